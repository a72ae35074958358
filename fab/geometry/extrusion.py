"""Which solids stand on plane regions with holes?"""

from __future__ import annotations

import numpy as np
import shapely

from fab.geometry.bodies import TriangleMesh
from fab.geometry.rings import next_corner
from fab.geometry.triangulation import covered
from solver.vectors import FloatArray, IntArray

__all__ = ["circle", "extruded", "walls"]


def circle(centre: FloatArray, radius: float, sides: int, *, around: bool) -> shapely.Polygon:
    """A regular polygon around a circle (its sides touch it) or within it (its corners do)."""
    turn = (np.arange(sides) + 0.5) * 2 * np.pi / sides
    far = radius / np.cos(np.pi / sides) if around else radius
    return shapely.Polygon(centre + far * np.column_stack([np.cos(turn), np.sin(turn)]))


def extruded(region: shapely.Polygon, low_mm: float, high_mm: float) -> TriangleMesh:
    """The solid over a region between two heights.

    Its planar sides are numbered: bottom, top, then one for each corner of its rings.
    """
    region = shapely.orient_polygons(region)
    rings = [shapely.get_coordinates(ring)[:-1] for ring in (region.exterior, *region.interiors)]
    flat = np.concatenate(rings)
    count = len(flat)
    here, offsets = np.arange(count), np.cumsum([0, *map(len, rings)])
    there = next_corner(offsets)
    top = covered(flat, offsets, np.array([0, len(rings)]))
    triangles = np.concatenate([top[:, ::-1], top + count, walls(here, there, count)])
    plane = np.concatenate([np.repeat([0, 1], len(top)), here + 2, here + 2])
    heights = np.repeat([low_mm, high_mm], count)
    return TriangleMesh(np.column_stack([np.tile(flat, (2, 1)), heights]), triangles, plane)


def walls(here: IntArray, there: IntArray, count: int) -> IntArray:
    """Triangles that stand on edges with a region on their left, seen from outside, (2 n, 3).

    here, there : shape (n,), the corners at the bottom; `count` further on are those at the top.
    """
    return np.concatenate(
        [
            np.column_stack([here, there, there + count]),
            np.column_stack([here, there + count, here + count]),
        ]
    )
