"""Sides of faces moved inwards by setbacks: whole rings, and what is left of each side.

A side that is moved inwards ends where the sides before and after it do, or where another one of
its face crosses it.
"""

from __future__ import annotations

import numpy as np

from fab.geometry.rings import are_convex
from fab.panels.setbacks import Setbacks, Sides
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["SHORTEST_SIDE_MM", "inset", "spans"]

# A side of a panel that is shorter than this after its setbacks is none.
SHORTEST_SIDE_MM = 0.05


def inset(
    corners: FloatArray, offsets: IntArray, setback: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Polygons with each side moved inwards by its own setback.

    corners : counterclockwise rings, shape (total, 2); setback : of the side from each corner to
    the next, shape (total,). Returns the new corners, and which polygons keep all their sides in
    direction, each at least `SHORTEST_SIDE_MM` long, shape (n,).

    >>> square = np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]])
    >>> moved, kept = inset(square, np.array([0, 4]), np.array([1.0, 2.0, 0.0, 3.0]))
    >>> moved.tolist(), kept.tolist()
    ([[3.0, 1.0], [7.0, 1.0], [7.0, 9.0], [3.0, 9.0]], [True])

    With unit directions d1, d2 of the sides before and after a corner and their setbacks s1, s2,
    the corner moves by (s1 d2 - s2 d1) / (d1 x d2).
    """
    following = next_corner(offsets)
    side = corners[following] - corners
    length = np.hypot(side[:, 0], side[:, 1])
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        after = side / length[:, None]
        before = np.empty_like(after)
        before[following] = after
        s2 = setback
        s1 = np.empty_like(s2)
        s1[following] = s2
        sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        move = (s1[:, None] * after - s2[:, None] * before) / sine[:, None]
        # straight corners: both sides move alike, or there is no corner to move to
        straight = (np.abs(sine) < 1e-9) & (s1 == s2) & ((before * after).sum(axis=1) > 0)
        move[straight] = (s2[:, None] * np.column_stack([-after[:, 1], after[:, 0]]))[straight]
        moved = corners + move
        along = ((moved[following] - moved) * after).sum(axis=1)
        back = (np.abs(sine) < 1e-9) & ~straight  # where the ring turns back, or has a step
        fine = np.isfinite(along) & (along >= np.minimum(SHORTEST_SIDE_MM, length / 2)) & ~back
    kept = np.logical_and.reduceat(fine, offsets[:-1])
    return moved, kept


def spans(
    sides: Sides, back: Setbacks, z_mm: float, rows: IntArray, own_mm: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Where each of some sides begins and ends at a height, in mm from its start, shapes (k,).

    rows : shape (k,), numbers of sides. own_mm : how far inwards each is moved, shape (k,); the
    setbacks of these sides where left out.

    The moved side ends where the next one crosses it; in convex faces any other may. The start
    comes after the end where nothing is left of it.
    """
    offsets = sides.offsets
    convex = are_convex(sides.start, offsets)
    back_mm = back.at(z_mm)[sides.edges]
    own_mm = back_mm[rows] if own_mm is None else own_mm
    face = sides.faces[rows]
    low, high = np.full(len(rows), -np.inf), np.full(len(rows), np.inf)
    sizes = np.diff(offsets)[face]
    for step in range(1, int(sizes.max(initial=1))):
        active = step < sizes
        # of a face that is not convex the two neighbours alone
        active &= convex[face] | (step == 1) | (step == sizes - 1)
        own = rows[active]
        other = offsets[face[active]] + (own - offsets[face[active]] + step) % sizes[active]
        point = sides.start[own] + own_mm[active, None] * sides.inward[own]
        slope = (sides.along[own] * sides.inward[other]).sum(axis=1)
        gap = ((sides.start[other] - point) * sides.inward[other]).sum(axis=1) + back_mm[other]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / slope  # where slope * t >= gap
        parallel = np.abs(slope) < 1e-9
        shut = parallel & (gap > 1e-9)
        if not convex.all():
            reflex = ~convex[face[active]]
            # beyond a reflex corner the neighbour cuts from the other end
            first, last = step == 1, step == sizes[active] - 1
            slope = np.where(reflex, np.where(first, -1.0, np.where(last, 1.0, slope)), slope)
        t = np.where(parallel, np.nan, t)
        low[active] = np.fmax(low[active], np.where(shut, np.inf, np.where(slope > 0, t, np.nan)))
        high[active] = np.fmin(
            high[active], np.where(shut, -np.inf, np.where(slope < 0, t, np.nan))
        )
    length = sides.length_mm[rows]
    return np.where(np.isinf(low) & (low < 0), 0.0, low), np.where(high == np.inf, length, high)
