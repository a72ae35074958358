"""Small inputs that people sent, cut as sheets: each with its right value.

They are read in place from the folder `shared/cases` beside the repository; the kind of each fault
has tests of its own in this folder.
"""

import json
import xml.etree.ElementTree as ElementTree

import ezdxf
import numpy as np
import pytest
import shapely
from click.testing import CliRunner
from helpers import PATTERNS
from shared_cases import shared_case

from fab.catalogue import shipped
from fab.cli.group import main

KERF = 0.15


def fabricated(path, out, *words, machine="co2_60w_600x400"):
    """The lines of each sheet by layer, in the order of the work, the report and the output."""
    command = ["fabricate", str(path), "--material", "card_300gsm", "--machine", str(machine)]
    result = CliRunner().invoke(main, [*command, "--out", str(out), *words])
    assert result.exit_code == 0, result.output
    sheets = []
    for file in sorted(out.glob("*.dxf")):
        lines = {}
        for entity in ezdxf.readfile(file).modelspace():
            if entity.dxftype() == "LINE":
                shape = shapely.LineString([entity.dxf.start, entity.dxf.end])
            else:
                points = [point[:2] for point in entity.get_points()]
                shape = (shapely.LinearRing if entity.closed else shapely.LineString)(points)
            lines.setdefault(entity.dxf.layer, []).append(shapely.force_2d(shape))
        sheets.append(lines)
    report = json.loads((out / f"{path.stem}_sheets_report.json").read_text())
    return sheets, report, result.output


def open_lengths(shapes):
    return [line.length for line in shapes if line.geom_type == "LineString"]


def closed_lengths(shapes):
    return [line.length for line in shapes if line.geom_type == "LinearRing"]


@pytest.mark.parametrize(
    ("name", "slits", "around"),
    [
        ("slit2_C.fold", [20.0], 320.0),
        ("dangle_C.fold", [40.0], 320.0),
        ("slit_lost.fold", [60.0], 400.0),
        ("flap.fold", [120.0], 360.0),
    ],
)
def test_cuts_within_faces_are_cut(tmp_path, name, slits, around):
    (lines,), _, _ = fabricated(shared_case(name), tmp_path)
    assert open_lengths(lines["CUT"]) == pytest.approx(slits)
    assert closed_lengths(lines["CUT"]) == pytest.approx([around + 4 * KERF])


@pytest.mark.parametrize("ending", ["fold", "cp"])
def test_all_slits_of_a_popup_are_cut_whatever_the_format_calls_them(tmp_path, ending):
    source = PATTERNS / "popup.fold"
    if ending == "cp":
        converted = tmp_path / "popup.cp"
        assert CliRunner().invoke(main, ["convert", str(source), str(converted)]).exit_code == 0
        source = converted
    (lines,), _, output = fabricated(source, tmp_path / "out", "--width-mm", "160")
    assert sum(open_lengths(lines["CUT"])) == pytest.approx(460.0)
    assert closed_lengths(lines["CUT"]) == pytest.approx([560 + 4 * KERF])
    assert ("border-inside" in output) == (ending == "cp")


def test_a_slot_narrower_than_the_kerf_is_one_line(tmp_path):
    (lines,), _, output = fabricated(shared_case("comb.fold"), tmp_path)
    assert open_lengths(lines["CUT"]) == pytest.approx([40.0])
    assert closed_lengths(lines["CUT"]) == pytest.approx([320.6])
    assert "gap-narrower-than-kerf" in output
    assert "1 centre line of 40 mm" in output


def test_edges_that_touch_when_folded_flat_have_no_tab(tmp_path):
    (lines,), report, _ = fabricated(shared_case("cupboard_fold.fold"), tmp_path)
    assert report["glue_up"] == []
    assert closed_lengths(lines["CUT"]) == pytest.approx([2 * (120 + 80 + 2 * KERF)])


def test_a_box_has_its_tabs_with_and_without_a_folded_form(tmp_path):
    (net,), report, _ = fabricated(shared_case("boxnet.fold"), tmp_path / "a")
    (known,), other, _ = fabricated(shared_case("boxnet_folded.fold"), tmp_path / "b")
    assert len(report["glue_up"]) == len(other["glue_up"]) == 7
    assert net.keys() == known.keys()
    assert all(
        shapely.equals_exact(net[layer], known[layer], tolerance=1e-9).all() for layer in net
    )


def test_a_piece_lies_in_the_hole_of_another_and_is_cut_first(tmp_path):
    (lines,), _, _ = fabricated(
        shared_case("framepart.fold"), tmp_path, machine=shared_case("bed_115.toml")
    )
    rings = [shapely.Polygon(ring) for ring in lines["CUT"]]
    assert shapely.area(rings) == pytest.approx(
        [(40 + KERF) ** 2, (70 - KERF) ** 2, (100 + KERF) ** 2], rel=1e-9
    )
    assert rings[1].contains(rings[0])
    assert rings[2].contains(rings[1])
    assert rings[0].distance(rings[1].exterior) >= 2.0


def test_pages_are_the_bed(tmp_path):
    fabricated(shared_case("strip.fold"), tmp_path)
    root = ElementTree.parse(tmp_path / "strip_1.svg").getroot()
    assert (root.get("width"), root.get("height")) == ("600.000000mm", "400.000000mm")


@pytest.mark.parametrize(
    ("rotations", "turned"),
    [("", True), ("rotations_deg = [0.0, 180.0]", False), ("rotations_deg = [0.0]", False)],
)
def test_pieces_keep_the_grain_of_their_material(tmp_path, rotations, turned):
    card = shipped("materials")["card_300gsm"].read_text()
    (tmp_path / "card.toml").write_text(f"{rotations}\n{card}")
    words = ["--material", str(tmp_path / "card.toml")]
    (lines,), _, _ = fabricated(shared_case("strip.fold"), tmp_path / "out", *words)
    width, height = np.ptp(shapely.get_coordinates(lines["CUT"]), axis=0)
    assert (width < height) == turned


def test_lines_are_as_wide_as_the_machine_wants(tmp_path):
    bed = shared_case("bed_115.toml").read_text()
    (tmp_path / "bed.toml").write_text(f"stroke_mm = 0.025\n{bed}")
    fabricated(shared_case("framepart.fold"), tmp_path, machine=tmp_path / "bed.toml")
    root = ElementTree.parse(tmp_path / "framepart_1.svg").getroot()
    strokes = {group.get("stroke-width") for group in root.iter("{http://www.w3.org/2000/svg}g")}
    assert strokes == {"0.025"}


def test_a_sheet_without_a_unit_that_comes_out_tiny_is_a_warning(tmp_path):
    path = shared_case("unit_square.fold")
    _, report, output = fabricated(path, tmp_path / "a")
    assert "warning: sheet-small" in output
    assert "only 1 x 1 mm large. Give its longer side with --width-mm" in output
    assert "sheet-small" in [finding["code"] for finding in report["findings"]]
    for number, words in enumerate([("--width-mm", "100"), ("--scale", "30")]):
        _, _, output = fabricated(path, tmp_path / str(number), *words)
        assert "sheet-small" not in output


@pytest.mark.parametrize("with_faces", [True, False])
def test_a_border_between_two_faces_is_a_cut_on_request_with_faces_and_without(
    tmp_path, with_faces
):
    data = json.loads(shared_case("inner_border.fold").read_text())
    if not with_faces:
        del data["faces_vertices"]
    path = tmp_path / "inner.fold"
    path.write_text(json.dumps(data))
    words = ["fabricate", str(path), "--material", "card_300gsm", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(main, [*words, "--machine", "co2_60w_600x400"])
    assert result.exit_code == 2
    assert "--inner-border cut" in result.output
    (lines,), report, output = fabricated(path, tmp_path / "out", "--inner-border", "cut")
    assert len(report["pieces"]) == 2
    assert closed_lengths(lines["CUT"]) == pytest.approx([2 * (100 + 50 + 2 * KERF)] * 2)
    assert "border-inside" in output


@pytest.mark.parametrize(
    ("name", "mountain", "valley", "holes"),
    [
        ("hole_island.fold", 90.0, 0.0, 1),
        ("keyhole.fold", 80.0, 40 * np.sqrt(2), 0),
        ("closed_crease_loop.fold", 16 * 50 * np.sin(np.pi / 16), 0.0, 0),
        ("diagonal_with_folded_frame.fold", 0.0, 100 * np.sqrt(2), 0),
    ],
)
def test_islands_holes_and_diagonals_are_whole_sheets(tmp_path, name, mountain, valley, holes):
    """Their creases are dashed from end to end, and joins are not drawn."""
    words = ("--width-mm", "100") if name == "keyhole.fold" else ()
    (lines,), report, _ = fabricated(shared_case(name), tmp_path, *words)
    assert len(report["pieces"]) == 1
    assert len(lines["CUT"]) == 1
    assert len(lines.get("HOLE", [])) == holes
    for layer, length in (("MOUNTAIN", mountain), ("VALLEY", valley)):
        dashes = sum(line.length for line in lines.get(layer, []))
        assert 0.3 * length <= dashes <= length
        assert (dashes > 0) == (length > 0)
