"""Limits of insets: the thickness and scale up to which setbacks leave something of a face.

What is left of a convex face at one height are the points x with n . x >= d for all its sides. Each
d grows in proportion with a radius, a thickness or a scale, so the largest value that leaves room
is that of a linear program in three unknowns, x and the value: exact, for many faces at once.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from itertools import combinations

import numpy as np

from fab.geometry.rings import by_size
from fab.panels.setbacks import Setbacks, Sides
from solver.vectors import BoolArray, FloatArray

__all__ = [
    "inradii",
    "largest_where",
    "least_scales",
    "rounded_down",
    "rounded_up",
    "scale_bounds",
]

# Bounds found by bisection are exact to this share of themselves.
_EXACT = 1e-9
# Faces with more sides are left to a solver, one by one.
_MOST_SIDES = 12
# Sines below this are those of parallel sides.
_PARALLEL = 1e-12


def inradii(sides: Sides, setback_mm: FloatArray) -> FloatArray:
    """Radius of the widest circle behind the setbacks of each convex face, mm, shape (nf,).

    setback_mm : of every edge, shape (ne,). Negative where nothing is left: a circle would fit if
    all setbacks were less by that amount. Minus infinity behind infinite setbacks.
    """
    depth, setback = _depths(sides), setback_mm[sides.edges]
    exists = _all_finite(sides, depth + setback)
    radius = _largest(
        sides, np.where(exists[sides.faces], setback - depth, 0.0), np.ones_like(depth)
    )
    radius[~exists] = -np.inf
    return radius


def least_scales(sides: Sides, setback_mm: FloatArray, radius_mm: float) -> FloatArray:
    """The scale at which each convex face has room for a circle of a given radius, shape (nf,).

    setback_mm : of every edge, shape (ne,), the same at every scale. Infinite behind infinite
    setbacks, and for faces without area.
    """
    depth, setback = _depths(sides), setback_mm[sides.edges]
    exists = _all_finite(sides, depth + setback)
    known = exists[sides.faces]
    need = np.where(known, setback + radius_mm, 0.0)
    scale = -_largest(sides, need, np.where(known, depth, 0.0))
    scale[~exists | np.isneginf(scale)] = np.inf
    return scale


def scale_bounds(
    sides: Sides, back: Setbacks, heights_mm: tuple[float, float], radius_mm: float
) -> FloatArray:
    """The least scale at which each convex face has a panel, shape (nf,).

    heights_mm : bottom and top of the panels, over their axes. A panel is feasible where a circle
    of a given radius fits into both. Infinite where no size helps.
    """
    low, high = (least_scales(sides, back.at(z), radius_mm) for z in heights_mm)
    return np.maximum(low, high)


def largest_where(
    holds: Callable[[float], bool], low: float, high: float, exact_rel: float = _EXACT
) -> float | None:
    """The largest value between two bounds at which something holds; it holds below that as well.

    low, high : above 0. Found by bisection, to a share of itself; None where it does not even hold
    at the lower bound.

    >>> round(largest_where(lambda x: x**2 <= 2, 1.0, 1e6), 6)
    1.414214
    """
    if not holds(low):
        return None
    if holds(high):
        return high
    while high > low * (1 + exact_rel):
        # in proportion while the bounds are orders of magnitude apart
        middle = (low * high) ** 0.5 if high > 2 * low else (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def rounded_down(bound: float) -> str:
    """An upper bound in four digits, rounded to the safe side.

    >>> rounded_down(3.14159)
    '3.141'
    """
    return f"{Decimal(bound).normalize(Context(prec=4, rounding=ROUND_FLOOR)):f}"


def rounded_up(bound: float) -> str:
    """A lower bound in four digits, rounded to the safe side.

    >>> rounded_up(3.14159)
    '3.142'
    """
    return f"{Decimal(bound).normalize(Context(prec=4, rounding=ROUND_CEILING)):f}"


def _depths(sides: Sides) -> FloatArray:
    """Distance of every side from the middle of its face's corners, shape (total,)."""
    middle = np.add.reduceat(sides.start, sides.offsets[:-1])
    middle /= np.diff(sides.offsets)[:, None]
    return np.asarray(((middle[sides.faces] - sides.start) * sides.inward).sum(axis=1))


def _all_finite(sides: Sides, values: FloatArray) -> BoolArray:
    """For each face whether the values of all its sides are finite."""
    return np.asarray(np.logical_and.reduceat(np.isfinite(values), sides.offsets[:-1]))


def _largest(sides: Sides, need: FloatArray, growth: FloatArray) -> FloatArray:
    """For each face the largest v with a point x so that n . x >= need + growth v, shape (nf,).

    need, growth : of every side, shape (total,), growth at least 0. Infinite where no side grows.
    """
    out = np.empty(len(sides.offsets) - 1)
    for faces, rows in by_size(np.arange(len(need)), sides.offsets):
        if rows.shape[1] <= _MOST_SIDES:
            out[faces] = _by_triples(sides.inward[rows], need[rows], growth[rows])
        else:
            out[faces] = [_by_solver(sides.inward[r], need[r], growth[r]) for r in rows]
    return out


def _by_triples(inward: FloatArray, need: FloatArray, growth: FloatArray) -> FloatArray:
    """The dual program: shapes (k, n, 2), (k, n) and (k, n) -> (k,).

    Weights w >= 0 of the sides with sum w n = 0 bound v by -(w . need) / (w . growth), and those
    of three sides give the least bound. Three sides balance with the sines between the other two.
    """
    out = np.full(len(inward), np.inf)
    for i, j, k in combinations(range(inward.shape[1]), 3):
        pairs = ((j, k), (k, i), (i, j))
        weights = np.stack(
            [
                inward[:, a, 0] * inward[:, b, 1] - inward[:, a, 1] * inward[:, b, 0]
                for a, b in pairs
            ],
            axis=1,
        )
        weights *= np.sign(weights.sum(axis=1))[:, None]
        weights[np.abs(weights) < _PARALLEL] = 0.0
        rows = [i, j, k]
        rise = (weights * growth[:, rows]).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            bound = -(weights * need[:, rows]).sum(axis=1) / rise
        binds = (weights >= 0).all(axis=1) & (rise > 0)
        out = np.where(binds, np.minimum(out, bound), out)
    return out


def _by_solver(inward: FloatArray, need: FloatArray, growth: FloatArray) -> float:
    from scipy.optimize import linprog

    if not growth.any():
        return float("inf")
    found = linprog(
        [0.0, 0.0, -1.0],
        np.column_stack([-inward, growth]),
        -need,
        bounds=[(None, None)] * 3,
        method="highs-ds",
    )
    return float(found.x[2]) if found.status == 0 else -float("inf")
