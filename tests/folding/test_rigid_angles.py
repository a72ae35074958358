"""Fold angles of rigid folds against closed forms; patterns that do not fold rigidly."""

from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import fan_of, grid, triangles
from helpers import PATTERNS
from hypothesis import given, settings
from hypothesis import strategies as st

from fab import read_pattern
from fab.folding.rigid_angles import rigid_angles
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.pattern.kinematics import fold_by_angles, vertices_closure_rad
from solver import InvalidValue, Miura


def require_rigid(made, fold_deg):
    """Closed at every vertex, signs as the letters, the largest angle as it was asked for."""
    closure = vertices_closure_rad(made)
    assert np.nan_to_num(closure).max() <= 1e-9
    angles = made.edges_foldAngle
    assert np.abs(angles).max() == pytest.approx(fold_deg, abs=1e-7)
    assert (angles[made.edges_assignment == "M"] <= 1e-6).all()
    assert (angles[made.edges_assignment == "V"] >= -1e-6).all()
    assert (angles[~np.isin(made.edges_assignment, ["M", "V", "U"])] == 0).all()
    assert made.folded_coords is None


@given(
    st.floats(30.0, 85.0),
    st.floats(30.0, 85.0),
    st.floats(0.5, 179.9),
    st.sampled_from(["VVMV", "VMVV", "MMVM", "MVMM"]),
)
@settings(max_examples=40)
def test_vertices_of_four_creases_follow_the_closed_form(first, second, fold_deg, letters):
    """tan(rho_1 / 2) = p tan(rho_2 / 2) with p of the sectors and the mode (Tachi 2009)."""
    a, b = np.radians([max(first, second) + 4, min(first, second)])
    pattern, spokes = fan_of([a, b, np.pi - a, np.pi - b], letters)
    made, findings = rigid_angles(pattern, fold_deg)
    assert [finding.code for finding in findings] == ["rigid-fold"]
    require_rigid(made, fold_deg)
    half = np.tan(np.radians(made.edges_foldAngle[spokes]) / 2)
    if letters in ("VVMV", "MMVM"):
        slow, fast, p = 0, 1, np.sin((a - b) / 2) / np.sin((a + b) / 2)
    else:
        slow, fast, p = 1, 0, np.cos((a + b) / 2) / np.cos((a - b) / 2)
    assert abs(half[slow]) == pytest.approx(abs(p * half[fast]), rel=1e-6)
    assert np.abs(half[2:]) == pytest.approx(np.abs(half[:2]), rel=1e-6)


@pytest.mark.parametrize("fold_deg", [1.0, 30.0, 90.0, 150.0, 179.0, 180.0])
def test_a_miura_folds_by_its_closed_form(fold_deg):
    """The zigzag creases fold by rho, the straight ones by 2 atan(cos(gamma) tan(rho / 2))."""
    mesh = Miura(columns=6, rows=5).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    made, _ = rigid_angles(pattern, fold_deg)
    require_rigid(made, fold_deg)
    folds = made.edges_faces[:, 1] >= 0
    sizes = np.unique(np.abs(made.edges_foldAngle[folds]).round(6))
    assert len(sizes) == (1 if fold_deg == 180 else 2)
    side = np.diff(pattern.vertices_coords[pattern.faces_vertices[:3]], axis=0)
    cosine = abs(-side[0] @ side[1]) / np.hypot(*side[0]) / np.hypot(*side[1])
    slow = 2 * np.degrees(np.arctan(cosine * np.tan(np.radians(fold_deg) / 2)))
    assert sizes[0] == pytest.approx(slow, abs=1e-5)
    folded = fold_by_angles(made)
    assert folded.gap_mm < 1e-8


def test_a_miura_is_where_its_own_folded_form_is():
    """The angles of a grown sheet, found again from the letters alone."""
    mesh = Miura(columns=5, rows=4).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    largest = float(np.abs(pattern.edges_foldAngle).max())
    made, _ = rigid_angles(pattern, largest)
    assert made.edges_foldAngle == pytest.approx(pattern.edges_foldAngle, abs=1e-6)


@pytest.mark.parametrize("name", ["bird_base", "miura", "waterbomb", "yoshimura"])
@pytest.mark.parametrize("fold_deg", [20.0, 90.0, 180.0])
def test_published_patterns_that_fold_rigidly(name, fold_deg):
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    made, findings = rigid_angles(pattern, fold_deg)
    assert [finding.code for finding in findings] == ["rigid-fold"]
    require_rigid(made, fold_deg)
    assert fold_by_angles(made).gap_rad < 1e-9


@pytest.mark.parametrize("name", ["square_twist", "crane", "maze", "resch"])
def test_patterns_that_do_not_fold_rigidly_stay_as_they_are(name):
    """The worst vertex is named; for the square twist see Silverberg et al. (2015)."""
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    made, (finding,) = rigid_angles(pattern, 90.0)
    assert made is pattern
    assert finding.code == "rigid-fold-missing"
    assert "around vertex" in finding.text
    vertex = int(finding.text.split("around vertex ")[1].split()[0])
    x, y = pattern.vertices_coords[vertex]
    assert f"({x:.6g}, {y:.6g}) mm" in finding.text


def test_a_state_that_cannot_be_reached_from_flat_is_not_taken():
    """A box with gussets: closed, it is a state of rigid faces, but nothing leads there."""
    pattern, _ = read_pattern(PATTERNS / "box.fold")
    made, (finding,) = rigid_angles(pattern, 90.0)
    assert made is pattern
    assert finding.code == "rigid-fold-missing"


@pytest.mark.parametrize("fold_deg", [10.0, 60.0, 150.0, 180.0])
def test_vertices_that_do_not_fold_flat_fold_until_a_crease_does(fold_deg):
    """The sector that is not the sum of its neighbours keeps the others from it."""
    pattern, spokes = fan_of(np.radians([80.0, 60.0, 90.0, 130.0]), "VVMV")
    made, _ = rigid_angles(pattern, fold_deg)
    require_rigid(made, fold_deg)
    assert (np.abs(made.edges_foldAngle[spokes]) > fold_deg - 1e-7).sum() == 1


def test_a_sheet_that_stops_before_is_reported():
    """Random triangles that lock: what is reported can be reached, and no more."""
    pattern = triangles(12, 8)
    far, (finding,) = rigid_angles(pattern, 180.0)
    assert far is pattern
    reached = float(finding.text.split(" at ")[1].split()[0])
    assert 5 < reached < 175
    made, _ = rigid_angles(pattern, reached - 0.1)
    require_rigid(made, reached - 0.1)
    beyond, _ = rigid_angles(pattern, reached + 0.1)
    assert beyond is pattern


def test_creases_without_a_letter_fold_as_they_must():
    a, b = np.radians([70.0, 50.0])
    pattern, spokes = fan_of([a, b, np.pi - a, np.pi - b], "VVMU")
    made, _ = rigid_angles(pattern, 90.0)
    assert made.edges_foldAngle[spokes[3]] == pytest.approx(90.0)
    require_rigid(made, 90.0)


def test_sheets_without_interior_vertices_fold_by_all_they_are_given():
    strip = grid(4, 1, 10.0)
    made, _ = rigid_angles(strip, 77.0)
    creases = strip.edges_faces[:, 1] >= 0
    assert made.edges_foldAngle[creases] == pytest.approx(77.0)


def test_flat_creases_stay_flat():
    mesh = Miura(columns=4, rows=4).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    letters = pattern.edges_assignment.copy()
    letters[np.flatnonzero(letters == "M")[0]] = "F"
    made, (finding,) = rigid_angles(replace(pattern, edges_assignment=letters), 90.0)
    assert finding.code == "rigid-fold-missing"
    assert made.edges_assignment.tolist() == letters.tolist()


def test_letters_must_say_how_it_folds():
    pattern = grid(2, 2, 10.0)
    free = np.where(pattern.edges_joining, "U", pattern.edges_assignment)
    _, (finding,) = rigid_angles(replace(pattern, edges_assignment=free))
    assert "no mountain or valley" in finding.text


def test_a_ring_that_misses_itself_is_reported():
    """Around a hole faces must meet too."""
    sheet = grid(3, 3, 10.0, without=[(1, 1)])
    middle = sheet.vertices_coords[sheet.edges_vertices].mean(axis=1)
    folds = (middle[:, 1] == 5) & (sheet.edges_faces[:, 1] >= 0)
    letters = np.where(sheet.edges_joining, "F", "B")
    letters[folds] = "V"
    made, (finding,) = rigid_angles(replace(sheet, edges_assignment=letters), 90.0)
    assert finding.code == "rigid-fold-missing"
    assert "around a hole" in finding.text
    assert made.edges_foldAngle.tolist() == sheet.edges_foldAngle.tolist()


@given(st.integers(0, 300), st.floats(5.0, 180.0))
@settings(max_examples=15)
def test_whatever_is_found_closes(seed, fold_deg):
    pattern = triangles(seed, 8)
    made, (finding,) = rigid_angles(pattern, fold_deg)
    if made is pattern:
        assert finding.code == "rigid-fold-missing"
    else:
        require_rigid(made, fold_deg)


@pytest.mark.parametrize("fold_deg", [0.0, -10.0, 181.0, float("nan")])
def test_angles_out_of_bounds_are_refused(fold_deg):
    with pytest.raises(InvalidValue, match="fold_deg"):
        rigid_angles(grid(2, 1, 10.0), fold_deg)
