"""DXF, SVG and PDF, read back by other programs' readers."""

import io
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import ezdxf
import ezdxf.bbox
import numpy as np
import pytest
from ezdxf import recover
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pypdf import PdfReader
from pypdfium2 import PdfDocument

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.drawings.dxf import DxfVersion, dxf_bytes
from fab.drawings.layer_colours import Colour, Colours
from fab.drawings.number_records import write_records
from fab.drawings.pdf import pdf_bytes
from fab.drawings.svg import svg_bytes
from fab.outputs import plain_title
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.sheets.perforation import perforate
from fab.sheets.perforation_settings import PerforationSettings
from solver import CurvedFold, InvalidValue

SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


@pytest.fixture(scope="module")
def paths() -> CutPaths:
    mesh = CurvedFold(columns=30, k=np.radians(181)).grow().mesh
    paths, _ = perforate(crease_pattern(mesh, develop(mesh), 60.0), PerforationSettings())
    return paths


def test_dxf_has_no_audit_finding_and_says_millimetres(paths):
    document, audit = recover.read(io.BytesIO(dxf_bytes(paths)))
    assert not audit.errors
    assert not audit.fixes
    assert not document.audit().errors
    assert document.header["$INSUNITS"] == 4
    assert document.header["$MEASUREMENT"] == 1
    assert document.dxfversion == "AC1015"


def test_dxf_holds_the_segments_on_their_layers(paths):
    document = ezdxf.read(io.StringIO(dxf_bytes(paths).decode()))
    space = document.modelspace()
    for layer, colour in zip(paths.layers, (1, 5, 7), strict=True):
        assert document.layers.get(layer.operation).color == colour
        lines = space.query(f'LINE[layer=="{layer.operation}"]')
        ends = np.array([[[*e.dxf.start.vec2], [*e.dxf.end.vec2]] for e in lines]).reshape(-1, 2, 2)
        assert ends == pytest.approx(layer.segments, abs=1e-6)
        outlines = space.query(f'LWPOLYLINE[layer=="{layer.operation}"]')
        assert len(outlines) == len(layer.outlines)
        for entity, outline in zip(outlines, layer.outlines, strict=True):
            assert entity.closed
            assert np.array(entity.get_points("xy")) == pytest.approx(outline, abs=1e-9)
    assert {e.dxftype() for e in space} == {"LINE", "LWPOLYLINE"}
    extents = ezdxf.bbox.extents(space)
    assert [*extents.size.vec2] == pytest.approx(paths.size_mm, abs=1e-6)


def test_dxf_frees_the_pieces_last(paths):
    document = ezdxf.read(io.StringIO(dxf_bytes(paths).decode()))
    order = [str(entity.dxf.layer) for entity in document.modelspace()]
    assert [*dict.fromkeys(order)] == [layer.operation for layer in paths.layers]
    kinds = [entity.dxftype() for entity in document.modelspace()]
    assert kinds.index("LWPOLYLINE") == kinds.count("LINE") > 0


def test_dxf_handles_are_unique_and_below_the_seed(paths):
    document = ezdxf.read(io.StringIO(dxf_bytes(paths).decode()))
    handles = [int(e.dxf.handle, 16) for e in document.modelspace()]
    assert len(set(handles)) == len(handles)
    text = dxf_bytes(paths).decode()
    seed = int(text.partition("$HANDSEED\n  5\n")[2].partition("\n")[0], 16)
    assert max(handles) < seed


def test_svg_is_millimetres_with_one_inkscape_layer_per_operation(paths):
    root = ElementTree.fromstring(svg_bytes(paths, 'a "title" <&>'))
    assert root.find(f"{SVG}title").text == 'a "title" <&>'
    assert root.get("width").endswith("mm")
    box = [float(x) for x in root.get("viewBox").split()]
    assert float(root.get("width")[:-2]) == pytest.approx(box[2])
    assert box[2:] == pytest.approx(np.array(paths.size_mm) + 0.2)
    groups = root.findall(f"{SVG}g")
    assert [g.get(f"{INKSCAPE}label") for g in groups] == ["MOUNTAIN", "VALLEY", "CUT"]
    assert all(g.get(f"{INKSCAPE}groupmode") == "layer" for g in groups)
    assert [g.get("stroke") for g in groups] == ["#ff0000", "#0000ff", "#000000"]


def test_pages_on_a_bed_are_the_bed_in_every_format(paths):
    """The place of a line on the page is its place on the bed, from the lower left corner."""
    on_bed = replace(paths, size_mm=(600.0, 400.0), on_bed=True)
    root = ElementTree.fromstring(svg_bytes(on_bed, "sheet"))
    assert (root.get("width"), root.get("height")) == ("600.000000mm", "400.000000mm")
    assert [float(x) for x in root.get("viewBox").split()] == [0, 0, 600, 400]
    (page,) = PdfReader(io.BytesIO(pdf_bytes(on_bed, "sheet"))).pages
    assert [float(x) * 25.4 / 72 for x in page.mediabox] == pytest.approx([0, 0, 600, 400])
    cut = root.findall(f"{SVG}g")[-1].find(f"{SVG}path").get("d")
    points = np.array([[float(x) for x in p.split(",")] for p in cut.strip("MZ").split("L")])
    outline = on_bed.layers[-1].outlines[0]
    assert points == pytest.approx(outline * [1, -1] + [0, 400], abs=1e-6)
    assert {g.get("stroke-width") for g in root.findall(f"{SVG}g")} == {"0.1"}


NASTY = "a\x00\x1b[31m\n\r\u2028</title><script>&amp;\udcff\ufffe\u202e ü(\\)%"


def test_titles_of_any_text_leave_files_that_can_be_read(paths):
    plain = plain_title(NASTY)
    assert plain == "a__[31m___</title><script>&amp;___ ü(\\)%"
    root = ElementTree.fromstring(svg_bytes(paths, NASTY))
    assert root.find(f"{SVG}title").text == plain
    assert root.find(f".//{SVG}script") is None
    reader = PdfReader(io.BytesIO(pdf_bytes(paths, NASTY)))
    assert reader.metadata.title == plain
    assert len(reader.pages) == 1


@given(st.text())
def test_titles_are_printable_and_stay_so(text):
    plain = plain_title(text)
    assert plain.isprintable()
    assert len(plain) == len(text)
    assert plain_title(plain) == plain
    assert not text.isprintable() or plain == text


def test_svg_shows_the_upper_side_not_its_mirror(paths):
    root = ElementTree.fromstring(svg_bytes(paths, "sheet"))
    height = paths.size_mm[1]
    mountain = root.find(f"{SVG}g/{SVG}path").get("d")
    numbers = np.array(
        [
            [float(x) for x in pair.split(",")]
            for pair in mountain.replace("M", "").replace("L", " ").split()
        ]
    ).reshape(-1, 2, 2)
    numbers[..., 1] = height - numbers[..., 1]
    assert numbers == pytest.approx(paths.layers[0].segments, abs=1e-5)


def test_the_same_paths_give_the_same_bytes(paths):
    assert dxf_bytes(paths) == dxf_bytes(paths)
    assert svg_bytes(paths, "a") == svg_bytes(paths, "a")
    assert pdf_bytes(paths, "a") == pdf_bytes(paths, "a")


def test_empty_layers_are_drawn_as_empty_layers():
    empty = np.empty((0, 2, 2))
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    paths = CutPaths(
        (Layer(Operation.MOUNTAIN, empty), Layer(Operation.CUT, empty, (square,))), (1, 1)
    )
    document = ezdxf.read(io.StringIO(dxf_bytes(paths).decode()))
    assert len(document.modelspace()) == 1
    assert "MOUNTAIN" in document.layers
    ElementTree.fromstring(svg_bytes(paths, "square"))


def written(*arguments) -> bytes:
    stream = io.BytesIO()
    write_records(stream, *arguments)
    return stream.getvalue()


numbers = st.floats(-1e6, 1e6) | st.sampled_from([0.0, -0.0, 0.9999999, -1e-9, 9.9999996, -99.5])


@given(arrays(float, st.tuples(st.integers(1, 40), st.integers(1, 5)), elements=numbers))
def test_records_are_the_numbers_to_six_decimals(rows):
    text = [b"<", *[b" "] * (rows.shape[1] - 1), b">\n"]
    lines = written(text, rows).decode().splitlines()
    back = np.array([[float(x) for x in line[1:-1].split()] for line in lines])
    assert back == pytest.approx(rows, rel=0, abs=0.5001e-6)
    assert len({len(line) for line in lines}) == 1


@given(st.integers(1, 30_000), st.integers(0x1000, 0x8000))
def test_records_count_their_handles(count, first):
    data = written([b"", b" ", b"\n"], np.zeros((count, 1)), first)
    handles = [int(line.split()[0], 16) for line in data.decode().splitlines()]
    assert handles == list(range(first, first + count))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -4e9])
def test_numbers_that_cannot_be_written_are_refused(bad):
    rows = np.array([[1.0, 2.0], [3.0, bad]])
    with pytest.raises(InvalidValue, match="coordinate"):
        written([b"", b" ", b"\n"], rows)
    assert written([b"", b" ", b"\n"], rows[:0]) == b""


@pytest.mark.parametrize("version", list(DxfVersion))
def test_every_version_says_millimetres_and_passes_the_audit(paths, version, caplog):
    data = dxf_bytes(paths, version=version)
    assert caplog.records == []
    document, audit = recover.read(io.BytesIO(data))
    assert not audit.errors
    assert not audit.fixes
    assert document.acad_release == version
    assert document.header["$INSUNITS"] == 4
    assert document.header["$MEASUREMENT"] == 1
    space = document.modelspace()
    kinds = {"LINE", "POLYLINE" if version is DxfVersion.R12 else "LWPOLYLINE"}
    assert {e.dxftype() for e in space} == kinds
    assert [*ezdxf.bbox.extents(space).size.vec2] == pytest.approx(paths.size_mm, abs=1e-6)
    for layer in paths.layers:
        assert len(space.query(f'LINE[layer=="{layer.operation}"]')) == len(layer.segments)


def test_handles_stay_apart_beside_many_outlines():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    outlines = tuple(square + np.array([i, 0.0]) for i in range(300))
    layer = Layer(Operation.CUT, square.reshape(2, 2, 2), outlines)
    document = ezdxf.read(io.StringIO(dxf_bytes(CutPaths((layer,), (300, 1))).decode()))
    assert len(document.modelspace()) == 302
    assert not document.audit().errors


OTHER = Colours(mountain=Colour(hex="#123456", aci=30), cut=Colour(hex="#0000ff", aci=5))


def test_colours_are_those_that_were_asked_for(paths):
    document = ezdxf.read(io.StringIO(dxf_bytes(paths, OTHER).decode()))
    assert [document.layers.get(name).color for name in ("MOUNTAIN", "VALLEY", "CUT")] == [30, 5, 5]
    groups = ElementTree.fromstring(svg_bytes(paths, "a", OTHER)).findall(f"{SVG}g")
    assert [g.get("stroke") for g in groups] == ["#123456", "#0000ff", "#0000ff"]
    content = PdfReader(io.BytesIO(pdf_bytes(paths, "a", OTHER))).pages[0].get_contents().get_data()
    assert b"0.0706 0.2039 0.3373 RG" in content


def test_pdf_is_the_sheet_at_its_size_with_one_layer_per_operation(paths):
    reader = PdfReader(io.BytesIO(pdf_bytes(paths, 'a "title" ü')))
    (page,) = reader.pages
    assert reader.metadata.title == 'a "title" ü'
    box = np.array([page.mediabox.width, page.mediabox.height], float) * 25.4 / 72
    assert box == pytest.approx(paths.size_mm, abs=1e-5)
    names = [group.get_object()["/Name"] for group in reader.root_object["/OCProperties"]["/OCGs"]]
    assert names == ["MOUNTAIN", "VALLEY", "CUT"]
    content = page.get_contents().get_data().decode()
    scale = [float(x) for x in content.split()[:4]]
    assert scale == pytest.approx([72 / 25.4, 0, 0, 72 / 25.4], abs=1e-11)
    groups = re.findall(r"/OC /(\w+) BDC\n[^\n]* RG\n(.*?)EMC", content, re.DOTALL)
    assert [name for name, _ in groups] == names
    for layer, (_, drawn) in zip(paths.layers, groups, strict=True):
        lines = re.findall(r"(\S+) (\S+) m (\S+) (\S+) l S\n", drawn)
        ends = np.array(lines, float).reshape(-1, 2, 2)
        assert ends == pytest.approx(layer.segments, abs=1e-6)
        points = re.findall(r"(\S+) (\S+) [ml](?:\n| s\n)", drawn)
        assert np.array(points, float).reshape(-1, 2) == pytest.approx(
            np.concatenate([np.empty((0, 2)), *layer.outlines]), abs=1e-6
        )


def test_pdf_is_drawn_where_it_should_be():
    square = np.array([[10.0, 20], [60, 20], [60, 90], [10, 90]])
    paths = CutPaths((Layer(Operation.CUT, outlines=(square,)),), (101.6, 127.0))
    page = PdfDocument(pdf_bytes(paths, "a"))[0]
    picture = page.render(scale=254 / 72, grayscale=True).to_numpy()  # ten pixels to the mm
    assert picture.shape[:2] == (1270, 1016)
    ink = picture.reshape(1270, 1016) < 200
    rows, columns = np.flatnonzero(ink.any(axis=1)), np.flatnonzero(ink.any(axis=0))
    assert np.array([columns[0], columns[-1]]) == pytest.approx([100, 600], abs=1)
    assert np.array([1270 - rows[-1], 1270 - rows[0]]) == pytest.approx([200, 900], abs=1)


def test_sheets_larger_than_a_page_are_refused():
    with pytest.raises(InvalidValue, match="at most 5080 mm"):
        pdf_bytes(CutPaths((), (5081.0, 10.0)), "large")


@pytest.mark.parametrize("version", list(DxfVersion))
def test_chains_are_one_open_line_in_every_format(version):
    bend = np.array([[10.0, 20], [10, 50], [40, 50]])
    layer = Layer(Operation.HOLE, np.array([[[1.0, 2], [3, 4]]]), (bend + 40,), (bend,))
    paths = CutPaths((layer,), (100.0, 100.0), on_bed=True)
    space = ezdxf.read(io.StringIO(dxf_bytes(paths, version=version).decode())).modelspace()
    kind = "POLYLINE" if version is DxfVersion.R12 else "LWPOLYLINE"
    lines = {entity.is_closed: entity for entity in space.query(kind)}
    assert set(lines) == {True, False}
    points = list(lines[False].points() if kind == "POLYLINE" else lines[False].vertices())
    assert np.array(points)[:, :2] == pytest.approx(bend)
    root = ElementTree.fromstring(svg_bytes(paths, "a"))
    drawn = [path.get("d") for path in root.iter(f"{SVG}path")]
    assert drawn[1] == "M10.000000,80.000000L10.000000,50.000000L40.000000,50.000000"
    assert drawn[2].endswith("Z")
    data = PdfReader(io.BytesIO(pdf_bytes(paths, "a"))).pages[0].get_contents().get_data()
    assert b"10.000000 20.000000 m\n10.000000 50.000000 l\n40.000000 50.000000 l S\n" in data
    assert data.count(b" l s\n") == 1
