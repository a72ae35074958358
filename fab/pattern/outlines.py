"""Outlines along which a pattern is cut out, and the cuts inside it."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree

from fab.geometry.rings import ring_areas
from fab.pattern.crease_pattern import CreasePattern
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["SAME_PLACE_MM", "Outlines", "inner_cuts", "outlines_of"]

# Vertices of the border nearer than this are one place; a cut between them would be cut twice.
SAME_PLACE_MM = 1e-6
# A bend of less than this (its sine) does not interrupt a straight cut.
_STRAIGHT = 1e-9


@dataclass(frozen=True)
class Outlines:
    """What is cut through, each line once, mm.

    Attributes
    ----------
    rings : closed polylines, each of shape (m, 2), material on their left: outer ones run
        counterclockwise, holes clockwise; largest area first. None passes a place twice.
    slits : cuts inside the material, shape (n, 2, 2), joined to chains: each begins where the one
        before it ends, as long as a chain lasts.
    """

    rings: tuple[FloatArray, ...]
    slits: FloatArray


def inner_cuts(pattern: CreasePattern) -> BoolArray:
    """Which edges are cuts between two faces: assigned C, or B though both faces are there."""
    return np.isin(pattern.edges_assignment, ["B", "C"]) & (pattern.edges_faces[:, 1] >= 0)


def outlines_of(pattern: CreasePattern) -> Outlines:
    """Rings around the faces, and the cuts between them.

    Sides of faces that lie on each other from both sides (a seam, the two lips of a slit) are one
    inner cut. Where the border touches itself in a vertex, rings are split there.
    """
    border = np.flatnonzero(pattern.edges_faces[:, 1] < 0)
    inner = np.flatnonzero(inner_cuts(pattern))
    used = np.unique(pattern.edges_vertices[np.concatenate([border, inner])])
    place = np.arange(len(pattern.vertices_coords))
    place[used] = used[_same_places(pattern.vertices_coords[used])]
    sides = place[pattern.edges_vertices[border]]
    places = np.unique(place[used])
    sides = _split(pattern.vertices_coords, sides[sides[:, 0] != sides[:, 1]], places)
    pairs, which = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    forward = np.where(sides[:, 0] < sides[:, 1], 1, -1)
    net = np.zeros(len(pairs), np.int64)
    np.add.at(net, which, forward)
    cuts = place[pattern.edges_vertices[inner]]
    cuts = _split(pattern.vertices_coords, cuts[cuts[:, 0] != cuts[:, 1]], places)
    cuts = np.sort(cuts, axis=1)
    lips = pairs[net == 0]
    directed = np.where(net[:, None] > 0, pairs, pairs[:, ::-1])
    rings = _rings(pattern.vertices_coords, np.repeat(directed, np.abs(net), axis=0))
    outer = {tuple(pair) for pair in pairs[net != 0].tolist()}
    inside = {tuple(pair) for pair in np.concatenate([cuts, lips]).tolist()} - outer
    return Outlines(rings, _chains(pattern.vertices_coords, sorted(inside)))


def _same_places(points: FloatArray) -> IntArray:
    """For each point the index of the first point in its place, shape (n,)."""
    near = cKDTree(points).query_pairs(SAME_PLACE_MM, output_type="ndarray")
    label = labels(near, len(points))
    _, first = np.unique(label, return_index=True)
    out: IntArray = first[label]
    return out


def _split(coords: FloatArray, sides: IntArray, places: IntArray) -> IntArray:
    """Sides split at the places that lie on them, so that partners of other lengths are found."""
    if not len(sides):
        return sides
    tree = shapely.STRtree(shapely.linestrings(coords[sides]))
    points = shapely.points(coords[places])
    point, side = tree.query(points, predicate="dwithin", distance=SAME_PLACE_MM)
    inside = (sides[side] != places[point, None]).all(axis=1)
    point, side = places[point[inside]], side[inside]
    # every side as its start, the places on it in their order, and its end
    stop = np.concatenate([sides[:, 0], point, sides[:, 1]])
    number = np.arange(len(sides))
    owner = np.concatenate([number, side, number])
    start = coords[sides[owner, 0]]
    order = np.lexsort((np.hypot(*(coords[stop] - start).T), owner))
    stop, owner = stop[order], owner[order]
    same = owner[1:] == owner[:-1]
    out: IntArray = np.column_stack([stop[:-1], stop[1:]])[same]
    return out


def _rings(coords: FloatArray, sides: IntArray) -> tuple[FloatArray, ...]:
    """Directed sides joined to closed polylines that pass no vertex twice; largest area first."""
    follow = _following(coords, sides).tolist()
    start = sides[:, 0].tolist()
    done = [False] * len(sides)
    rings = []
    for first in range(len(sides)):
        path: list[int] = []
        at: dict[int, int] = {}
        side = first
        while not done[side]:
            done[side] = True
            vertex = start[side]
            if vertex in at:  # pinched: what lies between both visits is a ring of its own
                rings.append(path[at[vertex] :])
                for passed in path[at[vertex] :]:
                    del at[passed]
                del path[len(path) - len(rings[-1]) :]
            at[vertex] = len(path)
            path.append(vertex)
            side = follow[side]
        if path:
            rings.append(path)
    if not rings:
        return ()
    offsets = np.concatenate([[0], np.cumsum([len(ring) for ring in rings])])
    corners = coords[np.concatenate([np.array(ring) for ring in rings])]
    order = np.argsort(-np.abs(ring_areas(corners, offsets)), kind="stable")
    return tuple(corners[offsets[i] : offsets[i + 1]] for i in order.tolist())


def _following(coords: FloatArray, sides: IntArray) -> IntArray:
    """The side after each one: where several begin, the one across the same material."""
    order = np.argsort(sides[:, 0], kind="stable")
    starts = sides[order, 0]
    low = np.searchsorted(starts, sides[:, 1])
    high = np.searchsorted(starts, sides[:, 1], side="right")
    follow: IntArray = order[low]
    arm = coords[sides[:, 1]] - coords[sides[:, 0]]
    angle = np.arctan2(arm[:, 1], arm[:, 0])
    touching = defaultdict(list)
    for side in np.flatnonzero(high - low > 1).tolist():
        touching[int(sides[side, 1])].append(side)
    for arriving in touching.values():
        leaving = order[low[arriving[0]] : high[arriving[0]]].tolist()
        for side in arriving:
            back = angle[side] + np.pi
            # material is on the left: clockwise from the arriving side to the leaving one
            turns = np.mod(back - angle[leaving], 2 * np.pi)
            follow[side] = leaving.pop(int(np.argmin(turns)))
    return follow


def _chains(coords: FloatArray, pairs: list[tuple[int, ...]]) -> FloatArray:
    """Cuts joined head to tail, straight on where several go on; straight runs become one cut."""
    at: defaultdict[int, set[int]] = defaultdict(set)
    for a, b in pairs:
        at[a].add(b)
        at[b].add(a)
    # chains begin at their ends, closed ones anywhere
    starts = sorted(at, key=lambda vertex: (len(at[vertex]) % 2 == 0, vertex))
    cuts: list[tuple[FloatArray, FloatArray]] = []
    for start in starts:
        while at[start]:
            vertex, heading = start, None
            fresh = True
            while at[vertex]:
                neighbours = sorted(at[vertex])
                arms = coords[neighbours] - coords[vertex]
                arms /= np.hypot(arms[:, 0], arms[:, 1])[:, None]
                chosen = 0 if heading is None else int(np.argmax(arms @ heading))
                onward = neighbours[chosen]
                at[vertex].remove(onward)
                at[onward].remove(vertex)
                turn = arms[chosen]
                straight = heading is not None and (
                    abs(heading[0] * turn[1] - heading[1] * turn[0]) < _STRAIGHT
                    and heading @ turn > 0
                )
                if straight and not fresh:
                    cuts[-1] = (cuts[-1][0], coords[onward])
                else:
                    cuts.append((coords[vertex], coords[onward]))
                vertex, heading, fresh = onward, turn, False
    return np.array(cuts).reshape(-1, 2, 2)
