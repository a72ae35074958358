"""DXF files of cut paths.

Real segments, no linetypes; one layer and one colour per operation; millimetres in the header.
ezdxf writes header, tables and polylines. The dashes are formatted in bulk, because a million of
them would otherwise take minutes, and put before the outlines, because a machine that cuts in the
order of the file must free pieces last.
"""

from __future__ import annotations

import io
import re
from enum import StrEnum
from typing import BinaryIO

import ezdxf
from ezdxf.enums import InsertUnits

from fab.drawings.cut_paths import CutPaths
from fab.drawings.layer_colours import Colours
from fab.drawings.number_records import write_records
from fab.outputs import fixed_dxf_metadata

__all__ = ["DxfVersion", "dxf_bytes", "write_dxf"]


class DxfVersion(StrEnum):
    """Versions of DXF.

    R12 is for old machines only. It has no LWPOLYLINE, so outlines are POLYLINEs, several times as
    long; and no units: $INSUNITS and $MEASUREMENT are in its header all the same, because programs
    that look for them then open the sheet at its size. Other programs take the numbers for their
    own unit: set that to millimetres.
    """

    R12 = "R12"
    R2000 = "R2000"
    R2004 = "R2004"
    R2007 = "R2007"
    R2010 = "R2010"
    R2013 = "R2013"
    R2018 = "R2018"


_UNITS = "  9\n$INSUNITS\n 70\n4\n  9\n$MEASUREMENT\n 70\n1\n"


def dxf_bytes(
    paths: CutPaths,
    colours: Colours | None = None,
    version: DxfVersion = DxfVersion.R2000,
    remark: str = "",
) -> bytes:
    """The bytes that `write_dxf` writes."""
    out = io.BytesIO()
    write_dxf(out, paths, colours, version, remark)
    return out.getvalue()


def write_dxf(
    stream: BinaryIO,
    paths: CutPaths,
    colours: Colours | None = None,
    version: DxfVersion = DxfVersion.R2000,
    remark: str = "",
) -> None:
    """Write the DXF file, the same bytes for the same paths, without holding it in memory.

    remark : one line of text, which becomes a comment at the head of the file.

    Raises `InvalidValue` for coordinates that are not finite or not below 4e9.
    """
    head, body, tail, owner, handle = _frame(paths, colours or Colours(), version)
    count = sum(len(layer.segments) for layer in paths.layers)
    handle = int(16 ** len(f"{max(handle, count):X}"))  # so that all handles are alike in length
    if remark:
        stream.write(f"999\n{remark}\n".encode())
    seed = f"$HANDSEED\n  5\n{handle + count:X}\n"
    stream.write(re.sub(r"\$HANDSEED\n  5\n[0-9A-F]+\n", seed, head).encode())
    for layer in paths.layers:
        rows = layer.segments.reshape(-1, 4)
        write_records(stream, _line(layer.operation, owner, version), rows, handle)
        handle += len(rows)
    stream.write(body.encode())
    stream.write(tail.encode())


def _frame(
    paths: CutPaths, colours: Colours, version: DxfVersion
) -> tuple[str, str, str, str, int]:
    """The text before the dashes, the outlines, the text after them; owner; a free handle."""
    with fixed_dxf_metadata():
        document = ezdxf.new(version)
        if version is not DxfVersion.R12:  # ezdxf would leave them out
            document.units = InsertUnits.Millimeters
            document.header["$MEASUREMENT"] = 1
        space = document.modelspace()
        for layer in paths.layers:
            document.layers.add(layer.operation, color=colours.of(layer.operation).aci)
            attributes = {"layer": layer.operation}
            lines = [(chain, False) for chain in layer.chains]
            lines += [(outline, True) for outline in layer.outlines]
            for line, close in lines:
                if version is DxfVersion.R12:
                    space.add_polyline2d(line, close=close, dxfattribs=attributes)
                else:
                    space.add_lwpolyline(line, close=close, dxfattribs=attributes)
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
    if version is DxfVersion.R12:
        first = "  2\nHEADER\n"
        head = head.replace(first, first + _UNITS, 1)
    body, end, tail = rest.partition("  0\nENDSEC\n")
    return head + mark, body, end + tail, space.layout_key, int(found[1], 16)


def _line(layer: str, owner: str, version: DxfVersion) -> list[bytes]:
    """The text of a LINE around its handle and its four coordinates."""
    kind, place, entity, between = "  0\nLINE\n  5\n", f"  8\n{layer}\n", "", ""
    if version is not DxfVersion.R12:
        entity = f"330\n{owner}\n100\nAcDbEntity\n"
        between = "100\nAcDbLine\n"
    parts = [
        kind,
        f"\n{entity}{place}{between} 10\n",
        "\n 20\n",
        "\n 30\n0.0\n 11\n",
        "\n 21\n",
        "\n 31\n0.0\n",
    ]
    return [part.encode() for part in parts]
