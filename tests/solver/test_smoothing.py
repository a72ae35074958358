"""Noisy meshes smoothed: what stays, what goes, and how much noise there is."""

import numpy as np
import pytest
import surface_meshes as made
import trimesh

from solver.errors import InvalidValue
from solver.targets.mesh_target import MeshTarget
from solver.targets.smoothing import noise_level, smoothed, smoothing_length
from solver.targets.surface_mesh import SurfaceMesh
from solver.targets.triangles import TriangleTree


def sphere(level=3, radius=1.0):
    mesh = trimesh.creation.icosphere(subdivisions=level, radius=radius)
    return made.mesh_of((np.array(mesh.vertices), np.array(mesh.faces)))


def bump(n=60):
    return made.grid(lambda u, v: (u, v, 0.4 * np.exp(-3 * (u * u + v * v))), n, n)


def with_noise(arrays, noise, seed=0):
    coords, faces = arrays
    moved = coords + noise * np.random.default_rng(seed).normal(size=coords.shape)
    return made.mesh_of((moved, faces))


@pytest.mark.parametrize(("length", "mean", "most"), [(0.2, 1e-6, 1e-4), (1.0, 2e-4, 3e-3)])
def test_a_smooth_sphere_is_not_smoothed_away(length, mean, most):
    radius = np.linalg.norm(smoothed(sphere(), length).mesh.vertices_coords, axis=1)
    assert abs(radius.mean() - 1) < mean
    assert np.abs(radius - 1).max() < most


@pytest.mark.parametrize("length", [0.25, 0.5])
def test_a_plane_stays_one_and_its_rim_where_it_was(length):
    mesh = made.mesh_of(made.grid(lambda u, v: (u, v, 0.3 * u - 0.1 * v), 40, 40))
    x, y, z = smoothed(mesh, length).mesh.vertices_coords.T
    assert z == pytest.approx(0.3 * x - 0.1 * y, abs=1e-12)
    moved = np.hypot(x - mesh.vertices_coords[:, 0], y - mesh.vertices_coords[:, 1])
    assert moved.max() < 0.1 * length  # at its corners
    beside = np.abs(mesh.vertices_coords[:, :2]).min(axis=1) < 1 - 1.2 * length
    assert moved[beside].max() < 0.005 * length


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_waves_keep_the_stated_part_of_their_height(ratio):
    length = 0.4
    wave = ratio * length

    def f(u, v):
        return u, v, 1e-3 * np.cos(2 * np.pi * u / wave)

    mesh = made.mesh_of(made.grid(f, 80, 40, u=(-1.6, 1.6)))
    after = smoothed(mesh, length).mesh.vertices_coords
    inner = np.abs(mesh.vertices_coords[:, :2]).max(axis=1) < 0.8
    before = mesh.vertices_coords[inner, 2]
    kept = float(after[inner, 2] @ before / (before @ before))
    left = 1 - (1 - 1 / (1 + (1 + np.sqrt(2)) / ratio**4)) ** 2
    assert {0.5: 0.05, 1.0: 0.5, 2.0: 0.98}[ratio] == pytest.approx(left, abs=0.005)
    assert kept == pytest.approx(left, abs=0.03)


@pytest.mark.parametrize(
    "arrays", [bump(), made.vase(96, 48), made.moebius(160, 16)], ids=["bump", "vase", "moebius"]
)
def test_noise_goes_and_the_surface_stays(arrays):
    noisy = with_noise(arrays, 0.01)
    done = smoothed(noisy, 0.25)
    tree = TriangleTree.of(*arrays)
    before = tree.nearest(noisy.vertices_coords)[0]
    after = tree.nearest(done.mesh.vertices_coords)[0]
    assert after.mean() < before.mean() / 2.5
    assert done.mesh.kind is noisy.kind
    own = TriangleTree.of(noisy.vertices_coords, noisy.faces_vertices)
    assert np.array_equal(done.distances, own.nearest(done.mesh.vertices_coords)[0])
    assert done.distances.max() < 0.05


def test_normals_are_those_of_the_surface_again():
    coords, faces = bump()
    true, noisy = MeshTarget(made.mesh_of((coords, faces))), with_noise((coords, faces), 0.01)
    at = coords[np.abs(coords[:, :2]).max(axis=1) < 0.9] + [0, 0, 0.05]

    def off(target):
        turned = [t.distance(at, t.unknown(len(at)))[1] for t in (target, true)]
        return np.linalg.norm(turned[0] - turned[1], axis=1).mean()

    assert off(MeshTarget(smoothed(noisy, 0.25).mesh)) < off(MeshTarget(noisy)) / 3


@pytest.mark.parametrize("noise", [0.003, 0.01, 0.03])
def test_the_level_of_noise_is_found(noise):
    for arrays in (bump(), made.cap(1.5, 40, 120), made.torus(96, 48), made.moebius(160, 16)):
        assert noise_level(with_noise(arrays, noise)) == pytest.approx(noise, rel=0.25)


def test_surfaces_without_noise_have_none():
    creased = made.grid(lambda u, v: (u, v, 0.6 * (1 - np.maximum(abs(u), abs(v)))), 90, 90)
    for arrays in (bump(), made.vase(96, 48), creased, made.torus(96, 48)):
        mesh = made.mesh_of(arrays)
        assert noise_level(mesh) < 3e-4
        assert smoothing_length(mesh, 0.1) == 0
    assert smoothing_length(sphere(), 0.1) == 0


def test_the_length_that_is_chosen_helps():
    arrays = bump()
    noisy = with_noise(arrays, 0.02)
    length = smoothing_length(noisy, 0.1)
    assert 0.1 < length < 0.4
    tree = TriangleTree.of(*arrays)
    after = tree.nearest(smoothed(noisy, length).mesh.vertices_coords)[0]
    assert after.mean() < 0.005  # 5 % of the cell


@pytest.mark.parametrize("scale", [1e-9, 1e6])
def test_all_of_it_scales(scale):
    mesh = with_noise(bump(30), 0.02)
    other = SurfaceMesh.of(scale * mesh.vertices_coords + 3 * scale, mesh.faces_vertices)
    one, two = smoothed(mesh, 0.3), smoothed(other, 0.3 * scale)
    assert (two.mesh.vertices_coords / scale - 3) == pytest.approx(
        one.mesh.vertices_coords, abs=1e-9
    )
    assert noise_level(other) == pytest.approx(scale * noise_level(mesh), rel=1e-6)
    assert smoothing_length(other, 0.1 * scale) == pytest.approx(
        scale * smoothing_length(mesh, 0.1), rel=1e-6
    )


def test_lengths_are_positive():
    with pytest.raises(InvalidValue, match="length"):
        smoothed(sphere(), 0.0)
    with pytest.raises(InvalidValue, match="cell"):
        smoothing_length(sphere(), -1.0)
