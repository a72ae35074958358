"""Sectors at the vertices of a pattern: the lines that meet there, in order, and their angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Sectors", "sectors_of"]


@dataclass(frozen=True)
class Sectors:
    """The ends of lines at their vertices, counterclockwise around each vertex.

    Attributes
    ----------
    vertices, edges, ends : of each line's end: its vertex, its edge, and 0 or 1 for the edge's
        start or end; shape (n,), the vertices rising.
    directions : angle of the line seen from the vertex, radians, rising at each vertex, shape (n,).
    following : index of the next line's end at the same vertex, shape (n,).
    angles : from each line to the following one, radians in [0, 2 pi], shape (n,).
    """

    vertices: IntArray
    edges: IntArray
    ends: IntArray
    directions: FloatArray
    following: IntArray
    angles: FloatArray

    def smallest(self) -> FloatArray:
        """The smaller of the two angles beside each line's end, radians, shape (n,)."""
        before = np.empty_like(self.angles)
        before[self.following] = self.angles
        return np.minimum(before, self.angles)


def sectors_of(pattern: CreasePattern, lines: BoolArray) -> Sectors:
    """The sectors between the edges chosen by `lines`, shape (ne,); others count as paper."""
    chosen = np.flatnonzero(lines)
    coords = pattern.vertices_coords[pattern.edges_vertices[chosen]]
    arm = coords[:, 1] - coords[:, 0]
    vertex = pattern.edges_vertices[chosen].T.ravel()
    arm = np.concatenate([arm, -arm])
    direction = np.arctan2(arm[:, 1], arm[:, 0])
    order = np.lexsort((direction, vertex))
    vertex, direction = vertex[order], direction[order]
    first = np.flatnonzero(np.diff(vertex, prepend=-1))
    following = np.arange(len(vertex)) + 1
    following[np.append(first[1:], len(vertex))[: len(first)] - 1] = first
    angle = direction[following] - direction
    last = following <= np.arange(len(vertex))
    angle[last] += 2 * np.pi
    edge, end = np.tile(chosen, 2)[order], np.repeat([0, 1], len(chosen))[order]
    return Sectors(vertex, edge, end, direction, following, angle)
