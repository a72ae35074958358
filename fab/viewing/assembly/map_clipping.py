"""What of a map is on its paper: areas and lines cut off at its rim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.viewing.sketch import Area, Lines, Mark, Words
from solver.vectors import FloatArray

__all__ = ["rings_of", "with_area", "within_paper"]


def within_paper(marks: Sequence[Mark], size_mm: tuple[float, float]) -> tuple[Mark, ...]:
    """What of marks is on the paper of a sketch."""
    paper = shapely.box(0, 0, *size_mm)
    out: list[Mark] = []
    for mark in marks:
        if isinstance(mark, Area):
            region = shapely.Polygon(mark.rings[0], mark.rings[1:])
            if not region.is_valid:
                region = region.buffer(0)
            for rings in rings_of(with_area(shapely.intersection(region, paper)), 0.0):
                out.append(Area(rings, mark.fill))
            if mark.edge is not None:
                sides = [np.stack([r, np.roll(r, -1, axis=0)], axis=1) for r in mark.rings]
                out.append(_clipped(Lines(np.concatenate(sides), mark.edge, mark.edge_mm), paper))
        elif isinstance(mark, Lines):
            out.append(_clipped(mark, paper))
        elif isinstance(mark, Words):
            x, y = mark.at
            if 0 <= x <= size_mm[0] and 0 <= y <= size_mm[1]:
                out.append(mark)
        else:
            out.append(mark)
    return tuple(out)


def with_area(shapes: Any) -> NDArray[np.object_]:
    """Polygons among the parts of shapes."""
    parts = np.atleast_1d(shapely.get_parts(shapes))
    out: NDArray[np.object_] = parts[shapely.area(parts) > 0]
    return out


def rings_of(region: NDArray[np.object_], tolerance: float) -> list[tuple[FloatArray, ...]]:
    """Rings of polygons, each with its holes."""
    simple = shapely.simplify(region, tolerance)
    return [
        tuple(shapely.get_coordinates(ring)[:-1] for ring in (polygon.exterior, *polygon.interiors))
        for polygon in simple
        if not polygon.is_empty
    ]


def _clipped(lines: Lines, paper: shapely.Polygon) -> Lines:
    """What of lines is within a rectangle."""
    within = shapely.intersection(shapely.linestrings(lines.segments), paper)
    kept = within[shapely.get_num_coordinates(within) == 2]
    return replace(lines, segments=shapely.get_coordinates(kept).reshape(-1, 2, 2))
