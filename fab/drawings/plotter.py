"""HP-GL files (.plt) of cut paths, for knife plotters.

Instructions of the vector group, as in HP's HP-GL/2 reference and the manuals of cutters (Gerber
Odyssey, Redsail RS1360C): `IN` initialises, `PA` takes coordinates as absolute, `SP n` selects a
pen or tool, `VS` its speed in cm/s, `PU` moves with the tool up and `PD` with the tool down along
all points that follow.

Coordinates are whole plotter units of 1/40 mm, so that each is rounded by up to 0.0125 mm. The
origin is the lower left corner of the page. The x axis of a plotter runs along the longer side of
its page, which is the feed of a roll: a bed that is deeper than wide is turned by a quarter.
"""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np

from fab.drawings.cut_paths import CutPaths, Operation, polylines
from fab.drawings.cut_settings import CutSetting
from solver.vectors import FloatArray, IntArray

__all__ = ["plotter_bytes"]

_UNITS_PER_MM = 40
_MM_PER_CM = 10
# Slower is no speed to plotters that take whole numbers.
_LEAST_CM_S = 1
_TOOLS = {
    Operation.ENGRAVE: 1,
    Operation.MOUNTAIN: 2,
    Operation.VALLEY: 3,
    Operation.RELIEF: 4,
    Operation.HOLE: 6,
    Operation.CUT: 5,
}


def plotter_bytes(paths: CutPaths, settings: Mapping[Operation, CutSetting] | None = None) -> bytes:
    """The file, the same bytes for the same paths; as seen from the upper side.

    Tools are 1 for engravings, 2 mountains, 3 valleys, 4 relief holes, 6 holes, 5 cuts, in this
    order.
    settings : of the operations; speeds are rounded to whole cm/s, and are the plotter's own where
        left out.
    """
    chosen = settings or {}
    out = io.StringIO()
    out.write("IN;PA;\n")
    for layer in paths.layers:
        lines = polylines(layer)
        if not lines:
            continue
        out.write(f"PU;SP{_TOOLS[layer.operation]};")
        if layer.operation in chosen:
            speed = round(chosen[layer.operation].speed_mm_s / _MM_PER_CM)
            out.write(f"VS{max(speed, _LEAST_CM_S)};")
        out.write("\n")
        for line in lines:
            points = _units(line, paths.size_mm).tolist()
            first, *others = [f"{x},{y}" for x, y in points]
            out.write(f"PU{first};PD{','.join(others)};\n")
    out.write("PU0,0;SP0;\n")
    return out.getvalue().encode()


def _units(points: FloatArray, size_mm: tuple[float, float]) -> IntArray:
    """Points (m, 2) on the page in plotter units, turned where the page is deeper than wide."""
    width, depth = size_mm
    if depth > width:
        points = np.column_stack([points[:, 1], width - points[:, 0]])
    return np.rint(_UNITS_PER_MM * points).astype(np.int64)
