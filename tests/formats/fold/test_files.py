"""FOLD files: round trip, frames, states, orders of faces, and every refusal."""

import json
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import pattern_of
from hypothesis import given
from strategies import patches

from fab import read_pattern
from fab.errors import InvalidFile
from fab.formats.fold.writer import fold_bytes
from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file
from fab.jobs.conversion import convert
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.pattern.inspection import inspect_angles
from solver import Miura
from solver.errors import InvalidValue


def read_fold(path):
    return read_pattern(path)[0]


def document_of(pattern, states=()) -> dict:
    return json.loads(fold_bytes(pattern, "sheet", states))


@pytest.fixture
def pattern():
    mesh = Miura(columns=3, rows=3).grow().mesh
    return crease_pattern(mesh, develop(mesh), 10.0)


@given(mesh=patches())
def test_reading_gives_the_same_arrays_back(tmp_path_factory, mesh):
    pattern = crease_pattern(mesh, develop(mesh), 10.0)
    before = [array.copy() for array in vars(pattern).values() if isinstance(array, np.ndarray)]
    path = tmp_path_factory.mktemp("fold") / "sheet.fold"
    path.write_bytes(fold_bytes(pattern, "sheet"))
    back, findings = read_pattern(path, ReadOptions(strict=True))
    assert {finding.code for finding in findings} <= {"sheet-overlaps"}
    for name in pattern.__dataclass_fields__:
        assert np.array_equal(getattr(back, name), getattr(pattern, name)), name
    after = [array for array in vars(pattern).values() if isinstance(array, np.ndarray)]
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=False))


def test_the_key_frame_is_flat_and_complete(pattern):
    document = document_of(pattern)
    assert document["file_spec"] == 1.2
    assert document["frame_classes"] == ["creasePattern"]
    assert document["frame_unit"] == "mm"
    assert all(len(p) == 3 and p[2] == 0 for p in document["vertices_coords"])
    assert set(document["edges_assignment"]) <= set("MVB")
    assert all(isinstance(a, float) for a in document["edges_foldAngle"])
    (folded,) = document["file_frames"]
    assert folded["frame_classes"] == ["foldedForm"]
    assert folded["frame_inherit"] is True
    assert np.ptp([p[2] for p in folded["vertices_coords"]]) > 1
    pairs = [tuple(sorted(e)) for e in document["edges_vertices"]]
    assert len(set(pairs)) == len(pairs)


def codes_of(path):
    return {finding.code for finding in read_pattern(path)[1]}


def test_angles_come_from_the_folded_form_where_none_are_stored(tmp_path, pattern):
    document = document_of(pattern)
    del document["edges_foldAngle"], document["edges_vertices"], document["edges_assignment"]
    path = tmp_path / "bare.fold"
    path.write_text(json.dumps(document))
    back = read_fold(path)
    assert back.edges_foldAngle == pytest.approx(pattern.edges_foldAngle, abs=1e-9)
    assert (back.edges_assignment == pattern.edges_assignment).all()
    assert codes_of(path) == {"edges-missing", "assignment-missing", "fold-angle-measured"}
    (finding,) = [f for f in read_pattern(path)[1] if f.code == "fold-angle-measured"]
    assert f"and {(pattern.edges_assignment != 'B').sum() - 5} more" in finding.text


def test_single_angles_come_from_the_folded_form_too(tmp_path, pattern):
    document = document_of(pattern)
    creases = np.flatnonzero(pattern.edges_foldAngle)
    some = creases[::3].tolist()
    for edge in some:
        document["edges_foldAngle"][edge] = None
    document["edges_assignment"][some[0]] = "U"
    path = tmp_path / "some.fold"
    path.write_text(json.dumps(document))
    back, (finding,) = read_pattern(path)
    assert back.edges_foldAngle == pytest.approx(pattern.edges_foldAngle, abs=1e-9)
    assert back.edges_assignment[some[0]] == "U"
    assert finding.code == "fold-angle-measured"
    assert finding.creases == tuple(some)


@pytest.mark.parametrize("letter", ["M", "V"])
def test_the_side_of_creases_folded_flat_is_that_of_their_letters(tmp_path, letter):
    sheet = pattern_of(
        [[0, 0], [10, 0], [20, 0], [20, 10], [10, 10], [0, 10]],
        [[0, 1, 4, 5], [1, 2, 3, 4]],
        letter,
        angle=180.0,
    )
    document = document_of(sheet)
    document["edges_foldAngle"] = [None] * 7
    folded = [[0, 0], [10, 0], [0, 0], [0, 10], [10, 10], [0, 10]]
    document["file_frames"] = [{"frame_classes": ["foldedForm"], "vertices_coords": folded}]
    path = tmp_path / "flat.fold"
    path.write_text(json.dumps(document))
    back = read_fold(path)
    assert codes_of(path) == {"fold-angle-measured"}
    assert back.edges_foldAngle.tolist() == sheet.edges_foldAngle.tolist()
    assert inspect_angles(back) == []
    (frame,) = document_of(back)["file_frames"]
    ((one, two, side),) = frame["faceOrders"]
    assert (one, two) == tuple(back.edges_faces[back.edges_assignment == letter][0])
    assert side == {"M": -1, "V": 1}[letter]


STRIP = [[x, y] for y in (0.0, 10.0) for x in (0.0, 10.0, 20.0, 30.0)]


def strip_folded_by(first, second, letters="VV", cuts=()):
    """Three squares in a row, and the points where two creases take them."""
    squares = [[i, i + 1, i + 5, i + 4] for i in range(3)]
    plain = pattern_of(STRIP, squares)
    inside = plain.edges_assignment == "M"
    names, angles = np.full(len(inside), "B"), np.zeros(len(inside))
    names[inside], angles[inside] = list(letters), np.abs([first, second])
    sheet = pattern_of(STRIP, squares, names, cuts, angles)
    steps = np.exp(1j * np.radians(np.cumsum([0.0, first, second])))
    x = np.concatenate([[0], np.cumsum(10 * steps)])
    return sheet, np.array([[p.real, y, p.imag] for y in (0.0, 10.0) for p in x])


def test_only_faces_that_are_folded_onto_each_other_have_an_order():
    for second, letters, rows in ((0.0, "VV", 1), (180.0, "VM", 2), (90.0, "VV", 0)):
        sheet, points = strip_folded_by(180.0, second, letters)
        (frame,) = document_of(replace(sheet, folded_coords=points))["file_frames"]
        assert len(frame.get("faceOrders", [])) == rows
        assert ("faceOrders" in frame) == bool(rows)


def test_states_have_the_angles_of_their_creases_and_none_at_cuts():
    sheet, points = strip_folded_by(-180.0, -180.0, "MM")
    (frame,) = document_of(sheet, [("folded", points)])["file_frames"]
    folds = np.array(frame["edges_foldAngle"])[sheet.edges_assignment == "M"]
    assert folds.tolist() == [-180.0, -180.0]
    sheet, points = strip_folded_by(90.0, 45.0, "VV", cuts=[(2, 6)])
    (frame,) = document_of(sheet, [("folded", points)])["file_frames"]
    angles = np.array(frame["edges_foldAngle"])
    assert angles[sheet.edges_assignment == "V"] == pytest.approx([90])
    assert angles[sheet.edges_assignment == "C"].tolist() == [0]


def test_cuts_and_lines_within_a_face_are_not_compared_with_the_folded_form(tmp_path):
    sheet, points = strip_folded_by(90.0, 45.0, "VV", cuts=[(2, 6)])
    document = document_of(replace(sheet, folded_coords=points))
    document["vertices_coords"].append([5.0, 5.0, 0.0])
    document["file_frames"][0]["vertices_coords"].append([5.0, 5.0, 0.0])
    document["edges_vertices"].append([0, 8])
    document["edges_assignment"].append("M")
    document["edges_foldAngle"].append(-180.0)
    path = tmp_path / "cut.fold"
    path.write_text(json.dumps(document))
    pattern = read_fold(path)
    assert pattern.counts()["C"] == pattern.counts()["M"] == 1
    assert inspect_angles(pattern) == []
    made = convert(PatternFile("", pattern, (), ()), tmp_path / "cut.obj")
    (finding,) = made.findings
    lost = pattern.edges_assignment[list(finding.creases)].tolist()
    assert finding.code == "lost-in-obj"
    assert sorted(lost) == ["C", "M"]


def test_faces_in_space_have_no_order(pattern):
    (frame,) = document_of(pattern)["file_frames"]
    assert "faceOrders" not in frame


def test_states_are_frames_of_their_own(tmp_path, pattern):
    half = Miura(columns=3, rows=3, fold=0.4).grow().mesh
    flat = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    states = [("flat", flat), ("half", half.vertices_coords * 10.0)]
    path = tmp_path / "sheet.fold"
    for folded in (pattern.folded_coords, None):
        sheet = replace(pattern, folded_coords=folded)
        path.write_bytes(fold_bytes(sheet, "sheet", states))
        back = read_pattern_file(path, ReadOptions(strict=True))
        assert back.title == "sheet"
        assert [title for title, _ in back.states] == ["flat", "half"]
        for (_, found), (_, given_points) in zip(back.states, states, strict=True):
            assert np.array_equal(found, given_points)
        assert (back.pattern.folded_coords is None) == (folded is None)
        again = fold_bytes(back.pattern, "sheet", back.states)
        assert again == path.read_bytes()
    frames = document_of(pattern, states)["file_frames"]
    assert set(frames[1]["edges_foldAngle"]) == {0.0}
    angles = np.array(frames[2]["edges_foldAngle"])
    assert (np.sign(angles) == np.sign(pattern.edges_foldAngle)).all()
    assert np.abs(angles).max() > 1


def test_states_that_do_not_fit_are_refused(pattern):
    points = pattern.folded_coords.copy()
    with pytest.raises(InvalidValue, match=r"have the shape \(16, 3\)"):
        fold_bytes(pattern, "sheet", [("half", points[1:])])
    points[3, 1] = np.nan
    with pytest.raises(InvalidValue, match=r"vertex 3 of state .* is not finite"):
        fold_bytes(pattern, "sheet", [("half", points)])


def test_other_folded_frames_are_states_in_units_of_their_own(tmp_path, pattern):
    document = document_of(pattern)
    points = np.array(document["file_frames"][0]["vertices_coords"])
    frame = {"frame_classes": ["foldedForm"], "frame_title": "later"}
    document["file_frames"] += [
        {**frame, "frame_unit": "cm", "vertices_coords": (points / 10).tolist()},
        {**frame, "vertices_coords": points[1:].tolist()},
    ]
    path = tmp_path / "frames.fold"
    path.write_text(json.dumps(document))
    read = read_pattern_file(path)
    assert read.pattern.folded_coords == pytest.approx(points)
    ((title, later),) = read.states
    assert title == "later"
    assert later == pytest.approx(points)
    assert [finding.code for finding in read.findings] == ["folded-form-differs"]


def test_a_flat_frame_is_a_sheet_whatever_its_class(tmp_path, pattern):
    document = document_of(pattern)
    document["frame_classes"] = ["foldedForm"]
    path = tmp_path / "folded.fold"
    path.write_text(json.dumps(document))
    read = read_pattern_file(path)
    assert [finding.code for finding in read.findings] == ["flat-form-taken"]
    assert np.array_equal(read.pattern.vertices_coords, pattern.vertices_coords)
    assert np.array_equal(read.pattern.folded_coords, pattern.folded_coords)
    with pytest.raises(InvalidFile, match="of class foldedForm is flat"):
        read_pattern_file(path, ReadOptions(strict=True))
    flat = {"vertices_coords": document["vertices_coords"], "frame_parent": 0}
    document["file_frames"] = [{**flat, "frame_inherit": True, "frame_classes": []}]
    document["vertices_coords"] = pattern.folded_coords.tolist()
    path.write_text(json.dumps(document))
    read = read_pattern_file(path)
    assert read.findings == ()
    assert np.array_equal(read.pattern.folded_coords, pattern.folded_coords)


def test_frames_may_stand_in_any_order_and_coordinates_may_be_plane(tmp_path, pattern):
    document = document_of(pattern)
    flat = {k: document.pop(k) for k in list(document) if not k.startswith("file_")}
    flat["vertices_coords"] = [p[:2] for p in flat["vertices_coords"]]
    folded = {**flat, **document["file_frames"][0], "frame_inherit": False}
    folded.pop("frame_parent")
    path = tmp_path / "turned.fold"
    path.write_text(json.dumps({**document, **folded, "file_frames": [flat]}))
    back = read_fold(path)
    assert (back.vertices_coords == pattern.vertices_coords).all()
    assert (back.folded_coords == pattern.folded_coords).all()


def test_faces_of_any_size_are_read(tmp_path):
    square = {
        "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0.5], [2, 1.5]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [1, 4], [4, 5], [5, 2]],
        "edges_foldAngle": [0, 90, 0, 0, None, 0, 0],
        "faces_vertices": [[0, 1, 2, 3], [1, 4, 5, 2]],
    }
    triangle = {**square, "faces_vertices": [[0, 1, 2, 3], [1, 4, 2], [4, 5, 2]]}
    triangle["edges_vertices"] = [*square["edges_vertices"], [4, 2]]
    triangle["edges_foldAngle"] = [*square["edges_foldAngle"], -30]
    path = tmp_path / "mixed.fold"
    path.write_text(json.dumps(triangle))
    pattern = read_fold(path)
    assert sorted(n.shape for _, n in pattern.faces_by_size()) == [(1, 4), (2, 3)]
    assert pattern.counts() == {"M": 1, "V": 1, "F": 0, "B": 6}
    assert pattern.folded_coords is None


def test_clockwise_faces_are_turned_around(tmp_path, pattern):
    document = document_of(pattern)
    document["faces_vertices"] = [face[::-1] for face in document["faces_vertices"]]
    path = tmp_path / "clockwise.fold"
    path.write_text(json.dumps(document))
    assert read_fold(path).counts() == pattern.counts()
    assert inspect_angles(read_fold(path)) == []
    del document["edges_foldAngle"]
    path.write_text(json.dumps(document))
    assert read_fold(path).counts() == pattern.counts()
    document["faces_vertices"][0].reverse()
    path.write_text(json.dumps(document))
    assert read_fold(path).counts() == pattern.counts()


def test_null_angles_are_those_of_the_letters(tmp_path, pattern):
    document = document_of(pattern)
    del document["file_frames"]
    document["edges_foldAngle"] = [None] * len(document["edges_vertices"])
    path = tmp_path / "null.fold"
    path.write_text(json.dumps(document))
    assert read_fold(path).counts() == pattern.counts()
    assert set(np.abs(read_fold(path).edges_foldAngle)) == {0.0, 180.0}


def changed(pattern, **changes):
    document = document_of(pattern)
    for key, value in changes.items():
        if value is None:
            document.pop(key)
        else:
            document[key] = value
    return json.dumps(document)


NAN = float("nan")


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"faces_vertices": [[0, 1]]}, "at least 3 corners"),
        ({"faces_vertices": [[0, 1, 99]]}, "vertex 99; vertices run from 0 to 15"),
        ({"faces_vertices": [[0, 1, -1]]}, "vertex -1"),
        ({"faces_vertices": [[0, 1, 1.5]]}, "vertex 1.5"),
        ({"faces_vertices": [[0, 1, 5, 1]]}, "passes a vertex twice"),
        ({"faces_vertices": [[0, 1, 5], [0, 1, 5]]}, "same corners"),
        ({"vertices_coords": "none"}, "must be a list"),
        ({"vertices_coords": []}, "at least 3 points"),
        ({"vertices_coords": [[0, 0], [1]]}, "alike in length"),
        ({"vertices_coords": [["0", "0"]] * 3}, "must be numbers"),
        ({"vertices_coords": [[0, 0], [1, False], [1, True]]}, "must be numbers"),
        ({"vertices_coords": [[0, 10**400]] * 3}, "must be numbers"),
        ({"frame_classes": 3}, "frame_classes of frame 0 must be a list"),
        ({"vertices_coords": [[0, 0, 0], [1, 0, 0], [0, NAN, 0]]}, "vertex 2 .* not finite"),
        ({"vertices_coords": np.eye(16)[:, :3].tolist()}, "no flat frame"),
        ({"edges_foldAngle": [0.0]}, "1 entries of edges_foldAngle for 24 edges"),
        ({"edges_foldAngle": [270.0] + [0.0] * 23}, "-180 to 180"),
        ({"edges_foldAngle": ["x"] + [0.0] * 23}, "-180 to 180"),
        ({"edges_foldAngle": [NAN] + [0.0] * 23}, "-180 to 180"),
        ({"edges_vertices": [[0, 1, 2]] * 24}, "two vertex numbers"),
        ({"edges_vertices": [["a", 1]] * 24}, "two vertex numbers"),
        ({"edges_assignment": ["M"]}, "1 entries of edges_assignment for 24 edges"),
        (
            {"edges_vertices": [[0, 1]] * 24, "edges_assignment": ["B"] * 24},
            "lacks the side",
        ),
        ({"file_frames": [3]}, "frame 1 must be an object"),
        ({"file_frames": [{"frame_inherit": True, "frame_parent": 7}]}, "frame_parent 7"),
        ({"file_frames": [{"frame_inherit": True, "frame_parent": 1}]}, "frame_parent 1"),
        (
            {"edges_vertices": None},
            "edges_vertices is missing, so that nobody knows which edges edges_assignment",
        ),
        (
            {"edges_vertices": None, "edges_assignment": None},
            "edges_vertices is missing, so that nobody knows which edges edges_foldAngle",
        ),
        (
            {
                "edges_foldAngle": None,
                "file_frames": [
                    {"frame_classes": ["foldedForm"], "vertices_coords": [[0, 0, 0]] * 16}
                ],
            },
            "folded form: edge .* has no length",
        ),
    ],
)
def test_bad_files_are_refused_with_the_place(tmp_path, pattern, changes, match):
    path = tmp_path / "bad.fold"
    path.write_text(changed(pattern, **changes))
    with pytest.raises(InvalidFile, match=match) as caught:
        read_fold(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    "text", ["", "{", "[1]", '{"a": ' + "9" * 5000 + "}", "\x00\x01", "nothing", "[" * 5000]
)
def test_what_is_no_fold_file_is_refused(tmp_path, text):
    path = tmp_path / "no.fold"
    path.write_text(text)
    with pytest.raises(InvalidFile):
        read_fold(path)
    with pytest.raises(InvalidFile, match="cannot be read"):
        read_fold(tmp_path / "missing.fold")
