"""Surfaces with parameters: parametric and explicit ones, and turned ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solver.errors import InvalidValue
from solver.targets.base import MOST_STEPS, Target, largest_step, settled
from solver.vectors import BoolArray, FloatArray, cross, dot, numbers, unit

__all__ = ["ParametricSurface", "TurnedTarget", "explicit_surface"]


def _rows(name: str, value: object, count: int) -> FloatArray:
    """What a function of the user's returned, as (count, 3); raises `InvalidValue` otherwise."""
    array = numbers(name, value)
    if array.shape != (count, 3):
        raise InvalidValue(
            name,
            f"array of shape {array.shape}",
            f"have shape ({count}, 3)",
            "Return x, y, z of every point, for arrays u and v.",
        )
    return array


@dataclass(frozen=True)
class ParametricSurface:
    """A surface X(u, v), u and v in [-1, 1].

    Attributes
    ----------
    position : u, v of shape (n,) to points (n, 3).
    derivatives : u, v to (X_u, X_v), each (n, 3); None: central differences of `position`.
    within : u, v to whether they belong to the domain, (n,); None: the whole square does.
    """

    position: Callable[[FloatArray, FloatArray], FloatArray]
    derivatives: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]] | None = None
    within: Callable[[FloatArray, FloatArray], BoolArray] | None = None

    def places(self, uv: FloatArray) -> FloatArray:
        """The parameters themselves, shape (n, 2)."""
        return uv

    def point(self, places: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""
        return _rows("position", self.position(places[:, 0], places[:, 1]), len(places))

    def tangents(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives X_u and X_v, each of shape (n, 3)."""
        u, v = places.T
        if self.derivatives is not None:
            along_u, along_v = self.derivatives(u, v)
            return _rows("X_u", along_u, len(u)), _rows("X_v", along_v, len(u))
        h = 6e-6  # the cube root of the rounding unit: best for central differences
        steps = [(u + h, v), (u - h, v), (u, v + h), (u, v - h)]
        right, left, up, down = (_rows("position", self.position(*at), len(u)) for at in steps)
        return (right - left) / (2 * h), (up - down) / (2 * h)

    def normal(self, places: FloatArray) -> FloatArray:
        """Unit normals X_u x X_v, shape (n, 3)."""
        return unit(cross(*self.tangents(places)))

    def distance(
        self, points: FloatArray, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Signed distances along the normals (n,), normals (n, 3) and parameters (n, 2).

        NaN where no nearest point is found: beyond the centres of curvature.
        Nearest points by Gauss-Newton, which converges linearly at the rate distance x curvature:
        fast for the thin sheets of origami.
        """
        uv, before = guess, np.inf
        for _ in range(MOST_STEPS):
            along_u, along_v = self.tangents(uv)
            off = points - self.point(uv)
            e, f, g = dot(along_u, along_u), dot(along_u, along_v), dot(along_v, along_v)
            p, q = dot(off, along_u), dot(off, along_v)
            determinant = e * g - f * f
            step = np.column_stack([(g * p - f * q), (e * q - f * p)]) / determinant[:, None]
            uv = uv + step
            now = largest_step(step / (1 + np.abs(uv)))
            if settled(now, before):
                break
            before = now
        normal = unit(cross(along_u, along_v))
        # beyond the surface's centres of curvature the steps go in circles
        lost = (np.abs(step) > 1e-6 * (1 + np.abs(uv))).any(axis=1)
        return np.where(lost, np.nan, dot(points - self.point(uv), normal)), normal, uv

    def inside(self, places: FloatArray) -> BoolArray:
        """Whether |u| and |v| are at most 1, and `within` holds, shape (n,)."""
        u, v = places[:, 0], places[:, 1]
        square: BoolArray = (np.abs(u) <= 1) & (np.abs(v) <= 1)
        return square if self.within is None else square & self.within(u, v)


@dataclass(frozen=True)
class TurnedTarget:
    """A target with its parameters turned, so that a sheet grows along another direction.

    The turned parameters are shrunk so that the domain stays within [-1, 1] x [-1, 1].

    Attributes
    ----------
    target : the surface; angle : from its u direction to the new one, radians.
    """

    target: Target
    angle: float

    def _shrink(self) -> float:
        return float(abs(np.cos(self.angle)) + abs(np.sin(self.angle)))

    def _turn(self, places: FloatArray, angle: float, scale: float) -> FloatArray:
        c, s = scale * np.cos(angle), scale * np.sin(angle)
        u, v = places[:, 0], places[:, 1]
        return np.column_stack([c * u - s * v, s * u + c * v, places[:, 2:]])

    def _inner(self, places: FloatArray) -> FloatArray:
        return self._turn(places, self.angle, self._shrink())

    def _outer(self, places: FloatArray) -> FloatArray:
        return self._turn(places, -self.angle, 1 / self._shrink())

    def places(self, uv: FloatArray) -> FloatArray:
        """Places with the turned parameters `uv`, shape (n, d)."""
        return self._outer(self.target.places(self._inner(uv)))

    def point(self, places: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""
        return self.target.point(self._inner(places))

    def normal(self, places: FloatArray) -> FloatArray:
        """Unit normals, shape (n, 3)."""
        return self.target.normal(self._inner(places))

    def distance(
        self, points: FloatArray, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """As `Target.distance`, with turned places."""
        distance, gradient, places = self.target.distance(points, self._inner(guess))
        return distance, gradient, self._outer(places)

    def inside(self, places: FloatArray) -> BoolArray:
        """As `Target.inside`."""
        return self.target.inside(self._inner(places))


def explicit_surface(
    height: Callable[[FloatArray, FloatArray], FloatArray],
    half_width_x: float = 1.0,
    half_width_y: float = 1.0,
) -> ParametricSurface:
    """The surface z = height(x, y) over a rectangle about the origin.

    half_width_x, half_width_y : u = x / half_width_x and v = y / half_width_y.

    >>> bowl = explicit_surface(lambda x, y: x**2 + y**2, half_width_x=2.0)
    >>> bowl.point(np.array([[0.5, 1.0]])).tolist()
    [[1.0, 1.0, 2.0]]
    """

    def position(u: FloatArray, v: FloatArray) -> FloatArray:
        x, y = half_width_x * u, half_width_y * v
        return np.column_stack([x, y, np.broadcast_to(height(x, y), x.shape)])

    return ParametricSurface(position)
