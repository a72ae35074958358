"""Solids over plane regions with holes, and the walls between two heights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fab.geometry.bodies import TriangleMesh
from fab.geometry.triangulation import covered
from solver.polygons import next_corner
from solver.vectors import FloatArray, IntArray

__all__ = ["circle", "extruded", "extruded_parts", "walls"]


def circle(centre: FloatArray, radius: float, sides: int, *, around: bool) -> shapely.Polygon:
    """A regular polygon around a circle (its sides touch it) or within it (its corners do)."""
    turn = (np.arange(sides) + 0.5) * 2 * np.pi / sides
    far = radius / np.cos(np.pi / sides) if around else radius
    return shapely.Polygon(centre + far * np.column_stack([np.cos(turn), np.sin(turn)]))


def extruded(region: shapely.Polygon, low_mm: float, high_mm: float) -> TriangleMesh:
    """The solid over a region between two heights.

    Its planar sides are numbered: bottom, top, then one for each corner of its rings.

    >>> plate = extruded(shapely.box(0, 0, 5, 5).difference(shapely.box(1, 1, 2, 2)), 0.0, 1.0)
    >>> len(plate.vertices_coords), len(np.unique(plate.triangles_plane))
    (16, 10)
    """
    region = shapely.orient_polygons(region)
    rings = [shapely.get_coordinates(ring)[:-1] for ring in (region.exterior, *region.interiors)]
    flat = np.concatenate(rings)
    count = len(flat)
    corners, offsets = np.arange(count), np.cumsum([0, *map(len, rings)])
    top = covered(flat, offsets, np.array([0, len(rings)]))
    sides = walls(corners, next_corner(offsets), count)
    triangles = np.concatenate([top[:, ::-1], top + count, sides])
    plane = np.concatenate([np.repeat([0, 1], len(top)), corners + 2, corners + 2])
    heights = np.repeat([low_mm, high_mm], count)
    return TriangleMesh(np.column_stack([np.tile(flat, (2, 1)), heights]), triangles, plane)


def extruded_parts(
    regions: Sequence[shapely.Polygon], low_mm: float, high_mm: float
) -> TriangleMesh:
    """The solid over regions that share borders with the same corners, between two heights.

    Its planar sides are numbered: bottom and top of each region, then one for each side of a region
    that no other one shares.

    >>> halves = [shapely.box(0, 0, 5, 5), shapely.box(5, 0, 9, 5)]
    >>> plate = extruded_parts(halves, 0.0, 1.0)
    >>> len(plate.vertices_coords), len(np.unique(plate.triangles_plane))
    (12, 10)
    """
    rings, first = [], [0]
    for region in map(shapely.orient_polygons, regions):
        rings += [shapely.get_coordinates(ring)[:-1] for ring in shapely.get_parts(region.boundary)]
        first.append(len(rings))
    flat, offsets = np.concatenate(rings), np.cumsum([0, *map(len, rings)])
    own = covered(flat, offsets, np.array(first))
    owner = np.repeat(np.arange(len(regions)), offsets[np.array(first)][1:] - offsets[first[:-1]])
    points, number = np.unique(flat, axis=0, return_inverse=True)
    number, count = number.ravel(), len(points)
    start, end = number, number[next_corner(offsets)]
    shared = np.isin(start * count + end, end * count + start)
    outer = np.flatnonzero(~shared)
    top, region_of = number[own], owner[own[:, 0]]
    sides = walls(start[outer], end[outer], count)
    triangles = np.concatenate([top[:, ::-1], top + count, sides])
    wall = 2 * len(regions) + np.arange(len(outer))
    plane = np.concatenate([2 * region_of, 2 * region_of + 1, wall, wall])
    heights = np.repeat([low_mm, high_mm], count)
    return TriangleMesh(np.column_stack([np.tile(points, (2, 1)), heights]), triangles, plane)


def walls(start: IntArray, end: IntArray, count: int) -> IntArray:
    """Triangles of the walls on edges with a region on their left, seen from outside, (2 n, 3).

    start, end : shape (n,), corners at the bottom; those at the top have numbers higher by `count`.
    """
    return np.concatenate(
        [
            np.column_stack([start, end, end + count]),
            np.column_stack([start, end + count, start + count]),
        ]
    )
