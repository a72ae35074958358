"""The landscape of a strip's flap angle: its cost, and the constraints that it breaks (S13)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.errors import InvalidState, require_count
from solver.flap_costs import DesignAngleCost, FlapCost
from solver.front import Front
from solver.growth import Lengths, lengths_along, usable_lengths
from solver.transfer import transfer_flap_angles
from solver.vectors import FloatArray, IntArray

__all__ = ["FlapLandscape", "flap_angle_landscape"]


@dataclass(frozen=True)
class FlapLandscape:
    """Cost and constraints at q flap angles of front vertex 1. Arrays are read-only.

    Attributes
    ----------
    flap_angles : radians, shape (q,).
    cost : at each of them, shape (q,).
    crossings : number of vertices at which new faces would cross old ones, shape (q,).
    unreached : number of creases without a usable length, shape (q,); zeros without lengths.
    free : flap angles without crossings, as arcs, exactly, shape (k, 2).
    best, best_cost : the free flap angle of least cost, polished, and that cost; NaN where none is
        free.
    """

    flap_angles: FloatArray
    cost: FloatArray
    crossings: IntArray
    unreached: IntArray
    free: FloatArray
    best: float
    best_cost: float

    def __post_init__(self) -> None:
        for array in vars(self).values():
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @property
    def constraint(self) -> IntArray:
        """C_con: how many vertices and creases break a constraint, 0 where a strip can grow, (q,).

        That is crossings and unreached together.
        """
        out: IntArray = self.crossings + self.unreached
        return out


def flap_angle_landscape(
    front: Front,
    cost: FlapCost | None = None,
    *,
    lengths: Lengths | None = None,
    flap_angles: FloatArray | int = 720,
) -> FlapLandscape:
    """What every flap angle of a strip costs, and which constraints it breaks.

    Parameters
    ----------
    front : open, with faces behind it.
    cost : of the front; None: S30, its `DesignAngleCost`.
    lengths : of the new creases, as in `Strip`; None: they break no constraint. A function of the
        rays may give NaN for a crease that misses what it should reach.
    flap_angles : radians, shape (q,), or how many, evenly around the circle.

    Raises `InvalidState` for a front that is a curve or a loop.

    >>> from solver.designs import Miura
    >>> from solver.mesh import Side
    >>> front = Front.of(Miura(columns=6, rows=3).grow().mesh, Side.TOP)
    >>> landscape = flap_angle_landscape(front, lengths=1.0)
    >>> bool(landscape.best_cost <= landscape.cost[landscape.crossings == 0].min())
    True
    """
    if front.back is None or front.closed:
        kind = "a loop" if front.closed else "a curve"
        cure = "Give an open front with faces behind it."
        raise InvalidState("front", f"the front is {kind}", cure)
    if isinstance(flap_angles, int):
        require_count("flap_angles", flap_angles, 1, "Give at least one.")
        trials = 2 * np.pi * np.arange(flap_angles) / flap_angles
    else:
        trials = np.asarray(flap_angles, np.float64)
    cost = DesignAngleCost.of(front) if cost is None else cost
    flaps = transfer_flap_angles(front.transfer_matrices, trials)
    crossings = front.self_intersections(flaps).sum(axis=0)
    unreached = np.zeros(len(trials), np.int64)
    if lengths is not None:
        for number, trial in enumerate(trials.tolist()):
            rays = front.rays(trial)
            unreached[number] = (~usable_lengths(lengths_along(lengths, rays), rays)).sum()
    free = front.free_flap_angles()
    best = best_cost = np.nan
    if len(free):
        best = cost.best_of(free) % (2 * np.pi)
        best_cost = float(cost.cost(np.array([best]))[0])
    return FlapLandscape(trials, cost.cost(trials), crossings, unreached, free, best, best_cost)
