"""Crease patterns as DXF drawings of whole lines, one layer for each assignment."""

from __future__ import annotations

import io

import ezdxf
import numpy as np
from ezdxf.enums import InsertUnits

from fab.errors import Finding, Severity
from fab.outputs import fixed_dxf_metadata, plain_title
from fab.pattern.crease_pattern import CreasePattern

__all__ = ["LAYERS", "angles_lost_in_dxf", "dxf_bytes"]

# Name and colour index by assignment; readers tell the assignment by either.
LAYERS = {
    "B": ("BORDER", 7),
    "M": ("MOUNTAIN", 1),
    "V": ("VALLEY", 5),
    "C": ("CUT", 3),
    "F": ("FACET", 2),
    "U": ("UNASSIGNED", 6),
    "J": ("JOIN", 4),
}


def dxf_bytes(pattern: CreasePattern, title: str) -> bytes:
    """The DXF file (R2004, millimetres) of a pattern: a LINE for each edge, on a layer that names
    its assignment. The same bytes for the same pattern; coordinates have all their digits.

    Fold angles have no place in it: `angles_lost_in_dxf`.
    """
    with fixed_dxf_metadata():
        document = ezdxf.new("R2004")
        document.units = InsertUnits.Millimeters
        document.header["$MEASUREMENT"] = 1
        document.header["$PROJECTNAME"] = plain_title(title)
        space = document.modelspace()
        for name, colour in LAYERS.values():
            document.layers.add(name, color=colour)
        ends = pattern.vertices_coords[pattern.edges_vertices].tolist()
        for (start, end), letter in zip(ends, pattern.edges_assignment.tolist(), strict=True):
            space.add_line(start, end, dxfattribs={"layer": LAYERS[letter][0]})
        low, high = pattern.vertices_coords.min(axis=0), pattern.vertices_coords.max(axis=0)
        corners = (*low.tolist(), 0.0), (*high.tolist(), 0.0)
        document.header["$EXTMIN"], document.header["$EXTMAX"] = corners
        space.dxf.extmin, space.dxf.extmax = corners
        stream = io.StringIO()
        document.write(stream)
        return stream.getvalue().encode(document.output_encoding, "dxfreplace")


def angles_lost_in_dxf(pattern: CreasePattern) -> tuple[Finding, ...]:
    """The finding of creases that fold by less than 180 degrees, which the drawing cannot say."""
    folding = np.isin(pattern.edges_assignment, ["M", "V"])
    partial = np.flatnonzero(folding & (np.abs(np.abs(pattern.edges_foldAngle) - 180.0) > 1e-9))
    if not len(partial):
        return ()
    what = "1 crease folds" if len(partial) == 1 else f"{len(partial)} creases fold"
    text = f"{what} by less than 180 degrees, which DXF files cannot say. Keep the FOLD file."
    creases = tuple(partial[:20].tolist())
    return (Finding("angles-lost-in-dxf", Severity.WARNING, text, creases),)
