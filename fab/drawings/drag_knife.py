"""Tool paths of drag knives, whose blade trails behind the axis on which it turns.

The tip of the blade is `offset_mm` behind the axis, in the direction in which it moves. So that the
tip follows a line, the axis runs ahead of it by the offset; at corners it goes around the corner on
an arc, about which the blade swivels with its tip in place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fab.drawings.cut_paths import CutPaths, Operation, polylines
from solver.vectors import FloatArray

__all__ = ["blade_led"]

# Chords of arcs turn by up to this angle: a chord leaves its arc by 0.1 % of the offset.
_CHORD_RAD = np.radians(5.0)
# Shorter sides have no direction, mm.
_LEAST_MM = 1e-6


def blade_led(paths: CutPaths, offset_mm: float, corner_deg: float) -> CutPaths:
    """The paths of the axis of a drag knife whose tip follows the lines, in the same order.

    Corners sharper than `corner_deg` (by how much the line turns) get swivel arcs; at others the
    axis goes straight on to the next side, and the tip leaves the line by up to about
    offset_mm (1 - cos(corner_deg)). A lifted blade keeps its direction, so before each line the
    knife swivels at its start from the direction in which the line before it ended; it is first
    lowered in the direction of the first line. Engraved lines stay as they are.
    """
    if not offset_mm:
        return paths
    heading: FloatArray | None = None
    layers = []
    for layer in paths.layers:
        if layer.operation is Operation.ENGRAVE:
            layers.append(layer)
            continue
        led = []
        for line in polylines(layer):
            path, heading = _axis_path(line, heading, offset_mm, np.radians(corner_deg))
            led.append(path)
        single = all(len(path) == 2 for path in led)
        segments = np.array(led).reshape(-1, 2, 2) if single else np.empty((0, 2, 2))
        chains = () if single else tuple(led)
        layers.append(replace(layer, segments=segments, chains=chains, outlines=()))
    return replace(paths, layers=tuple(layers))


def _axis_path(
    line: FloatArray, heading: FloatArray | None, offset: float, bound: float
) -> tuple[FloatArray, FloatArray | None]:
    """Where the axis goes along a line, shape (k, 2), and the direction that the blade has then."""
    sides = np.diff(line, axis=0)
    length = np.hypot(*sides.T)
    kept = length > _LEAST_MM
    if not kept.any():
        return line, heading
    starts = line[:-1][kept]
    along = sides[kept] / length[kept][:, None]
    ends = np.concatenate([starts[1:], line[-1:]])
    parts = []
    for i, (start, end) in enumerate(zip(starts, ends, strict=True)):
        before = heading if i == 0 else along[i - 1]
        if before is not None:
            parts.append(_around(start, before, along[i], offset, 0.0 if i == 0 else bound))
        parts.append(np.stack([start, end]) + offset * along[i])
    path = np.concatenate(parts)
    apart = np.hypot(*np.diff(path, axis=0).T) > _LEAST_MM
    return path[np.concatenate([[True], apart])], along[-1]


def _around(
    corner: FloatArray, before: FloatArray, after: FloatArray, offset: float, bound: float
) -> FloatArray:
    """An arc about a corner from one direction to another; nothing where they turn by less."""
    turn = float(np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after))
    if abs(turn) <= bound or not turn:
        return corner[None][:0]
    first = float(np.arctan2(before[1], before[0]))
    angle = first + turn * np.linspace(0.0, 1.0, int(np.ceil(abs(turn) / _CHORD_RAD)) + 1)
    out: FloatArray = corner + offset * np.column_stack([np.cos(angle), np.sin(angle)])
    return out
