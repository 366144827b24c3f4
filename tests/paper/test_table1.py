"""Paper, Table 1: the blocks R_ij and Ṙ_ij of every joint type, against the derived R and Ṙ; errata 9 and 10."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symgen.algebra.linear import Mat
from symgen.natural.entities import Entity
from symgen.scene.model import ZERO3, Options
from symgen.system import derive
from symgen.targets.sympy import block_matrix
from symgen.targets.sympy import paper as paper_room
from symgen.targets.sympy.paper import Factor, Point, Term, check_block, paper_natural
from tests.paper.world import World, example, matvec, notation, same
from tests.validation.scenes import SINGLES, chain, every_joint, single


def blocks(world: World, rate: bool) -> dict[tuple[str, str], str]:
    """{(row label, column): block} in the paper's symbols."""
    matrix = block_matrix(world.system, rate)
    found = {}
    for entity, row in zip(matrix.rows, matrix.blocks, strict=True):
        for unit, block in zip(matrix.columns, row, strict=True):
            found[entity.label, unit.letter + "_".join(unit.indices)] = notation(block)
    return found


def derived(world: World, label: str, column: int, size: int, rate: bool) -> Mat:
    """The rows of an entity and the columns of a joint in the derived R or Ṙ."""
    literal = world.literal
    matrix = literal.velocity_transformation_rate() if rate else literal.velocity_transformation()
    start = next(e.start for e in world.system.natural.entities if e.label == label)
    assert start is not None
    return tuple(tuple(matrix[start + k][column : column + size]) for k in range(3))


def is_derived(world: World, label: str, block: str, column: int, size: int, rate: bool) -> bool:
    value = world.evaluate(block)
    found = derived(world, label, column, size, rate)
    if isinstance(value, int):
        unit = tuple(tuple(value if i == j else 0 for j in range(size)) for i in range(3))
        return same(found, unit)
    return same(found, value if size == 3 else tuple((x,) for x in value))


FIG2 = World(example("fig2"))


@pytest.mark.parametrize("label", ["r1", "u1", "r3", "u3", "r6", "u6", "r8", "u8"])
def test_floating(label: str) -> None:
    """[1, −D_ij; 0, −U_i] and [0, −Ḋ_ij; 0, −U̇_i]"""
    i = label[1:]
    angular, its_rate = (f"-D{i}1", f"-D'{i}1") if label[0] == "r" else (f"-U{i}", f"-U'{i}")
    linear = "1" if label[0] == "r" else "0"
    if label == "r1":
        angular = its_rate = "0"  # "if body i is the same as floating base body j, then d_ij = 0"
    r, rdot = blocks(FIG2, False), blocks(FIG2, True)
    assert (r[label, "r1"], r[label, "omega1"]) == (linear, angular)
    assert (rdot[label, "r1"], rdot[label, "omega1"]) == ("0", its_rate)
    assert is_derived(FIG2, label, linear, 0, 3, False) and is_derived(FIG2, label, angular, 3, 3, False)
    assert is_derived(FIG2, label, "0", 0, 3, True) and is_derived(FIG2, label, its_rate, 3, 3, True)


REVOLUTE = [("r3", "2", 6), ("u4", "2", 6), ("r6", "3", 7), ("u6", "3", 7), ("r8", "7", 9)]


@pytest.mark.parametrize(("label", "joint", "column"), REVOLUTE)
def test_revolute(label: str, joint: str, column: int) -> None:
    """[−D_ij u_j; −U_i u_j] and [−Ḋ_ij u_j − D_ij u̇_j; −U̇_i u_j − U_i u̇_j]"""
    i = label[1:]
    if label[0] == "r":
        block, its_rate = f"-D{i}{joint} u{joint}", f"-D'{i}{joint} u{joint} -D{i}{joint} u'{joint}"
    else:
        block, its_rate = f"-U{i} u{joint}", f"-U'{i} u{joint} -U{i} u'{joint}"
    assert blocks(FIG2, False)[label, f"theta{joint}"] == block
    assert blocks(FIG2, True)[label, f"theta{joint}"] == its_rate
    assert is_derived(FIG2, label, block, column, 1, False)
    assert is_derived(FIG2, label, its_rate, column, 1, True)


@pytest.mark.parametrize(("label", "block", "its_rate"), [("r6", "u4", "u'4"), ("u6", "0", "0")])
def test_prismatic(label: str, block: str, its_rate: str) -> None:
    """[u_j; 0] and [u̇_j; 0]"""
    assert blocks(FIG2, False)[label, "theta4"] == block
    assert blocks(FIG2, True)[label, "theta4"] == its_rate
    assert is_derived(FIG2, label, block, 8, 1, False)
    assert is_derived(FIG2, label, its_rate, 8, 1, True)


UNIVERSAL = World(derive(chain("universal", ("revolute", "universal", "revolute"))))


@pytest.mark.parametrize("label", ["r3", "u3"])
@pytest.mark.parametrize("s", ["1", "2"])
def test_universal(label: str, s: str) -> None:
    """[−D_ij u_jˢ; −U_i u_jˢ] and Aˢ = [−Ḋ_ij u_jˢ − D_ij u̇_jˢ; −U̇_i u_jˢ − U_i u̇_jˢ]"""
    matrix = "D32" if label[0] == "r" else "U3"
    block, its_rate = f"-{matrix} u2_{s}", f"-{matrix[0]}'{matrix[1:]} u2_{s} -{matrix} u'2_{s}"
    assert blocks(UNIVERSAL, False)[label, f"theta2_{s}"] == block
    assert blocks(UNIVERSAL, True)[label, f"theta2_{s}"] == its_rate
    assert is_derived(UNIVERSAL, label, block, int(s), 1, False)
    assert is_derived(UNIVERSAL, label, its_rate, int(s), 1, True)


def test_erratum_10_one_u_i_in_both_columns() -> None:
    """Table 1 prints U_i¹ twice in R and U_iˢ in Aˢ: with vectors of its own in each column of Ṙ, the rate of one row
    would be that of another vector."""
    assert not is_derived(UNIVERSAL, "u3", "-U'2_2 u2_2 -U2_2 u'2_2", 2, 1, True)
    assert is_derived(UNIVERSAL, "u3", "-U'3 u2_2 -U3 u'2_2", 2, 1, True)


def test_erratum_9_floating_velocities_are_r_and_omega() -> None:
    """Not [ṙ; u̇]: −U_i u̇₁ is not u̇_i; and the base has six velocities, not as many as its natural coordinates."""
    w = FIG2
    block = w.evaluate("-U2")
    assert not same(w.rate("u2"), matvec(block, w.rate("u1")))
    assert same(w.rate("u2"), matvec(block, w.omega(1)))
    base = w.system.tree.bodies[0]
    assert base.nv == 6
    assert sum(e.size for e in w.system.natural.entities if e.home == 0 and e.start is not None) > 6


@pytest.mark.parametrize("kind", SINGLES)
@pytest.mark.parametrize("rate", [False, True])
def test_every_other_joint_type_is_derived_too(kind: str, rate: bool) -> None:
    """`block_matrix` compares every block with R or Ṙ; here it is made to, for the joint and one behind it."""
    matrix = block_matrix(derive(single(kind)), rate)
    assert any(block for row in matrix.blocks for block in row)


@pytest.mark.parametrize("base_velocity", ["world", "body", "mixed"])
def test_floating_conventions(base_velocity: str) -> None:
    scene = chain("f", ("floating", "revolute"), options=Options(base_velocity=base_velocity))
    for rate in (False, True):
        matrix = block_matrix(derive(scene), rate)
        assert [unit.letter for unit in matrix.columns] == ["v" if base_velocity == "body" else "r", "omega", "theta"]


def test_all_types_on_one_tree() -> None:
    for rate in (False, True):
        matrix = block_matrix(derive(every_joint()), rate)
        indices = [(unit.letter, unit.indices) for unit in matrix.columns]
        assert len(set(indices)) == len(indices)


def test_joints_at_one_point_are_told_apart() -> None:
    """Two axes through one basic point: the second joint takes another number."""
    scene = chain("wrist", ("revolute", "revolute", "revolute"))
    joints = tuple(replace(joint, origin=replace(joint.origin, translation=scene.joints[0].origin.translation))
                   if k == 0 else replace(joint, origin=replace(joint.origin, translation=ZERO3))
                   for k, joint in enumerate(scene.joints))  # fmt: skip
    matrix = block_matrix(derive(replace(scene, joints=joints)))
    assert len({unit.indices for unit in matrix.columns}) == 3


def test_a_block_that_is_not_derived_is_refused() -> None:
    """The comparison can fail: a sign, an index, a dot."""
    system = FIG2.system
    point = Point.random(system, paper_natural(system), 1)
    matrix = block_matrix(system)
    k = [entity.label for entity in matrix.rows].index("r6")
    entity, unit = matrix.rows[k], matrix.columns[2]
    wanted = tuple((x,) for x in point.literal.r_columns[k][unit.columns[0]])
    good = matrix.blocks[k][2]
    check_block(point, good, wanted, entity, unit, matrix.columns)
    for block in (
        (Term(False, good[0].factors),),
        (Term(True, (Factor("D", ("6", "3")), Factor("u", ("2",)))),),
        (Term(True, (Factor("D", ("6", "2")), Factor("u", ("2",), 1))),),
        (),
    ):
        with pytest.raises(ArithmeticError, match="r6"):
            check_block(point, block, wanted, entity, unit, matrix.columns)


def test_a_wrong_rule_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Table 1 with the sign of the vectors' block turned round."""
    right = paper_room._r_block

    def wrong(entity: Entity, unit: paper_room.Unit) -> paper_room.Block:
        block = right(entity, unit)
        return tuple(replace(term, negative=False) for term in block) if entity.kind == "vector" else block

    monkeypatch.setattr(paper_room, "_r_block", wrong)
    with pytest.raises(ArithmeticError):
        block_matrix(FIG2.system)
