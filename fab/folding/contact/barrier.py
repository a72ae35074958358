"""The barrier that keeps apart what comes nearer than its reach.

With s the share of the reach that is left, the energy is

    force * reach * -(1 - s)^2 ln s,    0 < s < 1,

and nothing beyond: the barrier of incremental potential contact (Li et al. 2020), of which two
derivatives are continuous. It has no bound where s goes to 0, so that no finite force brings what
it keeps apart together.
"""

from __future__ import annotations

import numpy as np

from solver.vectors import FloatArray

__all__ = ["barrier", "barrier_curvature", "barrier_slope"]


def barrier(share: FloatArray) -> FloatArray:
    """The energy, over force times reach, at shares of the reach; infinite at 0 and below.

    >>> barrier(np.array([0.0, 1.0, 2.0])).tolist()
    [inf, 0.0, 0.0]
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = -((1 - share) ** 2) * np.log(share)
    return np.where(share >= 1, 0.0, np.where(share > 0, inside, np.inf))


def barrier_slope(share: FloatArray) -> FloatArray:
    """Its derivative by the share, never positive; share : from 0, without it, to 1."""
    out: FloatArray = 2 * (1 - share) * np.log(share) - (1 - share) ** 2 / share
    return out


def barrier_curvature(share: FloatArray) -> FloatArray:
    """Its second derivative by the share, never negative; share : as for the slope."""
    rest = (1 - share) / share
    out: FloatArray = -2 * np.log(share) + 4 * rest + rest**2
    return out
