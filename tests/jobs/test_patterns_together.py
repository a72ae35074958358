"""Several patterns on the same sheets: each as it is alone, with names that no two share."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from flat_patterns import fan, grid, strips
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.cli.group import main
from fab.drawings.drawing_files import SheetFormat
from fab.errors import Finding, Severity
from fab.formats.fold.writer import fold_bytes
from fab.jobs.assembly_files import guide_of
from fab.jobs.sheet_files import fabricate, fabricate_together
from fab.pattern.side_by_side import side_by_side
from fab.sheets.cut_pieces import PatternCopies
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.sheet_drawings import sheet_drawings
from solver.errors import InvalidValue

STOCK = {"material": "card_300gsm", "machine": "co2_40w_300x200"}


def requested(page=False, **keys):
    return CutterSettings(**STOCK, **keys).request([SheetFormat.DXF], page=page)


def test_one_pattern_is_as_it_is_alone():
    alone = fabricate(grid(3, 2, 120.0), "board", requested(page=True, copies=2))
    together = fabricate_together(
        [PatternCopies("board", grid(3, 2, 120.0))], "board", requested(page=True, copies=2)
    )
    assert dict(alone.files) == dict(together.files)


def test_pieces_and_seams_are_counted_on_over_all_patterns():
    """Work is that of each alone: lengths of cuts and creases are sums."""
    patterns = [grid(4, 2, 80.0), strips(0.0, 2, 3), fan(6, 40.0)]
    wanted = [
        PatternCopies(name, pattern, copies)
        for name, pattern, copies in zip("xyz", patterns, (2, 1, 3), strict=True)
    ]
    made = fabricate_together(wanted, "all", requested(copies=2))
    single = [fabricate(p.pattern, p.name, requested(copies=2 * p.copies)) for p in wanted]
    report = made.report
    names = [piece["name"] for piece in report["pieces"]]
    assert len(set(names)) == len(names)
    assert [row["label"] for row in report["glue_up"]] == [*range(1, len(report["glue_up"]) + 1)]
    for key in ("pieces", "glue_up"):
        assert [row["pattern"] for row in report[key]] == [
            row["pattern"] for each in single for row in each.report[key]
        ]
    assert [(row["name"], row["copies"]) for row in report["patterns"]] == [
        ("x", 4),
        ("y", 2),
        ("z", 6),
    ]
    for row, each in zip(report["patterns"], single, strict=True):
        assert row["pieces"] == len(each.report["pieces"])
        assert row["seams"] == len(each.report["glue_up"])
    for key in ("cut_mm", "perforate_mm"):
        total = sum(sheet[key] for sheet in report["sheets"])
        alone = sum(sheet[key] for each in single for sheet in each.report["sheets"])
        assert total == pytest.approx(alone, abs=0.01)
    lying = [name for sheet in report["sheets"] for name in sheet["pieces"]]
    copies = {row["name"]: row["copies"] for row in report["patterns"]}
    assert sorted(lying) == sorted(
        piece["name"] for piece in report["pieces"] for _ in range(copies[piece["pattern"]])
    )
    assert len(report["sheets"]) <= sum(len(each.report["sheets"]) for each in single)


def test_findings_name_their_pattern_and_count_its_edges_in_all():
    found = Finding("told", Severity.NOTE, "something.", creases=(2,), panels=(1,))
    one, other = grid(2, 1, 30.0), grid(3, 1, 30.0)
    made = fabricate_together(
        [PatternCopies("one", one), PatternCopies("other", other, findings=(found,))],
        "both",
        requested(),
    )
    (told,) = (f for f in made.findings if f.code == "told")
    assert told.text == "other: something."
    assert told.creases == (len(one.edges_vertices) + 2,)
    assert told.panels == (one.face_count + 1,)


def test_two_patterns_of_one_name_are_refused():
    both = [PatternCopies("a", grid(1, 1, 30.0))] * 2
    with pytest.raises(InvalidValue, match="must be of one pattern"):
        fabricate_together(both, "a", requested())
    with pytest.raises(InvalidValue, match="copies = 0"):
        PatternCopies("a", grid(1, 1, 30.0), 0)


@settings(max_examples=20)
@given(st.lists(st.tuples(st.integers(1, 4), st.integers(1, 3)), min_size=1, max_size=4))
def test_patterns_side_by_side_are_theirs(sizes):
    patterns = [grid(columns, rows, 10.0) for columns, rows in sizes]
    made = side_by_side(patterns)
    whole = made.pattern
    assert whole.face_count == sum(each.face_count for each in patterns)
    for number, each in enumerate(patterns):
        face, edge = made.first_faces[number], made.first_edges[number]
        begin, end = whole.faces_offsets[[face, face + each.face_count]]
        corners = whole.vertices_coords[whole.faces_vertices[begin:end]]
        own = each.vertices_coords[each.faces_vertices]
        shift = corners - own
        np.testing.assert_allclose(shift, shift[:1].repeat(len(shift), 0), atol=1e-9)
        edges = slice(edge, edge + len(each.edges_vertices))
        assert whole.edges_assignment[edges].tolist() == each.edges_assignment.tolist()
        beside = whole.edges_faces[edges]
        assert np.where(beside >= 0, beside - face, -1).tolist() == each.edges_faces.tolist()
    low = [whole.vertices_coords[whole.edges_vertices[e], 0].min() for e in made.first_edges]
    assert low == sorted(set(low))


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, pattern in (("lid", grid(2, 1, 30.0)), ("box", grid(2, 2, 40.0))):
        Path(f"{name}.fold").write_bytes(fold_bytes(pattern, name))
    return tmp_path


def run(*words):
    keys = [part for key, name in STOCK.items() for part in (f"--{key}", name)]
    return CliRunner().invoke(main, ["fabricate", *map(str, words), *keys, "--only", "svg"])


def test_copies_are_those_of_each_file(here):
    result = run("lid.fold", "box.fold", "--copies", "2,1")
    assert result.exit_code == 0, result.output
    assert "lid: 2 copies of 1 piece, 0 seams" in result.output
    assert "box: 1 copy of 1 piece, 0 seams" in result.output
    report = json.loads(Path("lid_box_sheets_report.json").read_text())
    assert report["sheets"][0]["pieces"] == ["A", "A", "B"]
    assert report["sheets"][0]["files"] == ["lid_box_1.svg"]
    assert run("lid.fold", "lid.fold", "--copies", 2).exit_code == 0
    report = json.loads(Path("lid_lid_2_sheets_report.json").read_text())
    assert [(row["name"], row["copies"]) for row in report["patterns"]] == [
        ("lid", 2),
        ("lid_2", 2),
    ]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--copies", "2,1,1"), "3 numbers for 2 files. Give one number, or one for each file."),
        (("--copies", "many"), "must be a whole number, or one for each file: 2,1."),
        (("--copies", "0"), "copies = 0"),
        (("--copies", "1,0"), "copies = 0"),
        (("--width-mm", "5000"), "with its tabs"),
    ],
)
def test_bad_requests_write_nothing(here, words, text):
    result = run("lid.fold", "box.fold", *words)
    assert result.exit_code == 2, result.output
    assert text in result.output
    assert sorted(path.name for path in here.iterdir()) == ["box.fold", "lid.fold"]


@pytest.mark.parametrize("priority", [["box"], ["B"]])
def test_patterns_and_pieces_with_priority_lie_on_the_first_sheet(priority):
    """Boards fill a sheet each, so that a small box would come last."""
    wanted = [PatternCopies("board", grid(3, 2, 90.0), 2), PatternCopies("box", grid(2, 1, 30.0))]
    late = fabricate_together(wanted, "all", requested()).report["sheets"]
    early = fabricate_together(wanted, "all", requested(priority=priority)).report["sheets"]
    assert "B" not in late[0]["pieces"]
    assert "B" in early[0]["pieces"]
    assert sorted(name for sheet in early for name in sheet["pieces"]) == ["A", "A", "B"]


def test_priority_of_nothing_is_refused():
    wanted = [PatternCopies("board", grid(2, 1, 40.0)), PatternCopies("box", grid(2, 1, 30.0))]
    with pytest.raises(InvalidValue, match="name a piece, A to B, or a pattern, board, box"):
        fabricate_together(wanted, "all", requested(priority=["bax"]))


def test_every_finding_is_told_once():
    made = fabricate_together([PatternCopies("m", strips(0.05, 2, 3))], "m", requested())
    assert len(set(made.findings)) == len(made.findings) > 1


def test_guides_weigh_pieces_without_their_holes():
    """A ring of eight squares of 30 mm, whose outline and hole are half a kerf off."""
    wanted, request = [PatternCopies("ring", grid(3, 3, 30.0, without=[(1, 1)]))], requested()
    made = sheet_drawings(wanted, "ring", request)
    guide = guide_of(wanted, "ring", request, made, made_by="quadfold fabricate")
    kerf = request.machine.beam.widest_mm
    area = (90 + kerf) ** 2 - (30 - kerf) ** 2
    mass = f"{request.material.grams_per_m2 * area / 1e6:.3g} g"
    assert dict(guide.blocks[0].rows)["Mass"] == mass
