"""A ribbon of quads along a random walk that lies flat on a chosen plane curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import diags_array, hstack
from scipy.sparse.linalg import spsolve

from solver import seeds
from solver.designs.walks import can_fold, random_walks
from solver.errors import InvalidState, InvalidValue, require_within
from solver.front import Front
from solver.growth import Growth, Strip, grow
from solver.rays import Rays
from solver.vectors import ComplexArray, FloatArray, angle_between, full_turn, norm

__all__ = ["OUTLINES", "Outline", "ShapedRibbon", "chords"]

# Points of a plane curve and their derivatives for parameters in [0, 1], as complex numbers.
Outline = Callable[[FloatArray], tuple[ComplexArray, ComplexArray]]

# Walks are drawn anew until every vertex has room to fold.
_DRAWS = 2000


def _ellipse(t: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    reach = 1.9 * np.pi
    x, y = np.cos(reach * t), np.sin(reach * t)
    return x + 0.6j * y, reach * (0.6j * x - y)


def _spiral(t: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    reach = 4 * np.pi
    radius, turn = 0.4 + t, np.exp(1j * reach * t)
    return radius * turn, (1 + 1j * reach * radius) * turn


def _wave(t: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    reach = 3 * np.pi
    return reach * t + 1.5j * np.sin(reach * t), reach * (1 + 1.5j * np.cos(reach * t))


OUTLINES: dict[str, Outline] = {"ellipse": _ellipse, "spiral": _spiral, "wave": _wave}


@dataclass(frozen=True)
class ShapedRibbon:
    """Seed: a random walk in space. k: the angles of a polygon inscribed in a plane curve.

    The free choice of k on a curve (the paper's corollary) is the choice of the flat front: the
    vertices of the unfolded walk lie on the outline, and the new row runs beside it on the left at
    one distance from it.

    Attributes
    ----------
    outline : spiral, of two turns outwards; wave, of one and a half periods; ellipse, all but 18
        degrees of it.
    steps : of the walk, each normally distributed in x, y and z.
    flap_angle : at the first interior vertex, radians.
    width_share : of the largest ribbon width at which no creases meet.
    random_seed : the same number gives the same walk.
    """

    outline: str = "spiral"
    steps: int = 400
    flap_angle: float = field(default=np.pi / 4, metadata={"angle": True})
    width_share: float = 0.5
    random_seed: int = 0

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the ribbon. Raises `InvalidValue` for parameters out of bounds."""
        if self.outline not in OUTLINES:
            raise InvalidValue(
                "outline", self.outline, f"be one of {', '.join(OUTLINES)}", "Try spiral."
            )
        require_within("width_share", self.width_share, 0.0, 1.0, "One half is safe.")
        for walk in random_walks(self.steps, self.random_seed, _DRAWS):
            k = _room_to_fold(walk, OUTLINES[self.outline])
            if k is not None:
                return grow(seeds.curve(walk), 1, self._strip(k), k=k, progress=progress)
        raise InvalidState(
            "steps",
            f"none of {_DRAWS} walks of {self.steps} steps has room to fold at every vertex along "
            f"the {self.outline}",
            "Use more steps.",
        )

    def _strip(self, k: FloatArray) -> Callable[[Front, int], Strip]:
        def beside(rays: Rays) -> FloatArray:
            x, r = rays.vertices_coords, rays.directions
            lean = np.zeros(len(x))  # of each crease off the outline's normal
            lean[1:-1] = angle_between(x[:-2] - x[1:-1], r[1:-1]) - k / 2
            width = self.width_share * (rays.length_bounds * np.cos(lean)).min()
            out: FloatArray = width / np.cos(lean)
            return out

        square = np.pi / 2, np.pi / 2
        return lambda _front, _strip: Strip(self.flap_angle, beside, boundary_angles=square)


def _room_to_fold(walk: FloatArray, outline: Outline) -> FloatArray | None:
    """Angles k of the walk on the outline; None without beta < k < 2 pi - beta everywhere."""
    points = chords(outline, norm(np.diff(walk, axis=0)))
    if points is None:
        return None
    along = np.diff(points)
    k = full_turn(np.angle(-along[:-1] / along[1:]))  # on the left
    return k if can_fold(walk, k) else None


def chords(outline: Outline, sizes: FloatArray) -> ComplexArray | None:
    """Points from end to end of an outline whose distances have the ratios of `sizes`, (m,).

    Newton's method for the logarithms of the distances, from the points whose arc lengths along the
    outline have these ratios. Returns shape (m + 1,); None where that leads nowhere.
    """
    fine = np.linspace(0.0, 1.0, 4001)
    arc = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(outline(fine)[0])))])
    ends = np.concatenate([[0.0], np.cumsum(sizes)])
    t = np.interp(ends / ends[-1], arc / arc[-1], fine)
    scale = arc[-1] / ends[-1]
    count = len(sizes)
    for _ in range(30):
        point, slope = outline(t)
        step = np.diff(point)
        miss = np.log(np.abs(step) / (scale * sizes))
        # of the logarithms by the parameters of the points inside, and by that of the scale
        after, before = (slope[1:] / step).real, -(slope[:-1] / step).real
        inside = diags_array((after[:-1], before[1:]), offsets=(0, -1), shape=(count, count - 1))
        change = spsolve(hstack([inside, -np.ones((count, 1))]).tocsc(), -miss)
        t[1:-1] += change[:-1]
        scale *= np.exp(change[-1])
        if not (np.isfinite(t).all() and (np.diff(t) > 0).all()):
            return None
        if np.abs(change).max() < 1e-14:
            break
    return outline(t)[0]
