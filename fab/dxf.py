"""How do cut paths become a DXF file?

Real segments, no linetypes; one layer and one colour per operation; millimetres in the header.
ezdxf writes header, tables and outlines; the dashes are formatted in bulk and put behind them,
because a million of them would otherwise take minutes.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager

import ezdxf
from ezdxf.enums import InsertUnits

from fab.paths import CutPaths, Layer, Operation

__all__ = ["dxf_bytes"]

# AutoCAD colour index by operation: green marks, red mountains, blue valleys, magenta relief holes,
# black (white on dark) cuts.
_COLOURS = {
    Operation.ENGRAVE: 3,
    Operation.MOUNTAIN: 1,
    Operation.VALLEY: 5,
    Operation.RELIEF: 6,
    Operation.CUT: 7,
}

_LINE = (
    "  0\nLINE\n  5\n%X\n330\n{owner}\n100\nAcDbEntity\n  8\n{layer}\n100\nAcDbLine\n"
    " 10\n%.6f\n 20\n%.6f\n 30\n0.0\n 11\n%.6f\n 21\n%.6f\n 31\n0.0\n"
)


def dxf_bytes(paths: CutPaths) -> bytes:
    """The DXF R2000 file, the same bytes for the same paths."""
    with _fixed_metadata():
        document = ezdxf.new("R2000", units=InsertUnits.Millimeters)
        document.header["$MEASUREMENT"] = 1
        space = document.modelspace()
        for layer in paths.layers:
            document.layers.add(layer.operation, color=_COLOURS[layer.operation])
            for outline in layer.outlines:
                space.add_lwpolyline(outline, close=True, dxfattribs={"layer": layer.operation})
        corners = (0.0, 0.0, 0.0), (*paths.size_mm, 0.0)
        document.header["$EXTMIN"], document.header["$EXTMAX"] = corners
        space.dxf.extmin, space.dxf.extmax = corners
        stream = io.StringIO()
        document.write(stream)
    text = stream.getvalue()
    found = re.search(r"\$HANDSEED\n  5\n([0-9A-F]+)\n", text)
    head, mark, rest = text.partition("  2\nENTITIES\n")
    if found is None or not mark:
        raise RuntimeError("ezdxf wrote a DXF file without $HANDSEED or ENTITIES section")
    body, end, tail = rest.partition("  0\nENDSEC\n")
    handle = int(found[1], 16)
    parts = []
    for layer in paths.layers:
        parts.append(_lines(layer, handle, space.layout_key))
        handle += len(layer.segments)
    head = head.replace(found[0], f"$HANDSEED\n  5\n{handle:X}\n")
    return "".join([head, mark, body, *parts, end, tail]).encode("utf-8")


def _lines(layer: Layer, handle: int, owner: str) -> str:
    template = _LINE.format(owner=owner, layer=layer.operation)
    rows = layer.segments.reshape(-1, 4).tolist()
    return "".join(template % (handle + i, *row) for i, row in enumerate(rows))


@contextmanager
def _fixed_metadata() -> Iterator[None]:
    """Dates and GUIDs of ezdxf fixed, so that the same drawing gives the same bytes."""
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before
