"""Pictures from scenes: all of it within the frame, lengths to scale, colours absolute."""

import io
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import grid, pattern_of, turned_strip
from PIL import Image
from thick_sheets import book, miura_pattern, shipped_pattern, thick

from fab.errors import Finding, Severity
from fab.folding.folded_states import Stage, flat_panels, panels_at
from fab.formats.pattern_file import PatternFile
from fab.printing.plate_settings import PlateSettings
from fab.printing.plates import make_plates
from fab.viewing.camera import fitted, view_axes
from fab.viewing.canvas import Box, Canvas, bar_length_mm, colour_map
from fab.viewing.drawing import drawing_box
from fab.viewing.folding_picture import folding_gif_bytes, states_png_bytes
from fab.viewing.reading_picture import reading_png_bytes
from fab.viewing.scales import STRAIN, distance_scale
from fab.viewing.scene import Scene, Values
from fab.viewing.scene_builders import over_surface, pattern_scene, thick_scene
from fab.viewing.shapes import sheet_triangles
from fab.viewing.sheet_picture import sheet_png_bytes
from fab.viewing.thick_picture import thick_png_bytes
from fab.viewing.view_choice import best_view
from solver.targets.surface_mesh import SurfaceMesh

BAR = 38  # the grey of scale bars


def pixels(data: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), int)


def inked(image) -> tuple[int, int, int, int]:
    """First and last row and column with ink."""
    dark = (image < 250).any(axis=2)
    rows, columns = np.flatnonzero(dark.any(axis=1)), np.flatnonzero(dark.any(axis=0))
    return rows[0], rows[-1], columns[0], columns[-1]


def saturated(image) -> np.ndarray:
    """Pixels that are no grey: faces and creases, no text and no scale bars."""
    return np.ptp(image, axis=2) > 12


def bars(image) -> list[tuple[int, int]]:
    """Left end and length of all scale bars, by runs of their grey."""
    out = []
    rows = np.flatnonzero((image == BAR).all(axis=2).sum(axis=1) > 40)
    for row in rows[np.flatnonzero(np.diff(rows, append=10**6) > 1)]:
        line = np.flatnonzero((image[row] == BAR).all(axis=1))
        for run in np.split(line, np.flatnonzero(np.diff(line) > 1) + 1):
            if len(run) > 40:
                out.append((int(run[0]), len(run)))
    return sorted(out)


FORMS = {
    "miura": lambda: miura_pattern(6, 6),
    "long": lambda: miura_pattern(40, 2),
    "waterbomb": lambda: shipped_pattern("waterbomb", 120.0),
    "square_twist": lambda: shipped_pattern("square_twist", 120.0),
    "book": lambda: book(100.0),
}


@pytest.mark.parametrize("name", FORMS)
def test_sheets_are_wholly_in_their_frames_and_fill_them(name):
    image = pixels(sheet_png_bytes(pattern_scene(FORMS[name](), name)))
    assert image.shape == (900, 1600, 3)
    drawn = saturated(image)
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    assert 20 <= columns[0] < columns[-1] < 1580
    assert 40 <= rows[0] < rows[-1] < 860
    # form and pattern fill the picture in one direction, beside or above each other
    _, _, first, last = inked(image[70:840])
    assert last - first > 1450 or np.ptp(rows) > 720
    top, bottom, left, right = inked(image)
    assert min(top, 899 - bottom, left, 1599 - right) >= 4


def test_a_pattern_alone_fills_the_picture():
    pattern = grid(4, 2, 50.0)
    image = pixels(sheet_png_bytes(pattern_scene(pattern, "grid")))
    top, bottom, left, right = inked(image[80:846])
    assert bottom - top == pytest.approx(762, abs=4)
    assert right - left == pytest.approx(2 * 762, abs=6)


def test_scale_bars_have_the_length_that_they_name():
    """The bar of a pattern of 200 mm, in pixels, against the pattern itself."""
    image = pixels(sheet_png_bytes(pattern_scene(grid(4, 2, 50.0), "grid")))
    _, _, left, right = inked(image[100:820])
    ((_, length),) = bars(image)
    named = bar_length_mm(0.3 * (1600 - 48) * 200.0 / (right - left))
    assert named == 50.0
    assert length / (right - left) == pytest.approx(named / 200.0, abs=0.004)


def test_forms_have_the_scale_of_their_bars():
    """A flat form of 120 by 80 mm: its width across the view, in pixels, against its scale bar."""
    pattern = grid(6, 4, 20.0)
    flat = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    scene = pattern_scene(replace(pattern, folded_coords=flat), "flat")
    image = pixels(sheet_png_bytes(scene))
    triangles = sheet_triangles(scene.pattern)
    coords = scene.folded_coords
    axes = best_view([coords[triangles.vertices]], triangles.faces, upright=False)
    width_mm = np.ptp(coords @ axes[0])
    sand = image[..., 0] > image[..., 2] + 25
    columns = np.flatnonzero(sand.any(axis=0))
    (left, length), *_ = bars(image)
    assert left <= columns[0]
    per_mm = (np.ptp(columns) + 1) / width_mm
    assert length / per_mm == pytest.approx(bar_length_mm(length / per_mm * 1.02), rel=0.01)


def test_bars_are_exact_to_the_pixel():
    for per_mm in (0.37, 1.0, 7.77, 312.0):
        canvas = Canvas(500, 100).scale_bar(Box(10, 10, 480, 80), per_mm)
        ((left, length),) = bars(pixels(canvas.png_bytes()))
        named = bar_length_mm(0.3 * 480 / per_mm)
        assert left == 10
        assert length == round(named * per_mm)
        assert 0.3 * 480 * 0.4 <= length <= 0.3 * 480


def test_the_same_scene_gives_the_same_bytes():
    for made in (
        lambda: sheet_png_bytes(pattern_scene(miura_pattern(), "m")),
        lambda: folding_gif_bytes(strained([0.0, 0.02])),
        lambda: states_png_bytes(strained([0.0, 0.02])),
    ):
        assert made() == made()


def test_views_do_not_depend_on_where_a_form_is():
    triangles = sheet_triangles(miura_pattern())
    coords = pattern_scene(miura_pattern(), "m").folded_coords
    first = best_view([coords[triangles.vertices]], triangles.faces, upright=False)
    moved = best_view([3 * coords[triangles.vertices] + 40], triangles.faces, upright=False)
    assert np.array_equal(first, moved)
    assert first @ first.T == pytest.approx(np.eye(3))
    assert np.linalg.det(first) == pytest.approx(1)


@pytest.mark.parametrize("side", [0, 1, 2, 3])
def test_the_view_shows_the_side_that_has_faces(side):
    """A wall, with a screen before it: it is seen from where the screen does not hide it."""
    turn = np.radians(90.0 * side)
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    wall, screen = [], [np.array([[-6.0, -0.2, -6], [6, -0.2, -6], [6, -0.2, 6], [-6, -0.2, 6]])]
    for i in range(5):
        for k in range(5):
            x, z = 2.0 * i - 5, 2.0 * k - 5
            wall.append(np.array([[x, 0, z], [x + 2, 0, z], [x + 2, 0, z + 2], [x, 0, z + 2]]))
    quads = np.array(wall + screen) @ rotation.T
    corners = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    axes = best_view([corners], np.tile(np.arange(len(quads)), 2), upright=True)
    assert axes[2] @ (rotation @ [0, 1, 0]) > 0.5


def strained(percent) -> Scene:
    """A Miura sheet in as many states as there are strains, flat and folded by turns."""
    pattern = miura_pattern()
    scene = pattern_scene(pattern, "m")
    count = len(percent)
    values = np.tile(np.array(percent, float)[:, None], (1, pattern.face_count))
    return replace(
        scene,
        shares=np.linspace(0, 1, count),
        states_coords=scene.states_coords[np.arange(count) % 2],
        values=Values(values, STRAIN),
    )


def hue_of(image) -> np.ndarray:
    """The brightest colour of the faces, by channel shares."""
    faces = image[saturated(image) & (image.max(axis=2) > 100)]
    colours, counts = np.unique(faces.reshape(-1, 3), axis=0, return_counts=True)
    brightest = colours[counts.argmax()].astype(float)
    return brightest / brightest.max()


def test_strain_has_the_same_colour_whatever_else_a_fold_has():
    mild, torn = (states_png_bytes(strained([0.0, last])) for last in (0.02, 8.0))
    first, second = pixels(mild)[70:540, 650:1270], pixels(torn)[70:540, 650:1270]
    alone = pixels(states_png_bytes(strained([8.0, 0.02])))[70:540, 650:1270]
    assert np.array_equal(first, alone)  # its neighbour does not change it
    light, dark = hue_of(first), hue_of(second)
    assert light[1] > 0.8  # 0.02 % is a light yellow
    assert dark[1] < 0.25  # 8 % is a dark red


def test_each_state_is_as_large_as_its_place():
    image = pixels(states_png_bytes(strained([0, 0.1, 0.2, 0.5, 1, 2])))
    assert image.shape == (60 + 2 * 540, 3 * 640, 3)
    for row in range(2):
        for column in range(3):
            cell = image[60 + 540 * row : 60 + 540 * (row + 1), 640 * column : 640 * (column + 1)]
            rows, columns = (np.flatnonzero(saturated(cell).any(axis=k)) for k in (1, 0))
            assert 20 <= columns[0] < columns[-1] < 620
            assert 34 <= rows[0] < rows[-1] < 500
            assert np.ptp(columns) > 560 or np.ptp(rows) > 400
    assert len(bars(image)) == 6


def test_animations_show_every_state_at_one_scale_there_and_back():
    scene = strained([0.0, 0.1, 0.3, 1.0])
    with Image.open(io.BytesIO(folding_gif_bytes(scene))) as movie:
        assert movie.size == (800, 800)
        assert movie.n_frames == 6
        frames = []
        for number in range(6):
            movie.seek(number)
            frames.append(np.asarray(movie.convert("RGB"), int))
    for frame in frames:
        top, bottom, left, right = inked(frame)
        assert min(top, 799 - bottom, left, 799 - right) >= 4
    assert len({tuple(bars(frame)) for frame in frames}) == 1
    assert np.array_equal(frames[1], frames[5])


def test_animations_of_many_states_stay_short():
    scene = strained(np.linspace(0, 1, 101))
    steps = []
    data = folding_gif_bytes(scene, lambda done, total: steps.append((done, total)))
    assert steps[-1] == (60, 60)
    with Image.open(io.BytesIO(data)) as movie:
        assert movie.n_frames == 60 + 58


def test_sheets_over_a_surface_have_the_colours_of_their_distance():
    pattern = grid(4, 3, 10.0)
    corners = np.array([[-20.0, -20, 0], [60, -20, 0], [60, 50, 0], [-20, 50, 0]])
    surface = SurfaceMesh.of(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    reds, blues = [], []
    for height in (0.9, -0.9):
        lifted = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)), constant_values=height)
        scene = pattern_scene(replace(pattern, folded_coords=lifted), "grid", upright=True)
        image = pixels(sheet_png_bytes(over_surface(scene, surface)))
        reds.append(((image[..., 0] > image[..., 2] + 90) & (image[..., 1] < 120)).sum())
        blues.append(((image[..., 2] > image[..., 0] + 90) & (image[..., 1] < 120)).sum())
        grey = np.ptp(image, axis=2) < 8
        assert (grey & (image.max(axis=2) > 120) & (image.max(axis=2) < 225)).sum() > 2000
    # above it the sheet is red, below it blue; the creases of the pattern are blue in both
    assert reds[0] > 10000 > 10 * reds[1]
    assert blues[1] > blues[0] + 5000


def test_colour_maps_of_distances_have_grey_in_their_middle():
    colours = colour_map(distance_scale(np.array([1.0])))
    assert np.ptp(colours[128]) < 0.02
    assert colours[0].argmax() == 2
    assert colours[-1].argmax() == 0


def test_narrow_ribbons_are_seen():
    ribbon = turned_strip(200, 0.9)
    radius = np.hypot(*ribbon.vertices_coords.T)
    thin = ribbon.vertices_coords * (np.where(radius > 80, 60.02, 60.0) / radius)[:, None]
    folded = np.column_stack([thin[:, 0], thin[:, 1], np.linspace(0, 30, len(thin))])
    scene = pattern_scene(replace(ribbon, vertices_coords=thin, folded_coords=folded), "thin")
    image = pixels(sheet_png_bytes(scene))
    assert (image[80:840, 20:780].min(axis=2) < 200).sum() > 800


def two_panels():
    coords = np.array([[0.0, 0], [20, 0], [40, 0], [40, 20], [20, 20], [0, 20]])
    pattern = pattern_of(coords, [[0, 1, 4, 5], [1, 2, 3, 4]], "V", angle=90.0)
    folded = np.column_stack([coords, np.zeros(6)])
    folded[2:4] = [[20, 0, 20], [20, 20, 20]]
    state = panels_at(pattern, folded, Stage.TARGET, 1.0)
    return thick(pattern), [flat_panels(pattern), state]


def test_thick_sheets_are_shown_flat_and_folded():
    sheet, states = two_panels()
    data = thick_png_bytes(thick_scene(sheet, states, "two"))
    assert data == thick_png_bytes(thick_scene(sheet, states, "two"))
    image = pixels(data)
    assert image.shape == (880, 1600, 3)
    for half in (image[80:840, :800], image[80:840, 800:]):
        sand = half[..., 0] > half[..., 2] + 30
        hinge = half[..., 2] > half[..., 0] + 100  # a valley's is blue
        assert sand.mean() > 0.1
        assert 10 < hinge.sum() < sand.sum() / 5
        assert (half[:, :20] == 255).all()
        assert (half[:, -20:] == 255).all()
    assert len(bars(image)) == 2
    alone = pixels(thick_png_bytes(thick_scene(sheet, states[:1], "two")))
    assert len(bars(alone)) == 1


def test_thick_pictures_need_bodies():
    with pytest.raises(ValueError, match="thick_scene"):
        thick_png_bytes(pattern_scene(miura_pattern(), "m"))


def test_plates_are_shown_with_their_parts_within_their_beds():
    pattern = miura_pattern(6, 6)
    sheet = thick(pattern)
    plates, _ = make_plates(sheet, (60.0, 60.0), PlateSettings())
    assert plates.count > 1
    scene = thick_scene(plates.sheet, [flat_panels(pattern)], "miura")
    image = pixels(thick_png_bytes(scene, plates))
    rows = -(-plates.count // 4)
    assert image.shape == (880 + 400 * rows, 1600, 3)
    for plate in range(plates.count):
        row, column = divmod(plate, 4)
        cell = image[880 + 400 * row : 1280 + 400 * row, 400 * column : 400 * (column + 1)]
        parts = saturated(cell)
        inner = drawing_box(Box(0, 0, 400, 400))
        bed = min(inner.width, inner.height) - 4
        rows_in, columns_in = (np.flatnonzero(parts.any(axis=k)) for k in (1, 0))
        assert parts.sum() > 1000
        assert np.ptp(columns_in) < bed
        assert np.ptp(rows_in) < bed


def orange(image) -> int:
    return ((image[..., 0] > 200) & (image[..., 2] < 60) & (image[..., 1] > 90)).sum()


def test_what_was_read_is_shown_with_places_letters_and_form():
    pattern = miura_pattern()
    places = ((10.0, 5.0),)
    finding = Finding("edges-merged", Severity.WARNING, "two lines are one", places=places)
    read = PatternFile("m", pattern, (), (finding,))
    with_form = pixels(reading_png_bytes(read, "m"))
    flat = PatternFile("m", replace(pattern, folded_coords=None), (), ())
    without = pixels(reading_png_bytes(flat, "m"))
    assert orange(with_form) > 60 > orange(without)
    assert len(bars(with_form)) == 2
    assert len(bars(without)) == 1
    for image in (with_form, without):
        assert image.shape == (900, 1600, 3)


def test_long_names_stay_within_the_picture():
    scene = pattern_scene(miura_pattern(), "a_very_long_name_of_a_sheet" * 8)
    for data in (sheet_png_bytes(scene), states_png_bytes(scene)):
        image = pixels(data)
        _, _, left, right = inked(image)
        assert left >= 4
        assert right < image.shape[1] - 4


def test_cameras_fit_what_they_show():
    random = np.random.default_rng(2)
    points = random.normal(0, 30, (200, 3)) + 500
    for rise, turn in ((35.0, -60.0), (90.0, -90.0), (10.0, 200.0)):
        camera = fitted(view_axes(rise, turn), points, 300, 200, 10)
        at = camera.pixels(points)[:, :2]
        low, high = at.min(axis=0), at.max(axis=0)
        assert (low > [10 - 1e-6, 10 - 1e-6]).all()
        assert (high < [290 + 1e-6, 190 + 1e-6]).all()
        gaps = np.array([low[0] - 10, low[1] - 10])
        assert gaps.min() == pytest.approx(0, abs=1e-6)
        finer = camera.finer(3)
        assert finer.pixels(points) == pytest.approx(3 * camera.pixels(points))
