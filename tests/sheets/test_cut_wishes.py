"""Wishes for cuts: what bridges, slots, mirrors, knives and titles do to files and report."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from io import BytesIO, StringIO

import ezdxf
import numpy as np
import pytest
import shapely
from click.testing import CliRunner
from flat_patterns import grid
from helpers import PATTERNS
from machine_readers import lengths_by_tool, read_grbl, read_lightburn, read_plotter
from pypdf import PdfReader
from shared_cases import shared_case

from fab import read_pattern
from fab.cli.group import main
from fab.drawings.drawing_files import SheetFormat
from fab.errors import InvalidJob, Severity
from fab.jobs.sheet_files import fabricate
from fab.pattern.crease_pattern import scaled
from fab.settings import checked
from fab.sheets.cut_wishes import CutWishes
from fab.sheets.materials import Knife, Machine, Powers, load_machine, load_material
from fab.sheets.registration import Registration
from fab.sheets.sheet_request import SheetRequest
from solver import InvalidState, InvalidValue

POWERS = Powers(cut_percent=80, perforate_percent=60, score_percent=15, engrave_percent=12.5)
EVERY = [SheetFormat(kind) for kind in ("dxf", "svg", "pdf", "lbrn2", "plt", "gcode")]
KERF = 0.15
TOOLS = {"ENGRAVE": "1", "MOUNTAIN": "2", "VALLEY": "3", "RELIEF": "4", "CUT": "5", "HOLE": "6"}


def request_of(formats=(SheetFormat.DXF,), of=None, registration=None, **wishes):
    machine = load_machine("co2_60w_600x400").model_copy(update={"powers": POWERS, **(of or {})})
    return SheetRequest(
        load_material("card_300gsm"),
        machine,
        registration=registration,
        formats=formats,
        page=False,
        wishes=CutWishes(**wishes),
        names=("card_300gsm", "co2_60w_600x400"),
    )


def made_of(pattern, **choices):
    return fabricate(pattern, "sheet", request_of(**choices))


def entities(data):
    """Lines of a DXF by layer, closed ones as rings."""
    out = {}
    for entity in ezdxf.read(StringIO(data.decode())).modelspace():
        if entity.dxftype() == "LINE":
            line = shapely.LineString([entity.dxf.start.vec2, entity.dxf.end.vec2])
        else:
            points = [point[:2] for point in entity.get_points()]
            line = (shapely.LinearRing if entity.closed else shapely.LineString)(points)
        out.setdefault(entity.dxf.layer, []).append(line)
    return out


def window():
    """Four squares by four with a hole of one, 160 mm wide."""
    return grid(4, 4, 40.0, without=[(1, 1)], cuts=[(17, 18), (18, 13)])


def popup():
    return scaled(read_pattern(PATTERNS / "popup.fold")[0], width_mm=160)


def svg_lengths(data):
    out = {}
    for group in ElementTree.fromstring(data).iter("{http://www.w3.org/2000/svg}g"):
        total = 0.0
        for path in group:
            for part in re.findall(r"M[^M]*", path.get("d")):
                points = np.array(re.findall(r"(-?[\d.]+),(-?[\d.]+)", part), float)
                line = shapely.LinearRing(points) if "Z" in part else shapely.LineString(points)
                total += line.length
        out[group.get("id")] = total
    return out


def pdf_lengths(data):
    content = PdfReader(BytesIO(data)).pages[0].get_contents().get_data().decode()
    out = {}
    for name, body in re.findall(r"/OC /(\w+) BDC\n[^\n]* RG\n(.*?)EMC", content, re.DOTALL):
        total, points = 0.0, []
        for word in re.findall(r"(-?[\d.]+) (-?[\d.]+) [ml]|([Ss])\n", body):
            if not word[2]:
                points.append((float(word[0]), float(word[1])))
                continue
            shape = shapely.LinearRing if word[2] == "s" else shapely.LineString
            total, points = total + shape(points).length, []
        out[name] = total
    return out


ALL = {"bridges": 3, "closed_slots": True, "mirror": True, "title": True}
DRAG = Knife(offset_mm=0.3, overcut_mm=1.0, lead_in_mm=3.0)


@pytest.mark.parametrize(
    ("pattern", "of", "wishes"),
    [
        (window, {"kerf_mm": (0.1, 0.2), "knife": DRAG}, ALL),
        (popup, {"knife": DRAG}, {"bridges": 2, "title": True}),
        (window, {}, {"closed_slots": True, "bridges": 4}),
        (window, {"margin_mm": 0.0}, {"closed_slots": True, "bridges": 4, "slot_mm": 2.0}),
    ],
)
def test_all_formats_and_the_report_have_the_same_lengths_whatever_is_wished(pattern, of, wishes):
    made = made_of(pattern(), formats=EVERY, of=of, **wishes)
    assert not [f for f in made.findings if f.severity == Severity.ERROR]
    (sheet,) = made.report["sheets"]
    dxf = entities(made.files["sheet_1.dxf"])
    lengths = {layer: sum(line.length for line in own) for layer, own in dxf.items()}
    found = {
        "svg": svg_lengths(made.files["sheet_1.svg"]),
        "pdf": pdf_lengths(made.files["sheet_1.pdf"]),
        "lbrn2": lengths_by_tool(read_lightburn(made.files["sheet_1.lbrn2"]).strokes),
        "gcode": lengths_by_tool(read_grbl(made.files["sheet_1.gcode"]).strokes),
    }
    for kind, by_layer in found.items():
        by_layer = {layer: length for layer, length in by_layer.items() if length}
        assert by_layer == pytest.approx(lengths, abs=1e-3), kind
    plot = lengths_by_tool(read_plotter(made.files["sheet_1.plt"]).strokes)
    by_tool = {TOOLS[layer]: length for layer, length in lengths.items()}
    assert plot == pytest.approx(by_tool, rel=5e-2)  # in units of 0.025 mm, slots of 0.2 mm
    through = {layer: own for layer, own in dxf.items() if layer != "ENGRAVE"}
    assert sheet["pierces"] == sum(map(len, through.values()))
    creases = sum(lengths.get(layer, 0.0) for layer in ("MOUNTAIN", "VALLEY"))
    assert sheet["perforate_mm"] == pytest.approx(creases, abs=1e-2)
    assert sheet["engrave_mm"] == pytest.approx(lengths.get("ENGRAVE", 0.0), abs=1e-2)
    cut = sum(lengths.get(layer, 0.0) for layer in ("RELIEF", "HOLE", "CUT"))
    assert sheet["cut_mm"] == pytest.approx(cut, abs=1e-2)
    run = read_grbl(made.files["sheet_1.gcode"])
    assert (run.moves >= 0).all()
    assert (run.moves <= [600, 400]).all()


def test_bridges_hold_every_piece_and_shorten_the_cut_by_their_gaps():
    plain, held = made_of(window()), made_of(window(), bridges=3, bridge_mm=0.5)
    assert held.report["sheets"][0]["bridges"] == 3
    before, after = (made.report["sheets"][0] for made in (plain, held))
    assert before["cut_mm"] - after["cut_mm"] == pytest.approx(3 * (0.5 + KERF), abs=1e-3)
    assert after["pierces"] == before["pierces"] + 2
    lines = entities(held.files["sheet_1.dxf"])
    assert len(lines["CUT"]) == 3 + 1  # and the slit around a corner
    beam = shapely.union_all(shapely.buffer([*lines["CUT"]], KERF / 2))
    assert len(shapely.get_parts(shapely.box(0, 0, 600, 400).difference(beam))) == 1
    assert len(lines["HOLE"]) == 1


@pytest.mark.parametrize("wishes", [{}, {"bridges": 3}, {"bridges": 3, "closed_slots": True}])
def test_no_wish_takes_material_from_the_pieces(wishes):
    """What the beam clears along all cuts leaves the pattern whole, lead-ins and all."""
    pattern = grid(3, 3, 40.0, without=[(1, 1)])
    knife = {"knife": Knife(lead_in_mm=3.0, overcut_mm=2.0)}
    made = made_of(pattern, of=knife, tabs="none", **wishes)
    lines = entities(made.files["sheet_1.dxf"])
    cleared = shapely.union_all(shapely.buffer([*lines["CUT"], *lines["HOLE"]], KERF / 2))
    low_x, low_y, _, _ = shapely.union_all(lines["HOLE"]).bounds
    x, y = low_x - KERF / 2, low_y - KERF / 2  # the hole, of which the lead-in is within
    whole = shapely.box(x - 40, y - 40, x + 80, y + 80).difference(
        shapely.box(x, y, x + 40, y + 40)
    )
    assert cleared.intersection(whole).area < 1e-3


def test_a_piece_in_a_hole_is_held_through_the_waste_around_it(tmp_path):
    command = ["fabricate", str(shared_case("framepart.fold")), "--material", "card_300gsm"]
    command += ["--machine", str(shared_case("bed_115.toml")), "--set", "cutter.bridges=2"]
    result = CliRunner().invoke(main, [*command, "--only", "dxf", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    lines = entities((tmp_path / "framepart_1.dxf").read_bytes())
    cleared = shapely.union_all(shapely.buffer(lines["CUT"], KERF / 2))
    assert len(lines["CUT"]) == 2 * 3
    assert len(shapely.get_parts(shapely.box(0, 0, 115, 115).difference(cleared))) == 1


def test_small_pieces_with_fewer_bridges_are_a_finding():
    (finding,) = made_of(grid(1, 1, 3.5), bridges=6).findings
    assert finding.code == "bridges-fewer"
    assert "1 outline has room for fewer than 6 bridges away from corners, for 4" in finding.text


def test_closed_slots_leave_no_open_cut():
    made = made_of(popup(), closed_slots=True, bridges=2)
    lines = entities(made.files["sheet_1.dxf"])
    assert {"MOUNTAIN", "VALLEY", "HOLE", "CUT"} <= set(lines)
    assert all(line.geom_type == "LinearRing" for own in lines.values() for line in own)
    # software that perforates by itself gets dashes, or they could not be closed
    whole = request_of(of={"profile": "whole_lines"}, closed_slots=True)
    assert len(entities(fabricate(window(), "a", whole).files["a_1.dxf"])["VALLEY"]) > 100


def test_wishes_that_contradict_each_other_are_refused_with_the_cure():
    with pytest.raises(InvalidValue, match=r"cutter.slot_mm.*kerf \(0\.15 mm\)"):
        request_of(closed_slots=True, slot_mm=0.1)
    with pytest.raises(InvalidValue, match=r"cutter.piece_gap_mm = 1\.0 .*at least 3\.6"):
        replace(request_of(closed_slots=True, slot_mm=1.0, bridges=2), piece_gap_mm=1.0)
    for wish in ("mirror", "closed_slots"):
        with pytest.raises(InvalidState, match=f"two_sided.*{wish}"):
            request_of(registration=Registration(), **{wish: True})
    machine = {**load_machine("co2_60w_600x400").model_dump(), "kerf_mm": [0.0, 0.1]}
    with pytest.raises(InvalidJob, match=r"kerf_mm.*both widths"):
        checked(Machine, machine, "m.toml", "")


def test_mirrored_sheets_are_the_mirror_image_but_for_their_letters():
    plain = made_of(scaled(read_pattern(PATTERNS / "box.fold")[0], width_mm=150))
    mirrored = made_of(scaled(read_pattern(PATTERNS / "box.fold")[0], width_mm=150), mirror=True)
    assert "mirrored" in {f.code for f in mirrored.findings}
    first, second = (entities(made.files["sheet_1.dxf"]) for made in (plain, mirrored))
    assert set(first) == set(second)
    for layer in first:
        turned = shapely.union_all(
            [shapely.transform(line, lambda p: p * [-1, 1] + [600, 0]) for line in second[layer]]
        )
        same = shapely.hausdorff_distance(shapely.union_all(first[layer]), turned) < 1e-5
        assert same == (layer != "ENGRAVE")


def test_the_title_is_beside_the_pieces_and_a_sheet_without_room_says_so():
    made = made_of(window(), title=True)
    plain = made_of(window())
    new, old = (entities(m.files["sheet_1.dxf"]) for m in (made, plain))
    assert "ENGRAVE" not in old
    title = shapely.union_all(new["ENGRAVE"])
    piece = shapely.Polygon(max(new["CUT"], key=lambda line: line.length))
    assert title.distance(piece) >= 2.0 - 1e-6
    assert shapely.box(5, 5, 595, 395).covers(title)
    bar = max(new["ENGRAVE"], key=lambda line: line.bounds[2] - line.bounds[0])
    assert bar.bounds[2] - bar.bounds[0] == pytest.approx(100.0)
    full = made_of(grid(1, 1, 386.0), title=True, of={"bed_mm": (400.0, 400.0)})
    (finding,) = full.findings
    assert finding.code == "title-no-room"
    assert set(entities(full.files["sheet_1.dxf"])) == {"CUT"}


def test_kerfs_of_both_axes_are_those_of_the_bed_however_a_piece_is_turned():
    """A strip that fits the bed only upright: what is left of it has its size."""
    for bed in ((400.0, 130.0), (130.0, 400.0)):
        made = made_of(grid(3, 1, 100.0), of={"bed_mm": bed, "kerf_mm": (0.1, 0.4)})
        (ring,) = entities(made.files["sheet_1.dxf"])["CUT"]
        x, y = np.ptp(shapely.get_coordinates(ring), axis=0) - [0.1, 0.4]
        assert sorted([x, y]) == pytest.approx([100.0, 300.0])


def test_machines_have_no_knife_keys_of_their_own_and_keep_their_files():
    for name in ("knife_a4", "knife_a3_roll"):
        assert load_machine(name).knife == Knife()


def test_the_command_line_takes_every_wish(tmp_path):
    command = ["fabricate", str(PATTERNS / "miura.fold"), "--width-mm", "160", "--only", "dxf"]
    command += ["--material", "card_300gsm", "--machine", "co2_60w_600x400"]
    for wish in ("bridges=3", "bridge_mm=0.6", "title=true", "mirror=true", "closed_slots=true"):
        command += ["--set", f"cutter.{wish}"]
    result = CliRunner().invoke(main, [*command, "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    lines = entities((tmp_path / "miura_1.dxf").read_bytes())
    assert {"ENGRAVE", "CUT"} <= set(lines)
