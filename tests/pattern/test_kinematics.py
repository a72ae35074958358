"""Folding by angles: closed forms, closure, and wrong angles that are named."""

from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import fan, grid, pattern_of
from helpers import TEMPLATE_NAMES, template_fold

from fab import read_pattern
from fab.pattern.kinematics import fold_by_angles
from fab.pattern.open_cuts import opened
from solver.vectors import norm

SMALL = ["miura", "twisted_squares", "trefoil_knot", "helicoid_40", "curved_fold", "nested_cones"]


def template(name, tmp_path):
    (tmp_path / "x.fold").write_bytes(template_fold(name))
    return read_pattern(tmp_path / "x.fold")[0]


def moved_onto(points, target):
    a, b = points - points.mean(axis=0), target - target.mean(axis=0)
    left, _, right = np.linalg.svd(a.T @ b)
    turn = left @ np.diag([1, 1, np.sign(np.linalg.det(left @ right))]) @ right
    return a @ turn + target.mean(axis=0)


@pytest.mark.parametrize("name", SMALL)
def test_angles_of_templates_close_and_give_the_folded_form(name, tmp_path):
    assert name in TEMPLATE_NAMES
    pattern = template(name, tmp_path)
    found = fold_by_angles(pattern)
    size = norm(np.ptp(pattern.folded_coords, axis=0))
    assert found.closure_max_rad < 1e-10
    assert found.gap_mm < 1e-10 * size
    assert found.gap_rad < 1e-9
    off = moved_onto(found.folded_coords, pattern.folded_coords) - pattern.folded_coords
    assert norm(off).max() < 1e-10 * size


def test_one_crease_turns_its_face_about_the_edge():
    pattern = pattern_of(
        [[0, 0], [2, 0], [2, 1], [0, 1], [5, 0], [5, 1]],
        [[0, 1, 2, 3], [1, 4, 5, 2]],
        "V",
        angle=90.0,
    )
    folded = fold_by_angles(pattern).folded_coords
    up = folded[[4, 5]] - folded[[1, 2]]
    if np.allclose(folded[:4, 2], 0):  # the left face stays: the right one rises
        assert up == pytest.approx(np.array([[0, 0, 3], [0, 0, 3]]), abs=1e-12)
    else:
        left = folded[[0, 3]] - folded[[1, 2]]
        assert left == pytest.approx(np.array([[0, 0, 2], [0, 0, 2]]), abs=1e-12)


def test_a_square_folded_in_four_closes_and_a_wrong_angle_does_not():
    pattern = fan(4, 1.0, "V")
    angle = np.zeros(len(pattern.edges_vertices))
    inner = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)
    angle[inner] = [180.0, 180.0, -180.0, 180.0]  # folded flat, Maekawa holds
    folded = fold_by_angles(replace(pattern, edges_foldAngle=angle))
    assert folded.closure_max_rad == pytest.approx(0, abs=1e-12)
    angle = angle.copy()
    angle[inner[0]] = 175.0
    wrong = fold_by_angles(replace(pattern, edges_foldAngle=angle))
    assert wrong.closure_max_rad == pytest.approx(np.radians(5), abs=1e-9)
    assert np.flatnonzero(wrong.vertices_closure_rad > 1e-6).tolist() == [0]
    assert np.isnan(wrong.vertices_closure_rad[1:]).all()


@pytest.mark.parametrize("change", ["sign", "five degrees"])
def test_a_wrong_angle_on_any_crease_is_named_at_its_ends(change, tmp_path):
    pattern = template("miura", tmp_path)
    shared = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)
    inside = np.isfinite(fold_by_angles(pattern).vertices_closure_rad)
    for edge in shared.tolist():
        ends = pattern.edges_vertices[edge]
        if not inside[ends].any():
            continue
        angle = pattern.edges_foldAngle.copy()
        angle[edge] = -angle[edge] if change == "sign" else angle[edge] + 5.0
        closure = fold_by_angles(replace(pattern, edges_foldAngle=angle)).vertices_closure_rad
        named = set(np.flatnonzero(closure > 1e-6).tolist())
        assert named == set(ends[inside[ends]].tolist())


def test_angles_may_close_at_vertices_and_not_around_a_hole():
    pattern = grid(3, 3, 10.0, without=[(1, 1)])
    angle = np.zeros(len(pattern.edges_vertices))
    middle = pattern.vertices_coords[pattern.edges_vertices].mean(axis=1)
    one = (np.abs(middle - [20.0, 5.0]) < 1e-9).all(axis=1)
    angle[one] = 30.0
    found = fold_by_angles(replace(pattern, edges_foldAngle=angle))
    assert found.closure_max_rad == 0.0
    assert found.gap_rad == pytest.approx(np.radians(30))


def test_several_pieces_and_cuts_fold_each_for_itself():
    pattern = opened(grid(4, 1, 10.0, cuts=[(2, 7)])).pattern
    found = fold_by_angles(pattern)
    assert found.gap_mm < 1e-12
    apart = fold_by_angles(grid(3, 1, 10.0, without=[(1, 0)]))
    assert apart.folded_coords[:, 2] == pytest.approx(0.0)


def test_unassigned_creases_close_nothing():
    pattern = fan(5, 1.0, ["U", "V", "V", "V", "V", "V", "V", "V", "V", "V"])
    inner = pattern.edges_faces[:, 1] >= 0
    assert (pattern.edges_assignment[inner] == "U").sum() == 1
    assert np.isnan(fold_by_angles(pattern).vertices_closure_rad).all()
