"""Paper §2: the path matrices of both systems, and erratum 1."""

from __future__ import annotations

import numpy as np
import pytest

from tests.paper.world import example

PI_1 = [[-1, 1, 0, 0], [0, -1, 1, 0], [0, 0, -1, 1], [0, 0, 0, -1]]
PI_2 = [[-1, 1, 0, 0, 1], [0, -1, 1, 0, 0], [0, 0, -1, 1, 0], [0, 0, 0, -1, 0], [0, 0, 0, 0, -1]]
PI_STAR_1 = [[-1, 0, 0, 0], [-2, -1, 0, 0], [-3, -2, -1, 0], [-4, -3, -2, -1]]
PI_STAR_2_PRINTED = [
    [-1, 0, 0, 0, 0, 0],
    [-2, -1, 0, 0, 0, 0],
    [-3, -2, -1, 0, 0, 0],
    [-4, -3, -2, -1, 0, 0],
    [-2, 0, 0, 0, -1],
]


def test_path_matrices() -> None:
    assert example("fig1").path_matrix.tolist() == PI_1
    assert example("fig2").path_matrix.tolist() == PI_2


def test_secondary_path_matrix_of_the_grounded_system() -> None:
    assert example("fig1").secondary_path_matrix.tolist() == PI_STAR_1


def test_erratum_1_a_stray_sixth_column() -> None:
    """Printed with six columns in four of five rows it is no matrix; without the sixth it is ours."""
    with pytest.raises(ValueError, match="inhomogeneous"):
        np.array(PI_STAR_2_PRINTED)
    assert all(row[5:] in ([0], []) for row in PI_STAR_2_PRINTED)
    found = example("fig2").secondary_path_matrix
    assert found.shape == (5, 5)
    assert found.tolist() == [row[:5] for row in PI_STAR_2_PRINTED]


def test_erratum_1_four_paths_are_four_edges() -> None:
    """π*₄₁ = −4: between edge one and body four there is one path, of four edges, both ends counted."""
    system = example("fig1")
    assert system.secondary_path_matrix[3, 0] == -4
    assert len(system.tree.path(3)) == 4


def test_joints_are_those_of_the_figures() -> None:
    for name, letters in (("fig1", "RRPR"), ("fig2", "FRRPR")):
        kinds = {"revolute": "R", "prismatic": "P", "floating": "F"}
        assert "".join(kinds[body.joint.type] for body in example(name).tree.bodies) == letters
