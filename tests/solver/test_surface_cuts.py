"""Halves and openings of surfaces: area and winding kept, kinds as topology has them."""

import numpy as np
import pytest
import trimesh
from surface_meshes import cap, grid, mesh_of, moebius, torus, vase

from solver.surface_cover import covered, surface_samples
from solver.surface_cuts import halves, opened
from solver.targets.mesh_target import MeshTarget
from solver.targets.surface_mesh import MeshKind


def ball(subdivisions=2):
    made = trimesh.creation.icosphere(subdivisions)
    return np.array(made.vertices), np.array(made.faces)


@pytest.mark.parametrize(
    ("arrays", "kind"),
    [
        (ball(), MeshKind.DISC),
        (cap(1.0, 8, 24), MeshKind.DISC),
        (vase(24, 12), MeshKind.RING),
        (torus(24, 12), MeshKind.RING),
        (moebius(48, 4), MeshKind.DISC),
    ],
    ids=["ball", "cap", "vase", "torus", "moebius"],
)
def test_halves_share_the_area_evenly(arrays, kind):
    mesh = mesh_of(arrays)
    parts = halves(mesh)
    assert [part.kind for part in parts] == [kind, kind]
    assert sum(part.area for part in parts) == pytest.approx(mesh.area, rel=1e-3)
    assert parts[0].area >= parts[1].area > 0.49 * mesh.area
    again = halves(mesh)
    for part, same in zip(parts, again, strict=True):
        np.testing.assert_array_equal(part.vertices_coords, same.vertices_coords)
        np.testing.assert_array_equal(part.faces_vertices, same.faces_vertices)


def test_halves_of_a_ball_are_wound_outwards_and_end_in_a_plane():
    for part in halves(mesh_of(ball())):
        middle = part.vertices_coords[part.faces_vertices].mean(axis=1)
        assert ((part.doubled_areas * middle).sum(axis=1) > 0).all()
        (loop,) = part.boundary_loops
        rim = part.vertices_coords[loop]
        assert np.linalg.svd(rim - rim.mean(axis=0))[1][-1] < 1e-12


def test_the_cut_of_a_symmetric_surface_is_not_left_to_rounding():
    coords, faces = ball()
    turned = np.roll(coords, 1, axis=1)  # by 120 degrees, onto itself
    for arrays in ((coords, faces), (turned, faces), (coords * 3 + 1e-9, faces)):
        part = halves(mesh_of(arrays))[0]
        rim = part.vertices_coords[part.boundary_loops[0]]
        assert np.ptp(rim, axis=0)[2] < 1e-12


def test_a_long_strip_is_halved_across():
    mesh = mesh_of(grid(lambda u, v: (5 * u, v, 0 * u), 20, 4))
    for part in halves(mesh):
        assert part.area == pytest.approx(mesh.area / 2, rel=1e-3)
        assert np.ptp(part.vertices_coords, axis=0)[:2] == pytest.approx([5, 2], abs=0.3)


def test_a_torus_is_opened_to_a_tube_along_its_shortest_line():
    mesh = mesh_of(torus(36, 24))
    out = opened(mesh)
    assert out.kind is MeshKind.RING
    assert out.area == pytest.approx(mesh.area, rel=1e-3)
    for loop in out.boundary_loops:
        rim = out.vertices_coords[loop]
        girth = np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).sum()
        assert girth == pytest.approx(2 * np.pi * 0.8, rel=0.02)


def test_a_moebius_band_is_opened_to_a_strip():
    mesh = mesh_of(moebius(48, 4))
    out = opened(mesh)
    assert out.kind is MeshKind.DISC
    assert out.area == pytest.approx(mesh.area, rel=1e-3)
    assert out.wound.all()


@pytest.mark.parametrize("arrays", [cap(1.0, 4, 12), vase(24, 12), ball(1)])
def test_what_is_open_or_a_sphere_is_not_opened(arrays):
    assert opened(mesh_of(arrays)) is None


def test_samples_are_spread_by_area_and_the_same_each_time():
    mesh = mesh_of(grid(lambda u, v: (np.exp(u), v, 0 * u), 12, 3))
    face, weights = surface_samples(mesh, 5000)
    for first, again in zip((face, weights), surface_samples(mesh, 5000), strict=True):
        np.testing.assert_array_equal(first, again)
    assert weights.min() >= 0
    assert weights.sum(axis=1) == pytest.approx(1)
    area = np.linalg.norm(mesh.doubled_areas, axis=1) / 2
    count = np.bincount(face, minlength=len(area))
    assert np.abs(count - 5000 * area / mesh.area).max() <= 1
    # their mean over the plane is its centroid
    places = (weights[..., None] * mesh.vertices_coords[mesh.faces_vertices[face]]).sum(axis=1)
    middle = mesh.vertices_coords[mesh.faces_vertices].mean(axis=1)
    centroid = (area[:, None] * middle).sum(axis=0) / area.sum()
    assert places.mean(axis=0) == pytest.approx(centroid, abs=2e-3)


def quad(low, high, z):
    coords = np.array([[low, -1, z], [high, -1, z], [high, 1, z], [low, 1, z]], float)
    return coords, np.array([[0, 1, 2, 3]])


@pytest.mark.parametrize("z", [0.2, -0.2])
def test_half_a_plane_under_a_sheet_is_half_covered(z):
    target = MeshTarget(mesh_of(grid(lambda u, v: (u, v, 0 * u), 8, 8)))
    assert covered(target, [quad(-1, 0, z)], 0.3).mean() == pytest.approx(0.5, abs=2e-3)
    assert not covered(target, [quad(-1, 0, z)], 0.1).any()
    assert covered(target, [quad(-1, 0, z), quad(0, 1, -z)], 0.3).mean() > 0.999
    assert covered(target, [quad(-1, 0, z), quad(-0.5, 0.5, z)], 0.3).mean() == pytest.approx(
        0.75, abs=2e-3
    )


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e6])
def test_what_is_covered_is_the_same_in_any_unit(unit):
    target = MeshTarget(mesh_of(grid(lambda u, v: (unit * u, unit * v, 0 * u), 8, 8)))
    coords, faces = quad(-1, 0, 0.2)
    assert covered(target, [(unit * coords, faces)], 0.3 * unit).mean() == pytest.approx(
        0.5, abs=2e-3
    )
