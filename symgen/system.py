"""A derived system: the tree, its natural coordinates, and every catalogue function of it, in every form."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from symgen.algebra.numbers import Numbers, State
from symgen.catalogue import OF_CONSTRAINTS, Sizes, output_ports, row_of, sizes, split_row
from symgen.errors import NotSupportedError, SceneError
from symgen.integrators.plan import compose, is_step, needed_rows
from symgen.literal.base_parameters import BaseParameters, base_parameters
from symgen.literal.equations import Literal
from symgen.loops.choose import Code, code_of
from symgen.loops.model import LoopProgram, loop_counts
from symgen.natural.coordinates import choose_coordinates
from symgen.natural.layout import NaturalCoordinates
from symgen.plans.choose import Choice, PlanChoice, choose
from symgen.plans.families import innermost
from symgen.plans.walk import Lowered, lowered
from symgen.program.composed import ComposedProgram, composed_counts
from symgen.program.instructions import Program, count
from symgen.program.memory import uncollected
from symgen.scene.load import load
from symgen.scene.model import Output, Scene
from symgen.scene.outputs import DEFAULT_OUTPUTS, check_row
from symgen.topology.graph import cycles
from symgen.topology.tree import Tree, build_tree
from symgen.velocity.values import Values

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True, repr=False)
class System:
    """What `derive` makes of a scene. Functions are derived when asked for, and kept."""

    scene: Scene
    tree: Tree
    natural: NaturalCoordinates
    _chosen: dict[tuple[Output, bool], Choice] = field(default_factory=dict, repr=False, compare=False)
    _codes: dict[Output, Code] = field(default_factory=dict, repr=False, compare=False)

    def __repr__(self) -> str:
        sizes = f"nq = {self.tree.nq}, nv = {self.tree.nv}, nn = {self.natural.nn}, nc = {self.natural.nc}"
        return f"<System {self.scene.name}: {len(self.tree.bodies)} moving bodies, {sizes}>"

    @property
    def path_matrix(self) -> NDArray[np.int64]:
        """π (bodies × edges), paper §2."""
        return self.tree.path_matrix

    @property
    def secondary_path_matrix(self) -> NDArray[np.int64]:
        """π* (bodies × edges), paper §2."""
        return self.tree.secondary_path_matrix

    @cached_property
    def lowered(self) -> Lowered:
        """The elementary links of the tree, for the plans in body axes."""
        return lowered(self.scene, self.tree)

    @property
    def sizes(self) -> Sizes:
        return sizes(self.scene, self.tree, self.natural)

    @property
    def base_parameters(self) -> BaseParameters:
        """The inertial parameters that inverse dynamics can feel: ``names`` of all (ten per moving body), and the exact
        ``matrix`` K of the base parameters beta = K pi (see `symgen.literal.base_parameters`)."""
        self.require_tree()
        return base_parameters(self.scene, self.tree, self.natural)

    @property
    def outputs(self) -> tuple[Output, ...]:
        """The functions the scene asks for; the catalogue's default set where it asks for none (without constraints
        where origins of joints are run-time arguments: those have none); and what steps call."""
        if self.scene.outputs or not self.scene.runtime_origins:
            wanted = self.scene.outputs or DEFAULT_OUTPUTS
            return (*wanted, *needed_rows(wanted))
        return tuple(output for output in DEFAULT_OUTPUTS if output.name not in OF_CONSTRAINTS)

    def output(self, name: str) -> Output:
        """The function of that name among `outputs`, or the catalogue row of that name.

        Raises SceneError for what the catalogue does not have.
        """
        for output in self.outputs:
            if output.name == name:
                return output
        check_row(name, tuple(self.tree.frames), self.scene.source or self.scene.name)
        return Output(name, (name,))

    @uncollected()
    def _choose(self, name: str, every: bool) -> Choice:
        self.require_tree()
        key = (self.output(name), every)
        self.require(key[0])
        if not every and (key[0], True) in self._chosen:  # what more was counted changes no choice
            return self._chosen[key[0], True]
        if key not in self._chosen:
            self._chosen[key] = choose(self.lowered, self.natural, key[0], every)
        return self._chosen[key]

    def require_tree(self) -> None:
        """Raises NotSupportedError when the scene has closed loops."""
        if self.tree.cut_joints:
            cut = ", ".join(f"'{joint.name}'" for joint in self.tree.cut_joints)
            loops = "; ".join("–".join(loop) for loop in cycles(self.scene))
            raise NotSupportedError(
                f"{self.scene.source or self.scene.name}: closed loops are not there yet: "
                f"{loops} closes a loop (cut at {cut}); `symgen show` prints its graph"
            )

    def require(self, output: Output) -> None:
        """Raises SymgenError for a function that this scene cannot have."""
        self._require_constraints(output)
        self._require_parameters(output)

    def _require_parameters(self, output: Output) -> None:
        """Raises SceneError for derivatives by parameters that the scene does not have."""
        row = next((row for row in output.of if row.startswith("parameter_jacobian:")), None)
        if row is not None and not self.scene.parameters:
            raise SceneError(f"{row}: the scene has no run-time parameters", self.scene.source or self.scene.name)

    def _require_constraints(self, output: Output) -> None:
        """Raises NotSupportedError for constraints of a scene whose geometry is given at run time."""
        row = next((row for row in output.of if innermost(row) in OF_CONSTRAINTS), None)
        if row is not None and self.scene.runtime_origins:
            raise NotSupportedError(
                f"{self.scene.source or self.scene.name}: {row} needs constant joint origins, and these are run-time "
                f"parameters: {', '.join(sorted(self.scene.runtime_origins))}"
            )

    def code(self, name: str) -> Code:
        """What a function is emitted as: straight-line code or loops."""
        self.require_tree()
        output = self.output(name)
        self.require(output)
        if is_step(output) and output not in self._codes:
            self._codes[output] = self._step_code(output)
        if output not in self._codes:
            self._codes[output] = code_of(self.lowered, self.natural, output, lambda: self.program(name))
        return self._codes[output]

    def _step_code(self, output: Output) -> Code:
        program = compose(self.lowered, self.sizes, output, lambda row: self.code(row).program)
        why = f"calls {', '.join(program.callees)}"
        whole = all(self.code(row).straight is not None for row in program.callees)
        left_out = [name for name in self.scene.options.targets if name == "cuda" or (name == "casadi" and not whole)]
        note = f"{program.name} is left out of {' and '.join(left_out)}: it calls others" if left_out else ""
        return Code(program, None, why, note)

    def program(self, name: str) -> Program:
        """The exact straight-line program of a function, by its cheapest plan. Raises NotSupportedError for steps,
        which are calls of others (`code`)."""
        if is_step(self.output(name)):
            raise NotSupportedError(f"{name} has no straight-line program: it calls other functions")
        return self._choose(name, False).program

    def others(self, name: str) -> tuple[Program, ...]:
        """Programs of a function by another derivation, where one was weighed."""
        return self._choose(name, False).others

    def plans(self, name: str, every: bool = True) -> tuple[PlanChoice, ...]:
        """What was weighed for a function: plans, counts, which was taken, and why. Of a function in loops, nothing
        else is counted."""
        code = self.code(name)
        if isinstance(code.program, ComposedProgram):
            callees = code.program.callees.items()
            own = {row: loop_counts(x) if isinstance(x, LoopProgram) else count(x) for row, x in callees}
            return (PlanChoice(code.program.plan, composed_counts(code.program, own), True, code.why),)
        if isinstance(code.program, LoopProgram):
            return (PlanChoice(code.program.plan, loop_counts(code.program), True, code.why),)
        return self._choose(name, every).weighed

    def literal(self, numbers: Numbers, state: State) -> Literal:
        """The literal definition of every row at a state, in any number type."""
        return Literal(self.tree, self.natural, Values(self.scene, numbers, state.p), state)

    def evaluate(self, name: str, numbers: Numbers, state: State) -> dict[str, Any]:
        """A row's (or a combined function's) outputs by the literal definition: {output name: nested tuples}.

        forward_dynamics has no literal expression: it solves M a = τ − bias with the literal M and bias. Raises
        SceneError where M is singular.
        """
        self.require_tree()
        output = self.output(name)
        literal = self.literal(numbers, state)
        values: list[Any] = []
        for row in output.of:
            row_name, frame = split_row(row)
            definition = row_of(row).literal
            if definition is None and row_name != "forward_dynamics":
                raise NotSupportedError(f"{row} has no literal expression; it is defined by an equation")
            values.extend(definition(literal, frame) if definition else (_solve(literal),))
        return {port.name: value for port, value in zip(output_ports(output.of, self.sizes), values, strict=True)}

    def sympy(self, name: str) -> Any:
        """A row as readable SymPy: a Matrix, or an expression where the output is a scalar."""
        from symgen.targets.sympy import sympy_matrix

        self.require_tree()
        return sympy_matrix(self, name)

    def casadi(self, name: str) -> casadi.Function:
        """A function as a casadi.Function with named inputs and outputs."""
        from symgen.targets.casadi import casadi_function

        if is_step(self.output(name)):
            from symgen.integrators.casadi import casadi_step

            code = self.code(name).program
            assert isinstance(code, ComposedProgram)
            return casadi_step(code, {row: self.program(row) for row in code.callees})
        return casadi_function(self.program(name))


def _solve(literal: Literal) -> tuple[Any, ...]:
    """M⁻¹(τ − h) by elimination without pivoting (M is positive definite)."""
    scene, const = literal.values.scene, literal.values.numbers.const
    m = [[const(x) if isinstance(x, int) else x for x in row] for row in literal.mass_matrix()]
    b = [x - y for x, y in zip(literal.state.tau, literal.bias_force(), strict=True)]
    n = len(b)
    for k in range(n):
        if _known_zero(m[k][k]):
            raise SceneError(
                f"the mass matrix is singular: no inertia moves with velocity {k}", scene.source or scene.name
            )
        for i in range(k + 1, n):
            ratio = m[i][k] / m[k][k]
            m[i] = [x - ratio * y for x, y in zip(m[i], m[k], strict=True)]
            b[i] = b[i] - ratio * b[k]
    x: list[Any] = [0] * n
    for k in reversed(range(n)):
        rest = b[k]
        for j in range(k + 1, n):
            rest = rest - m[k][j] * x[j]
        x[k] = rest / m[k][k]
    return tuple(x)


def _known_zero(x: Any) -> bool:
    """x == 0 where the number type can tell (CasADi expressions can not, and refuse to be asked)."""
    try:
        return bool(x == 0)
    except RuntimeError:
        return False


def derive(scene: Scene | str | Path) -> System:
    """Order the tree and choose natural coordinates of a scene or its file. Functions follow when asked for."""
    scene = load(scene) if isinstance(scene, str | Path) else scene
    tree = build_tree(scene)
    return System(scene, tree, choose_coordinates(tree, loose=scene.runtime_origins))
