"""Targets and the sheets that follow them."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from fab.pattern.development import develop
from solver import (
    Front,
    InvalidValue,
    Miura,
    ParametricSurface,
    Side,
    Status,
    SurfaceFit,
    TurnedTarget,
    developability,
    explicit_surface,
    fit_surface,
    planarity,
    ray_hit,
)
from solver.coverage import one_piece, windings
from solver.designs.surface_fit import SURFACES
from solver.mesh import boundary_loops
from solver.mirroring import Mirror
from solver.planarise import planarised


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
    lengths, _ = ray_hit(SPHERE, origin, direction, offset, np.array([[u, v]]))
    along = float(np.vecdot(origin, direction)[0])
    expected = -along + np.sqrt(along**2 + (1 + offset) ** 2 - 1)
    assert lengths == pytest.approx(expected, abs=1e-12)
    assert np.isnan(ray_hit(SPHERE, origin, direction, -0.2, np.array([[u, v]]))[0]).all()


def test_rays_that_miss_are_not_numbers_and_leave_the_others_alone():
    flat = explicit_surface(lambda x, _y: 0 * x)
    origins = np.zeros((3, 3))
    directions = np.array([[0.0, 0, 1], [1, 0, 0], [0, 0.6, 0.8]])
    lengths, uv = ray_hit(flat, origins, directions, 1.0, np.zeros((3, 2)))
    assert lengths[[0, 2]] == pytest.approx([1.0, 1.25])
    assert np.isnan(lengths[1])
    assert uv[2] == pytest.approx([0.0, 0.75])


@pytest.mark.parametrize("name", sorted(SURFACES))
def test_derivatives_agree_with_differences_and_normals_stand_on_them(name):
    surface = SURFACES[name]
    uv = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    plain = ParametricSurface(surface.position)
    for given_one, difference in zip(surface.tangents(uv), plain.tangents(uv), strict=True):
        assert given_one == pytest.approx(difference, abs=1e-8)
        assert np.vecdot(surface.normal(uv), given_one) == pytest.approx(0, abs=1e-8)


@given(angles, angles, st.floats(-4.0, 4.0), st.floats(-0.2, 0.2))
def test_a_turned_target_is_the_same_surface(u, v, angle, height):
    turned = TurnedTarget(SPHERE, angle)
    places = turned.places(np.array([[u, v]]) / 2)
    point = turned.point(places)
    assert np.linalg.norm(point) == pytest.approx(1)
    normal = turned.normal(places)
    distance, gradient, found = turned.distance(point + height * normal, places)
    assert distance == pytest.approx(height, abs=1e-12)
    assert gradient == pytest.approx(normal, abs=1e-7)
    assert found == pytest.approx(places, abs=1e-7)


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-4.0, 4.0))
def test_a_turned_target_keeps_its_domain_within_the_square(u, v, angle):
    turned = TurnedTarget(SPHERE, angle)
    c, s, size = np.cos(angle), np.sin(angle), abs(np.cos(angle)) + abs(np.sin(angle))
    place = np.array([[c * u + s * v, c * v - s * u]]) / size
    assert np.abs(place).max() <= 1 + 1e-12
    assert turned.point(place) == pytest.approx(sphere(np.array([u]), np.array([v])), abs=1e-12)
    inner = 0.999 * place
    assert turned.inside(inner).all()


def offset_heights(surface, coords, reach=1.7):
    """Signed distances of points, the nearest sample of the surface taken as a first guess."""
    grid = np.linspace(-reach, reach, 300)
    uv = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    _, nearest = cKDTree(surface.point(uv)).query(coords)
    distance, _, places = surface.distance(coords, uv[nearest])
    return distance, places


@pytest.mark.parametrize(
    ("design", "strips", "coverage"),
    [
        (SurfaceFit(zigzag=3.0, row_step=0.7), 60, 0.999),
        (SurfaceFit(zigzag=4.0, row_step=0.8), 54, 0.999),
        (SurfaceFit(surface="cylinder"), 66, 1.0),
        (SurfaceFit(surface="barrel"), 58, 0.995),
        (SurfaceFit(surface="hourglass"), 62, 0.96),
        (SurfaceFit(surface="landscape"), 45, 0.98),
        (SurfaceFit(surface="paraboloid"), 50, 0.99),
        (SurfaceFit(surface="hypar", zigzag=5.0, row_step=1.4), 46, 0.96),
        (SurfaceFit(surface="helicoid", zigzag=8.0, row_step=2.8), 18, 0.999),
        (SurfaceFit(turn=np.pi / 4, zigzag=5.0, row_step=0.7), 55, 0.99),
    ],
)
def test_fitted_sheets_are_exact_lie_on_the_offsets_and_cover_the_domain(design, strips, coverage):
    growth = design.grow()
    mesh = growth.mesh
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    assert growth.status is Status.GROWN
    assert abs(growth.strips - strips) <= 1
    assert coverage <= growth.coverage <= 1
    assert planarity(coords, faces).max() < 1e-12
    assert developability(coords, faces).max() < 1e-12
    surface = SURFACES[design.surface]
    rows = coords[mesh.grid]
    distance, _ = offset_heights(surface, rows.reshape(-1, 3))
    distance = distance.reshape(rows.shape[:2])
    side = np.sign(distance[:1, :1]) * (-1.0) ** np.arange(len(rows))[:, None]
    level = distance * side
    assert np.ptp(level) < 1e-10  # every row on one offset, in turn on either side
    assert level.min() > 0


def test_the_zigzag_is_chosen_where_it_is_not_given_and_a_given_one_is_kept():
    free = SurfaceFit(surface="hypar", columns=30).grow()
    assert free.status is Status.GROWN
    kept = SurfaceFit(surface="hypar", columns=30, zigzag=5.0, row_step=1.4).grow()
    assert np.array_equal(free.mesh.vertices_coords, kept.mesh.vertices_coords)
    alone = SurfaceFit(surface="hypar", zigzag=3.0, row_step=1.0, turn=0.0).grow()
    assert alone.status is not Status.GROWN
    assert free.chosen == kept.chosen
    assert (free.chosen["zigzag"], free.chosen["row_step"]) == (5.0, 1.4)


def test_rows_across_asymptotic_directions_die_and_turned_ones_grow():
    saddle = explicit_surface(lambda x, y: 0.8 * x * y)
    straight = fit_surface(saddle, 30, zigzag=5.0, row_step=1.4, turn=0.0)
    assert straight.status is not Status.GROWN
    assert straight.coverage < 0.7
    turned = fit_surface(TurnedTarget(saddle, np.pi / 4), 30, zigzag=5.0, row_step=1.4, turn=0.0)
    assert turned.coverage > 0.95
    chosen = fit_surface(saddle, 30, zigzag=5.0, row_step=1.4)
    assert chosen.chosen["turn_deg"] in (45.0, -45.0)
    assert chosen.coverage > 0.95


@pytest.mark.parametrize("name", ["landscape", "helicoid", "hourglass"])
def test_trimmed_sheets_cover_the_domain_and_hardly_more(name):
    design = SurfaceFit(surface=name, columns=40, zigzag=3.0, row_step=1.0, trim=True)
    if name == "helicoid":
        design = SurfaceFit(surface=name, columns=40, zigzag=8.0, row_step=2.8, trim=True)
    growth = design.grow()
    mesh = growth.mesh
    assert growth.coverage > 0.9985
    assert len(boundary_loops(mesh.edges)) == 1  # one piece, nowhere held by a corner alone
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12
    assert develop(mesh).isometry_max_rel < 1e-10
    surface = SURFACES[name]
    _, places = offset_heights(surface, mesh.vertices_coords, 1.33)
    corners = places[mesh.faces_vertices]
    # no face lies apart from the domain by more than its own size
    size = np.linalg.norm(corners.max(axis=1) - corners.min(axis=1), axis=1)
    grid = np.linspace(-1, 1, 201)
    uv = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    inside = cKDTree(uv[surface.inside(uv)])
    gap, _ = inside.query(corners.mean(axis=1))
    assert (gap <= size + 0.01).all()
    with pytest.raises(InvalidValue, match="grow"):
        Front.of(mesh, Side.TOP)


def test_pieces_that_hang_together_by_a_corner_are_joined_or_dropped():
    falling = np.array([[1, 0, 0, 0], [0, 1, 1, 0], [0, 1, 1, 0], [1, 0, 0, 1]], bool)
    assert one_piece(falling).tolist() == [[False] * 4, *falling[1:3].tolist(), [False] * 4]
    ring = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 0]], bool)
    assert one_piece(ring).sum() >= 7
    assert one_piece(ring)[1, 1] or one_piece(ring)[2, 2]


@given(st.integers(0, 2**32 - 1))
def test_points_within_an_outline(seed):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 12))
    outline = rng.uniform(0.2, 1.0, (12, 1)) * np.column_stack([np.cos(angle), np.sin(angle)])
    hole = 0.05 * np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    points = rng.uniform(-1, 1, (100, 2))
    polygon = shapely.Polygon(outline).symmetric_difference(shapely.Polygon(hole))
    expected = shapely.contains_xy(polygon, *points.T)
    assert ((windings([outline, hole[::-1]], points) != 0) == expected).all()
    twice = np.concatenate([outline, outline])
    covered = shapely.contains_xy(shapely.Polygon(outline), *points.T)
    assert (windings([twice], points) == 2 * covered).all()
    assert (windings([twice[::-1]], points) == -2 * covered).all()


@settings(max_examples=40)
@given(st.floats(0, 6.28), st.integers(0, 1000))
def test_the_slope_of_the_mirror_cost_is_its_derivative(trial, seed):
    rng = np.random.default_rng(seed)
    mesh = Miura(columns=9, rows=2).grow().mesh
    front = Front.of(mesh, Side.TOP)
    normal = rng.normal(size=(8, 3))
    mirror = Mirror.of(front, normal / np.linalg.norm(normal, axis=1)[:, None])
    h = 1e-6
    below, above = mirror.cost(np.array([trial - h, trial + h]))
    assert mirror.slope(trial) == pytest.approx((above - below) / (2 * h), rel=1e-5, abs=1e-5)
    best = mirror.best_of(np.array([[0.0, 2 * np.pi]]))
    everywhere = mirror.cost(np.linspace(0, 2 * np.pi, 4001))
    assert mirror.cost(np.array([best]))[0] <= everywhere.min() + 1e-9


def test_rows_that_cannot_be_planarised_are_nothing():
    far = np.stack(np.meshgrid(np.linspace(-9, 9, 9), np.linspace(-9, 9, 3)), axis=-1)
    assert planarised(SURFACES["waves"], far, np.array([-5.0, 5.0, -5.0])) is None


def test_a_fit_that_stops_names_the_place_and_keeps_what_it_has():
    growth = SurfaceFit(surface="hypar", zigzag=3.0, row_step=0.7, turn=0.0).grow()
    assert growth.status is not Status.GROWN
    assert "Along u, upwards: " in growth.advice
    assert "Along u, downwards: " in growth.advice
    assert len(growth.mesh.faces_vertices) == 40 * (growth.strips + 2)
    assert planarity(growth.mesh.vertices_coords, growth.mesh.faces_vertices).max() < 1e-12
    assert 0.3 < growth.coverage < 0.7


def test_a_surface_of_the_users_own_is_followed():
    bump = explicit_surface(lambda x, y: 0.3 * np.exp(-0.5 * (x**2 + y**2)), 2.0, 2.0)
    growth = SurfaceFit(surface=bump, columns=20).grow()
    assert growth.status is Status.GROWN
    mesh = growth.mesh
    assert growth.coverage > 0.97
    assert (np.ptp(mesh.vertices_coords, axis=0)[:2] > 4.0).all()
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12
    assert develop(mesh).isometry_max_rel < 1e-11


def test_constant_heights_and_sides_of_the_domain():
    plain = explicit_surface(lambda x, y: 0.0)
    growth = fit_surface(plain, 8)
    assert growth.coverage == 1.0
    assert fit_surface(plain, 8, trim=True).coverage == 1.0
    aside = ParametricSurface(plain.position, None, lambda u, v: u > 5)
    with pytest.raises(InvalidValue, match="domain"):
        fit_surface(aside, 8)


def test_creases_that_shoot_far_past_the_surface_are_no_sheet():
    mesh = SurfaceFit(columns=12, trim=True).grow().mesh
    assert np.abs(mesh.vertices_coords[:, :2]).max() < 2.0


def test_points_beyond_the_centres_of_curvature_have_no_nearest_point():
    points = np.array([[0.5, 0, 0], [-2.0, 0.3, 0.1]])  # of the sphere, from the far side
    distance, _, _ = SPHERE.distance(points, np.array([[0.1, 0.1], [0.1, 0.1]]))
    assert distance[0] == pytest.approx(-0.5, abs=1e-9)
    assert np.isnan(distance[1])


def test_progress_is_reported_and_never_runs_over():
    reported = []
    SurfaceFit(columns=24, zigzag=3.0, row_step=1.0).grow(
        lambda done, total: reported.append((done, total))
    )
    assert reported[0][0] == 1
    assert all(done <= total for done, total in reported)


@pytest.mark.parametrize(
    ("design", "name"),
    [
        (SurfaceFit(surface="torus"), "surface = torus .* cylinder, helicoid"),
        (SurfaceFit(columns=2), "columns"),
        (SurfaceFit(thickness=0.0), "thickness"),
        (SurfaceFit(zigzag=np.nan), "zigzag"),
        (SurfaceFit(row_step=-1.0), "row_step"),
        (SurfaceFit(turn=np.inf), "turn"),
        (SurfaceFit(zigzag=100.0, row_step=90.0, turn=0.0), "zigzag 100 and row_step 90"),
        (SurfaceFit(zigzag=100.0, row_step=90.0), "none of 4 choices of zigzag"),
        (SurfaceFit(columns=5000), "columns"),
        (SurfaceFit(thickness=None), "thickness"),
        (SurfaceFit(thickness=1e-20), "surface|seed"),
        (SurfaceFit(surface=3), "surface"),
        (SurfaceFit(surface=ParametricSurface(lambda u, v: None)), "position"),
        (SurfaceFit(surface=ParametricSurface(lambda u, v: np.zeros((3, 2)))), "position"),
        (SurfaceFit(surface=explicit_surface(lambda x, y: np.nan * x)), "line u = 0"),
        (SurfaceFit(surface=ParametricSurface(lambda u, v: np.zeros((len(u), 3)))), "length of"),
    ],
)
def test_parameters_out_of_bounds_are_named(design, name):
    with pytest.raises(InvalidValue, match=name):
        design.grow()
