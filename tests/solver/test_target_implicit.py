"""Surfaces given as zeros of a function, and the boxes in which they are seen."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from solver import Status, developability, planarity
from solver.errors import InvalidValue
from solver.fitting import fit_surface
from solver.targets.frame import Frame
from solver.targets.implicit import ImplicitSurface

seeds = st.integers(0, 2**32 - 1)
TILT = np.array([1.0, -2.0, 2.0]) / 3
RING, TUBE = 1.0, 0.3


def torus(p):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - RING, p[:, 2]) - TUBE


def torus_gradient(p):
    r = np.hypot(p[:, 0], p[:, 1])
    length = np.hypot(r - RING, p[:, 2])
    inwards = (r - RING) / length / r
    return np.column_stack([inwards * p[:, 0], inwards * p[:, 1], p[:, 2] / length])


def torus_squared(p):
    """The same torus by a polynomial: no distance, and a gradient of varying length."""
    s = (p**2).sum(axis=1) + RING**2 - TUBE**2
    return s**2 - 4 * RING**2 * (p[:, 0] ** 2 + p[:, 1] ** 2)


def torus_squared_gradient(p):
    s = (p**2).sum(axis=1) + RING**2 - TUBE**2
    flat = np.array([1.0, 1.0, 0.0])
    return 4 * s[:, None] * p - 8 * RING**2 * p * flat


# value, gradient, frame, the true signed distance, and how far away it is unique
SURFACES = {
    "plane": (
        lambda p: 5 * (p @ TILT - 0.1),
        lambda p: np.tile(5 * TILT, (len(p), 1)),
        Frame.along(TILT),
        lambda p: p @ TILT - 0.1,
        0.9,
    ),
    "sphere": (
        lambda p: (p**2).sum(axis=1) - 1,
        lambda p: 2 * p,
        Frame.along((0, 0, 1), half_widths=(0.6, 0.6, 1.2)),
        lambda p: np.linalg.norm(p, axis=1) - 1,
        0.5,
    ),
    "torus": (
        torus_squared,
        torus_squared_gradient,
        Frame.along((0, 0, 1), origin=(RING, 0, 0), half_widths=(0.2, 0.2, 0.5)),
        torus,
        0.12,
    ),
}


@pytest.mark.parametrize("name", sorted(SURFACES))
@pytest.mark.parametrize("by_differences", [False, True])
@settings(max_examples=10)
@given(seed=seeds)
def test_distances_gradients_and_nearest_places_are_exact(name, by_differences, seed):
    value, gradient, frame, true, reach = SURFACES[name]
    surface = ImplicitSurface(value, frame, None if by_differences else gradient)
    rng = np.random.default_rng(seed)
    places = surface.places(rng.uniform(-1, 1, (20, 2)))
    feet = surface.point(places)
    assert np.abs(true(feet)).max() < 1e-14
    height = rng.uniform(-reach, reach, 20)
    points = feet + height[:, None] * surface.normal(places)
    assert true(points) == pytest.approx(height, abs=1e-9)
    guess = surface.places(np.clip(places[:, :2] + rng.uniform(-0.1, 0.1, (20, 2)), -1, 1))
    distance, slope, found = surface.distance(points, guess)
    assert np.abs(distance - true(points)).max() < 1e-12
    exact = 1e-8 if by_differences else 1e-12
    assert np.abs(found[:, 2:] - feet).max() < exact
    assert np.abs(found[:, :2] - places[:, :2]).max() < 10 * exact
    assert np.abs(slope - surface.normal(found)).max() == 0
    step = 1e-6 * rng.normal(size=3)
    ahead, behind = (surface.distance(points + s * step, guess)[0] for s in (1, -1))
    assert (ahead - behind) / 2 == pytest.approx(slope @ step, abs=1e-13)


def test_a_distance_to_nowhere_is_not_a_number_and_leaves_the_others_alone():
    surface = ImplicitSurface(torus, SURFACES["torus"][2], torus_gradient)
    guess = surface.places(np.zeros((2, 2)))
    # every point of the tube's ring is as near to the point in its middle as every other
    points = np.array([[RING, 0.0, 0.0], [RING, 0.0, 0.5]])
    distance, slope, _ = surface.distance(points, guess)
    assert np.isnan(distance[0]) or distance[0] == pytest.approx(-TUBE)
    assert distance[1] == pytest.approx(0.5 - TUBE, abs=1e-14)
    assert slope[1] == pytest.approx([0, 0, 1])
    never = ImplicitSurface(lambda p: (p**2).sum(axis=1) + 1, Frame.along((0, 0, 1)))
    assert np.isnan(never.distance(points, guess)[0]).all()


def test_the_uppermost_sheet_is_taken_and_the_square_is_the_inside():
    surface = ImplicitSurface(*SURFACES["sphere"][:1], Frame.along((0, 0, 1)))
    places = surface.places(np.array([[0.0, 0.0], [0.5, 0.5], [-0.6, 0.0]]))
    assert places[:, 4] == pytest.approx([1.0, np.sqrt(0.5), 0.8])
    below = ImplicitSurface(*SURFACES["sphere"][:1], Frame.along((0, 0, -1)))
    assert below.places(np.zeros((1, 2)))[0, 4] == pytest.approx(-1.0)
    uv = np.array([[1.0, -1.0], [1.001, 0.0], [0.0, -1.1]])
    assert surface.inside(np.pad(uv, ((0, 0), (0, 3)))).tolist() == [True, False, False]


def test_lines_that_miss_give_no_place_and_leave_the_others_alone():
    surface = ImplicitSurface(SURFACES["sphere"][0], Frame.along((0, 0, 1)))
    uv = np.array([[0.0, 0.0], [0.9, 0.8]])
    places = surface.places(uv)
    assert (places[:, :2] == uv).all()
    assert surface.point(places)[0] == pytest.approx([0, 0, 1])
    assert np.isnan(surface.point(places)[1]).all()
    assert surface.inside(places).tolist() == [True, False]


@given(seed=seeds)
def test_coordinates_in_a_box_turn_back_into_points(seed):
    rng = np.random.default_rng(seed)
    up, rows = rng.normal(size=(2, 3))
    frame = Frame.along(up, rows, origin=rng.normal(size=3), half_widths=rng.uniform(0.1, 9, 3))
    points = rng.normal(size=(5, 3))
    assert frame.points(frame.coordinates(points)) == pytest.approx(points, abs=1e-12)
    assert frame.axes[2] == pytest.approx(up / np.linalg.norm(up))
    assert frame.axes[1] @ rows > 0
    assert abs(frame.axes[0] @ rows) < 1e-12
    assert np.cross(frame.axes[0], frame.axes[1]) == pytest.approx(frame.axes[2])


@given(seed=seeds)
def test_the_box_around_a_turned_plate_has_its_sides(seed):
    rng = np.random.default_rng(seed)
    half = np.array([rng.uniform(1.1, 5), 1.0, 0.01])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    middle = rng.normal(size=3)
    corners = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3) * half
    frame = Frame.around(corners @ turn.T + middle, turn[:, 2])
    assert frame.half_widths == pytest.approx(half)
    assert frame.origin == pytest.approx(middle)
    assert abs(frame.axes[0] @ turn[:, 0]) == pytest.approx(1.0)
    assert np.abs(frame.coordinates(corners @ turn.T + middle)) == pytest.approx(1.0)


def test_u_runs_along_x_where_no_direction_is_better():
    square = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    assert Frame.around(square, (0, 0, 1)).axes == pytest.approx(np.eye(3))
    assert Frame.along((0.01, 0.0, 1)).axes[1] == pytest.approx([0, 1, 0])
    tall = square * [0.5, 2.0, 1.0]
    assert Frame.around(tall, (0, 0, 1)).axes[0] == pytest.approx([0, 1, 0])
    assert Frame.around(tall, (0, 0, 1), rows=(0, 1, 0)).axes[0] == pytest.approx([1, 0, 0])


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: Frame.along((0, 0, 0)), "up"),
        (lambda: Frame.along((0, 0, np.nan)), "up"),
        (lambda: Frame.along((0, 0, 1), rows=(0, 0, -2)), "rows"),
        (lambda: Frame.along((0, 0, 1), rows=(1, 0)), "rows"),
        (lambda: Frame.along((0, 0, 1), half_widths=(1, 0, 1)), "half_widths"),
        (lambda: Frame.along((0, 0, 1), origin=(0, np.inf, 0)), "origin"),
        (lambda: Frame(np.zeros(3), np.diag([1.0, 1, -1]), np.ones(3)), "axes"),
        (lambda: Frame(np.zeros(3), 2 * np.eye(3), np.ones(3)), "axes"),
        (lambda: Frame.around(np.eye(3)[[0, 0, 1]], (1, 0, 0), (0, 0, 1)), "half_widths"),
        (lambda: Frame.around(np.eye(3)[[0, 0, 1]], (0, 0, 1)), "half_widths"),
    ],
)
def test_boxes_that_are_none_are_refused(make, name):
    with pytest.raises(InvalidValue, match=name):
        make()


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_points_already_on_the_surface_have_no_distance(x, y):
    assume(x * x + y * y > 1e-6)
    surface = ImplicitSurface(*SURFACES["sphere"][:1], Frame.along((0, 0, 1)), lambda p: 2 * p)
    point = np.array([[x, y, 1.0]])
    point /= np.linalg.norm(point)
    distance, slope, _ = surface.distance(point, np.pad(point, ((0, 0), (2, 0))))
    assert abs(distance[0]) < 1e-15
    assert slope == pytest.approx(point)


def test_a_sheet_grows_on_a_torus_and_lies_on_its_offsets():
    frame = Frame.along((0, 0, 1), origin=(RING, 0, 0), half_widths=(0.18, 0.24, 0.5))
    surface = ImplicitSurface(torus_squared, frame, torus_squared_gradient)
    growth = fit_surface(surface, 16, zigzag=3.0, row_step=1.0)
    coords, faces = growth.mesh.vertices_coords, growth.mesh.faces_vertices
    assert growth.status is Status.GROWN
    assert growth.coverage > 0.99
    assert planarity(coords, faces).max() < 1e-13
    assert developability(coords, faces).max() < 1e-13
    height = np.abs(torus(coords))
    assert np.ptp(height) < 1e-13
    assert height[0] > 0.001
