"""Edges that come together when folded: by the folded form, by the angles, not by flat folds."""

from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import grid, pattern_of
from hypothesis import given
from hypothesis import strategies as st

from fab.pattern.closing_edges import closing_edges, closing_edges_by_angles
from fab.pattern.kinematics import fold_by_angles


def prism(sides, angle, rows=1):
    """A strip of squares, every crease across it folded by an angle."""
    pattern = grid(sides, rows, 10.0)
    ends = pattern.vertices_coords[pattern.edges_vertices]
    across = (ends[:, 0, 0] == ends[:, 1, 0]) & (pattern.edges_assignment != "B")
    letters = np.where(pattern.edges_assignment == "B", "B", np.where(across, "V", "F"))
    return replace(pattern, edges_assignment=letters, edges_foldAngle=np.where(across, angle, 0.0))


def cube():
    """Six squares as a cross, folded by 90 degrees."""
    without = [(c, r) for r in (0, 2) for c in (0, 2, 3)]
    pattern = grid(4, 3, 10.0, without)
    inner = pattern.edges_assignment != "B"
    return replace(pattern, edges_foldAngle=np.where(inner, 90.0, 0.0))


@given(st.integers(3, 12), st.integers(1, 3))
def test_a_prism_closes_by_its_angles_as_by_its_folded_form(sides, rows):
    pattern = prism(sides, 360.0 / sides, rows)
    edges, angle = closing_edges_by_angles(pattern)
    assert len(edges) == rows
    assert angle == pytest.approx(np.full(rows, 360.0 / sides))
    folded = replace(pattern, folded_coords=fold_by_angles(pattern).folded_coords)
    known_edges, known_angle = closing_edges(folded)
    assert (known_edges == edges).all()
    assert known_angle == pytest.approx(angle)
    off = prism(sides, 350.0 / sides, rows)
    assert len(closing_edges_by_angles(off)[0]) == 0


def test_a_cube_has_seven_seams_with_or_without_a_slit():
    edges, angle = closing_edges_by_angles(cube())
    assert len(edges) == 7
    assert np.abs(angle) == pytest.approx(np.full(7, 90.0))
    # two squares more beside the top, with a cut between them, change nothing
    assert len(closing_edges_by_angles(pattern_with_cut())[0]) == 7


def pattern_with_cut():
    """The cube, one of whose faces is two triangles with a cut along half of their common side."""
    pattern = cube()
    corners = [
        pattern.faces_vertices[i:j].tolist()
        for i, j in zip(pattern.faces_offsets[:-1], pattern.faces_offsets[1:], strict=True)
    ]
    a, b, c, d = corners[-1]
    coords = np.vstack([pattern.vertices_coords, pattern.vertices_coords[[a, c]].mean(axis=0)])
    middle = len(coords) - 1
    faces = [*corners[:-1], [a, b, c, middle], [a, middle, c, d]]
    letters = pattern_of(coords, faces)
    inner = letters.edges_assignment != "B"
    ends = np.sort(letters.edges_vertices, axis=1)
    first = (ends == sorted((a, middle))).all(axis=1)
    second = (ends == sorted((c, middle))).all(axis=1)
    return replace(
        letters,
        edges_assignment=np.where(first, "C", np.where(second, "F", np.where(inner, "V", "B"))),
        edges_foldAngle=np.where(inner & ~first & ~second, 90.0, 0.0),
    )


def test_flat_folds_bring_no_edges_together():
    """The doors of a cupboard touch in the middle, and are opened again."""
    coords = [[0, 0], [30, 0], [90, 0], [120, 0], [0, 80], [30, 80], [90, 80], [120, 80]]
    faces = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]]
    doors = pattern_of(coords, faces, "V", angle=180.0)
    folded = replace(doors, folded_coords=fold_by_angles(doors).folded_coords)
    assert folded.folded_coords[0] == pytest.approx(folded.folded_coords[3])
    assert len(closing_edges(folded)[0]) == 0
    assert len(closing_edges_by_angles(doors)[0]) == 0


def test_unknown_angles_close_nothing():
    pattern = cube()
    inner = np.flatnonzero(pattern.edges_assignment != "B")
    letters, angle = pattern.edges_assignment.copy(), pattern.edges_foldAngle.copy()
    letters[inner[0]], angle[inner[0]] = "U", 0.0
    unknown = replace(pattern, edges_assignment=letters, edges_foldAngle=angle)
    assert len(closing_edges_by_angles(unknown)[0]) == 0
