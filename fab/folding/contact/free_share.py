"""The share of a step that pairs may take before they touch: conservative advancement.

The unit vector between the closest points of a pair separates its parts. While they move by their
share of a step, that plane goes on to do so up to a time that follows from the speed of each point,
and then a new one is taken: after Mirtich and Canny (1995), with planes of separation in place of
bounds of speed, so that parts that slide along each other need one step.
"""

from __future__ import annotations

import numpy as np

from fab.folding.contact.closest_points import separations
from fab.folding.contact.surface import Pairs, Surface, weights_of
from solver.vectors import FloatArray, IntArray, dot

__all__ = ["free_share"]

# What is left of the room between two parts where a step would bring them nearer.
_LEFT = 0.1
# Planes that are taken one after another; then the step ends, short of contact.
_MOST = 16


def free_share(surface: Surface, coords: FloatArray, step: FloatArray, pairs: Pairs) -> float:
    """The largest share of a step, 0 to 1, that leaves every pair a tenth of its room.

    coords, step : shape (nv, 3). The room of a pair is its distance beyond its gap; one without
    room stops the step.
    """
    pairs = pairs.chosen(_in_danger(surface, coords, step, pairs))
    if not len(pairs.members):
        return 1.0
    points, steps = coords[pairs.members], step[pairs.members]
    distance, normal = separations(points, weights_of(points, pairs.faced))
    room = distance - pairs.gap
    if not (room > 0).all():
        return 0.0
    end = 1.0
    kept = pairs.gap + _LEFT / 2 * room
    time = _advance(points, steps, normal, np.zeros_like(normal), pairs.faced, kept)
    active = np.flatnonzero(time < end)
    time, far = time[active], np.ones(len(active))
    for _ in range(_MOST):
        if not len(active):
            return end
        faced = int(np.searchsorted(active, pairs.faced))
        start = points[active] + time[:, None, None] * steps[active]
        rest = (far - time)[:, None, None] * steps[active]
        distance, normal, there = _at_both_ends(start, start + rest, faced)
        touching = distance - pairs.gap[active] <= _LEFT * room[active]
        end = min(end, float(time[touching].min(initial=end)))
        turned = np.where((dot(normal, there) > 0)[:, None], there - normal, 0.0)
        moved = np.minimum(_advance(start, rest, normal, turned, faced, kept[active]), 1.0)
        time = time + (far - time) * moved
        far = np.where(moved < 1, (time + far) / 2, end)
        going = np.flatnonzero(~touching & (time < end))
        active, time, far = active[going], time[going], np.minimum(far, end)[going]
    return min(end, float(time.min(initial=end)))


def _at_both_ends(
    start: FloatArray, ahead: FloatArray, faced: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distances of pairs at the start, and unit vectors between them at the start and ahead."""
    both = np.concatenate([start[:faced], ahead[:faced], start[faced:], ahead[faced:]])
    distance, normal = separations(both, weights_of(both, 2 * faced))
    count = len(start)
    first = np.concatenate([np.arange(faced), np.arange(2 * faced, faced + count)])
    then = np.concatenate([np.arange(faced, 2 * faced), np.arange(faced + count, 2 * count)])
    return distance[first], normal[first], normal[then]


def _in_danger(surface: Surface, coords: FloatArray, step: FloatArray, pairs: Pairs) -> IntArray:
    """Those whose boxes along the step do not stay apart."""
    there = coords + step
    boxes = surface.boxes(np.minimum(coords, there), np.maximum(coords, there))
    return pairs.meeting(boxes, 0.0)


def _advance(
    points: FloatArray,
    steps: FloatArray,
    normal: FloatArray,
    turned: FloatArray,
    faced: int,
    kept: FloatArray,
) -> FloatArray:
    """For how long planes that turn keep parts `kept` apart, times, shape (n,).

    normal, turned : shape (n, 3), the direction across each at time 0, and by how much it changes
    up to time 1; it is no longer than 1 until then. Where it does not turn, the time may be longer.
    """
    out = np.empty(len(points))
    heights = [
        np.einsum("nix,nx->ni", *each)
        for each in ((points, normal), (steps, normal), (points, turned), (steps, turned))
    ]
    for part, above, below in (
        (slice(None, faced), [0], [1, 2, 3]),
        (slice(faced, None), [0, 1], [2, 3]),
    ):
        apart, speed, tilt, bend = (
            each[part][:, above, None] - each[part][:, None, below] for each in heights
        )
        times = _first_zero(apart - kept[part, None, None], speed + tilt, bend)
        out[part] = times.min(axis=(1, 2), initial=np.inf)
    return out


def _first_zero(level: FloatArray, slope: FloatArray, bend: FloatArray) -> FloatArray:
    """Where level + slope t + bend t^2 first falls to 0, from t = 0 on; inf where it never does."""
    inside = slope * slope - 4 * level * bend
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(inside)
        out = np.where(slope > 0, (slope + root) / (-2 * bend), 2 * level / (root - slope))
    out = np.where(out >= 0, out, np.inf)  # NaN where there is no root
    return np.where(level > 0, out, 0.0)
