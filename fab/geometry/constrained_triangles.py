"""Triangles over points of the plane, with given edges among their sides."""

from __future__ import annotations

from collections import deque
from fractions import Fraction

import numpy as np
from scipy.spatial import Delaunay, QhullError

from solver.vectors import FloatArray, IntArray

__all__ = ["triangle_sides"]

# Corners of a square around all points, so far from their middle, over their size.
_AROUND = 10.0
# Of what a determinant is the difference of: below this share, its sign is computed exactly.
_ROUNDING = 4e-16


def triangle_sides(points: FloatArray, edges: IntArray) -> IntArray:
    """Sides of triangles over all points, shape (n, 2), the edges among them where they can be.

    points : shape (m, 2), all different. edges : shape (ne, 2), which must not cross. Those that
    pass points, but for their ends, are sides from point to point.

    Delaunay triangles, of which those that an edge crosses are changed by flips (Sloan 1993, A fast
    algorithm for generating constrained Delaunay triangulations), with signs that are exact. No
    sides where points are so near to each other that their digits leave no such triangles.
    """
    nothing = np.empty((0, 2), np.int64)
    if not len(edges):
        return nothing
    size = float(np.ptp(points, axis=0).max())
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    around = _AROUND * size * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    local = np.concatenate([points - middle, around])
    try:
        triangles = Delaunay(local).simplices
    except QhullError:
        return nothing
    mesh = _Triangles(local, triangles)
    if not mesh.fine:
        return nothing
    for first, second in edges.tolist():
        mesh.insert(first, second)
    sides = mesh.sides()
    out: IntArray = sides[(sides < len(points)).all(axis=1)]
    return out


class _Triangles:
    """Triangles by their directed sides: the corner on the left of each.

    Attributes
    ----------
    fine : whether they have an area, lie beside each other, and reach all points.
    """

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        self._points = points.tolist()
        self._count = len(points)
        a, b, c = np.asarray(triangles, np.int64).T
        u, v = points[b] - points[a], points[c] - points[a]
        left, right = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
        sign = left - right
        close = np.flatnonzero(np.abs(sign) <= 4 * _ROUNDING * (np.abs(left) + np.abs(right)))
        for row in close.tolist():
            sign[row] = self._turn(int(a[row]), int(b[row]), int(c[row]))
        turned = sign < 0
        b, c = np.where(turned, c, b), np.where(turned, b, c)
        keys = np.concatenate([a * self._count + b, b * self._count + c, c * self._count + a])
        self._apex = dict(zip(keys.tolist(), np.concatenate([c, a, b]).tolist(), strict=True))
        # one corner of a triangle at each point
        self._spoke = np.full(self._count, -1)
        self._spoke[a], self._spoke[b], self._spoke[c] = b, c, a
        alone = len(self._apex) == len(keys)
        # Euler: so many triangles, where the four corners around all points are the only outer ones
        whole = len(triangles) == 2 * self._count - 6 and bool((self._spoke >= 0).all())
        self.fine = alone and whole and bool(sign.all())

    def sides(self) -> IntArray:
        """Each side once, lower number first, shape (n, 2), rising."""
        keys = np.fromiter(self._apex, np.int64, len(self._apex))
        sides = np.column_stack(np.divmod(np.sort(keys), self._count))
        out: IntArray = sides[sides[:, 0] < sides[:, 1]]
        return out

    def insert(self, first: int, second: int) -> None:
        """Make the line between two points a side, or several where it passes points."""
        while first != second and first * self._count + second not in self._apex:
            crossed, reached = self._crossed(first, second)
            self._flip_away(first, reached, crossed)
            first = reached

    def _turn(self, a: int, b: int, c: int) -> float:
        """Positive where c is on the left of the line from a to b; the sign is exact."""
        (ax, ay), (bx, by), (cx, cy) = self._points[a], self._points[b], self._points[c]
        left, right = (ax - cx) * (by - cy), (ay - cy) * (bx - cx)
        out = left - right
        if abs(out) > _ROUNDING * (abs(left) + abs(right)):
            return float(out)
        ax, ay, bx, by, cx, cy = map(Fraction, (ax, ay, bx, by, cx, cy))
        exact = (ax - cx) * (by - cy) - (ay - cy) * (bx - cx)
        return float((exact > 0) - (exact < 0))

    def _crossed(self, first: int, second: int) -> tuple[deque[tuple[int, int]], int]:
        """Sides that the line crosses, until it comes to its end or another point: that point.

        Each is given with its end on the right of the line first.
        """
        apex, count = self._apex, self._count
        right = int(self._spoke[first])
        side = self._turn(first, right, second)
        while True:
            left = apex[first * count + right]
            other = self._turn(first, left, second)
            if side >= 0 > other:
                break
            right, side = left, other
        out: deque[tuple[int, int]] = deque()
        if side == 0:  # ahead of it, as the line turns from left to right there
            return out, right
        while True:
            out.append((right, left))
            ahead = apex[left * count + right]
            if ahead == second:
                return out, ahead
            side = self._turn(first, second, ahead)
            if side == 0:
                return out, ahead
            if side > 0:
                left = ahead
            else:
                right = ahead

    def _flip_away(self, first: int, second: int, crossed: deque[tuple[int, int]]) -> None:
        """Flip sides, which the line between two points crosses, until it is one itself."""
        apex, count = self._apex, self._count
        while crossed:
            a, b = crossed.popleft()
            c, d = apex[a * count + b], apex[b * count + a]
            if not self._turn(c, d, a) < 0 < self._turn(c, d, b):  # not convex, as yet
                crossed.append((a, b))
                continue
            del apex[a * count + b], apex[b * count + a]
            for u, v, w in ((a, d, c), (d, b, c)):
                apex[u * count + v], apex[v * count + w], apex[w * count + u] = w, u, v
                self._spoke[u], self._spoke[v], self._spoke[w] = v, w, u
            if c in (first, second) or d in (first, second):
                continue
            one, other = self._turn(first, second, c), self._turn(first, second, d)
            if (one < 0) != (other < 0):
                crossed.append((c, d) if one < 0 else (d, c))
