"""Fold angles around vertices: against plain products of matrices, and where nothing must close."""

import json
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import fan, grid, pattern_of, triangles
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from strategies import patches

from fab import read_pattern
from fab.formats.fold.writer import fold_bytes
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.pattern.inspection import inspect_closure
from fab.pattern.kinematics import vertices_closure_rad


@given(mesh=patches())
def test_angles_of_folded_sheets_close(mesh):
    pattern = crease_pattern(mesh, develop(mesh), 10.0)
    gaps = np.degrees(vertices_closure_rad(pattern))
    rim = np.unique(pattern.edges_vertices[pattern.edges_faces[:, 1] < 0])
    assert np.isnan(gaps[rim]).all()
    inside = np.setdiff1d(np.arange(len(gaps)), rim)
    assert (gaps[inside] < 1e-6).all()
    assert inspect_closure(pattern) == []


@given(st.integers(3, 12), st.integers(0, 2**32 - 1))
def test_the_gap_is_the_angle_of_the_product_of_all_turns(sides, seed):
    random = np.random.default_rng(seed)
    sheet = fan(sides, 10.0, "V")
    spokes = sheet.edges_assignment == "V"
    angles = np.zeros(len(spokes))
    angles[spokes] = random.uniform(-180, 180, sides)
    sheet = replace(sheet, edges_foldAngle=angles)
    ends = sheet.edges_vertices[spokes].sum(axis=1)  # the other end is vertex 0
    product = np.eye(3)
    for v in range(1, sides + 1):
        x, y = sheet.vertices_coords[v] / 10.0
        turn = np.radians(angles[spokes][ends == v][0])
        product = product @ Rotation.from_rotvec(turn * np.array([x, y, 0.0])).as_matrix()
    gap = np.degrees(Rotation.from_matrix(product).magnitude())
    assert np.degrees(vertices_closure_rad(sheet))[0] == pytest.approx(gap, abs=1e-6)
    assert np.isnan(np.degrees(vertices_closure_rad(sheet))[1:]).all()


@pytest.mark.parametrize("off", [0.02, 1.0, 30.0])
def test_a_crease_that_is_off_opens_its_vertex_by_as_much(off):
    sheet = grid(2, 2, 10.0)
    across = np.isin(sheet.edges_vertices, [3, 5]).any(axis=1) & (sheet.edges_faces[:, 1] >= 0)
    angles = np.where(across, 90.0, 0.0)
    assert inspect_closure(replace(sheet, edges_foldAngle=angles)) == []
    angles = np.where(across & (np.cumsum(across) == 1), 90.0 + off, angles)
    sheet = replace(sheet, edges_foldAngle=angles)
    assert np.degrees(vertices_closure_rad(sheet))[4] == pytest.approx(off)
    (finding,) = inspect_closure(sheet)
    assert finding.code == "angles-open"
    assert "vertex 4 at (10, 10) mm" in finding.text
    assert f"by {off:.4g} degrees" in finding.text


@pytest.mark.parametrize("letter", ["C", "U"])
def test_cuts_and_free_creases_leave_a_vertex_open(letter):
    whole = fan(6, 10.0, "V")
    letters = whole.edges_assignment.copy()
    letters[np.flatnonzero(letters == "V")[0]] = letter
    faces = whole.faces_vertices.reshape(-1, 3).tolist()
    sheet = pattern_of(whole.vertices_coords, faces, letters)
    assert np.isnan(np.degrees(vertices_closure_rad(sheet))).all()
    assert np.isfinite(np.degrees(vertices_closure_rad(whole))[0])
    assert inspect_closure(sheet) == []


@pytest.mark.parametrize("letter", ["M", "U", "C"])
def test_lines_that_end_within_a_face_turn_nothing(tmp_path, letter):
    document = json.loads(fold_bytes(grid(2, 2, 10.0), "grid"))
    document["edges_foldAngle"] = [0.0] * len(document["edges_vertices"])
    flat = {"V": "F", "B": "B"}
    document["edges_assignment"] = [flat[given] for given in document["edges_assignment"]]
    document["vertices_coords"].append([13.0, 14.0, 0.0])
    document["edges_vertices"].append([4, 9])
    document["edges_assignment"].append(letter)
    document["edges_foldAngle"].append(-90.0 if letter == "M" else 0.0)
    path = tmp_path / "grid.fold"
    path.write_text(json.dumps(document))
    gaps = np.degrees(vertices_closure_rad(read_pattern(path)[0]))
    assert gaps[4] == 0
    assert np.isfinite(gaps).sum() == 1


def test_sheets_may_turn_twice_around_a_vertex():
    angle = np.arange(12) * np.pi / 3
    rim = 100 * np.column_stack([np.cos(angle), np.sin(angle)])
    faces = [[0, 1 + i, 1 + (i + 1) % 12] for i in range(12)]
    sheet = pattern_of(np.vstack([[[0.0, 0.0]], rim]), faces, "V", angle=0.0)
    assert vertices_closure_rad(sheet)[0] == pytest.approx(0.0, abs=1e-12)
    angles = np.zeros(len(sheet.edges_vertices))
    angles[np.flatnonzero(sheet.edges_assignment == "V")[0]] = 30.0
    folded = replace(sheet, edges_foldAngle=angles)
    assert vertices_closure_rad(folded)[0] == pytest.approx(np.radians(30))


def test_flat_sheets_close_everywhere_inside():
    sheet = triangles(3)
    flat = replace(sheet, edges_foldAngle=np.zeros(len(sheet.edges_foldAngle)))
    gaps = np.degrees(vertices_closure_rad(flat))
    assert (gaps[np.isfinite(gaps)] == 0).all()
