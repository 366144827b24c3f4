"""Random scenes all the way: generate, compile, load, and compare with the literal definition and with Pinocchio.

Every example is a tree with a floating base and other joint types, armature, damping, springs and run-time parameters;
together they hold every joint type, every velocity convention and both precisions.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction as F
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import symgen
from symgen.algebra.numbers import FloatNumbers, State
from symgen.catalogue import OF_CONSTRAINTS
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import Frame, JointSpring, Options, Output, Parameter, Scene, Spring, Transform
from symgen.scene.outputs import DEFAULT_OUTPUTS
from symgen.scene.parameters import available_parameters
from symgen.system import System, derive
from symgen.validation.functions import vary_parameters
from tests.natural.trees import random_planar_scene, random_scene, random_vector, rotation

Array = NDArray[Any]

Case = tuple[tuple[str, ...], str, str, int]
"""Joint types beside the base, base_velocity, precision, seed."""

BESIDE_A_BASE = (
    ("revolute", "spherical", "fixed"), ("universal", "prismatic"), ("planar", "helical"),
    ("cylindrical", "continuous"), ("spherical", "universal"), ("helical", "prismatic", "fixed"),
)  # fmt: skip
CONVENTIONS = ("world", "body", "mixed")
EXAMPLES = [(types, CONVENTIONS[k % 3], ("double", "float")[k // 3], 100 + k) for k, types in enumerate(BESIDE_A_BASE)]
IN_A_PLANE: Case = ((), "world", "double", 200)
TYPES = [name for row in BESIDE_A_BASE for name in row]
MORE = [
    (tuple(random.Random(seed).choices(TYPES, k=4)), CONVENTIONS[seed % 3], ("double", "float")[seed % 2], seed)
    for seed in range(24)
]
EPSILON = {"double": 2.0**-53, "float": 2.0**-24}
STATES = 4


def tree_of(types: tuple[str, ...], rng: random.Random) -> Scene:
    """A random tree with these joint types beside one floating base; a planar tree for none."""
    if not types:
        return random_planar_scene(rng, 4)
    wanted = sorted((*types, "floating"))
    while True:
        scene = random_scene(rng, len(wanted), tuple(dict.fromkeys(wanted)))
        bases = [joint for joint in scene.joints if joint.type == "floating"]
        if sorted(j.type for j in scene.joints) == wanted and all(joint.parent == "ground" for joint in bases):
            return scene


def scene_of(types: tuple[str, ...], convention: str, precision: str, seed: int) -> Scene:
    rng = random.Random(seed)
    scene = tree_of(types, rng)
    joints = tuple(
        joint
        if joint.type == "fixed"
        else replace(joint, armature=F(rng.randint(1, 3), 9), damping=F(rng.randint(0, 2), 5))
        for joint in scene.joints
    )
    names = [body.name for body in scene.bodies]
    springs: list[Spring | JointSpring] = [
        Spring((names[-1], "ground"), ((F(1), F(0), F(1, 3)), (F(0), F(2), F(5))), F(3), F(1, 2), F(1, 4), name="far"),
        Spring((names[0], names[-1]), ((F(1), F(2), F(0)), (F(0), F(1), F(-1))), F(2), F(1, 3), name="between"),
    ]
    springs += [
        JointSpring(joint.name, F(2), F(1, 4), F(1, 3), name=f"in_{joint.name}")
        for joint in joints
        if joint.type not in ("fixed", "spherical", "floating")
    ]
    frame = Frame("tool", names[-1], Transform(rotation(1, 2, -1, 1), random_vector(rng)))
    scene = replace(scene, name="random_tree", joints=joints, forces=tuple(springs), frames=(frame,))
    options = Options(convention, precision, rng.choice(("polynomial", "libm")), status=rng.random() < 0.5, batch=True)
    scene = replace(scene, parameters=parameters_of(scene, rng), options=options)
    refused = OF_CONSTRAINTS if scene.runtime_origins else frozenset()
    return replace(scene, outputs=tuple(output for output in outputs_of(names) if output.name not in refused))


def parameters_of(scene: Scene, rng: random.Random) -> tuple[Parameter, ...]:
    """About one in three of everything that may be one, always of a mass and of a spring."""
    found: list[Parameter] = []
    for name, (default, unit) in available_parameters(scene).items():
        if name == "far.length" or rng.randrange(3) == 0:
            found.append(Parameter(name, default, unit, sum(parameter.size for parameter in found)))
    return tuple(found)


def outputs_of(names: list[str]) -> tuple[Output, ...]:
    combined = Output("together", ("mass_matrix", "bias_force", f"frame_pose:{names[0]}", "frame_pose:tool"))
    return (*DEFAULT_OUTPUTS, Output("frame_pose:tool", ("frame_pose:tool",)), combined)


@dataclass(frozen=True)
class Example:
    """A compiled scene, and random states one per row; ``changed`` is the scene that the parameters ``p`` make."""

    system: System
    functions: Any
    folder: Path
    arguments: dict[str, Array]
    changed: Scene

    @property
    def tolerance(self) -> float:
        return 4096 * EPSILON[self.system.scene.options.precision]

    def row(self, k: int) -> dict[str, Any]:
        return {name: value if name in ("dt", "p") else value[k] for name, value in self.arguments.items()}

    def call(self, name: str, k: int) -> tuple[Array, ...]:
        return as_tuple(self.functions, name, self.row(k))

    def literal(self, name: str, k: int) -> list[Array]:
        given: dict[str, Any] = {n: x.astype(float).tolist() for n, x in self.row(k).items()}
        found = self.system.evaluate(name, FloatNumbers(), State(**given))
        return [np.array(value, dtype=float) for value in found.values()]


def as_tuple(functions: Any, name: str, arguments: dict[str, Any]) -> tuple[Array, ...]:
    function = getattr(functions, name)
    found = function(*(arguments[n] for n in function.inputs))
    return found if isinstance(found, tuple) else (found,)


def made(case: Case, folder: Path) -> Example:
    scene = scene_of(*case)
    artifact = symgen.generate(scene, folder / "out")
    rng = np.random.default_rng(case[-1])
    changed, p = vary_parameters(scene, rng)
    system = derive(scene)
    size = system.sizes
    arguments: dict[str, Any] = {
        "q": rng.normal(size=(STATES, size.nq)),
        "v": rng.normal(size=(STATES, size.nv)),
        "a": rng.normal(size=(STATES, size.nv)),
        "tau": rng.normal(size=(STATES, size.nv)),
        "dt": 0.0625,
        "p": p,
    }
    for body in system.tree.bodies:
        if body.nq > body.nv:
            part = arguments["q"][:, body.q + body.nq - 4 : body.q + body.nq]
            part /= np.linalg.norm(part, axis=1, keepdims=True)
    kind = np.float32 if scene.options.precision == "float" else np.float64
    arguments = {name: np.asarray(value, kind) for name, value in arguments.items()}
    loaded = artifact.load(flags=["-O1"], cache=folder / "cache")
    return Example(system, loaded, folder / "out", arguments, changed)


def close(found: Array, wanted: Array, tolerance: float, what: str) -> None:
    """Relative to the largest entry; to 1 where everything is small (Psi is zero)."""
    assert found.shape == wanted.shape, what
    scale = max(1.0, float(np.max(np.abs(wanted), initial=0.0)))
    assert float(np.max(np.abs(found - wanted), initial=0.0)) <= tolerance * scale, what


def solves(m: Array, a: Array, rest: Array, tolerance: float) -> None:
    """M a = τ − h to within the rounding of its terms, whatever the condition of M."""
    scale = np.abs(m) @ np.abs(a) + np.abs(rest)
    assert np.all(np.abs(m @ a - rest) <= tolerance * np.max(scale)), (m @ a - rest) / np.max(scale)


def check_literal(example: Example) -> None:
    for name in example.functions:
        row = "frame_pose:tool" if name == "frame_pose_tool" else name
        for k in range(STATES):
            found = example.call(name, k)
            if name == "forward_dynamics":
                (m,), (h,) = example.literal("mass_matrix", k), example.literal("bias_force", k)
                solves(m, found[0].astype(float), example.row(k)["tau"] - h, example.tolerance)
                continue
            for value, wanted in zip(found, example.literal(row, k), strict=True):
                close(value, wanted, example.tolerance, f"{name}, state {k}")


def check_batches(example: Example) -> None:
    for name in example.functions:
        inputs = getattr(example.functions, name).inputs
        if not {"q", "v", "a", "tau"}.intersection(inputs):
            continue
        together = as_tuple(example.functions, name, example.arguments)
        own = {**example.arguments, "p": np.tile(example.arguments["p"], (STATES, 1))}
        for port, values in enumerate(together):
            single = np.stack([example.call(name, k)[port] for k in range(STATES)])
            close(values, single, example.tolerance, f"{name}, batch")
            close(as_tuple(example.functions, name, own)[port], single, example.tolerance, f"{name}, p of each state")


def check_casadi(example: Example) -> None:
    casadi = pytest.importorskip("casadi")
    scene = example.system.scene
    for name in ("mass_matrix", "forward_dynamics", "integrate", "together"):
        function = casadi.Function.load(str(example.folder / f"{scene.name}.casadi" / f"{name}.casadi"))
        given = {n: np.asarray(x, float) for n, x in example.row(0).items()}
        found = function(*(given[function.name_in(i)] for i in range(function.n_in())))
        for value, wanted in zip(found if isinstance(found, tuple) else (found,), example.call(name, 0), strict=True):
            tolerance = example.tolerance * (1e4 if name == "forward_dynamics" else 1)  # as badly conditioned as M
            close(np.array(value).reshape(wanted.shape), wanted.astype(float), tolerance, f"{name}, CasADi")


def check_pinocchio(example: Example) -> None:
    from symgen.validation.pinocchio_model import build_pinocchio

    peer = build_pinocchio(example.changed)
    rows: dict[str, Callable[[Array, Array, Array], Array]] = {
        "mass_matrix": lambda q, v, a: peer.mass_matrix(q),
        "bias_force": lambda q, v, a: peer.bias_force(q, v),
        "inverse_dynamics": peer.inverse_dynamics,
        "passive_force": lambda q, v, a: peer.passive_force(q, v),
        "frame_pose_tool": lambda q, v, a: pose_of(peer, q),
    }
    for k in range(STATES):
        q, v, a, tau = (example.row(k)[name].astype(float) for name in ("q", "v", "a", "tau"))
        for name, of_peer in rows.items():
            close(example.call(name, k)[0], of_peer(q, v, a), example.tolerance, f"{name}, Pinocchio, state {k}")
        found = example.call("forward_dynamics", k)[0].astype(float)
        solves(peer.mass_matrix(q), found, tau - peer.bias_force(q, v), example.tolerance)


def pose_of(peer: Any, q: Array) -> Array:
    """The frame's pose from its body's, by Pinocchio."""
    (frame,) = peer.mechanism.scene.frames
    body = peer.body_pose(q, frame.body)
    local = np.eye(4)
    local[:3, :3] = [[float(x) for x in row] for row in frame.origin.rotation]
    local[:3, 3] = [float(x) for x in frame.origin.translation]
    outer = np.eye(4)
    outer[:3, :3], outer[:3, 3] = body.rotation, body.position
    return np.asarray(outer @ local)


def all_checks(case: Case, folder: Path) -> None:
    example = made(case, folder)
    check_literal(example)
    check_batches(example)
    check_casadi(example)
    try:
        import pinocchio  # noqa: F401
    except ImportError:
        return
    check_pinocchio(example)


def label(case: Case) -> str:
    return f"{case[1]}-{case[2]}-{case[3]}"


def test_every_joint_type_has_an_example() -> None:
    assert {"floating", *TYPES} == set(JOINT_TYPES)


@pytest.mark.parametrize("case", [*EXAMPLES, IN_A_PLANE], ids=label)
def test_random_scenes(case: Case, tmp_path: Path) -> None:
    all_checks(case, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("case", MORE, ids=label)
def test_more_random_scenes(case: Case, tmp_path: Path) -> None:
    all_checks(case, tmp_path)


def test_the_comparison_can_fail(tmp_path: Path) -> None:
    """Another parameter value than the one compared with is seen."""
    example = made(EXAMPLES[1], tmp_path)
    names = [parameter.name for parameter in example.system.scene.parameters]
    start = example.system.scene.parameters[names.index("far.length")].start
    example.arguments["p"][start] *= 1 + 1e-6
    with pytest.raises(AssertionError):
        check_pinocchio(example)
