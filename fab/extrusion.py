"""Which solids stand on plane regions with holes?"""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import cKDTree

from fab.bodies import TriangleMesh
from fab.polygons import next_corner
from solver.vectors import FloatArray, IntArray

__all__ = ["circle", "extruded"]


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
    here = np.arange(count)
    there = next_corner(np.cumsum([0, *map(len, rings)]))
    top = _covered(region, flat)
    walls = [[here, there, there + count], [here, there + count, here + count]]
    triangles = np.concatenate([top[:, ::-1], top + count, *(np.stack(w, axis=1) for w in walls)])
    plane = np.concatenate([np.repeat([0, 1], len(top)), here + 2, here + 2])
    heights = np.repeat([low_mm, high_mm], count)
    return TriangleMesh(np.column_stack([np.tile(flat, (2, 1)), heights]), triangles, plane)


def _covered(region: shapely.Polygon, corners: FloatArray) -> IntArray:
    """Counterclockwise triangles over a region, by the numbers of its corners, shape (k, 3)."""
    found = shapely.orient_polygons(shapely.constrained_delaunay_triangles(region))
    places = shapely.get_coordinates(found).reshape(-1, 4, 2)[:, :3]
    return np.asarray(cKDTree(corners).query(places)[1], np.int64)
