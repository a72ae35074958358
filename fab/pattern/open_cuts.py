"""The sheet that is left when the cuts between its faces are open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.graphs import EdgeIndex, labels
from solver.mesh import edges_of
from solver.vectors import IntArray

__all__ = ["Opened", "edges_between", "opened"]


@dataclass(frozen=True)
class Opened:
    """A pattern without cuts between faces.

    Attributes
    ----------
    pattern : vertices on cuts occur once for each side of the cut, cut edges twice, as borders.
        Edges that bound no face are left out. A slit of one edge, held at both its ends, keeps its
        letter C. A sheet without cuts keeps the numbers of its vertices.
    vertices_source, edges_source : shapes (nv,) and (ne,), numbers in the pattern that was opened.
    """

    pattern: CreasePattern
    vertices_source: IntArray
    edges_source: IntArray


def opened(pattern: CreasePattern) -> Opened:
    """Open the edges assigned C that have a face on both sides."""
    corners, offsets = pattern.faces_vertices, pattern.faces_offsets
    corners, source = _separated(pattern)
    edges = edges_of(corners, offsets)
    number = edges_between(pattern, source[edges.edges_vertices])
    letters = pattern.edges_assignment[number].copy()
    border = edges.edges_faces[:, 1] < 0
    letters[border] = "B"
    folded = pattern.folded_coords
    out = CreasePattern(
        pattern.vertices_coords[source],
        edges.edges_vertices,
        edges.edges_faces,
        letters,
        np.where(border, 0.0, pattern.edges_foldAngle[number]),
        corners,
        offsets,
        None if folded is None else folded[source],
    )
    return Opened(out, source, number)


def _separated(pattern: CreasePattern) -> tuple[IntArray, IntArray]:
    """Corners of the faces, with vertices on cuts repeated, and the vertex that each one was."""
    corners, offsets = pattern.faces_vertices, pattern.faces_offsets
    face = np.repeat(np.arange(pattern.face_count), np.diff(offsets))
    joining = pattern.edges_joining
    count = len(pattern.vertices_coords)
    keys = face * count + corners
    order = np.argsort(keys)
    ends = pattern.edges_vertices[joining].T.ravel()
    beside = np.tile(pattern.edges_faces[joining].T, 2)
    first, second = order[np.searchsorted(keys[order], beside * count + ends)]
    label = labels(np.column_stack([first, second]), len(corners))
    _, member = np.unique(label, return_index=True)
    ranked = np.argsort(corners[member], kind="stable")
    place = np.empty_like(ranked)
    place[ranked] = np.arange(len(ranked))
    return place[label], corners[member][ranked]


def edges_between(pattern: CreasePattern, ends: IntArray) -> IntArray:
    """The pattern's edge between each pair of its vertices, which are sides of its faces."""
    return EdgeIndex.of(pattern.edges_vertices, len(pattern.vertices_coords)).find(ends)
