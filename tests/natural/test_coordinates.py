"""Which points and vectors are chosen, their names and order, and how well W is conditioned."""

from __future__ import annotations

import random
import time
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symgen
from symgen.algebra.linear import matmul
from symgen.natural.carriers import CONDITION_LIMIT, complex_product
from symgen.natural.coordinates import choose_coordinates, ground_coordinates, natural_coordinates
from symgen.natural.layout import Complex, NaturalCoordinates
from symgen.natural.mass import SceneValues, natural_mass_matrix
from symgen.natural.plane import complement, cross, find_plane, product
from symgen.scene.model import GROUND, Body, Joint, Scene, Transform, Vector
from symgen.topology.tree import Tree, build_tree
from tests.natural.trees import AXES, X, Y, Z, random_planar_scene, random_scene, rotation, sample, triple

EXAMPLES = Path(__file__).parents[2] / "examples"
SIX = (F(1), F(2), F(5, 2), F(1, 10), F(1, 5), F(-1, 10))


def paper_body(name: str, declares: bool = False) -> Body:
    points = ((F(1, 4), F(1, 25), F(1, 10)),) if declares else ()
    vectors = ((F(2, 3), F(-1, 3), F(2, 3)),) if declares else ()
    return Body(name, F(2), (F(1, 8), F(1, 5), F(-1, 9)), SIX, points, vectors)


def paper_joint(number: int, kind: str, parent: str, child: str) -> Joint:
    """A joint with generic axis and mounting."""
    rng = random.Random(number)
    place = Transform(rotation(2, 1, -number, 3), triple(F(rng.randint(1, 9), 7) for _ in range(3)))
    return Joint(f"j{number}", kind, parent, child, place, AXES[4 + number % 3] if kind != "floating" else None)


def fig1() -> Scene:
    chain = [GROUND, "b1", "b2", "b3", "b4"]
    kinds = {1: "revolute", 2: "revolute", 3: "prismatic", 5: "revolute"}
    joints = [paper_joint(n, kind, chain[k], chain[k + 1]) for k, (n, kind) in enumerate(kinds.items())]
    return Scene("fig1", (*(paper_body(name) for name in chain[1:4]), paper_body("b4", True)), tuple(joints))


def fig2() -> Scene:
    joints = (
        paper_joint(1, "floating", GROUND, "b1"),
        paper_joint(2, "revolute", "b1", "b2"),
        paper_joint(3, "revolute", "b2", "b3"),
        paper_joint(4, "prismatic", "b3", "b4"),
        paper_joint(7, "revolute", "b1", "b5"),
    )
    bodies = tuple(paper_body(f"b{k}", k in (4, 5)) for k in range(1, 6))
    return Scene("fig2", bodies, joints)


def labels(natural: NaturalCoordinates, moving: bool) -> str:
    return " ".join(entity.label for entity in natural.entities if (entity.start is not None) == moving)


@pytest.mark.parametrize("scene", [fig1(), symgen.load(EXAMPLES / "fig1.scene.yaml")], ids=["ours", "example"])
def test_layout_of_fig_1(scene: Scene) -> None:
    """The left side of (4.9), its printed list corrected: nine moving entities, r1 and u1 in ground."""
    natural = choose_coordinates(build_tree(scene))
    assert labels(natural, True) == "r2 u2 r3 u3 r4 r5 u5 r6 u6"
    assert labels(natural, False) == "r1 u1"
    assert (natural.nn, natural.nc) == (27, 23)
    by_label = {entity.label: entity for entity in natural.entities}
    homes = {label: sorted(by_label[label].local) for label in ("u1", "r2", "r3", "u3", "r4", "r6")}
    assert homes == {"u1": [-1, 0], "r2": [0, 1], "r3": [1], "u3": [1, 2], "r4": [2], "r6": [3]}
    assert [entity.start for entity in natural.entities] == [None, None, *range(0, 27, 3)]


@pytest.mark.parametrize("scene", [fig2(), symgen.load(EXAMPLES / "fig2.scene.yaml")], ids=["ours", "example"])
def test_layout_of_fig_2(scene: Scene) -> None:
    """The left side of (4.13): fifteen entities, none in ground."""
    natural = choose_coordinates(build_tree(scene))
    assert labels(natural, True) == "r1 u1 r2 u2 r3 u3 r4 u4 r5 r6 u6 r7 u7 r8 u8"
    assert labels(natural, False) == ""
    assert natural.nn - natural.nc == 10


def test_labels_go_on_after_the_joints_for_auxiliary_entities() -> None:
    """Two revolutes leave the last body with one point and one vector: two auxiliary vectors, listed with it."""
    bodies = (Body("a"), Body("b"))
    joints = (Joint("j1", "revolute", GROUND, "a", axis=Z), Joint("j2", "revolute", "a", "b", Transform(), axis=X))
    natural = choose_coordinates(build_tree(Scene("two", bodies, joints)))
    assert labels(natural, False) == "r1 u1"
    assert labels(natural, True) == "u3 u2 u4 u5"  # the axes meet in r1, so u2 takes the next number


def test_universal_vectors_carry_superscripts() -> None:
    scene = Scene("cardan", (Body("a"),), (Joint("j", "universal", GROUND, "a", axis=Z, axis2=X),))
    natural = choose_coordinates(build_tree(scene))
    assert labels(natural, False) == "r1 u1_1"
    assert labels(natural, True).split()[0] == "u1_2"


def test_screw_has_its_angle_and_its_value() -> None:
    rng = random.Random(3)
    s = sample(random_scene(rng, 2, ("helical",)), rng)
    angles = [entity for entity in s.natural.entities if entity.kind == "angle"]
    assert [(entity.label, entity.home, entity.size) for entity in angles] == [("phi_j0", 0, 1), ("phi_j1", 1, 1)]
    starts = [entity.start for entity in angles]
    x = natural_coordinates(s.natural, s.tree, s.at.poses, s.state, s.numbers)
    assert [x[start] for start in starts if start is not None] == list(s.state.q)


def test_inverse_is_exact_and_condition_bounded() -> None:
    for seed in range(40):
        rng = random.Random(seed)
        scene = random_planar_scene(rng, 5) if seed % 4 == 0 else random_scene(rng, 5)
        natural = choose_coordinates(build_tree(scene))
        assert max(natural.conditions) <= CONDITION_LIMIT
        for w, inverse in zip(natural.W, natural.W_inverse, strict=True):
            if natural.plane is None:
                assert matmul(w, inverse) == tuple(tuple(int(i == j) for j in range(4)) for i in range(4))
            else:
                assert _complex_matmul(w, inverse) == [[(1, 0), (0, 0)], [(0, 0), (1, 0)]]


def _complex_matmul(a: Any, b: Any) -> list[list[Complex]]:
    result = []
    for row in a:
        products = [[complex_product(row[k], b[k][j]) for k in range(2)] for j in range(2)]
        result.append([(p[0][0] + p[1][0], p[0][1] + p[1][1]) for p in products])
    return result


def test_condition_is_that_of_the_scaled_matrix() -> None:
    """A floating body with points 1 m apart and gyration radius below: W with lengths in metres."""
    body = Body("a", F(1), (F(0),) * 3, (F(1, 100),) * 3 + (F(0),) * 3, ((F(1), F(0), F(0)), (F(0), F(1), F(0))), (Z,))
    natural = choose_coordinates(build_tree(Scene("a", (body,), (Joint("j", "floating", GROUND, "a"),))))
    expected = np.linalg.cond(np.array([[float(x) for x in row] for row in natural.W[0]]))
    assert natural.conditions[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("offset", [F(0), F(1, 10**9), F(1, 10**4)])
def test_points_too_near_do_not_carry(offset: F) -> None:
    """A body of a decimetre whose second point is (almost) its first gets auxiliary vectors instead."""
    bodies = tuple(Body(n, F(1), (F(1, 10), F(0), F(0)), (F(1, 100),) * 3 + (F(0),) * 3) for n in "ab")
    joints = (
        Joint("j1", "revolute", GROUND, "a", axis=Z),
        Joint("j2", "spherical", "a", "b", Transform(translation=(offset, F(0), F(0)))),
    )
    natural = choose_coordinates(build_tree(Scene("near", bodies, joints)))
    kinds = [natural.entities[k].kind for k in natural.carriers[0]]
    assert kinds.count("point") == 1
    assert natural.conditions[0] < 3


def test_many_children_stay_well_conditioned() -> None:
    """A hub with forty revolutes, of which four entities carry the mass."""
    rng = random.Random(4)
    bodies = [Body("hub", F(1), X, (F(1),) * 3 + (F(0),) * 3)]
    joints = [Joint("base", "floating", GROUND, "hub")]
    for k in range(40):
        bodies.append(Body(f"b{k}", F(1)))
        place = Transform(translation=triple(F(rng.randint(-9, 9), 9) for _ in range(3)))
        joints.append(Joint(f"j{k}", "revolute", "hub", f"b{k}", place, axis=rng.choice(AXES)))
    natural = choose_coordinates(build_tree(Scene("hub", tuple(bodies), tuple(joints))))
    assert len(natural.members[0]) > 40
    assert natural.conditions[0] < 10
    assert all(natural.entities[k].home == 0 for k in natural.carriers[0])


# -- planar ----------------------------------------------------------------------------------------------------------


def pendulums(axes: tuple[Vector, ...], base: Transform = Transform()) -> Tree:  # noqa: B008
    names = [GROUND, *(f"b{k}" for k in range(len(axes)))]
    joints = [
        Joint(f"j{k}", "revolute", names[k], names[k + 1], base if k == 0 else Transform(translation=X), axis)
        for k, axis in enumerate(axes)
    ]
    return build_tree(Scene("p", tuple(Body(name, F(1), X) for name in names[1:]), tuple(joints)))


@pytest.mark.parametrize(("normal", "basis"), [(Z, (X, Y)), (Y, (X, Z)), (X, (Y, Z)), ((F(0), F(0), F(-1)), (X, Y))])
def test_plane_is_drawn_as_people_draw_it(normal: Vector, basis: tuple[Vector, Vector]) -> None:
    found = find_plane(pendulums((normal, normal)))
    assert found is not None
    assert found[0][:2] == basis
    for e1, e2, n in (found[0], *found[1]):
        assert cross(e1, e2) == n


def test_opposite_axes_are_planar_and_skew_ones_are_not() -> None:
    assert find_plane(pendulums((Z, (F(0), F(0), F(-1))))) is not None
    assert find_plane(pendulums((Z, Y))) is None
    assert find_plane(pendulums((Z, (F(0), F(3, 5), F(4, 5))))) is None


def test_tilted_plane() -> None:
    tree = pendulums((Z, Z), Transform(rotation(3, 1, -2, 1)))
    natural = choose_coordinates(tree)
    assert natural.plane is not None
    assert natural.nn == 4
    e1, e2, n = natural.plane
    assert [product(a, b) for a in (e1, e2, n) for b in (e1, e2, n)] == [1, 0, 0, 0, 1, 0, 0, 0, 1]


def test_joints_that_leave_the_plane() -> None:
    for kind in ("spherical", "universal", "floating", "helical", "cylindrical"):
        joints = (
            Joint("a", "revolute", GROUND, "x", axis=Z),
            Joint("b", kind, "x", "y", axis=Z, axis2=X, pitch=F(1)),
        )
        assert find_plane(build_tree(Scene("s", (Body("x"), Body("y")), joints))) is None


def test_declared_vectors_ask_for_space() -> None:
    tree = pendulums((Z, Z))
    assert choose_coordinates(tree).plane is not None
    body = tree.bodies[1]
    declared = replace(body, parts=((replace(body.parts[0][0], unit_vectors=(X,)), Transform()),))
    natural = choose_coordinates(replace(tree, bodies=(tree.bodies[0], declared)))
    assert natural.plane is None
    assert "u3" in labels(natural, True)


def test_planar_points_one_above_the_other_are_one() -> None:
    joints = (
        Joint("a", "revolute", GROUND, "x", axis=Z),
        Joint("b", "revolute", "x", "y", Transform(translation=(F(0), F(0), F(3)), rotation=rotation(1, 0, 0, 2)), Z),
    )
    natural = choose_coordinates(build_tree(Scene("stack", (Body("x"), Body("y")), joints)))
    assert ground_coordinates(natural) == {0: (F(0), F(0))}
    assert labels(natural, False) == "r1"
    assert labels(natural, True) == "r2 r3"


def test_complement_is_orthonormal_and_right_handed() -> None:
    for n in (*AXES, (F(-1), F(0), F(0)), (F(0), F(-1), F(0))):
        e1, e2 = complement(n)
        assert cross(e1, e2) == n
        assert [product(e1, e1), product(e2, e2), product(e1, e2)] == [1, 1, 0]


# -- speed -----------------------------------------------------------------------------------------------------------


def test_long_chains_stay_fast() -> None:
    """A hundred bodies with axes on the 2⁻⁶⁰ grid: a tenth of a second here; the limit only catches a blow-up."""
    rng = random.Random(1)
    names = [GROUND, *(f"b{k}" for k in range(100))]
    joints = []
    for k in range(100):
        a, b = (F(rng.getrandbits(60), 2**60) for _ in range(2))
        s = 1 + a * a + b * b
        place = Transform(rotation(*(rng.getrandbits(40) for _ in range(4))), triple(F(rng.random()) for _ in range(3)))
        joints.append(Joint(f"j{k}", "revolute", names[k], names[k + 1], place, (2 * a / s, 2 * b / s, 2 / s - 1)))
    bodies = tuple(Body(name, F(1), X, SIX) for name in names[1:])
    tree = build_tree(Scene("chain", bodies, tuple(joints)))
    start = time.process_time()
    natural = choose_coordinates(tree)
    natural_mass_matrix(natural, tree, SceneValues())
    assert time.process_time() - start < 2
    assert max(natural.conditions) <= CONDITION_LIMIT
