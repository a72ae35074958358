"""Crease patterns: signs, angles and counts."""

from dataclasses import replace

import flat_patterns
import numpy as np
import pytest
from hypothesis import given
from strategies import patches

from fab.pattern.crease_pattern import crease_pattern, fold_angles_deg
from fab.pattern.development import develop
from fab.pattern.inspection import measure_pattern
from solver import InvalidValue, Miura
from solver.mesh import edges_of


def pattern_of(mesh, scale=1.0):
    return crease_pattern(mesh, develop(mesh), scale)


@pytest.mark.parametrize("angle_deg", [-179.0, -90.0, -1.0, 0.0, 30.0, 120.0, 180.0])
def test_a_single_fold_has_its_angle_and_valleys_are_positive(angle_deg):
    """Two squares in the xy plane seen from +z; the right one is turned up about x = 1."""
    t = np.radians(angle_deg)
    x, z = 1 + np.cos(t), np.sin(t)
    folded = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [x, 0, z], [x, 1, z]])
    faces = np.array([0, 1, 2, 3, 1, 4, 5, 2])
    offsets = np.array([0, 4, 8])
    edges = edges_of(faces, offsets)
    angles = fold_angles_deg(folded, edges, faces, offsets)
    crease = edges.edges_vertices.tolist().index([1, 2])
    assert angles[crease] == pytest.approx(angle_deg, abs=1e-12)
    assert np.delete(angles, crease).tolist() == [0.0] * 6


def test_miura_angles_are_those_of_the_closed_form():
    gamma, fold = np.radians(60), np.radians(45)
    pattern = pattern_of(Miura(sector_angle=gamma, fold=fold).grow().mesh)
    inner = np.abs(pattern.edges_foldAngle[pattern.edges_faces[:, 1] >= 0])
    # faces lean by `fold` on both sides of a zigzag; creases between rows follow (Schenk, Guest)
    across = 2 * np.degrees(
        np.arcsin(np.sin(fold) * np.cos(gamma) / np.sqrt(1 - (np.sin(fold) * np.sin(gamma)) ** 2))
    )
    assert sorted(set(inner.round(8))) == pytest.approx(sorted([across, 90.0]), abs=1e-7)


def test_counts_of_a_miura_sheet():
    pattern = pattern_of(Miura(columns=10, rows=8).grow().mesh)
    assert pattern.face_count == 80
    assert pattern.counts() == {"M": 76, "V": 66, "F": 0, "B": 36}


@given(patches())
def test_letters_follow_signs_and_borders_are_flat(mesh):
    pattern = pattern_of(mesh, 25.0)
    letter, angle = pattern.edges_assignment, pattern.edges_foldAngle
    border = pattern.edges_faces[:, 1] < 0
    assert (letter[border] == "B").all()
    assert (angle[border] == 0).all()
    assert ((letter == "V") == (angle > 0)).all()
    assert ((letter == "M") == (angle < 0)).all()


@given(patches())
def test_every_interior_vertex_satisfies_maekawa_or_is_nowhere_flat(mesh):
    """A degree-4 vertex that folds has three creases of one letter and one of the other."""
    pattern = pattern_of(mesh)
    sign = np.sign(pattern.edges_foldAngle)
    degree = np.zeros(len(mesh.vertices_coords))
    total = np.zeros(len(mesh.vertices_coords))
    for end in (0, 1):
        np.add.at(degree, pattern.edges_vertices[:, end], sign != 0)
        np.add.at(total, pattern.edges_vertices[:, end], sign)
    border = np.unique(pattern.edges_vertices[pattern.edges_faces[:, 1] < 0])
    inner = np.setdiff1d(np.flatnonzero(degree == 4), border)
    assert (np.abs(total[inner]) == 2).all()


def test_scale_is_applied_once():
    mesh = Miura().grow().mesh
    small, large = pattern_of(mesh), pattern_of(mesh, 20.0)
    assert large.vertices_coords == pytest.approx(20 * small.vertices_coords)
    assert large.folded_coords == pytest.approx(20 * mesh.vertices_coords)
    assert (large.edges_foldAngle == small.edges_foldAngle).all()
    assert measure_pattern(large).isometry_max_rel < 1e-13


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_bad_scales_are_refused(scale):
    with pytest.raises(InvalidValue, match="scale_mm_per_unit"):
        pattern_of(Miura().grow().mesh, scale)


def test_edges_that_join_faces_are_creases_between_two_of_them():
    corners, faces = [[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]]
    for letter, joins in (("V", True), ("F", True), ("U", True), ("C", False)):
        pattern = flat_patterns.pattern_of(corners, faces, letter)
        joined = np.sort(pattern.edges_vertices[pattern.edges_joining], axis=1).tolist()
        assert joined == ([[0, 2]] if joins else [])
        assert pattern.faces_piece.tolist() == ([0, 0] if joins else [0, 1])


def test_an_edge_within_a_face_joins_nothing():
    pattern = flat_patterns.grid(2, 1, 10.0)
    faces = pattern.edges_faces.copy()
    crease = int(np.flatnonzero(faces[:, 1] >= 0)[0])
    faces[crease, 1] = faces[crease, 0]
    assert pattern.edges_joining.sum() == 1
    assert replace(pattern, edges_faces=faces).edges_joining.sum() == 0
