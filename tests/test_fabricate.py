"""From a FOLD file to sheets: pieces, beds, files, the report, and the command line."""

import json
import os
import subprocess
import sys
from io import StringIO
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from click.testing import CliRunner
from flat_patterns import grid, triangles
from helpers import TEMPLATES, made_template
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from fab.cli import main
from fab.errors import InvalidJob, Severity
from fab.fabricate import SheetFormat, _perforation, fabricate, scaled
from fab.job import load_job
from fab.make import Format, make
from fab.materials import load_machine, load_material, shipped
from fab.paths import Operation
from fab.pattern_file import read_pattern
from fab.pieces import split
from fab.polygons import ring_areas
from solver import InvalidValue

PATTERNS = Path(__file__).parent / "patterns"
NAMES = sorted(path.stem for path in PATTERNS.glob("*.fold"))
MATERIALS = ["copy_paper_80gsm", "pet_film_0.19mm", "plywood_3mm"]
MACHINE = "co2_60w_600x400"


def sheets_of(name, material, width_mm=400.0, **choices):
    pattern, findings = read_pattern(PATTERNS / f"{name}.fold")
    return pattern, fabricate(
        scaled(pattern, width_mm=width_mm),
        name,
        load_material(material),
        load_machine(MACHINE),
        findings=findings,
        **choices,
    )


def with_pieces(pattern, name, machine, material="card_300gsm", **choices):
    """What is made, and the pieces that it is made of."""
    kept = []

    def kept_split(*given_):
        kept.append(split(*given_))
        return kept[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fab.fabricate.split", kept_split)
        made = fabricate(pattern, name, load_material(material), machine, **choices)
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
            shape = shapely.LineString([*points, points[0]])
        lines.setdefault(entity.dxf.layer, []).append(shape)
    return lines


@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("name", NAMES)
def test_patterns_of_others_come_out_on_the_bed_and_nothing_is_cut_twice(name, material):
    pattern, made = sheets_of(name, material, formats=[SheetFormat.DXF])
    assert made.within_tolerance, made.findings
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
        rings = [line for line in lines["CUT"] if line.is_ring]
        outlines = shapely.get_parts(shapely.build_area(shapely.union_all(rings)))
        assert len(outlines) == len(sheet["pieces"])
        one, two = shapely.STRtree(outlines).query(outlines, "dwithin", distance=1.9)
        assert (one == two).all()
        cores = shapely.buffer(outlines, -machine.kerf_mm / 2, join_style="mitre", mitre_limit=9)
        kept += float(shapely.area(cores).sum())
    whole = sum(
        ring_areas(p.vertices_coords[p.faces_vertices], p.faces_offsets).sum()
        for p in (piece.pattern for piece in pieces.pieces)
    )
    assert kept == pytest.approx(copies * whole, rel=1e-3)


def test_every_material_suits_every_machine():
    for machine in shipped("machines"):
        for material in shipped("materials"):
            style = _perforation(load_machine(machine), load_material(material))
            whole = load_machine(machine).profile == "whole_lines"
            assert (style.mountain.kind == style.valley.kind == "score") or not whole


def test_copies_lie_on_as_many_sheets_as_they_need_and_apart():
    _, one = sheets_of("square_twist", "card_300gsm", 180.0, formats=[SheetFormat.DXF])
    _, four = sheets_of("square_twist", "card_300gsm", 180.0, copies=4, formats=[SheetFormat.DXF])
    assert [sheet["pieces"] for sheet in one.report["sheets"]] == [["A"]]
    assert sum(len(sheet["pieces"]) for sheet in four.report["sheets"]) == 4
    alone = drawn(one.files["square_twist_1.dxf"])["CUT"]
    (frame,) = (line for line in alone if line.is_ring)
    area = shapely.Polygon(frame).area
    for sheet in four.report["sheets"]:
        rings = [line for line in drawn(four.files[sheet["files"][0]])["CUT"] if line.is_ring]
        pieces = [shapely.Polygon(ring) for ring in rings]
        assert shapely.union_all(pieces).area == pytest.approx(len(pieces) * area)
        assert all(a.distance(b) >= 2.0 for a in pieces for b in pieces if a is not b)


def test_a_ring_is_cut_into_pieces_with_a_glue_up_list(tmp_path):
    (tmp_path / "cones.fold").write_bytes(made_template("nested_cones").files["nested_cones.fold"])
    pattern, _ = read_pattern(tmp_path / "cones.fold")
    made = fabricate(
        pattern,
        "cones",
        load_material("card_300gsm"),
        load_machine(MACHINE),
        formats=[SheetFormat.SVG],
    )
    assert made.within_tolerance, made.findings
    names = [piece["name"] for piece in made.report["pieces"]]
    assert len(names) > 1
    assert sum(piece["faces"] for piece in made.report["pieces"]) == 1800
    rows = made.report["glue_up"]
    assert [row["label"] for row in rows] == list(range(1, len(rows) + 1))
    assert {name for row in rows for name in row["pieces"]} == set(names)
    # the rings were cut open to lie flat: their seam closes by glue too
    assert pattern.folded_coords is not None
    whole = fabricate(
        pattern, "cones", load_material("card_300gsm"), load_machine("co2_100w_1300x900")
    )
    assert [piece["name"] for piece in whole.report["pieces"]] == ["A"]
    assert len(whole.report["glue_up"]) == 18
    assert all(row["pieces"] == ["A", "A"] for row in whole.report["glue_up"])


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
    # of the folded form: edges of one face each that lie on each other
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
        written = [label for label in piece.labels if label.text == str(seam.label)]
        missing = piece.unwritten.count(str(seam.label))
        for edge in seam.piece_edges:
            face = piece.pattern.edges_faces[edge, 0]
            i, j = piece.pattern.faces_offsets[face : face + 2]
            corners = piece.pattern.vertices_coords[piece.pattern.faces_vertices[i:j]]
            beside = [shapely.Polygon(corners).covers(shapely.Point(x.at)) for x in written]
            assert sum(beside) == 1 or (missing and not any(beside))


def test_threads_of_pieces_are_placed_or_refused(tmp_path):
    ribbon = made_template("brownian_ribbon_400").files["brownian_ribbon_400.fold"]
    (tmp_path / "ribbon.fold").write_bytes(ribbon)
    pattern, _ = read_pattern(tmp_path / "ribbon.fold")
    with np.errstate(all="ignore"):
        made = fabricate(
            scaled(pattern, width_mm=15000.0),
            "ribbon",
            load_material("copy_paper_80gsm"),
            load_machine("co2_100w_1300x900"),
            formats=[SheetFormat.SVG],
        )
    assert sum(piece["faces"] for piece in made.report["pieces"]) == 400
    assert len(made.report["glue_up"]) >= len(made.report["pieces"]) - 1


def test_the_same_pattern_gives_the_same_bytes():
    first, second = (sheets_of("resch", "plywood_3mm")[1] for _ in range(2))
    assert dict(first.files) == dict(second.files)
    assert set(first.files) == {"resch_1.dxf", "resch_1.svg", "resch_1.pdf", "report.json"}


_RIBBON = """
import hashlib, sys
from fab.fabricate import SheetFormat, fabricate, scaled
from fab.materials import load_machine, load_material
from fab.pattern_file import read_pattern
made = fabricate(
    scaled(read_pattern(sys.argv[1])[0], width_mm=15000.0), "ribbon",
    load_material("copy_paper_80gsm"), load_machine("co2_100w_1300x900"),
    formats=[SheetFormat.SVG],
)
for name, data in sorted(made.files.items()):
    print(name, hashlib.sha256(data).hexdigest())
"""


def test_threads_of_pieces_are_placed_alike_in_every_process(tmp_path):
    """Where hulls stand for needles, and whatever order sets and dicts of strings have."""
    made = make(load_job(TEMPLATES / "brownian_ribbon_400.toml"), [Format.FOLD])
    (tmp_path / "ribbon.fold").write_bytes(made.files["brownian_ribbon_400.fold"])
    told = [
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", _RIBBON, str(tmp_path / "ribbon.fold")],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("1", "77")
    ]
    assert told[0] == told[1]
    assert len(told[0].splitlines()) > 2


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
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


CARD = ("--material", "card_300gsm", "--machine", "co2_40w_300x200")


def test_a_fold_file_becomes_sheets(here):
    words = ("fabricate", PATTERNS / "yoshimura.fold", *CARD, "--width-mm", 150, "--out", "out")
    dry = run(*words, "--dry-run")
    assert dry.exit_code == 0, dry.output
    assert not (here / "out").exists()
    result = run(*words, "--only", "svg,pdf")
    assert result.exit_code == 0, result.output
    names = sorted(path.name for path in (here / "out").iterdir())
    assert names == ["report.json", "yoshimura_1.pdf", "yoshimura_1.svg"]
    report = json.loads((here / "out" / "report.json").read_text())
    assert report["sheets"][0]["minutes"] > 0
    assert all(f["severity"] != Severity.ERROR for f in report["findings"])
    assert "1 pieces, 0 seams, 1 sheets of 300 x 200 mm" in result.output


def test_a_test_card_is_written(here):
    result = run("coupon", *CARD, "--out", "card", "--only", "dxf")
    assert result.exit_code == 0, result.output
    lines = drawn((here / "card" / "coupon_card_300gsm_co2_40w_300x200.dxf").read_bytes())
    assert {"ENGRAVE", "MOUNTAIN", "VALLEY", "CUT"} <= set(lines)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--material", "card", "--machine", "co2_40w_300x200"), "Did you mean card_300gsm"),
        (("--material", "card_300gsm", "--machine", "laser"), "machine 'laser' must be one of"),
        ((*CARD, "--scale", "-1"), "scale = -1"),
        ((*CARD, "--copies", "0"), "copies = 0"),
        ((*CARD, "--width-mm", "100", "--copies", "20000"), "copies = 20000"),
        ((*CARD, "--width-mm", "1e-9"), "narrower than the kerf"),
        ((*CARD, "--only", "dwg"), "must be among dxf,svg,pdf"),
        ((*CARD, "--width-mm", "1e9"), "face"),
    ],
)
def test_bad_requests_write_nothing(here, words, text):
    result = run("fabricate", PATTERNS / "bird_base.fold", *words, "--out", "out")
    assert result.exit_code == 2, result.output
    assert text in result.output
    assert not (here / "out").exists()


def test_shipped_materials_and_machines_are_listed():
    for kind in ("materials", "machines"):
        result = run("shipped", kind)
        assert result.exit_code == 0, result.output
        assert [line.split()[0] for line in result.output.splitlines()] == list(shipped(kind))
