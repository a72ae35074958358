"""Holding bridges: gaps in outlines that keep pieces in the sheet until they are broken out.

A bridge lies on a straight run of its outline, away from corners: within it, and for `clear_mm` on
both sides of it, the outline turns by less than 10 degrees in all corners together, and no other
cut ends there. `clear_mm` is the gap or 1 mm, whichever is longer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fab.drawings.beam import Beam
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Bridged", "bridged"]

# What turns by more within a bridge and what is kept clear beside it is a corner.
_CORNER_DEG = 10.0
_LEAST_CLEAR_MM = 1.0
# Places that are tried along an outline, as many for each bridge; and ways to spread them.
_PLACES = 400
_PHASES = 48
# Two bridges are at least this share of their even distance apart, from middle to middle.
_LEAST_SPREAD = 0.5
# Runs of at least this share of the longest are long.
_LONG = 0.5
# Cuts that end nearer than this to an outline reach it, besides the kerf.
_REACH_MM = 1e-3


@dataclass(frozen=True)
class Bridged:
    """Outlines with their bridges.

    Attributes
    ----------
    outlines : those that have room for none, closed, each of shape (m, 2).
    chains : the parts of the others between their bridges, open.
    counts : how many bridges each outline got, in the order given.
    """

    outlines: tuple[FloatArray, ...]
    chains: tuple[FloatArray, ...]
    counts: tuple[int, ...]


def bridged(
    outlines: Sequence[FloatArray],
    count: int,
    bridge_mm: float,
    beam: Beam,
    ends: FloatArray | None = None,
    clear_mm: float = 0.0,
) -> Bridged:
    """Outlines with `count` bridges each, or as many as there is room for.

    Bridges are spread evenly along the outline, on its longest runs where these allow it. The
    material that is left is `bridge_mm` wide: the gap is wider by the kerf.

    Parameters
    ----------
    outlines : as the beam follows them, each of shape (m, 2).
    ends : of other cuts, shape (n, 2).
    clear_mm : bridges lie where at least this is cut away beside the outline, so that they lead to
        what is left of the sheet.

    >>> square = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]])
    >>> made = bridged([square], 2, 0.4, Beam.of(0.1))
    >>> made.counts, len(made.chains), len(made.outlines)
    ((2,), 2, 0)
    """
    points = shapely.points(np.empty((0, 2)) if ends is None else ends)
    tree = shapely.STRtree(points)
    whole: list[FloatArray] = []
    chains: list[FloatArray] = []
    counts = []
    for outline in outlines:
        line = _Line.of(outline)
        near = tree.query(shapely.LinearRing(outline), "dwithin", beam.widest_mm + _REACH_MM)
        met = [shapely.LinearRing(outline).project(points[i]) for i in sorted(near.tolist())]
        middles, gaps = _places(line, count, bridge_mm, beam, np.array(met), clear_mm)
        counts.append(len(middles))
        if not len(middles):
            whole.append(outline)
            continue
        begins, stops = middles + gaps / 2, np.roll(middles - gaps / 2, -1)
        stops[-1] += line.length
        chains += [line.part(a, b) for a, b in zip(begins.tolist(), stops.tolist(), strict=True)]
    return Bridged(tuple(whole), tuple(chains), tuple(counts))


@dataclass(frozen=True)
class _Line:
    """A closed polyline by its length.

    Attributes
    ----------
    ring : shape (m, 2). at : where along it each vertex is, and its whole length, (m + 1,).
    turn_deg : by how much it turns at each vertex, shape (m,).
    """

    ring: FloatArray
    at: FloatArray
    turn_deg: FloatArray

    @classmethod
    def of(cls, ring: FloatArray) -> _Line:
        sides = np.roll(ring, -1, axis=0) - ring
        before = np.roll(sides, 1, axis=0)
        turn = np.arctan2(
            before[:, 0] * sides[:, 1] - before[:, 1] * sides[:, 0], (before * sides).sum(axis=1)
        )
        at = np.concatenate([[0.0], np.cumsum(np.hypot(*sides.T))])
        return cls(ring, at, np.degrees(np.abs(turn)))

    @property
    def length(self) -> float:
        return float(self.at[-1])

    def directions(self, places: FloatArray) -> FloatArray:
        """Direction of the side that each place is on, shape (n, 2)."""
        side = np.searchsorted(self.at, np.mod(places, self.length), side="right") - 1
        side = np.minimum(side, len(self.ring) - 1)
        out: FloatArray = self.ring[(side + 1) % len(self.ring)] - self.ring[side]
        return out

    def points(self, places: FloatArray) -> FloatArray:
        """Points at places along it, shape (n, 2)."""
        closed = np.concatenate([self.ring, self.ring[:1]])
        where = np.mod(places, self.length)
        return np.column_stack([np.interp(where, self.at, closed[:, axis]) for axis in (0, 1)])

    def has_beside(self, places: FloatArray, wide_mm: float) -> BoolArray:
        """Whether nothing of it is nearer on the right of places than a width, shape (n,)."""
        ahead = self.directions(places)
        aside = np.column_stack([ahead[:, 1], -ahead[:, 0]]) / np.hypot(*ahead.T)[:, None]
        start = self.points(places)
        rays = np.stack([start + _REACH_MM * aside, start + wide_mm * aside], axis=1)
        ring = shapely.LinearRing(self.ring)
        shapely.prepare(ring)
        out: BoolArray = ~shapely.intersects(ring, shapely.linestrings(rays))
        return out

    def part(self, begin: float, end: float) -> FloatArray:
        """The polyline from one place on to another, which is less than a round ahead."""
        at = np.concatenate([self.at[:-1], self.at[:-1] + self.length, self.at + 2 * self.length])
        inner = at[(at > begin) & (at < end)]
        return self.points(np.concatenate([[begin], inner, [end]]))

    def turned_within(self, places: FloatArray, reach: FloatArray, met: FloatArray) -> FloatArray:
        """How much it turns in all within a reach on both sides of places, shape (n,).

        met : places where another cut ends, which count as corners.
        """
        one = np.concatenate([self.at[:-1], met])
        bend = np.concatenate([self.turn_deg, np.full(len(met), 360.0)])
        at = np.concatenate([one - self.length, one, one + self.length])
        order = np.argsort(at, kind="stable")
        at = at[order]
        total = np.concatenate([[0.0], np.cumsum(np.tile(bend, 3)[order])])
        low = np.searchsorted(at, places - reach, side="left")
        high = np.searchsorted(at, places + reach, side="right")
        out: FloatArray = total[high] - total[low]
        return out


def _places(
    line: _Line, count: int, bridge_mm: float, beam: Beam, met: FloatArray, clear_mm: float
) -> tuple[FloatArray, FloatArray]:
    """Middles of the bridges along an outline, rising, and the lengths of their gaps."""
    even = np.arange(_PLACES * count) * (line.length / (_PLACES * count))
    sides = (line.at[:-1] + line.at[1:]) / 2  # short runs have their middles at least
    tried: FloatArray = np.unique(np.concatenate([even, sides]))
    gaps = bridge_mm + beam.along(line.directions(tried))
    clear = np.maximum(gaps, _LEAST_CLEAR_MM)
    free = line.turned_within(tried, gaps / 2 + clear, met) < _CORNER_DEG
    tried, gaps = tried[free], gaps[free]
    if clear_mm:
        leads = line.has_beside(tried, clear_mm)
        tried, gaps = tried[leads], gaps[leads]
    long = _on_long_runs(line, tried)
    for wanted in range(count, 0, -1):
        for chosen in (long, np.ones(len(tried), bool)):
            found = _spread(line.length, tried[chosen], gaps[chosen], wanted)
            if len(found):
                return tried[chosen][found], gaps[chosen][found]
    return np.empty(0), np.empty(0)


def _on_long_runs(line: _Line, places: FloatArray) -> BoolArray:
    """Which places are on runs that are long among those of the outline, shape (n,)."""
    if not len(places):
        return np.zeros(0, bool)
    corners = np.sort(line.at[:-1][line.turn_deg >= _CORNER_DEG])
    if not len(corners):
        return np.ones(len(places), bool)
    after = np.searchsorted(corners, places, side="right")
    around = np.concatenate([[corners[-1] - line.length], corners, [corners[0] + line.length]])
    run = around[after + 1] - around[after]
    out: BoolArray = run >= _LONG * run.max()
    return out


def _spread(length: float, places: FloatArray, gaps: FloatArray, count: int) -> IntArray:
    """Which of the places to take, rising; none where they cannot be spread."""
    if not len(places):
        return np.empty(0, np.int64)
    even = length / count
    best, found = np.inf, np.empty(0, np.int64)
    for phase in np.arange(_PHASES) * (even / _PHASES):
        wanted = phase + even * np.arange(count)
        after = np.searchsorted(places, wanted) % len(places)
        near = np.stack([after - 1, after]) % len(places)
        off = np.abs(places[near] - wanted)
        off = np.minimum(off, length - off)
        taken = np.sort(near[np.argmin(off, axis=0), np.arange(count)])
        apart = np.diff(places[taken], append=places[taken[0]] + length)
        widest = float(gaps[taken].max())
        if apart.min() < max(_LEAST_SPREAD * even, 2 * widest) and count > 1:
            continue
        missed = float(off.min(axis=0).max())
        if missed < best - 1e-9:
            best, found = missed, taken
    return found
