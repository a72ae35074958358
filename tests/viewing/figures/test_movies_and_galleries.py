"""Figures of data of one's own: galleries, growth, circles, and files of movies."""

import io

import numpy as np
import pytest
from PIL import Image

from fab.viewing.camera import view_axes
from fab.viewing.figures.canvas import Drawing, movie, new_figure, plain
from fab.viewing.figures.circles import draw_circle
from fab.viewing.figures.forms import Bundle, draw_bundle, principal_view
from fab.viewing.figures.galleries import gallery_figure
from fab.viewing.figures.growing import growth_movie
from fab.viewing.figures.sheets import draw_flat, shown_sheet
from fab.viewing.figures.vertices import angles_figure
from fab.viewing.movie_files import gif_bytes
from solver import Miura, RandomTube, TiltedRings
from solver.vertex_family import vertex_family


@pytest.fixture(scope="module")
def rings():
    return shown_sheet(TiltedRings(strips=5, opening=0.5).grow().mesh, "rings")


def test_curves_over_the_flap_angle_close_after_a_turn():
    family = vertex_family([-1, 0, 0.4], [1, 0.2, 0.4], [0, -1, 0], 12)
    sectors = angles_figure(family).figure.axes[0]
    theta1, theta2 = (line.get_xydata() for line in sectors.lines[:2])
    for curve in (theta1, theta2):
        assert curve[[0, -1], 0].tolist() == [0.0, 360.0]
        assert curve[0, 1] == curve[-1, 1]
    np.testing.assert_allclose(theta1[:, 1] + theta2[:, 1], np.degrees(family.k))


def test_a_closed_sheet_grows_ring_by_ring(rings):
    assert np.bincount(rings.steps).tolist() == [4] * 6
    frames = growth_movie(rings).frames
    words = [frame().figure.texts[0].get_text() for frame in frames]
    assert words[0] == "rings: step 1 of 6, 4 faces"
    assert words[-1] == "rings: step 6 of 6, 24 faces"


def test_flat_drawings_show_the_creases_between_faces_that_are_there(rings):
    def lines(shown):
        axes = new_figure(100, 100).add_subplot()
        draw_flat(axes, rings, shown)
        return {
            tuple(np.round(each.get_colors()[0][:3], 2)): len(each.get_segments())
            for each in axes.collections
            if len(each.get_segments())
        }

    counts = rings.pattern.counts()
    assert sum(lines(None).values()) == sum(counts.values())
    one_ring = lines(rings.steps == 0)
    assert sum(one_ring.values()) == 4 * 2 + 5  # two sides of four quads, five creases and ends


def test_a_gallery_has_two_drawings_for_each_sheet(rings):
    small = shown_sheet(Miura(columns=4, rows=3).grow().mesh, "miura", upright=True)
    tube = shown_sheet(RandomTube(strips=2, random_seed=3).grow().mesh, "tube")
    gallery = gallery_figure([small, rings, tube], "three", columns=2)
    assert len(gallery.figure.axes) == 6
    assert gallery.figure.axes[0].get_title() == "miura: 12 quads"
    assert gallery.png_bytes() == gallery.png_bytes()


def test_a_movie_draws_its_pictures_once_and_shows_the_last_longer():
    def frame(size):
        figure = new_figure(120, 80)
        plain(figure, (0, 0, 1, 1)).plot([0, size], [0, 1], color="red")
        return Drawing(figure)

    made = movie([lambda: frame(1), lambda: frame(2), lambda: frame(3)], last_ms=900)
    assert list(made.order) == [0, 1, 2]
    seen = []
    images = made.images(lambda done, total: seen.append((done, total)))
    assert seen == [(0, 3), (1, 3), (2, 3)]
    data = gif_bytes(images, made.order, made.times_ms)
    with Image.open(io.BytesIO(data)) as image:
        assert (image.size, image.n_frames, image.info["loop"]) == ((120, 80), 3, 0)
        durations = []
        for number in range(3):
            image.seek(number)
            durations.append(image.info["duration"])
        assert durations == [100, 100, 900]
        assert image.convert("RGB").getpixel((0, 0)) == (255, 255, 255)


def test_what_is_nearer_hides_what_is_further():
    low = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    up = np.array([0.0, 0, 1])
    red, green = ((1.0, 0.0, 0.0),) * 2, ((0.0, 1.0, 0.0),) * 2

    def middle(faces, colours):
        figure = new_figure(100, 100)
        axes = plain(figure, (0, 0, 1, 1))
        draw_bundle(axes, view_axes(90.0, -90.0), Bundle(faces, colours))
        axes.set_xlim(0, 1)
        axes.set_ylim(0, 1)
        return Drawing(figure).image().getpixel((50, 50))

    assert middle([low, low + up], [red, green])[1] > 100
    assert middle([low + up, low], [green, red])[1] > 100
    # two faces that pass through each other: each is seen on its half
    tilted = low + np.outer(low[:, 0] - 0.4, [0, 0, 1])
    assert middle([low, tilted], [red, green])[1] > 100
    tilted = low + np.outer(0.4 - low[:, 0], [0, 0, 1])
    assert middle([low, tilted], [red, green])[0] > 100


def test_faces_show_their_upper_and_their_lower_side():
    face = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 1, 0]])
    for flipped, expected in ((False, 0), (True, 2)):
        figure = new_figure(60, 60)
        axes = plain(figure, (0, 0, 1, 1))
        corners = face[::-1] if flipped else face
        draw_bundle(axes, view_axes(90.0, -90.0), Bundle([corners], [((1, 0, 0), (0, 0, 1))]))
        axes.set_xlim(0, 1)
        axes.set_ylim(0, 1)
        assert np.argmax(Drawing(figure).image().getpixel((30, 40))) == expected


def test_views_are_along_the_longest_directions():
    points = np.random.default_rng(1).normal(size=(50, 3)) * [0.1, 3.0, 2.0]
    view = principal_view(points, view_axes(90.0, -90.0))
    np.testing.assert_allclose(view @ view.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(view) == pytest.approx(1)
    assert np.abs(view[0]).argmax() == 1
    assert np.abs(view[2]).argmax() == 0


def test_forbidden_arcs_are_where_their_angles_are():
    axes = plain(new_figure(200, 200), (0, 0, 1, 1))
    draw_circle(axes, [("", np.array([[6.0, 0.5]]))], {}, taken=1.0)
    (ring,) = axes.patches
    angles = np.arctan2(*ring.get_xy().T[::-1])
    assert angles.min() == pytest.approx(6.0 - 2 * np.pi)
    assert angles.max() == pytest.approx(0.5)
    hand = axes.lines[-1].get_xydata()
    np.testing.assert_allclose(np.arctan2(*hand.T[::-1]), 1.0)
