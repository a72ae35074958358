"""A ribbon of quads along a random walk that lies flat on a circle (figures 4F and S17)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq

from solver import seeds
from solver.designs.walks import can_fold, random_walks
from solver.errors import InvalidState, InvalidValue, require_within
from solver.front import Front
from solver.growth import Growth, Strip, grow
from solver.rays import Rays
from solver.vectors import FloatArray, norm

__all__ = ["BrownianRibbon", "ribbon"]

# Walks are drawn anew until every vertex has room to fold.
_DRAWS = 20_000


@dataclass(frozen=True)
class BrownianRibbon:
    """Seed: a random walk in space. k: the angles of a polygon inscribed in a circle (S55).

    Unfolded, the walk's vertices lie on a circle of the radius that lets the polygon turn by
    `turn`, and the new row on a smaller one about the same centre.

    Attributes
    ----------
    steps : of the walk, each normally distributed in x, y and z.
    flap_angle : at the first interior vertex, radians.
    turn : what the flat ribbon turns by in all, radians.
    width_share : of the largest ribbon width at which no creases meet.
    random_seed : the same number gives the same walk.
    radius_ratio : r_inner / r_outer of the two circles, in place of width_share; the authors' model
        of figure 4F has 0.99948.
    """

    steps: int = 400
    flap_angle: float = field(default=np.pi / 4, metadata={"angle": True})
    turn: float = field(default=2 * np.pi, metadata={"angle": True})
    width_share: float = 0.5
    random_seed: int = 0
    radius_ratio: float | None = None

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the ribbon. Raises `InvalidValue` for parameters out of bounds."""
        require_within("turn", self.turn, 0.0, 2.001 * np.pi, "A circle has 360.", angle=True)
        require_within("width_share", self.width_share, 0.0, 1.0, "One half is safe.")
        if self.radius_ratio is not None:
            cure = "Long ribbons are narrow: 400 steps want about 0.9995."
            require_within("radius_ratio", self.radius_ratio, 0.0, 1.0, cure)
        for walk in random_walks(self.steps, self.random_seed, _DRAWS):
            if _has_room(walk, self.turn):
                return ribbon(
                    walk,
                    self.flap_angle,
                    self.turn,
                    width_share=self.width_share,
                    radius_ratio=self.radius_ratio,
                    progress=progress,
                )
        raise InvalidState(
            "turn",
            f"none of {_DRAWS} walks has room to fold at every vertex for a turn of "
            f"{self.turn:.6g} rad",
            "Use a smaller turn, or another number of steps.",
        )


def _has_room(walk: FloatArray, turn: float) -> bool:
    """Whether beta < k < 2 pi - beta at every vertex of the walk."""
    sizes = norm(np.diff(walk, axis=0))
    outer = _outer_radius(sizes, turn)
    if outer is None:
        return False
    base = np.arccos(sizes / (2 * outer))
    return can_fold(walk, base[1:] + base[:-1])


def ribbon(
    walk: FloatArray,
    flap_angle: float,
    turn: float,
    *,
    width_share: float | None = None,
    radius_ratio: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """One strip along a polyline (m + 1, 3) that unfolds between two circles.

    The ratio of inner to outer radius sets the width; where it is None, a share of the largest one.
    """
    sizes = norm(np.diff(walk, axis=0))
    outer = _outer_radius(sizes, turn)
    if outer is None:
        raise InvalidState(
            "turn",
            f"no chords turn by {turn:.6g} rad: one step is longer than all others together",
            "Use more steps, or a smaller turn.",
        )
    base = np.arccos(sizes / (2 * outer))  # base angles of the triangles over the centre

    def choose(_front: Front, _strip: int) -> Strip:
        def to_circle(rays: Rays) -> FloatArray:
            lean = _lean(rays, base)
            least = _least_ratio(rays, lean, outer)
            if radius_ratio is None:
                assert width_share is not None
                return _lengths(lean, outer, 1 - width_share * (1 - least))
            if radius_ratio <= least:
                raise InvalidValue(
                    "radius_ratio",
                    radius_ratio,
                    f"be above {least:.9g}, below which creases of this walk meet",
                    "Use a larger ratio, or another random_seed.",
                )
            return _lengths(lean, outer, radius_ratio)

        ends = float(base[0]), float(base[-1])
        return Strip(flap_angle, to_circle, boundary_angles=ends)

    return grow(seeds.curve(walk), 1, choose, k=base[1:] + base[:-1], progress=progress)


def _outer_radius(sizes: FloatArray, turn: float) -> float | None:
    """Radius of the circle in which chords of these sizes turn by `turn`; None where none does."""

    def excess(radius: float) -> float:
        return float(2 * np.arcsin(np.minimum(sizes / (2 * radius), 1.0)).sum()) - turn

    low, high = float(sizes.max()) / 2, float(sizes.sum())
    while excess(high) > 0:
        high *= 2
    if excess(low) < 0:
        return None
    return float(brentq(excess, low, high, xtol=1e-14 * high, rtol=8.9e-16, maxiter=500))


def _lean(rays: Rays, base: FloatArray) -> FloatArray:
    """Angle between each crease and the flat radius at its vertex, radians."""
    x, r = rays.vertices_coords, rays.directions
    before = x[:-2] - x[1:-1]
    theta1 = np.arctan2(norm(np.cross(before, r[1:-1])), np.vecdot(before, r[1:-1]))
    lean = np.zeros(len(x))
    lean[1:-1] = theta1 - base[:-1]
    return lean


def _lengths(lean: FloatArray, outer: float, ratio: float) -> FloatArray:
    """From the outer to the inner circle along creases that lean off the radius; NaN past it."""
    inner2 = ratio**2 - np.sin(lean) ** 2
    with np.errstate(invalid="ignore"):
        # cos - sqrt(cos^2 - (1 - ratio^2)) without cancellation for a narrow ribbon
        out: FloatArray = outer * (1 - ratio**2) / (np.cos(lean) + np.sqrt(inner2))
    return out


def _least_ratio(rays: Rays, lean: FloatArray, outer: float) -> float:
    """The smallest ratio of radii at which every crease reaches and none meet, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        fits = (_lengths(lean, outer, middle) < rays.length_bounds).all()
        low, high = (low, middle) if fits else (middle, high)
    return high
