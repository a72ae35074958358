"""Implicit surfaces: where a function of space is zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.targets.frame import Frame
from solver.vectors import BoolArray, FloatArray, cross, dot, norm, unit

__all__ = ["ImplicitSurface"]

# Heights at which the function is looked at along a line; steps towards the nearest point.
_HEIGHTS = 257
_APPROACH = 4
_STEPS = 60
_EXACT = 1e-15
# Steps of this size, in half diagonals of the box, are on the way to the nearest point.
_NEAR = 1e-6


@dataclass(frozen=True)
class ImplicitSurface:
    """The surface value(points) = 0 within a box; normals point to where the value is positive.

    Places are (u, v, x, y, z). The surface goes on beyond the box as the function does.

    Attributes
    ----------
    value : points (n, 3) to numbers (n,).
    frame : the box. Of several sheets the uppermost counts, where they lie further apart than the
        box's height / 128.
    gradient : points (n, 3) to the gradients (n, 3) of `value`; None: central differences of it,
        with an error of about 1e-10 of the box, as have the directions of normals.

    >>> def sphere(points):
    ...     return (points**2).sum(axis=1) - 1
    >>> surface = ImplicitSurface(sphere, Frame.along([0, 0, 1]), lambda points: 2 * points)
    >>> places = surface.places(np.array([[0.6, 0.0]]))
    >>> surface.point(places).round(12).tolist()
    [[0.6, 0.0, 0.8]]
    >>> surface.distance(np.array([[0.0, 0.0, 3.0]]), places)[0].round(12).tolist()
    [2.0]
    """

    value: Callable[[FloatArray], FloatArray]
    frame: Frame
    gradient: Callable[[FloatArray], FloatArray] | None = None

    def gradients(self, points: FloatArray) -> FloatArray:
        """Gradients of the function, shape (n, 3)."""
        if self.gradient is not None:
            return self.gradient(points)
        # the cube root of the rounding unit is the best step for central differences
        return self._differences(self.value, points, 6e-6)

    def places(self, uv: FloatArray) -> FloatArray:
        """Places (n, 5) with the parameters `uv`, on the uppermost sheet in the box.

        NaN but for u and v where the line upwards does not meet the surface in the box.
        """
        count = len(uv)
        heights = np.linspace(1.01, -1.01, _HEIGHTS)  # a surface may touch the box
        lines = np.empty((count, _HEIGHTS, 3))
        lines[:, :, :2], lines[:, :, 2] = uv[:, None], heights
        values = self.value(self.frame.points(lines).reshape(-1, 3)).reshape(count, _HEIGHTS)
        above = values > 0
        change = above[:, 1:] != above[:, :-1]
        first = change.argmax(axis=1)
        high, low = heights[first], heights[first + 1]
        beyond = above[np.arange(count), first]
        for _ in range(_STEPS):  # halves the interval down to neighbouring numbers
            middle = (high + low) / 2
            at = self.frame.points(np.column_stack([uv, middle]))
            same = (self.value(at) > 0) == beyond
            high, low = np.where(same, middle, high), np.where(same, low, middle)
        height = np.where(change.any(axis=1), (high + low) / 2, np.nan)
        return np.column_stack([uv, self.frame.points(np.column_stack([uv, height]))])

    def point(self, places: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""
        return places[:, 2:]

    def normal(self, places: FloatArray) -> FloatArray:
        """Unit normals, shape (n, 3)."""
        return unit(self.gradients(places[:, 2:]))

    def distance(
        self, points: FloatArray, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Signed distances (n,), their gradients (n, 3) and the nearest places (n, 5).

        Newton on the conditions of Lagrange, x - p + l grad g(x) = 0 and g(x) = 0, from the guess;
        the second derivatives are differences of the gradient, which only cost speed. Exact to
        rounding where the gradient is given; NaN where the steps do not settle.
        """
        x = guess[:, 2:]
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for _ in range(_APPROACH):
                slope = self.gradients(x)
                off = points - x
                size = dot(slope, slope)
                x = x + off - ((dot(off, slope) + self.value(x)) / size)[:, None] * slope
            scale = float(norm(self.frame.half_widths))
            multiplier, last = np.zeros(len(x)), np.full(len(x), np.inf)
            for step in range(_STEPS):
                slope = self.gradients(x)
                if step == 0:
                    multiplier = dot(points - x, slope) / dot(slope, slope)
                curved = multiplier[:, None, None] * self._second(x) + np.eye(3)
                miss = x - points + multiplier[:, None] * slope
                by_slope, by_miss = _solved(curved, slope), _solved(curved, miss)
                change = (self.value(x) - dot(slope, by_miss)) / dot(slope, by_slope)
                move = -by_miss - change[:, None] * by_slope
                x, multiplier = x + move, multiplier + change
                size = norm(move)
                # down to rounding, or to the error of differences, where steps shrink no longer
                settled = (size <= _EXACT * scale) | ((size > last / 2) & (size < _NEAR * scale))
                if (settled | ~np.isfinite(size)).all():
                    break
                last = size
            lost = ~(size <= _NEAR * scale)
            normal = unit(self.gradients(x))
            x, normal = np.where(lost[:, None], np.nan, x), np.where(lost[:, None], np.nan, normal)
        places = np.column_stack([self.frame.coordinates(x)[:, :2], x])
        return dot(points - x, normal), normal, places

    def inside(self, places: FloatArray) -> BoolArray:
        """Whether places are in the square of the parameters, shape (n,)."""
        inside: BoolArray = np.abs(places[:, :2]).max(axis=1) <= 1 + 1e-9
        return inside & ~np.isnan(places[:, 2])

    def _second(self, points: FloatArray) -> FloatArray:
        """Second derivatives by differences of the gradient, made symmetric, shape (n, 3, 3)."""
        step = 6e-6 if self.gradient is not None else 1e-3  # differences of differences: coarser
        rows = self._differences(self.gradients, points, step)
        return (rows + rows.swapaxes(1, 2)) / 2

    def _differences(
        self, function: Callable[[FloatArray], FloatArray], points: FloatArray, step: float
    ) -> FloatArray:
        """Central differences along x, y, z, as the last axis; `step` in widths of the box."""
        h = step * float(self.frame.half_widths.max())
        out: FloatArray = np.stack(
            [(function(points + e) - function(points - e)) / (2 * h) for e in h * np.eye(3)],
            axis=-1,
        )
        return out


def _solved(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions (n, 3) of symmetric 3 x 3 systems by Cramer's rule; singular ones give NaN."""
    a, b, c = matrices[:, 0], matrices[:, 1], matrices[:, 2]
    bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
    top = right[:, :1] * bc + right[:, 1:2] * ca + right[:, 2:] * ab
    out: FloatArray = top / dot(a, bc)[:, None]
    return out
