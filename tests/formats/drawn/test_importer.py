"""Line soup made into patterns: every repair and refusal, and what must not change the result."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from flat_patterns import grid
from helpers import PATTERNS
from hypothesis import given
from hypothesis import strategies as st
from line_soups import SQUARE, lengths, soup_of, soup_of_pattern

from fab import read_pattern
from fab.errors import InvalidFile
from fab.formats.drawn.importer import pattern_of_lines
from fab.formats.fold.writer import fold_bytes
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file
from fab.formats.strictness import FACTS
from fab.geometry.rings import ring_areas
from solver.errors import InvalidValue

NAMES = sorted(path.stem for path in PATTERNS.glob("*.fold"))
CUT = ReadOptions(inner_border="cut")


def imported(rows, options=None, **changes):
    read = pattern_of_lines(soup_of(rows, **changes), options)
    require_sound(read.pattern)
    return read.pattern, {finding.code: finding for finding in read.findings}


def require_sound(pattern):
    """Faces are simple and counterclockwise, and each edge is beside the faces that have it."""
    areas = ring_areas(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets)
    assert (areas > 0).all()
    rings = np.split(pattern.faces_vertices, pattern.faces_offsets[1:-1])
    assert all(len(set(ring.tolist())) == len(ring) for ring in rings)
    for (first, second), pair in zip(
        pattern.edges_faces.tolist(), pattern.edges_vertices.tolist(), strict=True
    ):
        assert first >= 0
        if first != second:
            for face in {first, second} - {-1}:
                assert set(pair) <= set(rings[face].tolist())
    assert ((pattern.edges_faces[:, 1] < 0) == (pattern.edges_assignment == "B")).all()
    assert pattern.vertices_coords.min(axis=0).tolist() == [0, 0]


@pytest.mark.parametrize("name", NAMES)
def test_drawn_patterns_are_those_of_their_files(name):
    """Lengths by letter, area and angles; drawn lines have no numbers and fewer vertices."""
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    read = pattern_of_lines(soup_of_pattern(pattern))
    require_sound(read.pattern)
    assert {f.code for f in read.findings} <= {"runs-joined", "crease-dangling", "hole"}
    assert lengths(read.pattern) == pytest.approx(lengths(pattern), rel=1e-9)
    assert read.pattern.face_count == pattern.face_count
    weight = [
        sum(
            abs(p.edges_foldAngle)
            * np.hypot(*np.diff(p.vertices_coords[p.edges_vertices], axis=1)[:, 0].T)
        )
        for p in (pattern, read.pattern)
    ]
    assert weight[0] == pytest.approx(weight[1], rel=1e-9)


CREASE = ("V", 50, 0, 50, 100)


@pytest.mark.parametrize(
    ("rows", "code", "place", "counts"),
    [
        ([CREASE], "lines-split", "(50, 0) mm", {"V": 1, "B": 6}),
        (
            [("M", 0, 0, 100, 100), ("V", 0, 100, 100, 0)],
            "lines-split",
            "(50, 50)",
            {"M": 2, "V": 2, "B": 4},
        ),
        ([("V", 50, 0.08, 50, 99.95)], "ends-extended", "(50, 0.08) mm", {"V": 1, "B": 6}),
        ([("V", 50, -0.08, 50, 100.05)], "ends-extended", "(50, -0.08) mm", {"V": 1, "B": 6}),
        ([("V", 0.05, 0.05, 100, 99.9)], "ends-joined", "(0.05, 0.05) mm", {"V": 1, "B": 4}),
        ([CREASE, CREASE], "duplicate-line", "(50, 50) mm", {"V": 1, "B": 6}),
        ([CREASE, ("F", 50, 100, 50, 0)], "duplicate-line", "as V", {"V": 1, "B": 6}),
        ([CREASE, ("C", 50, 100, 50, 0)], "duplicate-line", "as C", {"V": 0, "B": 6, "C": 1}),
        ([CREASE, ("V", 50, 20, 50, 40)], "duplicate-line", "(50, 30)", {"V": 1, "B": 6}),
        ([CREASE, ("C", 50, 20, 50, 40)], "duplicate-line", "as C", {"V": 2, "B": 6, "C": 1}),
        (
            [("M", 0, 0, 60, 60), ("M", 100, 100, 40, 40)],
            "lines-overlap",
            "(40, 40) mm to (60, 60)",
            {"M": 1, "B": 4},
        ),
        ([("M", 0, 0, 50, 50), ("M", 50, 50, 100, 100)], "runs-joined", "", {"M": 1, "B": 4}),
        ([("F", 120, 20, 120, 40)], "line-outside", "from (120, 20) mm to (120, 40) mm", {"B": 4}),
        (
            [("V", 50, -5, 50, 100)],
            "line-outside",
            "from (50, -5) mm to (50, 0) mm",
            {"V": 1, "B": 6},
        ),
        ([("C", 20, 50, 80, 50)], "crease-dangling", "(50, 50) mm", {"C": 1, "B": 4}),
        ([("M", 20, 50, 80, 50)], "crease-dangling", "(50, 50) mm", {"M": 1, "B": 4}),
        ([("M", 0, 0, 80, 50)], "crease-dangling", "(40, 25) mm", {"M": 1, "B": 4}),
        (
            [("C", 30, 30, 60, 30), ("C", 60, 30, 40, 60), ("C", 40, 60, 30, 30)],
            "island-joined",
            "",
            {"C": 3, "J": 2, "B": 4},
        ),
        (
            [("B", 30, 30, 60, 30), ("B", 60, 30, 40, 60), ("B", 40, 60, 30, 30)],
            "hole",
            "mm",
            {"J": 2, "B": 7},
        ),
        ([("M", 50, 50, 50.0001, 50)], "zero-length-line", "(50, 50) mm", {"B": 4}),
    ],
)
def test_every_repair_names_its_place_and_its_edges(rows, code, place, counts):
    pattern, findings = imported([*SQUARE, *rows])
    assert code in findings, findings
    assert place in findings[code].text
    assert pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 0, **counts}
    assert pattern.vertices_coords.max(axis=0).tolist() == [100, 100]
    assert all(0 <= edge < len(pattern.edges_vertices) for edge in findings[code].creases)
    strict = ReadOptions(strict=True, fold_deg=180)
    if code in FACTS:
        imported(
            [*SQUARE, *(row for row in rows if code in ("crease-dangling", "lines-split"))], strict
        )
    else:
        with pytest.raises(InvalidFile, match=r"drawing.svg: "):
            imported([*SQUARE, *rows], strict)


LETTER_O = [
    ("B", 20, 20, 30, 20),
    ("B", 30, 20, 30, 30),
    ("B", 30, 30, 20, 30),
    ("B", 20, 30, 20, 20),
]


@pytest.mark.parametrize("letter", ["C", "U"])
def test_a_border_within_the_outline_of_the_sheet_is_refused(letter):
    """The outline is drawn to be cut, and only a letter that is written on it as a border is."""
    outline = [(letter, *row[1:]) for row in SQUARE]
    match = r"is within closed lines .*, and so is 1 crease beside it, .* at \(50, 50\) mm"
    with pytest.raises(InvalidFile, match=match):
        imported([*outline, *LETTER_O, CREASE])
    frame = [(letter, -20, -20, 150, -20), (letter, 150, -20, 150, 150),
             (letter, 150, 150, -20, 150), (letter, -20, 150, -20, -20)]  # fmt: skip
    legend = ("V", 110, 0, 110, 50)
    pattern, findings = imported([*SQUARE, CREASE, *frame, legend])
    assert findings["line-outside"].text.startswith("5 edges")
    assert pattern.counts()["V"] == 1


# A square of 80 with a line of 20 beside it, 30 below its upper side.
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="90mm" viewBox="0 0 200 90">'
    '<path fill="none" stroke="#000" d="M10 5H90V85H10Z"/>'
    '<path stroke="#f00" d="M100 35H120"/></svg>'
)
CP = "1 10 5 90 5\n1 90 5 90 85\n1 90 85 10 85\n1 10 85 10 5\n2 100 35 120 35\n"


@pytest.mark.parametrize(("name", "text"), [("a.svg", SVG), ("a.cp", CP)])
def test_places_in_texts_are_those_of_the_file_where_y_points_down(name, text, tmp_path):
    path = tmp_path / name
    for y, shown, height in (("35", "35", 50), ("-0.0", "0", 85), ("-2.5", "-2.5", 87.5)):
        path.write_text(text.replace("35", y))
        read = read_pattern_file(path)
        finding = next(each for each in read.findings if each.code == "line-outside")
        assert f"from (100, {shown}) mm to (120, {shown}) mm" in finding.text
        # in pictures of the pattern, above its lower left corner
        assert finding.places[0] - read.origin == pytest.approx([100, height])


def test_findings_name_edges_of_the_pattern():
    rows = [*SQUARE, ("V", 50, 0.05, 50, 100), ("M", 20, 50, 40, 60), ("M", 20, 50, 40, 60)]
    pattern, findings = imported(rows)
    (dangling,) = findings["duplicate-line"].creases
    assert pattern.edges_assignment[dangling] == "M"
    (crease,) = findings["ends-extended"].creases
    assert pattern.edges_assignment[crease] == "V"
    assert pattern.vertices_coords[pattern.edges_vertices[crease]][:, 0].tolist() == [50, 50]


@pytest.mark.parametrize(
    ("rows", "options", "match"),
    [
        ([("M", 0, 0, 10, 10)], None, "enclose no face. .* --border hull"),
        (
            [("M", 0, 0, 60, 60), ("V", 60, 0, 0, 60), ("M", 40, -9, 40, 70)],
            None,
            "no line is a border, and .* --border hull",
        ),
        (
            [*SQUARE[:3], ("B", 0, 100, 0, 2)],
            None,
            r"a gap of 2 mm between \(0, [02]\) mm .*--merge-mm",
        ),
        (
            [*SQUARE, ("B", 50, 0, 50, 50)],
            None,
            r"the outline is open at line 5: it ends at \(50, 50\)",
        ),
        (
            [*SQUARE, ("B", 50, 0, 50, 100)],
            None,
            r"line 5 from \(50, 0\) mm to \(50, 100\) mm is a",
        ),
        (
            [*SQUARE, CREASE, ("M", 50, 20, 50, 40)],
            None,
            "line 6 is a mountain and line 5 a valley .*from .50, 20. mm",
        ),
        ([*SQUARE, CREASE], ReadOptions(merge_mm=80), "merge-mm 80: must be under half"),
        ([], None, "no lines"),
    ],
)
def test_what_can_be_meant_in_two_ways_is_refused(rows, options, match):
    with pytest.raises(InvalidFile, match=match):
        imported(rows, options)


def test_creases_beside_a_gap_are_no_border():
    rows = [
        *SQUARE[:2], ("B", 100, 100, 51, 100), ("B", 49, 100, 0, 100), SQUARE[3],
        *(("V", 50, 50, x, y) for x, y in ((51, 100), (49, 100), (0, 0), (100, 0))),
    ]  # fmt: skip
    with pytest.raises(InvalidFile, match=r"a gap of 2 mm between \(51, 100\) mm and \(49, 100\)"):
        imported(rows)
    pattern, findings = imported(rows, ReadOptions(merge_mm=2.5))
    assert pattern.counts()["B"] == 5
    assert "(tolerance 2.5 mm: given by --merge-mm)" in findings["ends-joined"].text


def test_borders_within_the_sheet_are_cuts_where_asked_for():
    rows = [*SQUARE, ("B", 50, 0, 50, 100)]
    pattern, findings = imported(rows, CUT)
    assert pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 6, "C": 1}
    assert pattern.edges_assignment[findings["border-inside"].creases[0]] == "C"
    beside = [(x, a + 100, b, c + 100, d) for x, a, b, c, d in SQUARE]
    pattern, findings = imported([*SQUARE, *beside])
    assert pattern.counts()["C"] == 1
    assert "border-shared" in findings


def test_the_border_is_found_or_the_hull_is_taken():
    rows = [("M", *row[1:]) for row in SQUARE] + [("V", 0, 0, 100, 100)]
    pattern, findings = imported(rows)
    assert pattern.counts() == {"M": 0, "V": 1, "F": 0, "B": 4}
    assert len(findings["border-found"].creases) == 4
    star = [("M", 50, 50, x, y) for x, y in ((100, 50), (0, 50), (50, 100), (50, 0))]
    pattern, findings = imported(star, ReadOptions(border="hull"))
    assert pattern.counts() == {"M": 4, "V": 0, "F": 0, "B": 4}
    assert "border-hull" in findings
    drawn, findings = imported([*SQUARE, *star], ReadOptions(border="hull"))
    assert "border-hull" not in findings
    assert drawn.counts()["B"] == 8


def test_one_straight_side_may_lack_its_letter():
    rows = [*SQUARE[:3], ("?", 0, 100, 0, 0), CREASE]
    pattern, findings = imported(rows)
    assert pattern.counts()["B"] == 6
    assert pattern.edges_assignment[findings["border-unmarked"].creases[0]] == "B"


def test_parts_in_holes_are_pieces_of_their_own():
    def square(low, high, letter="B"):
        return [
            (letter, low, low, high, low), (letter, high, low, high, high),
            (letter, high, high, low, high), (letter, low, high, low, low),
        ]  # fmt: skip

    pattern, findings = imported([*square(0, 90), *square(20, 70), *square(30, 60)])
    assert pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 12, "J": 2}
    areas = ring_areas(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets)
    assert areas.sum() == pytest.approx(90**2 - 50**2 + 30**2)
    assert len(np.unique(pattern.faces_piece)) == 2
    pattern, findings = imported([*square(0, 90), *square(20, 70), ("M", 30, 30, 60, 60)])
    # what has its creases in a hole alone is the page around a sheet
    assert "page-frame" in findings
    assert pattern.counts() == {"M": 1, "V": 0, "F": 0, "B": 4}
    rows = [*square(0, 90), *square(20, 70), ("M", 30, 30, 60, 60), ("V", 0, 10, 90, 10)]
    pattern, findings = imported(rows)
    assert "line-outside" in findings
    assert pattern.counts()["M"] == 0


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_islands_of_any_number_are_joined(seed, count):
    """Triangles anywhere in a square, in several of which there are others."""
    random = np.random.default_rng(seed)
    rows = [*SQUARE]
    cells = random.permutation(25)[:count]
    middles = 10 + 20.0 * np.column_stack(np.divmod(cells, 5))
    for middle in middles:
        for radius in (8, 3)[: random.integers(1, 3)]:
            turn = random.uniform(0, 2) + np.arange(3) * 2 * np.pi / 3
            corner = middle + radius * np.column_stack([np.cos(turn), np.sin(turn)])
            letter = random.choice(["M", "C", "B"])
            rows += [(letter, *corner[k], *corner[(k + 1) % 3]) for k in range(3)]
    rows += [("V", 0, 0, 1.5, 1.5)]  # with a crease of its own the square is no frame of a page
    pattern, findings = imported(rows)
    assert "island-joined" in findings
    drawn = sum(np.hypot(row[3] - row[1], row[4] - row[2]) for row in rows)
    total = lengths(pattern)
    total.pop("J")
    inner = [f for code, f in findings.items() if code == "line-outside"]
    if not inner:
        assert sum(total.values()) == pytest.approx(drawn, rel=1e-6)


def test_angles_are_given_asked_for_or_full():
    rows = [*SQUARE, CREASE, ("M", 0, 50, 50, 50), ("?", 50, 30, 100, 30), ("F", 50, 60, 100, 60)]
    angles = [np.nan] * 4 + [45, np.nan, -20, np.nan]
    pattern, findings = imported(rows, angles=angles)
    found = {
        (str(x), float(a))
        for x, a in zip(pattern.edges_assignment, pattern.edges_foldAngle, strict=True)
    }
    assert found == {("B", 0.0), ("V", 45.0), ("M", -180.0), ("M", -20.0), ("F", 0.0)}
    assert "fold-angle-missing" in findings
    pattern, findings = imported(rows, ReadOptions(fold_deg=90), angles=angles)
    assert -90 in pattern.edges_foldAngle
    assert "fold-angle-missing" not in findings
    assert "fold-deg-unused" not in findings
    for strict in (False, True):
        angles = [np.nan] * 4 + [45, -10, -20, np.nan]
        _, findings = imported(rows, ReadOptions(fold_deg=90, strict=strict), angles=angles)
        assert "no mountain or valley" in findings["fold-deg-unused"].text
    _, findings = imported([*SQUARE, ("?", 0, 0, 100, 100)], ReadOptions(fold_deg=90, assign=True))
    assert "fold-deg-unused" not in findings
    with pytest.raises(InvalidValue, match="fold_deg"):
        imported(rows, ReadOptions(fold_deg=200))
    pattern, _ = imported([*SQUARE, ("?", 0, 0, 100, 100)])
    assert pattern.counts()["U"] == 1


def test_units_are_those_of_the_drawing_or_of_the_options():
    pattern, findings = imported(SQUARE, mm_per_unit=None)
    assert "unit-unknown" in findings
    pattern, findings = imported(SQUARE, ReadOptions(mm_per_unit=2.0), mm_per_unit=None)
    assert "unit-unknown" not in findings
    assert pattern.vertices_coords.max() == 200
    pattern, _ = imported(SQUARE, ReadOptions(mm_per_unit=2.0), mm_per_unit=25.4)
    assert pattern.vertices_coords.max() == 2540


def test_what_is_drawn_apart_stays_apart():
    """A slot of 0.1 mm, creases 0.05 mm apart in a row, a curve of short lines."""
    slot = [(50.05, 0), (100, 0), (100, 60), (0, 60), (0, 0), (49.95, 0), (49.95, 40), (50.05, 40)]
    rows = [("B", *a, *b) for a, b in zip(slot, slot[1:] + slot[:1], strict=True)]
    pattern, _ = imported(rows)
    assert len(pattern.vertices_coords) == 8
    row = [("V", 50 + 0.05 * k, 0, 50 + 0.05 * k, 100) for k in range(12)]
    pattern, _ = imported([*SQUARE, *row])
    assert pattern.counts()["V"] == 12
    turn = np.linspace(0, 2 * np.pi, 2001)
    arc = 50 + 40 * np.column_stack([np.cos(turn), np.sin(turn)])
    circle = [("B", *a, *b) for a, b in pairwise(arc)]
    rows = [*circle, ("V", 5, 50, 95, 50)]
    elements = [0] * 2000 + [1]
    pattern, findings = imported(rows, elements=elements)
    assert pattern.counts() == {"M": 0, "V": 1, "F": 0, "B": 2000}
    assert findings["line-outside"].text.startswith("2 edges")


@given(st.integers(0, 2**32 - 1))
def test_order_direction_and_splits_of_lines_do_not_change_the_pattern(seed):
    random = np.random.default_rng(seed)
    sheet = grid(3, 3, 20.0, without=[(1, 1)] if random.random() < 0.5 else [])
    soup = soup_of_pattern(sheet)
    reference = pattern_of_lines(soup).pattern
    order = random.permutation(len(soup.lines_coords))
    coords, letters = soup.lines_coords[order], soup.lines_assignment[order]
    angles = soup.lines_foldAngle[order]
    turned = random.random(len(order)) < 0.5
    coords[turned] = coords[turned, ::-1]
    share = random.uniform(0.3, 0.7, (len(order), 1))
    middle = coords[:, 0] + share * (coords[:, 1] - coords[:, 0])
    halves = np.concatenate(
        [np.stack([coords[:, 0], middle], 1), np.stack([middle, coords[:, 1]], 1)]
    )
    mixed = replace(
        soup,
        lines_coords=halves,
        lines_assignment=np.tile(letters, 2),
        lines_foldAngle=np.tile(angles, 2),
        lines_element=np.arange(len(halves)),
        elements=tuple(f"line {k}" for k in range(len(halves))),
    )
    pattern = pattern_of_lines(mixed).pattern
    require_sound(pattern)
    assert pattern.counts() == reference.counts()
    assert lengths(pattern) == pytest.approx(lengths(reference))
    assert pattern.face_count == reference.face_count
    assert len(pattern.vertices_coords) == len(reference.vertices_coords)


@given(st.integers(0, 2**32 - 1), st.integers(1, 12))
def test_no_line_is_dropped_without_a_finding(seed, count):
    """Random creases on a square: their lengths come back, or a finding says why not."""
    random = np.random.default_rng(seed)
    ends = random.uniform(1, 99, (count, 4))
    rows = [*SQUARE, *(("F", *row) for row in ends)]
    pattern, findings = imported(rows)
    drawn = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1]).sum()
    moved = [code for code in findings if code not in ("lines-split", "crease-dangling")]
    length = lengths(pattern)
    assert length["B"] == pytest.approx(400)
    if not set(moved) - {"island-joined"}:
        assert length["F"] == pytest.approx(drawn, rel=1e-9)
    else:
        assert length["F"] == pytest.approx(drawn, abs=0.5 * count)


def test_what_was_imported_is_written_and_read_alike(tmp_path):
    rows = [*SQUARE, CREASE, ("M", 20, 20, 40, 40), ("C", 60, 60, 90, 60), ("M", 0, 50, 50, 50)]
    pattern, _ = imported(rows)
    path = tmp_path / "sheet.fold"
    path.write_bytes(fold_bytes(pattern, "sheet"))
    assert "NaN" not in json.dumps(json.loads(path.read_text()))
    again, findings = read_pattern(path, ReadOptions(strict=True))
    assert {f.code for f in findings} <= {"crease-dangling"}
    assert np.array_equal(again.edges_vertices, pattern.edges_vertices)
    assert np.array_equal(again.edges_faces, pattern.edges_faces)


def test_borders_that_end_within_the_sheet_are_cuts_on_request():
    """A slit from the rim, one that lies free and one that ends on a crease."""
    slits = [("B", 20, 0, 20, 40), ("B", 60, 60, 80, 60), ("B", 50, 20, 70, 20)]
    rows = [*SQUARE, ("M", 50, 0, 50, 100), *slits]
    with pytest.raises(InvalidFile, match=r"a border that joins no other, .* --inner-border cut"):
        imported(rows)
    pattern, findings = imported(rows, ReadOptions(inner_border="cut"))
    assert pattern.counts() == {"M": 2, "V": 0, "F": 0, "B": 7, "C": 3}
    assert "3 edges" in findings["border-inside"].text
    assert len(findings["border-inside"].creases) == 3
