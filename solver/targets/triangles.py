"""What triangles have: edges, angles, heights, barycentric coordinates, the nearest of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.graphs import edge_keys
from solver.vectors import FloatArray, IntArray, angle_between, cross, dot, norm

__all__ = [
    "TriangleTree",
    "barycentric",
    "corner_angles",
    "least_heights",
    "quads_cut",
    "triangle_edges",
]


@dataclass(frozen=True)
class TriangleTree:
    """Triangles among which the nearest one is found, by libigl's tree of boxes.

    Attributes
    ----------
    coords : shape (n, 3). triangles : shape (nf, 3). tree : `igl.AABB`.
    """

    coords: FloatArray
    triangles: IntArray
    tree: Any

    @classmethod
    def of(cls, coords: FloatArray, triangles: IntArray) -> TriangleTree:
        """The tree of triangles with vertices `coords`."""
        import igl

        coords, triangles = np.ascontiguousarray(coords), np.ascontiguousarray(triangles)
        tree = igl.AABB()
        tree.init(coords, triangles)
        return cls(coords, triangles, tree)

    def nearest(self, points: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """Distances (n,), numbers of the nearest triangles (n,), nearest points (n, 3).

        points : finite, shape (n, 3). Those that follow one another in space are found faster.
        """
        squared, number, foot = self.tree.squared_distance(
            self.coords, self.triangles, np.ascontiguousarray(points)
        )
        distance = np.sqrt(np.asarray(squared, np.float64).reshape(-1))
        return distance, np.asarray(number, np.int64).reshape(-1), np.asarray(foot).reshape(-1, 3)


def triangle_edges(triangles: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Ends of all edges (ne, 2), rising, and numbers (nf, 3): the edge after each corner.

    count : number of vertices.
    """
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1)
    keys, number = np.unique(edge_keys(ends, count), return_inverse=True)
    return np.column_stack([keys // count, keys % count]), number.reshape(-1, 3)


def quads_cut(coords: FloatArray, quads: IntArray) -> IntArray:
    """Triangles (2 nq, 3) of quads (nq, 4), cut along their shorter diagonals."""
    first, second = (norm(coords[quads[:, i]] - coords[quads[:, i + 2]]) for i in (0, 1))
    turned = np.where((second < first)[:, None], np.roll(quads, -1, axis=1), quads)
    return np.stack([turned[:, [0, 1, 2]], turned[:, [2, 3, 0]]], axis=1).reshape(-1, 3)


def corner_angles(coords: FloatArray, triangles: IntArray) -> FloatArray:
    """Angles of triangles at their corners, radians, shape (nf, 3)."""
    p = coords[triangles]
    return angle_between(np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p)


def least_heights(coords: FloatArray, triangles: IntArray) -> FloatArray:
    """The least height of each triangle, shape (nf,); NaN for a point."""
    p = coords[triangles]
    longest = norm(p - np.roll(p, 1, axis=1)).max(axis=1)
    with np.errstate(invalid="ignore"):
        out: FloatArray = norm(cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])) / longest
    return out


def barycentric(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Weights (n, 3) of the corners (n, 3, 3) whose mean is a point; NaN without an area."""
    a, b, c = (corners[:, i] for i in range(3))
    normal = cross(b - a, c - a)
    with np.errstate(invalid="ignore", divide="ignore"):
        second = dot(cross(points - a, c - a), normal) / dot(normal, normal)
        third = dot(cross(b - a, points - a), normal) / dot(normal, normal)
    return np.column_stack([1 - second - third, second, third])
