"""Crease patterns of other programs: ten published ones, every repair and every refusal."""

import importlib.util
import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from helpers import PATTERNS
from hypothesis import given
from hypothesis import strategies as st

from fab import read_pattern
from fab.errors import InvalidFile, Severity
from fab.formats.fold.reader import read_fold
from fab.formats.fold.writer import fold_bytes
from fab.formats.read_options import ReadOptions
from fab.formats.strictness import is_repair
from fab.geometry.planar_graph import enclosed_faces, first_crossing, without_dangling
from fab.geometry.rings import ring_areas
from fab.pattern.kinematics import vertices_closure_rad
from solver.errors import InvalidValue

NAMES = sorted(path.stem for path in PATTERNS.glob("*.fold"))
# Edges by letter, faces, width and height, area in mm; from the patterns' own formulas.
FIGURES = {
    "bird_base": ({"M": 10, "V": 18, "F": 0, "B": 8, "J": 4}, 24, (152.4, 152.4), 152.4**2),
    "box": ({"M": 4, "V": 12, "F": 0, "B": 12}, 13, (177.8, 177.8), 177.8**2),
    "crane": ({"M": 35, "V": 54, "F": 0, "B": 10}, 52, (150, 150), 150**2),
    "maze": ({"M": 48, "V": 56, "F": 8, "B": 28}, 65, (6, 6), 36),
    "miura": (
        {"M": 15, "V": 16, "F": 0, "B": 18, "J": 20},
        40,
        (165, 60 * 3**0.5),
        150 * 60 * 3**0.5,
    ),
    "square_twist": ({"M": 4, "V": 8, "F": 0, "B": 12}, 9, (120, 120), 120**2),
    "waterbomb": ({"M": 66, "V": 64, "F": 0, "B": 28}, 96, (8, 8), 64),
    "resch": ({"M": 96, "V": 40, "F": 0, "B": 32, "U": 40}, 128, (120, 40 * 3**0.5), 3200 * 3**0.5),
    "popup": ({"M": 2, "V": 7, "F": 0, "B": 6, "C": 22}, 6, (160, 120), 160 * 120),
    "yoshimura": (
        {"M": 18, "V": 44, "F": 0, "B": 20},
        48,
        (6.5 * 25.4, 160 * 25.4 / 72),
        6 * 160 * 25.4**2 / 72,
    ),
}


def areas(pattern):
    return ring_areas(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets)


@pytest.mark.parametrize("name", NAMES)
def test_published_patterns_are_read(name):
    pattern, findings = read_pattern(PATTERNS / f"{name}.fold")
    counts, faces, size, area = FIGURES[name]
    assert pattern.counts() == counts
    assert pattern.face_count == faces
    assert pattern.vertices_coords.min(axis=0) == pytest.approx([0, 0], abs=1e-12)
    assert pattern.vertices_coords.max(axis=0) == pytest.approx(size)
    assert (areas(pattern) > 0).all()
    assert areas(pattern).sum() == pytest.approx(area)
    assert all(f.severity != Severity.ERROR for f in findings)
    polygons = shapely.polygonize(
        shapely.linestrings(pattern.vertices_coords[pattern.edges_vertices])
    )
    assert len(polygons.geoms) == faces  # shapely finds the same faces
    assert sorted(p.area for p in polygons.geoms) == pytest.approx(sorted(areas(pattern)))


# Not folded flat: boxes and walls stand, some creases of Resch are free.
FLAT = ["bird_base", "crane", "square_twist", "waterbomb", "yoshimura"]


@pytest.mark.parametrize("name", FLAT)
def test_published_patterns_fold_flat_at_each_vertex(name):
    """Kawasaki: every other sector adds up to 180 degrees; Maekawa: M - V = +-2."""
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    creases = np.isin(pattern.edges_assignment, ["M", "V"])
    border = set(pattern.edges_vertices[pattern.edges_assignment == "B"].ravel().tolist())
    seen = 0
    for vertex in set(range(len(pattern.vertices_coords))) - border:
        at = creases & (pattern.edges_vertices == vertex).any(axis=1)
        letters = pattern.edges_assignment[at].tolist()
        if not letters:
            continue
        other = pattern.edges_vertices[at].sum(axis=1) - vertex
        along = pattern.vertices_coords[other] - pattern.vertices_coords[vertex]
        angles = np.sort(np.arctan2(along[:, 1], along[:, 0]))
        sectors = np.diff(np.append(angles, angles[0] + 2 * np.pi))
        assert sectors[::2].sum() == pytest.approx(np.pi)
        if len(letters) > 2:
            assert abs(letters.count("M") - letters.count("V")) == 2
            seen += 1
    assert seen > 3


@pytest.mark.parametrize(
    ("name", "vertices"),
    [
        ("bird_base", 9),
        ("box", 4),
        ("crane", 38),
        ("maze", 48),
        ("miura", 12),
        ("square_twist", 4),
        ("waterbomb", 35),
        ("yoshimura", 15),
    ],
)
def test_fold_angles_of_published_patterns_close(name, vertices):
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    gaps = np.degrees(vertices_closure_rad(pattern))
    assert np.isfinite(gaps).sum() == vertices
    assert np.nanmax(gaps) < 1e-9


def test_the_files_are_those_of_their_script():
    spec = importlib.util.spec_from_file_location("patterns", PATTERNS / "make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for pattern in module.PATTERNS:
        written = (PATTERNS / f"{pattern.__name__}.fold").read_text()
        assert written == module.text_of(pattern()), pattern.__name__


@pytest.mark.parametrize("name", NAMES)
def test_what_was_read_is_written_and_read_alike(tmp_path, name):
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    (tmp_path / "again.fold").write_bytes(fold_bytes(pattern, name))
    again, findings = read_pattern(tmp_path / "again.fold", ReadOptions(strict=True))
    assert {f.code for f in findings} <= {"crease-dangling"}
    assert fold_bytes(again, name) == (tmp_path / "again.fold").read_bytes()
    assert again.counts() == pattern.counts()
    for key in ("vertices_coords", "edges_vertices", "edges_faces", "edges_foldAngle"):
        assert np.array_equal(getattr(again, key), getattr(pattern, key)), key


# Two squares side by side, 1 unit = 1 mm; edge 6 is the crease between them.
SQUARES = {
    "frame_unit": "mm",
    "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
    "edges_assignment": ["B", "B", "B", "B", "B", "B", "V"],
    "edges_foldAngle": [0, 0, 0, 0, 0, 0, 90],
    "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
}


def read(tmp_path, document, **options):
    path = tmp_path / "sheet.fold"
    path.write_text(json.dumps(document))
    return read_pattern(path, ReadOptions(**options))


def changed(**changes):
    document = {**json.loads(json.dumps(SQUARES)), **changes}
    return {key: value for key, value in document.items() if value is not None}


def with_edge(pair, letter, points=(), **changes):
    """The two squares with one edge, and points, more; its faces are left to be found."""
    return changed(
        vertices_coords=[*SQUARES["vertices_coords"], *points],
        edges_vertices=[*SQUARES["edges_vertices"], pair],
        edges_assignment=[*SQUARES["edges_assignment"], letter],
        edges_foldAngle=[*SQUARES["edges_foldAngle"], {"M": -90, "V": 90}.get(letter, 0)],
        **{"faces_vertices": None, **changes},
    )


def test_a_sound_file_has_no_findings(tmp_path):
    pattern, findings = read(tmp_path, SQUARES)
    assert findings == ()
    assert pattern.counts() == {"M": 0, "V": 1, "F": 0, "B": 6}
    assert pattern.edges_foldAngle.tolist().count(90.0) == 1


@pytest.mark.parametrize(
    ("document", "code", "edges", "counts"),
    [
        (changed(frame_unit=None), "unit-unknown", (), {"V": 1, "B": 6}),
        (changed(frame_unit="unit"), "unit-unknown", (), {"V": 1, "B": 6}),
        (
            changed(edges_vertices=None, edges_assignment=None, edges_foldAngle=None),
            "edges-missing",
            (),
            {"U": 1, "B": 6},
        ),
        (changed(edges_assignment=None), "assignment-missing", (), {"V": 1, "B": 6}),
        (
            changed(edges_assignment=None, edges_foldAngle=None),
            "assignment-missing",
            (),
            {"U": 1, "B": 6},
        ),
        (changed(edges_assignment=[*"BBBBBBx"]), "assignment-unknown", (6,), {"U": 1, "B": 6}),
        (changed(edges_assignment=[*"BBBBBBv"]), "assignment-unknown", (6,), {"V": 1, "B": 6}),
        (
            changed(edges_assignment=["B"] * 6 + [None]),
            "assignment-unknown",
            (6,),
            {"U": 1, "B": 6},
        ),
        (changed(edges_foldAngle=None), "fold-angle-missing", (), {"V": 1, "B": 6}),
        (changed(edges_foldAngle=[None] * 7), "fold-angle-missing", (6,), {"V": 1, "B": 6}),
        (changed(edges_assignment=[*"BBBBBBM"]), "fold-angle-contradicts", (6,), {"M": 1, "B": 6}),
        (changed(edges_assignment=[*"BBBBBBF"]), "fold-angle-contradicts", (6,), {"F": 1, "B": 6}),
        (with_edge([2, 2], "M"), "zero-length-edge", (7,), {"V": 1, "B": 6}),
        (with_edge([2, 6], "M", [[2, 0]]), "zero-length-edge", (7,), {"V": 1, "B": 6}),
        (with_edge([4, 1], "V", angle=90), "duplicate-edge", (7,), {"V": 1, "B": 6}),
        (with_edge([4, 1], "U"), "duplicate-edge", (7,), {"V": 1, "B": 6}),
        (with_edge([4, 1], "C"), "duplicate-edge", (6,), {"C": 1, "B": 6}),
        (
            changed(vertices_coords=[*SQUARES["vertices_coords"], [9, 9]]),
            "vertex-unused",
            (),
            {"V": 1, "B": 6},
        ),
        (changed(faces_vertices=None), "faces-rebuilt", (), {"V": 1, "B": 6}),
        (changed(faces_vertices=[]), "faces-rebuilt", (), {"V": 1, "B": 6}),
        (
            changed(faces_vertices=[[5, 4, 1, 0], [1, 2, 3, 4]]),
            "face-clockwise",
            (),
            {"V": 1, "B": 6},
        ),
        (
            changed(faces_vertices=[[0, 1, 4, 5], [1, 2, 3, 4], [0, 1, 2]]),
            "face-without-area",
            (),
            {"V": 1, "B": 6},
        ),
        (changed(edges_assignment=[*"MBBBBBV"]), "border-unmarked", (0,), {"V": 1, "B": 6}),
        (
            with_edge([1, 6], "C", [[0.5, 0.5]]),
            "crease-dangling",
            (7,),
            {"V": 1, "B": 6, "C": 1},
        ),
        (
            with_edge([6, 7], "C", [[0.3, 0.5], [0.6, 0.5]]),
            "crease-dangling",
            (7,),
            {"V": 1, "B": 6, "C": 1},
        ),
        (
            with_edge(
                [6, 7], "C", [[1.3, 0.5], [1.6, 0.5]], faces_vertices=SQUARES["faces_vertices"]
            ),
            "crease-dangling",
            (7,),
            {"V": 1, "B": 6, "C": 1},
        ),
    ],
)
def test_every_repair_names_its_edges(tmp_path, document, code, edges, counts):
    pattern, findings = read(tmp_path, document)
    (finding,) = [f for f in findings if f.code == code]
    assert finding.creases == edges
    assert all(str(edge) in finding.text for edge in edges)
    assert pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 0, **counts}
    assert areas(pattern) == pytest.approx([1, 1])
    assert pattern.vertices_coords.max(axis=0).tolist() == [2, 1]
    fold = pattern.edges_foldAngle[np.isin(pattern.edges_assignment, ["M", "V"])]
    assert (np.sign(fold) == np.where(counts.get("M"), -1, 1)).all()
    assert (pattern.edges_foldAngle[pattern.edges_assignment == "B"] == 0).all()
    first = next((f for f in findings if is_repair(f)), None)
    if first is None:
        assert read(tmp_path, document, strict=True)[1] == findings
        return
    with pytest.raises(InvalidFile) as refused:
        read(tmp_path, document, strict=True)
    refusal = f"{tmp_path / 'sheet.fold'}: {first.text} --strict refuses this."
    assert str(refused.value) == refusal


def test_sides_without_length_that_cross_their_face_are_merged(tmp_path):
    """Edge 7 is 1e-10 long and turned around: its face crosses itself by that much."""
    document = changed(
        vertices_coords=[*SQUARES["vertices_coords"][:5], [1e-10, 1], [0, 1]],
        edges_vertices=[*SQUARES["edges_vertices"][:4], [4, 5], [6, 0], [1, 4], [5, 6]],
        edges_assignment=[*SQUARES["edges_assignment"], "B"],
        edges_foldAngle=[*SQUARES["edges_foldAngle"], 0],
        faces_vertices=[[0, 1, 4, 5, 6], [1, 2, 3, 4]],
    )
    pattern, findings = read(tmp_path, document)
    assert findings == ()  # a short side alone stays
    document["vertices_coords"][5:] = [[0, 1 - 1e-10], [0, 1]]
    pattern, (finding,) = read(tmp_path, document)
    assert finding.code == "zero-length-edge"
    assert finding.creases == (7,)
    assert pattern.counts() == {"M": 0, "V": 1, "F": 0, "B": 6}


def test_edges_are_named_in_the_order_of_the_file(tmp_path):
    """Faces name the crease 4 first, the crease 1 last."""
    document = {
        "frame_unit": "mm",
        "vertices_coords": [[x, y] for y in (0, 1) for x in range(4)],
        "edges_vertices": [
            *([0, 1], [2, 6], [1, 2], [2, 3], [1, 5]),
            *([0, 4], [4, 5], [5, 6], [6, 7], [7, 3]),
        ],
        "edges_assignment": [*"BMBBVBBBBB"],
        "edges_foldAngle": [0, 20, 0, 0, -10, 0, 0, 0, 0, 0],
        "faces_vertices": [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]],
    }
    pattern, (finding,) = read(tmp_path, document)
    assert finding.creases == (1, 4)
    assert (
        "edges 1, 4: the sign of the fold angle (20) contradicts the assignment M" in finding.text
    )
    assert sorted(pattern.edges_foldAngle[pattern.edges_foldAngle != 0]) == [-20, 10]


def test_slits_belong_to_the_face_around_them(tmp_path):
    document = with_edge([6, 7], "C", [[1.3, 0.5], [1.6, 0.5]])
    pattern, _ = read(tmp_path, document)
    (slit,) = np.flatnonzero(pattern.edges_assignment == "C")
    face = pattern.edges_faces[slit]
    assert face[0] == face[1]
    corners = pattern.faces_vertices[pattern.faces_offsets[face[0]] :][:4]
    assert pattern.vertices_coords[corners].mean(axis=0).tolist() == [1.5, 0.5]


def test_holes_amid_faces_are_found(tmp_path):
    points = [[x, y] for y in range(4) for x in range(4)]
    pairs = [[v, v + 1] for v in range(16) if v % 4 < 3] + [[v, v + 4] for v in range(12)]
    around = [{5, 6}, {9, 10}, {5, 9}, {6, 10}]
    letters = [
        "B"
        if set(p) in around or {q // 4 for q in p} in ({0}, {3}) or {q % 4 for q in p} in ({0}, {3})
        else "M"
        for p in pairs
    ]
    document = {
        "vertices_coords": points,
        "edges_vertices": pairs,
        "edges_assignment": letters,
    }
    pattern, findings = read(tmp_path, document, mm_per_unit=2.0)
    assert "hole" in {f.code for f in findings}
    assert "border-inside" not in {f.code for f in findings}
    assert areas(pattern) == pytest.approx([4.0] * 8)
    document["edges_assignment"] = [
        "F" if set(p) in around else x for p, x in zip(pairs, letters, strict=True)
    ]
    pattern, findings = read(tmp_path, document, mm_per_unit=2.0)
    assert "hole" not in {f.code for f in findings}
    assert pattern.face_count == 9


@pytest.mark.parametrize(
    ("unit", "mm"),
    [("mm", 1), ("cm", 10), ("m", 1000), ("in", 25.4), ("pt", 25.4 / 72), ("unit", 7.0)],
)
def test_units_become_millimetres(tmp_path, unit, mm):
    pattern, _ = read(tmp_path, changed(frame_unit=unit), mm_per_unit=7.0)
    assert pattern.vertices_coords.max(axis=0) == pytest.approx([2 * mm, mm])


def test_a_file_without_letters_and_angles_says_so(tmp_path):
    _, (told,) = read(tmp_path, changed(edges_assignment=None, edges_foldAngle=None))
    assert told.code == "assignment-missing"
    assert "nor fold angles: no crease is a mountain or a valley" in told.text
    _, (told,) = read(tmp_path, changed(edges_assignment=None))
    assert "mountains and valleys are those of the fold angles" in told.text


def test_a_tolerance_for_lines_has_no_effect_on_faces_and_says_so(tmp_path):
    _, (told,) = read(tmp_path, changed(), merge_mm=0.5, strict=True)
    assert told.code == "merge-unused"
    assert "--merge-mm 0.5 has no effect" in told.text
    _, found = read(tmp_path, changed(faces_vertices=None), merge_mm=0.5)
    assert [finding.code for finding in found] == ["faces-rebuilt"]


ROOF = [[0, 0, 0], [1, 0, 0], [2, 0, 1], [2, 1, 1], [1, 1, 0], [0, 1, 0]]
ISLAND = [[0.3, 0.3], [0.6, 0.3], [0.6, 0.6]]
NAN = float("nan")


@pytest.mark.parametrize(
    ("document", "match"),
    [
        (changed(frame_unit="ell"), "frame_unit = 'ell' must be one of unit, mm"),
        (changed(frame_unit=3), "frame_unit = 3"),
        (changed(vertices_coords=[[0, NAN], [1, 0], [2, 0]]), "vertex 0 .* not finite"),
        (
            changed(vertices_coords=ROOF, frame_classes=["creasePattern"]),
            "no flat frame: the crease pattern's z runs over 1",
        ),
        (
            changed(vertices_coords=[*ROOF[:3], [2, 1, 2], *ROOF[4:]]),
            "face 1 of the folded form not flat",
        ),
        (changed(vertices_coords=ROOF, faces_vertices=None), "without faces it cannot be unfolded"),
        (changed(edges_vertices=None, faces_vertices=None), "edges_vertices is missing"),
        (changed(edges_vertices=None), "edges_vertices is missing, .* edges_assignment is of"),
        (
            changed(edges_vertices=None, edges_assignment=None),
            "edges_vertices is missing, .* remove edges_foldAngle",
        ),
        (changed(edges_vertices=[[0, 1], [1]]), "edge 1 must have two vertex numbers"),
        (changed(edges_vertices=[[0, 1], [1, 2.5]]), "edge 1 must have two vertex numbers"),
        (changed(edges_vertices=[[0, 1], [1, 10**30]]), "edge 1 names|edge 1 must"),
        (with_edge([1, 6], "M"), "edge 7 names the vertices .1, 6.; vertices run from 0 to 5"),
        (with_edge([-1, 2], "M"), "edge 7 names"),
        (changed(edges_assignment=["B"]), "1 entries of edges_assignment for 7 edges"),
        (changed(edges_foldAngle=[0]), "1 entries of edges_foldAngle for 7 edges"),
        (changed(edges_foldAngle=[0] * 6 + [200]), "fold angle 200 of edge 6"),
        (changed(edges_foldAngle=[0] * 6 + [NAN]), "fold angle nan of edge 6"),
        (changed(edges_foldAngle=[0] * 6 + [True]), "fold angle True of edge 6"),
        (with_edge([4, 1], "M"), r"edges 7 and 6 join the same vertices, M and V|edges 6 and 7"),
        (
            with_edge([6, 7], "B", [[0.5, 0.2], [1.5, 0.2]]),
            r"open at edge 7: a gap of 1 mm between",
        ),
        (with_edge([1, 6], "B", [[0.5, 0.5]]), "the outline is open at edge 7"),
        (
            changed(edges_assignment=[*"BBBBBBB"]),
            r"edge 6, near \(1, 0.5\) mm, is a border .* --inner-border cut",
        ),
        (
            changed(edges_assignment=[*"BBBBBBB"], faces_vertices=None),
            r"edge 6 from \(1, 0\) mm to \(1, 1\) mm is a border .* --inner-border cut",
        ),
        (changed(faces_vertices=[[0, 1, 2, 3, 4, 5], [0, 1, 4]]), "edge"),
        (changed(faces_vertices=[[0, 1, 3, 5]]), "lacks the side"),
        (changed(faces_vertices=[[0, 1, 99]]), "vertex 99"),
        (
            changed(edges_vertices=[[0, 1]], edges_assignment=["V"], edges_foldAngle=[9]),
            "lacks the side",
        ),
        (
            changed(
                edges_vertices=[[0, 1]],
                edges_assignment=["V"],
                edges_foldAngle=[9],
                faces_vertices=None,
            ),
            "enclose no face",
        ),
    ],
)
def test_what_cannot_be_meant_in_one_way_is_refused(tmp_path, document, match):
    with pytest.raises(InvalidFile, match=match) as caught:
        read(tmp_path, document)
    assert "sheet.fold" in str(caught.value)


@pytest.mark.parametrize(
    ("document", "code", "counts"),
    [
        (with_edge([0, 3], "M"), "lines-split", {"M": 2, "V": 2, "B": 6}),
        (with_edge([0, 2], "M"), "duplicate-line", {"V": 1, "B": 6}),
        (with_edge([5, 6], "M", [[1, 0.5]]), "lines-split", {"M": 1, "V": 2, "B": 6}),
        (with_edge([5, 6], "M", [[0.999, 0.5]]), "ends-extended", {"M": 1, "V": 2, "B": 6}),
        (with_edge([5, 6], "M", [[1.001, 0.001]]), "ends-joined", {"M": 1, "V": 1, "B": 6}),
        (with_edge([2, 6], "M", [[3, 3]]), "line-outside", {"V": 1, "B": 6}),
        (
            changed(
                vertices_coords=[*SQUARES["vertices_coords"], *ISLAND],
                edges_vertices=[*SQUARES["edges_vertices"], [6, 7], [7, 8], [8, 6]],
                edges_assignment=[*SQUARES["edges_assignment"], "B", "B", "B"],
                edges_foldAngle=None,
                faces_vertices=None,
            ),
            "island-joined",
            {"V": 1, "B": 9, "J": 2},
        ),
    ],
)
def test_edges_without_faces_are_lines_of_a_drawing(tmp_path, document, code, counts):
    pattern, findings = read(tmp_path, document)
    told = {finding.code: finding for finding in findings}
    assert " mm" in told[code].text
    assert pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 0, **counts}
    assert pattern.vertices_coords.max(axis=0).tolist() == [2, 1]
    again, findings = written(tmp_path, pattern)
    assert {finding.code for finding in findings} <= {"crease-dangling"}
    assert np.array_equal(again.edges_vertices, pattern.edges_vertices)


def written(tmp_path, pattern):
    (tmp_path / "again.fold").write_bytes(fold_bytes(pattern, "again"))
    return read_pattern(tmp_path / "again.fold", ReadOptions(strict=True))


def test_borders_within_the_sheet_are_cuts_where_asked_for(tmp_path):
    path = tmp_path / "sheet.fold"
    for faces in (SQUARES["faces_vertices"], None):
        path.write_text(json.dumps(changed(edges_assignment=[*"BBBBBBB"], faces_vertices=faces)))
        found = read_fold(path, ReadOptions(inner_border="cut"))
        assert found.pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 6, "C": 1}
        assert "border-inside" in {finding.code for finding in found.findings}


@pytest.mark.parametrize("name", NAMES)
def test_files_without_faces_keep_the_numbers_of_vertices(tmp_path, name):
    """The same pattern with its faces left out, and a folded form that names its vertices."""
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    folded = np.random.default_rng(1).uniform(0, 1, (len(pattern.vertices_coords), 3))
    document = json.loads(fold_bytes(replace(pattern, folded_coords=folded), name))
    del document["faces_vertices"]
    again, findings = read(tmp_path, document)
    assert {f.code for f in findings} <= {"faces-rebuilt", "crease-dangling", "hole"}
    assert np.array_equal(again.vertices_coords, pattern.vertices_coords)
    assert np.array_equal(again.folded_coords, folded)
    for key in ("edges_vertices", "edges_assignment"):
        first, second = getattr(pattern, key), getattr(again, key)
        assert sorted(map(str, np.sort(first, axis=-1))) == sorted(
            map(str, np.sort(second, axis=-1))
        )


def test_folded_forms_follow_edges_that_are_split(tmp_path):
    """A crease that crosses nothing folded: the new vertex is between the ends in both forms."""
    document = with_edge([6, 7], "F", [[0.5, 0], [0.5, 1]])
    folded = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 0, 1],
        [1, 1, 1],
        [1, 1, 0],
        [0, 1, 0],
        [0.5, 0, 0],
        [0.5, 1, 0],
    ]
    document["file_frames"] = [{"frame_classes": ["foldedForm"], "vertices_coords": folded}]
    pattern, findings = read(tmp_path, document)
    assert pattern.face_count == 3
    assert len(pattern.folded_coords) == 8
    document["file_frames"][0]["vertices_coords"][6] = [0.5, 0.3, 0.4]
    pattern, findings = read(tmp_path, document)
    (told,) = [f for f in findings if f.code == "folded-form-differs"]
    assert "(0.5, 0) mm" in told.text
    assert pattern.folded_coords is None


def test_an_open_outline_names_its_gap(tmp_path):
    pairs = [pair for pair in SQUARES["edges_vertices"] if pair != [0, 1]]
    document = changed(
        edges_vertices=pairs,
        edges_assignment=[*"BBBBBV"],
        edges_foldAngle=None,
        faces_vertices=None,
    )
    with pytest.raises(InvalidFile, match=r"a gap of 1 mm between .* mm and .*, 0\) mm"):
        read(tmp_path, document)


@pytest.mark.parametrize("bad", [0, -1, NAN, "1"])
def test_the_unit_must_be_a_length(tmp_path, bad):
    with pytest.raises(InvalidValue, match="mm_per_unit"):
        read(tmp_path, SQUARES, mm_per_unit=bad)


def test_lips_of_a_slit_are_one_cut(tmp_path):
    """Two pieces side by side whose borders share a line, each with vertices of its own."""
    document = {
        "frame_unit": "mm",
        "vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1], [1, 0], [2, 0], [2, 1], [1, 1]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4]],
        "edges_assignment": ["B"] * 8,
    }
    pattern, findings = read(tmp_path, document)
    assert pattern.face_count == 2
    assert pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 6, "C": 1}
    codes = {"faces-rebuilt", "vertices-merged", "duplicate-line", "border-shared"}
    assert {f.code for f in findings} == codes
    document["faces_vertices"] = [[0, 1, 2, 3], [4, 5, 6, 7]]
    pattern, findings = read(tmp_path, document)
    assert findings == ()
    assert pattern.counts()["B"] == 8
    del document["faces_vertices"]
    document["edges_assignment"][1] = "M"
    with pytest.raises(InvalidFile, match=r"edge 7 from .* is a border"):
        read(tmp_path, document)


@given(st.integers(0, 2**32 - 1), st.integers(4, 30))
def test_faces_of_random_triangulations_are_found(seed, count):
    from scipy.spatial import Delaunay

    random = np.random.default_rng(seed)
    points = random.uniform(0, 1, (count, 2))
    triangles = Delaunay(points).simplices
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, ::2]]))
    pairs = np.unique(sides, axis=0)
    random.shuffle(pairs, axis=1)
    corners, offsets = enclosed_faces(points, pairs)
    found = {frozenset(corners[i:j].tolist()) for i, j in pairwise(offsets)}
    assert found == {frozenset(t) for t in triangles.tolist()}
    assert without_dangling(pairs).all()
    nowhere = np.zeros(len(pairs), bool)
    assert first_crossing(points, pairs, 1e-12, nowhere) is None
    one, two = pairs[0]
    off = points[two] - points[one]
    across = points[[one, two]].mean(axis=0) + np.outer([-1e-3, 1e-3], [-off[1], off[0]])
    more = np.concatenate([points, across]), np.concatenate([pairs, [[count, count + 1]]])
    met = first_crossing(*more, 1e-12, np.append(nowhere, False))
    assert met is not None
    assert met[:2] == (0, len(pairs))
    assert met[2] == pytest.approx(points[[one, two]].mean(axis=0))


def test_our_own_files_read_alike_either_way(tmp_path):
    from fab.pattern.crease_pattern import crease_pattern
    from fab.pattern.development import develop
    from solver import Miura

    mesh = Miura(columns=4, rows=3).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 10.0)
    (tmp_path / "miura.fold").write_bytes(fold_bytes(pattern, "miura"))
    strict, _ = read_pattern(tmp_path / "miura.fold", ReadOptions(strict=True))
    free, findings = read_pattern(tmp_path / "miura.fold")
    assert findings == ()
    for key in ("edges_vertices", "edges_faces", "edges_foldAngle", "edges_assignment"):
        assert np.array_equal(getattr(strict, key), getattr(free, key)), key


def test_a_folded_form_of_another_sheet_is_left_out_and_told(tmp_path):
    square = {
        "file_spec": 1.1,
        "vertices_coords": [[0, 0], [9, 0], [9, 9], [0, 9]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]],
        "edges_assignment": ["B", "B", "B", "B", "V"],
        "file_frames": [
            {
                "frame_classes": ["foldedForm"],
                "vertices_coords": [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 5]],
            }
        ],
    }
    path = tmp_path / "square.fold"
    path.write_text(json.dumps(square))
    pattern, findings = read_pattern(path, ReadOptions(mm_per_unit=2.0))
    assert pattern.folded_coords[3].tolist() == [0, 18, 10]
    assert "folded-form-differs" not in {finding.code for finding in findings}
    square["file_frames"][0]["vertices_coords"].pop()
    path.write_text(json.dumps(square))
    pattern, findings = read_pattern(path)
    assert pattern.folded_coords is None
    assert "folded-form-differs" in {finding.code for finding in findings}
