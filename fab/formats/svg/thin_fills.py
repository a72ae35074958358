"""Filled shapes that are outlines of drawn lines, as "stroke to path" of drawing programs makes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.formats.svg.shapes import Drawn
from fab.formats.svg.tree import Shape
from solver.vectors import FloatArray

__all__ = ["outlines_of_strokes"]

# Strokes are thinner than this, over the diagonal of the drawing, and many times as long as wide.
_THIN_REL = 0.01
_SLENDER = 8.0
# Coordinates beyond it are refused later.
_FARTHEST = 1e9
# Rings of one shape; their places in each other are worked out.
_MOST_RINGS = 1_000
_SLITS = frozenset({"B", "C"})


def outlines_of_strokes(
    shapes: Sequence[Shape], diagonal: float
) -> tuple[tuple[Shape, float], ...]:
    """The filled shapes that are outlines of strokes, and how wide each stroke is.

    A slit is as thin as a stroke: thin shapes with the letter of a border or cut are none where
    they lie within a wider shape, the sheet.

    diagonal : of the box around all shapes.
    """
    thin, wide = [], []
    for shape in shapes:
        width = _stroke_width(shape.drawn, _THIN_REL * diagonal)
        if width is None:
            wide.append(shape)
        else:
            thin.append((shape, width))
    if not thin:
        return ()
    sheets = shapely.STRtree([_box(shape.drawn) for shape in wide])
    return tuple(
        (shape, width)
        for shape, width in thin
        if shape.letter not in _SLITS
        or not len(sheets.query(_box(shape.drawn), predicate="covered_by"))
    )


def _box(drawn: Drawn) -> shapely.Polygon:
    points = np.concatenate([np.array(run) for run in drawn.runs])
    return shapely.box(*points.min(axis=0), *points.max(axis=0))


def _stroke_width(drawn: Drawn, most: float) -> float | None:
    """The mean width of a shape that is closed, slender and thinner than `most`; None for others.

    A shape without area is a line, and one that crosses itself is no outline.
    """
    if not all(len(run) > 3 and run[0] == run[-1] for run in drawn.runs):
        return None
    rings = [np.array(run) for run in drawn.runs]
    if not all((np.abs(ring) <= _FARTHEST).all() for ring in rings):
        return None
    length = float(sum(np.hypot(*np.diff(ring, axis=0).T).sum() for ring in rings))
    widest = min(most, length / (2 * _SLENDER))
    if len(rings) == 1 and abs(_area(rings[0])) * 2 >= widest * length:
        return None
    polygons = np.array([shapely.polygons(ring) for ring in rings])
    if len(rings) > _MOST_RINGS or not shapely.is_valid(polygons).all():
        return None
    area = abs(_filled_area(polygons))
    return 2 * area / length if 0 < 2 * area < widest * length else None


def _filled_area(polygons: NDArray[np.object_]) -> float:
    """The area of rings that do not cross, each a hole in the one around it."""
    corners = shapely.points([polygon.exterior.coords[0] for polygon in polygons])
    _, inside = shapely.STRtree(corners).query(polygons, predicate="contains")
    depth = np.bincount(inside, minlength=len(polygons))
    return float(np.where(depth % 2, -1.0, 1.0) @ shapely.area(polygons))


def _area(ring: FloatArray) -> float:
    x, y = (ring - ring[0]).T
    return float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) / 2
