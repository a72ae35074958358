"""Rings of corners that bound the planar sides of bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.geometry.bodies import Bodies
from solver.errors import InvalidState
from solver.graphs import EdgeIndex, labels
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray, cross, norm

__all__ = ["SideLoops", "cycles", "side_loops"]


@dataclass(frozen=True)
class SideLoops:
    """The rings around all sides of bodies: of each body, of each side, its outer ring first.

    Attributes
    ----------
    corners : shape (total,), numbers of vertices; the side lies on the left of its rings, seen
        from outside.
    offsets : ring i has the corners offsets[i]:offsets[i + 1].
    bodies : shape (n,), the body of each ring, rising.
    outer : shape (n,), whether it is the outer ring of its side, and not that of a hole.
    normals : shape (n, 3), unit normal of its side, outwards.
    """

    corners: IntArray
    offsets: IntArray
    bodies: IntArray
    outer: BoolArray
    normals: FloatArray


def side_loops(bodies: Bodies) -> SideLoops:
    """The rings around the sides of all bodies; a side is a connected part of a plane.

    Rings that meet in a vertex stay apart: around it they go on within the same fan of triangles.
    Vertices within a side are in no ring.

    Raises `InvalidState` where triangles do not close a body.
    """
    triangles = bodies.triangles
    if not len(triangles):
        none = np.empty(0, np.int64)
        return SideLoops(none, np.zeros(1, np.int64), none, none.astype(bool), np.empty((0, 3)))
    start = triangles.ravel()
    after = np.roll(triangles, -1, axis=1).ravel()
    twin = _twins(start, after, len(bodies.vertices_coords))
    plane = np.repeat(bodies.triangles_plane, 3)
    border = plane != plane[twin]
    half = np.arange(len(start))
    inside = np.column_stack([half[~border] // 3, twin[~border] // 3])
    side = np.repeat(labels(inside, len(triangles)), 3)
    ahead = half - half % 3 + (half + 1) % 3  # next half edge of the same triangle
    members = np.flatnonzero(border)
    following = ahead.copy()
    turning = members
    while len(turning := turning[~border[following[turning]]]):
        following[turning] = ahead[twin[following[turning]]]
    corners, offsets = cycles(members, following)
    first = corners[offsets[:-1]]
    body = np.repeat(bodies.triangles_body, 3)[first]
    coords = bodies.vertices_coords[start[corners]]
    coords = coords - np.repeat(coords[offsets[:-1]], np.diff(offsets), axis=0)
    area = np.add.reduceat(cross(coords, coords[next_corner(offsets)]), offsets[:-1])
    size = norm(area)
    order = np.lexsort([first, -size, side[first], body])
    outer = np.ones(len(order), bool)
    outer[1:] = np.diff(side[first[order]]) != 0
    normals = (area / size[:, None])[order][np.flatnonzero(outer)[np.cumsum(outer) - 1]]
    sizes = np.diff(offsets)[order]
    ends = np.concatenate([[0], np.cumsum(sizes)])
    place = np.repeat(offsets[:-1][order] - ends[:-1], sizes) + np.arange(ends[-1])
    return SideLoops(start[corners[place]], ends, body[order], outer, normals)


def _twins(start: IntArray, end: IntArray, count: int) -> IntArray:
    """The half edge that runs back along each one."""
    index = EdgeIndex.of(np.column_stack([start, end]), count, directed=True)
    twin = index.find(np.column_stack([end, start]))
    if twin.min() < 0 or (np.diff(index.keys) == 0).any():
        raise InvalidState(
            "bodies",
            f"an edge of the {len(start) // 3} triangles is not between exactly two of them",
            "Give closed surfaces, their triangles counterclockwise seen from outside.",
        )
    return twin


def cycles(members: IntArray, following: IntArray) -> tuple[IntArray, IntArray]:
    """The cycles of a permutation of some numbers, rising, each from its least: all in turn, and
    where each begins.
    """
    ring_of = labels(np.column_stack([members, following[members]]), len(following))[members]
    _, first = np.unique(ring_of, return_index=True)
    begin = at = members[np.sort(first)]
    ring = np.arange(len(at))
    rings, steps = [ring], [at]
    while len(at):
        going = following[at] != begin
        at, begin, ring = following[at][going], begin[going], ring[going]
        rings.append(ring)
        steps.append(at)
    owner = np.concatenate(rings)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(steps)[order], np.concatenate([[0], np.cumsum(np.bincount(owner))])
