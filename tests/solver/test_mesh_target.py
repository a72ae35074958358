"""Triangle meshes as smooth targets."""

import numpy as np
import pytest
import surface_meshes as made
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from solver.errors import InvalidState, InvalidValue
from solver.targets.mesh_target import MeshTarget

seeds = st.integers(0, 2**32 - 1)


def asked(target, points):
    return target.distance(points, target.unknown(len(points)))


def sphere(level):
    mesh = trimesh.creation.icosphere(subdivisions=level)
    return MeshTarget(made.mesh_of((np.array(mesh.vertices), np.array(mesh.faces))))


def flat(height=lambda u, v: 0 * u, n=8):
    """A plate and its map: u and v are x and y."""
    mesh = made.mesh_of(made.grid(lambda u, v: (u, v, height(u, v)), n, n))
    return MeshTarget(mesh, mesh.vertices_coords[mesh.faces_vertices][..., :2])


@given(seed=seeds)
def test_points_are_their_places_and_distances_along_normals_of_the_rim(seed):
    rng = np.random.default_rng(seed)
    target = flat(lambda u, v: 0.3 * u * u - 0.2 * u * v)
    points = rng.uniform(-2, 2, (40, 3))
    distance, normal, places = asked(target, points)
    rim = target.on_rim(places)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1)
    assert target.normal(places) == pytest.approx(normal)
    assert target.point(places)[rim] == pytest.approx((points - distance[:, None] * normal)[rim])
    off = points - target.mesh_point(places)
    assert np.abs(distance)[~rim] == pytest.approx(np.linalg.norm(off, axis=1)[~rim])
    assert distance[rim] == pytest.approx((off * normal).sum(axis=1)[rim])
    assert np.array_equal(target.inside(places), ~rim)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_plate_goes_on_as_its_plane(scale):
    plate = flat()
    mesh = made.mesh_of((scale * plate.mesh.vertices_coords, plate.mesh.faces_vertices))
    target = MeshTarget(mesh)
    points = scale * np.array([[0.3, 0.2, 0.5], [4.0, 0.1, -0.25], [3.0, 3.0, 0.0], [1, 1, 2.0]])
    distance, normal, places = asked(target, points)
    assert distance == pytest.approx(scale * np.array([0.5, -0.25, 0.0, 2.0]), abs=1e-15 * scale)
    assert normal == pytest.approx(np.tile([0.0, 0, 1], (4, 1)))
    assert target.on_rim(places).tolist() == [False, True, True, True]
    assert target.inside(places).tolist() == [True, False, False, True]


def test_distances_and_normals_of_a_sphere_converge():
    rng = np.random.default_rng(5)
    points = rng.normal(size=(300, 3))
    radius = np.linalg.norm(points, axis=1)
    points *= (rng.uniform(0.7, 1.4, 300) / radius)[:, None]
    radius = np.linalg.norm(points, axis=1)
    gaps, turns = [], []
    for level in (2, 3, 4):
        distance, normal, _ = asked(sphere(level), points)
        gaps.append(np.abs(distance - (radius - 1)).max())
        turns.append(np.abs(normal - points / radius[:, None]).max())
    assert gaps[1] < gaps[0] / 3.5
    assert gaps[2] < gaps[1] / 3.5
    assert turns[2] < turns[0] / 3  # of first order, by the distance over the radius


def test_signs_are_right_at_a_sharp_needle():
    """A tetrahedron, wholly known by four half spaces."""
    rng = np.random.default_rng(1)
    coords = rng.normal(size=(4, 3)) * [1, 1, 0.1]
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    if np.linalg.det(coords[1:] - coords[0]) < 0:
        faces = faces[:, ::-1]
    target = MeshTarget(made.mesh_of((coords, faces)))
    points = coords.mean(axis=0) + rng.normal(size=(2000, 3)) * [0.5, 0.5, 0.05]
    first = coords[faces[:, 0]]
    normals = np.cross(coords[faces[:, 1]] - first, coords[faces[:, 2]] - first)
    inside = (((points[:, None] - first) * normals).sum(axis=2) < 0).all(axis=1)
    distance, _, _ = asked(target, points)
    assert np.array_equal(distance < 0, inside)
    assert 10 < inside.sum() < 1990


def test_distances_are_continuous_across_the_rim():
    target = MeshTarget(made.mesh_of(made.cap(1.0, 40, 120)))
    angle = np.linspace(0.9, 1.1, 801)
    points = 1.1 * np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])
    distance, _, places = asked(target, points)
    rim = target.on_rim(places)
    assert rim.sum() == pytest.approx(400, abs=5)
    assert distance[~rim] == pytest.approx(0.1, abs=1e-3)
    # beyond it, that to the tangent cone
    assert distance[rim] == pytest.approx(1.1 * np.cos(angle - 1.0)[rim] - 1, abs=2e-3)
    assert np.abs(np.diff(distance)).max() < 2e-3


def test_the_normal_is_the_slope_of_the_distance():
    target = MeshTarget(made.mesh_of(made.vase(192, 96)))
    rng = np.random.default_rng(2)
    z = rng.uniform(-1, 1, 200)
    t = rng.uniform(0, 2 * np.pi, 200)
    out = 0.7 + 0.25 * np.sin(2.2 * z + 0.4) + rng.uniform(-0.1, 0.1, 200)
    points = np.column_stack([out * np.cos(t), out * np.sin(t), z])
    _, normal, _ = asked(target, points)
    step = 0.02
    slope = np.stack(
        [
            (asked(target, points + step * d)[0] - asked(target, points - step * d)[0]) / (2 * step)
            for d in np.eye(3)
        ],
        axis=1,
    )
    assert np.abs(slope - normal).max() < 0.02


def test_a_moebius_band_keeps_the_side_of_the_guess_and_turns_it_once_around():
    target = MeshTarget(made.mesh_of(made.moebius()))
    height = 0.05
    angle = np.linspace(0, 2 * np.pi, 201) + 0.5
    middle = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    # tangents of the band at its middle line are along it and (cos u/2 er + sin u/2 ez)
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    up = np.array([0.0, 0, 1])
    normal = np.cos(angle / 2)[:, None] * up - np.sin(angle / 2)[:, None] * radial
    points = middle + height * normal
    place = target.unknown(1)
    distance, _, place = target.distance(points[:1], place)
    start = float(distance[0])
    assert abs(start) == pytest.approx(height, rel=1e-2)
    sides = set()
    for point, n in zip(points, normal, strict=True):
        distance, gradient, place = target.distance(point[None], place)
        assert distance[0] == pytest.approx(start, rel=2e-2)
        assert gradient[0] @ n * np.sign(start) > 0.99
        sides.add(float(place[0, 8]))
    assert sides == {1.0, -1.0}
    # at the same point of space, on the other side now
    again, _, _ = target.distance(points[:1], place)
    assert again[0] == pytest.approx(-start, rel=1e-6)


@given(seed=seeds)
def test_maps_and_places_are_inverse(seed):
    rng = np.random.default_rng(seed)
    target = flat(lambda u, v: 0.4 * np.sin(2 * u) + 0.1 * v)
    uv = rng.uniform(-1.5, 1.5, (50, 2))
    places = target.places(uv)
    assert np.array_equal(places[:, :2], uv)
    inside = np.abs(uv).max(axis=1) <= 1
    assert np.array_equal(target.inside(places), inside)
    point = target.point(places)
    assert point[inside, :2] == pytest.approx(uv[inside])
    distance, _, again = asked(target, point)
    assert distance[inside] == pytest.approx(0, abs=1e-12)
    assert again[inside, :2] == pytest.approx(uv[inside], abs=1e-9)


def test_beyond_the_map_a_plate_goes_on_straight():
    target = flat(lambda u, v: 0.5 * u)
    uv = np.array([[1.7, 0.3], [-2.0, 1.5], [0.2, -3.0]])
    point = target.point(target.places(uv))
    assert point == pytest.approx(np.column_stack([uv, 0.5 * uv[:, 0]]))
    _, _, places = asked(target, point)
    assert places[:, :2] == pytest.approx(uv)


def test_misuse_is_refused_and_what_is_not_finite_stays_so():
    target = sphere(1)
    with pytest.raises(InvalidState, match="no map"):
        target.places(np.zeros((1, 2)))
    with pytest.raises(InvalidValue, match="corners_uv"):
        MeshTarget(target.mesh, np.zeros((3, 3, 2)))
    distance, normal, places = asked(target, np.array([[np.nan, 0, 0], [0, 0, 2.0]]))
    assert np.isnan(distance[0])
    assert np.isnan(normal[0]).all()
    assert np.isnan(places[0]).all()
    assert distance[1] == pytest.approx(1.0, abs=0.1)
