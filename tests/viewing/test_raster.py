"""Painted triangles: what is in front hides what is behind, and slim faces are seen."""

import numpy as np
import pytest

from fab.geometry.bodies import Bodies, concatenated, stacked
from fab.viewing.camera import fitted, view_axes
from fab.viewing.painting import Shapes, painted
from fab.viewing.raster import nearest_triangles
from fab.viewing.shapes import solid_shapes

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
SIZE = 400


def block(low, high) -> Bodies:
    (x0, y0, z0), (x1, y1, z1) = low, high
    ring = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)
    return stacked(np.stack([ring, ring], axis=1), np.array([0, 4]), np.array([z0, z1], float))


def seen(*coloured, elevation_deg=90.0, azimuth_deg=-90.0):
    """Shares of the picture that are redder and bluer than anything else."""
    bodies = concatenated([body for body, _ in coloured])
    shapes = solid_shapes(bodies, np.array([colour for _, colour in coloured]))
    axes = view_axes(elevation_deg, azimuth_deg)
    image = painted(fitted(axes, bodies.vertices_coords, SIZE, SIZE, 16), [shapes])
    assert image.shape == (SIZE, SIZE, 3)
    assert image.min() >= 0
    assert image.max() <= 1
    other = image.max(axis=2) < 0.999
    red = (image[..., 0] > image[..., 2] + 0.1) & other
    blue = (image[..., 2] > image[..., 0] + 0.1) & other
    return red.mean(), blue.mean()


def test_what_is_above_hides_what_is_below():
    low, high = block((0, 0, 0), (10, 10, 1)), block((0, 0, 5), (10, 10, 6))
    red, blue = seen((low, RED), (high, BLUE))
    assert red == 0
    assert blue > 0.3
    red, blue = seen((high, RED), (low, BLUE))  # whatever the order
    assert blue == 0


def test_bodies_that_pass_through_each_other_show_what_is_in_front_at_every_pixel():
    """Two long bars that cross, one tilted: no order of painting whole faces shows them right."""
    flat = block((-10, -1, 0), (10, 1, 0.2))
    tilted = block((-10, -1, 0), (10, 1, 0.2))
    coords = tilted.vertices_coords @ np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    tilted = Bodies(coords, *(getattr(tilted, f) for f in list(Bodies.__annotations__)[1:]))
    red, blue = seen((flat, RED), (tilted, BLUE))
    # from above, the tilted bar hides one half of the flat one: 8 of 20 long, and that one 12
    assert red / (red + blue) == pytest.approx(12 / 20, abs=0.03)


def test_the_area_of_a_square_is_that_of_its_outline():
    red, _ = seen((block((0, 0, 0), (10, 10, 1)), RED))
    assert red == pytest.approx(((SIZE - 32) / SIZE) ** 2, rel=0.01)
    turned, _ = seen((block((0, 0, 0), (10, 10, 1)), RED), azimuth_deg=-30.0)
    side = 1 / (np.cos(np.pi / 3) + np.sin(np.pi / 3))  # as wide as the square turned by 60 degrees
    assert turned == pytest.approx(red * side**2, rel=0.02)


def test_sheets_have_a_colour_on_each_side():
    corners = np.array([[[0.0, 0, 0], [10, 0, 0], [0, 10, 0]]])
    shapes = Shapes(corners, np.array([RED]), np.array([BLUE]), np.array([0]))
    for rise, colour in ((90.0, 0), (-90.0, 2)):
        camera = fitted(view_axes(rise, -90.0), corners.reshape(-1, 3), 100, 100, 4)
        image = painted(camera, [shapes])
        inked = image[(image.min(axis=2) < 0.5)]
        assert len(inked) > 3000
        assert (inked.argmax(axis=1) == colour).all()


def test_of_faces_on_each_other_the_first_is_seen_all_over():
    """Layers of a sheet that is folded flat do not flicker."""
    random = np.random.default_rng(0)
    corners = random.uniform(0, 10, (30, 3, 3)) * [1, 1, 0] + random.normal(0, 1e-12, (30, 3, 3))
    corners[0] = [[0, 0, 0], [10, 0, 0], [0, 10, 0]]
    ink = np.tile(BLUE, (30, 1))
    ink[0] = RED
    camera = fitted(view_axes(90.0, -90.0), corners.reshape(-1, 3), 300, 300, 4)
    image = painted(camera, [Shapes(corners, ink, ink, np.arange(30))])
    x, y = camera.pixels(corners[0])[:, :2].T
    rows, columns = np.mgrid[:300, :300] + 0.5
    inside = (columns > x[0] + 2) & (rows < y[0] - 2)
    inside &= (columns - x[0]) / (x[1] - x[0]) + (y[0] - rows) / (y[0] - y[2]) < 0.97
    assert inside.sum() > 10000
    assert (image[inside][:, 2] < 0.01).all()


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.0])
def test_faces_slimmer_than_a_pixel_are_lines_without_gaps(turn):
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    start = np.array([5.3, 5.7])
    flat = np.stack([start, start + 80 * along, start + 80 * along + 0.01 * across])
    owner, _ = nearest_triangles(np.pad(flat, ((0, 0), (0, 1)))[None], 100, 100)
    rows, columns = np.nonzero(owner == 0)
    places = np.sort((np.column_stack([columns, rows]) + 0.5 - start) @ along)
    assert places[0] < 1
    assert places[-1] > 79
    assert np.diff(places).max() < 1.5
    assert np.abs((np.column_stack([columns, rows]) + 0.5 - start) @ across).max() < 1


def test_triangles_beyond_the_picture_are_clipped():
    corners = np.array([[[-50.0, -50, 0], [200, -50, 0], [-50, 200, 0]]])
    owner, depth = nearest_triangles(corners, 60, 40)
    assert (owner == 0).all()
    assert np.isfinite(depth).all()
    away, depth = nearest_triangles(corners - [500.0, 0, 0], 60, 40)
    assert (away == -1).all()
    assert np.isneginf(depth).all()
    assert (nearest_triangles(np.empty((0, 3, 3)), 5, 4)[0] == -1).all()


def test_heights_are_those_of_the_plane():
    corners = np.array([[[0.0, 0, 0], [100, 0, 50], [0, 100, -20]]])
    owner, depth = nearest_triangles(corners, 100, 100)
    rows, columns = np.nonzero(owner == 0)
    expected = 0.5 * (columns + 0.5) - 0.2 * (rows + 0.5)
    assert depth[rows, columns] == pytest.approx(expected)
