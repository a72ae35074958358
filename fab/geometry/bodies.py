"""Closed solids with planar sides, all in one set of arrays.

Body i has the vertices vertices_offsets[i]:vertices_offsets[i + 1] and the triangles
triangles_offsets[i]:triangles_offsets[i + 1]; bodies share no vertices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fab.geometry.triangulation import cap_triangles
from solver.vectors import FloatArray, IntArray, cross, dot

__all__ = ["Bodies", "TriangleMesh", "bodies_of", "concatenated", "stacked"]


@dataclass(frozen=True)
class TriangleMesh:
    """A closed surface: vertices (nv, 3) in mm, triangles (nt, 3) seen from outside.

    triangles_plane : shape (nt,), equal for triangles of one planar side.
    """

    vertices_coords: FloatArray
    triangles: IntArray
    triangles_plane: IntArray


@dataclass(frozen=True)
class Bodies:
    """Closed polyhedra, each bounded by triangles.

    Attributes
    ----------
    vertices_coords : shape (nv, 3), mm.
    vertices_offsets : shape (n + 1,).
    triangles : shape (nt, 3), numbers of vertices, counterclockwise seen from outside.
    triangles_offsets : shape (n + 1,).
    triangles_plane : shape (nt,), equal for the triangles of one planar side of one body.
    """

    vertices_coords: FloatArray
    vertices_offsets: IntArray
    triangles: IntArray
    triangles_offsets: IntArray
    triangles_plane: IntArray

    def __len__(self) -> int:
        return len(self.vertices_offsets) - 1

    def mesh(self, i: int) -> TriangleMesh:
        """Body i alone."""
        first, end = self.vertices_offsets[i : i + 2]
        rows = slice(*self.triangles_offsets[i : i + 2])
        return TriangleMesh(
            self.vertices_coords[first:end],
            self.triangles[rows] - first,
            self.triangles_plane[rows],
        )

    @property
    def vertices_body(self) -> IntArray:
        """The body of every vertex, shape (nv,)."""
        return np.repeat(np.arange(len(self)), np.diff(self.vertices_offsets))

    @property
    def triangles_body(self) -> IntArray:
        """The body of every triangle, shape (nt,)."""
        return np.repeat(np.arange(len(self)), np.diff(self.triangles_offsets))

    def volumes_mm3(self) -> FloatArray:
        """Volumes by the divergence theorem, seen from the middle of each body, shape (n,)."""
        middles = np.add.reduceat(self.vertices_coords, self.vertices_offsets[:-1])
        middles /= np.diff(self.vertices_offsets)[:, None]
        owner = self.triangles_body
        a, b, c = (self.vertices_coords[self.triangles] - middles[owner][:, None]).swapaxes(0, 1)
        out = np.bincount(owner, dot(a, cross(b, c)) / 6, len(self))
        return np.asarray(out, np.float64)

    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest coordinates of each body, shapes (n, 3)."""
        starts = self.vertices_offsets[:-1]
        low = np.minimum.reduceat(self.vertices_coords, starts)
        return low, np.maximum.reduceat(self.vertices_coords, starts)

    def moved(self, turns: FloatArray, shifts: FloatArray) -> Bodies:
        """Each body moved by x -> turn x + shift; shapes (n, 3, 3) and (n, 3)."""
        owner = self.vertices_body
        coords = np.squeeze(turns[owner] @ self.vertices_coords[:, :, None], axis=2) + shifts[owner]
        return Bodies(
            coords,
            self.vertices_offsets,
            self.triangles,
            self.triangles_offsets,
            self.triangles_plane,
        )

    def chosen(self, bodies: IntArray) -> Bodies:
        """The bodies of these numbers, in that order."""
        return bodies_of([self.mesh(i) for i in np.asarray(bodies).tolist()])


def bodies_of(meshes: Sequence[TriangleMesh]) -> Bodies:
    """Bodies from one closed surface each."""
    sizes = [len(mesh.vertices_coords) for mesh in meshes]
    counts = [len(mesh.triangles) for mesh in meshes]
    vertices = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    plane, planes = 0, []
    for mesh in meshes:
        names, numbers = np.unique(mesh.triangles_plane, return_inverse=True)
        planes.append(numbers + plane)
        plane += len(names)
    shifted = [m.triangles + first for m, first in zip(meshes, vertices.tolist(), strict=False)]
    return Bodies(
        np.concatenate([np.empty((0, 3)), *(mesh.vertices_coords for mesh in meshes)]),
        vertices,
        np.concatenate([np.empty((0, 3), np.int64), *shifted]),
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.concatenate([np.empty(0, np.int64), *planes]),
    )


def concatenated(parts: Sequence[Bodies]) -> Bodies:
    """The bodies of all parts, one after another."""
    vertices = np.cumsum([0, *(len(part.vertices_coords) for part in parts)])
    triangles = np.cumsum([0, *(len(part.triangles) for part in parts)])
    planes = np.cumsum([0, *(part.triangles_plane.max(initial=-1) + 1 for part in parts)])

    def ends(offsets: Sequence[IntArray], shifts: IntArray) -> IntArray:
        moved = [o[1:] + shift for o, shift in zip(offsets, shifts.tolist(), strict=False)]
        return np.concatenate([[0], *moved]).astype(np.int64)

    return Bodies(
        np.concatenate([np.empty((0, 3)), *(part.vertices_coords for part in parts)]),
        ends([part.vertices_offsets for part in parts], vertices),
        np.concatenate(
            [np.empty((0, 3), np.int64)]
            + [part.triangles + s for part, s in zip(parts, vertices.tolist(), strict=False)]
        ),
        ends([part.triangles_offsets for part in parts], triangles),
        np.concatenate(
            [np.empty(0, np.int64)]
            + [part.triangles_plane + s for part, s in zip(parts, planes.tolist(), strict=False)]
        ),
    )


def stacked(rings: FloatArray, offsets: IntArray, heights_mm: FloatArray) -> Bodies:
    """Solids between rings of corners at several heights, sides planar.

    rings : shape (total, k, 2), mm: corners of all solids, counterclockwise, at each of k heights;
        side j of a solid, from corner j to the next, has the same direction at all heights.
    offsets : solid i has the corners offsets[i]:offsets[i + 1]; heights_mm : shape (k,), rising.

    Vertices of a solid are its ring at the lowest height, then that at the next one, and so on.

    A box of 2 x 1 x 3 mm:

    >>> ring = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    >>> box = stacked(np.stack([ring, ring], axis=1), np.array([0, 4]), np.array([0.0, 3.0]))
    >>> len(box), box.volumes_mm3().tolist()
    (1, [6.0])
    """
    levels = len(heights_mm)
    sizes = np.diff(offsets)
    vertices = np.concatenate([[0], np.cumsum(levels * sizes)]).astype(np.int64)
    counts = 2 * (sizes - 2) + 2 * (levels - 1) * sizes
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    planes = np.concatenate([[0], np.cumsum(2 + (levels - 1) * sizes)])
    coords = np.empty((int(vertices[-1]), 3))
    triangles = np.empty((int(starts[-1]), 3), np.int64)
    plane = np.empty(int(starts[-1]), np.int64)
    for n in np.unique(sizes).tolist():
        members = np.flatnonzero(sizes == n)
        ring = rings[offsets[members][:, None] + np.arange(n)]
        place = vertices[members][:, None] + np.arange(levels * n)
        coords[place, :2] = ring.swapaxes(1, 2).reshape(len(members), -1, 2)
        coords[place, 2] = np.repeat(heights_mm, n)
        low, high = cap_triangles(ring[:, :, 0]), cap_triangles(ring[:, :, -1])
        i = np.arange(n)
        walls = []
        for level in range(levels - 1):
            a, b = level * n + i, level * n + (i + 1) % n
            walls += [np.stack([a, b, b + n], 1), np.stack([a, b + n, a + n], 1)]
        sides = np.broadcast_to(np.concatenate(walls), (len(members), 2 * (levels - 1) * n, 3))
        local = np.concatenate([low[:, :, ::-1], high + (levels - 1) * n, sides], axis=1)
        rows = starts[members][:, None] + np.arange(local.shape[1])
        triangles[rows] = local + vertices[members][:, None, None]
        own = np.repeat([0, 1], n - 2)
        walls_plane = [2 + level * n + i for level in range(levels - 1) for _ in range(2)]
        plane[rows] = np.concatenate([own, *walls_plane]) + planes[members][:, None]
    return Bodies(coords, vertices, triangles, starts, plane)
