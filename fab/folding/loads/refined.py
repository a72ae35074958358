"""Sheets with finer triangles, for faces that bend."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.folding.bar_hinge_model import Framework
from fab.pattern.crease_pattern import CreasePattern
from solver.graphs import EdgeIndex
from solver.mesh import edges_of
from solver.vectors import FloatArray, IntArray

__all__ = ["Refined", "refined"]


@dataclass(frozen=True)
class Refined:
    """A sheet whose triangles are each divided into n x n equal ones.

    Attributes
    ----------
    pattern : its faces are the small triangles, joined (letter J) within a face of the sheet. The
        first vertices are those of the sheet. Creases and borders are divided.
    corners, shares : shapes (nv, 3): of each vertex three of the sheet, and their shares in it.
    faces_source : shape (nf,), the face of the sheet that each triangle is part of.
    """

    pattern: CreasePattern
    corners: IntArray
    shares: FloatArray
    faces_source: IntArray

    def coords(self, coords: FloatArray) -> FloatArray:
        """Coordinates of all vertices, shape (nv, d), from those of the sheet's vertices."""
        out: FloatArray = (self.shares[:, :, None] * coords[self.corners]).sum(axis=1)
        return out


def refined(frame: Framework, parts: int) -> Refined:
    """A framework's sheet with each side of its triangles divided into `parts`.

    >>> from fab.folding.bar_hinge_model import framework
    >>> corners, offsets = np.array([0, 1, 2, 3]), np.array([0, 4])
    >>> edges = edges_of(corners, offsets)
    >>> square = CreasePattern(
    ...     np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]),
    ...     edges.edges_vertices,
    ...     edges.edges_faces,
    ...     np.full(4, "B"),
    ...     np.zeros(4),
    ...     corners,
    ...     offsets,
    ... )
    >>> fine = refined(framework(square), 3)
    >>> len(fine.pattern.vertices_coords), fine.pattern.face_count
    (16, 18)
    """
    lattice, small = _lattice(parts)
    numbers, total = _numbers(frame, parts, lattice)
    triangles = frame.triangles_vertices
    corners, shares = np.zeros((total, 3), np.int64), np.zeros((total, 3))
    corners[numbers], shares[numbers] = triangles[:, None, :], lattice / parts
    faces = numbers[:, small].reshape(-1, 3)
    offsets = 3 * np.arange(len(faces) + 1)
    edges = edges_of(faces.ravel(), offsets)
    sheet = frame.sheet.pattern
    letters = np.where(edges.edges_faces[:, 1] < 0, "B", "J")
    angles = np.zeros(len(letters))
    own = np.flatnonzero(frame.hinges_edge >= 0)
    pieces = _pieces(frame, parts, own)
    edge = EdgeIndex.of(edges.edges_vertices, total).find(pieces)
    source = np.repeat(frame.hinges_edge[own], parts)
    letters[edge], angles[edge] = sheet.edges_assignment[source], sheet.edges_foldAngle[source]
    pattern = CreasePattern(
        (shares[:, :, None] * sheet.vertices_coords[corners]).sum(axis=1),
        edges.edges_vertices,
        edges.edges_faces,
        letters,
        angles,
        faces.ravel(),
        offsets,
    )
    return Refined(pattern, corners, shares, np.repeat(frame.triangles_face, len(small)))


def _lattice(parts: int) -> tuple[IntArray, IntArray]:
    """Points of a divided triangle, and its small triangles, counterclockwise.

    Points are whole shares of the three corners, (n, 3), which add up to `parts`.
    """
    second, third = np.divmod(np.arange((parts + 1) ** 2), parts + 1)
    inside = second + third <= parts
    second, third = second[inside], third[inside]
    lattice = np.stack([parts - second - third, second, third], axis=1)
    number = np.full((parts + 2, parts + 2), -1)
    number[second, third] = np.arange(len(lattice))
    first = lattice[:, 0]
    j, k = second[first >= 1], third[first >= 1]
    upright = np.stack([number[j, k], number[j + 1, k], number[j, k + 1]], axis=1)
    j, k = second[first >= 2], third[first >= 2]
    turned = np.stack([number[j + 1, k], number[j + 1, k + 1], number[j, k + 1]], axis=1)
    return lattice, np.concatenate([upright, turned])


def _numbers(frame: Framework, parts: int, lattice: IntArray) -> tuple[IntArray, int]:
    """The vertex at each point of each triangle, shape (nt, n), and how many there are.

    First those of the sheet, then those on its bars, each from its first end, then those inside.
    """
    triangles, bars = frame.triangles_vertices, frame.bars_vertices
    count = len(frame.vertices_coords)
    index = EdgeIndex.of(bars, count)
    out = np.empty((len(triangles), len(lattice)), np.int64)
    for corner in range(3):
        out[:, lattice[:, corner] == parts] = triangles[:, corner, None]
        a, b = corner, (corner + 1) % 3
        on = np.flatnonzero((lattice[:, [a, b]] > 0).all(axis=1) & (lattice[:, 3 - a - b] == 0))
        bar = index.find(triangles[:, [a, b]])
        forward = bars[bar, 0] == triangles[:, a]
        step = np.where(forward[:, None], lattice[on, b], lattice[on, a])
        out[:, on] = count + bar[:, None] * (parts - 1) + step - 1
    begin = count + len(bars) * (parts - 1)
    inner = np.flatnonzero((lattice > 0).all(axis=1))
    total = begin + len(triangles) * len(inner)
    out[:, inner] = np.arange(begin, total).reshape(len(triangles), len(inner))
    return out, total


def _pieces(frame: Framework, parts: int, hinges: IntArray) -> IntArray:
    """Ends of the parts of some hinges, shape (n parts, 2)."""
    count = len(frame.vertices_coords)
    bar = EdgeIndex.of(frame.bars_vertices, count).find(frame.hinges_vertices[hinges][:, :2])
    ends = frame.bars_vertices[bar]
    between = count + bar[:, None] * (parts - 1) + np.arange(parts - 1)
    points = np.concatenate([ends[:, :1], between, ends[:, 1:]], axis=1)
    return np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2)
