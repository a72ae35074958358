"""Half edges around the planar sides of bodies, and bodies made of such half edges again.

The inverse of `fab.geometry.side_loops`: rings are taken apart into half edges, some of which are
replaced, and what closes again is covered with triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.geometry.bodies import Bodies
from fab.geometry.rings import ring_areas
from fab.geometry.side_loops import cycles, side_loops
from fab.geometry.triangulation import covered
from solver.polygons import next_corner
from solver.vectors import FloatArray, IntArray

__all__ = ["HalfEdges", "bodies_from", "half_edges", "triangles_within"]


@dataclass(frozen=True)
class HalfEdges:
    """All edges around the sides of bodies; a side lies on their left, seen from outside.

    Attributes
    ----------
    start, end : shape (n,), numbers of vertices.
    sides : shape (n,), the side of each.
    normals : shape (number of sides, 3), outwards.
    bodies : shape (number of sides,), rising.
    """

    start: IntArray
    end: IntArray
    sides: IntArray
    normals: FloatArray
    bodies: IntArray

    def bottoms_and_tops(self, body_count: int) -> tuple[IntArray, IntArray]:
        """The sides of each body that look most downwards and most upwards, shapes (n,).

        The first ones of all bodies from 0 to `body_count` - 1; each must have a side.
        """
        order = np.lexsort((self.normals[:, 2], self.bodies))
        first = np.searchsorted(self.bodies, np.arange(body_count + 1))
        return order[first[:-1]], order[first[1:] - 1]


def half_edges(bodies: Bodies) -> HalfEdges:
    """The half edges of bodies. Raises `InvalidState` where triangles do not close one."""
    loops = side_loops(bodies)
    following = next_corner(loops.offsets)
    side = np.cumsum(loops.outer) - 1
    return HalfEdges(
        loops.corners,
        loops.corners[following] if len(following) else loops.corners,
        np.repeat(side, np.diff(loops.offsets)),
        loops.normals[loops.outer],
        loops.bodies[loops.outer],
    )


def triangles_within(edges: HalfEdges, coords: FloatArray) -> tuple[IntArray, IntArray]:
    """Triangles of all sides between their half edges, shape (k, 3), and the side of each, (k,).

    coords : shape (nv, 3). A side may be in several pieces, or be one piece with holes.
    """
    count = len(edges.start)
    starts = edges.sides * len(coords) + edges.start
    order = np.argsort(starts)
    following = order[np.searchsorted(starts[order], edges.sides * len(coords) + edges.end)]
    ring, offsets = cycles(np.arange(count), following)
    corners, first = edges.start[ring], ring[offsets[:-1]]
    side = edges.sides[first]
    flat = _flattened(coords[corners], edges.normals[edges.sides[ring]])
    # of one side, outer rings before those of holes
    hole = ring_areas(flat, offsets) < 0
    order = np.lexsort((hole, side))
    sizes = np.diff(offsets)[order]
    ends = np.concatenate([[0], np.cumsum(sizes)])
    place = np.repeat(offsets[:-1][order] - ends[:-1], sizes) + np.arange(ends[-1])
    regions = np.flatnonzero(np.concatenate([~hole[order], [True]]))
    found = covered(flat[place], ends, regions)
    return corners[place][found], np.repeat(side[order], sizes)[found[:, 0]]


def _flattened(points: FloatArray, normals: FloatArray) -> FloatArray:
    """Points without their coordinate along the axis nearest to a normal, seen against it."""
    axis = np.abs(normals).argmax(axis=1)
    row = np.arange(len(points))
    u, v = points[row, (axis + 1) % 3], points[row, (axis + 2) % 3]
    away = normals[row, axis] < 0
    return np.column_stack([np.where(away, v, u), np.where(away, u, v)])


def bodies_from(
    coords: FloatArray,
    vertices_body: IntArray,
    triangles: IntArray,
    triangles_plane: IntArray,
) -> Bodies:
    """Bodies from vertices and triangles in any order, each with at least one.

    coords : shape (nv, 3), mm; vertices_body : shape (nv,). triangles_plane : shape (nt,), equal
    for those of one planar side of one body.
    """
    order = np.argsort(vertices_body, kind="stable")
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(len(order))
    count = int(vertices_body.max(initial=-1)) + 1
    owner = vertices_body[triangles[:, 0]]
    rows = np.lexsort((triangles_plane, owner))
    plane, body = triangles_plane[rows], owner[rows]
    new = np.zeros(len(rows), bool)
    new[1:] = (np.diff(plane) != 0) | (np.diff(body) != 0)
    return Bodies(
        coords[order],
        np.searchsorted(vertices_body[order], np.arange(count + 1)),
        number[triangles[rows]],
        np.searchsorted(body, np.arange(count + 1)),
        np.cumsum(new),
    )
