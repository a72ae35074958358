"""Sheets that fold rigidly and flat, exact in every state of their motion."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import InvalidValue, Miura, QuadMesh, RigidMiura, Status, developability, planarity
from solver.flat_foldable import left_sector, multiplier
from solver.measure import isometry, sector_angles
from solver.rigid_march import march

STATIONS = np.pi * np.arange(1, 21) / 20


def mesh_of(coords):
    """A folded sheet as a mesh, and the flat or folded coordinates of its vertices."""
    return QuadMesh.from_rows(
        coords if coords.shape[2] == 3 else np.pad(coords, [(0, 0)] * 2 + [(0, 1)])
    )


def kawasaki(mesh):
    """By how much opposite sectors at interior vertices miss a half turn, radians."""
    rows, columns = mesh.grid.shape
    sector = sector_angles(mesh.vertices_coords, mesh.faces_vertices)
    sector = sector.reshape(rows - 1, columns - 1, 4)  # corners: lower left, lower right, ...
    above_right, below_left = sector[1:, 1:, 0], sector[:-1, :-1, 2]
    above_left, below_right = sector[1:, :-1, 1], sector[:-1, 1:, 3]
    return np.abs([above_right + below_left - np.pi, above_left + below_right - np.pi]).max()


@st.composite
def boundary_data(draw):
    """Sectors and lengths near to those of Miura sheets, and not near to any."""
    columns, rows = draw(st.integers(2, 9)), draw(st.integers(2, 8))
    wide = draw(st.sampled_from([0.05, 0.3]))
    random = np.random.default_rng(draw(st.integers(0, 10**6)))
    lean = np.where(np.arange(columns - 1) % 2, 2, 1) * np.pi / 3

    def near(sectors):
        return sectors + random.uniform(-wide, wide, len(sectors))

    row, column = (near(lean), near(lean)), (near(np.full(rows - 2, 1.1)),) * 2
    lengths = [random.uniform(0.7, 1.3, n) for n in (columns, rows)]
    return *row, *column, *lengths


@given(boundary_data())
@settings(max_examples=40)
def test_sheets_are_exact_along_their_whole_motion(data):
    marched = march(*data)
    sheet = marched.sheet
    flat = mesh_of(sheet.flat_coords)
    assert kawasaki(flat) <= 1e-13
    assert developability(flat.vertices_coords, flat.faces_vertices).max(initial=0) <= 1e-13
    side = np.roll(flat.vertices_coords[flat.faces_vertices], -1, axis=1)
    side = (side - flat.vertices_coords[flat.faces_vertices])[..., :2]
    turn = np.linalg.det(np.stack([side, np.roll(side, -1, axis=1)], axis=-2))
    assert turn.min() > 0  # panels are convex
    for fold in STATIONS:
        mesh = mesh_of(sheet.folded(fold))
        bent = planarity(mesh.vertices_coords, mesh.faces_vertices)
        change = isometry(mesh.vertices_coords, flat.vertices_coords[:, :2], mesh.faces_vertices)
        assert bent.max() <= 1e-12
        assert change.max() <= 1e-12
    assert np.ptp(mesh.vertices_coords[:, 2]) <= 1e-12  # the last station is folded flat
    along, across = sheet.fold_angles(np.pi)
    assert (np.abs(along) == np.pi).all()
    assert (np.abs(across) == np.pi).all()


@given(boundary_data(), st.floats(0.05, 3.0))
@settings(max_examples=20)
def test_fold_angles_are_the_closed_form(data, fold):
    """Measured between the panels in space; the half-angle tangents keep their ratios."""
    sheet = march(*data).sheet
    coords = sheet.folded(fold)
    x, y = coords[:-1, 1:] - coords[:-1, :-1], coords[1:, :-1] - coords[:-1, :-1]
    normal = np.cross(x, y)
    normal /= np.linalg.norm(normal, axis=2)[..., None]

    def measured(first, second, edge):
        edge = edge / np.linalg.norm(edge, axis=2)[..., None]
        sine = (np.cross(second, first) * edge).sum(axis=2)
        return np.arctan2(sine, (first * second).sum(axis=2))

    along, across = sheet.fold_angles(fold)
    assert np.abs(np.concatenate([along.ravel(), across.ravel()])).max() == pytest.approx(fold)
    up, right = np.diff(coords, axis=0)[:, 1:-1], np.diff(coords, axis=1)[1:-1]
    assert measured(normal[:, :-1], normal[:, 1:], up) == pytest.approx(across, abs=1e-9)
    assert measured(normal[1:], normal[:-1], right) == pytest.approx(along, abs=1e-9)
    assert np.tan(along / 2) == pytest.approx(sheet.along * np.tan(fold / 2), rel=1e-9)
    assert np.tan(across / 2) == pytest.approx(sheet.across * np.tan(fold / 2), rel=1e-9)


@given(boundary_data())
@settings(max_examples=20)
def test_the_row_and_the_column_are_as_given(data):
    row_right, row_left, column_right, column_left, row_lengths, column_lengths = data
    sheet = march(*data).sheet
    rows = len(sheet.across)
    assert sheet.right[0].tolist() == row_right.tolist()
    assert sheet.left[0].tolist() == row_left.tolist()
    assert sheet.right[1:, 0].tolist() == column_right[: rows - 2].tolist()
    assert sheet.left[1:, 0].tolist() == column_left[: rows - 2].tolist()
    inner = np.linalg.norm(np.diff(sheet.flat_coords[1, 1:-1], axis=0), axis=1)
    assert inner == pytest.approx(row_lengths[1:-1])
    inner = np.linalg.norm(np.diff(sheet.flat_coords[1:-1, 1], axis=0), axis=1)
    assert inner == pytest.approx(column_lengths[1 : rows - 1])
    first = sheet.flat_coords[1:-1, 1:-1]
    to_right, up = sheet.flat_coords[1:-1, 2:] - first, sheet.flat_coords[2:, 1:-1] - first
    corner = (to_right * up).sum(axis=2) / np.linalg.norm(to_right, axis=2)
    cosine = corner / np.linalg.norm(up, axis=2)
    assert np.arccos(cosine) == pytest.approx(sheet.right, abs=1e-7)


@given(st.floats(0.05, 3.09), st.floats(0.05, 3.09))
def test_the_sector_of_a_multiplier_gives_it_back(right, left):
    m = multiplier(right, left)
    assert left_sector(right, 1.0, m) == pytest.approx(left, abs=1e-9)
    other = np.sin((left - right) / 2) / np.sin((left + right) / 2)
    assert left_sector(right, other, 1.0) == pytest.approx(left, abs=1e-9)


def test_a_miura_sheet_is_marched_from_its_sectors():
    """The same shape as the strip-by-strip design, at the same fold."""
    grown = Miura(columns=6, rows=5, fold=0.7).grow().mesh
    normal = [
        np.cross(*np.diff(grown.vertices_coords[f[:3]], axis=0)) for f in grown.faces_vertices
    ]
    normal = np.array(normal).reshape(5, 6, 3)
    cosine = (normal[0, 0] @ normal[1, 0]) / (normal[0, 0] @ normal[0, 0])
    sixty = (2 * np.pi / 3, np.pi / 3)
    design = RigidMiura(6, 5, sixty, sixty, sixty[:1], sixty[:1], fold=np.arccos(cosine))
    made = design.grow()
    assert made.status is Status.GROWN

    def distances(mesh):
        x = mesh.vertices_coords[mesh.grid].reshape(-1, 3)
        return np.linalg.norm(x[:, None] - x, axis=2)

    turned = QuadMesh.from_rows(grown.vertices_coords[grown.grid])
    assert distances(made.mesh) == pytest.approx(distances(turned), abs=1e-9)


def test_a_design_that_cannot_go_on_keeps_its_rows_and_says_why():
    spiral = RigidMiura(
        row_right=(np.pi / 3, 1.92), row_left=(np.pi / 3, 1.92), column_right=(1.0,)
    )
    made = spiral.grow()
    assert made.status is Status.LENGTH_NOT_POSITIVE
    assert 2 <= made.strips + 1 < spiral.rows
    assert made.advice.startswith(f"Row {made.strips + 1}: ")
    assert "shorter rows or longer columns" in made.advice
    coords, faces = made.mesh.vertices_coords, made.mesh.faces_vertices
    assert len(faces) == spiral.columns * (made.strips + 1)
    assert planarity(coords, faces).max() <= 1e-13
    assert developability(coords, faces).max() <= 1e-13


def test_sectors_that_leave_their_bounds_end_the_march():
    made = RigidMiura(
        row_right=(0.3, 2.0), row_left=(2.0, 0.4), column_right=(2.8,), column_left=(2.5,)
    ).grow()
    assert made.status is Status.SECTOR_OUT_OF_BOUNDS
    assert "vertex 2 would need a sector of" in made.advice
    assert planarity(made.mesh.vertices_coords, made.mesh.faces_vertices).max() <= 1e-13


@pytest.mark.parametrize(
    ("name", "value", "match"),
    [
        ("columns", 1, "columns"),
        ("rows", 1, "rows"),
        ("fold", np.pi, "fold"),
        ("row_right", (1.0, 3.2), r"row_right\[1\]"),
        ("column_left", (0.0,), r"column_left\[0\]"),
        ("row_left", (2 * np.pi / 3,), r"row_left\[0\].*not make 180 deg with row_right\[0\]"),
        ("row_lengths", (1.0, -1.0), r"row_lengths\[1\]"),
        ("column_lengths", (), "column_lengths is empty"),
    ],
)
def test_boundary_data_out_of_bounds_are_refused(name, value, match):
    with pytest.raises(InvalidValue, match=match):
        RigidMiura(**{name: value}).grow()


def test_folds_beyond_flat_are_refused():
    with pytest.raises(InvalidValue, match="fold"):
        RigidMiura(3, 3).march().sheet.folded(3.2)
