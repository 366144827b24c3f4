"""Ψ(x) = 0: rigid bodies, ties of entities beyond the carriers, and what joints ask beyond sharing (paper (3.1)).

Rows of a body are written for what it adds to its parent: its carriers include everything it shares with the parent,
and a product of shared entities alone has no row. So the block of its rows against its own entities has full row
rank wherever Ψ = 0, Ψ_q is block triangular along the tree, and no row is redundant, in any configuration.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement

from symgen.algebra import linear
from symgen.algebra.linear import Mat, Scalar
from symgen.algebra.numbers import Numbers
from symgen.natural.entities import Vector
from symgen.natural.forms import (
    Form,
    Polynomial,
    carried,
    combination,
    component,
    direction,
    dot,
    entity_form,
    terms,
)
from symgen.natural.layout import Constraint, NaturalCoordinates, Term, base_carrier, constant
from symgen.natural.plane import complement, cross, difference, in_plane, joint_axis, product, turned
from symgen.topology.tree import Tree, TreeBody


def build_constraints(natural: NaturalCoordinates, tree: Tree) -> tuple[Constraint, ...]:
    """All rows, body by body: lengths and angles, ties, the incoming joint's conditions. At zero they are met."""
    rows: list[Constraint] = []
    for body in tree.bodies:
        rows.extend(_rigid(natural, body))
        rows.extend(_ties(natural, body))
        for condition in CONDITIONS.get(body.joint.type, ()):
            rows.extend(condition(natural, body))
    return tuple(rows)


def _label(natural: NaturalCoordinates, index: int) -> str:
    return natural.entities[index].label


def _rigid(natural: NaturalCoordinates, body: TreeBody) -> list[Constraint]:
    """Products of the edges drawn from the base point; none for those the parent has already stated."""
    carriers = natural.carriers[body.index]
    base = base_carrier(natural, body.index)
    origin = natural.entities[carriers[base]]
    edges: list[tuple[str, Form, Vector, bool]] = []
    for n, index in enumerate(carriers):
        entity = natural.entities[index]
        own = entity.home == body.index
        if n == base:
            continue
        if entity.kind == "vector":
            edges.append((entity.label, entity_form(natural, index), entity.local[body.index], own))
        else:
            form = entity_form(natural, index) - entity_form(natural, carriers[base])
            local = difference(entity.local[body.index], origin.local[body.index])
            edges.append((f"({entity.label}-{origin.label})", form, local, own or origin.home == body.index))
    rows = []
    for (name1, form1, local1, own1), (name2, form2, local2, own2) in combinations_with_replacement(edges, 2):
        if own1 or own2:
            polynomial = dot(form1, form2)
            _add_constant(polynomial, -_local_product(natural, body.index, local1, local2))
            kind = "length" if name1 == name2 else "angle"
            rows.append(Constraint(f"{body.name}: {name1}·{name2}", kind, body.index, terms(polynomial)))
    return rows


def _local_product(natural: NaturalCoordinates, body: int, a: Vector, b: Vector) -> linear.Scalar:
    if natural.plane is None:
        return product(a, b)
    basis = natural.body_planes[body]
    return linear.dot(in_plane(basis, a), in_plane(basis, b))


def _add_constant(polynomial: Polynomial, value: Scalar) -> None:
    polynomial[()] = polynomial[()] + value if () in polynomial else value


def _ties(natural: NaturalCoordinates, body: TreeBody) -> list[Constraint]:
    """Entities beyond the carriers are combinations of them: one row per component."""
    rows = []
    for index in natural.members[body.index]:
        if index in natural.carriers[body.index]:
            continue
        entity = natural.entities[index]
        parts = carried(natural, body.index, entity.kind, entity.local[body.index])
        form = entity_form(natural, index) - combination(natural, parts)
        for k in range(len(form.constant)):
            name = f"{body.name}: {entity.label} tied [{k}]"
            rows.append(Constraint(name, "tie", body.index, terms(component(form, k))))
    return rows


# -- joint conditions beyond sharing ---------------------------------------------------------------------------------


def _outside(body: TreeBody, local: Vector) -> Vector:
    """A direction given in joint axes, in the parent's axes."""
    return turned(body.joint.origin.rotation, local)


def _normals(natural: NaturalCoordinates, body: TreeBody) -> tuple[Vector, ...]:
    """Unit vectors across the joint's axis, in joint axes; in planar scenes the one in the plane."""
    axis = joint_axis(body.joint)
    if natural.plane is None:
        return complement(axis)
    return (cross(natural.body_planes[body.index][2], axis),)


def _separation(natural: NaturalCoordinates, body: TreeBody) -> tuple[str, Form]:
    """r_b − r_a of a sliding joint: from the parent's point to the child's."""
    points = [k for k in natural.joints[body.index] if natural.entities[k].kind == "point"]
    name = f"({_label(natural, points[-1])}-{_label(natural, points[0])})"
    return name, entity_form(natural, points[-1]) - entity_form(natural, points[0])


def _joint_row(body: TreeBody, name: str, found: Sequence[Term]) -> Constraint:
    return Constraint(f"{body.joint.name}: {name}", "joint", body.index, tuple(found))


def aligned(natural: NaturalCoordinates, body: TreeBody) -> list[Constraint]:
    """(r_b − r_a)·n = 0 for the normals n of the axis, fixed in the parent."""
    name, separation = _separation(natural, body)
    rows = []
    for n, normal in enumerate(_normals(natural, body), 1):
        polynomial = dot(separation, direction(natural, body.parent, _outside(body, normal)))
        rows.append(_joint_row(body, f"{name}·n{n}", terms(polynomial)))
    return rows


def no_turn(natural: NaturalCoordinates, body: TreeBody) -> list[Constraint]:
    """m·n = 0, with m fixed in the child and n in the parent, at right angles to each other and (in space) to the axis:
    the sine of the angle turned, so the row never degenerates."""
    m = _normals(natural, body)[0]
    n = joint_axis(body.joint) if natural.plane is not None else _normals(natural, body)[1]
    polynomial = dot(direction(natural, body.index, m), direction(natural, body.parent, _outside(body, n)))
    return [_joint_row(body, "m·n", terms(polynomial))]


def axes_angle(natural: NaturalCoordinates, body: TreeBody) -> list[Constraint]:
    """u¹·u² = constant, whatever the constant."""
    first, second = (k for k in natural.joints[body.index] if natural.entities[k].kind == "vector")
    polynomial = dot(entity_form(natural, first), entity_form(natural, second))
    if body.joint.axis2 is None:
        raise ValueError(f"joint '{body.joint.name}' has no second axis")
    _add_constant(polynomial, -product(joint_axis(body.joint), body.joint.axis2))
    return [_joint_row(body, f"{_label(natural, first)}·{_label(natural, second)}", terms(polynomial))]


def in_normal_plane(natural: NaturalCoordinates, body: TreeBody) -> list[Constraint]:
    """(r_b − r_a)·n = 0; in planar scenes nothing is left to ask."""
    if natural.plane is not None:
        return []
    name, separation = _separation(natural, body)
    normal = natural.joints[body.index][1]
    return [_joint_row(body, f"{name}·{_label(natural, normal)}", terms(dot(separation, entity_form(natural, normal))))]


def screw(natural: NaturalCoordinates, body: TreeBody) -> list[Constraint]:
    """(r_b − r_a)·u − hφ = 0, and φ is the angle turned: m·(n₂ cos φ − n₁ sin φ) = 0, m = n₁ at zero."""
    axis, angle = natural.joints[body.index][1], natural.joints[body.index][3]
    start = natural.entities[angle].start
    if start is None or body.joint.pitch is None:
        raise ValueError(f"joint '{body.joint.name}' is no screw")
    name, separation = _separation(natural, body)
    phi = _label(natural, angle)
    advance = dot(separation, entity_form(natural, axis))
    advance[(start,)] = -body.joint.pitch
    n1, n2 = _normals(natural, body)
    m = direction(natural, body.index, n1)
    ahead = dot(m, direction(natural, body.parent, _outside(body, n2)))
    along = dot(m, direction(natural, body.parent, _outside(body, n1)))
    turned = (*terms(ahead, 1, ("cos", start)), *terms(along, -1, ("sin", start)))
    return [
        _joint_row(body, f"{name}·{_label(natural, axis)} - h {phi}", terms(advance)),
        _joint_row(body, f"m·(n2 cos {phi} - n1 sin {phi})", turned),
    ]


Condition = Callable[[NaturalCoordinates, TreeBody], list[Constraint]]

CONDITIONS: dict[str, tuple[Condition, ...]] = {
    "prismatic": (aligned, no_turn),
    "cylindrical": (aligned,),
    "helical": (aligned, screw),
    "universal": (axes_angle,),
    "planar": (in_normal_plane,),
}
"""What a joint type asks beyond the entities it shares."""


# -- values ----------------------------------------------------------------------------------------------------------


def _turn_value(turn: tuple[str, int] | None, x: Sequence[Scalar], numbers: Numbers, rate: bool = False) -> Scalar:
    """The factor cos φ or sin φ of a term, or its derivative by φ."""
    if turn is None:
        return 1
    function, angle = turn
    if not rate:
        return numbers.cos(x[angle]) if function == "cos" else numbers.sin(x[angle])
    return linear.sub(0, numbers.sin(x[angle])) if function == "cos" else numbers.cos(x[angle])


def _scaled(term: Term, numbers: Numbers, factors: Sequence[Scalar]) -> Scalar:
    value = constant(term.coefficient, numbers)
    for factor in factors:
        value = linear.mul(value, factor)
    return value


def evaluate_constraints(natural: NaturalCoordinates, x: Sequence[Scalar], numbers: Numbers) -> tuple[Scalar, ...]:
    """Ψ (nc) at the natural coordinates x (nn); identically zero at the x of any configuration of the tree."""
    return tuple(
        linear.total(
            _scaled(term, numbers, [_turn_value(term.turn, x, numbers), *(x[k] for k in term.factors)])
            for term in constraint.terms
        )
        for constraint in natural.constraints
    )


def constraint_jacobian(natural: NaturalCoordinates, x: Sequence[Scalar], numbers: Numbers) -> Mat:
    """Ψ_q (nc × nn) at x, rows as in `evaluate_constraints`; structural zeros are the int 0."""
    rows = []
    for constraint in natural.constraints:
        row: list[Scalar] = [0] * natural.nn
        for term in constraint.terms:
            turn = _turn_value(term.turn, x, numbers)
            for n, k in enumerate(term.factors):
                others = [x[j] for m, j in enumerate(term.factors) if m != n]
                row[k] = linear.add(row[k], _scaled(term, numbers, [turn, *others]))
            if term.turn is not None:
                rate = _turn_value(term.turn, x, numbers, rate=True)
                values = [rate, *(x[k] for k in term.factors)]
                row[term.turn[1]] = linear.add(row[term.turn[1]], _scaled(term, numbers, values))
        rows.append(tuple(row))
    return tuple(rows)
