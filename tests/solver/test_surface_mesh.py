"""Topology of triangle meshes."""

import numpy as np
import pytest
import surface_meshes as made
import trimesh

from solver.errors import InvalidState, InvalidValue
from solver.targets.surface_mesh import MeshKind, SurfaceMesh


def ball():
    mesh = trimesh.creation.icosphere(subdivisions=2)
    return np.array(mesh.vertices), np.array(mesh.faces)


def holed_torus():
    coords, faces = made.torus()
    return made.packed(coords, faces[1:])


@pytest.mark.parametrize(
    ("arrays", "kind", "loops", "genus", "orientable"),
    [
        (made.cap(np.pi / 2), MeshKind.DISC, 1, 0, True),
        (made.grid(lambda u, v: (u, v, u * v)), MeshKind.DISC, 1, 0, True),
        (made.vase(), MeshKind.RING, 2, 0, True),
        (made.dome_with_holes(), MeshKind.DISC_WITH_HOLES, 4, 0, True),
        (ball(), MeshKind.SPHERE, 0, 0, True),
        (made.torus(), MeshKind.TORUS, 0, 1, True),
        (made.moebius(), MeshKind.MOEBIUS, 1, 1, False),
        (holed_torus(), MeshKind.OTHER, 1, 1, True),
    ],
)
def test_kinds(arrays, kind, loops, genus, orientable):
    mesh = SurfaceMesh.of(*arrays)
    assert mesh.kind is kind
    assert len(mesh.boundary_loops) == loops
    assert mesh.genus == genus
    assert mesh.orientable is orientable
    handles = 2 * genus if orientable else genus
    assert mesh.euler_characteristic == 2 - handles - loops


def test_loops_run_with_the_faces_on_their_left_and_the_longest_comes_first():
    mesh = made.mesh_of(made.dome_with_holes())
    lengths = [mesh.loop_length(loop) for loop in mesh.boundary_loops]
    assert lengths == sorted(lengths, reverse=True)
    first, *holes = mesh.boundary_loops

    def turned(loop):
        x, y = mesh.vertices_coords[loop, :2].T
        return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2

    assert turned(first) == pytest.approx(4.0)
    assert all(turned(hole) < 0 for hole in holes)
    rim = {tuple(pair) for pair in mesh.edges_vertices[mesh.rim_edges].tolist()}
    walked = {
        tuple(sorted(pair))
        for loop in mesh.boundary_loops
        for pair in zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True)
    }
    assert walked == rim


def test_edges_know_their_faces():
    mesh = made.mesh_of(made.vase(6, 3))
    for edge, (ends, faces) in enumerate(zip(mesh.edges_vertices, mesh.edges_faces, strict=True)):
        beside = [f for f in range(len(mesh.faces_vertices)) if edge in mesh.faces_edges[f]]
        assert sorted(f for f in faces if f >= 0) == beside
        assert all(set(ends) <= set(mesh.faces_vertices[f]) for f in beside)


SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 2, 1], [3, 1, 1]])


@pytest.mark.parametrize(
    ("faces", "says"),
    [
        ([[0, 1, 2], [0, 3, 2]], "wound against"),
        ([[0, 1, 2], [3, 4, 5]], "several pieces"),
        ([[0, 1, 2], [0, 2, 3], [2, 0, 4]], "has 3 faces"),
        ([[0, 1, 2], [0, 2, 3], [0, 0, 1]], "twice"),
    ],
)
def test_what_is_no_surface_is_refused(faces, says):
    coords, numbers = made.packed(SQUARE, np.array(faces))
    with pytest.raises(InvalidState, match=says):
        SurfaceMesh.of(coords, numbers)


def test_cones_that_touch_at_their_tips_are_refused():
    ring = np.column_stack([np.cos(np.arange(6)), np.sin(np.arange(6)), np.ones(6)])
    coords = np.concatenate([[[0.0, 0, 0]], ring, -ring])
    up = [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)]
    down = [[0, 7 + k, 7 + (k + 1) % 6] for k in range(6)]
    join = [[1, 2, 7]]
    with pytest.raises(InvalidState):
        SurfaceMesh.of(coords, np.array(up + down + join))
    coords, faces = made.packed(coords, np.array(up))
    assert SurfaceMesh.of(coords, faces).kind is MeshKind.DISC


def test_wrong_arrays_are_refused():
    with pytest.raises(InvalidValue, match="faces_vertices"):
        SurfaceMesh.of(SQUARE, np.array([[0, 1, 2, 3]]))
    with pytest.raises(InvalidValue, match="from 0 to 5"):
        SurfaceMesh.of(SQUARE, np.array([[0, 1, 6]]))
    with pytest.raises(InvalidState, match="NaN"):
        SurfaceMesh.of(SQUARE * np.nan, np.array([[0, 1, 2]]))
    with pytest.raises(InvalidState, match="vertex 3 belongs to no face"):
        SurfaceMesh.of(SQUARE, np.array([[0, 1, 2]]))


def test_what_it_is_made_from_is_not_changed():
    coords, faces = made.vase()
    before = coords.copy(), faces.copy()
    mesh = SurfaceMesh.of(coords, faces)
    coords[0] = 7.0
    assert np.array_equal(mesh.vertices_coords, before[0])
    with pytest.raises(ValueError, match="read-only"):
        mesh.faces_vertices[0] = 0
