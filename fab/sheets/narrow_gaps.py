"""Gaps in outlines that are narrower than the kerf, and the lines along which they are cut.

The beam clears what its disc reaches from the moved outline; what is left of a hole, or of a notch
between two sides of an outline, is cut along its middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.geometry.centre_lines import centre_lines
from fab.sheets.crease_cuts import SHORTEST_CUT_MM
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Gaps", "narrow_gaps"]

Shapes = NDArray[np.object_]

# Narrower ones are rounding, mm.
_LEAST_WIDTH_MM = 1e-7
# Moved outlines are simplified by up to 1 % of the distance: by more than that, in kerfs, what the
# beam reaches is taken for larger.
_SIMPLIFIED = 0.01
# Corners of holes are cut as they come out where they are nearer to the moved outline than this, in
# kerfs: the beam clears half a kerf, and as much again is not worth a cut.
_NEAR = 1.2
# Points nearer to an outline than this share of the largest coordinate are on it.
_ON_REL = 1e-9
# A gap is open over less than this share of its length; what is rounded off a corner, or smoothed
# along a bend, is open over more.
_OPEN_REL = 0.5


@dataclass(frozen=True)
class Gaps:
    """What is cut along centre lines.

    Attributes
    ----------
    segments : shape (n, 2, 2), mm, joined to chains; pierces are as long as the shortest cut.
    owner, line : the outline that each is of, and its centre line, shape (n,), rising.
    """

    segments: FloatArray
    owner: IntArray
    line: IntArray


def narrow_gaps(
    shapes: Shapes, moved: Shapes, outer: BoolArray, kerf_mm: float, plain: BoolArray
) -> Gaps:
    """The gaps of outlines that the beam on the moved outlines leaves uncut.

    Parameters
    ----------
    shapes, moved : polygons within outlines, before and after they are moved by half the kerf.
    outer : which are material; the others are holes, shape (n,).
    plain : which do not cross themselves; the others have no gaps, shape (n,).
    """
    chosen = np.flatnonzero(plain)
    chosen = chosen[_may_have(shapes[chosen], moved[chosen], outer[chosen], kerf_mm)]
    inward = outer[chosen]
    reach = kerf_mm * (0.5 + _SIMPLIFIED)
    reached = shapely.buffer(moved[chosen], np.where(inward, -reach, reach))
    left = shapely.difference(
        np.where(inward, reached, shapes[chosen]), np.where(inward, shapes[chosen], reached)
    )
    parts, of = shapely.get_parts(left, return_index=True)
    size = _sizes(parts)
    wide = (size > 0) & (shapely.area(parts) > _LEAST_WIDTH_MM * size)
    wide &= shapely.get_dimensions(parts) == 2
    numbers = chosen[of]
    lost = shapely.is_empty(moved)[numbers]
    segments, owner, line = [], [], []
    count = 0
    for part in np.flatnonzero(wide & (lost | (size > kerf_mm))).tolist():
        number = int(numbers[part])
        found = (
            _hole_lines(parts[part], kerf_mm)
            if lost[part]
            else _notch_lines(parts[part], shapes[number], kerf_mm)
        )
        for points in found:
            segments.append(np.stack([points[:-1], points[1:]], axis=1))
            owner.append(np.full(len(points) - 1, number))
            line.append(np.full(len(points) - 1, count))
            count += 1
    if not segments:
        return Gaps(np.empty((0, 2, 2)), np.empty(0, np.int64), np.empty(0, np.int64))
    return Gaps(np.concatenate(segments), np.concatenate(owner), np.concatenate(line))


def _may_have(shapes: Shapes, moved: Shapes, outer: BoolArray, kerf_mm: float) -> BoolArray:
    """Which outlines may have a gap, shape (n,): not the convex ones without deep corners."""
    convex = shapely.area(shapely.convex_hull(shapes)) <= shapely.area(shapes) * (1 + 1e-12)
    near = shapely.hausdorff_distance(shapes, moved) <= _NEAR * kerf_mm  # false for vanished ones
    return np.asarray(~(convex & (outer | near)))


def _sizes(parts: Shapes) -> FloatArray:
    """Diagonals of the boxes around figures, shape (n,)."""
    low_x, low_y, high_x, high_y = shapely.bounds(parts).T
    return np.asarray(np.nan_to_num(np.hypot(high_x - low_x, high_y - low_y)))


def _hole_lines(hole: shapely.Polygon, kerf_mm: float) -> list[FloatArray]:
    """Centre lines of a whole hole, each of shape (k, 2); a pierce in one no longer than the kerf.

    A pierce is a cut of the least length in the middle.
    """
    lines = centre_lines(hole, kerf_mm)
    if _length(lines) > kerf_mm:
        return lines
    middle = shapely.get_coordinates(shapely.maximum_inscribed_circle(hole))[0]
    return [middle + np.array([[-0.5, 0.0], [0.5, 0.0]]) * SHORTEST_CUT_MM]


def _notch_lines(part: shapely.Polygon, shape: shapely.Polygon, kerf_mm: float) -> list[FloatArray]:
    """Centre lines of a gap, each of shape (k, 2); none where it is the rest of a corner.

    part : the gap, short of what the beam reaches by what outlines may be simplified by.
    """
    if _widest_mouth(part, shape) > _OPEN_REL * float(_sizes(np.array([part]))[0]):
        return []
    lines = centre_lines(part, kerf_mm)
    if _length(lines) <= kerf_mm:
        return []
    near = _ON_REL * float(np.abs(part.bounds).max())
    for line in lines:
        for end, inner in ((0, 1), (-1, -2)):
            point = shapely.points(line[end])
            if part.boundary.distance(point) < near < shape.boundary.distance(point):
                span = line[end] - line[inner]
                line[end] += _SIMPLIFIED * kerf_mm / np.hypot(*span) * span
    return lines


def _length(lines: list[FloatArray]) -> float:
    return sum(float(np.hypot(*np.diff(line, axis=0).T).sum()) for line in lines)


def _widest_mouth(part: shapely.Polygon, shape: shapely.Polygon) -> float:
    """Distance between the ends of the longest run of a part's sides that are off the outline."""
    ring = shapely.get_coordinates(part.exterior)
    middles = shapely.points((ring[:-1] + ring[1:]) / 2)
    near = _ON_REL * float(np.abs(ring).max())
    off = shapely.distance(middles, shape.boundary) > near
    if off.all() or not off.any():
        return float(np.inf) if off.all() else 0.0
    first = int(np.flatnonzero(~off)[0])
    off, ring = np.roll(off, -first), np.roll(ring[:-1], -first, axis=0)
    change = np.diff(off.astype(int), append=0)
    begin, end = np.flatnonzero(change == 1) + 1, np.flatnonzero(change == -1) + 1
    spans = ring[end % len(ring)] - ring[begin]
    return float(np.hypot(*spans.T).max())
