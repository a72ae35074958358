"""Overlaps and distances of all pairs of bodies of a thick sheet in one state.

Panels across a crease must keep the distance that their setbacks promise (`fab.panels.setbacks`),
all other pairs must not touch. Planes between two bodies prove most of this for all pairs at once
(`fab.geometry.separating_planes`); what they leave open is measured exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fab.clearance.checked_bodies import CheckedBodies, may_touch
from fab.clearance.promised_distances import (
    axis_slips_mm,
    halfway_normals,
    knuckled_mm,
    mates_promised_mm,
)
from fab.folding.folded_states import FoldedState, Stage
from fab.geometry.bodies import Bodies
from fab.geometry.separating_planes import apart_along, apart_at_least, near_pairs
from fab.panels.thick_sheet import ThickSheet
from solver.vectors import BoolArray, FloatArray, IntArray, norm

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["OVERLAP_MM3", "PairCheck", "check_pairs"]

# manifold3d reports up to 5e-13 mm3 where two bodies only touch; real overlaps are far larger.
OVERLAP_MM3 = 1e-6
# Distances may fall short of what setbacks promise by rounding alone.
_KEPT = 0.97
# Distances are measured up to this multiple of what is wanted, or known to be.
_REACH = 1.5
# The distance of the closest pair is resolved to this share of itself.
_RESOLVED = 1e-6


@dataclass(frozen=True)
class PairCheck:
    """All pairs of bodies in one state.

    Attributes
    ----------
    state : which. names : of all bodies; faces : the face of each, -1 for those that bend.
    pairs : shape (n, 2), those with a common crease, and all others near each other.
    edges : shape (n,), the common crease of two panels; -1 where there is none.
    may_touch : shape (n,), for bodies of one face, and for hinges.
    wanted_mm : shape (n,), the distance that each pair must keep.
    apart_mm : shape (n,), a lower bound of their distance; exact below `wanted_mm`, and for the
        closest pair unless knuckles join it.
    overlap_mm3 : shape (n,), common volume. depth_mm : shape (n,), how deep they reach into each
        other at most, where there is one.
    """

    state: FoldedState
    names: tuple[str, ...]
    faces: IntArray
    pairs: IntArray
    edges: IntArray
    may_touch: BoolArray
    wanted_mm: FloatArray
    apart_mm: FloatArray
    overlap_mm3: FloatArray
    depth_mm: FloatArray

    @property
    def overlapping(self) -> IntArray:
        """The pairs with a common volume, the largest first."""
        rows = np.flatnonzero(self.overlap_mm3 > OVERLAP_MM3)
        return rows[np.argsort(-self.overlap_mm3[rows], kind="stable")]

    @property
    def deep(self) -> BoolArray:
        """Whether each pair reaches deeper into each other than faces that bend explain, (n,)."""
        return np.asarray(self.depth_mm > 2 * self.state.bend_mm)

    @property
    def closest(self) -> int | None:
        """The pair that comes nearest to each other, of those that may not touch."""
        free = np.flatnonzero(~self.may_touch)
        return int(free[self.apart_mm[free].argmin()]) if len(free) else None


def check_pairs(sheet: ThickSheet, checked: CheckedBodies, state: FoldedState) -> PairCheck:
    """Check all pairs of some bodies, each with its face in a state, or where it is when flat."""
    moving = np.maximum(checked.faces, 0)
    bodies = checked.bodies
    if state.stage != Stage.FLAT:
        bodies = bodies.moved(state.turns[moving], state.shifts[moving])
    promised = _by_pairs(checked, mates_promised_mm(sheet, checked, state))
    least = float(promised.min(initial=np.inf))
    if not np.isfinite(least):
        least = 2 * float(sheet.panels.setbacks.axis_mm.max(initial=0.0)) or sheet.panel.gap_mm
    near = near_pairs(bodies, least)
    if state.stage != Stage.FLAT:  # pieces of a sheet have no common place when folded
        piece = sheet.pattern.faces_piece[moving]
        near = near[piece[near[:, 0]] == piece[near[:, 1]]]
    near = near[~may_touch(checked, near) | _boxes_meet(bodies, near)]
    pairs, mate = _pairs(checked, near)
    edges = np.where(mate >= 0, checked.mates_edge[mate] if len(checked.mates) else -1, -1)
    touch = may_touch(checked, pairs)
    wanted = _wanted_mm(bodies, pairs, mate, touch, promised, least, state)
    linked = np.flatnonzero(mate >= 0)
    linked = linked[checked.linked[mate[linked]] >= 0]
    knuckles = checked.linked[mate[linked]]
    slips = axis_slips_mm(sheet, state, knuckles)
    apart = np.full(len(pairs), -np.inf)
    across = np.flatnonzero(mate >= 0)
    apart[across] = apart_along(bodies, pairs[across], halfway_normals(sheet, state, edges[across]))
    if state.stage != Stage.FLAT:
        apart[linked] = knuckled_mm(sheet, state, knuckles, slips)
    undecided = np.setdiff1d(np.flatnonzero(apart < wanted), linked)  # no plane parts linked ones
    apart[undecided] = np.maximum(
        apart[undecided], apart_at_least(bodies, pairs[undecided], wanted[undecided])
    )
    depth = np.maximum(-apart, 0.0)
    # barrels lie within each other: they share what they slip beyond their play
    depth[linked] = np.maximum(slips - sheet.knuckles.play_mm, 0.0)
    placed = _Placed(checked, state, {})
    exact = (apart < wanted) & ~touch
    apart, overlap = _measured(placed, pairs, touch, wanted, apart, least)
    # of knuckles the bound is as good as exact
    known = exact | np.isin(np.arange(len(pairs)), linked)
    apart = _with_closest_measured(placed, pairs, np.flatnonzero(~touch), apart, known)
    return PairCheck(
        state, checked.names, checked.faces, pairs, edges, touch, wanted, apart, overlap, depth
    )


def _wanted_mm(
    bodies: Bodies,
    pairs: IntArray,
    mate: IntArray,
    touch: BoolArray,
    promised: FloatArray,
    least: float,
    state: FoldedState,
) -> FloatArray:
    """The distance that each pair must keep, shape (n,), mm; negative where bodies may touch.

    mate : shape (n,), the row of each in `mates`, or -1. promised : of these, shape (k,).
    least : what all other pairs must keep.
    """
    wanted = np.full(len(pairs), least)
    # two faces that bend are that much nearer or farther than simulated
    kept = _KEPT * promised[mate[mate >= 0]] - 2 * state.bend_mm
    wanted[mate >= 0] = np.maximum(kept, 0.0)
    # of bodies that may touch, the common volume is at most the depth times a section
    first, second = pairs.T
    section = np.min([_widths(bodies)[side] for side in (first, second)], axis=0) ** 2
    with np.errstate(divide="ignore"):
        wanted[touch] = -OVERLAP_MM3 / section[touch]
    return wanted


def _by_pairs(checked: CheckedBodies, promised: FloatArray) -> FloatArray:
    """The least distance that any common crease of two panels promises, shape (k,), mm.

    What is measured is the distance of the panels, wherever they are nearest.
    """
    if not len(promised):
        return promised
    _, pair = np.unique(checked.mates, axis=0, return_inverse=True)
    least = np.full(int(pair.max()) + 1, np.inf)
    np.minimum.at(least, pair.ravel(), promised)
    return np.asarray(least[pair.ravel()])


@dataclass(frozen=True)
class _Placed:
    """Bodies for exact measures, in a state; each is placed once, when it is asked for."""

    checked: CheckedBodies
    state: FoldedState
    known: dict[int, Manifold]

    def solid(self, body: int) -> Manifold:
        if self.state.stage == Stage.FLAT:
            return self.checked.solids[body]
        if body not in self.known:
            face = self.checked.faces[body]
            motion = np.column_stack([self.state.turns[face], self.state.shifts[face]])
            self.known[body] = self.checked.solids[body].transform(motion)
        return self.known[body]

    def apart_mm(self, first: int, second: int, reach_mm: float) -> float:
        """Their distance, or the reach where it is larger."""
        return float(self.solid(first).min_gap(self.solid(second), reach_mm))

    def overlap_mm3(self, first: int, second: int) -> float:
        """Their common volume."""
        return float((self.solid(first) ^ self.solid(second)).volume())


def _measured(
    placed: _Placed,
    pairs: IntArray,
    touch: BoolArray,
    wanted: FloatArray,
    apart: FloatArray,
    least: float,
) -> tuple[FloatArray, FloatArray]:
    """Distances, exact where no bound reaches what is wanted, and common volumes, shape (n,)."""
    apart, overlap = apart.copy(), np.zeros(len(pairs))
    for pair in np.flatnonzero(apart < wanted).tolist():
        first, second = pairs[pair].tolist()
        if not touch[pair]:
            apart[pair] = placed.apart_mm(first, second, _REACH * max(wanted[pair], least))
        if touch[pair] or apart[pair] == 0.0:
            overlap[pair] = placed.overlap_mm3(first, second)
    return apart, overlap


def _with_closest_measured(
    placed: _Placed, pairs: IntArray, free: IntArray, apart: FloatArray, known: BoolArray
) -> FloatArray:
    """The distances with an exact one for the closest pair, found from the least bound upwards."""
    out = apart.copy()
    best = np.inf
    for pair in free[np.argsort(apart[free], kind="stable")].tolist():
        if apart[pair] >= best * (1 - _RESOLVED):
            break
        if not known[pair]:
            first, second = pairs[pair].tolist()
            out[pair] = placed.apart_mm(first, second, _REACH * apart[pair])
        best = min(best, float(out[pair]))
    return out


def _boxes_meet(bodies: Bodies, pairs: IntArray) -> BoolArray:
    low, high = bodies.boxes()
    first, second = pairs.T
    return np.asarray(((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1))


def _pairs(checked: CheckedBodies, near: IntArray) -> tuple[IntArray, IntArray]:
    """Mates and other pairs, each once, sorted; and the row of each in `mates`, or -1."""
    both = np.concatenate([checked.mates, near])
    row = np.concatenate([np.arange(len(checked.mates)), np.full(len(near), -1)])
    order = np.lexsort((row < 0, both[:, 1], both[:, 0]))
    both, row = both[order], row[order]
    kept = np.ones(len(both), bool)
    kept[1:] = (both[1:] != both[:-1]).any(axis=1)
    # two panels with several creases in common are a pair for each of them
    kept |= row >= 0
    return both[kept], row[kept]


def _widths(bodies: Bodies) -> FloatArray:
    low, high = bodies.boxes()
    return norm(high - low)
