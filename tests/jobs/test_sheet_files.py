"""From a FOLD file to sheets: pieces, beds, files, the report, and the command line."""

import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from io import StringIO
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from click.testing import CliRunner
from flat_patterns import grid, pattern_of, triangles, turned_strip
from helpers import PATTERNS, TEMPLATES, template_fold
from hypothesis import given, settings
from hypothesis import strategies as st
from pypdf import PdfReader
from scipy.spatial import cKDTree

from fab import read_pattern
from fab.catalogue import known_of, shipped
from fab.cli.group import main
from fab.drawings.cut_paths import Operation
from fab.drawings.drawing_files import USUAL, SheetFormat
from fab.errors import InvalidJob, Severity
from fab.formats.fold.writer import fold_bytes
from fab.geometry.rings import ring_areas
from fab.jobs.file_names import SHEETS, left_over
from fab.jobs.job import load_job
from fab.jobs.job_files import Format, make
from fab.jobs.sheet_files import fabricate
from fab.pattern.crease_pattern import scaled
from fab.sheets.labels import number_text
from fab.sheets.materials import load_machine, load_material, perforation_for
from fab.sheets.perforation import cut_layers, cut_piece
from fab.sheets.pieces import split
from fab.sheets.registration import Registration
from fab.sheets.sheet_request import SheetRequest
from solver import InvalidValue

NAMES = sorted(path.stem for path in PATTERNS.glob("*.fold"))
MATERIALS = ["copy_paper_80gsm", "pet_film_0.19mm", "plywood_3mm"]
MACHINE = "co2_60w_600x400"


def requested(material="card_300gsm", machine=MACHINE, **choices):
    return SheetRequest(load_material(material), load_machine(machine), **choices)


def sheets_of(name, material, width_mm=400.0, **choices):
    pattern, findings = read_pattern(PATTERNS / f"{name}.fold")
    request = requested(material, **choices)
    return pattern, fabricate(scaled(pattern, width_mm=width_mm), name, request, findings=findings)


def with_pieces(pattern, name, machine, material="card_300gsm", **choices):
    """What is made, and the pieces that it is made of."""
    kept = []

    def kept_split(*arguments, **choices):
        kept.append(split(*arguments, **choices))
        return kept[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fab.sheets.cut_pieces.split", kept_split)
        made = fabricate(pattern, name, SheetRequest(load_material(material), machine, **choices))
    return kept[0][0], made


def drawn(data):
    """Lines of a DXF file by layer, as shapely geometry."""
    document = ezdxf.read(StringIO(data.decode()))
    assert not document.audit().errors
    assert document.header["$INSUNITS"] == 4
    lines = {}
    for entity in document.modelspace():
        if entity.dxftype() == "LINE":
            ends = [entity.dxf.start, entity.dxf.end]
            shape = shapely.LineString([(p.x, p.y) for p in ends])
        else:
            points = [(x, y) for x, y, *_ in entity.get_points()]
            shape = shapely.LineString([*points, *points[: entity.closed]])
        lines.setdefault(entity.dxf.layer, []).append(shape)
    return lines


@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("name", NAMES)
def test_patterns_of_others_come_out_on_the_bed_and_nothing_is_cut_twice(name, material):
    pattern, made = sheets_of(name, material, formats=[SheetFormat.DXF])
    # short creases have no room for a living hinge of plywood, nor has the middle of a crane
    rigid = {
        "crane": ["lattices-meet"],
        "resch": ["lattice-rigid"],
        "yoshimura": ["lattice-rigid"],
    }
    wanted = rigid.get(name, []) if material == "plywood_3mm" else []
    assert [f.code for f in made.findings if f.severity == Severity.ERROR] == wanted
    assert sum(piece["faces"] for piece in made.report["pieces"]) == pattern.face_count
    machine = load_machine(MACHINE)
    bed = shapely.box(0, 0, *machine.bed_mm).buffer(-machine.margin_mm + 1e-5)
    for sheet in made.report["sheets"]:
        lines = drawn(made.files[sheet["files"][0]])
        assert set(lines) <= set(Operation)
        everything = [line for layer in lines.values() for line in layer]
        assert all(bed.covers(line) for line in everything)
        through = [line for layer, own in lines.items() if layer != "ENGRAVE" for line in own]
        total = sum(line.length for line in through)
        assert shapely.union_all(through, grid_size=1e-5).length == pytest.approx(total, abs=0.02)
        perforated = sum(line.length for key in ("MOUNTAIN", "VALLEY") for line in lines[key])
        assert sheet["perforate_mm"] == pytest.approx(perforated, abs=0.01)
        assert sheet["pierces"] == len(through)


@st.composite
def random_patterns(draw):
    """Triangles anywhere, or squares with holes and cuts; some larger than the bed."""
    if draw(st.booleans()):
        return scaled(triangles(draw(st.integers(0, 10**6))), width_mm=draw(st.floats(100, 300)))
    places = st.tuples(st.integers(0, 5), st.integers(0, 4))
    cuts = [(i, i + 1) for i in draw(st.sets(st.integers(7, 33), max_size=4)) if (i + 1) % 7]
    return grid(6, 5, draw(st.floats(25, 60)), draw(st.sets(places, max_size=12)), cuts)


@given(
    random_patterns(),
    st.sampled_from(["copy_paper_80gsm", "plywood_3mm", "card_300gsm"]),
    st.integers(1, 2),
)
@settings(max_examples=12)
def test_sheets_of_any_pattern_hold_its_faces_and_tabs_once(pattern, material, copies):
    """All pieces inside the bed and apart, of the right area; nothing is cut twice."""
    machine = load_machine("co2_40w_300x200")
    pieces, made = with_pieces(
        pattern, "any", machine, material, copies=copies, formats=[SheetFormat.DXF]
    )
    every = np.concatenate([piece.faces[piece.faces >= 0] for piece in pieces.pieces])
    assert sorted(every.tolist()) == list(range(pattern.face_count))
    bed = shapely.box(0, 0, *machine.bed_mm).buffer(-machine.margin_mm + 1e-5)
    kept = 0.0
    for sheet in made.report["sheets"]:
        lines = drawn(made.files[sheet["files"][0]])
        assert all(bed.covers(line) for layer in lines.values() for line in layer)
        through = [line for layer, own in lines.items() if layer != "ENGRAVE" for line in own]
        total = sum(line.length for line in through)
        assert shapely.union_all(through, grid_size=1e-5).length == pytest.approx(total, abs=0.02)
        rings = [line for line in (*lines["CUT"], *lines.get("HOLE", [])) if line.is_ring]
        outlines = shapely.get_parts(shapely.build_area(shapely.union_all(rings)))
        assert len(outlines) == len(sheet["pieces"])
        first, second = shapely.STRtree(outlines).query(outlines, "dwithin", distance=1.9)
        assert (first == second).all()
        cores = shapely.buffer(outlines, -machine.kerf_mm / 2, join_style="mitre", mitre_limit=9)
        kept += float(shapely.area(cores).sum())
    whole = sum(
        ring_areas(p.vertices_coords[p.faces_vertices], p.faces_offsets).sum()
        for p in (piece.pattern for piece in pieces.pieces)
    )
    assert kept == pytest.approx(copies * whole, rel=1e-3)


def test_every_material_suits_every_machine():
    for machine in known_of("cutter"):
        for material in known_of("sheet"):
            style = perforation_for(load_machine(machine), load_material(material))
            whole = load_machine(machine).profile == "whole_lines"
            assert (style.mountain.kind == style.valley.kind == "score") or not whole


def test_copies_lie_on_as_many_sheets_as_they_need_and_apart():
    _, single = sheets_of("square_twist", "card_300gsm", 180.0, formats=[SheetFormat.DXF])
    _, several = sheets_of(
        "square_twist", "card_300gsm", 180.0, copies=4, formats=[SheetFormat.DXF]
    )
    assert [sheet["pieces"] for sheet in single.report["sheets"]] == [["A"]]
    assert sum(len(sheet["pieces"]) for sheet in several.report["sheets"]) == 4
    alone = drawn(single.files["square_twist_1.dxf"])["CUT"]
    (frame,) = (line for line in alone if line.is_ring)
    area = shapely.Polygon(frame).area
    for sheet in several.report["sheets"]:
        rings = [line for line in drawn(several.files[sheet["files"][0]])["CUT"] if line.is_ring]
        pieces = [shapely.Polygon(ring) for ring in rings]
        assert shapely.union_all(pieces).area == pytest.approx(len(pieces) * area)
        assert all(a.distance(b) >= 2.0 for a in pieces for b in pieces if a is not b)


def test_a_ring_is_cut_into_pieces_with_a_glue_up_list(tmp_path):
    (tmp_path / "cones.fold").write_bytes(template_fold("nested_cones"))
    pattern, _ = read_pattern(tmp_path / "cones.fold")
    made = fabricate(pattern, "cones", requested(formats=[SheetFormat.SVG]))
    assert made.within_tolerance, made.findings
    names = [piece["name"] for piece in made.report["pieces"]]
    assert len(names) > 1
    assert sum(piece["faces"] for piece in made.report["pieces"]) == 1800
    rows = made.report["glue_up"]
    assert [row["label"] for row in rows] == list(range(1, len(rows) + 1))
    assert {name for row in rows for name in row["pieces"]} == set(names)
    # the rings were cut open to lie flat: their seam closes by glue too
    assert pattern.folded_coords is not None
    whole = fabricate(pattern, "cones", requested(machine="co2_100w_1300x900"))
    assert [piece["name"] for piece in whole.report["pieces"]] == ["A"]
    assert len(whole.report["glue_up"]) == 18
    assert all(row["pieces"] == ["A", "A"] for row in whole.report["glue_up"])


def outlines_on(made):
    """Areas within the outer outlines on each sheet, drawn without a kerf."""
    for sheet in made.report["sheets"]:
        rings = [line for line in drawn(made.files[sheet["files"][0]])["CUT"] if line.is_ring]
        yield sheet, [shapely.Polygon(ring) for ring in rings]


@pytest.mark.parametrize(("turns", "rows"), [(1.4, 1), (2.3, 2), (3.1, 1)])
def test_a_sheet_that_turns_over_itself_goes_from_its_file_to_sheets(tmp_path, turns, rows):
    strip = turned_strip(int(14 * turns), turns, rows, seed=int(10 * turns))
    (tmp_path / "turned.fold").write_bytes(fold_bytes(strip, "turned"))
    pattern, findings = read_pattern(tmp_path / "turned.fold")
    request = requested(machine="knife_a3_roll", formats=[SheetFormat.DXF])
    made = fabricate(pattern, "turned", request, findings=findings)
    assert made.within_tolerance, made.findings
    assert {"sheet-overlaps", "sheet-split"} <= {f["code"] for f in made.report["findings"]}
    assert sum(piece["faces"] for piece in made.report["pieces"]) == pattern.face_count
    names = [piece["name"] for piece in made.report["pieces"]]
    assert {name for row in made.report["glue_up"] for name in row["pieces"]} == set(names)
    assert len(made.report["glue_up"]) >= len(names) - 1
    assert load_machine("knife_a3_roll").kerf_mm == 0
    total = 0.0
    filled = []
    for sheet, polygons in outlines_on(made):
        assert len(polygons) == len(sheet["pieces"])
        assert shapely.is_valid(polygons).all()
        filled.append(shapely.union_all(polygons))
        total += filled[-1].area
    # a seam's edge is the foot of its tab, or an edge of the sheet
    for row in made.report["glue_up"]:
        for side, (name, number, at) in enumerate(
            zip(row["pieces"], row["sheets"], row["at_mm"], strict=True)
        ):
            assert name in made.report["sheets"][number - 1]["pieces"]
            point, sheet = shapely.Point(at), filled[number - 1]
            assert sheet.distance(point) < 1e-3
            assert (sheet.boundary.distance(point) < 1e-3) == (row["tab"] != side)
    # tabs come on top; no piece covers any of its own faces twice
    corners = np.split(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets[1:-1])
    assert total >= shapely.area([shapely.Polygon(ring) for ring in corners]).sum() * (1 - 1e-6)


def test_two_pieces_drawn_over_each_other_are_two_pieces(tmp_path):
    square = [[0, 0], [90, 0], [90, 90], [0, 90]]
    document = {
        "frame_unit": "mm",
        "vertices_coords": square + [[x + 20, y + 10] for x, y in square],
        "faces_vertices": [[0, 1, 2, 3], [4, 5, 6, 7]],
    }
    (tmp_path / "two.fold").write_text(json.dumps(document))
    pattern, _ = read_pattern(tmp_path / "two.fold")
    made = fabricate(pattern, "two", requested())
    assert [piece["faces"] for piece in made.report["pieces"]] == [1, 1]
    assert made.report["glue_up"] == []
    (sheet,) = made.report["sheets"]
    assert len(sheet["pieces"]) == 2


def test_a_ribbon_too_fine_for_the_beam_is_read_with_a_cure_in_its_findings(tmp_path):
    job = load_job(TEMPLATES / "brownian_ribbon_1000.toml")
    (tmp_path / "ribbon.fold").write_bytes(make(job, [Format.FOLD]).files[f"{job.name}.fold"])
    pattern, findings = read_pattern(tmp_path / "ribbon.fold")
    assert findings == ()
    assert pattern.face_count == 1000
    with np.errstate(all="ignore"):
        made = fabricate(pattern, "ribbon", requested(formats=[SheetFormat.SVG]))
    assert not made.within_tolerance
    texts = {finding.code: finding.text for finding in made.findings}
    assert (
        "1000 of 1000 faces are not wider than the kerf (0.15 mm)"
        in texts["face-narrower-than-kerf"]
    )
    for code in ("face-narrower-than-kerf", "crease-too-short"):
        assert "times as large" in texts[code]


def test_creases_of_all_pieces_have_one_finding_with_the_factor_that_helps_all():
    """A ladder of rungs, of which three in different pieces are too short."""
    height = np.full(100, 20.0)
    height[[10, 50, 90]] = 0.9, 0.5, 0.7
    rungs = [[[15.0 * i, -h / 2], [15.0 * i, h / 2]] for i, h in enumerate(height)]
    faces = [[2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1] for i in range(len(rungs) - 1)]
    pattern = pattern_of(np.reshape(rungs, (-1, 2)), faces, "M")
    pieces, made = with_pieces(pattern, "ladder", load_machine(MACHINE), formats=[SheetFormat.SVG])
    (finding,) = [f for f in made.findings if f.code == "crease-too-short"]
    short = pattern.vertices_coords[pattern.edges_vertices[list(finding.creases)]]
    assert np.hypot(*np.diff(short, axis=1)[:, 0].T) == pytest.approx([0.9, 0.5, 0.7])
    homes = [[c in piece.edges for c in finding.creases].index(True) for piece in pieces.pieces]
    assert homes == [0, 1, 2]
    assert finding.text.startswith("3 of 98 mountain creases")
    factor = float(re.search(r"at least (\S+) times", finding.text)[1])
    assert factor == pytest.approx(1.01 / 0.5, rel=0.01)


@pytest.mark.parametrize("name", ["nested_cones", "elliptic_ring", "twisted_squares"])
def test_rings_close_with_the_same_number_on_both_sides(name, tmp_path):
    made = make(load_job(TEMPLATES / f"{name}.toml"), [Format.FOLD])
    (tmp_path / "ring.fold").write_bytes(made.files[f"{name}.fold"])
    pattern, _ = read_pattern(tmp_path / "ring.fold")
    pattern = scaled(pattern, factor=5.0)
    machine = load_machine(MACHINE)
    bed = tuple(np.ptp(pattern.vertices_coords, axis=0) + 100.0)
    pieces, made = with_pieces(
        pattern, "ring", machine.model_copy(update={"bed_mm": bed}), formats=[SheetFormat.SVG]
    )
    (piece,) = pieces.pieces
    # of the folded form: edges of a single face that coincide
    border = np.flatnonzero(pattern.edges_faces[:, 1] < 0)
    middle = pattern.folded_coords[pattern.edges_vertices[border]].mean(axis=1)
    meeting = border[cKDTree(middle).query(middle, k=2)[0][:, 1] < 1e-5]
    assert sorted(e for seam in pieces.seams for e in seam.edges) == meeting.tolist()
    assert len(meeting) > 0
    bare = {seam.edges[0] for seam in pieces.seams if seam.tab is None}
    named = [f.creases for f in made.findings if f.code == "tab-no-room"]
    assert bare == {edge for creases in named for edge in creases}
    assert len(bare) < len(pieces.seams)
    assert len(piece.unwritten) < len(pieces.seams)
    rows = made.report["glue_up"]
    assert [row["label"] for row in rows] == [seam.label for seam in pieces.seams]
    for row, seam in zip(rows, pieces.seams, strict=True):
        assert row["pieces"] == ["A", "A"]
        assert row["length_mm"] == pytest.approx(seam.length_mm, abs=1e-4)
        assert row["fold_angle_deg"] == pytest.approx(seam.fold_angle_deg, abs=1e-4)
        assert row["tab"] == seam.tab
        text = number_text(seam.label)
        written = [label for label in piece.labels if label.text == text]
        missing = piece.unwritten.count(text)
        for edge in seam.piece_edges:
            face = piece.pattern.edges_faces[edge, 0]
            i, j = piece.pattern.faces_offsets[face : face + 2]
            corners = piece.pattern.vertices_coords[piece.pattern.faces_vertices[i:j]]
            beside = [shapely.Polygon(corners).covers(shapely.Point(x.at)) for x in written]
            assert sum(beside) == 1 or (missing and not any(beside))


def test_threads_of_pieces_are_placed_or_refused(tmp_path):
    ribbon = template_fold("brownian_ribbon_400")
    (tmp_path / "ribbon.fold").write_bytes(ribbon)
    pattern, _ = read_pattern(tmp_path / "ribbon.fold")
    with np.errstate(all="ignore"):
        request = requested("copy_paper_80gsm", "co2_100w_1300x900", formats=[SheetFormat.SVG])
        made = fabricate(scaled(pattern, width_mm=15000.0), "ribbon", request)
    assert sum(piece["faces"] for piece in made.report["pieces"]) == 400
    assert len(made.report["glue_up"]) >= len(made.report["pieces"]) - 1


def test_the_bound_of_dashes_is_on_all_copies_of_all_pieces_together(monkeypatch):
    from fab.sheets import crease_cuts

    pattern = scaled(read_pattern(PATTERNS / "yoshimura.fold")[0], width_mm=500.0)
    machine = load_machine(MACHINE).model_copy(update={"bed_mm": (300.0, 300.0)})
    material = load_material("card_300gsm")
    request = SheetRequest(material, machine, formats=[SheetFormat.DXF])
    pieces = split(pattern, request.split, machine.bed_mm)[0].pieces
    counts = [
        int(cut_piece(piece.pattern, request.perforation, machine.kerf_mm).creases.cuts.sum())
        for piece in pieces
    ]
    assert len(counts) > 1
    monkeypatch.setattr(crease_cuts, "_MOST_DASHES", sum(counts))
    fabricate(pattern, "sheet", request)
    monkeypatch.setattr(crease_cuts, "_MOST_DASHES", sum(counts) - 1)
    assert max(counts) < sum(counts) - 1
    with pytest.raises(InvalidValue, match=f"number of dashes = {sum(counts)} .*fewer copies"):
        fabricate(pattern, "sheet", request)
    monkeypatch.setattr(crease_cuts, "_MOST_DASHES", 2 * sum(counts) - 1)
    with pytest.raises(InvalidValue, match=f"number of dashes = {2 * sum(counts)} "):
        fabricate(pattern, "sheet", replace(request, copies=2))


def test_the_same_pattern_gives_the_same_bytes():
    first, second = (sheets_of("resch", "plywood_3mm")[1] for _ in range(2))
    assert dict(first.files) == dict(second.files)
    sheets = {"resch_1.dxf", "resch_1.svg", "resch_1.pdf"}
    assert set(first.files) == {*sheets, "resch_sheets.html", "resch_sheets_report.json"}


def test_both_sides_hold_the_scores_of_the_pieces_and_nothing_twice():
    formats = [SheetFormat.DXF]
    _, single = sheets_of("yoshimura", "card_300gsm", 300.0, copies=3, formats=formats)
    _, made = sheets_of(
        "yoshimura",
        "card_300gsm",
        300.0,
        copies=3,
        registration=Registration(),
        formats=formats,
    )
    assert made.within_tolerance, made.findings
    machine = load_machine(MACHINE)
    scored = perforation_for(machine, load_material("card_300gsm"), scored=True)
    assert scored.mountain.kind == scored.valley.kind == "score"
    sheets = made.report["sheets"]
    assert sum(len(sheet["pieces"]) for sheet in sheets) == 3
    assert len(sheets) >= len(single.report["sheets"])
    for number, sheet in enumerate(sheets):
        names = [f"yoshimura_{number + 1}_{side}.dxf" for side in ("front", "back")]
        assert sheet["files"] == names
        front, back = (drawn(made.files[name]) for name in names)
        assert set(front) == {"ENGRAVE", "MOUNTAIN", "RELIEF"}
        assert set(back) == {"ENGRAVE", "VALLEY", "CUT"}
        height = machine.bed_mm[1]
        over = [
            shapely.transform(line, lambda p, h=height: p * [1, -1] + [0, h])
            for own in back.values()
            for line in own
        ]
        both = [*over, *(line for own in front.values() for line in own)]
        bed = shapely.box(0, 0, *machine.bed_mm).buffer(-machine.margin_mm)
        assert all(bed.covers(line) for line in both)
        total = sum(line.length for line in both)
        assert shapely.union_all(both, grid_size=1e-5).length == pytest.approx(total, abs=0.02)
        pieces = shapely.union_all([shapely.Polygon(line) for line in over if line.is_ring])
        assert all(pieces.covers(line) for line in front["MOUNTAIN"])
        assert sheet["pierces"] == sum(side["pierces"] for side in sheet["sides"])
        minutes = sum(side["minutes"] for side in sheet["sides"])
        assert sheet["minutes"] == pytest.approx(minutes, abs=1e-3)
        assert [side["side"] for side in sheet["sides"]] == ["front", "back"]
        assert all(name.removesuffix(".dxf") in sheet["turn"] for name in names)
    # a single sheet of one copy, scored from one side, has the same creases
    pattern, _ = read_pattern(PATTERNS / "yoshimura.fold")
    wanted = 3 * sum(layer_length(scaled(pattern, width_mm=300.0), scored).values())
    assert sum(sheet["perforate_mm"] for sheet in sheets) == pytest.approx(wanted, abs=0.01)


def layer_length(pattern, style):
    layers, _ = cut_layers(pattern, style, load_machine(MACHINE).kerf_mm)
    return {
        layer.operation: np.hypot(*np.diff(layer.segments, axis=1)[:, 0].T).sum()
        for layer in layers
        if layer.operation in (Operation.MOUNTAIN, Operation.VALLEY)
    }


def test_a_bed_without_room_for_registration_is_refused():
    machine = load_machine(MACHINE).model_copy(update={"bed_mm": (45.0, 45.0)})
    pattern, _ = read_pattern(PATTERNS / "square_twist.fold")
    small = scaled(pattern, width_mm=5.0)
    request = SheetRequest(load_material("copy_paper_80gsm"), machine, registration=Registration())
    with pytest.raises(InvalidValue, match="at least 60 mm"):
        fabricate(small, "small", request)


_RIBBON = """
import hashlib, sys
from fab.drawings.drawing_files import SheetFormat
from fab import read_pattern
from fab.pattern.crease_pattern import scaled
from fab.sheets.materials import load_machine, load_material
from fab.jobs.sheet_files import fabricate
from fab.sheets.sheet_request import SheetRequest
request = SheetRequest(
    load_material("copy_paper_80gsm"), load_machine("co2_100w_1300x900"), formats=[SheetFormat.SVG]
)
made = fabricate(scaled(read_pattern(sys.argv[1])[0], width_mm=15000.0), "ribbon", request)
for name, data in sorted(made.files.items()):
    print(name, hashlib.sha256(data).hexdigest())
"""


def test_threads_of_pieces_are_placed_alike_in_every_process(tmp_path):
    """Where hulls replace needles, and whatever order sets and dicts of strings have."""
    made = make(load_job(TEMPLATES / "brownian_ribbon_400.toml"), [Format.FOLD])
    (tmp_path / "ribbon.fold").write_bytes(made.files["brownian_ribbon_400.fold"])
    printed = [
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", _RIBBON, str(tmp_path / "ribbon.fold")],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("1", "77")
    ]
    assert printed[0] == printed[1]
    assert len(printed[0].splitlines()) > 2


def test_a_request_gives_its_margins_and_speeds():
    machine, material = load_machine(MACHINE), load_material("plywood_3mm")
    plain, registered = (
        SheetRequest(material, machine, registration=registration)
        for registration in (None, Registration(hole_mm=4.0, clearance_mm=3.0))
    )
    assert plain.margin_mm == plain.split.margin_mm == machine.margin_mm
    assert registered.margin_mm == machine.margin_mm + 4.0 + 2 * 3.0
    assert plain.perforation == material.perforation
    assert registered.perforation.mountain.kind == "score"
    assert plain.speeds.cut_mm_s == machine.speeds.cut_mm_s * material.cut_speed_ratio
    assert plain.speeds.travel_mm_s == machine.speeds.travel_mm_s
    wide = SheetRequest(material, machine.model_copy(update={"kerf_mm": 1.0}))
    assert (plain.gap_mm, wide.gap_mm) == (2.0, 4.0)
    for copies in (0, -1, 1.5):
        with pytest.raises(InvalidValue, match="copies"):
            SheetRequest(material, machine, copies)


def test_sizes_are_asked_for_once():
    pattern, _ = read_pattern(PATTERNS / "resch.fold")
    wide = scaled(pattern, width_mm=250.0)
    assert np.ptp(wide.vertices_coords, axis=0).max() == pytest.approx(250.0)
    twice = scaled(pattern, factor=2.0)
    assert twice.vertices_coords == pytest.approx(2 * pattern.vertices_coords)
    assert scaled(pattern) is pattern
    with pytest.raises(InvalidJob, match="give one"):
        scaled(pattern, width_mm=10.0, factor=2.0)
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(InvalidValue, match="width_mm"):
            scaled(pattern, width_mm=wrong)


def test_a_face_larger_than_the_bed_is_refused():
    with pytest.raises(InvalidValue, match="face"):
        sheets_of("bird_base", "copy_paper_80gsm", 5000.0)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


CARD = ("--material", "card_300gsm", "--machine", "co2_40w_300x200")


def test_a_fold_file_becomes_sheets(folder):
    words = ("fabricate", PATTERNS / "yoshimura.fold", *CARD, "--width-mm", 150, "--out", "out")
    dry = run(*words, "--dry-run")
    assert dry.exit_code == 0, dry.output
    assert not (folder / "out").exists()
    result = run(*words, "--only", "svg,pdf")
    assert result.exit_code == 0, result.output
    names = sorted(path.name for path in (folder / "out").iterdir())
    assert names == ["yoshimura_1.pdf", "yoshimura_1.svg", "yoshimura_sheets_report.json"]
    report = json.loads((folder / "out" / "yoshimura_sheets_report.json").read_text())
    assert report["sheets"][0]["minutes"] > 0
    assert all(f["severity"] != Severity.ERROR for f in report["findings"])
    assert "1 piece, 0 seams, 1 sheet of 300 x 200 mm" in result.output


def test_both_sides_are_written_in_every_format(folder):
    words = ("fabricate", PATTERNS / "square_twist.fold", *CARD, "--width-mm", 120, "--two-sided")
    result = run(*words, "--out", "out")
    assert result.exit_code == 0, result.output
    kinds = [f"square_twist_1_{side}.{kind}" for side in ("back", "front") for kind in USUAL]
    written = sorted(path.name for path in (folder / "out").iterdir())
    assert written == sorted(
        [
            *kinds,
            "square_twist_assembly.pdf",
            "square_twist_sheets.html",
            "square_twist_sheets_report.json",
        ]
    )
    assert "Turn the sheet over so that its upper edge becomes the lower one" in result.output
    again = run(*words[:-1], "--out", "out", "--only", "dxf")
    first = "square_twist_1_back.dxf, square_twist_1_back.pdf, square_twist_1_back.svg"
    assert f"note: {first} and 5 more in out are from an earlier run" in again.output
    assert (folder / "out" / "square_twist_1_back.dxf").exists()


def test_sheets_of_an_earlier_run_are_named(folder):
    words = ("fabricate", PATTERNS / "yoshimura.fold", *CARD, "--width-mm", 150, "--only", "svg")
    assert "earlier run" not in run(*words, "--copies", 12).output
    others = ["yoshimura_1_2.svg", "yoshimura_2.png", "yoshimura.svg", "my_yoshimura_2.svg"]
    others += ["yoshimura_2.svg.old", "yoshimura_2_back.txt"]
    for name in others:
        (folder / name).touch()
    sheets = [path.name for path in folder.glob("yoshimura_?.svg")]
    assert len(sheets) > 1
    result = run(*words)
    assert "note: yoshimura_2.svg" in result.output
    left = left_over(["yoshimura_1.svg"], "yoshimura", [SHEETS], folder)
    assert [path.name for path in left] == sorted(
        {*sheets, "yoshimura_sheets_report.json"} - {"yoshimura_1.svg"}
    )
    assert left_over([], "yoshimura", [SHEETS], folder / "missing") == []


@pytest.mark.skipif(os.name != "posix", reason="file names of POSIX")
def test_file_names_of_any_bytes_become_names_that_can_be_read(folder):
    file = os.fsdecode(b'a\x1b[31m\n<b>&"\xff.fold')
    Path(file).write_bytes((PATTERNS / "square_twist.fold").read_bytes())
    result = run("fabricate", file, *CARD, "--width-mm", 120, "--out", "out")
    assert result.exit_code == 0, result.output
    names = sorted(path.name for path in (folder / "out").iterdir())
    plain = 'a_[31m_<b>&"_'
    drawings = [f"{plain}_1.{kind}" for kind in USUAL]
    others = ["assembly.pdf", "sheets.html", "sheets_report.json"]
    assert names == sorted([*(f"{plain}_{other}" for other in others), *drawings])
    plain += "_1"
    root = ElementTree.fromstring((folder / "out" / f"{plain}.svg").read_bytes())
    assert root[0].text == plain
    assert drawn((folder / "out" / f"{plain}.dxf").read_bytes())
    assert PdfReader(folder / "out" / f"{plain}.pdf").metadata.title == plain


@pytest.mark.skipif(os.name != "posix", reason="file names of POSIX")
def test_a_name_too_long_for_its_sheets_is_refused_with_its_cure(folder):
    file = 245 * "a" + ".fold"
    Path(file).write_bytes((PATTERNS / "square_twist.fold").read_bytes())
    words = ("fabricate", file, *CARD, "--width-mm", 120, "--out")
    result = run(*words, "out", "--only", "svg")  # the longest name is the report's
    assert result.exit_code == 2, result.output
    assert "File name too long" in result.output
    assert "Give the file that they are made from, or --out, a shorter name" in result.output
    assert [path.name for path in folder.iterdir()] == [file]
    result = run(*words, 300 * "b")
    assert result.exit_code == 2, result.output
    assert "or --out, a shorter name" in result.output


def test_sheets_are_beside_the_files_of_their_job(folder):
    Path("out").mkdir()
    Path("out/bird_base_report.json").write_text("of the job")
    Path("out/bird_base.fold").write_bytes((PATTERNS / "bird_base.fold").read_bytes())
    before = {path.name: path.read_bytes() for path in Path("out").iterdir()}
    words = ("fabricate", "out/bird_base.fold", *CARD, "--width-mm", 120, "--out", "out")
    assert run(*words).exit_code == 0
    after = {path.name: path.read_bytes() for path in Path("out").iterdir()}
    assert len(after) > len(before)
    assert before == {name: after[name] for name in before}


def test_the_name_of_a_test_card_is_whole(folder):
    words = ("--material", "polypropylene_0.5mm", "--machine", "co2_40w_300x200", "--only", "svg")
    assert run("coupon", *words).exit_code == 0
    assert [p.name for p in folder.iterdir()] == ["coupon_polypropylene_0.5mm_co2_40w_300x200.svg"]


def test_a_test_card_is_written(folder):
    result = run("coupon", *CARD, "--out", "card", "--only", "dxf")
    assert result.exit_code == 0, result.output
    lines = drawn((folder / "card" / "coupon_card_300gsm_co2_40w_300x200.dxf").read_bytes())
    assert {"ENGRAVE", "MOUNTAIN", "VALLEY", "CUT"} <= set(lines)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--material", "card", "--machine", "co2_40w_300x200"), "Did you mean card_300gsm"),
        (("--material", "card_300gsm", "--machine", "laser"), "machine 'laser' must be one of"),
        ((*CARD, "--scale", "-1"), "scale = -1"),
        ((*CARD, "--copies", "0"), "copies = 0"),
        ((*CARD, "--width-mm", "100", "--copies", "20000"), "copies = 20000"),
        ((*CARD, "--width-mm", "1e-9"), "its longer side must be from 0.1"),
        ((*CARD, "--only", "dwg"), "must be among dxf,svg,pdf"),
        ((*CARD, "--width-mm", "1e9"), "its longer side must be from 0.1"),
    ],
)
def test_bad_requests_write_nothing(folder, words, text):
    result = run("fabricate", PATTERNS / "bird_base.fold", *words, "--out", "out")
    assert result.exit_code == 2, result.output
    assert text in result.output
    assert not (folder / "out").exists()


def test_shipped_materials_and_machines_are_listed():
    for kind in ("materials", "machines"):
        result = run("shipped", kind)
        assert result.exit_code == 0, result.output
        assert [line.split()[0] for line in result.output.splitlines()] == list(shipped(kind))
