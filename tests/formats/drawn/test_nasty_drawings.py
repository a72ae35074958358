"""Small nasty drawings, each with the answer that a careful reader gives."""

from itertools import pairwise

import numpy as np
import pytest
from line_soups import SQUARE, lengths, soup_of

from fab.errors import InvalidFile
from fab.formats.drawn.importer import pattern_of_lines
from fab.formats.read_options import ReadOptions


def box(x, y, z, w, letter="B"):
    return [
        (letter, x, y, z, y),
        (letter, z, y, z, w),
        (letter, z, w, x, w),
        (letter, x, w, x, y),
    ]


def star(count):
    turn = np.arange(count) * np.pi / count + 0.1
    arm = 40 * np.column_stack([np.cos(turn), np.sin(turn)])
    return [("M", *(50 + a), *(50 - a)) for a in arm]


def octagon(radius):
    turn = np.arange(9) * np.pi / 4
    corner = 50 + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return [("B", *a, *b) for a, b in pairwise(corner)]


ACROSS = ("M", 0, 50, 100, 50)
OPEN_SQUARE = SQUARE[:3]
TITLE = [*box(100, -60, 180, -40), ("B", 100, -50, 180, -50)]

# lines: faces, pieces, length by letter, codes that are and are not reported
READ = {
    "mountain and valley end to end": (
        [*SQUARE, ("M", 0, 50, 60, 50), ("V", 60, 50, 100, 50)],
        (2, 1, {"B": 400, "M": 60, "V": 40}, "lines-split", "duplicate-line"),
    ),
    "a cut on a part of a mountain": (
        [*SQUARE, ACROSS, ("C", 30, 50, 70, 50)],
        (2, 1, {"B": 400, "M": 60, "C": 40}, "duplicate-line", "crease-dangling"),
    ),
    "a facet crease under a valley": (
        [*SQUARE, ("F", 0, 50, 100, 50), ("V", 100, 50, 0, 50)],
        (2, 1, {"B": 400, "V": 100}, "duplicate-line", "lines-overlap"),
    ),
    "the border twice": (
        [*SQUARE, *SQUARE, ACROSS],
        (2, 1, {"B": 400, "M": 100}, "duplicate-line", "border-shared"),
    ),
    "a mountain on the border": (
        [*SQUARE, ("M", 0, 0, 100, 0)],
        (1, 1, {"B": 400}, "duplicate-line", "line-outside"),
    ),
    "fifty times the same": (
        [*SQUARE, *[ACROSS] * 50],
        (2, 1, {"B": 400, "M": 100}, "duplicate-line", "lines-overlap"),
    ),
    "a T-joint": (
        [*SQUARE, ACROSS, ("V", 50, 50, 50, 100)],
        (3, 1, {"B": 400, "M": 100, "V": 50}, "lines-split", "ends-extended"),
    ),
    "a T-joint too short by 0.05": (
        [*SQUARE, ACROSS, ("V", 50, 50.05, 50, 100)],
        (3, 1, {"B": 400, "M": 100, "V": 50}, "ends-extended", "crease-dangling"),
    ),
    "a T-joint too long by 0.05": (
        [*SQUARE, ACROSS, ("V", 50, 49.95, 50, 100)],
        (3, 1, {"B": 400, "M": 100, "V": 50}, "ends-extended", "crease-dangling"),
    ),
    "a crease that ends 2 before another": (
        [*SQUARE, ACROSS, ("V", 50, 52, 50, 100)],
        (2, 1, {"B": 400, "M": 100, "V": 48}, "crease-dangling", "ends-extended"),
    ),
    "a crease that ends 2 behind another": (
        [*SQUARE, ACROSS, ("V", 50, 48, 50, 100)],
        (3, 1, {"B": 400, "M": 100, "V": 52}, "crease-dangling", "ends-extended"),
    ),
    "a crease over the border by 0.05": (
        [*SQUARE, ("M", -0.05, 50, 100.05, 50)],
        (2, 1, {"B": 400, "M": 100}, "ends-extended", "line-outside"),
    ),
    "a crease over the border by 2": (
        [*SQUARE, ("M", -2, 50, 102, 50)],
        (2, 1, {"B": 400, "M": 100}, "line-outside", "ends-extended"),
    ),
    "a star that ends within": (
        [*SQUARE, *star(3)],
        (1, 1, {"B": 400, "M": 240}, "crease-dangling", "lines-bent"),
    ),
    "two parallels within the tolerance": (
        [*SQUARE, ACROSS, ("M", 0, 50.02, 100, 50.02)],
        (2, 1, {"B": 400, "M": 100}, "duplicate-line", "crease-dangling"),
    ),
    "two lines that part by less than the tolerance": (
        [*SQUARE, ACROSS, ("M", 0, 50, 100, 50.05)],
        (2, 1, {"B": 400, "M": 100}, "duplicate-line", "crease-dangling"),
    ),
    "a narrow wedge that is meant": (
        [*SQUARE, ACROSS, ("M", 0, 50, 100, 51)],
        (3, 1, {"B": 400, "M": 100 + np.hypot(100, 1)}, "lines-split", "duplicate-line"),
    ),
    "a gap of the border within the tolerance": (
        [*OPEN_SQUARE, ("B", 0, 100, 0, 0.1), ACROSS],
        (2, 1, {"B": 400, "M": 100}, "ends-joined", "border-unmarked"),
    ),
    "a gap of the border that a crease closes": (
        [*OPEN_SQUARE, ("M", 0, 0, 0, 100), ACROSS],
        (2, 1, {"B": 400, "M": 100}, "border-unmarked", "ends-joined"),
    ),
    "a hole across from a crease": (
        [*SQUARE, *box(30, 30, 60, 60), ("V", 0, 20, 100, 20)],
        (3, 1, {"B": 520, "V": 100}, "hole", "page-frame"),
    ),
    "a piece in a hole": (
        [*SQUARE, *box(20, 20, 80, 80), *box(30, 30, 60, 60)],
        (3, 2, {"B": 760}, "hole", "page-frame"),
    ),
    "a creased piece in the hole of a creased one": (
        [
            *SQUARE,
            *box(20, 20, 80, 80),
            *box(30, 30, 60, 60),
            ("M", 30, 45, 60, 45),
            ("V", 0, 10, 100, 10),
        ],
        (5, 2, {"B": 760, "M": 30, "V": 100}, "hole", "page-frame"),
    ),
    "a loop of creases within": (
        [*SQUARE, *box(30, 30, 60, 60, "M")],
        (3, 1, {"B": 400, "M": 120}, "island-joined", "hole"),
    ),
    "a slit from the border": (
        [*SQUARE, ("C", 50, 0, 50, 40)],
        (1, 1, {"B": 400, "C": 40}, "crease-dangling", "line-outside"),
    ),
    "a slit that misses the border by 0.05": (
        [*SQUARE, ("C", 50, 0.05, 50, 40)],
        (1, 1, {"B": 400, "C": 40}, "ends-extended", "line-outside"),
    ),
    "a slit within": (
        [*SQUARE, ("C", 50, 20, 50, 40)],
        (1, 1, {"B": 400, "C": 20}, "crease-dangling", "line-outside"),
    ),
    "a cut across": (
        [*SQUARE, ("C", 0, 50, 100, 50), ("M", 50, 0, 50, 100)],
        (4, 2, {"B": 400, "C": 100, "M": 100}, "lines-split", "crease-dangling"),
    ),
    "two sheets": (
        [*SQUARE, *box(120, 0, 200, 80), ACROSS, ("V", 120, 40, 200, 40)],
        (4, 2, {"B": 720, "M": 100, "V": 80}, "lines-split", "page-frame"),
    ),
    "two sheets side by side, both sides drawn": (
        [*SQUARE, *box(100, 0, 200, 100), ACROSS],
        (3, 2, {"B": 600, "C": 100, "M": 100}, "border-shared", "border-inside"),
    ),
    "two sheets that touch in a corner": (
        [*SQUARE, *box(100, 100, 200, 200), ACROSS],
        (3, 2, {"B": 800, "M": 100}, "lines-split", "border-shared"),
    ),
    "a page around the sheet": (
        [*box(-50, -50, 160, 247), *SQUARE, ACROSS],
        (2, 1, {"B": 400, "M": 100}, "page-frame", "hole"),
    ),
    "a page around two sheets": (
        [*box(-50, -50, 260, 247), *SQUARE, ACROSS, *box(120, 0, 200, 80), ("V", 120, 40, 200, 40)],
        (4, 2, {"B": 720, "M": 100, "V": 80}, "page-frame", "hole"),
    ),
    "a page that has its corner in that of the sheet": (
        [*box(0, 0, 210, 297), *SQUARE, ACROSS],
        (2, 1, {"B": 400, "M": 100}, "page-frame", "border-inside"),
    ),
    "a page as wide as the sheet": (
        [*box(0, -30, 100, 297), *SQUARE, ACROSS],
        (2, 1, {"B": 400, "M": 100}, "page-frame", "border-inside"),
    ),
    "a page with a sheet in a corner and another one": (
        [*box(0, 0, 260, 247), *SQUARE, ACROSS, *box(120, 9, 200, 89), ("V", 120, 40, 200, 40)],
        (4, 2, {"B": 720, "M": 100, "V": 80}, "page-frame", "hole"),
    ),
    "a double frame": (
        [*box(-50, -50, 160, 247), *box(-45, -45, 155, 242), *SQUARE, ACROSS],
        (2, 1, {"B": 400, "M": 100}, "page-frame", "hole"),
    ),
    "a triple frame": (
        [
            *box(-60, -60, 170, 257),
            *box(-50, -50, 160, 247),
            *box(-45, -45, 155, 242),
            *SQUARE,
            ACROSS,
        ],
        (2, 1, {"B": 400, "M": 100}, "page-frame", "hole"),
    ),
    "a double frame with a title block": (
        [*SQUARE, ACROSS, *box(-20, -60, 180, 140), *TITLE, *box(-30, -70, 190, 150)],
        (2, 1, {"B": 400, "M": 100}, "page-frame", "hole"),
    ),
    "a page around two sheets side by side, both sides drawn": (
        [*box(-50, -50, 260, 247), *SQUARE, *box(100, 0, 200, 100), ACROSS],
        (3, 2, {"B": 600, "C": 100, "M": 100}, "border-shared", "border-inside"),
    ),
    "a creased piece in a ring that is no page": (
        [*octagon(99), *octagon(80), *SQUARE, ACROSS],
        (4, 2, {"B": 400 + 16 * 179 * np.sin(np.pi / 8), "M": 100}, "hole", "page-frame"),
    ),
    "a page of no letter": (
        [*box(-50, -50, 160, 247, "?"), *SQUARE, ACROSS],
        (2, 1, {"B": 400, "M": 100}, "line-outside", "page-frame"),
    ),
    "a page with a title block": (
        [*SQUARE, ACROSS, *box(-20, -60, 180, 140), *TITLE],
        (2, 1, {"B": 400, "M": 100}, "page-frame", "hole"),
    ),
    "no border around closed creases": (
        [*box(0, 0, 100, 100, "M"), ("V", 0, 0, 100, 100)],
        (2, 1, {"B": 400, "V": np.hypot(100, 100)}, "border-found", "border-unmarked"),
    ),
    "a border that crosses itself": (
        [
            ("B", 0, 0, 100, 100),
            ("B", 100, 100, 100, 0),
            ("B", 100, 0, 0, 100),
            ("B", 0, 100, 0, 0),
        ],
        (2, 2, {"B": 200 + 2 * np.hypot(100, 100)}, "lines-split", "border-shared"),
    ),
    "a line that is a point": (
        [*SQUARE, ("M", 50, 50, 50, 50)],
        (1, 1, {"B": 400}, "zero-length-line", "crease-dangling"),
    ),
    "a crease of a thousand lines": (
        [*SQUARE, *(("M", i / 10, 50, (i + 1) / 10, 50) for i in range(1000))],
        (2, 1, {"B": 400, "M": 100}, "runs-joined", "duplicate-line"),
    ),
}

REFUSED = {
    "mountain and valley on each other": (
        [*SQUARE, ("M", 0, 50, 60, 50), ("V", 40, 50, 100, 50)],
        r"line 5 is a mountain and line 6 a valley .* from \(40, 50\) mm to \(60, 50\) mm",
    ),
    "a gap beyond the tolerance": (
        [*OPEN_SQUARE, ("B", 0, 100, 0, 0.2), ACROSS],
        r"a gap of 0.2 mm between \(0, 0\) mm and \(0, 0.2\) mm.*--merge-mm 0.202",
    ),
    "a border across": ([*SQUARE, ("B", 0, 50, 100, 50)], "line 5 .*--inner-border cut"),
    "a corner that is cut off by a border": (
        [*SQUARE, ACROSS, ("B", 0, 30, 30, 30), ("B", 30, 30, 30, 0)],
        "is a border .B. with the sheet on both sides",
    ),
    "a dimension line as a border": (
        [*SQUARE, ACROSS, ("B", 0, -10, 100, -10)],
        r"line 6 is a border that joins no other, from \(0, -10\) mm to \(100, -10\) mm. Remove",
    ),
    "creases alone that enclose nothing": ([ACROSS, ("V", 50, 0, 50, 100)], "--border hull"),
    "lines on each other without end": (
        [*SQUARE, *(("M", i / 40, 50, 50 + i / 40, 50) for i in range(2000))],
        "on other lines more than .* times. Draw each crease once",
    ),
}


@pytest.mark.parametrize("name", READ)
def test_what_is_read(name):
    """Faces, pieces and lengths are the right ones, whatever the order of the lines."""
    rows, (faces, pieces, wanted, found, absent) = READ[name]
    for order in (np.arange(len(rows)), np.random.default_rng(1).permutation(len(rows))):
        read = pattern_of_lines(soup_of([rows[i] for i in order]))
        assert read.pattern.face_count == faces
        assert len(np.unique(read.pattern.faces_piece)) == pieces
        total = lengths(read.pattern)
        total.pop("J", None)  # joins of faces around islands are ours
        assert total == pytest.approx(wanted, abs=0.15)
        codes = {finding.code for finding in read.findings}
        assert found in codes
        assert absent not in codes


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name):
    rows, text = REFUSED[name]
    with pytest.raises(InvalidFile, match=text):
        pattern_of_lines(soup_of(rows))


def test_a_page_is_a_repair():
    rows = [*box(-50, -50, 160, 247), *SQUARE, ("M", 0, 0, 100, 100)]
    with pytest.raises(InvalidFile, match="frame of a page"):
        pattern_of_lines(soup_of(rows), ReadOptions(strict=True))


def test_drawings_of_close_ends_have_a_tolerance_above_that_of_files_with_faces():
    """Rows of ends so close that the tolerance is halved again and again."""
    row = [("M", 50, 50 + 1e-7 * i, 99, 20 + i) for i in range(40)]
    read = pattern_of_lines(soup_of([*SQUARE, *row]))
    coords = read.pattern.vertices_coords
    apart = np.hypot(*(coords[:, None] - coords).transpose(2, 0, 1)) + np.eye(len(coords))
    assert apart.min() > 1e-8 * np.hypot(100, 100)


@pytest.mark.parametrize(("off", "passed"), [(1e-5, False), (1.0, True)])
def test_bridges_keep_clear_of_other_vertices(off, passed):
    """The end of a crease is beside the shortest bridge, from corner to corner."""
    crease = ("V", 20, 20 - off, 30, 5)
    read = pattern_of_lines(soup_of([*SQUARE, *box(40, 40, 60, 60, "M"), crease]))
    joins = read.pattern.edges_vertices[read.pattern.edges_assignment == "J"]
    ends = {
        tuple(sorted(map(tuple, pair))) for pair in read.pattern.vertices_coords[joins].tolist()
    }
    assert len(ends) == 2
    assert (((0.0, 0.0), (40.0, 40.0)) in ends) == passed
