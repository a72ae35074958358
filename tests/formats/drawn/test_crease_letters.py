"""Letters and fold angles that a file lacks: assigned on request, reported, or left free."""

import json
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import grid
from helpers import PATTERNS

from fab import read_pattern
from fab.formats.fold.writer import fold_bytes
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file
from fab.jobs.folding_files import simulate

ASSIGN = ReadOptions(assign=True)


def without_letters(tmp_path, numbers, name="bird_base", given=None):
    """A pattern, some of whose letters are U."""
    document = json.loads((PATTERNS / f"{name}.fold").read_text())
    letters = document["edges_assignment"]
    kept = [letters[k] for k in numbers]
    for k in numbers:
        letters[k] = "U"
    document["edges_assignment"] = letters
    if given is not None:
        document["edges_foldAngle"] = given
    path = tmp_path / "u.fold"
    path.write_text(json.dumps(document))
    return path, kept


def found(read):
    return {finding.code: finding for finding in read.findings}


def creases_of(name):
    document = json.loads((PATTERNS / f"{name}.fold").read_text())
    return [k for k, letter in enumerate(document["edges_assignment"]) if letter in "MV"]


@pytest.mark.parametrize("name", ["bird_base", "waterbomb"])
def test_letters_that_follow_are_assigned_on_request(tmp_path, name):
    numbers = creases_of(name)[::9]
    path, kept = without_letters(tmp_path, numbers, name)
    plain, asked = read_pattern_file(path), read_pattern_file(path, ASSIGN)
    whole, _ = read_pattern(PATTERNS / f"{name}.fold")
    assert plain.pattern.counts()["U"] == len(numbers)
    assert "--assign" in found(plain)["letters-assignable"].text
    assert found(plain)["letters-assignable"].creases == tuple(numbers)[:20]
    assert "letters-assigned" not in found(plain)
    finding = found(asked)["letters-assigned"]
    assert finding.creases == tuple(numbers)[:20]
    assert "0 creases stay unassigned" in finding.text
    assert (asked.pattern.edges_assignment == whole.edges_assignment).all()
    assert (asked.pattern.edges_foldAngle == whole.edges_foldAngle).all()
    assert len(kept) > 2


def test_assigned_creases_fold_by_the_angle_that_is_asked_for(tmp_path):
    path, _ = without_letters(tmp_path, creases_of("bird_base")[:1])
    read = read_pattern_file(path, replace(ASSIGN, fold_deg=120.0, strict=False))
    folds = np.isin(read.pattern.edges_assignment, ["M", "V"])
    assert (np.abs(read.pattern.edges_foldAngle[folds]) == 120).all()
    assert "U" not in read.pattern.edges_assignment


def test_what_does_not_follow_stays_free(tmp_path):
    """Nothing follows without any letter; the creases are simulated as free."""
    path, _ = without_letters(tmp_path, creases_of("bird_base"))
    read = read_pattern_file(path, ASSIGN)
    free = len(creases_of("bird_base"))
    assert read.pattern.counts()["U"] == free
    text = found(read)["letters-assigned"].text
    assert text.startswith("no letter follows")
    assert f"{free} creases stay unassigned (U)." in text
    report = simulate(read.pattern, "free", formats=[]).report
    assert (report["verdict"]["driven"], report["verdict"]["free"]) == (0, free)


def test_vertices_that_do_not_fold_flat_are_counted(tmp_path):
    """Four squares of which the common corner has moved."""
    sheet = grid(2, 2, 10.0)
    letters = sheet.edges_assignment.copy()
    letters[sheet.edges_joining] = ["M", "M", "V", "U"]
    angles = np.where(letters == "M", -180.0, np.where(letters == "V", 180.0, 0.0))
    path = tmp_path / "a.fold"
    document = json.loads(
        fold_bytes(replace(sheet, edges_assignment=letters, edges_foldAngle=angles), "a")
    )
    path.write_text(json.dumps(document))
    assert found(read_pattern_file(path, ASSIGN))["letters-assigned"].text.startswith("edge ")
    document["vertices_coords"][4][:2] = [12.0, 13.0]
    path.write_text(json.dumps(document))
    read = read_pattern_file(path, ASSIGN)
    assert "1 vertex does not fold flat (Kawasaki)." in found(read)["letters-assigned"].text
    assert read.pattern.counts()["U"] == 1


def test_a_vertex_that_no_letters_fold_is_reported_with_its_place(tmp_path):
    turns = np.radians([0, 70, 120, 230])
    rim = 50 + 50 * np.column_stack([np.cos(turns), np.sin(turns)])
    document = {
        "frame_unit": "mm",
        "vertices_coords": [[50, 50], *rim.tolist()],
        "edges_vertices": [*([0, k + 1] for k in range(4)), [1, 2], [2, 3], [3, 4], [4, 1]],
        "edges_assignment": [*"MMMU", *"BBBB"],
    }
    path = tmp_path / "a.fold"
    path.write_text(json.dumps(document))
    read = read_pattern_file(path, ASSIGN)
    finding = found(read)["letters-contradict"]
    place = read.pattern.vertices_coords[0] + read.origin
    assert f"at ({place[0]:.6g}, {place[1]:.6g}) mm" in finding.text
    assert read.pattern.counts()["U"] == 1
    assert "letters-assignable" not in found(read_pattern_file(path))


@pytest.mark.parametrize(
    "options", [ReadOptions(strict=True), ReadOptions(strict=True, assign=True)]
)
def test_letters_on_request_are_no_repairs(tmp_path, options):
    numbers = creases_of("bird_base")[::9]
    path, _ = without_letters(tmp_path, numbers)
    document = json.loads(path.read_text())
    whole = read_pattern_file(path).pattern
    assert "U" in document["edges_assignment"]
    path.write_bytes(fold_bytes(whole, "u"))
    read = read_pattern_file(path, options)
    assert ("U" in read.pattern.edges_assignment) != options.assign


SHEET = {
    "frame_unit": "mm",
    "vertices_coords": [[0, 0], [10, 0], [20, 0], [30, 0], [30, 9], [20, 9], [10, 9], [0, 9]],
    "edges_vertices": [*([k, (k + 1) % 8] for k in range(8)), [1, 6], [2, 5]],
    "edges_assignment": [*"BBBBBBBB", "M", "V"],
    "faces_vertices": [[0, 1, 6, 7], [1, 2, 5, 6], [2, 3, 4, 5]],
}


@pytest.mark.parametrize(
    ("angles", "fold_deg", "counts", "folds", "text"),
    [
        ([0, 0], None, {"M": 1, "V": 1}, [-180, 180], "folded by 180 degrees"),
        ([0, 0], 90.0, {"M": 1, "V": 1}, [-90, 90], "folded by 90 degrees"),
        ([0, None], None, {"M": 1, "V": 1}, [-180, 180], "edge 8 with fold angle 0"),
        ([0, 1e-9], None, {"M": 1, "V": 1}, [-180, 180], "edges 8, 9 with fold angle 0"),
        ([-0.0, 30], None, {"F": 1, "V": 1}, [0, 30], "edge 8: a crease with fold angle 0"),
        ([-30, 0], 90.0, {"M": 1, "F": 1}, [-30, 0], "edge 9: a crease with fold angle 0"),
    ],
)
@pytest.mark.parametrize("faces", [True, False])
def test_mountains_and_valleys_of_angle_0(tmp_path, angles, fold_deg, counts, folds, text, faces):
    document = {**SHEET, "edges_foldAngle": [0] * 8 + angles}
    if not faces:
        del document["faces_vertices"]
    path = tmp_path / "a.fold"
    path.write_text(json.dumps(document))
    read = read_pattern_file(path, ReadOptions(fold_deg=fold_deg))
    assert read.pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 8, **counts}
    creases = np.flatnonzero(read.pattern.edges_assignment != "B")
    x = read.pattern.vertices_coords[read.pattern.edges_vertices[creases, 0], 0]
    assert read.pattern.edges_foldAngle[creases[np.argsort(x)]].tolist() == folds
    assert text in found(read)["fold-angle-zero"].text
    assert "fold-angle-missing" not in found(read) or None in angles
