"""Faces that a FOLD file lists: over each other, needles, broken ones, and lines within them."""

import json
from itertools import pairwise

import numpy as np
import pytest
import shapely
from flat_patterns import grid, pattern_of, turned_strip
from hypothesis import given
from hypothesis import strategies as st

from fab import read_pattern
from fab.errors import InvalidFile, Severity
from fab.formats.fold.writer import fold_bytes
from fab.geometry.planar_graph import first_abutting
from fab.geometry.rings import ring_areas
from fab.sheets.pieces import SheetSplit, split


def polygons_of(pattern):
    ring = np.repeat(np.arange(pattern.face_count), np.diff(pattern.faces_offsets))
    corners = pattern.vertices_coords[pattern.faces_vertices]
    return shapely.polygons(shapely.linearrings(corners, indices=ring))


def document_of(pattern):
    return json.loads(fold_bytes(pattern, "sheet"))


def read(folder, document):
    path = folder / "sheet.fold"
    path.write_text(json.dumps(document))
    return read_pattern(path)


def with_lines(pattern, points, pairs, letter="C"):
    """The pattern's document with more vertices, and edges of no face."""
    document = document_of(pattern)
    document["vertices_coords"] += [[x, y, 0.0] for x, y in points]
    document["edges_vertices"] += pairs
    document["edges_assignment"] += [letter] * len(pairs)
    document["edges_foldAngle"] += [0.0] * len(pairs)
    return document


def faces_alone(coords, faces):
    return {"frame_unit": "mm", "vertices_coords": coords, "faces_vertices": faces}


SQUARE = [[0, 0], [100, 0], [100, 100], [0, 100]]


@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.floats(0.4, 3.0))
def test_sheets_that_turn_over_themselves_are_read_as_written_and_cut_into_pieces(
    tmp_path_factory, seed, rows, turns
):
    sheet = turned_strip(int(12 * turns) + 5, turns, rows, seed)
    pattern, findings = read(tmp_path_factory.mktemp("turned"), document_of(sheet))
    assert np.array_equal(pattern.faces_vertices, sheet.faces_vertices)
    assert np.array_equal(pattern.edges_assignment, sheet.edges_assignment)
    assert np.array_equal(pattern.edges_vertices, sheet.edges_vertices)
    shapes = polygons_of(pattern)
    total = shapely.area(shapes).sum()
    covered = shapely.union_all(shapes).area
    overlaps = bool(covered < total * (1 - 1e-6))
    assert [f.code for f in findings] == ["sheet-overlaps"] * overlaps
    made, _ = split(pattern, SheetSplit(), (900.0, 900.0))
    assert (len(made.pieces) > 1) == overlaps
    numbers = np.concatenate([piece.faces[piece.faces >= 0] for piece in made.pieces])
    assert sorted(numbers.tolist()) == list(range(pattern.face_count))
    for piece in made.pieces:
        own = polygons_of(piece.pattern)
        assert shapely.union_all(own).area == pytest.approx(shapely.area(own).sum(), rel=1e-6)


@pytest.mark.parametrize(("turns", "over"), [(1.0, 0), (1.25, 6), (2.0, 24), (4.0, 48)])
def test_faces_that_lie_on_each_other_are_counted(tmp_path, turns, over):
    """Quads of a ring of twelve: those of later turns lie exactly on those of the first."""
    sheet = turned_strip(int(12 * turns), turns)
    pattern, findings = read(tmp_path, document_of(sheet))
    assert pattern.face_count == 12 * turns
    if not over:
        assert findings == ()
        return
    (finding,) = findings
    assert finding.severity is Severity.NOTE
    assert f"{over} of {12 * turns:g} faces" in finding.text
    assert "the first are 0 and 12" in finding.text
    assert finding.panels == ((0, 1, 2, 12, 13, 14) if over == 6 else tuple(range(20)))
    made, _ = split(pattern, SheetSplit(), (900.0, 900.0))
    assert len(made.pieces) == np.ceil(turns)


def test_findings_number_faces_as_the_file_does(tmp_path):
    coords = [*SQUARE, *([x + 30, y + 40] for x, y in SQUARE), [50, 0]]
    faces = [[0, 8, 1], [0, 1, 2, 3], [7, 6, 5, 4]]
    pattern, findings = read(tmp_path, faces_alone(coords, faces))
    panels = {finding.code: finding.panels for finding in findings if finding.panels}
    assert panels == {"face-without-area": (0,), "face-clockwise": (2,), "sheet-overlaps": (1, 2)}
    made, _ = split(pattern, SheetSplit(), (400.0, 400.0))
    assert len(made.pieces) == 2
    assert not made.seams


def test_a_sheet_may_turn_twice_around_a_vertex(tmp_path):
    angle = np.arange(12) * np.pi / 3
    rim = 100 * np.column_stack([np.cos(angle), np.sin(angle)])
    faces = [[0, 1 + i, 1 + (i + 1) % 12] for i in range(12)]
    sheet = pattern_of(np.vstack([[[0.0, 0.0]], rim]), faces, "V")
    pattern, findings = read(tmp_path, document_of(sheet))
    assert [f.code for f in findings] == ["sheet-overlaps"]
    made, _ = split(pattern, SheetSplit(), (400.0, 400.0))
    assert sorted(int((piece.faces >= 0).sum()) for piece in made.pieces) == [6, 6]
    assert len(made.seams) == 2


BESIDE = [*SQUARE, *([x + 100, y] for x, y in SQUARE)]
# A wide face above two narrow ones, which have a vertex that it lacks.
OFFSET = [[0, 0], [200, 0], [200, 100], [0, 100], [0, -100], [100, -100], [200, -100], [100, 0]]
OFFSET_FACES = [[0, 1, 2, 3], [4, 5, 7, 0], [5, 6, 1, 7]]


@pytest.mark.parametrize(
    ("coords", "faces", "match"),
    [
        (SQUARE, [[0, 1, 2, 3], [0, 1, 2, 3]], "faces 0 and 1 have the same corners"),
        (SQUARE, [[0, 1, 2, 3], [3, 2, 1, 0]], "faces 0 and 1 have the same corners"),
        (SQUARE, [[0, 1, 2, 3], [2, 3, 0, 1]], "faces 0 and 1 have the same corners"),
        (SQUARE, [[0, 1, 2, 3], [0, 1, 2]], "faces 0 and 1 lie on the same side .*\\(0, 1\\)"),
        (
            [*SQUARE, [40, 0], [40, 100]],
            [[0, 1, 2, 3], [1, 2, 5, 4]],
            "faces 0 and 1 lie on the same side .*\\(1, 2\\), as in a folded sheet",
        ),
        (
            [*SQUARE, [200, 0], [200, 100], [40, 50]],
            [[0, 1, 2, 3], [1, 4, 5, 2], [1, 2, 6]],
            "faces 0 and 2 lie on the same side",
        ),
        ([[0, 0], [100, 0], [0, 100], [100, 100]], [[0, 1, 2, 3]], "face 0: the sides cross"),
        ([[0, 0], [90, 0], [0, 90], [100, 100]], [[0, 1, 2, 3]], "face 0: the sides cross"),
        ([*SQUARE, [50, 0]], [[0, 1, 2, 4, 3]], "face 0: the sides cross or touch"),
        (BESIDE, [[0, 1, 2, 3], [4, 5, 6, 7]], r"edges 2 and 5 lie on each other at \(100, 50\)"),
        (OFFSET, OFFSET_FACES, r"edges 0 and 3 lie on each other at \(50, 0\)"),
    ],
)
def test_faces_of_no_flat_sheet_are_refused(tmp_path, coords, faces, match):
    with pytest.raises(InvalidFile, match=match):
        read(tmp_path, faces_alone(coords, faces))


@pytest.mark.parametrize(
    ("coords", "faces"), [(BESIDE, [[0, 1, 2, 3], [4, 5, 6, 7]]), (OFFSET, OFFSET_FACES)]
)
def test_borders_may_lie_on_each_other(tmp_path, coords, faces):
    pattern, findings = read(tmp_path, document_of(pattern_of(coords, faces, "V")))
    assert findings == ()
    made, _ = split(pattern, SheetSplit(), (900.0, 900.0))
    assert len(made.pieces) == 2


TWICE = turned_strip(24, 2.0)
OF_TWICE = len(TWICE.vertices_coords)


def test_a_line_lies_in_the_face_whose_corner_it_begins_in(tmp_path):
    """Face 0 has the corners 0 and 1, face 12 lies on it with the corners 12 and 13."""
    for corner, face in ((0, 0), (12, 12)):
        document = with_lines(TWICE, [[72.0, 20.0]], [[corner, OF_TWICE]])
        pattern, findings = read(tmp_path, document)
        assert pattern.edges_faces[-1].tolist() == [face, face]
        assert {f.code for f in findings} == {"crease-dangling", "sheet-overlaps"}


@pytest.mark.parametrize(
    ("points", "pairs", "match"),
    [
        ([[70, 20], [75, 20]], [[0, 1]], "edge 73, .* lies in faces 0, 12, which lie over each"),
        ([[0, 30]], [[-OF_TWICE, 0]], "edge 73, .* lies inside of no face"),
        ([[300, 0], [300, 9]], [[0, 1]], "edge 73, .* lies inside of no face"),
        (
            [[68, 10], [75, 20], [68, 20], [76, 10]],
            [[-OF_TWICE, 0], [0, 1], [0, 2], [2, 3]],
            "edges 74 and 76 meet at",
        ),
        ([[90, 56]], [[-OF_TWICE, 0]], "edges 1 and 73 meet at"),
        ([[80, 20], [76, 44]], [[-OF_TWICE, 0], [0, 1]], "edges 2 and 74 meet at"),
    ],
)
def test_lines_that_leave_their_face_are_refused(tmp_path, points, pairs, match):
    rows = [[OF_TWICE + v for v in pair] for pair in pairs]
    with pytest.raises(InvalidFile, match=match):
        read(tmp_path, with_lines(TWICE, points, rows))


def test_a_line_may_cross_what_lies_over_its_face(tmp_path):
    """Two pieces, half over each other: the diagonal of one crosses a side of the other."""
    coords = [*SQUARE, *([x + 50, y] for x, y in SQUARE)]
    sheet = pattern_of(coords, [[0, 1, 2, 3], [4, 5, 6, 7]], "V")
    pattern, findings = read(tmp_path, with_lines(sheet, [[90, 70]], [[0, 8]]))
    assert pattern.edges_faces[-1].tolist() == [0, 0]
    assert "sheet-overlaps" in {finding.code for finding in findings}


@pytest.mark.parametrize(
    ("width", "moved"), [(1e-3, 0.0), (1e-3, 1e4), (1e-7, 0.0), (1e-7, 1e4), (1e-9, 0.0)]
)
def test_needles_are_faces_as_long_as_the_coordinates_can_tell(tmp_path, width, moved):
    """Squares of side 1, and needles that are `width` wide between them."""
    x = np.cumsum([0.0, 1.0, width, 1.0, width, 1.0]) + moved
    coords = [[a, b] for b in (0.0, 1.0) for a in x]
    faces = [[i, i + 1, i + 7, i + 6] for i in range(5)]
    sheet = pattern_of(coords, faces, "V")
    pattern, findings = read(tmp_path, document_of(sheet))
    assert findings == ()
    assert pattern.counts() == sheet.counts()
    areas = ring_areas(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets)
    assert areas == pytest.approx(np.diff(pattern.vertices_coords[:6, 0]), rel=1e-12)


def test_needles_below_the_last_digits_are_no_faces(tmp_path):
    x = np.cumsum([0.0, 1.0, 1e-13, 1.0]) + 10.0
    coords = [[a, b] for b in (0.0, 1.0) for a in x]
    sheet = pattern_of(coords, [[i, i + 1, i + 5, i + 4] for i in range(3)], "V")
    pattern, findings = read(tmp_path, document_of(sheet))
    assert pattern.counts() == {"M": 0, "V": 1, "F": 0, "B": 6}
    told = {finding.code: finding for finding in findings}
    assert told["face-without-area"].panels == (1,)
    assert "zero-length-edge" in told


def test_edges_of_removed_faces_alone_go_with_them(tmp_path):
    """A triangle on the border whose corners lie on a line: its own side is no edge any more."""
    sheet = pattern_of([*SQUARE, [50, 0]], [[0, 4, 1, 2, 3], [0, 1, 4]], "F")
    pattern, findings = read(tmp_path, document_of(sheet))
    assert pattern.face_count == 1
    assert pattern.counts()["B"] == 5
    assert {f.code for f in findings} == {"face-without-area", "border-unmarked"}


def test_a_fine_sheet_is_read_whatever_its_size_and_place(tmp_path):
    sheet = grid(6, 5, 20.0, without=[(2, 2)])
    document = document_of(sheet)
    coords = np.array(document["vertices_coords"])
    for factor, shift in ((1e-7, 0.0), (1e7, 0.0), (1.0, 1e6)):
        document["vertices_coords"] = (coords * factor + shift).tolist()
        pattern, findings = read(tmp_path, document)
        assert {f.code for f in findings} <= {"vertex-unused"}
        assert np.array_equal(pattern.edges_faces, sheet.edges_faces)


FORTH = [[0.0, 0.0], [10.0, 0.0]]


@pytest.mark.parametrize(
    ("other", "at"),
    [
        ([[10, 0], [0, 0]], 5),
        ([[4, 0], [2, 0]], 3),
        ([[15, 0], [8, 0]], 9),
        ([[2, 0], [-9, 0]], 1),
        ([[20, 0], [-20, 0]], 5),
        ([[4, 1e-9], [2, -1e-9]], 3),
        ([[4.002, 5e-7], [4, -5e-7]], 4.001),  # short, and so turned by more than its ends are off
        ([[2, 0], [4, 0]], None),  # both faces lie on the same side
        ([[20, 0], [10, 0]], None),  # end to end
        ([[0, 0], [-10, 0]], None),
        ([[4, 0], [4, 9]], None),
        ([[4, 0.1], [2, -0.1]], None),
        ([[4, 1e-3], [2, 1e-3]], None),
    ],
)
def test_edges_abut_where_they_run_along_each_other_in_opposite_directions(other, at):
    ends = np.array([FORTH, other], float)
    for turn in (0.0, 0.3, 2.0):
        c, s = np.cos(turn), np.sin(turn)
        points = ends.reshape(-1, 2) @ np.array([[c, s], [-s, c]]) + 5.0
        for order in ([[0, 1], [2, 3]], [[2, 3], [0, 1]]):
            pairs, free = np.array(order), np.zeros(2, bool)
            found = first_abutting(points, pairs, 1e-6, free)
            if at is None:
                assert found is None
                continue
            assert found is not None
            assert found[:2] == (0, 1)
            expected = np.array([c, s]) * at + 5.0
            assert found[2] == pytest.approx(expected, abs=1e-6)
            assert first_abutting(points, pairs, 1e-6, ~free) is None
            assert first_abutting(points, pairs, 1e-6, np.array([True, False])) is not None


def test_all_sides_of_a_sheet_are_free_to_meet_end_to_end():
    sheet = turned_strip(30, 1.7, 2, seed=4)
    alone = sheet.edges_faces[:, 1] < 0
    pairs = sheet.edges_vertices[alone]
    assert first_abutting(sheet.vertices_coords, pairs, 1e-9, np.zeros(len(pairs), bool)) is None
    corners = sheet.faces_vertices
    assert all(len(set(corners[i:j])) == 4 for i, j in pairwise(sheet.faces_offsets))
