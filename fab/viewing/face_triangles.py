"""Triangles over the faces of a pattern, for what draws triangles alone."""

from __future__ import annotations

import numpy as np

from fab.geometry.triangulation import cap_triangles
from fab.pattern.crease_pattern import CreasePattern
from solver.errors import InvalidState
from solver.vectors import FloatArray, IntArray

__all__ = ["face_corner_triangles"]


def face_corner_triangles(pattern: CreasePattern) -> tuple[IntArray, IntArray]:
    """Triangles (nt, 3) of entries of `faces_vertices`, and the face of each (nt,), rising.

    They are counterclockwise in the flat sheet. Faces with a slit, whose outline touches itself,
    get a fan, which may reach out of them.

    >>> from fab.formats.pattern_file import CreasePattern
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> sides = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    >>> pattern = CreasePattern(
    ...     square, sides, np.array([[0, -1]] * 4), np.array(["B"] * 4), np.zeros(4),
    ...     np.array([0, 1, 2, 3]), np.array([0, 4]),
    ... )
    >>> face_corner_triangles(pattern)[0].tolist()
    [[0, 1, 2], [0, 2, 3]]
    """
    corners = np.arange(len(pattern.faces_vertices))
    sizes = np.diff(pattern.faces_offsets)
    coords = pattern.vertices_coords[pattern.faces_vertices]
    triangles, faces = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)]
    for n in np.unique(sizes).tolist():
        chosen = np.flatnonzero(sizes == n)
        rings = corners[pattern.faces_offsets[chosen][:, None] + np.arange(n)]
        try:
            cut = cap_triangles(coords[rings])
        except InvalidState:
            cut = np.stack([_caps(coords[ring]) for ring in rings])
        triangles.append(np.take_along_axis(rings[:, None, :], cut, axis=2).reshape(-1, 3))
        faces.append(np.repeat(chosen, n - 2))
    face = np.concatenate(faces)
    order = np.argsort(face, kind="stable")
    return np.concatenate(triangles)[order], face[order]


def _caps(ring: FloatArray) -> IntArray:
    """Triangles of one ring, a fan where its outline touches itself, shape (n - 2, 3)."""
    try:
        return np.asarray(cap_triangles(ring[None])[0])
    except InvalidState:
        onward = np.arange(1, len(ring) - 1)
        return np.stack([np.zeros_like(onward), onward, onward + 1], axis=1)
