"""Maps of surfaces: isometric where the surface can be unrolled, never folded over elsewhere."""

import numpy as np
import pytest
from surface_meshes import cap, dome_with_holes, grid, mesh_of, moebius, torus, vase

from solver import InvalidState
from solver.surface_maps import cylinder_map, disc_map, principal_turn
from solver.targets.surface_mesh import MeshKind


def stretches(mesh, flat):
    """Singular values of the map in each triangle, largest first, and its signed area ratio."""
    corners = mesh.vertices_coords[mesh.faces_vertices]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    x = a / np.linalg.norm(a, axis=1)[:, None]
    normal = np.cross(a, b)
    y = np.cross(normal / np.linalg.norm(normal, axis=1)[:, None], x)
    own = np.stack([[(a * x).sum(1), (b * x).sum(1)], [(a * y).sum(1), (b * y).sum(1)]])
    sides = np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=-1)
    change = sides @ np.linalg.inv(own.transpose(2, 0, 1))
    return np.linalg.svd(change, compute_uv=False), np.linalg.det(change)


def tube(around=36, along=12, height=2.0):
    def f(u, v):
        return np.cos(u), np.sin(u), v

    return mesh_of(grid(f, around, along, u=(0, 2 * np.pi), v=(0, height), around=(True, False)))


def icosahedron():
    g = (1 + np.sqrt(5)) / 2
    corners = np.array([(0, s, t * g) for s in (-1, 1) for t in (-1, 1)], float)
    corners = np.concatenate([np.roll(corners, k, axis=1) for k in range(3)])
    far = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    near = np.isclose(far, 2)
    faces = [
        (i, j, k) if np.linalg.det(corners[[i, j, k]]) > 0 else (i, k, j)
        for i in range(12)
        for j in range(i)
        for k in range(j)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    return corners, np.array(faces)


@pytest.mark.parametrize(
    "f",
    [
        lambda u, v: (u, v, 0 * u),
        lambda u, v: (np.cos(u), np.sin(u), v),
        lambda u, v: ((v + 2) * np.cos(u), (v + 2) * np.sin(u), v),
    ],
    ids=["plane", "cylinder", "cone"],
)
def test_what_can_be_unrolled_is_mapped_without_stretch(f):
    mesh = mesh_of(grid(f, 24, 12))
    both, turned = stretches(mesh, disc_map(mesh))
    assert both == pytest.approx(1, abs=1e-6)
    assert turned == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("arrays", [cap(np.pi / 2), dome_with_holes()], ids=["hemisphere", "holes"])
def test_domes_keep_every_winding_and_are_stretched_little(arrays):
    mesh = mesh_of(arrays)
    both, turned = stretches(mesh, disc_map(mesh))
    assert turned.min() > 0
    assert 0.6 < both.min() <= both.max() < 1.5


def test_the_map_of_a_disc_is_one_of_its_vertices():
    """All faces agree where each vertex lies, so that neighbours stay neighbours."""
    mesh = mesh_of(cap(1.2, 8, 24))
    flat = disc_map(mesh)
    first = np.zeros((len(mesh.vertices_coords), 2))
    first[mesh.faces_vertices] = flat
    np.testing.assert_array_equal(first[mesh.faces_vertices], flat)


def test_the_map_keeps_up_with_the_size_of_the_mesh():
    coords, faces = cap(1.2, 8, 24)
    small, large = (disc_map(mesh_of((size * coords, faces))) for size in (1.0, 1024.0))
    assert large / 1024 == pytest.approx(small, abs=1e-9)


@pytest.mark.parametrize("along", [3, 12, 50])
def test_a_tube_is_unrolled_exactly_however_few_its_rows(along):
    mesh = tube(36, along)
    flat, period = cylinder_map(mesh)
    both, turned = stretches(mesh, flat)
    assert both == pytest.approx(1, abs=1e-6)
    assert turned.min() > 0
    assert period == pytest.approx(72 * np.sin(np.pi / 36), rel=1e-9)


@pytest.mark.parametrize("mesh", [tube(), mesh_of(vase())], ids=["tube", "vase"])
def test_a_cylinder_map_closes_and_has_its_rims_at_its_ends(mesh):
    flat, period = cylinder_map(mesh)
    assert stretches(mesh, flat)[1].min() > 0
    high = flat[..., 1].max()
    of_vertex = np.zeros(len(mesh.vertices_coords))
    of_vertex[mesh.faces_vertices] = flat[..., 1]
    assert flat[..., 1] == pytest.approx(of_vertex[mesh.faces_vertices], abs=1e-12)
    ends = sorted(float(np.ptp(of_vertex[loop])) for loop in mesh.boundary_loops)
    assert ends == [0, 0]
    assert {float(of_vertex[loop[0]]) for loop in mesh.boundary_loops} == {0.0, float(high)}
    # faces agree on their common corners but for whole turns
    around = np.zeros(len(mesh.vertices_coords))
    around[mesh.faces_vertices] = flat[..., 0]
    turns = (flat[..., 0] - around[mesh.faces_vertices]) / period
    assert turns == pytest.approx(np.rint(turns), abs=1e-9)
    assert np.rint(turns).any()
    assert (flat[..., 0].mean(axis=1) >= 0).all()
    assert (flat[..., 0].mean(axis=1) < period).all()
    assert np.ptp(flat[..., 0], axis=1).max() < period / 2


def test_girth_times_length_is_the_area_of_a_vase():
    mesh = mesh_of(vase())
    flat, period = cylinder_map(mesh)
    assert period * flat[..., 1].max() == pytest.approx(mesh.area, rel=1e-3)


def test_the_longest_extent_of_a_map_is_found():
    turn = np.radians(25)
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    coords, faces = grid(lambda u, v: (3 * u, v, 0 * u), 6, 6)
    assert principal_turn((coords[:, :2] @ axes)[faces]) == pytest.approx(turn, abs=1e-12)
    square, faces = grid(lambda u, v: (u, v, 0 * u), 6, 6)
    assert principal_turn(square[:, :2][faces]) == 0


@pytest.mark.parametrize(
    ("make_map", "arrays", "text"),
    [
        (disc_map, icosahedron(), "sphere, not a disc"),
        (disc_map, torus(12, 8), "torus, not a disc"),
        (disc_map, moebius(24, 4), "moebius, not a disc"),
        (cylinder_map, cap(1.0, 4, 12), "disc, not a ring"),
    ],
)
def test_other_surfaces_are_refused(make_map, arrays, text):
    with pytest.raises(InvalidState, match=text):
        make_map(mesh_of(arrays))


def test_a_ring_is_laid_flat_where_it_can_be():
    mesh = mesh_of(grid(
        lambda u, v: ((2 + v) * np.cos(u), (2 + v) * np.sin(u), 0 * u),
        36, 4, u=(0, 2 * np.pi), around=(True, False),
    ))  # fmt: skip
    assert mesh.kind is MeshKind.RING
    assert stretches(mesh, disc_map(mesh))[0] == pytest.approx(1, abs=1e-6)
