"""Targets and the sheets that follow them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.development import develop
from solver import (
    InvalidValue,
    ParametricSurface,
    Status,
    SurfaceFit,
    developability,
    explicit_surface,
    planarity,
)
from solver.designs.surface_fit import SURFACES, fit_surface


def sphere(u, v):
    return np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])


SPHERE = ParametricSurface(sphere)
angles = st.floats(-1.2, 1.2)


@given(angles, angles, st.floats(-0.3, 0.3))
def test_distance_to_a_sphere_is_the_radius_less_one(u, v, height):
    point = (1 + height) * sphere(np.array([u]), np.array([v]))
    distance, normal, uv = SPHERE.distance(point, np.array([[u + 0.1, v - 0.1]]))
    assert distance == pytest.approx(height, abs=1e-12)
    assert normal == pytest.approx(point / (1 + height), abs=1e-8)
    assert uv == pytest.approx(np.array([[u, v]]), abs=1e-7)


@given(angles, angles, st.floats(0.05, 0.3), st.floats(-0.4, 0.4), st.floats(-0.4, 0.4))
def test_rays_hit_the_offset_sphere_where_the_quadratic_says(u, v, offset, du, dv):
    origin = sphere(np.array([u]), np.array([v]))
    direction = sphere(np.array([u + du]), np.array([v + dv]))
    lengths, _ = SPHERE.ray_hit(origin, direction, offset, np.array([[u, v]]))
    along = float(np.vecdot(origin, direction)[0])
    expected = -along + np.sqrt(along**2 + (1 + offset) ** 2 - 1)
    assert lengths == pytest.approx(expected, abs=1e-12)
    assert np.isnan(SPHERE.ray_hit(origin, direction, -0.2, np.array([[u, v]]))[0]).all()


def test_rays_that_miss_are_not_numbers_and_leave_the_others_alone():
    flat = explicit_surface(lambda x, _y: 0 * x)
    origins = np.zeros((3, 3))
    directions = np.array([[0.0, 0, 1], [1, 0, 0], [0, 0.6, 0.8]])
    lengths, uv = flat.ray_hit(origins, directions, 1.0, np.zeros((3, 2)))
    assert lengths[[0, 2]] == pytest.approx([1.0, 1.25])
    assert np.isnan(lengths[1])
    assert uv[2] == pytest.approx([0.0, 0.75])


@pytest.mark.parametrize("name", sorted(SURFACES))
def test_derivatives_agree_with_differences(name):
    surface = SURFACES[name]
    uv = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    plain = ParametricSurface(surface.position)
    for given_one, difference in zip(surface.tangents(uv), plain.tangents(uv), strict=True):
        assert given_one == pytest.approx(difference, abs=1e-8)


@pytest.mark.parametrize(
    ("design", "strips"),
    [
        (SurfaceFit(), 54),
        (SurfaceFit(zigzag=2.5, row_step=0.5), 76),
        (SurfaceFit(surface="cylinder", zigzag=5.0), 64),
        (SurfaceFit(surface="paraboloid", zigzag=5.0, row_step=1.0), 55),
        (SurfaceFit(surface="hypar", zigzag=8.0, row_step=1.4), 54),
    ],
)
def test_fitted_sheets_are_exact_lie_on_the_offsets_and_cover_the_domain(design, strips):
    growth = design.grow()
    mesh = growth.mesh
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    assert growth.status is Status.GROWN
    assert abs(growth.strips - strips) <= 1
    assert planarity(coords, faces).max() < 1e-12
    assert developability(coords, faces).max() < 1e-12
    surface = SURFACES[design.surface]
    step = 2 / design.columns
    guess = np.stack(
        [
            np.broadcast_to(np.linspace(-1.4, 1.4, len(mesh.grid))[:, None], mesh.grid.shape),
            np.broadcast_to(np.linspace(-1, 1, design.columns + 1), mesh.grid.shape),
        ],
        axis=-1,
    )
    # walk row by row, so that the nearest points are looked for near the row before
    uv = guess[len(guess) // 2]
    middle = len(mesh.grid) // 2
    found = {}
    for rows in (range(middle, len(mesh.grid)), range(middle - 1, -1, -1)):
        uv = guess[middle]
        for row in rows:
            distance, _, uv = surface.distance(coords[mesh.grid[row]], uv)
            found[row] = uv
            assert np.abs(np.abs(distance) - design.thickness * step / 2).max() < 1e-10
            assert np.ptp(distance) < 1e-10
    u = np.stack([found[row][:, 0] for row in range(len(mesh.grid))])
    assert u.max(axis=0).min() > 1.0
    assert u.min(axis=0).max() < -1.0


def test_a_fit_that_dies_says_where_and_keeps_what_it_has():
    growth = SurfaceFit(surface="hypar").grow()
    assert growth.status is not Status.GROWN
    assert growth.advice.startswith("Towards u = ")
    assert len(growth.mesh.faces_vertices) == 40 * (growth.strips + 2)
    assert planarity(growth.mesh.vertices_coords, growth.mesh.faces_vertices).max() < 1e-12


def test_a_surface_of_ones_own_is_followed():
    bump = explicit_surface(lambda x, y: 0.15 * np.exp(-2 * (x**2 + y**2)))
    growth = fit_surface(bump, 20, thickness=0.1, zigzag=0.3, row_step=0.1)
    assert growth.status is Status.GROWN
    mesh = growth.mesh
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12
    assert develop(mesh).isometry_max_rel < 1e-11


@pytest.mark.parametrize(
    ("design", "name"),
    [
        (SurfaceFit(surface="torus"), "surface = torus .* cylinder, hypar"),
        (SurfaceFit(columns=2), "columns"),
        (SurfaceFit(thickness=0.0), "thickness"),
        (SurfaceFit(zigzag=np.nan), "zigzag"),
        (SurfaceFit(row_step=-1.0), "row_step"),
    ],
)
def test_parameters_out_of_bounds_are_named(design, name):
    with pytest.raises(InvalidValue, match=name):
        design.grow()
