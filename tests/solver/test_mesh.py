"""Numbering, connectivity and boundary of meshes."""

import numpy as np
import pytest
from hypothesis import given
from strategies import patches

from solver import InvalidValue, QuadMesh, Side
from solver.mesh import boundary_loops, edges_of, interior_vertices


def flat_patch(rows: int, columns: int) -> QuadMesh:
    y, x = np.mgrid[:rows, :columns]
    return QuadMesh.from_rows(np.stack([x, y, 0 * x], axis=-1).astype(float))


def test_numbering_is_the_one_drawn_in_the_module():
    mesh = flat_patch(4, 4)
    assert mesh.faces_vertices[0].tolist() == [0, 1, 5, 4]
    assert mesh.faces_vertices[5].tolist() == [6, 7, 11, 10]
    assert mesh.grid[3].tolist() == [12, 13, 14, 15]


def test_arrays_are_read_only_and_the_callers_array_is_left_alone():
    rows = np.zeros((2, 3, 3)) + np.arange(3)[:, None]
    mesh = QuadMesh.from_rows(rows)
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices_coords[0] = 1
    rows[0] = 7
    assert mesh.vertices_coords[0, 0] == 0


@pytest.mark.parametrize(
    ("side", "front"),
    [
        (Side.TOP, [3, 4, 5]),
        (Side.BOTTOM, [2, 1, 0]),
        (Side.LEFT, [0, 3]),
        (Side.RIGHT, [5, 2]),
    ],
)
def test_fronts_run_with_new_growth_on_their_left(side, front):
    assert flat_patch(2, 3).front_vertices(side).tolist() == front


@pytest.mark.parametrize("side", list(Side))
def test_growth_on_any_side_keeps_old_numbers_and_winding(side):
    mesh = flat_patch(3, 3)
    out = {
        Side.TOP: [0, 1, 0],
        Side.BOTTOM: [0, -1, 0],
        Side.LEFT: [-1, 0, 0],
        Side.RIGHT: [1, 0, 0],
    }
    row = mesh.vertices_coords[mesh.front_vertices(side)]
    grown = mesh.extended(side, np.stack([row + out[side], row + 2 * np.array(out[side])]))
    assert (grown.vertices_coords[:9] == mesh.vertices_coords).all()
    assert (grown.faces_vertices[:4] == mesh.faces_vertices).all()
    assert len(grown.faces_vertices) == 8
    corners = grown.vertices_coords[grown.faces_vertices]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert (normal == [0, 0, 2]).all()
    placed = grown.vertices_coords[grown.grid]
    assert (np.diff(placed[..., 0], axis=1) == 1).all()
    assert (np.diff(placed[..., 1], axis=0) == 1).all()


def test_edges_of_a_patch_satisfy_euler():
    mesh = flat_patch(4, 5)
    edges = mesh.edges
    assert len(mesh.vertices_coords) - len(edges.edges_vertices) + len(mesh.faces_vertices) == 1
    assert (edges.edges_faces[:, 1] < 0).sum() == 2 * (3 + 4)
    # the first face has the edge in its own direction, the second against it
    for (a, b), (first, second) in zip(edges.edges_vertices, edges.edges_faces, strict=True):
        for face, (u, v) in ((first, (a, b)), (second, (b, a))):
            if face >= 0:
                ring = mesh.faces_vertices[face].tolist()
                assert ring[(ring.index(u) + 1) % 4] == v


def test_edges_of_mixed_polygons():
    edges = edges_of(np.array([0, 1, 2, 2, 1, 3, 4, 5]), np.array([0, 3, 8]))
    assert edges.edges_vertices.tolist() == [[0, 1], [1, 2], [2, 0], [1, 3], [3, 4], [4, 5], [5, 2]]
    assert edges.edges_faces[1].tolist() == [0, 1]


def test_an_edge_with_three_faces_and_a_face_wound_backwards_are_refused():
    with pytest.raises(InvalidValue, match="belongs to 3 faces"):
        edges_of(np.array([0, 1, 2, 1, 0, 3, 0, 1, 4]), np.array([0, 3, 6, 9]))
    with pytest.raises(InvalidValue, match="in the same direction"):
        edges_of(np.array([0, 1, 2, 0, 1, 3]), np.array([0, 3, 6]))


@given(patches())
def test_interior_vertices_are_those_off_the_boundary_edges(mesh):
    sides = mesh.edges.edges_vertices[mesh.edges.edges_faces[:, 1] < 0]
    expected = np.ones(len(mesh.vertices_coords), bool)
    expected[sides] = False
    assert (interior_vertices(mesh.faces_vertices, len(expected)) == expected).all()


def test_boundary_loops_wind_with_the_faces_on_their_left_and_find_holes():
    mesh = flat_patch(4, 4)
    (loop,) = boundary_loops(mesh.edges)
    assert len(loop) == 12
    ring = mesh.vertices_coords[loop]
    area = np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - np.roll(ring[:, 0], -1) * ring[:, 1]) / 2
    assert area == pytest.approx(9)
    kept = np.delete(mesh.faces_vertices, 4, axis=0)  # the middle face
    loops = boundary_loops(edges_of(kept.ravel(), np.arange(9) * 4))
    assert [len(loop) for loop in loops] == [12, 4]


def test_a_boundary_that_touches_itself_is_refused():
    kept = flat_patch(3, 3).faces_vertices[[0, 3]]  # two faces that share one vertex
    with pytest.raises(InvalidValue, match="vertex 4"):
        boundary_loops(edges_of(kept.ravel(), np.arange(3) * 4))


@pytest.mark.parametrize(
    "rows",
    [
        np.zeros((2, 2, 3)),
        np.zeros((2, 3)),
        np.full((2, 3, 3), np.nan),
        np.full((2, 3, 3), 1e60),
        np.zeros((2, 3, 3), complex),
        np.zeros((0, 3, 3)),
        [[[0, 0, 0], [1, 1, 0]], [[0, 0, 0]]],
        "rows",
        None,
    ],
)
def test_bad_rows_are_refused(rows):
    with pytest.raises(InvalidValue):
        QuadMesh.from_rows(rows)


@pytest.mark.parametrize("rows", [np.zeros((2, 4, 3)), np.zeros((3, 3)), np.zeros((1, 3, 2))])
def test_rows_to_grow_have_a_point_for_each_vertex_of_the_side(rows):
    with pytest.raises(InvalidValue, match=r"shape \(n, 3, 3\)"):
        flat_patch(3, 3).extended(Side.TOP, rows)


def test_vertices_without_faces_are_not_interior():
    mesh = flat_patch(3, 3)
    inside = interior_vertices(mesh.faces_vertices, 12)
    assert np.flatnonzero(inside).tolist() == [4]
