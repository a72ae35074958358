"""DXF and SVG, read back by other programs' readers."""

import io
import xml.etree.ElementTree as ElementTree

import ezdxf
import ezdxf.bbox
import numpy as np
import pytest
from ezdxf import recover

from fab.crease import crease_pattern
from fab.development import develop
from fab.dxf import dxf_bytes
from fab.paths import CutPaths, Layer, Operation
from fab.perforation import PerforationSettings, perforate
from fab.svg import svg_bytes
from solver import CurvedFold

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
