"""Pinocchio from the same scene: its C++ as users compile it, and C generated from it by CppADCodeGen and by CasADi.

The three read one text file of joints, so that their compiled programs serve every scene. Joints about a coordinate
axis get Pinocchio's model of that axis, as its own URDF reader gives them.
"""

from __future__ import annotations

import importlib.util
import re
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symgen.bench.peers.casadi_c import casadi_variant
from symgen.bench.text import template
from symgen.bench.variant import INPUTS, Array, Found, Left, Problem, State, Unit, Variant, split, upper_to_full
from symgen.bench.workshop import CompileError, Workshop
from symgen.errors import NotSupportedError
from symgen.validation.mechanism import Link
from symgen.validation.pinocchio_model import Pinocchio, build_pinocchio

DEFINES = (
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)
"""What Pinocchio's own CMake files define."""
Unpack = Callable[[Array, State], list[Array]]
SYMMETRIC = frozenset({"mass_matrix", "mass_matrix_inverse"})
OPERATORS = re.compile(r" [-+*/] |= -|sqrt\(")
"""Arithmetic in what CppADCodeGen writes."""
CPP, CODEGEN, CASADI = "pinocchio", "pinocchio-cppadcg", "pinocchio-casadi"


def site_of(package: str) -> Path | None:
    """The folder that a package was installed in, without importing it."""
    spec = importlib.util.find_spec(package)
    return Path(spec.origin).parent.parent if spec is not None and spec.origin else None


def include_folders() -> tuple[Path, ...]:
    """Headers of Pinocchio and of what it needs, as PyPI's packages bring them; empty where one is missing."""
    site = site_of("pinocchio")
    candidates = [Path(site).joinpath(*up, "cmeel.prefix", "include") for up in ((), ("..",) * 4) if site]
    found = next((p.resolve() for p in candidates if (p / "pinocchio" / "multibody.hpp").exists()), None)
    if found is None or not (found / "eigen3" / "Eigen" / "Core").exists() or not (found / "boost").exists():
        return ()
    return (found, found / "eigen3")


def has_cpp() -> bool:
    return bool(include_folders())


def has_codegen() -> bool:
    folders = include_folders()
    return bool(folders) and (folders[0] / "cppad" / "cg.hpp").exists()


def casadi_home() -> Path | None:
    """CasADi's wheel, where it brings headers and library."""
    site = site_of("casadi")
    home = site / "casadi" if site else None
    return home if home and (home / "include" / "casadi" / "casadi.hpp").exists() else None


def has_casadi() -> bool:
    return has_cpp() and casadi_home() is not None


@dataclass(frozen=True)
class Row:
    """One joint of the text file."""

    kind: str
    axis: Array


def joint_rows(link: Link) -> list[Row]:
    """The joints that make up a link's joint, as `symgen.validation.pinocchio_model` chains them."""

    def row(letter: str, axis: Array) -> Row:
        unit = next((name for name, e in zip("XYZ", np.eye(3), strict=True) if np.array_equal(e, axis)), "U")
        return Row(letter + unit, axis)

    x, y, z = np.eye(3)
    match link.joint.type:
        case "revolute" | "continuous":
            return [row("R", link.axis)]
        case "prismatic":
            return [row("P", link.axis)]
        case "helical":
            return [Row("HU", link.axis)]
        case "cylindrical":
            return [row("R", link.axis), row("P", link.axis)]
        case "universal":
            return [row("R", link.axis), row("R", link.axis2)]
        case "planar":
            return [row("P", x), row("P", y), row("R", z)]
        case "spherical":
            return [Row("S", z)]
        case "floating":
            return [Row("FF", z)]
    raise NotSupportedError(f"joint type {link.joint.type} has no Pinocchio model")


def model_text(adapter: Pinocchio) -> str:
    """The model file that the C++ reads. Places and inertias are those of the validation's model."""
    model = adapter.model
    lines = [f"{model.njoints - 1} {_words(model.gravity.linear)}"]
    number = 1
    for link in adapter.mechanism.links:
        for row in joint_rows(link):
            place, inertia = model.jointPlacements[number], model.inertias[number]
            start = model.joints[number].idx_v
            numbers = [
                link.pitch, model.armature[start], inertia.mass, *row.axis, *place.translation, *inertia.lever,
                *np.ravel(place.rotation), *np.ravel(inertia.inertia),
            ]  # fmt: skip
            lines.append(f"{row.kind} {model.parents[number]} {_words(numbers)}")
            number += 1
    return "\n".join(lines) + "\n"


def _words(numbers: Sequence[float]) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def prepared(problem: Problem) -> Pinocchio:
    """Raises NotSupportedError where the coordinates differ: then functions are not the same."""
    adapter = build_pinocchio(problem.scene)
    if not adapter.square:
        raise NotSupportedError("coupled joints are joints of their own in Pinocchio")
    if np.any(adapter.loose_armature):
        raise NotSupportedError("armature of a floating base is in other coordinates in Pinocchio")
    return adapter


def cpp(problem: Problem, workshop: Workshop) -> Found:
    """Pinocchio's algorithms, results left in its Data."""
    adapter = prepared(problem)
    path = problem.folder / "pinocchio.model"
    path.write_text(model_text(adapter))
    unit = Unit(
        "pinocchio", template("pinocchio.cpp"), "c++", (*DEFINES, *_system(include_folders())),
        headers=(("pinocchio_model.hpp", template("pinocchio_model.hpp")),), limited=False,
    )  # fmt: skip
    found = Found()
    for name in problem.wanted:
        sizes = problem.shapes(name)
        arguments = ", ".join(f"{{{key}}}" for key in INPUTS[name])
        declaration = (
            "int pinocchio_open(const char *);\nvoid pinocchio_fetch(const char *, double *);\n"
            f"void pinocchio_{name}({', '.join(['const double *'] * len(INPUTS[name]))});"
        )
        found.variants.append(
            Variant(
                CPP, name, declaration, f"pinocchio_{name}({arguments});",
                {key: problem.column(key) for key in INPUTS[name]}, sum(sizes),
                _split_into(sizes), (unit,), fetch=f'pinocchio_fetch("{name}", {{out}});',
                setup=f"if (pinocchio_open({_c_string(path)})) return 1;", sized=False,
            )
        )  # fmt: skip
    return found


def _c_string(path: Path) -> str:
    return '"' + str(path).replace("\\", "\\\\").replace('"', '\\"') + '"'


def _system(folders: Sequence[Path]) -> tuple[str, ...]:
    return tuple(word for folder in folders for word in ("-isystem", str(folder)))


def _split_into(sizes: Sequence[int]) -> Unpack:
    """Outputs that are in our order already."""
    return lambda flat, state: split(flat, sizes)


def _unpacking(problem: Problem, name: str) -> tuple[int, Unpack]:
    """How many numbers a generated function has, and how they become ours."""
    n = problem.nv
    if name in SYMMETRIC:
        return n * (n + 1) // 2, lambda flat, state: [upper_to_full(flat, n)]
    sizes = problem.shapes(name)
    return sum(sizes), _split_into(sizes)


def _sources(program: Path, model: Path, folder: Path, names: Sequence[str]) -> tuple[dict[str, float], list[Left]]:
    """Run a generator, function by function: seconds by name, and what it could not do."""
    folder.mkdir(parents=True, exist_ok=True)
    seconds, left = {}, []
    for name in names:
        ran = subprocess.run([str(program), str(model), str(folder), name], capture_output=True, text=True, check=False)
        if ran.returncode or not ran.stdout.split():
            why = (ran.stderr.strip().splitlines() or [f"ended with status {ran.returncode}"])[0][:200]
            left.append(Left("", name, why))
        else:
            seconds[name] = float(ran.stdout.split()[1])
    return seconds, left


def generator_headers() -> tuple[tuple[str, str], ...]:
    return tuple((name, template(name)) for name in ("pinocchio_model.hpp", "pinocchio_rows.hpp"))


def codegen(problem: Problem, workshop: Workshop) -> Found:
    """C by CppADCodeGen from tapes of Pinocchio's algorithms; inputs are one array."""
    unit = Unit(
        "cppadcodegen", template("cppadcodegen.cpp"), "c++", (*DEFINES, *_system(include_folders())),
        headers=generator_headers(), limited=False,
    )  # fmt: skip
    folder, model = problem.folder / CODEGEN, problem.folder / "pinocchio.model"
    model.write_text(model_text(prepared(problem)))
    program = workshop.program(unit, ("-O1",), ()).path
    seconds, left = _sources(program, model, folder, problem.wanted)
    found = Found(left=[Left(CODEGEN, row.function, row.why) for row in left])
    for name, taken in seconds.items():
        outputs, unpack = _unpacking(problem, name)
        x = np.hstack([problem.column(key) for key in INPUTS[name]])
        text = (folder / f"{name}.c").read_text()
        source = Unit(f"cppadcodegen_{name}", text)
        found.variants.append(
            Variant(
                CODEGEN, name, f"void cppadcodegen_{name}(const double *x, double *y);",
                f"cppadcodegen_{name}({{x}}, {{out}});", {"x": x}, outputs, unpack, (source,), generate_s=taken,
                operations=len(OPERATORS.findall(text)),
            )
        )  # fmt: skip
    return found


def casadi(problem: Problem, workshop: Workshop) -> Found:
    """C by CasADi's code generator, common subexpressions eliminated, from Pinocchio's algorithms over SX."""
    home = casadi_home()
    if home is None:
        raise CompileError("CasADi's headers are missing")
    unit = Unit(
        "casadi_pinocchio", template("casadi_pinocchio.cpp"), "c++",
        (*DEFINES, *_system((*include_folders(), home / "include"))), headers=generator_headers(), limited=False,
    )  # fmt: skip
    folder, model = problem.folder / CASADI, problem.folder / "pinocchio.model"
    model.write_text(model_text(prepared(problem)))
    program = workshop.program(unit, ("-O1",), (f"-L{home}", "-lcasadi", f"-Wl,-rpath,{home}")).path
    seconds, left = _sources(program, model, folder, problem.wanted)
    found = Found(left=[Left(CASADI, row.function, row.why) for row in left])
    for name, taken in seconds.items():
        outputs, unpack = _unpacking(problem, name)
        found.variants.append(
            casadi_variant(
                CASADI, name, f"pincasadi_{name}", (folder / f"pincasadi_{name}.c").read_text(),
                {key: problem.column(key) for key in INPUTS[name]}, [outputs], unpack, taken,
                int((folder / f"{name}.operations").read_text()),
            )
        )  # fmt: skip
    return found
