"""LightBurn projects (.lbrn2) of cut paths.

The format is XML without a published schema. The structure is that of projects which LightBurn
itself writes, FormatVersion 1, as its forum (threads 42317 and 52174) and the importer of MeerK40t
(meerk40t/extra/lbrn.py) read it:

- `LightBurnProject`, with MirrorX and MirrorY off: x to the right and y away from the front left
  corner of the bed, in millimetres.
- `UIPrefs`: the settings of the cut planner; here layers by their order, inner shapes first, no
  other change of the order in the file.
- A `CutSetting` for each operation: `index` is the number of its layer and colour, `priority` its
  place in the order of the work, `speed` in mm/s, `minPower` and `maxPower` in per cent. What is
  left out takes LightBurn's default.
- A `Shape` of the type Path for each line: `XForm`, the matrix a b c d e f; `VertList`, vertices
  "Vx yc0x1c1x1", whose last parts say that no Bezier handles follow; `PrimList`, sides "L0 1" from
  vertex to vertex. A closed line ends at its first vertex.
- `Notes`, shown as the project opens where something is left to set.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from xml.sax.saxutils import quoteattr

import numpy as np

from fab.drawings.cut_paths import CutPaths, Operation, polylines
from fab.drawings.cut_settings import CutSetting
from fab.outputs import plain_title
from solver.vectors import FloatArray

__all__ = ["lightburn_bytes"]

# LightBurn has fixed colours of layers: black, blue, red, green, orange the sixth, magenta the
# eighth.
_LAYERS = {
    Operation.ENGRAVE: 3,
    Operation.MOUNTAIN: 2,
    Operation.VALLEY: 1,
    Operation.RELIEF: 7,
    Operation.HOLE: 5,
    Operation.CUT: 0,
}
# Numbers of texts that count up: none are drawn, but LightBurn looks for the table.
_TEXT = {"Start": 0, "End": 999, "Current": 0, "Increment": 1, "AutoAdvance": 0}
# -1: not among what the cut planner orders by.
_PLANNER = {
    "Optimize_ByLayer": 0,
    "Optimize_ByGroup": -1,
    "Optimize_ByPriority": -1,
    "Optimize_WhichDirection": 0,
    "Optimize_InnerToOuter": 1,
    "Optimize_ByDirection": 0,
    "Optimize_ReduceTravel": 0,
    "Optimize_HideBacklash": 0,
    "Optimize_ReduceDirChanges": 0,
    "Optimize_ChooseCorners": 0,
    "Optimize_AllowReverse": 0,
    "Optimize_RemoveOverlaps": 0,
    "Optimize_OptimalEntryPoint": 0,
    "Optimize_OverlapDist": 0.025,
}
_HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<LightBurnProject AppVersion="1.7.08" FormatVersion="1" MaterialHeight="0" \
MirrorX="False" MirrorY="False">
"""


def lightburn_bytes(
    paths: CutPaths, title: str, settings: Mapping[Operation, CutSetting] | None = None
) -> bytes:
    """The project, the same bytes for the same paths; as seen from the upper side.

    title : in the notes; "_" replaces what cannot be printed.
    settings : of the operations; speed and power that are left out are those that LightBurn gives
        to new layers, and the notes name the layers.
    """
    chosen = settings or {}
    out = io.BytesIO()
    out.write(_HEAD.encode())
    out.write(_table("VariableText", _TEXT).encode())
    out.write(_table("UIPrefs", _PLANNER).encode())
    for layer in paths.layers:
        out.write(_cut_setting(layer.operation, chosen.get(layer.operation)).encode())
    number = 0
    for layer in paths.layers:
        attributes = f'Type="Path" CutIndex="{_LAYERS[layer.operation]}"'
        for line in polylines(layer):
            out.write(_shape(line, attributes, number).encode())
            number += 1
    out.write(_notes(paths, plain_title(title), chosen).encode())
    out.write(b"</LightBurnProject>\n")
    return out.getvalue()


def _table(name: str, values: Mapping[str, object], attributes: str = "") -> str:
    rows = "".join(f'<{key} Value="{value}"/>\n' for key, value in values.items())
    return f"<{name}{attributes}>\n{rows}</{name}>\n"


def _cut_setting(operation: Operation, setting: CutSetting | None) -> str:
    values: dict[str, object] = {"index": _LAYERS[operation], "name": operation}
    if setting is not None:
        if setting.power_percent is not None:
            power = f"{setting.power_percent:g}"
            values |= {"minPower": power, "maxPower": power}
        values["speed"] = f"{setting.speed_mm_s:g}"
    values["priority"] = list(Operation).index(operation)
    return _table("CutSetting", values, ' type="Cut"')


def _shape(line: FloatArray, attributes: str, number: int) -> str:
    """A Path; `line` : shape (m, 2), closed where it ends at its first vertex."""
    closed = len(line) > 2 and np.array_equal(line[0], line[-1])
    vertices = line[:-1] if closed else line
    sides = [(i, (i + 1) % len(vertices)) for i in range(len(line) - 1)]
    listed = "".join("V%.6f %.6fc0x1c1x1" % (x, y) for x, y in vertices.tolist())
    joined = "".join(f"L{start} {end}" for start, end in sides)
    return (
        f'<Shape {attributes} VertID="{number}" PrimID="{number}">\n<XForm>1 0 0 1 0 0</XForm>\n'
        f"<VertList>{listed}</VertList>\n<PrimList>{joined}</PrimList>\n</Shape>\n"
    )


def _notes(paths: CutPaths, title: str, settings: Mapping[Operation, CutSetting]) -> str:
    width, depth = paths.size_mm
    text = f"{title}, on a bed of {width:g} x {depth:g} mm, origin at its front left corner."
    unset = list(_unset(paths, settings))
    if unset:
        text += f" Set in each of these layers before you cut: {'; '.join(unset)}."
    return f'<Notes ShowOnLoad="{int(bool(unset))}" Notes={quoteattr(text)}/>\n'


def _unset(paths: CutPaths, settings: Mapping[Operation, CutSetting]) -> Iterator[str]:
    """What each layer leaves to LightBurn."""
    for layer in paths.layers:
        setting = settings.get(layer.operation)
        if setting is None:
            yield f"{layer.operation}, speed and power"
        elif setting.power_percent is None:
            yield f"{layer.operation}, power"
