"""From a FOLD file to sheets: pieces, beds, files, the report, and the command line."""

import json
from io import StringIO
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from click.testing import CliRunner
from helpers import made_template

from fab.cli import main
from fab.errors import InvalidJob, Severity
from fab.fabricate import SheetFormat, _perforation, fabricate, scaled
from fab.materials import load_machine, load_material, shipped
from fab.paths import Operation
from fab.pattern_file import read_pattern
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
