"""The surface of a sheet whose parts may touch: vertices, edges and triangles, and how far apart.

What may touch is a vertex and a triangle, or two edges, that have no vertex in common: where none
of these pass through each other, no triangles do. A pair has four vertices, of a vertex and a
triangle the vertex first.

In the flat sheet parts that belong together are near to each other. So a pair keeps at most half of
its flat distance; parts that touch in the flat sheet, as the sides of a slit do, keep none, and are
not in contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array

from fab.folding.bar_hinge_model import Framework
from fab.folding.contact.closest_points import segment_weights, separations, triangle_weights
from solver.vectors import BoolArray, FloatArray, IntArray, dot, norm

__all__ = ["Pairs", "Surface", "surface_of", "weights_of"]

# Parts that are nearer to each other when flat, relative to the size of the sheet, touch.
_TOUCHING = 1e-7
# Of the flat distance: what a pair keeps at least, and how far beyond its barrier reaches.
_KEPT, _REACHED = 0.5, 0.4


@dataclass(frozen=True)
class Surface:
    """What may touch. Lengths are relative to the size of the sheet.

    Attributes
    ----------
    flat : shape (nv, 3), vertices of the flat sheet.
    edges, triangles : shapes (ne, 2) and (nt, 3).
    joined : shape (k,), rising numbers u * nv + v of vertices u and v of one face.
    gap : the distance of two layers' middles that touch: the thickness of the sheet.
    """

    flat: FloatArray
    edges: IntArray
    triangles: IntArray
    joined: IntArray
    gap: float

    @property
    def parts(self) -> int:
        """Number of vertices, triangles and edges together, numbered in this order."""
        return len(self.flat) + len(self.triangles) + len(self.edges)

    @cached_property
    def side(self) -> float:
        """Mean length of the edges."""
        ends = self.flat[self.edges]
        return float(norm(ends[:, 1] - ends[:, 0]).mean())

    def pairs(
        self, vertices: IntArray, triangles: IntArray, edges: IntArray, reach: float
    ) -> Pairs:
        """Those of vertices and triangles, shape (n,) both, and of edges, shape (m, 2).

        Without those that have a vertex in common, or touch when flat. reach : the farthest of any
        barrier.
        """
        corners = self.triangles[triangles]
        apart = (corners != vertices[:, None]).all(axis=1)
        first = np.column_stack([vertices, corners])[apart]
        count = len(self.flat)
        faced = np.column_stack([vertices, count + triangles])[apart]
        ends = self.edges[edges]
        apart = (ends[:, 0, :, None] != ends[:, 1, None, :]).all(axis=(1, 2))
        second = ends[apart].reshape(-1, 4)
        crossed = count + len(self.triangles) + edges[apart]
        return self._kept(first, second, np.concatenate([faced, crossed]), reach)

    def boxes(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Boxes of all parts while vertices stay in theirs, (nv, 3) each; shape (2, 3, n)."""
        least, most = low.T, high.T
        return np.stack(
            [
                np.concatenate([x, f(x[:, self.triangles], axis=2), f(x[:, self.edges], axis=2)], 1)
                for x, f in ((least, np.min), (most, np.max))
            ]
        )

    def _kept(self, first: IntArray, second: IntArray, parts: IntArray, reach: float) -> Pairs:
        """Pairs, with the gaps and limits of those that are not far from each other when flat."""
        members, faced = np.concatenate([first, second]), len(first)
        middles, radii = self._spheres
        arm = middles[parts[:, 0]] - middles[parts[:, 1]]
        flat = np.sqrt(dot(arm, arm)) - radii[parts].sum(axis=1)
        close = np.flatnonzero(flat < max(self.gap / _KEPT, self.gap + reach / _REACHED))
        points = self.flat[members[close]]
        weights = weights_of(points, int(np.searchsorted(close, faced)))
        flat[close], _ = separations(points, weights)
        far = flat > _TOUCHING
        gap = np.minimum(self.gap, _KEPT * flat)
        gap[faced:][self._are_joined(second)] = 0.0
        gap = gap[far]
        limit = _REACHED * (flat[far] - gap)
        return Pairs(members[far], int(far[:faced].sum()), parts[far], gap, limit)

    @cached_property
    def _spheres(self) -> tuple[FloatArray, FloatArray]:
        """Centres and radii of spheres around all parts of the flat sheet."""
        boxes = self.boxes(self.flat, self.flat)
        sides = boxes[1] - boxes[0]
        return boxes.mean(axis=0).T, np.sqrt((sides * sides).sum(axis=0)) / 2

    def _are_joined(self, edges: IntArray) -> BoolArray:
        """Whether one of their ends each is of one face, shape (n,); edges : shape (n, 4)."""
        keys = edges[:, :2, None] * len(self.flat) + edges[:, None, 2:]
        place = np.minimum(np.searchsorted(self.joined, keys), len(self.joined) - 1)
        return np.asarray((self.joined[place] == keys).any(axis=(1, 2)))


@dataclass(frozen=True)
class Pairs:
    """Pairs that may touch, those of a vertex and a triangle first.

    Attributes
    ----------
    members : shape (n, 4), vertices. faced : number of pairs of a vertex and a triangle.
    parts : shape (n, 2), numbers of both parts (`Surface.parts`).
    gap : shape (n,), the distance that they keep. limit : shape (n,), the farthest reach of their
        barriers beyond it, so that the flat sheet is free.
    """

    members: IntArray
    faced: int
    parts: IntArray
    gap: FloatArray
    limit: FloatArray

    def chosen(self, which: IntArray) -> Pairs:
        """Some of them; which : rising, shape (k,)."""
        faced = int(np.searchsorted(which, self.faced))
        return Pairs(
            self.members[which], faced, self.parts[which], self.gap[which], self.limit[which]
        )

    def meeting(self, boxes: FloatArray, reach: float | FloatArray) -> IntArray:
        """Those whose boxes are nearer than their gap and reach, rising; boxes : (2, 3, n)."""
        near = np.arange(len(self.parts))
        most = self.gap + reach
        for low, high in zip(*boxes, strict=True):
            first, second = self.parts[near].T
            apart = np.maximum(low[first] - high[second], low[second] - high[first])
            near = near[apart <= most[near]]
        return near


def weights_of(points: FloatArray, faced: int) -> FloatArray:
    """Weights of the closest points of pairs, the first `faced` of a vertex and a triangle."""
    if faced == len(points):
        return triangle_weights(points)
    if not faced:
        return segment_weights(points)
    return np.concatenate([triangle_weights(points[:faced]), segment_weights(points[faced:])])


def surface_of(frame: Framework, thickness_mm: float = 0.0) -> Surface:
    """That of a framework, whose layers are thickness_mm apart where they touch."""
    sheet = frame.sheet.pattern
    count = len(frame.vertices_coords)
    of = np.repeat(np.arange(sheet.face_count), np.diff(sheet.faces_offsets))
    ones = np.ones(len(of), np.int64)
    corners = coo_array((ones, (sheet.faces_vertices, of)), shape=(count, sheet.face_count)).tocsr()
    first, second = (corners @ corners.T).nonzero()
    return Surface(
        frame.vertices_coords,
        frame.bars_vertices,
        frame.triangles_vertices,
        np.sort(first.astype(np.int64) * count + second),
        thickness_mm / frame.size_mm,
    )
