"""Which surface shall a sheet follow: its points, its normals, and where a ray meets its offset?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.vectors import BoolArray, FloatArray, cross, dot, unit

__all__ = ["ParametricSurface", "Target", "explicit_surface"]

_STEPS = 60
_EXACT = 1e-14


class Target(Protocol):
    """What surface fitting asks of a surface. Parameters `uv` have shape (n, 2)."""

    def point(self, uv: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""

    def normal(self, uv: FloatArray) -> FloatArray:
        """Unit normals, shape (n, 3)."""

    def nearest(self, points: FloatArray, guess: FloatArray) -> FloatArray:
        """Parameters of the nearest points of the surface, near a guess, shape (n, 2)."""

    def ray_hit(
        self, origins: FloatArray, directions: FloatArray, offset: float, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Lengths to the offset surface, and the parameters there; NaN where a ray misses."""


@dataclass(frozen=True)
class ParametricSurface:
    """A surface X(u, v).

    Attributes
    ----------
    position : u, v of shape (n,) to points (n, 3).
    derivatives : u, v to (X_u, X_v), each (n, 3); None: central differences of `position`.
    """

    position: Callable[[FloatArray, FloatArray], FloatArray]
    derivatives: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]] | None = None

    def point(self, uv: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""
        return self.position(uv[:, 0], uv[:, 1])

    def tangents(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives X_u and X_v, each of shape (n, 3)."""
        u, v = uv.T
        if self.derivatives is not None:
            return self.derivatives(u, v)
        h = 6e-6  # the cube root of the rounding unit: best for central differences
        along_u = (self.position(u + h, v) - self.position(u - h, v)) / (2 * h)
        along_v = (self.position(u, v + h) - self.position(u, v - h)) / (2 * h)
        return along_u, along_v

    def normal(self, uv: FloatArray) -> FloatArray:
        """Unit normals X_u x X_v, shape (n, 3)."""
        return unit(cross(*self.tangents(uv)))

    def nearest(self, points: FloatArray, guess: FloatArray) -> FloatArray:
        """Parameters of the nearest points by Gauss-Newton, shape (n, 2).

        Converges linearly at the rate distance x curvature: fast for the thin sheets of origami.
        """
        uv = guess.copy()
        for _ in range(_STEPS):
            along_u, along_v = self.tangents(uv)
            off = points - self.point(uv)
            e, f, g = dot(along_u, along_u), dot(along_u, along_v), dot(along_v, along_v)
            p, q = dot(off, along_u), dot(off, along_v)
            determinant = e * g - f * f
            step = np.column_stack([(g * p - f * q), (e * q - f * p)]) / determinant[:, None]
            uv = uv + step
            if not np.abs(step).max() > _EXACT * (1 + np.abs(uv).max()):
                break
        return uv

    def distance(
        self, points: FloatArray, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Signed distances along the normals (n,), normals (n, 3) and parameters (n, 2)."""
        uv = self.nearest(points, guess)
        normal = self.normal(uv)
        return dot(points - self.point(uv), normal), normal, uv

    def ray_hit(
        self, origins: FloatArray, directions: FloatArray, offset: float, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Lengths (n,) to the surface offset along its normals, and the parameters there (n, 2).

        Newton on the signed distance, whose derivative along a ray is normal . direction. A ray
        that does not meet the offset in front of it gives NaN.
        """
        lengths = np.zeros(len(origins))
        uv = guess.copy()
        missed: BoolArray = np.zeros(len(origins), bool)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for _ in range(_STEPS):
                points = origins + lengths[:, None] * directions
                distance, normal, found = self.distance(points, uv)
                uv = np.where(missed[:, None], guess, found)
                step = np.where(missed, 0.0, (offset - distance) / dot(normal, directions))
                lengths = lengths + step
                missed |= ~np.isfinite(lengths)
                lengths[missed] = 0.0
                if not np.abs(step[~missed]).max(initial=0.0) > _EXACT:
                    break
        lengths[missed | (lengths <= 0)] = np.nan
        return lengths, uv


def explicit_surface(height: Callable[[FloatArray, FloatArray], FloatArray]) -> ParametricSurface:
    """The surface z = height(x, y), with u = x and v = y."""
    return ParametricSurface(lambda x, y: np.column_stack([x, y, height(x, y)]))
