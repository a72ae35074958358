"""Bodies near each other, and planes that show how far they are apart.

The bodies of a pair are apart by at least as much as their shadows on any line are: this holds for
bodies of any shape, and is exact for the right line where both are convex.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from fab.geometry.bodies import Bodies
from solver.vectors import FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["apart_along", "apart_at_least", "near_pairs"]

# Coordinates compared at a time: this bounds the memory, not the answer.
_AT_ONCE = 3_000_000
# Steps towards the nearest points of two bodies; what they leave undecided needs exact distances.
_STEPS = 12


def near_pairs(bodies: Bodies, reach_mm: float) -> IntArray:
    """Pairs (i < j) of bodies whose boxes come within `reach_mm` of each other, sorted, (n, 2)."""
    if not len(bodies):
        return np.empty((0, 2), np.int64)
    low, high = bodies.boxes()
    low, high = low - reach_mm / 2, high + reach_mm / 2
    thin, *wide = np.argsort(high.max(axis=0) - low.min(axis=0), kind="stable").tolist()
    boxes = shapely.box(low[:, wide[0]], low[:, wide[1]], high[:, wide[0]], high[:, wide[1]])
    first, second = shapely.STRtree(boxes).query(boxes)
    near = (
        (first < second)
        & (low[first, thin] <= high[second, thin])
        & (low[second, thin] <= high[first, thin])
    )
    pairs = np.column_stack([first[near], second[near]])
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def apart_along(bodies: Bodies, pairs: IntArray, directions: FloatArray) -> FloatArray:
    """Distances of the shadows of both bodies of each pair on a line, mm, negative where they meet.

    pairs, directions : shapes (n, 2) and (n, 3), the latter of length 1; NaN gives -inf.
    """
    first, second = (_shadows(bodies, pairs[:, k], directions) for k in (0, 1))
    out = np.maximum(first[0] - second[1], second[0] - first[1])
    return np.where(np.isnan(out), -np.inf, out)


def apart_at_least(bodies: Bodies, pairs: IntArray, wanted_mm: FloatArray) -> FloatArray:
    """Distances between the bodies of each pair, as far as planes show them, mm, shape (n,).

    First between their boxes, then along the sides of both bodies; those pairs that these do not
    show to be `wanted_mm` apart also across lines ever closer to the one between their nearest
    points. Negative where no plane separates them: then their sides reach into each other by at
    most as much.
    """
    low, high = bodies.boxes()
    first, second = pairs.T
    best: FloatArray = np.maximum(low[first] - high[second], low[second] - high[first]).max(axis=1)
    normals, offsets, heights = _sides(bodies, np.unique(pairs[best < wanted_mm]))
    for own, other in ((0, 1), (1, 0)):
        undecided = np.flatnonzero(best < wanted_mm)
        bodies_own = pairs[undecided, own]
        counts = np.diff(offsets)[bodies_own]
        ends = np.cumsum(counts)
        pair = np.repeat(undecided, counts)
        side = np.arange(len(pair)) + np.repeat(offsets[bodies_own] - (ends - counts), counts)
        nearest, _ = _shadows(bodies, pairs[pair, other], normals[side])
        np.maximum.at(best, pair, nearest - heights[side])
    undecided = np.flatnonzero(best < wanted_mm)
    best[undecided] = np.maximum(
        best[undecided], _walked(bodies, pairs[undecided], wanted_mm[undecided])
    )
    return best


def _walked(bodies: Bodies, pairs: IntArray, wanted_mm: FloatArray) -> FloatArray:
    """The nearest point to the origin of all differences of points, by Frank and Wolfe's method."""
    best = np.full(len(pairs), -np.inf)
    first, second = pairs.T
    middles = np.add.reduceat(bodies.vertices_coords, bodies.vertices_offsets[:-1])
    middles /= np.diff(bodies.vertices_offsets)[:, None]
    x = middles[first] - middles[second]
    active = np.arange(len(pairs))
    for _ in range(_STEPS):
        along = unit(x[active])
        corner = _corners(bodies, first[active], -along) - _corners(bodies, second[active], along)
        bound = dot(along, corner)
        best[active] = np.fmax(best[active], bound)
        step = corner - x[active]
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.clip(-dot(x[active], step) / dot(step, step), 0.0, 1.0)
        x[active] += share[:, None] * step
        # done where decided, and where the bodies meet
        more = (best[active] < wanted_mm[active]) & (norm(x[active]) > 1e-9) & (share > 0)
        active = active[more]
    return best


def _sides(bodies: Bodies, chosen: IntArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """Outward normals of the planar sides of chosen bodies, each body's first, farthest points.

    Shapes (k, 3), (n + 1,) and (k,): the largest coordinate of the body along each normal.
    """
    asked = np.zeros(len(bodies), bool)
    asked[chosen] = True
    owner = bodies.triangles_body
    triangles = np.flatnonzero(asked[owner])
    owner = owner[triangles]
    a, b, c = bodies.vertices_coords[bodies.triangles[triangles]].swapaxes(0, 1)
    twice = cross(b - a, c - a)
    order = np.lexsort((norm(twice), bodies.triangles_plane[triangles], owner))
    plane = bodies.triangles_plane[triangles][order]
    # the largest triangle of each plane is the last of its run
    last = np.ones(len(order), bool)
    last[:-1] = (plane[1:] != plane[:-1]) | (np.diff(owner[order]) > 0)
    largest = order[last]
    normals = unit(twice[largest])
    has_area = np.isfinite(normals).all(axis=1)
    largest, normals = largest[has_area], normals[has_area]
    offsets = np.searchsorted(owner[largest], np.arange(len(bodies) + 1))
    return normals, offsets, _shadows(bodies, owner[largest], normals)[1]


def _shadows(
    bodies: Bodies, chosen: IntArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Least and largest coordinate along a direction of a body, row by row, shapes (k,)."""
    low, high = np.empty(len(chosen)), np.empty(len(chosen))
    for rows, corners in _rows(bodies, chosen):
        along = np.squeeze(corners @ directions[rows][:, :, None], axis=2)
        low[rows], high[rows] = along.min(axis=1), along.max(axis=1)
    return low, high


def _corners(bodies: Bodies, chosen: IntArray, directions: FloatArray) -> FloatArray:
    """The vertex of a body that lies farthest along a direction, row by row, shape (k, 3)."""
    out = np.empty((len(chosen), 3))
    for rows, corners in _rows(bodies, chosen):
        along = np.squeeze(corners @ directions[rows][:, :, None], axis=2)
        out[rows] = corners[np.arange(len(rows)), along.argmax(axis=1)]
    return out


def _rows(bodies: Bodies, chosen: IntArray) -> Iterator[tuple[IntArray, FloatArray]]:
    """Rows whose bodies have equally many vertices, a part at a time, and these (k, n, 3)."""
    sizes = np.diff(bodies.vertices_offsets)[chosen]
    for n in np.unique(sizes).tolist():
        members = np.flatnonzero(sizes == n)
        for part in np.array_split(members, len(members) * n // _AT_ONCE + 1):
            first = bodies.vertices_offsets[chosen[part]]
            yield part, bodies.vertices_coords[first[:, None] + np.arange(n)]
