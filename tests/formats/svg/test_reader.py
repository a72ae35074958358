"""SVG files of many programs give the lines, letters and angles that their drawings show."""

import gzip
import re
from collections import Counter
from math import pi
from pathlib import Path

import numpy as np
import pytest
from flat_patterns import grid, pattern_of, triangles
from formats.svg import dialects
from helpers import TEMPLATES
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fab import read_pattern
from fab.drawings.svg import svg_bytes
from fab.errors import InvalidFile
from fab.formats.drawn.line_soup import LineSoup
from fab.formats.read_options import ReadOptions
from fab.formats.svg.reader import FLATNESS_MM, read_svg
from fab.formats.svg.viewports import PX_MM
from fab.formats.svg.writer import simulator_svg_bytes
from fab.jobs.job import load_job
from fab.jobs.job_files import make
from fab.pattern.crease_pattern import scaled
from fab.sheets.crease_styles import DashStyle, DotStyle
from fab.sheets.perforation import PerforationSettings, perforate
from fab.sheets.relief_holes import ReliefSettings

HERE = Path(__file__).parent
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">'


def read(tmp_path: Path, text: str | bytes, **options) -> LineSoup:
    path = tmp_path / "drawing.svg"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_svg(path, ReadOptions(**options))


def drawn(tmp_path: Path, inside: str, **options) -> LineSoup:
    return read(tmp_path, f"{HEAD}{inside}</svg>", **options)


def codes(soup: LineSoup) -> set[str]:
    return {finding.code for finding in soup.findings}


def text_of(soup: LineSoup, code: str) -> str:
    return next(finding.text for finding in soup.findings if finding.code == code)


def lengths(coords: np.ndarray, letters: np.ndarray) -> dict[str, float]:
    length = np.hypot(*(coords[:, 1] - coords[:, 0]).T)
    return {str(letter): float(length[letters == letter].sum()) for letter in np.unique(letters)}


def in_order(coords: np.ndarray, letters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lines from the corner of the drawing, each with its lower end first, and their order."""
    ends = coords - coords.min(axis=(0, 1))
    near = np.abs(ends[:, 0, 0] - ends[:, 1, 0]) < 1e-4
    back = np.where(near, ends[:, 0, 1] > ends[:, 1, 1], ends[:, 0, 0] > ends[:, 1, 0])
    ends[back] = ends[back, ::-1]
    rounded = np.round(ends.reshape(-1, 4), 3)
    return ends, np.lexsort((*rounded.T, letters))


def assert_same_lines(soup: LineSoup, lines: dialects.Source, angles: bool) -> None:
    found = soup.lines_coords * soup.mm_per_unit
    assert Counter(soup.lines_assignment.tolist()) == Counter(lines.letters.tolist())
    wanted = lengths(lines.coords, lines.letters)
    assert lengths(found, soup.lines_assignment) == pytest.approx(wanted, rel=1e-6)
    a, first = in_order(found, soup.lines_assignment)
    b, second = in_order(lines.coords, lines.letters)
    size = np.ptp(b)
    assert a[first] == pytest.approx(
        b[second], rel=0, abs=1e-6 * size
    )  # neither turned nor mirrored
    folds = np.isin(soup.lines_assignment[first], ["M", "V"])
    given, expected = soup.lines_foldAngle[first][folds], lines.angles[second][folds]
    if angles and (np.abs(expected) < 180).any():
        assert given == pytest.approx(expected, abs=1e-6)
    else:
        assert np.isnan(given).all()


@pytest.mark.parametrize("name", dialects.NAMES)
@pytest.mark.parametrize("dialect", dialects.DIALECTS)
def test_every_dialect_says_what_its_program_drew(dialect, name, tmp_path):
    written = dialects.DIALECTS[dialect](dialects.lines_of(name))
    soup = read(tmp_path, written.text)
    assert_same_lines(soup, written.lines, written.angles)
    assert len(soup.elements) > soup.lines_element.max()


@pytest.mark.parametrize("name", sorted(set(dialects.NAMES) - set(dialects.OWN)))
def test_what_convert_writes_comes_back(name, tmp_path):
    written = dialects.ours(name)
    soup = read(tmp_path, written.text)
    assert soup.mm_per_unit == 1
    assert_same_lines(soup, written.lines, written.angles)
    assert codes(soup) <= {"dashes-joined"}
    assert soup.title == name


def test_pinwheel_is_unlike_its_mirror_image():
    """So that the tests above would see a drawing that comes back mirrored."""
    lines = dialects.pinwheel()
    a, first = in_order(lines.coords, lines.letters)
    b, second = in_order(lines.coords * [1, -1], lines.letters)
    assert np.abs(a[first] - b[second]).max() > 1


# --- our own sheets ---


def sheet_of(pattern, kerf_mm: float, **settings) -> bytes:
    paths, _ = perforate(pattern, PerforationSettings(**settings), kerf_mm)
    return svg_bytes(paths, "sheet")


@pytest.mark.parametrize("kerf", [0.0, 0.15, 0.4])
@pytest.mark.parametrize(
    "style",
    [
        {},
        {"margin_mm": 2.0},
        {"relief": ReliefSettings(web_mm=0.8)},
        {"relief": ReliefSettings(shape="polygon", web_mm=0.8)},
        {"mountain": DashStyle(cut_mm=6, gap_mm=2), "valley": DotStyle(dot_mm=0.5, pitch_mm=2.5)},
    ],
    ids=["plain", "wide margin", "round holes", "holes with corners", "dots"],
)
@pytest.mark.parametrize("name", ["bird_base", "crane", "miura", "square_twist", "waterbomb"])
def test_our_own_sheet_is_the_pattern_again(name, style, kerf, tmp_path):
    pattern = dialects.pattern(name)
    scale = 300 / np.ptp(pattern.vertices_coords[:, 0])
    pattern = scaled(pattern, factor=scale)
    soup = read(tmp_path, sheet_of(pattern, kerf, **style))
    ends = pattern.vertices_coords[pattern.edges_vertices]
    wanted = lengths(ends, pattern.edges_assignment)
    wanted = {letter: wanted[letter] for letter in "BMV"}  # others are not drawn
    found = lengths(soup.lines_coords, soup.lines_assignment)
    assert ("kerf-removed" in codes(soup)) == (kerf > 0 and "kerf-unknown" not in codes(soup))
    if kerf > 0 and "kerf-unknown" in codes(soup):  # larger by the kerf, and so are its creases
        assert name in ("miura", "square_twist")
        assert found == pytest.approx(wanted, rel=0, abs=5 * kerf)
        return
    assert found == pytest.approx(wanted, rel=2e-6)
    assert ("sheet-addition" in codes(soup)) == ("relief" in style)
    assert "crease-end-open" not in codes(soup)
    # every end of a crease is at a vertex of the pattern
    corner = pattern.vertices_coords - pattern.vertices_coords.min(axis=0)
    places = (soup.lines_coords - soup.lines_coords.min(axis=(0, 1))).reshape(-1, 2)
    apart = np.hypot(*np.moveaxis(places[:, None] - corner, 2, 0)).min(axis=1)
    assert apart.max() < 5e-3


@pytest.mark.parametrize("name", ["curved_fold", "crumpled", "miura"])
def test_sheets_of_jobs_are_their_patterns_again(name, tmp_path):
    """Creases that all but go straight on at their vertices, and very short ones, are resolved."""
    files = make(load_job(TEMPLATES / f"{name}.toml"), ["svg", "fold"]).files
    soup = read(tmp_path, files[f"{name}.svg"])
    path = tmp_path / "pattern.fold"
    path.write_bytes(files[f"{name}.fold"])
    pattern, _ = read_pattern(path)
    ends = pattern.vertices_coords[pattern.edges_vertices]
    letters = pattern.edges_assignment
    assert Counter(soup.lines_assignment.tolist()) == Counter(letters.tolist())
    found = lengths(soup.lines_coords, soup.lines_assignment)
    assert found == pytest.approx(lengths(ends, letters), rel=1e-6)


@settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**31), kerf=st.sampled_from([0.0, 0.15, 0.4]))
def test_sheets_with_a_curved_crease_are_their_patterns_again(seed, kerf, tmp_path):
    """Chords meet in pairs, also those too short for more than one dash, near the outline or not.

    The kerf is that of the outlines, or not known; never another one.
    """
    random = np.random.default_rng(seed)
    least = random.choice([2.0, 4.0, 9.0])
    y = np.cumsum(
        least + random.exponential(random.choice([0.5, 5.0]), int(random.integers(3, 25)))
    )
    y = np.concatenate([[0.0], y])
    x = 15.0 + 40.0 * y[-1] / 100 * np.sin(np.pi * y / y[-1]) + random.normal(0, 0.3, len(y))
    crease = np.column_stack([x, y])
    width = x.max() + random.choice([3.0, 60.0])
    corners = [[0.0, 0.0], [width, 0.0], [width, y[-1]], [0.0, y[-1]]]
    count = len(crease)
    across = list(range(4, 4 + count))
    faces = [[0, *across, 3], [1, 2, *across[::-1]]]
    pattern = pattern_of(np.concatenate([corners, crease]), faces)
    soup = read(tmp_path, sheet_of(pattern, kerf))
    found = lengths(soup.lines_coords, soup.lines_assignment)
    wanted = lengths(pattern.vertices_coords[pattern.edges_vertices], pattern.edges_assignment)
    assert Counter(soup.lines_assignment.tolist())["M"] == count - 1
    known = "kerf-unknown" not in codes(soup)
    assert found == pytest.approx(wanted, rel=0, abs=1e-3 if known else 5 * kerf + 1e-3)
    assert ("kerf-removed" in codes(soup)) == (known and kerf > 0)


def test_slits_of_our_own_sheets_stay_cuts(tmp_path):
    pattern = grid(3, 2, 40.0, cuts=[(5, 6)])
    soup = read(tmp_path, sheet_of(pattern, 0.15))
    ends = pattern.vertices_coords[pattern.edges_vertices]
    wanted = lengths(ends, pattern.edges_assignment)
    assert lengths(soup.lines_coords, soup.lines_assignment)["C"] == pytest.approx(wanted["C"])


@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**31))
def test_any_triangles_come_back_from_the_simulator_file(seed, tmp_path):
    pattern = triangles(seed)
    soup = read(tmp_path, simulator_svg_bytes(pattern, "t"))
    ends = pattern.vertices_coords[pattern.edges_vertices]
    angles = np.abs(pattern.edges_foldAngle) < 180
    lines = dialects.Source(ends, pattern.edges_assignment, pattern.edges_foldAngle)
    assert_same_lines(soup, lines, bool(angles.any()))


# --- structure ---


def test_groups_uses_symbols_and_nested_drawings():
    soup = read_svg(HERE / "nested.svg", ReadOptions())
    assert soup.title == "A flag of creases"
    assert soup.mm_per_unit == 1
    by_letter = {
        letter: np.round(soup.lines_coords[soup.lines_assignment == letter], 9).tolist()
        for letter in "MVCUF"
    }
    assert by_letter["M"] == [[[10, 0], [10, -40]]]
    assert by_letter["V"] == [[[25, 0], [25, -40]]]
    assert by_letter["C"] == [[[40, -20], [60, -20]]]
    assert by_letter["U"] == [[[30, -10], [35, -10]], [[35, -10], [35, -20]]]
    assert by_letter["F"] == [[[0, -40], [10, -30]]]
    assert (soup.lines_assignment == "B").sum() == 4
    assert soup.lines_foldAngle[soup.lines_assignment == "V"] == [90]
    assert soup.lines_foldAngle[soup.lines_assignment == "M"] == [-180]
    left_out = text_of(soup, "not-lines")
    for what in ("3 hidden shapes", "1 text", "1 image", "1 reference to other files"):
        assert what in left_out
    assert "1 filled shape without a stroke" in left_out
    assert "polyline 1" in text_of(soup, "clip-ignored")


def test_names_come_before_colours_and_unknown_colours_are_reported():
    soup = read_svg(HERE / "laser_colours.svg", ReadOptions())
    assert lengths(soup.lines_coords, soup.lines_assignment) == pytest.approx(
        {"C": 13 * 25.4, "U": 2 * 25.4, "?": 3 * 25.4}
    )
    text = text_of(soup, "colour-unknown")
    assert "2 lines have" in text
    assert "1 #808080" in text
    assert "1 rgb(139, 69, 19)" in text
    assert "--colours" in text
    options = ReadOptions(colours={"#808080": "V", "layer7": "M", "cut": "B"})
    soup = read_svg(HERE / "laser_colours.svg", options)
    assert lengths(soup.lines_coords, soup.lines_assignment) == pytest.approx(
        {"B": 13 * 25.4, "U": 2 * 25.4, "M": 3 * 25.4}
    )
    assert "colour-unknown" not in codes(soup)


def test_outlines_of_fills_are_taken_where_nothing_has_a_stroke():
    soup = read_svg(HERE / "silhouette.svg", ReadOptions())
    assert lengths(soup.lines_coords, soup.lines_assignment) == pytest.approx({"B": 400})
    assert "1 filled shape" in text_of(soup, "outline-of-fill")


FRAME = '<path d="M0 0H100V100H0Z M.3.3V99.7H99.7V.3Z"/>'
CREASE = '<path fill="#a00" d="M49.9.3V99.7H50.1V.3Z"/>'
DASHES = " ".join(f"M30 {y}v2h.3v-2z" for y in range(0, 100, 4))


@pytest.mark.parametrize(
    ("inside", "first", "width"),
    [
        (FRAME, "path 1 is a filled shape", "0.3 mm"),
        (FRAME.replace("V99.7H99.7V.3Z", "H99.7V99.7H.3Z"), "path 1 is", "0.3 mm"),
        (f"{FRAME}{CREASE}", "path 1 and 1 more are filled shapes", "0.3 mm"),
        (f'<rect width="100" height="100"/>{CREASE}', "path 1 is", "0.2 mm"),
        (f'<rect width="100" height="100"/><path fill="red" d="{DASHES}"/>', "path 1 is", "0.26"),
        ('<rect width="50" height="0.4" fill="blue" transform="rotate(9)"/>', "rect 1 is", "0.4"),
        ('<polygon points="0,0 90,60 90.2,60 .2,0"/>', "polygon 1 is", "0.1"),
        (f'{FRAME}<circle cx="20" cy="20" r="3"/>', "path 1 is", "0.3 mm"),
    ],
)
def test_outlines_of_strokes_are_refused(inside, first, width, tmp_path):
    with pytest.raises(InvalidFile) as error:
        drawn(tmp_path, inside)
    for words in (first, width, "drawing.svg", "stroke to path"):
        assert words in str(error.value)


def test_filled_shapes_that_look_like_creases_are_reported_beside_lines(tmp_path):
    square = '<rect width="100" height="100" fill="none" stroke="black"/>'
    text = '<path d="M5 5h3v9z"/>'
    soup = drawn(tmp_path, f'{square}{text}{CREASE}<g id="valleys"><path d="M5 50h3v9z"/></g>')
    told = text_of(soup, "fill-of-crease")
    assert "2 filled shapes without a stroke" in told
    assert "the first is path 2" in told
    assert "3 filled shapes without a stroke" in text_of(soup, "not-lines")
    assert "fill-of-crease" not in codes(drawn(tmp_path, square + text))


SQUARES = "M0 0H40V40H0Z M60 0V40H100V0Z"


@pytest.mark.parametrize(
    "inside",
    [
        f'{FRAME}{CREASE}<path d="M5 5H50" stroke="red"/>',
        '<rect width="100" height="100"/><rect x="20" y="30" width="60" height="0.5"/>',
        '<rect width="100" height="100"/><path fill="red" d="M50 0V100"/>',
        f'<path d="{SQUARES}"/>',
        '<path d="M0 0L100 100V0L0 100Z"/>',
        "".join(
            f'<rect x="{x}" y="{y}" width="1" height="1" fill="red"/>'
            for x in range(0, 100, 9)
            for y in range(0, 100, 9)
        ),
        '<rect width="100" height="9"/>',
        '<path d="M0 0Q50 1 100 0"/>',
    ],
)
def test_other_fills_are_no_outlines_of_strokes(inside, tmp_path):
    soup = drawn(tmp_path, inside)
    assert ("outline-of-fill" in codes(soup)) is ("stroke" not in inside)


def test_scribbles_take_no_longer_than_other_fills(tmp_path):
    corners = np.random.default_rng(1).uniform(0, 100, (3000, 2)).round(2)
    path = "L".join(f"{x} {y}" for x, y in corners)
    soup = drawn(tmp_path, f'<path d="M{path}Z M0 0H9V9Z"/>')
    assert "outline-of-fill" in codes(soup)


def test_exploded_dashes_are_joined_and_cuts_are_not():
    soup = read_svg(HERE / "exploded_dashes.svg", ReadOptions())
    found = {letter: soup.lines_coords[soup.lines_assignment == letter] for letter in "MVC"}
    assert len(found["M"]) == len(found["V"]) == 1
    assert np.sort(found["M"][0], axis=0).tolist() == [[40, -50], [40, 0]]
    assert np.sort(found["V"][0], axis=0).tolist() == [[0, -25], [40, -25]]
    assert len(found["C"]) == 4
    assert "10 dashes in 2 rows" in text_of(soup, "dashes-joined")


def test_dash_arrays_are_whole_lines(tmp_path):
    soup = drawn(tmp_path, '<path d="M0 0L30 40" stroke="red" stroke-dasharray="3 1"/>')
    assert lengths(soup.lines_coords, soup.lines_assignment) == {"M": 50}


@pytest.mark.parametrize(
    ("style", "letter", "angle"),
    [
        ('stroke="#f00"', "M", -180),
        ('stroke="#F008"', "M", -96),
        ('stroke="rgba(0,0,255,.25)"', "V", 45),
        ('stroke="hsl(240 100% 50% / 50%)" opacity=".5"', "V", 45),
        ('stroke="blue" style="stroke-opacity:.5;opacity:0.5"', "V", 45),
        ('stroke="red" data-foldAngle="-30"', "M", -30),
        ('stroke="red" data-foldAngle="30" opacity="0.5"', "M", -90),
        ('class="valley" stroke="red" stroke-opacity="0.1"', "V", 18),
        ('stroke="blue" opacity="0"', "V", 0),
        ('stroke="red" style="stroke:blue"', "V", 180),
        ('data-assignment="m" stroke="lime"', "M", -180),
    ],
)
def test_angles_are_the_opacity_of_the_stroke(style, letter, angle, tmp_path):
    other = '<line x2="9" stroke="red" opacity="0.9"/>'  # makes opacity one of angles
    soup = drawn(tmp_path, f'<line {style} x1="0" y1="0" x2="10" y2="20"/>{other}')
    assert soup.lines_assignment[0] == letter
    assert soup.lines_foldAngle[0] == pytest.approx(angle, abs=1e-9)


def test_opacity_of_groups_is_no_fold_angle(tmp_path):
    soup = drawn(tmp_path, '<g opacity="0.5"><line x2="9" stroke="red"/></g>')
    assert np.isnan(soup.lines_foldAngle).all()
    assert "group-opacity" in codes(soup)


def test_what_is_hidden_or_unknown_is_counted(tmp_path):
    line = '<line x2="9" stroke="red"/>'
    soup = drawn(
        tmp_path,
        f'{line}<g opacity="0">{line}<g opacity=".5">{line}</g></g><g style="opacity:0%">{line}</g>'
        f"<scribble>{line}</scribble><sketch/><set/>",
    )
    assert len(soup.lines_coords) == 1
    assert "3 hidden shapes" in text_of(soup, "not-lines")
    assert "2 elements of unknown kinds" in text_of(soup, "not-lines")
    assert "1 group" in text_of(soup, "group-opacity")


def at_x(soup: LineSoup) -> list[float]:
    return sorted(soup.lines_coords[:, 0, 0].tolist())


def upright(x: float, attributes: str = "") -> str:
    return f'<path d="M{x} 0V9" stroke="red" {attributes}/>'


FEATURE = 'requiredFeatures="http://www.w3.org/TR/SVG11/feature#Shape"'


@pytest.mark.parametrize(
    ("children", "x"),
    [
        (upright(1) + upright(2), 1),
        (upright(1, 'systemLanguage="xx"') + upright(2), 2),
        (upright(1, 'systemLanguage="de, EN-gb"') + upright(2), 1),
        (upright(1, 'systemLanguage="eng"') + upright(2, 'systemLanguage="en"'), 2),
        (upright(1, 'systemLanguage=""') + upright(2), 2),
        (upright(1, 'requiredExtensions="http://x.example"') + upright(2), 2),
        (upright(1, 'requiredExtensions=""') + upright(2), 2),
        (upright(1, 'requiredFeatures="x"') + upright(2), 2),
        (upright(1, FEATURE) + upright(2), 1),
        (f"<title>t</title><desc/>{upright(1)}{upright(2)}", 1),
        (f"<g>{upright(1)}</g><g>{upright(2)}</g>", 1),
    ],
)
def test_the_first_alternative_that_is_meant_is_drawn(children, x, tmp_path, monkeypatch):
    monkeypatch.setenv("LANG", "de_DE.UTF-8")
    soup = drawn(tmp_path, f"<switch>{children}</switch>")
    assert at_x(soup) == [x]
    assert "1 shape for other languages or programs" in text_of(soup, "not-lines")


def test_alternatives_without_lines_are_not_counted(tmp_path):
    other = '<foreignObject requiredExtensions="x" width="1" height="1"/>'
    soup = drawn(tmp_path, f"<switch>{other}{upright(1)}<text>A</text></switch>")
    assert at_x(soup) == [1]
    assert codes(soup).isdisjoint({"not-lines"})


def test_what_is_for_other_languages_is_left_out_anywhere(tmp_path):
    soup = drawn(
        tmp_path,
        f'{upright(1)}<g systemLanguage="de">{upright(2)}<rect width="x"/></g>'
        f'<switch>{upright(3, """systemLanguage="de" """)}</switch>',
    )
    assert at_x(soup) == [1]
    assert "3 shapes for other languages or programs" in text_of(soup, "not-lines")


def test_compressed_drawings_are_those_that_are_in_them(tmp_path):
    text = f'{HEAD}<path d="M0 0L9 9" stroke="red"/></svg>'.encode()
    packed, plain = read(tmp_path, gzip.compress(text)), read(tmp_path, text)
    assert packed.lines_coords.tolist() == plain.lines_coords.tolist()
    assert packed.findings == plain.findings


def test_style_sheets_follow_the_order_of_css(tmp_path):
    sheet = (
        "@import url(other.css); .a {stroke: red} #b {stroke: blue} line {stroke: lime}"
        " g > .c {stroke: yellow !important} .d::before {stroke: red} .e:unknown {stroke: red}"
    )
    lines = "".join(
        f'<g><line {what} x2="5" y2="{n}"/></g>'
        for n, what in enumerate(
            [
                'class="a" stroke="black"',
                'class="a" id="b"',
                'stroke="black"',
                'class="c" style="stroke:red"',
                'class="a" style="stroke:blue"',
            ],
            1,
        )
    )
    soup = drawn(tmp_path, f"<style>{sheet}</style>{lines}")
    assert soup.lines_assignment.tolist() == ["M", "V", "C", "F", "V"]
    assert "2 rules of style sheets" in text_of(soup, "not-lines")
    sheet = "line {stroke: red} @media print {line {stroke: blue}}"
    soup = drawn(tmp_path, f"<style>{sheet}</style>{lines}")
    assert "1 rule of style sheets" in text_of(soup, "not-lines")


# --- shapes ---


def test_curves_become_chords_within_the_stated_distance(tmp_path):
    soup = drawn(
        tmp_path,
        '<circle cx="50" cy="50" r="40" stroke="red" fill="none"/>'
        '<path d="M0 0A30 30 0 0 1 60 0" stroke="blue"/>',
    )
    for letter, centre, radius in (("M", (50, -50), 40), ("V", (30, 0), 30)):
        ends = soup.lines_coords[soup.lines_assignment == letter]
        assert np.hypot(*(ends - centre).reshape(-1, 2).T) == pytest.approx(radius)
        middle = np.hypot(*(ends.mean(axis=1) - centre).T)
        assert (radius - middle).max() <= FLATNESS_MM * (1 + 1e-9)
    assert "2 curves" in text_of(soup, "curve-flattened")
    assert "0.012 mm" in text_of(soup, "curve-flattened")  # 1e-4 of the diagonal
    length = lengths(soup.lines_coords, soup.lines_assignment)
    assert length["M"] == pytest.approx(2 * pi * 40, rel=2e-3)


@pytest.mark.parametrize("size", [0.1, 10, 1e3])
def test_chords_suit_the_drawing_whatever_its_size(tmp_path, size):
    """A disc drawn in a few pixels is no polygon on a large sheet."""
    soup = drawn(tmp_path, f'<circle r="{size}" stroke="red" fill="none"/>')
    middle = np.hypot(*soup.lines_coords.mean(axis=1).T)
    assert (size - middle).max() <= min(FLATNESS_MM, 1e-4 * 2**1.5 * size) * (1 + 1e-9)


@pytest.mark.parametrize(
    "turned",
    [
        'transform="rotate(90)" transform-origin="70 30"',
        'transform="rotate(90)" transform-origin="70% center"',
        'style="transform: rotate(90deg); transform-origin: center 70px"',
    ],
)
def test_transforms_are_about_their_origin(tmp_path, turned):
    soup = read(
        tmp_path,
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">'
        f'<line x1="40" y1="30" x2="100" y2="30" stroke="blue" {turned}/></svg>',
    )
    x, y = (50, 70) if "center 70" in turned else (70, 30)
    ends = np.array([[40, 30], [100, 30]]) - [x, y]
    wanted = ends @ [[0, 1], [-1, 0]] + [x, y]
    assert soup.lines_coords[0] == pytest.approx(wanted * [1, -1], abs=1e-9)


def test_transforms_of_other_kinds_are_told(tmp_path):
    soup = drawn(
        tmp_path,
        '<line x2="9" stroke="red" style="translate: 5px"/>'
        '<line x2="9" stroke="red" '
        'style="transform: scale(2); transform-box: fill-box; transform-origin: center"/>',
    )
    assert "of 2 elements" in text_of(soup, "transform-unreadable")


@pytest.mark.parametrize(
    ("moved", "end"),
    [
        ('transform="translate(7-3)"', (17, -3)),
        ('transform=" scale( 2 , 3 ),translate(1e0 .5.5) "', None),
        ('transform="scale(2, 3),translate(1e0.5)"', (22, 1.5)),
        ('transform="rotate(90 , 10 5)"', (15, 5)),
        ('transform="skewX(45) matrix(1 0 0 1 0 2)"', (12, 2)),
        ('transform="none"', (10, 0)),
        ('transform=""', (10, 0)),
        ('transform="translate(1cm 0)"', None),
        ('transform="translate(3px, 4px)"', None),
        ('transform="rotate(90deg)"', None),
        ('transform="matrix(1 0 0)"', None),
        ('transform="translate(1 2 3)"', None),
        ('transform="translate(1,,2)"', None),
        ('transform="translate(5%)"', None),
        ('transform="scaleX(2)"', None),
        ('transform="translate(1 2) 5"', None),
        ('transform=", scale(2)"', None),
        ('style="transform:translate(10mm,0)"', (10 + 10 / PX_MM, 0)),
        ('style="transform: translate(1cm, -1in)"', (10 + 10 / PX_MM, -96)),
        ('style="transform:translateX(3pt) translateY(1pc)"', (14, 16)),
        ('style="transform:translate(4px)"', (14, 0)),
        ('style="transform:rotate(90deg)"', (0, 10)),
        ('style="transform:rotate(.25turn)"', (0, 10)),
        ('style="transform:rotate(100grad)"', (0, 10)),
        ('style="transform:rotate(1.5707963267948966rad)"', (0, 10)),
        ('style="transform:scaleX(2)scaleY(3)"', (20, 0)),
        ('style="transform:skew(0, 45deg)"', (10, 10)),
        ('style="transform:skewY(45deg)"', (10, 10)),
        ('style="transform:matrix(2,0,0,2,1,3)"', (21, 3)),
        ('style="transform:none" transform="scale(2)"', (10, 0)),
        ('style="transform:scale(3)" transform="scale(2)"', (30, 0)),
        ('class="cm"', (10 + 10 / PX_MM, 0)),
        ('style="transform:translate(50%, 0)"', None),
        ('style="transform:translate(1em, 0)"', None),
        ('style="transform:translate(3, 4)"', None),
        ('style="transform:translate(3px 4px)"', None),
        ('style="transform:rotate(90)"', None),
        ('style="transform:rotate(1px)"', None),
        ('style="transform:scale(2px)"', None),
        ('style="transform:translate(calc(1px + 2px), 0)"', None),
        ('style="transform:rotate3d(0,0,1,90deg)"', None),
        ('style="transform:var(--t)"', None),
    ],
)
def test_transforms_are_read_with_their_units_or_reported(moved, end, tmp_path):
    style = "<style>.cm {transform: translate(1cm, 0)}</style>"
    soup = drawn(tmp_path, f'{style}<line x2="10" stroke="red" {moved}/>')
    x, y = soup.lines_coords[0, 1]
    assert (x, -y) == pytest.approx(end or (10, 0), abs=1e-9)
    assert ("transform-unreadable" in codes(soup)) is (end is None)


@pytest.mark.parametrize(
    ("around", "width", "told"),
    [
        ("", 'stroke-width="0"', True),
        ("", 'style="stroke-width:0mm"', True),
        ("", 'style="stroke-width: 0.0%"', True),
        ("", 'class="hair"', True),
        ('stroke-width="0"', "", True),
        ('style="stroke-width:0px"', 'stroke-width="inherit"', True),
        ('stroke-width="0"', 'stroke-width="0.001"', False),
        ('stroke-width="0"', 'style="stroke-width:1px"', False),
        ('stroke-width="0"', 'style="stroke-width:initial"', False),
        ("", "", False),
    ],
)
def test_hairlines_without_width_are_lines_and_reported(around, width, told, tmp_path):
    style = "<style>.hair {stroke-width: 0}</style>"
    soup = drawn(tmp_path, f'{style}<g {around}><line id="a" x2="9" stroke="red" {width}/></g>')
    assert soup.lines_assignment.tolist() == ["M"]
    assert ("stroke-without-width" in codes(soup)) is told
    if told:
        assert "1 shape with a stroke of width 0" in text_of(soup, "stroke-without-width")
        assert "line 'a'" in text_of(soup, "stroke-without-width")


def test_what_has_no_stroke_has_no_width_to_report(tmp_path):
    line = '<line x2="9" stroke="red"/>'
    hidden = '<g display="none"><line x2="9" stroke="red" stroke-width="0"/></g>'
    soup = drawn(tmp_path, f'{line}{hidden}<rect width="5" height="5" stroke-width="0"/>')
    assert "stroke-without-width" not in codes(soup)


def test_a_used_drawing_has_the_size_that_the_use_gives(tmp_path):
    soup = drawn(
        tmp_path,
        '<defs><svg id="s" width="10" height="6" viewBox="0 0 10 6"><path d="M3 0V6" stroke="red"/>'
        '</svg></defs><use href="#s" width="100" height="60"/><use href="#s" y="70"/>',
    )
    assert np.sort(lengths_each(soup)).tolist() == pytest.approx([6, 60])


def lengths_each(soup: LineSoup) -> np.ndarray:
    return np.hypot(*(soup.lines_coords[:, 1] - soup.lines_coords[:, 0]).T)


def test_bezier_curves_are_followed(tmp_path):
    soup = drawn(
        tmp_path, '<path d="M0 0C0 40 40 40 40 0S 80 -40 80 0q5 5 10 0t10 0" stroke="red"/>'
    )
    t = np.linspace(0, 1, 4001)[:, None]
    curve = 3 * t * (1 - t) ** 2 * [0, -40] + 3 * t**2 * (1 - t) * [40, -40] + t**3 * [40, 0]
    first = soup.lines_coords[soup.lines_coords[..., 0].max(axis=1) <= 40 + 1e-9]
    for points in (first.reshape(-1, 2), first.mean(axis=1)):
        gap = np.hypot(*np.moveaxis(points[:, None] - curve, 2, 0)).min(axis=1)
        assert gap.max() <= FLATNESS_MM
    assert soup.lines_coords.reshape(-1, 2)[-1] == pytest.approx([100, 0])


def test_curves_that_are_straight_are_lines(tmp_path):
    soup = drawn(tmp_path, '<path d="M0 0C10 0 20 0 30 0" stroke="red"/>')
    assert len(soup.lines_coords) == 1
    assert "curve-flattened" not in codes(soup)


@pytest.mark.parametrize(
    ("shape", "length"),
    [
        ('rect x="1" y="2" width="10" height="20"', 60),
        ('rect width="10" height="20" rx="3"', 60 - 24 + 6 * pi),
        ('rect width="10" height="20" rx="30" ry="0"', 60),
        ('polygon points="0,0 3,0 3 4"', 12),
        ('polyline points="0,0 3,0 3,4"', 7),
        ('line x1="10%" x2="60%"', 50),
        ('ellipse cx="9" rx="5"', 10 * pi),
        ('path d="M0 0h3v4z"', 12),
        ('path d="m1 1 3 0 0 4z l -1 0"', 13),
        ('path d="M0-1.5.5-1.5"', 0.5),
        ('path d="M1e1,0H20"', 10),
    ],
)
def test_shapes_have_their_length(shape, length, tmp_path):
    soup = drawn(tmp_path, f'<{shape} stroke="black" fill="none"/>')
    found = lengths(soup.lines_coords, soup.lines_assignment)["B"]
    assert found == pytest.approx(length, rel=1e-9 if length % 1 == 0 else 5e-3)


def test_broken_data_is_read_up_to_its_fault(tmp_path):
    soup = drawn(
        tmp_path,
        '<path d="M0 0L10 0L10 x" stroke="red"/><path d="M0 0HNaNV5" stroke="red"/>'
        '<path id="q" d="M0 0C1 2 3 4 5 0 L 5 9 C 1" '
        'stroke="blue"/><g transform="turn(3)"><line x2="9" stroke="lime"/></g>',
    )
    assert lengths(soup.lines_coords, soup.lines_assignment)["M"] == 10
    assert lengths(soup.lines_coords, soup.lines_assignment)["V"] > 9
    assert "3 shapes" in text_of(soup, "shape-unreadable")
    assert "path 1" in text_of(soup, "shape-unreadable")
    assert "g 1" in text_of(soup, "transform-unreadable")


def test_marks_of_vertices_are_left_out(tmp_path):
    dots = "".join(
        f'<circle cx="{x}" cy="{y}" r="0.5" style="fill:#fff;stroke:#000"/>'
        for x, y in ((0, 0), (80, 0), (80, 60))
    )
    hole = '<circle cx="30" cy="20" r="0.5" stroke="#000" fill="#fff"/>'
    lines = '<path d="M0 0H80V60" stroke="red"/>'
    soup = drawn(tmp_path, dots + hole + lines)
    assert "3 small circles" in text_of(soup, "vertex-mark")
    assert set(soup.lines_assignment.tolist()) == {"M", "B"}
    black = soup.lines_coords[soup.lines_assignment == "B"].reshape(-1, 2)
    assert black.mean(axis=0) == pytest.approx([30, -20])


# --- sizes ---


@pytest.mark.parametrize(
    ("attributes", "mm", "known"),
    [
        ('width="100mm" height="50mm" viewBox="0 0 200 100"', 50, True),
        ('width="10cm" viewBox="0 0 200 100"', 50, True),
        ('height="2in" viewBox="0 0 200 100"', 50.8, True),
        ('width="72pt" height="36pt" viewBox="0 0 200 100"', 12.7, True),
        ('width="100mm" height="100mm" viewBox="0 0 200 100"', 50, True),
        ('width="100mm" height="100mm"', 100 * 25.4 / 96, True),
        ('width="400px" height="200px" viewBox="0 0 200 100"', 200 * 25.4 / 96, False),
        ('width="400" viewBox="0 0 200 100"', 200 * 25.4 / 96, False),
        ('width="100%" height="100%" viewBox="0 0 200 100"', 100 * 25.4 / 96, False),
        ("", 100 * 25.4 / 96, False),
    ],
)
def test_units(attributes, mm, known, tmp_path):
    inside = '<line x2="100" stroke="red"/>'
    soup = read(tmp_path, f'<svg xmlns="http://www.w3.org/2000/svg" {attributes}>{inside}</svg>')
    length = lengths(soup.lines_coords, soup.lines_assignment)["M"]
    assert length * soup.mm_per_unit == pytest.approx(mm)
    assert ("unit-unknown" in codes(soup)) == (not known)
    options = {"mm_per_unit": 2.0}
    soup = read(
        tmp_path, f'<svg xmlns="http://www.w3.org/2000/svg" {attributes}>{inside}</svg>', **options
    )
    if not known:
        assert soup.mm_per_unit == 2
        assert "unit-unknown" not in codes(soup)


def test_aspect_ratio_of_the_page(tmp_path):
    page = 'width="100mm" height="100mm" viewBox="0 0 20 10"'
    inside = '<path d="M0 0H20V10" stroke="red"/>'
    for fit, corner in (("none", (100, -100)), ("xMinYMax slice", (200, -100)), ("", (100, -75))):
        text = f'<svg {page} preserveAspectRatio="{fit}">{inside}</svg>'
        assert read(tmp_path, text).lines_coords.reshape(-1, 2)[-1] == pytest.approx(corner)


@pytest.mark.parametrize(
    ("head", "pixel", "whose"),
    [
        ("<!-- Generator: Adobe Illustrator 26 -->", 25.4 / 72, "Adobe Illustrator"),
        ("<!-- Created with Inkscape -->", 25.4 / 96, "1/96 inch"),
    ],
)
def test_pixels_of_programs(head, pixel, whose, tmp_path):
    soup = read(tmp_path, f'{head}<svg viewBox="0 0 9 9"><path d="M0 0H9" stroke="red"/></svg>')
    assert soup.mm_per_unit == pytest.approx(pixel)
    assert whose in text_of(soup, "unit-unknown")


# --- refused ---

LINE = '<line x2="9" stroke="red"/>'
BOMB = "".join(f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(9))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty"),
        ("  \n", "empty"),
        ("\0\1\2", "not XML"),
        ("<svg><line></svg>", "not XML at line 1"),
        ("<html><svg/></html>", "'html', not svg"),
        ("<svg/>", "no line"),
        ('<svg><text>x</text><rect width="9"/></svg>', "1 text"),
        ('<svg><image href="x.png"/></svg>', "picture of pixels"),
        ('<svg><g display="none"><path d="M0 0H9" stroke="red"/></g></svg>', "1 hidden shape"),
        (f'<!DOCTYPE svg [<!ENTITY a0 "x">{BOMB}]><svg>&a9;{LINE}</svg>', "entity 'a1'"),
        (f'<!DOCTYPE svg [<!ENTITY a SYSTEM "/etc/passwd">]><svg>&a;{LINE}</svg>', "another file"),
        (f'<!DOCTYPE svg [<!ENTITY % a "x">]><svg>{LINE}</svg>', "entity 'a'"),
        (f'<!DOCTYPE s [<!ENTITY a "{"x" * 999}">]><svg>{"&a;" * 2000}{LINE}</svg>', "over 1 MB"),
        (f"<svg>{'<g>' * 300}{LINE}{'</g>' * 300}</svg>", "256 deep"),
        ('<svg><line x2="1e301" stroke="red"/></svg>', "line 1 has a coordinate of 1e+301"),
        ('<svg><path d="M0 0L1e999 0" stroke="red"/></svg>', "coordinate of inf"),
        (b"\x1f\x8b123", "damaged"),
        (gzip.compress(f"{HEAD}</svg>".encode(), mtime=0)[:-9], "ends too early"),
        (gzip.compress(b" " * 100_000_001, mtime=0), "larger than 100 MB"),
        ('<?xml version="1.0" encoding="klingon"?><svg/>', "encoding"),
        ('<svg><line stroke="red"/></svg>', "no line"),
        (
            "<svg>"
            + "".join(f'<g id="g{n}">{f"""<use href="#g{n + 1}"/>""" * 10}</g>' for n in range(8))
            + f'<g id="g8">{LINE}</g></svg>',
            "draw more than",
        ),
    ],
)
def test_refused(text, words, tmp_path):
    with pytest.raises(InvalidFile) as error:
        read(tmp_path, text)
    assert words in str(error.value)
    assert "drawing.svg" in str(error.value)


def test_missing_file():
    with pytest.raises(InvalidFile, match=r"cannot be read"):
        read_svg(HERE / "missing.svg", ReadOptions())


def test_uses_in_a_circle_are_left_out(tmp_path):
    soup = drawn(tmp_path, f'<g id="a"><use href="#b"/>{LINE}</g><g id="b"><use href="#a"/></g>')
    assert "use-unresolved" in codes(soup)


def test_other_encodings(tmp_path):
    text = f'<?xml version="1.0" encoding="UTF-16"?><svg><title>Fälten</title>{LINE}</svg>'
    assert read(tmp_path, text.encode("utf-16")).title == "Fälten"


def test_mutated_files_are_read_or_refused(tmp_path):
    generator = np.random.default_rng(7)
    bases = [path.read_bytes() for path in sorted(HERE.glob("*.svg"))]
    bases += [
        dialects.DIALECTS[name](dialects.pinwheel()).text.encode() for name in dialects.DIALECTS
    ]
    refused = 0
    for number in range(100):
        data = mutated(bytearray(bases[number % len(bases)]), generator)
        try:
            read(tmp_path, bytes(data))
        except InvalidFile:
            refused += 1
    assert 0 < refused < 100


WORDS = [
    b"NaN",
    b"1e999",
    b"-1",
    b"%",
    b'"',
    b"<",
    b"</g>",
    b"url(#a)",
    b"0",
    b"inherit",
    b"M",
    b"a",
]
WORDS += [b"&amp;", b"99999999", b"none", b"matrix(", b"var(--x)", b"\xff", b"e", b".", b"C1,2"]


def mutated(data: bytearray, generator: np.random.Generator) -> bytearray:
    """A file with a few pieces changed, cut out, repeated or exchanged for awkward words."""
    for _ in range(int(generator.integers(1, 6))):
        at = int(generator.integers(len(data)))
        size = int(generator.integers(1, 40))
        match int(generator.integers(5)):
            case 0:
                data[at] = int(generator.integers(256))
            case 1:
                del data[at : at + size]
            case 2:
                data[at:at] = data[at : at + size]
            case 3:
                data[at : at + 1] = WORDS[int(generator.integers(len(WORDS)))]
            case 4:
                to = int(generator.integers(len(data)))
                data[to : to + size] = data[at : at + size]
    return data


def test_arcs_beyond_the_range_of_floats_are_refused(tmp_path):
    """Without a warning of numpy, which would be an error."""
    path = '<path d="M1e308 10A1e308 1e308 0 0 1 -1e308 9" stroke="red" transform="scale(1e300)"/>'
    with pytest.raises(InvalidFile, match="coordinate"):
        drawn(tmp_path, path)


@pytest.mark.parametrize("scale", ["1e300", "1e307"])
def test_curves_that_are_too_large_are_refused_without_a_warning(scale, tmp_path):
    path = f'<path d="M0 0C0 9 9 9 9 0S1 2 3 4Q5 6 7 8" stroke="red" transform="scale({scale})"/>'
    with pytest.raises(InvalidFile, match="path 1 has a coordinate of"):
        drawn(tmp_path, path)


@pytest.mark.parametrize("value", ["nan", "abc", "1_0", "inf", "1e999", ""])
def test_coordinates_that_are_no_numbers_are_refused(tmp_path, value):
    path = tmp_path / "odd.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'
        f'<line x1="{value}" y1="0" x2="5" y2="9" stroke="#f00"/></svg>'
    )
    with pytest.raises(InvalidFile, match=f"x1 = '{value}' of line 1 is no length"):
        read_svg(path, ReadOptions())


LINE = '<path d="M0 0H9" stroke="red"/>'
HREF = 'href="#part"'


@pytest.mark.parametrize(
    ("page", "content", "place"),
    [
        ('width="x" height="9mm"', LINE, "width = 'x' of the outermost svg is no length"),
        ('width="9mm" height="nan"', LINE, "height = 'nan' of the outermost svg is no length"),
        ('width="9parsec"', LINE, "width = '9parsec' of the outermost svg is no length"),
        ('viewBox="0 0 9"', LINE, "viewBox = '0 0 9' of the outermost svg is no rectangle"),
        ('viewBox="0 0 0 9"', LINE, "'0 0 0 9' of the outermost svg is no rectangle"),
        ('viewBox="0 0 9 9 9"', LINE, "'0 0 9 9 9' of the outermost svg is no rectangle"),
        ('viewBox="0 0 9 nan"', LINE, "'0 0 9 nan' of the outermost svg is no rectangle"),
        ('viewBox="0 0 9 1e999"', LINE, "'0 0 9 1e999' of the outermost svg is no rectangle"),
        ("", f'<svg x="left">{LINE}</svg>', "x = 'left' of svg 2 is no length"),
        ("", f'<svg id="in" viewBox="a">{LINE}</svg>', "viewBox = 'a' of svg 'in' is no rectangle"),
        ("", f'<use {HREF} x="abc"/>', "x = 'abc' of use 1 is no length"),
        ("", f'<use {HREF} y=""/>', "y = '' of use 1 is no length"),
        ("", f'<use {HREF} width="1,5"/>', "width = '1,5' of use 1 is no length"),
        ("", '<rect width="a" height="2" stroke="red"/>', "width = 'a' of rect 1 is no length"),
        ("", '<rect width="3" height="2" rx="b"/>', "rx = 'b' of rect 1 is no length"),
        ("", '<circle r="wide" stroke="red"/>', "r = 'wide' of circle 1 is no length"),
    ],
)
def test_lengths_of_viewports_uses_and_shapes_that_are_none_are_refused(
    tmp_path, page, content, place
):
    path = tmp_path / "odd.svg"
    part = '<defs><path id="part" d="M0 0H5" stroke="red"/></defs>'
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {page}>{part}{content}</svg>')
    with pytest.raises(InvalidFile, match=re.escape(place)):
        read_svg(path, ReadOptions())


@pytest.mark.parametrize(
    "page",
    [
        'width="auto" height="auto" viewBox="0,0,9,9"',
        'width="100vw" height="100VH" viewBox=" 0 0  9 , 9 "',
        'width="100%" viewBox="0 0 9 9"',
        'x="0" y="0px" width=" 9 " viewBox="0 0 9e0 +9.0"',
    ],
)
def test_lengths_that_programs_write_are_read(tmp_path, page):
    path = tmp_path / "page.svg"
    hidden = '<g display="none"><rect width="none" height="1"/></g>'
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {page}>{hidden}{LINE}</svg>')
    soup = read_svg(path, ReadOptions())
    assert np.ptp(soup.lines_coords[..., 0]) * soup.mm_per_unit == pytest.approx(9 * PX_MM)


def test_a_made_up_encoding_is_named_in_short(tmp_path):
    path = tmp_path / "a.svg"
    path.write_bytes(b'<?xml version="1.0" encoding="%s"?><svg/>' % (b"x" * 30_000))
    with pytest.raises(InvalidFile, match="Save it as UTF-8") as refused:
        read_svg(path, ReadOptions())
    assert len(str(refused.value)) < len(str(path)) + 300
