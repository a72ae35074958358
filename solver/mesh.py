"""Quad meshes: patches with a grid of vertices, their edges, neighbours and boundary.

A patch of R rows and C columns is numbered row after row where it was grown at the top alone:

     side "top"                     vertices of a face, counterclockwise
     12---13---14---15              seen from the upper side:
      |  6 |  7 |  8 |
      8----9---10---11                   3---2
      |  3 |  4 |  5 |                   |   |
      4----5----6----7                   0---1
      |  0 |  1 |  2 |
      0----1----2----3              row 0 is the bottom, column 0 the left

A closed patch (a tube or a ring of cones) has the same numbering; its last column is joined to its
first by one more face in every row, and it has no left and right side.

Growth on other sides gives new vertices and faces the next free numbers; old numbers never change,
and `grid` keeps which vertex is at (row, column), or -1 where there is none: there the outline
has a concave corner (`solver.corner`). A corner filled by a five-sided face leaves the grid of the
rows around it, which holds only the last part of the patch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from solver.errors import InvalidState, InvalidValue
from solver.graphs import edge_keys
from solver.vectors import BoolArray, FloatArray, IntArray, numbers, points

__all__ = [
    "Edges",
    "QuadMesh",
    "Side",
    "boundary_loops",
    "edges_of",
    "grid_faces",
    "interior_vertices",
]


class Side(StrEnum):
    """A side of a patch, as drawn in the module's numbering."""

    TOP = "top"
    RIGHT = "right"
    BOTTOM = "bottom"
    LEFT = "left"


# Quarter turns (numpy.rot90) that bring a side to the top; fronts then run left to right.
_TURNS = {Side.TOP: 0, Side.LEFT: 1, Side.BOTTOM: 2, Side.RIGHT: 3}


def _turns(side: Side) -> int:
    if side not in list(Side):
        raise InvalidValue("side", repr(side), f"be one of {', '.join(Side)}", "See `Side`.")
    return _TURNS[side]


@dataclass(frozen=True)
class Edges:
    """Unique edges of a polygon mesh.

    Attributes
    ----------
    edges_vertices : shape (ne, 2); edge direction is that of its first face.
    edges_faces : shape (ne, 2), the face on the left of the edge and the other one;
        -1 in the second column at the boundary.
    """

    edges_vertices: IntArray
    edges_faces: IntArray


@dataclass(frozen=True)
class QuadMesh:
    """A patch of planar quads in space, with pentagons at unmatched corners. Arrays are read-only.

    Attributes
    ----------
    vertices_coords : shape (nv, 3).
    faces_vertices : shape (nf, 4), counterclockwise seen from the upper side.
    grid : shape (R, C), the vertex at each row and column, -1 for none; with R = 1 the mesh is a
        curve.
    closed : whether the last column is joined to the first.
    pentagons : shape (np, 5), counterclockwise too.
    """

    vertices_coords: FloatArray
    faces_vertices: IntArray
    grid: IntArray
    closed: bool = False
    pentagons: IntArray = field(default_factory=lambda: np.empty((0, 5), np.int64))

    def __post_init__(self) -> None:
        for array in (self.vertices_coords, self.faces_vertices, self.grid, self.pentagons):
            array.flags.writeable = False

    @classmethod
    def from_rows(
        cls, rows: FloatArray | Sequence[FloatArray], *, closed: bool = False
    ) -> QuadMesh:
        """The patch with the vertices `rows`, shape (R, C, 3), numbered row after row.

        closed : whether each row is a loop; its first vertex is not repeated.

        Raises `InvalidValue` for other shapes, fewer than 3 columns, or bad coordinates (see
        `solver.vectors.points`).

        >>> y, x = np.mgrid[:2, :3]
        >>> mesh = QuadMesh.from_rows(np.stack([x, y, 0 * x], axis=-1))
        >>> mesh.faces_vertices.tolist()
        [[0, 1, 4, 3], [1, 2, 5, 4]]
        >>> mesh.front_vertices(Side.LEFT).tolist()
        [0, 3]
        """
        coords = numbers("rows", rows)
        if coords.ndim != 3 or coords.shape[2] != 3 or coords.shape[0] < 1 or coords.shape[1] < 3:
            raise InvalidValue(
                "rows",
                f"array of shape {coords.shape}",
                "have shape (rows, columns, 3) with at least 1 row and 3 columns",
                "Give one row of points per grid row.",
            )
        grid = np.arange(coords.shape[0] * coords.shape[1]).reshape(coords.shape[:2])
        return cls(
            points("rows", coords.reshape(-1, 3)).copy(), grid_faces(grid, closed), grid, closed
        )

    @cached_property
    def edges(self) -> Edges:
        """Unique edges with the faces beside them."""
        return edges_of(*self.polygons)

    @cached_property
    def polygons(self) -> tuple[IntArray, IntArray]:
        """Corners of all faces, one face after another, and where each face begins, (nf + 1,).

        The quads come first, in their order, then the pentagons.
        """
        quads, five = self.faces_vertices, self.pentagons
        sizes = np.repeat([4, 5], [len(quads), len(five)])
        corners = np.concatenate([quads.ravel(), five.ravel()])
        return corners, np.concatenate([[0], np.cumsum(sizes)])

    def turned(self, side: Side) -> IntArray:
        """The grid seen with `side` on top."""
        out: IntArray = np.rot90(self.grid, _turns(side))
        return out

    def front_vertices(self, side: Side) -> IntArray:
        """Vertex numbers along `side`, in the direction that has new growth on its left.

        -1 where there is none. Raises `InvalidValue` for a side on which nothing can grow.
        """
        if self.closed and side in (Side.LEFT, Side.RIGHT):
            raise InvalidValue(
                "side", side, "be top or bottom on a closed patch", "Cut it open for other sides."
            )
        if len(self.pentagons) and side is Side.BOTTOM:
            raise InvalidValue(
                "side",
                side,
                "not be bottom behind an unmatched corner",
                "Grow there before the corner is filled.",
            )
        front: IntArray = self.turned(side)[-1]
        return front

    def previous_vertices(self, side: Side) -> IntArray | None:
        """Vertex numbers of the grid line behind the front; None where the front is a curve."""
        turned = self.turned(side)
        if len(turned) == 1:
            return None
        behind: IntArray = turned[-2]
        return behind

    def extended(self, side: Side, rows: FloatArray, first: int = 0) -> QuadMesh:
        """The mesh with `rows`, shape (n, C', 3), grown one after another on `side`.

        first : front vertex at which the rows begin, where they are grown on a part of the front.
        """
        turned = self.turned(side)
        if (
            rows.ndim != 3
            or rows.shape[2] != 3
            or not 1 <= rows.shape[1] <= turned.shape[1] - first
        ):
            raise InvalidValue(
                "rows",
                f"array of shape {rows.shape}",
                f"have shape (n, {turned.shape[1] - first}, 3)",
                "Give one point a row for each vertex of the side.",
            )
        count, width = rows.shape[:2]
        new = np.full((count, turned.shape[1]), -1)
        numbers = len(self.vertices_coords) + np.arange(count * width)
        new[:, first : first + width] = numbers.reshape(count, width)
        return self.filled(side, np.vstack([turned, new]), rows.reshape(-1, 3))

    def filled(self, side: Side, turned: IntArray, coords: FloatArray) -> QuadMesh:
        """The mesh with the new vertices `coords`, and quads between four corners of the grid.

        turned : the grid with the new vertices' numbers, seen with `side` on top.
        """
        faces = grid_faces(turned, self.closed)
        fresh = (faces.min(axis=1) >= 0) & (faces.max(axis=1) >= len(self.vertices_coords))
        return replace(
            self,
            vertices_coords=np.concatenate([self.vertices_coords, coords]),
            faces_vertices=np.concatenate([self.faces_vertices, faces[fresh]]),
            grid=np.rot90(turned, -_turns(side)).copy(),
        )

    def with_faces(self, kept: BoolArray) -> QuadMesh:
        """The patch with the faces `kept` alone, by row and column of the grid, (R - 1, C - 1).

        Faces can be kept where the grid has all four corners; on a closed patch kept has shape
        (R - 1, C). Vertices that no face uses any more are dropped, the others numbered anew in
        the same order; `grid` is -1 where there is none.
        """
        faces = grid_faces(self.grid, self.closed)[kept.ravel()]
        used = np.zeros(len(self.vertices_coords), bool)
        used[faces] = True
        number = np.where(used, np.cumsum(used) - 1, -1)
        grid = np.where(self.grid >= 0, number[self.grid], -1)
        return QuadMesh(self.vertices_coords[used], number[faces], grid, self.closed)

    def cut_open(self) -> QuadMesh:
        """The patch with a closed one's first column doubled behind its last, to lie flat.

        The new vertices take the next free numbers; an open patch is returned as it is.
        """
        if not self.closed:
            return self
        seam = self.grid[:, 0]
        new = len(self.vertices_coords) + np.arange(len(seam))
        grid = np.column_stack([self.grid, new])
        coords = np.concatenate([self.vertices_coords, self.vertices_coords[seam]])
        return QuadMesh(coords, grid_faces(grid, closed=False), grid)


def grid_faces(grid: IntArray, closed: bool) -> IntArray:
    """Faces between the rows and columns of a grid of vertices (R, C), row after row, (nf, 4)."""
    if closed:
        grid = np.column_stack([grid, grid[:, 0]])
    corners = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
    return np.stack(corners, axis=-1).reshape(-1, 4).astype(np.int64)


def edges_of(corners: IntArray, offsets: IntArray) -> Edges:
    """Unique edges of polygons, in the order in which the faces first name them.

    corners : vertices of all faces, one face after another; offsets : where each face begins,
    shape (nf + 1,). Raises `InvalidState` where an edge has more than two faces or two faces
    run along it in the same direction.

    >>> edges = edges_of(np.array([0, 1, 2, 2, 1, 3]), np.array([0, 3, 6]))
    >>> edges.edges_vertices.tolist()
    [[0, 1], [1, 2], [2, 0], [1, 3], [3, 2]]
    >>> edges.edges_faces[1].tolist()
    [0, 1]
    """
    sizes = np.diff(offsets)
    face = np.repeat(np.arange(len(sizes)), sizes)
    following = np.arange(len(corners)) + 1
    following[offsets[1:] - 1] = offsets[:-1]
    start, end = corners, corners[following]
    count = int(corners.max()) + 1 if len(corners) else 0
    key = edge_keys(np.column_stack([start, end]), count)
    order = np.argsort(key, kind="stable")
    first = np.ones(len(key), bool)
    first[1:] = key[order][1:] != key[order][:-1]
    group = np.cumsum(first) - 1
    members = np.bincount(group)
    heads = order[first]
    second = np.full(len(heads), -1)
    shared = ~first
    second[group[shared]] = order[shared]
    crowded = np.flatnonzero(members > 2)
    if len(crowded):
        h = heads[crowded[0]]
        raise InvalidState(
            "faces",
            f"edge ({start[h]}, {end[h]}) belongs to {members[crowded[0]]} faces, not at most 2",
            "Split the sheet where more than two faces meet in an edge.",
        )
    paired = second >= 0
    same = paired.copy()
    same[paired] = start[heads[paired]] == start[second[paired]]
    if same.any():
        h = heads[np.flatnonzero(same)[0]]
        raise InvalidState(
            "faces",
            f"both faces of edge ({start[h]}, {end[h]}) run along it in the same direction",
            "Turn one of the two faces around.",
        )
    rank = np.argsort(heads)
    heads, second = heads[rank], second[rank]
    vertices = np.column_stack([start[heads], end[heads]])
    faces = np.column_stack([face[heads], np.where(second >= 0, face[second], -1)])
    return Edges(vertices, faces)


def interior_vertices(faces_vertices: IntArray, count: int) -> BoolArray:
    """Which of `count` vertices are surrounded by faces, shape (count,), for a manifold mesh.

    Around an interior vertex the vertices that follow it in its faces are those that precede it;
    at the boundary one of each is left over. Comparing the two sums needs no edge list.
    """
    following = np.roll(faces_vertices, -1, axis=1).ravel()
    preceding = np.roll(faces_vertices, 1, axis=1).ravel()
    corner = faces_vertices.ravel()
    balance = np.bincount(corner, (following - preceding).astype(np.float64), count)
    used = np.bincount(corner, minlength=count) > 0
    inside: BoolArray = (balance == 0) & used
    return inside


def boundary_loops(edges: Edges) -> list[IntArray]:
    """Boundary of the mesh as vertex loops, faces on the left; longest loop first.

    Raises `InvalidState` where the boundary touches itself in a vertex.
    """
    sides = edges.edges_vertices[edges.edges_faces[:, 1] < 0]
    follow = dict(zip(sides[:, 0].tolist(), sides[:, 1].tolist(), strict=True))
    if len(follow) != len(sides):
        values, counts = np.unique(sides[:, 0], return_counts=True)
        raise InvalidState(
            "edges",
            f"the boundary passes vertex {values[counts > 1][0]} more than once",
            "Split the vertex, or join the faces around it.",
        )
    loops = []
    while follow:
        start, vertex = next(iter(follow.items()))
        loop = []
        while vertex in follow:
            loop.append(vertex)
            vertex = follow.pop(vertex)
        loops.append(np.array([start, *loop[:-1]] if loop[-1] == start else loop))
    return sorted(loops, key=len, reverse=True)
