"""Sheets in any plane, several of a file, folded forms that unfold, and files known by content."""

import json
from itertools import pairwise

import numpy as np
import pytest
from flat_patterns import fan, grid
from hypothesis import given
from hypothesis import strategies as st
from line_soups import lengths
from strategies import patches

from fab import read_pattern
from fab.errors import InvalidFile
from fab.formats.fold.frames import frame_faces
from fab.formats.fold.reader import read_fold
from fab.formats.fold.writer import fold_bytes
from fab.formats.meshes.obj import obj_bytes
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file
from fab.geometry.rings import ring_areas
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop


def document_of(pattern):
    return json.loads(fold_bytes(pattern, "sheet"))


def read(folder, document, **options):
    path = folder / "sheet.fold"
    path.write_text(json.dumps(document))
    return read_fold(path, ReadOptions(**options))


def turned(seed):
    """A random rotation in space."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def corners_of(pattern):
    return pattern.vertices_coords[pattern.faces_vertices]


def same_shape(first, second):
    """Whether one pattern is the other, turned and moved but not mirrored."""
    a, b = (p.vertices_coords[:, 0] + 1j * p.vertices_coords[:, 1] for p in (first, second))
    a, b = a - a.mean(), b - b.mean()
    turn = np.vdot(a, b)
    return bool(np.abs(a * turn / abs(turn) - b).max() <= 1e-5 * np.abs(b).max())


@given(st.integers(0, 2**32 - 1), st.sampled_from(["creasePattern", "foldedForm", None]))
def test_sheets_in_any_plane_are_seen_from_their_upper_side(tmp_path_factory, seed, kind):
    """Whatever plane and class: the same pattern, not mirrored, mountains where they were."""
    sheet = grid(3, 2, 20.0)
    letters = np.where(np.arange(len(sheet.edges_assignment)) % 3 == 0, "V", sheet.edges_assignment)
    document = document_of(sheet)
    document["edges_assignment"] = np.where(sheet.edges_faces[:, 1] < 0, "B", letters).tolist()
    document["edges_foldAngle"] = None
    shift = np.random.default_rng(seed).uniform(-50, 50, 3)
    points = np.array(document["vertices_coords"]) @ turned(seed).T + shift
    document["vertices_coords"] = points.tolist()
    document["frame_classes"] = [] if kind is None else [kind]
    document = {key: value for key, value in document.items() if value is not None}
    found = read(tmp_path_factory.mktemp("turned"), document)
    assert same_shape(sheet, found.pattern)
    assert np.array_equal(found.pattern.faces_vertices, sheet.faces_vertices)
    assert found.pattern.edges_assignment.tolist() == document["edges_assignment"]
    codes = {finding.code for finding in found.findings}
    assert codes >= {"frame-turned"}
    assert ("flat-form-taken" in codes) == (kind == "foldedForm")
    assert "side-assumed" not in codes


@pytest.mark.parametrize("axes", [(0, 2, 1), (2, 0, 1), (1, 2, 0), (0, 1, 2)])
@pytest.mark.parametrize("flip", [1, -1])
@pytest.mark.parametrize("noise", [0.0, 3e-9])
def test_planes_of_the_axes_keep_coordinates_exactly(tmp_path, axes, flip, noise):
    sheet = grid(2, 2, 10.0)
    points = np.array(document_of(sheet)["vertices_coords"])
    points[:, 2] = np.random.default_rng(1).uniform(-noise, noise, len(points))
    points[:, 1] *= flip
    document = {**document_of(sheet), "vertices_coords": points[:, np.argsort(axes)].tolist()}
    found = read(tmp_path, document).pattern
    assert (ring_areas(corners_of(found), found.faces_offsets) == 100.0).all()
    assert lengths(found) == lengths(sheet)
    assert np.isin(found.vertices_coords, [0, 10, 20]).all()


def test_without_faces_the_side_is_assumed(tmp_path):
    document = document_of(grid(2, 1, 10.0))
    del document["faces_vertices"]
    points = np.array(document["vertices_coords"])
    document["vertices_coords"] = points[:, [0, 2, 1]].tolist()
    found = read(tmp_path, document)
    assert "side-assumed" in {finding.code for finding in found.findings}
    with pytest.raises(InvalidFile, match="which side of the sheet is the upper one"):
        read(tmp_path, document, strict=True)


@given(patches(), st.integers(0, 2**32 - 1))
def test_folded_forms_alone_unfold_into_their_patterns(tmp_path_factory, mesh, seed):
    sheet = crease_pattern(mesh, develop(mesh), 10.0)
    document = document_of(sheet)
    points = sheet.folded_coords @ turned(seed).T
    document["vertices_coords"] = points.tolist()
    document["frame_classes"] = ["foldedForm"]
    del document["file_frames"]
    found = read(tmp_path_factory.mktemp("folded"), document)
    assert same_shape(sheet, found.pattern)
    assert np.array_equal(found.pattern.edges_assignment, sheet.edges_assignment)
    assert np.array_equal(found.pattern.edges_foldAngle, sheet.edges_foldAngle)
    assert found.pattern.folded_coords == pytest.approx(points)
    for key in ("edges_assignment", "edges_foldAngle", "edges_vertices"):
        del document[key]
    again = read(tmp_path_factory.mktemp("folded"), document).pattern
    sided = np.abs(sheet.edges_foldAngle) < 179.9  # beyond, letters alone say to which side
    assert again.edges_foldAngle[sided] == pytest.approx(sheet.edges_foldAngle[sided], abs=1e-6)
    assert np.abs(again.edges_foldAngle) == pytest.approx(np.abs(sheet.edges_foldAngle), abs=1e-6)


def test_sheets_that_fold_flat_are_unfolded_too(tmp_path):
    """A strip folded once onto itself: its faces turn both ways, so that it is no pattern."""
    document = {
        "frame_unit": "mm",
        "frame_classes": ["foldedForm"],
        "vertices_coords": [[0, 0], [10, 0], [4, 0], [4, 5], [10, 5], [0, 5]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
        "edges_assignment": ["B"] * 6 + ["V"],
        "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
    }
    found = read(tmp_path, document)
    assert found.pattern.vertices_coords.max(axis=0).tolist() == [16, 5]
    assert found.pattern.edges_foldAngle.tolist().count(180.0) == 1
    del document["faces_vertices"]
    with pytest.raises(InvalidFile, match="without faces it cannot be unfolded"):
        read(tmp_path, document)


CONE = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
CONE_FACES = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]
# Two squares on a point that is there twice.
DOUBLED = [[0, 0, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0], [0, -1, 1], [1, -1, 1]]
DOUBLED_FACES = [[0, 1, 2, 3], [1, 0, 4, 5]]
TUBE = [[x, y, z] for z in (0, 2) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
TUBE_FACES = [[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)]


@pytest.mark.parametrize(
    ("coords", "faces", "match"),
    [
        (CONE, CONE_FACES, "vertex 0 not flat, the angles around the first add up to 240"),
        (TUBE, TUBE_FACES, "closes on itself at vertex [0-7]"),
        ([*CONE, [3, 3, 3]], [*CONE_FACES, [0, 1, 5]], r"edge \(0, 1\) has more than two faces"),
        ([*CONE[:3], [1, 1, 5]], [[0, 1, 3, 2]], "face 0 of the folded form not flat"),
        (DOUBLED, DOUBLED_FACES, r"edge \(0, 1\) between two faces has no length"),
    ],
)
def test_what_does_not_unfold_is_refused_with_its_place(tmp_path, coords, faces, match):
    document = {"vertices_coords": coords, "faces_vertices": faces}
    with pytest.raises(InvalidFile, match=match):
        read(tmp_path, document)
    corners = np.array([v for face in faces for v in face])
    offsets = np.cumsum([0, *map(len, faces)])
    path = tmp_path / "mesh.obj"
    path.write_bytes(obj_bytes(np.array(coords, float), corners, offsets, "mesh"))
    with pytest.raises(InvalidFile, match=match):
        read_pattern_file(path)


def test_forms_that_are_cut_open_unfold(tmp_path):
    coords = [*TUBE, TUBE[0], TUBE[4]]
    faces = [*TUBE_FACES[:3], [3, 8, 9, 7]]
    found = read(tmp_path, {"frame_unit": "mm", "vertices_coords": coords, "faces_vertices": faces})
    assert sorted(found.pattern.vertices_coords.max(axis=0)) == pytest.approx([2, 4])
    assert found.pattern.counts()["B"] == 10
    assert np.abs(found.pattern.edges_foldAngle).tolist().count(90.0) == 3


def test_one_of_several_patterns_is_chosen(tmp_path):
    first, second = grid(2, 1, 10.0), grid(1, 3, 20.0)
    document = document_of(first)
    form = np.pad(second.vertices_coords, ((0, 0), (0, 1)))
    document["file_frames"] = [
        {**document_of(second), "frame_title": "second"},
        {"frame_classes": ["foldedForm"], "frame_parent": 1, "frame_inherit": True,
         "vertices_coords": form.tolist()},
    ]  # fmt: skip
    found = read(tmp_path, document)
    assert found.patterns == 2
    assert found.pattern.counts() == first.counts()
    assert found.pattern.folded_coords is None
    (told,) = found.findings
    assert told.code == "several-patterns"
    assert "--frame 2" in told.text
    other = read(tmp_path, document, frame=2)
    assert other.findings == ()
    assert other.title == "second"
    assert other.pattern.counts() == second.counts()
    assert other.pattern.folded_coords is not None
    for frame in (0, 3):
        with pytest.raises(InvalidFile, match=f"--frame {frame}: the file has 2 crease patterns"):
            read(tmp_path, document, frame=frame)


def test_titles_are_read_without_what_cannot_be_printed(tmp_path):
    sheet = grid(1, 1, 10.0)
    document = document_of(sheet)
    evil = "\x1b]0;pwned\x07\x1b[31mRED\u202e\n"
    document["file_title"] = evil
    form = {"frame_classes": ["foldedForm"], "frame_title": evil}
    document["file_frames"] = [
        {**form, "vertices_coords": document["vertices_coords"]},
        {**form, "vertices_coords": document["vertices_coords"]},
        {**form, "vertices_coords": document["vertices_coords"][:3]},
    ]
    found = read(tmp_path, document)
    assert found.title == "_]0;pwned__[31mRED__"
    assert [title for title, _ in found.states] == ["_]0;pwned__[31mRED__"]
    assert all(finding.text.isprintable() for finding in found.findings)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_faces_along_edges_that_end_within_them_are_those_without_these_edges(seed, count):
    """A ring with a tree grown into it, whose edges its walk passes forth and back."""
    random = np.random.default_rng(seed)
    ring = list(range(random.integers(3, 8)))
    walk = list(ring)
    for new in range(len(ring), len(ring) + count):
        at = int(random.integers(0, len(walk)))
        walk[at : at + 1] = [walk[at], new, walk[at]]
    start = int(random.integers(0, len(walk)))
    corners, _ = frame_faces("x.fold", [walk[start:] + walk[:start]], len(ring) + count)
    place = corners.tolist().index(0)
    assert corners.tolist()[place:] + corners.tolist()[:place] == ring


@pytest.mark.parametrize(
    ("factor", "match"),
    [(1e300, "over the bound of 1e\\+50. Scale it by"), (1e-320, "under the bound of 1e-50")],
)
def test_sizes_that_geometry_cannot_take_are_refused(tmp_path, factor, match):
    document = document_of(fan(5, 10.0))
    points = np.array(document["vertices_coords"])
    for faces in (True, False):
        large = {**document, "vertices_coords": (points * factor).tolist()}
        if not faces:
            del large["faces_vertices"]
        with pytest.raises(InvalidFile, match=match):
            read(tmp_path, large)
    form = {"frame_classes": ["foldedForm"], "vertices_coords": (points * factor).tolist()}
    with pytest.raises(InvalidFile, match=match):
        read(tmp_path, {**document, "file_frames": [form]})
    far = {**document, "vertices_coords": (points + 1e14).tolist()}
    with pytest.raises(InvalidFile, match="Move it to the origin"):
        read(tmp_path, far)


@pytest.mark.parametrize("factor", [1e-9, 1e-3, 1e3, 1e10])
@pytest.mark.parametrize("shift", [0.0, 1e3])
def test_patterns_of_any_size_and_place_are_read_alike(tmp_path, factor, shift):
    sheet = grid(3, 3, 20.0, without=[(1, 1)])
    document = document_of(sheet)
    points = np.array(document["vertices_coords"])
    document["vertices_coords"] = ((points + shift) * factor).tolist()
    for _ in range(2):
        found = read(tmp_path, document).pattern
        assert found.counts() == sheet.counts()
        assert found.vertices_coords == pytest.approx(sheet.vertices_coords * factor, rel=1e-9)
        document.pop("faces_vertices", None)


@given(st.integers(0, 2**32 - 1), st.integers(4, 14))
def test_what_was_read_and_written_is_read_again(tmp_path_factory, seed, count):
    """Edges between few places, many of them the same: what is read is sound and stays so."""
    random = np.random.default_rng(seed)
    places = random.integers(0, 3, (count, 2)) * 10
    rim = [[0, 0], [20, 0], [20, 20], [0, 20]]
    pairs = random.integers(0, count, (count, 2)).tolist()
    document = {
        "frame_unit": "mm",
        "vertices_coords": [*places.tolist(), *rim],
        "edges_vertices": [*pairs, *([count + k, count + (k + 1) % 4] for k in range(4))],
        "edges_assignment": [*random.choice(["M", "F", "C", "U"], count), *"BBBB"],
    }
    folder = tmp_path_factory.mktemp("again")
    pattern = read(folder, document).pattern
    (folder / "b.fold").write_bytes(fold_bytes(pattern, "b"))
    again, findings = read_pattern(folder / "b.fold", ReadOptions(strict=True))
    assert {finding.code for finding in findings} <= {"crease-dangling", "letters-assignable"}
    assert fold_bytes(again, "b") == (folder / "b.fold").read_bytes()
    rings = [pattern.faces_vertices[i:j] for i, j in pairwise(pattern.faces_offsets)]
    assert all(len(np.unique(ring)) == len(ring) for ring in rings)


def test_one_mesh_is_a_pattern(tmp_path):
    """Flat, in either plane, without angles; folded, with the angles that it has."""
    sheet = grid(2, 1, 10.0)
    flat = np.pad(sheet.vertices_coords, ((0, 0), (0, 1)))
    rise = flat.copy()
    x = flat[:, 0]
    rise[:, 0], rise[:, 2] = np.minimum(x, 10), np.maximum(x - 10, 0)
    for name, points, letter in (
        ("z_up", flat, "U"),
        ("y_up", flat[:, [0, 2, 1]] * [1, 1, -1], "U"),
        ("lone_flat", flat, "U"),
        ("alone_fold", rise, "V"),
        ("roof", rise[:, [0, 2, 1]] * [1, 1, -1], "V"),
    ):
        path = tmp_path / f"{name}.obj"
        path.write_bytes(obj_bytes(points, sheet.faces_vertices, sheet.faces_offsets, name))
        found = read_pattern_file(path)
        assert found.pattern.counts()["B"] == 6
        assert found.pattern.counts()[letter] == 1, name
        assert found.title == name.removesuffix("_flat").removesuffix("_fold")
        assert sorted(found.pattern.vertices_coords.max(axis=0)) == pytest.approx([10, 20])
        codes = {finding.code for finding in found.findings}
        assert ("half-missing" in codes) == ("lone" in name)
        assert ("unfolded" in codes) == (letter == "V")


def test_files_are_known_by_ending_or_content(tmp_path):
    sheet = grid(2, 1, 10.0)
    data = fold_bytes(sheet, "sheet")
    for name in ("sheet.fold", "sheet.FOLD", "sheet.json", "sheet"):
        (tmp_path / name).write_bytes(data)
        assert read_pattern_file(tmp_path / name).pattern.counts() == sheet.counts()
    flat = np.pad(sheet.vertices_coords, ((0, 0), (0, 1)))
    mesh = obj_bytes(flat, sheet.faces_vertices, sheet.faces_offsets, "sheet")
    (tmp_path / "mesh.txt").write_bytes(mesh)
    assert read_pattern_file(tmp_path / "mesh.txt").pattern.face_count == 2
    (tmp_path / "noise.bin").write_bytes(b"\x00\x01 no pattern")
    for name in ("noise.bin", ".", "missing.xyz"):
        with pytest.raises(
            InvalidFile, match=r"Files that are read: \.fold, \.svg|not a file|cannot be"
        ):
            read_pattern_file(tmp_path / name)


# Two squares side by side, without letters; edge 3 is between them.
STRIP = {
    "frame_unit": "mm",
    "frame_classes": ["creasePattern"],
    "vertices_coords": [[0, 0], [2, 0], [4, 0], [0, 2], [2, 2], [4, 2]],
    "edges_vertices": [[0, 1], [1, 2], [0, 3], [1, 4], [2, 5], [3, 4], [4, 5]],
    "faces_vertices": [[0, 1, 4, 3], [1, 2, 5, 4]],
}
HEIR = {"frame_parent": 0, "frame_inherit": True, "frame_classes": ["creasePattern"]}
BENT = [[0, 0, 0], [2, 0, 0], [2, 0, 2], [0, 2, 0], [2, 2, 0], [2, 2, 2]]


def lettered(letter):
    return {"edges_assignment": [*"BBB", letter, *"BBB"]}


def angled(degrees):
    return {"edges_foldAngle": [0, 0, 0, degrees, 0, 0, 0]}


def crease_of(found):
    """Letter and angle of the only crease of a strip."""
    (inner,) = np.flatnonzero(found.pattern.edges_faces[:, 1] >= 0)
    return found.pattern.edges_assignment[inner], found.pattern.edges_foldAngle[inner]


@pytest.mark.parametrize(
    ("change", "crease"),
    [
        (lettered("V") | angled(90), ("V", 90)),
        (angled(-45), ("M", -45)),
        ({"vertices_coords": [[0, 0], [3, 0], [4, 0], [0, 2], [3, 2], [4, 2]]}, ("M", -90)),
        ({"vertices_coords": [[0, 0, 0], [3, 0, 0], [4, 0, 0], [0, 2, 0], [3, 2, 0], [4, 2, 0]]},
         ("M", -90)),
        ({"frame_unit": "cm"}, ("M", -90)),
    ],
)  # fmt: skip
@pytest.mark.parametrize("classes", [True, False])
def test_patterns_that_inherit_count_by_what_they_change(tmp_path, change, crease, classes):
    heir = HEIR if classes else {k: v for k, v in HEIR.items() if k != "frame_classes"}
    document = {**STRIP, **lettered("M"), **angled(-90), "file_frames": [{**heir, **change}]}
    found = read(tmp_path, document)
    assert found.patterns == 2
    (told,) = found.findings
    assert told.code == "several-patterns"
    assert "the first is read. Give --frame 2" in told.text
    assert crease_of(found) == ("M", -90)
    second = read(tmp_path, document, frame=2)
    assert second.findings == ()
    assert crease_of(second) == crease
    with pytest.raises(InvalidFile, match="--frame 3: the file has 2 crease patterns"):
        read(tmp_path, document, frame=3)


def test_the_very_same_pattern_is_not_counted_twice(tmp_path):
    first = {**STRIP, **lettered("M"), **angled(-90)}
    spatial = [[float(x), y, 0.0] for x, y in STRIP["vertices_coords"]]
    again = [
        {**HEIR, "frame_title": "again"},
        {**HEIR, **lettered("M")},
        {**HEIR, "vertices_coords": spatial},
        {**first, **angled(-90.0)},
    ]
    again.append({**HEIR, **lettered("V"), "frame_classes": ["foldedForm"]})
    for classes in (["linkage"], ["graph"], []):
        again.append({**HEIR, "frame_title": "of another class", "frame_classes": classes})
    found = read(tmp_path, {**first, "file_frames": again})
    assert found.patterns == 1
    assert found.findings == ()
    assert crease_of(found) == ("M", -90)
    other = {**HEIR, **lettered("V"), **angled(90)}
    form = {**HEIR, "frame_classes": ["foldedForm"], "frame_parent": 4, "vertices_coords": BENT}
    document = {**first, "file_frames": [*again[:4], other, form]}
    found = read(tmp_path, document)
    assert found.patterns == 2
    assert found.pattern.folded_coords is not None  # of a frame that is the first once more
    second = read(tmp_path, document, frame=2)
    assert crease_of(second) == ("V", 90)
    assert second.pattern.folded_coords is None


@pytest.mark.parametrize("classes", [["linkage"], ["graph"], []])
def test_frames_of_other_classes_are_reported_beside_a_pattern(tmp_path, classes):
    first = {**STRIP, **lettered("M"), **angled(-90)}
    other = {**HEIR, **lettered("V"), "frame_classes": classes}
    form = {**HEIR, "frame_classes": ["foldedForm"], "vertices_coords": BENT}
    found = read(tmp_path, {**first, "file_frames": [form, other]}, strict=True)
    assert found.patterns == 1
    (told,) = found.findings
    assert told.code == "frames-left-out"
    assert "file_frames[1] is neither of class creasePattern" in told.text
    found = read(tmp_path, {**first, "file_frames": [other, other, {**other, **angled(30)}]})
    (told,) = found.findings
    assert "file_frames[0] and 2 other frames are neither" in told.text


@pytest.mark.parametrize("classes", [["linkage"], []])
def test_flat_frames_count_as_patterns_where_none_says_that_it_is_one(tmp_path, classes):
    first = {**STRIP, "frame_classes": classes, **lettered("M"), **angled(-90)}
    second = {**first, **lettered("V"), **angled(90)}
    bent = {**first, "vertices_coords": BENT}
    for document in (
        {**first, "file_frames": [bent, second]},
        {"file_frames": [first, bent, {**first, "vertices_coords": [[0, "x"]]}, second]},
    ):
        found = read(tmp_path, document)
        assert found.patterns == 2
        assert [finding.code for finding in found.findings] == [
            "several-patterns",
            "frames-left-out",
        ]
        assert crease_of(found) == ("M", -90)
        found = read(tmp_path, document, frame=2)
        assert [finding.code for finding in found.findings] == ["frames-left-out"]
        assert crease_of(found) == ("V", 90)


def test_folded_forms_besides_the_one_that_is_unfolded_are_states(tmp_path):
    form = {**STRIP, "frame_classes": ["foldedForm"], **lettered("V"), "vertices_coords": BENT}
    half = [[x, y, z * 0.6] if x < 4 else [2 + 1.6, y, 1.2] for (x, y), z in
            zip(STRIP["vertices_coords"], (0, 0, 2, 0, 0, 2), strict=True)]  # fmt: skip
    more = {**form, "vertices_coords": [*BENT, [9, 9, 9]]}
    found = read(tmp_path, {**form, "file_frames": [{**form, "vertices_coords": half}, more]})
    assert crease_of(found) == ("V", pytest.approx(90))
    assert [points[2].tolist() for _, points in found.states] == [[3.6, 0, 1.2]]
    codes = [finding.code for finding in found.findings]
    assert codes == ["unfolded", "folded-form-differs", "fold-angle-measured"]


@pytest.mark.parametrize("parent", [0, 1])
def test_the_pattern_that_says_more_of_the_same_is_read(tmp_path, parent):
    """Letters that a frame adds are not lost, nor is a folded form of the sheet without them."""
    form = {**HEIR, "frame_classes": ["foldedForm"], "frame_parent": parent}
    frames = [
        {**HEIR, **lettered("V")},
        {**HEIR, **lettered("M")},
        {**form, "vertices_coords": BENT},
    ]
    document = {**STRIP, "file_frames": frames}
    found = read(tmp_path, document)
    assert found.patterns == 3
    assert found.pattern.folded_coords is not None
    assert crease_of(found) == ("V", pytest.approx(90))
    told = found.findings[0]
    assert told.code == "several-patterns"
    assert "number 2 is read, which is the first with edges_assignment besides" in told.text
    assert "--frame 1" in told.text
    assert "assignment-missing" not in {finding.code for finding in found.findings}
    assert crease_of(read(tmp_path, document, frame=2))[0] == "V"
    bare = read(tmp_path, document, frame=1)
    assert "assignment-missing" in {finding.code for finding in bare.findings}
    del document["file_frames"][2]
    assert crease_of(read(tmp_path, document, frame=3))[0] == "M"
    other = {**STRIP, **lettered("V"), "vertices_coords": [[x, 2 * y] for x, y in ((0, 0), (2, 0),
             (4, 0), (0, 2), (2, 2), (4, 2))]}  # fmt: skip
    found = read(tmp_path, {**STRIP, "file_frames": [other]})
    assert "the first is read" in found.findings[0].text  # of another sheet, nothing is known


@pytest.mark.parametrize(
    "odd", [3, {}, "x", [[[[1]]]], [3], ["a" * 9, None], [{}], [[1e999, -0.0]]]
)
@pytest.mark.parametrize("key", ["vertices_coords", "edges_assignment", "frame_unit", "faceOrders"])
def test_odd_values_of_other_patterns_leave_the_first(tmp_path, key, odd):
    document = {**STRIP, **lettered("M"), "faceOrders": [[0, 1, 1]], **angled(-90)}
    found = read(tmp_path, {**document, "file_frames": [{**HEIR, key: odd}]})
    assert [finding.code for finding in found.findings] == ["several-patterns"]
    assert crease_of(found) == ("M", -90)
