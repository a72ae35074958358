"""Which bodies of a thick sheet overlap in one state, and how near do the others come?

Panels across a crease must keep the distance that their setbacks promise (`fab.setbacks`), all
other pairs must not touch. Planes between two bodies prove most of this for all pairs at once
(`fab.separation`); what they leave open is measured exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fab.folding.folded_states import FoldedState, Stage
from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of
from fab.geometry.separating_planes import apart_along, apart_at_least, near_pairs
from fab.panels.setbacks import Setbacks
from fab.panels.thick_sheet import ThickSheet
from solver.vectors import BoolArray, FloatArray, IntArray, norm, unit

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["OVERLAP_MM3", "PairCheck", "ThickBodies", "check_pairs", "promised_mm", "thick_bodies"]

# manifold3d reports up to 5e-13 mm3 where two bodies only touch; real overlaps are far larger.
OVERLAP_MM3 = 1e-6
# Distances may fall short of what setbacks promise by rounding alone.
_KEPT = 0.97
# Distances are measured up to this multiple of what is wanted, or known to be.
_REACH = 1.5
# Fold angles of states are known to this.
_ANGLE_DEG = 1e-6
# The closest pair is told to this.
_TOLD = 1e-6


@dataclass(frozen=True)
class ThickBodies:
    """The bodies of a sheet that are checked together, as they lie when flat.

    Attributes
    ----------
    bodies : those with knuckles as their convex hulls, from which planes are as far away.
    solids : the bodies themselves, for exact measures.
    names : such as "panel 3". faces, creases : as in a `ThickSheet`.
    mates, mates_edge : shapes (k, 2) and (k,): panels across a crease, and that crease.
    linked : shape (k,), the number of the knuckles that join them, -1 without.
    """

    bodies: Bodies
    solids: list[Manifold]
    names: tuple[str, ...]
    faces: IntArray
    creases: IntArray
    mates: IntArray
    mates_edge: IntArray
    linked: IntArray


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
    apart_mm : shape (n,), at least so far apart; exact below `wanted_mm`, and for the closest pair
        unless knuckles join it.
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


def thick_bodies(sheet: ThickSheet, solids: list[Manifold], chosen: IntArray) -> ThickBodies:
    """Some of the bodies of a sheet, by rising number. solids : all of them."""
    faces, creases = sheet.faces[chosen], sheet.creases[chosen]
    place = np.full(sheet.pattern.face_count, -1)
    panels = np.flatnonzero((creases < 0) & (faces >= 0))
    place[faces[panels]] = panels
    mates = place[sheet.pattern.edges_faces]
    edges = np.flatnonzero(sheet.pattern.edges_joining & (mates >= 0).all(axis=1))
    all_of_them = len(chosen) == len(sheet.bodies)
    bodies = sheet.bodies if all_of_them else sheet.bodies.chosen(chosen)
    chosen_solids = [solids[body] for body in chosen.tolist()]
    with_barrels = np.isin(faces, _with_barrels(sheet)) & (creases < 0)
    if with_barrels.any():
        bodies = bodies_of(
            [
                _hull(chosen_solids[i]) if hollow else bodies.mesh(i)
                for i, hollow in enumerate(with_barrels.tolist())
            ]
        )
    linked = np.full(len(mates), -1)
    linked[sheet.knuckles.creases] = np.arange(len(sheet.knuckles.creases))
    return ThickBodies(
        bodies,
        chosen_solids,
        tuple(sheet.names[body].replace("_", " ") for body in chosen.tolist()),
        faces,
        creases,
        np.sort(mates[edges], axis=1),
        edges,
        linked[edges],
    )


def _with_barrels(sheet: ThickSheet) -> IntArray:
    """The faces whose panels have barrels."""
    return np.unique(sheet.pattern.edges_faces[sheet.knuckles.creases])


def _hull(solid: Manifold) -> TriangleMesh:
    """The convex hull of a body; each triangle is a side of its own."""
    mesh = solid.hull().to_mesh64()
    triangles = np.asarray(mesh.tri_verts, np.int64)
    coords = np.array(mesh.vert_properties[:, :3], np.float64)
    return TriangleMesh(coords, triangles, np.arange(len(triangles)))


def promised_mm(
    back: Setbacks, heights_mm: tuple[float, float], angles_deg: FloatArray
) -> FloatArray:
    """Distance of both panels of every crease at fold angles, shape (ne,), mm; 0 where they meet.

    Seen along the crease, a point of a panel that is set back by s at the height z lies
    s cos(rho / 2) - z sin(rho / 2) off the plane between both.
    """
    half = np.radians(angles_deg) / 2
    low, high = heights_mm
    ends = [low, high, 0.0] if low < 0 < high else [low, high]
    off = [back.at(z) * np.cos(half) - z * np.sin(half) for z in ends]
    return np.asarray(2 * np.maximum(np.min(off, axis=0), 0.0))


def check_pairs(sheet: ThickSheet, those: ThickBodies, state: FoldedState) -> PairCheck:
    """Check all pairs of some bodies, each with its face in a state, or where it is when flat."""
    moving = np.maximum(those.faces, 0)
    bodies = those.bodies
    if state.stage != Stage.FLAT:
        bodies = bodies.moved(state.turns[moving], state.shifts[moving])
    promised = _promised(sheet, those, state)
    least = float(promised.min(initial=np.inf))
    if not np.isfinite(least):
        least = 2 * float(sheet.panels.setbacks.axis_mm.max(initial=0.0))
    near = near_pairs(bodies, least)
    if state.stage != Stage.FLAT:  # pieces of a sheet have no common place when folded
        piece = sheet.pattern.faces_piece[moving]
        near = near[piece[near[:, 0]] == piece[near[:, 1]]]
    near = near[~_may_touch(those, near) | _boxes_meet(bodies, near)]
    pairs, mate = _pairs(those, near)
    one, two = pairs.T
    edges = np.where(mate >= 0, those.mates_edge[mate] if len(those.mates) else -1, -1)
    touch = _may_touch(those, pairs)
    wanted = np.full(len(pairs), least)
    # two faces that bend lie that much nearer or farther than simulated
    kept = _KEPT * promised[mate[mate >= 0]] - 2 * state.bend_mm
    wanted[mate >= 0] = np.maximum(kept, 0.0)
    # of bodies that may touch, the common volume is at most the depth times a section
    section = np.min([_widths(bodies)[side] for side in (one, two)], axis=0) ** 2
    with np.errstate(divide="ignore"):
        wanted[touch] = -OVERLAP_MM3 / section[touch]
    apart = np.full(len(pairs), -np.inf)
    across = np.flatnonzero(mate >= 0)
    middle = _between(sheet, state, edges[across])
    apart[across] = apart_along(bodies, pairs[across], middle)
    linked = np.flatnonzero(mate >= 0)
    linked = linked[those.linked[mate[linked]] >= 0]
    knuckles = those.linked[mate[linked]]
    slips = _slips_mm(sheet, state, knuckles)
    if state.stage != Stage.FLAT:
        apart[linked] = _turned_mm(sheet, state, knuckles, slips)
    undecided = np.setdiff1d(np.flatnonzero(apart < wanted), linked)  # no plane parts these
    apart[undecided] = np.maximum(
        apart[undecided], apart_at_least(bodies, pairs[undecided], wanted[undecided])
    )
    depth = np.maximum(-apart, 0.0)
    # barrels lie within each other: they share what they slip beyond their play
    depth[linked] = np.maximum(slips - sheet.knuckles.play_mm, 0.0)
    placed = _Placed(those, state, {})
    overlap = np.zeros(len(pairs))
    exact = (apart < wanted) & ~touch
    for pair in np.flatnonzero(apart < wanted).tolist():
        first, second = pairs[pair].tolist()
        if exact[pair]:
            apart[pair] = placed.apart(first, second, _REACH * max(wanted[pair], least))
        if touch[pair] or apart[pair] == 0.0:
            overlap[pair] = (placed.solid(first) ^ placed.solid(second)).volume()
    # of knuckles the bound is as good as exact
    known = np.isin(np.arange(len(pairs)), linked) & ~exact
    _measure_closest(placed, pairs, np.flatnonzero(~touch), apart, exact | known)
    return PairCheck(
        state, those.names, those.faces, pairs, edges, touch, wanted, apart, overlap, depth
    )


@dataclass(frozen=True)
class _Placed:
    """Bodies for exact measures, in a state; each is placed once, when it is asked for."""

    those: ThickBodies
    state: FoldedState
    known: dict[int, Manifold]

    def solid(self, body: int) -> Manifold:
        if self.state.stage == Stage.FLAT:
            return self.those.solids[body]
        if body not in self.known:
            face = self.those.faces[body]
            motion = np.column_stack([self.state.turns[face], self.state.shifts[face]])
            self.known[body] = self.those.solids[body].transform(motion)
        return self.known[body]

    def apart(self, one: int, two: int, reach_mm: float) -> float:
        """Their distance, or the reach where it is larger."""
        return float(self.solid(one).min_gap(self.solid(two), reach_mm))


def _promised(sheet: ThickSheet, those: ThickBodies, state: FoldedState) -> FloatArray:
    """What panels across a crease must keep, shape (k,), mm: what their setbacks promise, but
    linked ones their play; neither do barrels come nearer to any other panel.

    Between flat and the target it is the least of what they promise there and at the target.
    """
    panels = sheet.panels
    back, heights = panels.setbacks, panels.heights_mm
    out = promised_mm(back, heights, state.angles_deg)
    if state.stage == Stage.BETWEEN:
        out = np.fmin(promised_mm(back, heights, np.zeros_like(out)), back.clearance_mm)
    out = np.maximum(out[those.mates_edge], 0.0)
    barrels = np.isin(those.faces[those.mates], _with_barrels(sheet)).any(axis=1)
    out[barrels] = np.minimum(out[barrels], sheet.knuckles.play_mm)
    return np.where(those.linked >= 0, sheet.knuckles.play_mm, out)


def _slips_mm(sheet: ThickSheet, state: FoldedState, knuckles: IntArray) -> FloatArray:
    """How far apart a crease's ends lie at most, seen from both panels, mm, shape (k,)."""
    pattern = sheet.pattern
    edge = sheet.knuckles.creases[knuckles]
    ends = pattern.vertices_coords[pattern.edges_vertices[edge]]
    one, two = (
        ends @ state.turns[face][:, :, :2].swapaxes(1, 2) + state.shifts[face][:, None]
        for face in pattern.edges_faces[edge].T
    )
    return np.asarray(norm(one - two).max(axis=1, initial=0.0))


def _turned_mm(
    sheet: ThickSheet, state: FoldedState, knuckles: IntArray, slips_mm: FloatArray
) -> FloatArray:
    """How far linked panels are apart at least in a state, mm; -inf where this is not known.

    Panels without their barrels are parted by the plane between them. However far they turn about
    their axis between flat and the target, barrels and arms keep their play from all else
    (`fab.knuckles`). They reach r from the axis. Where its ends slip by s, what is farther than
    r + play from it comes nearer by s at most, and the rest by s + 2 s (r + play) / l, with the
    length l of the axis.
    """
    pattern, panels, play = sheet.pattern, sheet.panels, sheet.knuckles.play_mm
    edge = sheet.knuckles.creases[knuckles]
    bare = panels.bodies.moved(state.turns[panels.faces], state.shifts[panels.faces])
    mates = np.searchsorted(panels.faces, pattern.edges_faces[edge])
    parted = apart_along(bare, mates, _between(sheet, state, edge))
    start, end = pattern.vertices_coords[pattern.edges_vertices[edge]].swapaxes(0, 1)
    ends = [np.hypot(panels.setbacks.at(z)[edge], z) for z in panels.heights_mm]
    near = np.maximum(*ends) + play
    kept = play - slips_mm * (1 + 2 * near / norm(end - start))
    angle, most = state.angles_deg[edge], pattern.edges_foldAngle[edge]
    within = (angle * np.sign(most) >= -_ANGLE_DEG) & (np.abs(angle) <= np.abs(most) + _ANGLE_DEG)
    return np.where(within, np.minimum(parted, kept), -np.inf)


def _may_touch(those: ThickBodies, pairs: IntArray) -> BoolArray:
    """Bodies of one face, and hinges with whatever they are near to."""
    one, two = those.faces[pairs].T
    hinge = (those.faces < 0) | (those.creases >= 0)
    return np.asarray((one == two) | hinge[pairs].any(axis=1))


def _boxes_meet(bodies: Bodies, pairs: IntArray) -> BoolArray:
    low, high = bodies.boxes()
    one, two = pairs.T
    return np.asarray(((low[one] <= high[two]) & (low[two] <= high[one])).all(axis=1))


def _pairs(those: ThickBodies, near: IntArray) -> tuple[IntArray, IntArray]:
    """Mates and other pairs, each once, sorted; and the row of each in `mates`, or -1."""
    both = np.concatenate([those.mates, near])
    row = np.concatenate([np.arange(len(those.mates)), np.full(len(near), -1)])
    order = np.lexsort((row < 0, both[:, 1], both[:, 0]))
    both, row = both[order], row[order]
    first = np.ones(len(both), bool)
    first[1:] = (both[1:] != both[:-1]).any(axis=1)
    # two panels with several creases in common are a pair for each of them
    first |= row >= 0
    return both[first], row[first]


def _between(sheet: ThickSheet, state: FoldedState, edges: IntArray) -> FloatArray:
    """Normals of the planes halfway between both faces of some creases, shape (k, 3)."""
    start, end = sheet.pattern.vertices_coords[sheet.pattern.edges_vertices[edges]].swapaxes(0, 1)
    way = end - start
    inward = np.column_stack([-way[:, 1], way[:, 0]])
    one, two = sheet.pattern.edges_faces[edges].T
    both = state.turns[one] + state.turns[two]
    return unit(np.squeeze(both[:, :, :2] @ inward[:, :, None], axis=2))


def _widths(bodies: Bodies) -> FloatArray:
    low, high = bodies.boxes()
    return norm(high - low)


def _measure_closest(
    placed: _Placed, pairs: IntArray, free: IntArray, apart: FloatArray, known: BoolArray
) -> None:
    """Make the distance of the closest pair exact, from the least bound upwards."""
    best = np.inf
    for pair in free[np.argsort(apart[free], kind="stable")].tolist():
        if apart[pair] >= best * (1 - _TOLD):
            break
        if not known[pair]:
            one, two = pairs[pair].tolist()
            apart[pair] = placed.apart(one, two, _REACH * apart[pair])
        best = min(best, float(apart[pair]))
