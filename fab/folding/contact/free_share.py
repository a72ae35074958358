"""The share of a step that pairs may take before they touch: conservative advancement.

The unit vector between the closest points of a pair separates its parts. While they move by their
share of a step, that plane goes on to do so up to a time that follows from the speed of each point,
and then a new one is taken: after Mirtich and Canny (1995), with planes of separation in place of
bounds of speed, so that parts that slide along each other need one step.
"""

from __future__ import annotations

import numpy as np

from fab.folding.contact.closest_points import separations, spheres_apart
from fab.folding.contact.surface import Pairs, weights_of
from solver.vectors import FloatArray, IntArray, dot

__all__ = ["free_share"]

# What is left of the room between two parts where a step would bring them nearer.
_LEFT = 0.1
# Planes that are taken one after another; then the step ends, short of contact.
_MOST = 16


def free_share(coords: FloatArray, step: FloatArray, pairs: Pairs) -> float:
    """The largest share of a step, 0 to 1, that leaves every pair a tenth of its room.

    coords, step : shape (nv, 3). The room of a pair is its distance beyond its gap; one without
    room stops the step.
    """
    pairs = pairs.chosen(_in_danger(coords, step, pairs))
    active = np.arange(len(pairs.members))
    time = np.zeros(len(active))
    least = np.full(len(active), np.nan)
    end = 1.0
    for _ in range(_MOST):
        if not len(active):
            return end
        some = pairs.chosen(active)
        points = coords[some.members] + time[active, None, None] * step[some.members]
        distance, normal = separations(points, weights_of(points, some.faced))
        room = distance - some.gap
        first = np.isnan(least[active])
        if (first & ~(room > 0)).any():
            return 0.0
        least[active[first]] = _LEFT * room[first]
        touching = room <= least[active]
        ends = time[active[touching & ~first]]
        if len(ends):
            end = min(end, float(ends.min()))
        time[active] += _advance(points, step[some.members], normal, some, least[active] / 2)
        active = active[~(touching & ~first) & (time[active] < end)]
    return min(end, float(time[active].min(initial=end)))


def _in_danger(coords: FloatArray, step: FloatArray, pairs: Pairs) -> IntArray:
    """Those whose spheres do not stay apart."""
    moved = step[pairs.members]
    speed = np.sqrt(dot(moved, moved))
    faced = pairs.faced
    nearing = np.empty(len(speed))
    nearing[:faced] = speed[:faced, 0] + speed[:faced, 1:].max(axis=1)
    nearing[faced:] = speed[faced:].reshape(-1, 2, 2).max(axis=2).sum(axis=1)
    apart = spheres_apart(coords[pairs.members], faced)
    return np.flatnonzero(apart - nearing < pairs.gap)


def _advance(
    points: FloatArray, steps: FloatArray, normal: FloatArray, pairs: Pairs, room: FloatArray
) -> FloatArray:
    """For how long the planes across `normal` keep parts their gap and some room apart, (n,)."""
    height = np.einsum("nix,nx->ni", points, normal)
    speed = np.einsum("nix,nx->ni", steps, normal)
    out = np.empty(len(points))
    faced = pairs.faced
    for part, above, below in (
        (slice(None, faced), [0], [1, 2, 3]),
        (slice(faced, None), [0, 1], [2, 3]),
    ):
        apart = height[part][:, above, None] - height[part][:, None, below]
        nearing = speed[part][:, None, below] - speed[part][:, above, None]
        kept = (pairs.gap + room)[part, None, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            times = np.where(nearing > 0, (apart - kept) / nearing, np.inf)
        out[part] = times.min(axis=(1, 2), initial=np.inf)
    return np.maximum(out, 0.0)
