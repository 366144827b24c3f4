"""The peers that the bench knows: how each is built, and what installs it."""

from __future__ import annotations

import contextlib
import importlib.metadata
import importlib.util
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from symgen.bench.peers import adam, casadi_c, mujoco, pinocchio
from symgen.bench.variant import KANE, PRINTED, Found, Left, Problem
from symgen.bench.workshop import CompileError, Workshop
from symgen.errors import NotSupportedError, SceneError, ToolError

INSTALL = "make peers, or pip install 'symgen[bench]'"


@dataclass(frozen=True)
class Peer:
    name: str
    what: str
    """One line for the report."""
    installed: Callable[[], bool]
    build: Callable[[Problem, Workshop], Found]
    package: str = ""
    """What is installed of it, whose version is told."""
    physics: bool = True
    """False for a peer that is given our own expressions: it has what the scene has."""


def _module(*names: str) -> Callable[[], bool]:
    return lambda: all(importlib.util.find_spec(name) is not None for name in names)


def _kane(problem: Problem, workshop: Workshop) -> Found:
    from symgen.bench.peers import kane  # with it SymPy's mechanics, which take a while

    return kane.build(problem, workshop)


PEERS: tuple[Peer, ...] = (
    Peer(PRINTED, "our expressions as C by CasADi", _module("casadi"), casadi_c.own, "casadi", physics=False),
    Peer(pinocchio.CPP, "Pinocchio's C++, results left in its Data", pinocchio.has_cpp, pinocchio.cpp, "pin"),
    Peer(
        pinocchio.CODEGEN, "C by CppADCodeGen from Pinocchio; symmetric matrices by their upper triangle",
        pinocchio.has_codegen, pinocchio.codegen, "cmeel-cppadcodegen",
    ),
    Peer(
        pinocchio.CASADI, "C by CasADi from Pinocchio, cse; symmetric matrices by their upper triangle",
        pinocchio.has_casadi, pinocchio.casadi, "casadi",
    ),
    Peer(
        mujoco.NAME, "MuJoCo's C interface, the library as its wheel brings it", mujoco.has_mujoco, mujoco.build,
        "mujoco",
    ),
    Peer(
        adam.NAME, "C by CasADi from adam's algorithms, cse", _module("adam", "liecasadi"), adam.build,
        "adam-robotics",
    ),
    Peer(KANE, "SymPy's KanesMethod, cse, as C; small scenes only", _module("sympy"), _kane, "sympy"),
)  # fmt: skip


def chosen(names: Sequence[str] | None) -> tuple[list[Peer], list[Left]]:
    """The peers of these names (None: all), those that are installed and what is missing.

    Raises SceneError for a name that is no peer.
    """
    known = [peer.name for peer in PEERS]
    for name in names or ():
        if name not in known:
            raise SceneError(f"no peer {name!r}; there are: {', '.join(known)}", "--peers")
    wanted = [peer for peer in PEERS if names is None or peer.name in names]
    missing = [Left(peer.name, "", f"not installed: {INSTALL}") for peer in wanted if not peer.installed()]
    return [peer for peer in wanted if peer.installed()], missing


def versions(names: Collection[str]) -> dict[str, str]:
    """The version of what each of these peers is made with, as it is installed."""
    found = {}
    for peer in PEERS:
        if peer.name in names and peer.package:
            with contextlib.suppress(importlib.metadata.PackageNotFoundError):
                found[peer.name] = f"{peer.package} {importlib.metadata.version(peer.package)}"
    return found


def build(peer: Peer, problem: Problem, workshop: Workshop) -> Found:
    """A peer's variants; what it cannot do is said, never an error."""
    try:
        return peer.build(problem, workshop)
    except (CompileError, NotSupportedError, ToolError, SceneError) as error:
        return Found(left=[Left(peer.name, "", str(error))])
    except Exception as error:
        return Found(left=[Left(peer.name, "", f"{type(error).__name__}: {str(error).splitlines()[0][:200]}")])
