"""DXF drawings: curves within their tolerance, blocks, layers, units, and what is refused."""

import io
import math

import ezdxf
import numpy as np
import pytest
from ezdxf.disassemble import recursive_decompose
from ezdxf.path import make_path
from ezdxf.units import METER_FACTOR
from helpers import PATTERNS

from fab import read_pattern
from fab.drawings.drawing_files import SheetFormat
from fab.drawings.dxf import DxfVersion
from fab.errors import InvalidFile, Severity
from fab.formats.dxf.reader import read_dxf
from fab.formats.read_options import ReadOptions
from fab.formats.strictness import is_repair
from fab.jobs.sheet_files import fabricate
from fab.sheets.materials import load_machine, load_material
from fab.sheets.sheet_request import SheetRequest


@pytest.fixture
def drawing():
    document = ezdxf.new("R2010")
    document.units = ezdxf.enums.InsertUnits.Millimeters
    return document


def read(document, tmp_path, options=None):
    path = tmp_path / "drawing.dxf"
    if isinstance(document, str | bytes):
        path.write_bytes(document.encode() if isinstance(document, str) else document)
    else:
        document.saveas(path)
    return read_dxf(path, options or ReadOptions())


def found(soup, code):
    return next(finding for finding in soup.findings if finding.code == code)


def codes(soup):
    return [finding.code for finding in soup.findings]


def length(lines):
    return float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum())


def test_arcs_and_circles_are_within_the_tolerance_that_is_reported(drawing, tmp_path):
    space = drawing.modelspace()
    space.add_circle((10, 20), 50)
    space.add_arc((10, 20), 30, 350, 80)
    space.add_lwpolyline([(200, 0, 1), (240, 0, -0.5), (240, 60, 0)], format="xyb", close=True)
    space.add_polyline2d([(300, 0, 1), (340, 0, 0)], format="xyb")
    soup = read(drawing, tmp_path)
    parts = [soup.lines_coords[soup.lines_element == i] for i in range(4)]
    for part, radius, turn in [(parts[0], 50, math.tau), (parts[1], 30, math.pi / 2)]:
        ends = np.linalg.norm(part - [10, 20], axis=2)
        middles = np.linalg.norm(part.mean(axis=1) - [10, 20], axis=1)
        np.testing.assert_allclose(ends, radius, rtol=1e-12)
        assert (radius - middles).max() <= 0.01
        # an eighth more lines than needed would be a waste, an eighth fewer too rough
        assert len(part) == pytest.approx(turn / (2 * math.acos(1 - 0.01 / radius)), rel=1 / 8)
        assert length(part) == pytest.approx(radius * turn, rel=1e-3)
    assert parts[0][-1, 1].tolist() == parts[0][0, 0].tolist()
    # a half circle below its chord, an arc of 4 atan 1/2 that turns right, and two straight sides
    third = 4 * math.atan(0.5) * (60 * 1.25 / 2)
    sides = length(parts[2])
    assert sides == pytest.approx(20 * math.pi + third + math.hypot(40, 60), rel=1e-3)
    assert parts[2][..., 1].min() == pytest.approx(-20, abs=0.01)
    assert parts[2][..., 0].min() == pytest.approx(200)
    middle = parts[2].reshape(-1, 2)
    assert np.hypot(*(middle - [240 - 60 / 4, 30]).T).min() < 2
    assert parts[3][..., 1].min() == pytest.approx(-20, abs=0.01)
    assert found(soup, "curves-flattened").text == "4 curves are flattened within 0.01 mm."


@pytest.mark.parametrize("unit", [1, 4, 6])
def test_the_tolerance_is_in_millimetres_whatever_the_unit(unit, drawing, tmp_path):
    drawing.units = unit
    mm = {1: 25.4, 4: 1.0, 6: 1000.0}[unit]
    drawing.modelspace().add_circle((0, 0), 100 / mm)
    soup = read(drawing, tmp_path)
    assert soup.mm_per_unit == mm
    assert len(soup.lines_coords) == math.ceil(math.pi / math.acos(1 - 0.01 / 100))


def test_splines_and_ellipses_are_the_curves_themselves(drawing, tmp_path):
    space = drawing.modelspace()
    space.add_ellipse((0, 0), (40, 0), 0.5, 0, math.pi / 2)
    # three control points of a quarter circle, exact as a rational spline
    weight = math.sqrt(0.5)
    quarter = space.add_rational_spline([(100, 0), (100, 100), (0, 100)], [1, weight, 1], degree=2)
    assert quarter.construction_tool().order == 3
    space.add_spline([(0, 0), (50, 0), (100, 0)])
    soup = read(drawing, tmp_path)
    first, second, third = (soup.lines_coords[soup.lines_element == i] for i in range(3))
    np.testing.assert_allclose((first / [40, 20] ** np.array(1.0)) ** 2 @ [1, 1], 1, rtol=1e-12)
    assert first[0, 0].tolist() == pytest.approx([40, 0])
    assert first[-1, 1].tolist() == pytest.approx([0, 20])
    np.testing.assert_allclose(np.linalg.norm(second, axis=2), 100, rtol=1e-12)
    assert (100 - np.linalg.norm(second.mean(axis=1), axis=1)).max() <= 0.01
    np.testing.assert_allclose(third, [[[0, 0], [100, 0]]], atol=1e-9)
    assert "2 curves" in found(soup, "curves-flattened").text


def test_blocks_are_followed_through_every_transformation(drawing, tmp_path):
    """Against ezdxf's own explosion of the same blocks, which cannot shear."""
    inner = drawing.blocks.new("INNER", base_point=(1, 2))
    inner.add_line((0, 0), (10, 3))
    inner.add_circle((5, 5), 4)
    inner.add_lwpolyline([(0, 0, 0.4), (6, 1, 0), (6, 4, -1)], format="xyb", close=True)
    outer = drawing.blocks.new("OUTER", base_point=(-3, 1))
    outer.add_blockref("INNER", (7, 1), {"xscale": -2, "yscale": 2, "rotation": 30})
    outer.add_line((0, 0), (0, 5))
    space = drawing.modelspace()
    upside_down = {"extrusion": (0, 0, -1), "rotation": 70}
    space.add_blockref("OUTER", (40, 50), {"xscale": 3, "yscale": -3, "rotation": 15})
    space.add_blockref("OUTER", (40, 50), upside_down)
    space.add_blockref(
        "OUTER",
        (0, 0),
        {"column_count": 3, "row_count": 2, "column_spacing": 60, "row_spacing": 40, "rotation": 5},
    )
    soup = read(drawing, tmp_path)
    assert len(soup.elements) == (1 + 1 + 6) * 4
    boxes = []
    for entity in recursive_decompose(space):
        points = np.array([(p.x, p.y) for p in make_path(entity).flattening(1e-4)])
        boxes.append([points.min(axis=0), points.max(axis=0)])
    own = []
    for i in range(len(soup.elements)):
        points = soup.lines_coords[soup.lines_element == i].reshape(-1, 2)
        own.append([points.min(axis=0), points.max(axis=0)])
    boxes, own = np.reshape(boxes, (-1, 4)), np.reshape(own, (-1, 4))
    for box in boxes:  # in any order; circles of ezdxf are off by 3e-4 of their radius
        assert np.abs(own - box).max(axis=1).min() < 0.03


def test_a_turned_block_in_a_stretched_one_is_sheared(drawing, tmp_path):
    drawing.blocks.new("INNER", base_point=(1, 2)).add_circle((1, 2), 5)
    drawing.blocks.new("OUTER", base_point=(-3, 1)).add_blockref("INNER", (7, 1), {"rotation": 30})
    drawing.blocks.get("INNER").add_line((1, 2), (11, 2))
    drawing.modelspace().add_blockref("OUTER", (40, 50), {"xscale": 3, "yscale": -1})
    soup = read(drawing, tmp_path)
    line = soup.lines_coords[soup.lines_element == 1][0]
    start = np.array([40 + 3 * 10, 50])
    end = start + 10 * np.array([3 * math.cos(math.pi / 6), -math.sin(math.pi / 6)])
    np.testing.assert_allclose(line, [start, end])
    circle = (soup.lines_coords[soup.lines_element == 0] - start) / [15, 5]
    np.testing.assert_allclose((circle**2).sum(axis=2), 1)
    middles = circle.mean(axis=1) * [15, 5]
    assert len(middles) > 50
    assert (1 - np.hypot(*(middles / [15, 5]).T)).max() < 0.01 / 5


def test_layer_zero_and_byblock_are_those_of_the_insert(drawing, tmp_path):
    drawing.layers.add("Berge", color=3)
    drawing.layers.add("green things", color=3)
    block = drawing.blocks.new("B")
    block.add_line((0, 0), (1, 0))  # layer 0, colour by layer
    block.add_line((0, 0), (1, 1), {"color": 0})
    block.add_line((0, 0), (0, 1), {"layer": "green things"})
    block.add_line((0, 0), (2, 1), {"true_color": 0xFF00FF})
    space = drawing.modelspace()
    space.add_blockref("B", (0, 0), {"color": 5})
    space.add_blockref("B", (5, 0), {"layer": "green things", "color": 1})
    soup = read(drawing, tmp_path)
    assert "".join(soup.lines_assignment) == "BVCU" + "CMCU"
    options = ReadOptions(colours={"green things": "M", "#ff00ff": "F"})
    assert "".join(read(drawing, tmp_path, options).lines_assignment) == "BVMF" + "MMMM"


def test_colours_of_a_drawing(drawing, tmp_path):
    colours = [1, 5, 7, 3, 2, 6, 250, 8, 255]
    for number, colour in enumerate(colours):
        drawing.modelspace().add_line((number, 0), (number, 1), {"color": colour})
    drawing.modelspace().add_line((50, 0), (50, 1), {"true_color": 0xFFFFFF})
    soup = read(drawing, tmp_path)
    assert "".join(soup.lines_assignment) == "MVBCFUB?BB"
    assert codes(soup) == ["colour-unknown"]
    assert found(soup, "colour-unknown").text.startswith("1 line has neither")


def test_the_cutlines_of_others_are_cuts(drawing, tmp_path):
    """Those of ORIPA are borders: see the dialects."""
    drawing.modelspace().add_line((0, 0), (1, 0), {"layer": "CutLine"})
    assert read(drawing, tmp_path).lines_assignment.tolist() == ["C"]


def test_what_is_left_out_is_counted(drawing, tmp_path):
    drawing.layers.add("off").off()
    drawing.layers.add("cold").freeze()
    space = drawing.modelspace()
    space.add_line((0, 0), (10, 0))
    space.add_line((0, 1), (10, 1), {"layer": "off"})
    space.add_line((0, 2), (10, 2), {"invisible": 1})
    drawing.blocks.new("B").add_line((0, 3), (10, 3))
    space.add_blockref("B", (0, 0), {"layer": "cold"})
    space.add_blockref("missing", (0, 0))
    drawing.add_xref_def("other.dxf", "elsewhere")
    space.add_blockref("elsewhere", (0, 0))
    space.add_blockref("elsewhere", (5, 0))
    space.add_polymesh((2, 2))
    space.add_polyface().append_face([(0, 0), (1, 0), (1, 1)])
    for _ in range(3):
        space.add_text("x")
    space.add_mline([(0, 0), (1, 1)])
    space.add_hatch()
    space.add_3dface([(0, 0), (1, 0), (1, 1)])
    space.add_circle((0, 0), 0)
    soup = read(drawing, tmp_path)
    left_out = ["entities-skipped", "layers-hidden", "blocks-absent", "entities-damaged"]
    assert codes(soup) == left_out
    skipped = found(soup, "entities-skipped")
    assert "3 TEXT, 2 MESH, 1 3DFACE, 1 HATCH, 1 MLINE. Explode them" in skipped.text
    assert skipped.severity == Severity.WARNING
    assert "1 on '0', 1 on 'cold', 1 on 'off'" in found(soup, "layers-hidden").text
    assert found(soup, "layers-hidden").severity == Severity.NOTE  # as in SVG files
    assert "2 of 'elsewhere', 1 of 'missing'" in found(soup, "blocks-absent").text
    assert "1 CIRCLE" in found(soup, "entities-damaged").text


def test_outlines_that_name_their_first_point_again_are_no_repair(drawing, tmp_path):
    """As many programs write closed polylines."""
    space = drawing.modelspace()
    space.add_lwpolyline([(0, 0), (9, 0), (9, 5), (0, 5), (0, 0)], close=True)
    space.add_line((3, 3), (3, 3))
    soup = read(drawing, tmp_path)
    assert codes(soup) == ["line-without-length"]
    assert found(soup, "line-without-length").text == "2 lines without length: left out."
    assert len(soup.lines_coords) == 4
    assert not is_repair(found(soup, "line-without-length"))
    for polyline in space.query("LWPOLYLINE"):
        space.delete_entity(polyline)
    with pytest.raises(InvalidFile, match=r"no lines.* 1 line without length"):
        read(drawing, tmp_path)


def test_what_is_never_plotted_is_left_out(drawing, tmp_path):
    space = drawing.modelspace()
    space.add_line((0, 0), (10, 0))
    for layer in ("Defpoints", "DEFPOINTS"):
        space.add_line((0, 1), (10, 1), {"layer": layer})
    drawing.blocks.new("B").add_line((0, 3), (10, 3), {"layer": "Mountain"})
    space.add_blockref("B", (0, 0), {"layer": "Defpoints"})
    soup = read(drawing, tmp_path)
    assert soup.lines_coords[:, 0, 1].tolist() == [0, 3]
    assert found(soup, "layer-unplotted").text.startswith("2 lines and curves on the layer")


def test_whole_ellipses_and_closed_splines_are_closed_curves_anywhere(drawing, tmp_path):
    space = drawing.modelspace()
    space.add_ellipse((50, 30), (8, 0), 0.5)
    corners = [(45, 20, 0), (55, 20, 0), (55, 30, 0), (45, 30, 0), (45, 20, 0)]
    space.add_spline(degree=1).set_open_uniform(corners, degree=1)
    soup = read(drawing, tmp_path)
    first, second = (soup.lines_coords[soup.lines_element == i] for i in range(2))
    np.testing.assert_allclose(((first - [50, 30]) / [8, 4]) ** 2 @ [1, 1], 1, rtol=1e-9)
    assert length(first) == pytest.approx(38.754, rel=1e-3)
    assert length(second) == pytest.approx(40)


def test_texts_alone_are_a_note(drawing, tmp_path):
    drawing.modelspace().add_line((0, 0), (10, 0))
    drawing.modelspace().add_mtext("x")
    assert found(read(drawing, tmp_path), "entities-skipped").severity == Severity.NOTE


@pytest.mark.parametrize("code", range(1, 21))
def test_units_are_those_of_ezdxf(code, drawing, tmp_path):
    drawing.header["$INSUNITS"] = code
    drawing.modelspace().add_line((0, 0), (1, 0))
    soup = read(drawing, tmp_path)
    known = {8: 25.4e-6, 9: 25.4e-3}
    wanted = known[code] if code in known else 1000 / METER_FACTOR[code]
    assert soup.mm_per_unit == pytest.approx(wanted, rel=2e-3 if code > 18 else 1e-8)
    assert codes(soup) == []


def test_a_file_without_a_header_names_no_unit(tmp_path):
    line = "0\nLINE\n8\nMountain\n10\n0\n20\n0\n11\n30\n21\n0\n"
    soup = read(f"0\nSECTION\n2\nENTITIES\n{line}0\nENDSEC\n0\nEOF\n", tmp_path)
    assert soup.mm_per_unit is None
    assert length(soup.lines_coords) == 30


def test_layers_outside_of_the_code_page_are_read(tmp_path):
    drawing = ezdxf.new("R2000")
    drawing.layers.add("山折", color=8)
    drawing.modelspace().add_line((0, 0), (1, 0), dxfattribs={"layer": "山折"})
    assert read(drawing, tmp_path).lines_assignment.tolist() == ["M"]


def test_units_of_surveyors_and_none(drawing, tmp_path):
    drawing.modelspace().add_line((0, 0), (1, 0))
    for code, mm in {21: 1200 / 3937 * 1e3, 22: 100 / 3937 * 1e3, 0: None, 25: None}.items():
        drawing.header["$INSUNITS"] = code
        soup = read(drawing, tmp_path)
        assert soup.mm_per_unit == (mm if mm is None else pytest.approx(mm, rel=1e-12))
        assert codes(soup) == []
    drawing.header["$MEASUREMENT"] = 0
    assert codes(read(drawing, tmp_path)) == ["unit-imperial"]


def test_heights_are_flattened_and_slants_reported(drawing, tmp_path):
    space = drawing.modelspace()
    space.add_line((0, 0), (100, 0))
    space.add_line((0, 0, 7), (0, 100, 7))
    assert found(read(drawing, tmp_path), "off-plane").severity == Severity.NOTE
    space.add_line((0, 0, 0), (30, 0, 40))
    soup = read(drawing, tmp_path)
    assert found(soup, "off-plane").severity == Severity.WARNING
    assert "1 of them is slanted" in found(soup, "off-plane").text
    assert length(soup.lines_coords[2:]) == pytest.approx(30)
    for entity in list(space)[1:2]:
        space.delete_entity(entity)
    with pytest.raises(InvalidFile, match="in an upright plane"):
        read(drawing, tmp_path)


def test_blocks_that_grow_without_end_are_refused_before_the_work(drawing, tmp_path):
    loop = drawing.blocks.new("LOOP")
    loop.add_line((0, 0), (1, 0))
    drawing.modelspace().add_blockref("LOOP", (0, 0))
    path = tmp_path / "drawing.dxf"
    loop.add_blockref("loop", (1, 1))
    drawing.saveas(path)
    with pytest.raises(InvalidFile, match="the block 'LOOP' contains itself"):
        read_dxf(path, ReadOptions())


def test_billions_of_lines_in_nested_blocks_are_refused(drawing, tmp_path):
    drawing.blocks.new("B0").add_line((0, 0), (1, 0))
    for i in range(1, 11):
        block = drawing.blocks.new(f"B{i}")
        for k in range(10):
            block.add_blockref(f"B{i - 1}", (k, 0))
    drawing.modelspace().add_blockref("B10", (0, 0))
    with pytest.raises(InvalidFile, match="lines are over the bound of 1000000"):
        read(drawing, tmp_path)
    chain = ezdxf.new()
    chain.blocks.new("B0").add_line((0, 0), (1, 0))
    for i in range(1, 60):
        chain.blocks.new(f"B{i}").add_blockref(f"B{i - 1}", (0, 0))
    chain.modelspace().add_blockref("B59", (0, 0))
    with pytest.raises(InvalidFile, match="is over 50 blocks deep"):
        read(chain, tmp_path)
    grid = ezdxf.new()
    grid.blocks.new("B").add_line((0, 0), (1, 0))
    many = {"row_count": 32000, "row_spacing": 1, "column_count": 32000, "column_spacing": 1}
    grid.modelspace().add_blockref("B", (0, 0), many)
    with pytest.raises(InvalidFile, match="lines are over the bound of 1000000"):
        read(grid, tmp_path)


@pytest.mark.parametrize(
    ("data", "wanted"),
    [
        (b"AC1032\0\0\0\0 and so on", "a DWG file under the name of a DXF file. Save it as DXF"),
        (b"AutoCAD Binary DXF\r\n\x1a\x00\x05\x06", "a binary DXF file that cannot be read"),
        (b"%PDF-1.4\n", "no section of a DXF file"),
        (b"PK\x03\x04\0\0", "neither a text file nor a binary DXF file"),
        (b"0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n", "it has no lines, arcs"),
        (b"0\nSECTION\n2\nENTITIES\nLINE\n", "cannot be read: 'Invalid group code"),
    ],
)
def test_what_is_no_drawing_is_refused_in_plain_words(data, wanted, tmp_path):
    with pytest.raises(InvalidFile, match=wanted):
        read(data, tmp_path)


def test_a_drawing_without_lines_is_refused_with_what_it_has(drawing, tmp_path):
    drawing.modelspace().add_text("x")
    with pytest.raises(InvalidFile, match=r"no lines.*left out, as they are no lines: 1 TEXT"):
        read(drawing, tmp_path)
    drawing.layers.add("off").off()
    drawing.modelspace().add_line((0, 0), (1, 1), {"layer": "off"})
    with pytest.raises(InvalidFile, match=r"on layers that are off or frozen: 1 on 'off'"):
        read(drawing, tmp_path)


def test_a_drawing_that_breaks_the_rules_is_recovered(drawing, tmp_path):
    drawing.modelspace().add_line((0, 1), (2, 3), {"color": 1})
    stream = io.StringIO()
    drawing.write(stream)
    text = stream.getvalue()
    line = " 10\n0.0\n 20\n1.0\n 30\n0.0\n 11\n2.0\n 21\n3.0\n 31\n0.0\n"
    assert line in text
    shuffled = " 10\n0.0\n 11\n2.0\n 20\n1.0\n 21\n3.0\n 30\n0.0\n 31\n0.0\n"
    soup = read(text.replace(line, shuffled), tmp_path)
    assert soup.lines_coords.tolist() == [[[0, 1], [2, 3]]]
    assert codes(soup) == ["file-recovered"]


def test_coordinates_that_are_too_large_or_not_finite(drawing, tmp_path):
    space = drawing.modelspace()
    space.add_line((0, 0), (1e200, 1e200))
    space.add_line((0, 0), (-1.7e308, 1e200))
    with pytest.raises(InvalidFile, match="coordinates are too large"):
        read(drawing, tmp_path)
    text = ezdxf.new("R12")
    text.modelspace().add_line((0, 0), (123, 0))
    text.modelspace().add_line((0, 0), (5, 0))
    stream = io.StringIO()
    text.write(stream)
    soup = read(stream.getvalue().replace("123.0", "nan"), tmp_path)
    assert soup.lines_coords.tolist() == [[[0, 0], [5, 0]]]
    assert codes(soup) == ["entities-damaged"]


@pytest.mark.parametrize("name", ["square_twist", "crane", "miura"])
@pytest.mark.parametrize("version", [DxfVersion.R12, DxfVersion.R2000, DxfVersion.R2018])
def test_our_own_sheets_come_back(name, version, tmp_path):
    """Dashes, margins and kerf are taken away again; creases that stay flat are not drawn."""
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    machine = load_machine("co2_60w_600x400").model_copy(update={"dxf_version": version})
    material = load_material("card_300gsm")
    request = SheetRequest(material, machine, formats=[SheetFormat.DXF])
    made = fabricate(pattern, name, request)
    (data,) = (content for file, content in made.files.items() if file.endswith(".dxf"))
    soup = read(data, tmp_path)
    assert {"kerf-removed", "dashes-joined"} <= set(codes(soup))
    size = np.linalg.norm(np.diff(pattern.vertices_coords[pattern.edges_vertices], axis=1), axis=2)
    for letter in "BMV":
        drawn = soup.lines_coords[soup.lines_assignment == letter]
        own = float(size[pattern.edges_assignment == letter].sum())
        assert length(drawn) == pytest.approx(own, rel=1e-5), letter


def test_dashes_of_any_drawing_are_joined(drawing, tmp_path):
    for i in range(10):
        drawing.modelspace().add_line((3 * i, 0), (3 * i + 2, 0), {"color": 1})
    drawing.modelspace().add_lwpolyline([(-5, -5), (40, -5), (40, 5), (-5, 5)], close=True)
    soup = read(drawing, tmp_path)
    assert "dashes-joined" in codes(soup)
    assert soup.lines_coords[soup.lines_assignment == "M"].tolist() == [[[0, 0], [29, 0]]]


def test_a_drawing_of_too_many_lines_is_refused_before_its_dashes_are_joined(
    drawing, tmp_path, monkeypatch
):
    """Joining needs as much memory as the import, which has a bound."""
    monkeypatch.setattr("fab.formats.drawn.line_soup.MOST_LINES", 100)
    for i in range(101):
        drawing.modelspace().add_line((3 * i, 0), (3 * i + 2, 0), {"color": 1})
    monkeypatch.setattr("fab.formats.dxf.reader.join_dashes", None)  # not to be called
    with pytest.raises(InvalidFile, match=r"101 lines are over the bound of 100\. Leave out"):
        read(drawing, tmp_path)
