"""The literal definition of every catalogue row (theory, §2–§4), over any number type.

Nothing here is clever: R from the joint table, M from natural coordinates, and the products the paper writes.
Every emitted function is certified against this module.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from symgen.algebra.linear import (
    Mat,
    Vec,
    add,
    dot,
    half,
    is_zero,
    known_value,
    matvec,
    mul,
    scale,
    sub,
    total,
    vadd,
    vneg,
    vsub,
)
from symgen.algebra.numbers import State
from symgen.errors import SceneError
from symgen.literal import walks
from symgen.natural import constraints, coordinates, mass
from symgen.natural.entities import Entity
from symgen.natural.layout import NaturalCoordinates, constants
from symgen.scene.model import JointSpring, Spring
from symgen.topology.tree import Tree
from symgen.velocity import kinematics as motion
from symgen.velocity.values import Values

Scalar = Any
Columns = dict[int, Vec]
"""Non-zero columns of some rows: {velocity index: entries}."""


@dataclass(frozen=True)
class Literal:
    """All literal quantities of one system at one state. Each is computed when asked for, once."""

    tree: Tree
    natural: NaturalCoordinates
    values: Values
    state: State
    pseudo_inertias: dict[int, Mat] = field(default_factory=dict, repr=False, compare=False)
    """P of the bodies that were asked for, see `symgen.literal.frames.pseudo`."""

    # --- kinematics -------------------------------------------------------------------------------------------

    @cached_property
    def at(self) -> motion.Kinematics:
        return motion.kinematics(self.tree, self.values, self.state.q)

    @cached_property
    def twists(self) -> tuple[motion.Twist, ...]:
        return motion.twists(self.at, self.state.v)

    @cached_property
    def rates(self) -> motion.Rates:
        return motion.column_rates(self.at, self.twists)

    @cached_property
    def moving(self) -> tuple[Entity, ...]:
        return tuple(self.natural.entities[k] for k in self.natural.moving)

    def components(self, x: Vec) -> Vec:
        """Ground-axes vector → the rows an entity occupies (its in-plane components in planar scenes)."""
        if self.natural.plane is None:
            return x
        return tuple(dot(self.values.vector(axis), x) for axis in self.natural.plane[:2])

    def place(self, entity: Entity) -> Vec:
        """Position of a point or direction of a vector in ground axes."""
        pose, local = self.at.pose(entity.home), constants(entity.local[entity.home], self.values.numbers)
        return pose.point(local) if entity.kind == "point" else pose.vector(local)

    def _columns(self, entity: Entity) -> Columns:
        body = self.tree.bodies[entity.home]
        if entity.kind == "angle":
            return {body.v: (self.values.multiplier(body),)}
        find = motion.point_columns if entity.kind == "point" else motion.vector_columns
        found = find(self.at, entity.home, self.place(entity))
        return {j: self.components(column) for j, column in found.items()}

    def _column_rates(self, entity: Entity) -> Columns:
        if entity.kind == "angle":
            return {}
        find = motion.point_column_rates if entity.kind == "point" else motion.vector_column_rates
        found = find(self.at, self.twists, self.rates, entity.home, self.place(entity))
        return {j: self.components(column) for j, column in found.items()}

    @cached_property
    def r_columns(self) -> tuple[Columns, ...]:
        """R, one block of rows per moving entity: the negative entries of π* replaced by the joint table's blocks."""
        return tuple(self._columns(entity) for entity in self.moving)

    @cached_property
    def r_rate_columns(self) -> tuple[Columns, ...]:
        """Ṙ likewise."""
        return tuple(self._column_rates(entity) for entity in self.moving)

    def _dense(self, blocks: Sequence[Columns]) -> Mat:
        rows: list[Vec] = []
        for entity, block in zip(self.moving, blocks, strict=True):
            for k in range(entity.size):
                rows.append(tuple(block[j][k] if j in block else 0 for j in range(self.tree.nv)))
        return tuple(rows)

    # --- products with R and M, one vector at a time ------------------------------------------------------------

    def apply(self, blocks: Sequence[Columns], x: Sequence[Scalar]) -> list[Vec]:
        """R x (or Ṙ x), per moving entity."""
        found = []
        for entity, block in zip(self.moving, blocks, strict=True):
            value: Vec = (0,) * entity.size
            for j, column in block.items():
                value = vadd(value, scale(x[j], column))
            found.append(value)
        return found

    def velocities(self, x: Sequence[Scalar]) -> list[Vec]:
        """R x, per moving entity; in large trees by a walk that does not form R."""
        if self.walked:
            return walks.velocities(self.at, self.natural, self.values, self.places, x)
        return self.apply(self.r_columns, x)

    @property
    def walked(self) -> bool:
        return len(self.tree.bodies) > walks.LARGE

    @cached_property
    def places(self) -> list[tuple[Entity, Vec]]:
        """Moving entities and where they are, ground axes."""
        return [(entity, () if entity.kind == "angle" else self.place(entity)) for entity in self.moving]

    def apply_transposed(self, y: Sequence[Vec]) -> list[Scalar]:
        """Rᵀ y; likewise."""
        if self.walked:
            return walks.forces(self.at, self.natural, self.values, self.places, y)
        found: list[Scalar] = [0] * self.tree.nv
        for block, value in zip(self.r_columns, y, strict=True):
            for j, column in block.items():
                found[j] = add(found[j], dot(column, value))
        return found

    @cached_property
    def entity_mass(self) -> dict[tuple[int, int], Any]:
        return mass.entity_mass(self.natural, self.tree, self.values)

    @cached_property
    def _mass_rows(self) -> dict[int, list[tuple[int, Any]]]:
        rows: dict[int, list[tuple[int, Any]]] = {}
        for (i, k), block in self.entity_mass.items():
            rows.setdefault(i, []).append((k, block))
        return rows

    def mass_times_field(self, values: dict[int, Vec]) -> list[Vec]:
        """M y, where y holds a value for some entities (ground-fixed ones may be among them)."""
        found = []
        for index, entity in zip(self.natural.moving, self.moving, strict=True):
            result: Vec = (0,) * entity.size
            for k, block in self._mass_rows.get(index, ()):
                if k in values:
                    part = matvec(block, values[k]) if isinstance(block, tuple) else scale(block, values[k])
                    result = vadd(result, part)
            found.append(result)
        return found

    def mass_times(self, y: Sequence[Vec]) -> list[Vec]:
        return self.mass_times_field(dict(zip(self.natural.moving, y, strict=True)))

    def mass_matrix_times(self, x: Sequence[Scalar]) -> list[Scalar]:
        """(RᵀMR) x as Rᵀ(M(R x)), with the armature."""
        product = self.apply_transposed(self.mass_times(self.velocities(x)))
        return [add(value, mul(extra, xi)) for value, extra, xi in zip(product, self.armature, x, strict=True)]

    def coriolis_times(self, x: Sequence[Scalar]) -> list[Scalar]:
        """(RᵀMṘ) x."""
        return self.apply_transposed(self.mass_times(self.apply(self.r_rate_columns, x)))

    @cached_property
    def armature(self) -> tuple[Scalar, ...]:
        found: list[Scalar] = [0] * self.tree.nv
        for body in self.tree.bodies:
            once = self.values.multiplier(body)
            extra = mul(mul(once, once), self.values.armature(body.joint))
            for i in range(body.v, body.v + body.nv):
                found[i] = add(found[i], extra)
        return tuple(found)

    # --- the catalogue --------------------------------------------------------------------------------------------

    def natural_coordinates(self) -> Vec:
        return coordinates.natural_coordinates(self.natural, self.tree, self.at.poses, self.state, self.values.numbers)

    def natural_mass_matrix(self) -> Mat:
        return mass.natural_mass_matrix(self.natural, self.tree, self.values)

    def constraints(self) -> Vec:
        return constraints.evaluate_constraints(self.natural, self.natural_coordinates(), self.values.numbers)

    def constraint_jacobian(self) -> Mat:
        return constraints.constraint_jacobian(self.natural, self.natural_coordinates(), self.values.numbers)

    def velocity_transformation(self) -> Mat:
        return self._dense(self.r_columns)

    def velocity_transformation_rate(self) -> Mat:
        return self._dense(self.r_rate_columns)

    @cached_property
    def _bias(self) -> list[Vec]:
        """Ṙθ̇ per moving entity, by the outward pass that does not form Ṙ."""
        at, twists = self.at, self.twists
        bias = motion.bias_accelerations(at, twists, self.state.v)
        found: list[Vec] = []
        for entity in self.moving:
            if entity.kind == "angle":
                found.append((0,))
                continue
            place = self.place(entity)
            if entity.kind == "point":
                full = motion.point_bias(at, twists, bias, entity.home, place)
            else:
                full = motion.vector_bias(twists, bias, entity.home, place)
            found.append(self.components(full))
        return found

    def natural_bias_acceleration(self) -> Vec:
        return tuple(entry for block in self._bias for entry in block)

    def mass_matrix(self) -> Mat:
        return self._by_columns(self.mass_matrix_times)

    def coriolis_matrix(self) -> Mat:
        return self._by_columns(self.coriolis_times)

    def _by_columns(self, times: Any) -> Mat:
        nv = self.tree.nv
        columns = [times([1 if i == j else 0 for i in range(nv)]) for j in range(nv)]
        return tuple(tuple(columns[j][i] for j in range(nv)) for i in range(nv))

    def coriolis_force(self) -> Vec:
        """RᵀMṘθ̇, from Ṙθ̇ as one vector."""
        return tuple(self.apply_transposed(self.mass_times(self._bias)))

    def gravity_force(self) -> Vec:
        """−RᵀQ with Q_b = M_b γ: γ = g at every point, ground-fixed ones included, 0 at every vector."""
        g = self.components(self.values.gravity())
        field = {k: g for k, entity in enumerate(self.natural.entities) if entity.kind == "point"}
        return vneg(tuple(self.apply_transposed(self.mass_times_field(field))))

    def passive_force(self) -> Vec:
        nv = self.tree.nv
        found: list[Scalar] = [0] * nv
        for body in self.tree.bodies:
            once = self.values.multiplier(body)
            damping = mul(mul(once, once), self.values.damping(body.joint))
            for i in range(body.v, body.v + body.nv):
                found[i] = add(found[i], mul(damping, self.state.v[i]))
        for force in self.values.scene.forces:
            part = self._spring_force(force) if isinstance(force, Spring) else self._joint_spring_force(force)
            for j, value in part.items():
                found[j] = add(found[j], value)
        return tuple(found)

    def bias_force(self) -> Vec:
        return self._bias_force

    @cached_property
    def _bias_force(self) -> Vec:
        return vadd(vadd(self.coriolis_force(), self.gravity_force()), self.passive_force())

    def inverse_dynamics(self) -> Vec:
        return vadd(tuple(self.mass_matrix_times(self.state.a)), self.bias_force())

    def kinetic_energy(self) -> Scalar:
        velocity = self.velocities(self.state.v)
        twice = total(dot(x, y) for x, y in zip(velocity, self.mass_times(velocity), strict=True))
        motors = total(mul(extra, mul(x, x)) for extra, x in zip(self.armature, self.state.v, strict=True))
        return half(add(twice, motors))

    def potential_energy(self) -> Scalar:
        g, energy = self.values.gravity(), 0
        for body in self.tree.bodies:
            p = mass.pseudo_inertia(body.parts, self.values, body.welds)
            pose = self.at.poses[body.index]
            moment = vadd(scale(p[0][0], pose.origin), pose.vector(tuple(p[0][1:])))
            energy = sub(energy, dot(g, moment))
        return add(energy, self.spring_energy())

    def spring_energy(self) -> Scalar:
        """The springs' part of the potential energy."""
        return total(self._spring_energy(force) for force in self.values.scene.forces)

    def frame_pose(self, frame: str) -> Mat:
        home, rotation, translation = self.values.frame(self.tree, frame)
        pose = self.at.pose(home)
        axes = tuple(matvec(pose.rotation, column) for column in zip(*rotation, strict=True))
        origin = pose.point(translation)
        rows = [(*(axis[i] for axis in axes), origin[i]) for i in range(3)]
        return (*rows, (0, 0, 0, 1))

    def integrate(self) -> Vec:
        return motion.integrate(self.tree, self.values, self.state)

    # --- springs ----------------------------------------------------------------------------------------------------

    def _ends(self, spring: Spring) -> tuple[tuple[int, Vec], tuple[int, Vec]]:
        """(tree body, point in ground axes) of both ends."""
        found = []
        for end, name in enumerate(spring.between):
            home, rotation, translation = self.values.frame(self.tree, name)
            inside = vadd(matvec(rotation, self.values.point(spring, end)), translation)
            found.append((home, self.at.pose(home).point(inside)))
        return found[0], found[1]

    def spring_pull(self, spring: Spring) -> tuple[tuple[int, Vec], tuple[int, Vec], Vec] | None:
        """(tree body, point) of both ends and the force on the first, ground axes; None inside one rigid body.

        The pull per unit of d is k(1 − L/ℓ) + c ḋ·d/ℓ², so that neither a root nor a division is needed without length
        and damping."""
        (first, a), (second, b) = self._ends(spring)
        if first == second:
            return None
        d = vsub(b, a)
        square = dot(d, d)
        length, damping = self.values.force(spring, "length"), self.values.force(spring, "damping")
        pull = self.values.force(spring, "stiffness")
        if not is_zero(length) and not is_zero(pull):
            pull = sub(pull, mul(pull, length) / self._distance(spring, square))
        if not is_zero(damping):
            self._require_direction(spring, square)
            d_rate = vsub(
                motion.point_velocity(self.at, self.twists, second, b),
                motion.point_velocity(self.at, self.twists, first, a),
            )
            pull = add(pull, mul(damping, dot(d, d_rate)) / square)
        return (first, a), (second, b), scale(pull, d)

    def _spring_force(self, spring: Spring) -> Columns:
        """Left-hand side of a spring: −Jᵀ of its pull."""
        pulled = self.spring_pull(spring)
        if pulled is None:
            return {}
        (first, a), (second, b), force = pulled
        found: Columns = {}
        for sign, body, point in ((-1, first, a), (1, second, b)):
            for j, column in motion.point_columns(self.at, body, point).items() if body >= 0 else ():
                value = dot(column, force)
                found[j] = add(found.get(j, 0), value if sign > 0 else sub(0, value))
        return found

    def _distance(self, spring: Spring, square: Scalar) -> Scalar:
        """The root of the squared distance of a spring's ends."""
        self._require_direction(spring, square)
        known, numbers = known_value(square), self.values.numbers
        return numbers.sqrt(square if known is None else numbers.const(known))

    def _require_direction(self, spring: Spring, square: Scalar) -> None:
        """Raises SceneError where a spring's length is known to be zero in every configuration."""
        if known_value(square) == 0:
            scene = self.values.scene
            label = f"spring '{spring.name}'" if spring.name else f"spring between {' and '.join(spring.between)}"
            raise SceneError(
                f"the {label} has both ends at one place in every configuration, so that it has no direction",
                scene.source or scene.name,
            )

    def _spring_joint(self, spring: JointSpring) -> Any:
        return next(body for body in self.tree.bodies if body.joint.name == spring.joint)

    def _joint_spring_force(self, spring: JointSpring) -> Columns:
        body, found = self._spring_joint(spring), {}
        stiffness, damping = self.values.force(spring, "stiffness"), self.values.force(spring, "damping")
        rest = self.values.force(spring, "rest")
        once, rates = self.values.multiplier(body), self.values.rates(body, self.state.v)
        for k, (position, rate) in enumerate(zip(self.values.positions(body, self.state.q), rates, strict=True)):
            force = mul(stiffness, sub(position, rest))
            if not is_zero(damping):
                force = add(force, mul(damping, rate))
            found[body.v + k] = mul(once, force)
        return found

    def _spring_energy(self, force: Spring | JointSpring) -> Scalar:
        stiffness = self.values.force(force, "stiffness")
        if is_zero(stiffness):
            return 0
        if isinstance(force, JointSpring):
            body, rest = self._spring_joint(force), self.values.force(force, "rest")
            stretches = [sub(position, rest) for position in self.values.positions(body, self.state.q)]
            return half(mul(stiffness, total(mul(x, x) for x in stretches)))
        (first, a), (second, b) = self._ends(force)
        if first == second:
            return 0  # a constant
        d = vsub(b, a)
        square, length = dot(d, d), self.values.force(force, "length")
        if is_zero(length):
            return half(mul(stiffness, square))
        stretch = sub(self._distance(force, square), length)
        return half(mul(stiffness, mul(stretch, stretch)))
