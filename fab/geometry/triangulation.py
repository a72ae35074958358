"""Triangles over plane regions with holes, many regions at once."""

from __future__ import annotations

import numpy as np
import shapely

from solver.errors import InvalidState
from solver.vectors import FloatArray, IntArray

__all__ = ["cap_triangles", "covered"]


def covered(points: FloatArray, rings: IntArray, regions: IntArray) -> IntArray:
    """Counterclockwise triangles over regions, region by region, shape (k, 3), of their corners.

    points : shape (total, 2), no two of a region alike. rings : ring i has the points
    rings[i]:rings[i + 1]. regions : region j has the rings regions[j]:regions[j + 1], first the one
    around it, counterclockwise, then those of its holes.

    A region of n corners with h holes has n + 2 h - 2 triangles. Up to four corners without a hole
    they are a fan from the corner that gives its thinnest triangle most area; others get their
    Delaunay triangles, so that corners on a straight side make no slivers.
    """
    starts = rings[regions]
    sizes, holes = np.diff(starts), np.diff(regions) - 1
    counts = sizes + 2 * holes - 2
    ends = np.concatenate([[0], np.cumsum(counts)])
    out = np.empty((int(ends[-1]), 3), np.int64)
    few = (sizes <= 4) & (holes == 0)
    for n in np.unique(sizes[few]).tolist():
        chosen = np.flatnonzero(few & (sizes == n))
        first = starts[chosen]
        fans = _fans(points[first[:, None] + np.arange(n)]) + first[:, None, None]
        out[ends[chosen][:, None] + np.arange(n - 2)] = fans
    if not few.all():
        many = np.flatnonzero(~few)
        place = np.repeat(ends[many] - _before(counts[many]), counts[many])
        out[place + np.arange(len(place))] = _delaunay(points, rings, regions, many)
    return out


def _before(counts: IntArray) -> IntArray:
    """Sums of all counts before each."""
    return np.asarray(np.cumsum(counts) - counts)


def _fans(rings: FloatArray) -> IntArray:
    """Triangles of polygons with three or four corners, shape (k, n, 2) -> (k, n - 2, 3)."""
    n = rings.shape[1]
    fans = np.array(
        [[[s, (s + k) % n, (s + k + 1) % n] for k in range(1, n - 1)] for s in range(n)]
    )
    at = rings[:, fans]
    u, v = at[..., 1, :] - at[..., 0, :], at[..., 2, :] - at[..., 0, :]
    thinnest = (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]).min(axis=2)
    return np.asarray(fans[thinnest.argmax(axis=1)], np.int64)


def _delaunay(points: FloatArray, rings: IntArray, regions: IntArray, chosen: IntArray) -> IntArray:
    """Constrained Delaunay triangles of some regions."""
    many = np.diff(regions)[chosen]
    ring = np.repeat(regions[chosen] - _before(many), many) + np.arange(many.sum())
    sizes = np.diff(rings)[ring]
    point = np.repeat(rings[ring] - _before(sizes), sizes) + np.arange(sizes.sum())
    lines = shapely.linearrings(points[point], indices=np.repeat(np.arange(len(ring)), sizes))
    shapes = shapely.polygons(lines, indices=np.repeat(np.arange(len(chosen)), many))
    found, owner = shapely.get_parts(
        shapely.constrained_delaunay_triangles(shapes), return_index=True
    )
    # these are clockwise and closed, with the very coordinates of their corners
    places = shapely.get_coordinates(shapely.orient_polygons(found)).reshape(-1, 4, 2)[:, :3]
    x, y = np.concatenate([points[point], places.reshape(-1, 2)]).T
    region = np.repeat(np.repeat(np.arange(len(chosen)), many), sizes)
    whose = np.concatenate([region, np.repeat(owner, 3)])
    order = np.lexsort((y, x, whose))  # stable: a corner comes before the places on it
    new = np.ones(len(order), bool)
    new[1:] = (np.diff(whose[order]) != 0) | (np.diff(x[order]) != 0) | (np.diff(y[order]) != 0)
    corner = np.empty(len(order), np.int64)
    corner[order] = order[np.flatnonzero(new)[np.cumsum(new) - 1]]
    return np.asarray(point[corner[len(point) :]].reshape(-1, 3))


def cap_triangles(rings: FloatArray) -> IntArray:
    """Triangles of simple counterclockwise polygons, shape (k, n, 2) -> (k, n - 2, 3).

    They are those of `covered`. Raises `InvalidState` for polygons of more than four corners that
    cross or touch themselves.

    >>> cap_triangles(np.array([[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]])).tolist()
    [[[0, 1, 2], [0, 2, 3]]]
    """
    count, n = rings.shape[:2]
    if n > 4:
        outlines = shapely.polygons(rings)
        for wrong in outlines[~shapely.is_valid(outlines)]:
            why = shapely.is_valid_reason(wrong)
            sentence = f"a polygon crosses or touches itself ({why})"
            raise InvalidState("polygon", sentence, "Split the face.")
    starts = n * np.arange(count + 1)
    found = covered(rings.reshape(-1, 2), starts, np.arange(count + 1))
    return np.asarray(found.reshape(count, n - 2, 3) - starts[:-1, None, None])
