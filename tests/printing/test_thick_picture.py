"""Pictures of solids: what is in front hides what is behind; sides and hinges have colours."""

import io

import numpy as np
import pytest
from flat_patterns import pattern_of
from PIL import Image

from fab.folding.folded_states import Stage, flat_panels, panels_at
from fab.geometry.bodies import Bodies, concatenated, stacked
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.printing.thick_picture import folded_bodies, rendered, thick_png_bytes

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def block(low, high) -> Bodies:
    (x0, y0, z0), (x1, y1, z1) = low, high
    ring = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)
    return stacked(np.stack([ring, ring], axis=1), np.array([0, 4]), np.array([z0, z1], float))


def seen(*coloured, elevation_deg=90.0):
    """Shares of the picture that are redder and bluer than anything else."""
    bodies = concatenated([body for body, _ in coloured])
    owners = [np.tile(c, (len(b.triangles), 1)) for b, c in coloured]
    image = rendered(bodies, np.concatenate(owners), elevation_deg)
    assert image.shape[0] == image.shape[1]
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
    # turned by 60 degrees it is cos 60 + sin 60 times as wide, and that is 92 % of the picture
    side = 0.92 / (np.cos(np.pi / 3) + np.sin(np.pi / 3))
    assert red == pytest.approx(side**2, rel=0.02)


@pytest.fixture(scope="module")
def hinged():
    coords = np.array([[0.0, 0], [20, 0], [40, 0], [40, 20], [20, 20], [0, 20]])
    pattern = pattern_of(coords, [[0, 1, 4, 5], [1, 2, 3, 4]], "V", angle=90.0)
    sheet, findings = thicken(pattern, PanelSettings(), HingeSettings())
    assert not findings
    folded = np.column_stack([coords, np.zeros(6)])
    folded[2:4] = [[20, 0, 20], [20, 20, 20]]
    return sheet, panels_at(pattern, folded, Stage.TARGET, 1.0)


def test_bent_webs_have_each_half_with_its_panel(hinged):
    sheet, state = hinged
    bodies, numbers = folded_bodies(sheet, state)
    assert numbers.tolist() == [0, 1, 2]
    web = bodies.mesh(2).vertices_coords
    flat = sheet.bodies.mesh(2).vertices_coords
    left = flat[:, 0] < 20
    assert web[left] == pytest.approx(flat[left])
    # turned up about x = 20: x - 20 becomes z, z becomes 20 - x
    right = flat[~left]
    turned = np.column_stack([20 - right[:, 2], right[:, 1], right[:, 0] - 20])
    assert web[~left] == pytest.approx(turned)
    still, _ = folded_bodies(sheet, flat_panels(sheet.pattern))
    assert still.vertices_coords == pytest.approx(sheet.bodies.vertices_coords)


def test_the_picture_is_a_png_of_both_states_and_repeats(hinged):
    sheet, state = hinged
    data = thick_png_bytes(sheet, "two", state)
    assert data == thick_png_bytes(sheet, "two", state)
    picture = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), float)
    assert picture.shape == (840, 1600, 3)
    left, right = picture[40:, :800], picture[40:, 800:]
    sand = (left[..., 0] > left[..., 2] + 40) & (left[..., 0] > 120)
    hinge = left[..., 2] > left[..., 0] + 100  # a valley's is blue
    assert sand.mean() > 0.05
    assert 50 < hinge.sum() < sand.sum() / 5
    upper = (right[..., 0] > right[..., 2] + 40).mean()
    assert upper > (right[..., 2] > right[..., 0] + 20).mean()  # its upper sides are seen
    for half in (left, right):
        assert (half < 250).any(axis=2).mean() > 0.05
        assert (half[:, :20] == 255).all()
        assert (half[:, -20:] == 255).all()
    alone = np.asarray(Image.open(io.BytesIO(thick_png_bytes(sheet, "two"))))
    assert alone.shape[:2] == (840, 1600)
