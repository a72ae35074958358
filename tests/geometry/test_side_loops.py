"""Rings of the sides of bodies: holes, several parts in a plane, rings that touch themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import Manifold
from solid_patterns import folded_pair
from thick_sheets import miura_pattern, thick

from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of
from fab.geometry.brep import solids
from fab.geometry.side_loops import side_loops
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from solver import InvalidValue
from solver.polygons import next_corner
from solver.vectors import cross


def flat_sided(solid: Manifold) -> TriangleMesh:
    """A solid whose triangles have one number for each plane, also where it has several sides."""
    mesh = solid.to_mesh64()
    coords = np.array(mesh.vert_properties[:, :3], float)
    triangles = np.array(mesh.tri_verts, np.int64)
    a, b, c = coords[triangles].swapaxes(0, 1)
    normal = cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    planes = np.round(np.column_stack([normal, (normal * a).sum(axis=1)]), 6) + 0.0
    return TriangleMesh(
        coords, triangles, np.unique(planes, axis=0, return_inverse=True)[1].ravel()
    )


def box(size, place=(0.0, 0.0, 0.0)) -> Manifold:
    return Manifold.cube(size).translate(place)


def cube() -> Manifold:
    return box((4, 4, 4))


def with_pit() -> Manifold:
    """A pit that touches a corner of the top, whose ring passes that corner twice."""
    corners = np.array([[0.0, 0, 4], [3, 1, 4], [1, 3, 4], [1, 1, 2]])
    return cube() - Manifold.hull_points(corners)


SHAPES = {
    "cube": (cube, 6, 0),
    "tube": (lambda: cube() - box((1, 1, 9), (1, 1, -1)), 10, 2),
    "two tubes": (
        lambda: cube() - box((1, 1, 9), (0.5, 1, -1)) - box((1, 1, 9), (2.5, 1, -1)),
        14,
        4,
    ),
    # the top in two parts
    "groove": (lambda: cube() - box((1, 9, 9), (1.5, -1, 3)), 10, 0),
    "pit": (with_pit, 9, 0),
}


@pytest.mark.parametrize("name", SHAPES)
def test_sides_and_holes_of_known_bodies(name):
    make, sides, holes = SHAPES[name]
    solid = make()
    bodies = bodies_of([flat_sided(solid), flat_sided(cube())])
    loops = side_loops(bodies)
    first = loops.bodies == 0
    assert (loops.outer & first).sum() == sides
    assert (~loops.outer & first).sum() == holes
    assert (loops.outer & ~first).sum() == 6
    made = solids(bodies)
    assert [len(one.faces()) for one in made] == [sides, 6]
    assert all(one.is_valid for one in made)
    assert made[0].volume == pytest.approx(solid.volume(), rel=1e-12)
    assert made[1].volume == pytest.approx(64, rel=1e-12)


def test_a_ring_passes_a_corner_twice_where_a_pit_touches_it():
    loops = side_loops(bodies_of([flat_sided(with_pit())]))
    ring = max(np.split(loops.corners, loops.offsets[1:-1]), key=len)
    assert len(ring) == 7
    assert len(set(ring.tolist())) == 6


def test_corners_within_a_side_are_on_no_ring():
    mesh = flat_sided(cube())
    top = (mesh.vertices_coords[mesh.triangles, 2] == 4).all(axis=1)
    middle = len(mesh.vertices_coords)
    sides = mesh.triangles[top][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    rim = sides[~(sides[:, None, ::-1] == sides).all(axis=2).any(axis=1)]
    fan = np.column_stack([rim, np.full(len(rim), middle)])
    assert len(fan) == 4
    fanned = TriangleMesh(
        np.append(mesh.vertices_coords, [[2.0, 2, 4]], axis=0),
        np.concatenate([mesh.triangles[~top], fan]),
        np.concatenate(
            [mesh.triangles_plane[~top], np.repeat(mesh.triangles_plane[top], len(fan) // 2)]
        ),
    )
    bodies = bodies_of([fanned])
    loops = side_loops(bodies)
    assert np.diff(loops.offsets).tolist() == [4] * 6
    assert middle not in loops.corners
    (made,) = solids(bodies)
    assert made.is_valid
    assert len(made.vertices()) == 8
    assert made.volume == pytest.approx(64, rel=1e-12)


def test_panels_with_knuckles_and_holes_are_exact_solids():
    panel = PanelSettings(thickness_mm=3.2, axis="middle")
    hinge = HingeSettings(kind="knuckle", knuckle_mm=3.0, hole_mm=2.0)
    sheet, _ = thicken(folded_pair(60.0), panel, hinge)
    assert len(sheet.held) == 1
    made = solids(sheet.bodies)
    assert all(one.is_valid for one in made)
    assert [one.volume for one in made] == pytest.approx(sheet.bodies.volumes_mm3(), rel=1e-12)


@settings(max_examples=20)
@given(st.integers(1, 4), st.integers(1, 4), st.sampled_from(["bottom", "middle"]))
def test_rings_bound_the_area_of_their_triangles(columns, rows, axis):
    bodies = thick(miura_pattern(2 * columns, 2 * rows), axis).bodies
    loops = side_loops(bodies)
    ring = bodies.vertices_coords[loops.corners]
    twice = np.add.reduceat(cross(ring, ring[next_corner(loops.offsets)]), loops.offsets[:-1])
    assert twice == pytest.approx(np.linalg.norm(twice, axis=1)[:, None] * loops.normals, abs=1e-9)
    a, b, c = bodies.vertices_coords[bodies.triangles].swapaxes(0, 1)
    area = np.linalg.norm(cross(b - a, c - a), axis=1)
    total = np.bincount(bodies.triangles_body, area)
    found = np.bincount(loops.bodies, np.linalg.norm(twice, axis=1))
    assert found == pytest.approx(total, rel=1e-12)
    # each edge of a body is walked once in each direction
    after = loops.corners[next_corner(loops.offsets)]
    directed = set(zip(loops.corners.tolist(), after.tolist(), strict=True))
    assert len(directed) == len(loops.corners)
    assert directed == {(b, a) for a, b in directed}


def test_bodies_that_are_not_closed_are_refused():
    mesh = flat_sided(cube())
    open_ = TriangleMesh(mesh.vertices_coords, mesh.triangles[1:], mesh.triangles_plane[1:])
    with pytest.raises(InvalidValue, match="not between exactly two"):
        side_loops(bodies_of([open_]))
    turned = np.concatenate([mesh.triangles[:1, ::-1], mesh.triangles[1:]])
    with pytest.raises(InvalidValue, match="counterclockwise"):
        side_loops(bodies_of([TriangleMesh(mesh.vertices_coords, turned, mesh.triangles_plane)]))


def test_no_bodies_have_no_rings():
    none = np.empty((0, 3))
    start = np.zeros(1, np.int64)
    empty = Bodies(none, start, none.astype(np.int64), start, np.empty(0, np.int64))
    assert len(side_loops(empty).bodies) == 0
    assert solids(empty) == []
