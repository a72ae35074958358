"""Trimming of sheets to the rim of their surface: nothing is bent, nothing is beyond, all is over.

Also what it rests on: faces left out of grids, and neighbours across concave corners.
"""

from dataclasses import replace

import numpy as np
import pytest
from surface_meshes import cap, disc, grid, mesh_of

from solver import QuadMesh, developability, planarity
from solver.mesh import edges_of
from solver.relaxation import relaxed_sheet
from solver.relaxation.laying import Pleats, laid_patch, rim_planes
from solver.relaxation.neighbours import opposite_pairs
from solver.relaxation.rim_trimming import shares_over, trimmed
from solver.self_intersection import crossing_faces
from solver.surface_cover import covered
from solver.surface_maps import disc_map
from solver.targets.mesh_target import MeshTarget


def flat_sheet(rows, columns, low, high, z=0.0):
    x, y = np.meshgrid(np.linspace(*low, columns), np.linspace(*high, rows))
    return QuadMesh.from_rows(np.stack([x, y, np.full_like(x, z)], axis=-1))


def square():
    return MeshTarget(mesh_of(grid(lambda u, v: (u, v, 0 * u), 8, 8)))


def outline(mesh):
    edges = edges_of(*mesh.polygons)
    return np.unique(edges.edges_vertices[edges.edges_faces[:, 1] < 0])


def test_shares_over_a_square_are_those_of_its_cells():
    """Of columns from -1.5 to 1.5, three wide, the outer two are half over it."""
    sheet = flat_sheet(4, 4, (-1.5, 1.5), (-0.9, 0.9))
    share = shares_over(square(), sheet.vertices_coords, sheet.faces_vertices)
    assert share.reshape(3, 3).tolist() == [[0.5, 1.0, 0.5]] * 3


def test_a_flat_sheet_is_trimmed_to_its_square_exactly():
    sheet = flat_sheet(6, 6, (-1.1, 1.1), (-1.1, 1.1))
    out = trimmed(square(), sheet)
    np.testing.assert_array_equal(out.faces_vertices, sheet.faces_vertices)
    inner = np.setdiff1d(np.arange(36), outline(sheet))
    np.testing.assert_array_equal(out.vertices_coords[inner], sheet.vertices_coords[inner])
    assert np.abs(out.vertices_coords[outline(sheet)]).max(axis=1) == pytest.approx(1, abs=1e-5)
    assert np.abs(out.vertices_coords).max() <= 1 + 1e-9


def test_a_sheet_within_its_surface_stays_as_it_is():
    sheet = flat_sheet(5, 5, (-0.8, 0.8), (-0.9, 0.9), 0.05)
    np.testing.assert_array_equal(trimmed(square(), sheet).vertices_coords, sheet.vertices_coords)


def test_cells_beyond_the_rim_are_dropped_and_sides_keep_their_least_length():
    """The last column is beyond the square altogether; the first and third are partly over it."""
    sheet = flat_sheet(6, 5, (-1.6, 2.4), (-0.8, 0.8))
    out = trimmed(square(), sheet)
    assert len(out.faces_vertices) == 15  # the column of x from 1.4 to 2.4 is dropped
    assert (out.grid[:, 4] == -1).all()
    right = out.vertices_coords[out.grid[1:-1, 3]]
    assert right[:, 0] == pytest.approx(1.0, abs=1e-5)
    left = out.vertices_coords[out.grid[1:-1, 0]]
    assert left[:, 0] == pytest.approx(-1.0, abs=1e-5)
    short = trimmed(square(), flat_sheet(6, 4, (-0.9, 1.8), (-0.8, 0.8)))
    assert short.vertices_coords[short.grid[1:-1, 3], 0] == pytest.approx(0.9 + 0.3 * 0.9, abs=1e-5)


@pytest.mark.parametrize(
    "arrays",
    [cap(np.pi / 3, 12, 36), disc(lambda x, y: (2 * x, y, 0.2 * x * y), 10, 36)],
    ids=["cap", "oval saddle"],
)
def test_trimming_keeps_sheets_exact_and_the_surface_covered(arrays):
    surface = mesh_of(arrays)
    target = MeshTarget(surface, disc_map(surface))
    sheet = laid_patch(target, 10, Pleats(), 0.0)
    whole = relaxed_sheet(target, sheet, rim=rim_planes(target, sheet)).mesh
    out = trimmed(target, whole)
    for measure in (planarity, developability):
        before, after = (measure(m.vertices_coords, m.faces_vertices).max() for m in (whole, out))
        assert before < 1e-13
        assert after < 1e-13
    reach = 2 * sheet.cell.thickness
    before, after = (
        covered(target, [(m.vertices_coords, m.faces_vertices)], reach).mean() for m in (whole, out)
    )
    assert after > 0.99
    # vertices inside stay, creases at the rim have only become shorter
    there = out.grid >= 0
    old, new = whole.vertices_coords[whole.grid[there]], out.vertices_coords[out.grid[there]]
    moved = np.linalg.norm(new - old, axis=1)
    on_rim = np.zeros(len(out.vertices_coords), bool)
    on_rim[outline(out)] = True
    assert moved[~on_rim[out.grid[there]]].max() == 0
    assert (
        0
        < moved.max()
        < 0.7
        * np.linalg.norm(np.ptp(whole.vertices_coords[whole.faces_vertices], axis=1), axis=1).max()
    )
    aside = [shares_over(target, m.vertices_coords, m.faces_vertices).mean() for m in (whole, out)]
    assert aside[1] > aside[0]


@pytest.mark.parametrize("size", [12, 20])
def test_a_face_of_the_rim_that_crosses_another_is_dropped_from_a_large_sheet(size):
    """Two cells beside a corner of a square stand upright and lean through each other."""
    ends = -0.9, 0.9
    flat = flat_sheet(size + 2, size + 2, ends, ends)
    kept = np.ones((size + 1, size + 1), bool)
    kept[0], kept[:, 0] = False, False
    kept[2, 0] = kept[0, 2] = True
    sheet = flat.with_faces(kept)
    coords, side = sheet.vertices_coords.copy(), 1.8 / (size + 1)
    corner = coords[sheet.grid[1, 1]]
    for axis, free in ((0, sheet.grid[2:4, 0]), (1, sheet.grid[0, 2:4])):
        lean = np.sign(corner[1 - axis]) * 2 * side
        coords[free, axis] = corner[axis]
        coords[free, 1 - axis] += lean
        coords[free, 2] += side
    swung = QuadMesh(coords, sheet.faces_vertices, sheet.grid)
    assert len(crossing_faces(coords, *swung.polygons)) == 1
    out = trimmed(square(), swung)
    large = len(swung.faces_vertices) > 1 / 0.003
    assert len(swung.faces_vertices) - len(out.faces_vertices) == large
    assert len(crossing_faces(out.vertices_coords, *out.polygons)) == (not large)


def test_pairs_across_a_concave_corner_are_both_there():
    """An L of three faces: vertex 4 has three of them, and both its lines run through it.

    6 7
    3 4 5      each number is a vertex; the face at the upper right is missing
    0 1 2
    """
    faces = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6]])
    pairs = {tuple(sorted(pair)) for pair in opposite_pairs(faces, 8).tolist()}
    assert pairs == {(0, 2), (0, 6), (1, 7), (3, 5)}
    turned = {tuple(sorted(p)) for p in opposite_pairs(np.roll(faces, 1, axis=1)[::-1], 8).tolist()}
    assert turned == pairs


def test_pairs_of_a_whole_grid_are_those_of_its_rows_and_columns():
    mesh = flat_sheet(4, 5, (0, 1), (0, 1))
    grid_of = mesh.grid
    expected = {
        tuple(sorted(pair))
        for a, b in ((grid_of[:, :-2], grid_of[:, 2:]), (grid_of[:-2], grid_of[2:]))
        for pair in zip(a.ravel().tolist(), b.ravel().tolist(), strict=True)
    }
    pairs = opposite_pairs(mesh.faces_vertices, 20).tolist()
    assert len(pairs) == len(expected)
    assert {tuple(sorted(pair)) for pair in pairs} == expected


def test_faces_of_a_tube_can_be_left_out():
    angle = np.pi / 3 * np.arange(6)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    rows = np.stack([np.column_stack([ring, np.full(6, z)]) for z in (0.0, 1.0, 2.0)])
    tube = QuadMesh.from_rows(rows, closed=True)
    kept = np.ones((2, 6), bool)
    whole = tube.with_faces(kept)
    np.testing.assert_array_equal(whole.faces_vertices, tube.faces_vertices)
    assert whole.closed
    kept[0, 4:] = kept[0, 0] = False  # across the seam: vertices 5 and 0 of the first row go
    part = tube.with_faces(kept)
    assert part.closed
    assert len(part.faces_vertices) == 9
    assert part.grid[0].tolist() == [-1, 0, 1, 2, 3, -1]
    corners = part.vertices_coords[part.faces_vertices]
    np.testing.assert_array_equal(corners, tube.vertices_coords[tube.faces_vertices[kept.ravel()]])


def test_a_sheet_with_cells_left_out_has_no_vertices_without_faces():
    surface = mesh_of(cap(1.0, 8, 24))
    target = MeshTarget(surface, disc_map(surface))
    sheet = laid_patch(target, 8, Pleats())
    mesh = sheet.mesh(sheet.points(target))
    assert len(mesh.faces_vertices) == sheet.kept.sum() == len(sheet.faces_vertices)
    assert np.unique(mesh.faces_vertices).tolist() == list(range(len(mesh.vertices_coords)))


def test_no_vertex_is_left_far_beyond_the_rim_where_a_little_may_be_lost():
    """A disc under a square grid: without a loss staircases stick out, with one they do not."""
    mesh = mesh_of(disc(lambda x, y: (x, y, 0 * x), 24, 96))
    target = MeshTarget(mesh)
    x, y = np.meshgrid(np.linspace(-1.1, 1.1, 12), np.linspace(-1.1, 1.1, 12))
    whole = QuadMesh.from_rows(np.stack([x, y, 0 * x], axis=-1))
    share = shares_over(target, whole.vertices_coords, whole.faces_vertices)
    sheet = whole.with_faces((share > 0.04).reshape(11, 11))

    def beyond(made):
        return np.linalg.norm(made.vertices_coords[:, :2], axis=1).max() - 1

    kept = trimmed(target, sheet, most_beyond=0.05)
    assert beyond(kept) > 0.05
    made = trimmed(target, sheet, most_beyond=0.05, may_fall=0.05)
    assert beyond(made) < beyond(kept)
    lost = shares_over(target, kept.vertices_coords, kept.faces_vertices).sum()
    lost -= shares_over(target, made.vertices_coords, made.faces_vertices).sum()
    assert 0 < lost <= 0.05 * share.sum()


def test_trimming_ends_where_a_cell_is_kept_only_to_join_others():
    """A ring of squares without one corner: the cell that fills it up is all beyond the rim."""
    coords, faces = [], []
    for row, column in ((1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)):
        corners = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)]
        number = []
        for corner in corners:  # the ends of the ring touch in (1, 1), and are not joined
            if corner not in coords or (corner == (1, 1) and (row, column) == (0, 1)):
                coords.append(corner)
            number.append(len(coords) - 1 - coords[::-1].index(corner))
        faces += [(number[0], number[1], number[2]), (number[0], number[2], number[3])]
    mesh = mesh_of((np.pad(np.array(coords, float), ((0, 0), (0, 1))), np.array(faces)))
    sheet = flat_sheet(4, 4, (0, 3), (0, 3))
    made = trimmed(MeshTarget(mesh), sheet, most_beyond=0.5, may_fall=0.5)
    assert len(made.faces_vertices) == 8


def test_faces_and_cells_are_looked_at_in_blocks_of_any_size(monkeypatch):
    mesh = mesh_of(cap(np.pi / 4, 8, 24))
    target = MeshTarget(mesh, disc_map(mesh))
    whole = laid_patch(target, 10, Pleats())
    coords, faces = whole.points(target), replace(whole, kept=None).faces_vertices
    share = shares_over(target, coords, faces)
    assert 0 < share.mean() < 1
    for module in ("laying", "rim_trimming"):
        monkeypatch.setattr(f"solver.relaxation.{module}._AT_ONCE", 7)
    np.testing.assert_array_equal(shares_over(target, coords, faces), share)
    np.testing.assert_array_equal(laid_patch(target, 10, Pleats()).kept, whole.kept)
