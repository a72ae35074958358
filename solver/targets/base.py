"""Target surfaces: what surface fitting asks of them, and rays that meet their offsets."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from solver.vectors import BoolArray, FloatArray, dot

__all__ = ["MOST_STEPS", "Target", "largest_step", "ray_hit", "settled"]

# Steps of Newton's method towards nearest points and ray hits.
MOST_STEPS = 60
# Steps this small do not count; steps below the second number that no longer shrink are rounding.
_EXACT = 1e-15
_ROUNDING = 1e-9
# A ray whose last step is longer, relative to its length, found nothing: its steps go in circles.
_SETTLED = 1e-11


def settled(now: float, before: float) -> bool:
    """Whether relative steps of this size, after such ones before, are worth no further one."""
    return now <= _EXACT or (now < _ROUNDING and now > before / 2)


class Target(Protocol):
    """What surface fitting asks of a surface.

    A place is a point of the surface as a row of numbers; the first two are always its parameters
    u and v, in which the surface's domain lies in the square [-1, 1] x [-1, 1]. Places beyond the
    domain exist as far as the surface can be continued.
    """

    def places(self, uv: FloatArray) -> FloatArray:
        """Places with the parameters `uv`, shapes (n, 2) and (n, d)."""

    def point(self, places: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""

    def normal(self, places: FloatArray) -> FloatArray:
        """Unit normals, shape (n, 3)."""

    def distance(
        self, points: FloatArray, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Signed distances (n,) of points, their gradients (n, 3), the nearest places (n, d).

        Positive on the normals' side; `guess` are places near the nearest ones.
        """

    def inside(self, places: FloatArray) -> BoolArray:
        """Whether places belong to the domain, not to the surface's continuation, shape (n,)."""


def largest_step(steps: FloatArray) -> float:
    """Largest size among the numbers; NaN and infinity have failed and do not count."""
    return float(np.max(np.abs(steps), initial=0.0, where=np.isfinite(steps)))


def ray_hit(
    target: Target,
    origins: FloatArray,
    directions: FloatArray,
    offset: float,
    guess: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Lengths (n,) of rays to the surface offset along its normals, and the places there (n, d).

    origins, directions : shape (n, 3); guess : places near the origins. Newton on the signed
    distance, whose derivative along a ray is gradient . direction. A ray that does not meet the
    offset in front of it gives NaN.

    >>> from solver.targets import explicit_surface
    >>> plane = explicit_surface(lambda x, y: 0 * x)
    >>> origin, up = np.array([[0.2, 0.3, 0.0]]), np.array([[0.0, 0.6, 0.8]])
    >>> lengths, places = ray_hit(plane, origin, up, 0.4, origin[:, :2])
    >>> lengths.round(12), places.round(12)
    (array([0.5]), array([[0.2, 0.6]]))
    """
    lengths = np.zeros(len(origins))
    places = guess.copy()
    missed: BoolArray = np.zeros(len(origins), bool)
    before = np.inf
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for _ in range(MOST_STEPS):
            points = origins + lengths[:, None] * directions
            distance, gradient, found = target.distance(points, places)
            places = np.where(missed[:, None], guess, found)
            step = np.where(missed, 0.0, (offset - distance) / dot(gradient, directions))
            lengths = lengths + step
            missed |= ~np.isfinite(lengths)
            lengths[missed] = 0.0
            now = largest_step(step / (1 + np.abs(lengths)))
            if settled(now, before):
                break
            before = now
    unsettled = np.abs(step) > _SETTLED * (1 + np.abs(lengths))
    lengths[missed | unsettled | (lengths <= 0)] = np.nan
    return lengths, places
