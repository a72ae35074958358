"""Costs of a strip's flap angle, and the free flap angles at which they are least.

S30, the paper's cost of surface fitting: new design angles near those of the strip behind. The
authors' models of peaks have its least value over all free flap angles on every strip.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from solver.arcs import contain
from solver.front import Front
from solver.vectors import FloatArray, angle_between

__all__ = ["DesignAngleCost", "FlapCost", "is_free"]

# Flap angles tried all around the circle.
_TRIALS = 1441


def is_free(free: FloatArray, angle: float) -> bool:
    """Whether a flap angle, in radians of any turn, is within one of the free arcs."""
    return bool(contain(free, np.array([angle % (2 * np.pi)]))[0])


@dataclass(frozen=True)
class FlapCost(ABC):
    """A cost of the flap angle at the first interior vertex of an open front.

    Attributes
    ----------
    front : the front, its vertices' numbers in columns.
    """

    front: Front

    @abstractmethod
    def cost(self, trials: FloatArray) -> FloatArray:
        """The cost at each of q flap angles, radians, shape (q,): a whole landscape at once."""

    @abstractmethod
    def slope(self, trial: float) -> float:
        """Derivative of the cost with respect to the first flap angle, exact."""

    def _parts(self, trials: FloatArray) -> tuple[FloatArray, ...]:
        """Of the first flap angles: size of the images; cosine, sine, level, length by vertex."""
        f = self.front
        image = f.transfer_matrices @ np.stack([np.sin(trials / 2), np.cos(trials / 2)])
        squares = image * image
        size = squares[:, 0] + squares[:, 1]
        cosine = (squares[:, 1] - squares[:, 0]) / size
        sine = 2 * image[:, 0] * image[:, 1] / size
        level = (f.run + f.sin_beta)[:, None] - f.sin_beta[:, None] * cosine
        return size, cosine, sine, level, np.hypot(f.rise[:, None], level)

    def minimum(self, low: float, high: float) -> float | None:
        """A flap angle between two others at which the cost is least; None where it falls out."""
        if not self.slope(low) < 0 < self.slope(high):
            return None
        return float(brentq(self.slope, low, high, xtol=1e-13))

    def best_of(self, free: FloatArray) -> float:
        """The free flap angle of least cost all around: the best of many trials, then polished."""
        trials = np.linspace(0.0, 2 * np.pi, _TRIALS, endpoint=False)
        inside = contain(free, trials)
        if not inside.any():  # arcs narrower than the trials' distance
            trials, inside = _middles(free), np.ones(len(free), bool)
        best = float(trials[np.argmin(np.where(inside, self.cost(trials), np.inf))])
        spread = 2 * np.pi / _TRIALS
        polished = self.minimum(best - spread, best + spread)
        return best if polished is None or not is_free(free, polished) else polished


@dataclass(frozen=True)
class DesignAngleCost(FlapCost):
    """S30: squares of theta1 - theta4 and theta2 - theta3, added up over the interior vertices.

    As the four angles of a vertex are a full turn, this is 2 (theta1 + theta3 - pi)^2 but for what
    no flap angle changes: each vertex is drawn to where it folds flat.

    Attributes
    ----------
    theta3, theta4 : design angles of the strip behind, radians, shape (n, 1).

    The Miura sheet repeats itself at the flap angle of least cost, or is mirrored at another one
    that costs as much:

    >>> from solver.designs import Miura
    >>> from solver.mesh import Side
    >>> mesh = Miura(columns=8, rows=4).grow().mesh
    >>> front = Front.of(mesh, Side.TOP)
    >>> rays = front.rays(DesignAngleCost.of(front).best_of(front.free_flap_angles()))
    >>> before = mesh.vertices_coords[mesh.grid[-2]] - mesh.vertices_coords[mesh.grid[-3]]
    >>> bool(abs(abs(rays.directions) - abs(before)).max() < 1e-6)
    True
    """

    theta3: FloatArray
    theta4: FloatArray

    @classmethod
    def of(cls, front: Front) -> DesignAngleCost:
        """The cost of a front with faces behind it."""
        assert front.back is not None
        u = front.edges_direction
        theta4, theta3 = angle_between(-u[:-1], front.back), angle_between(u[1:], front.back)
        return cls(front, theta3[:, None], theta4[:, None])

    def cost(self, trials: FloatArray) -> FloatArray:
        """Sum over the vertices, square radians, shape (q,)."""
        _, _, _, level, _ = self._parts(trials)
        theta1 = np.arctan2(self.front.rise[:, None], level)
        theta2 = self.front.k[:, None] - theta1
        out: FloatArray = ((theta1 - self.theta4) ** 2 + (theta2 - self.theta3) ** 2).sum(axis=0)
        return out

    def slope(self, trial: float) -> float:
        """Derivative of the cost with respect to the first flap angle, exact."""
        size, _, sine, level, length = self._parts(np.array([trial]))
        f = self.front
        theta1 = np.arctan2(f.rise[:, None], level)
        skew = (theta1 - self.theta4) - (f.k[:, None] - theta1 - self.theta3)
        opening = -f.rise[:, None] * f.sin_beta[:, None] * sine / length**2  # by its own flap angle
        speed = np.linalg.det(f.transfer_matrices)[:, None] / size  # of it by the first
        return float((2 * skew * opening * speed).sum())


def _middles(arcs: FloatArray) -> FloatArray:
    start, end = arcs.T
    out: FloatArray = (start + ((end - start) % (2 * np.pi)) / 2) % (2 * np.pi)
    return out
