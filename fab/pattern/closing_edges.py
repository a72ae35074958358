"""Boundary edges that come together when a sheet is folded, such as those of a cut ring."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern, face_normals
from solver.vectors import FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["closing_edges"]

# Folded ends nearer than this share of the sheet are one point.
_CLOSED_REL = 1e-6
# Faces that lie on each other when folded are layers, no seam.
_LAYERED_DEG = 179.0


def closing_edges(pattern: CreasePattern) -> tuple[IntArray, FloatArray]:
    """Pairs of boundary edges that are one edge in the folded form, (n, 2), and their fold angles.

    Edges that lie on each other when flat too are a slit, and layers folded flat on each other are
    no seam.
    """
    folded = pattern.folded_coords
    border = np.flatnonzero(pattern.edges_faces[:, 1] < 0)
    none = np.empty((0, 2), np.int64), np.empty(0)
    if folded is None or len(border) < 2:
        return none
    near = _CLOSED_REL * float(norm(np.ptp(folded, axis=0)))
    ends = pattern.edges_vertices[border]
    ahead = np.concatenate([folded[ends[:, 0]], folded[ends[:, 1]]], axis=1)
    back = np.concatenate([folded[ends[:, 1]], folded[ends[:, 0]]], axis=1)
    pairs = cKDTree(ahead).sparse_distance_matrix(cKDTree(back), near, output_type="coo_matrix")
    first, second = pairs.row, pairs.col
    times = np.bincount(first, minlength=len(border))
    plain = (first < second) & (times[first] == 1) & (times[second] == 1)
    first, second = first[plain], second[plain]
    flat = pattern.vertices_coords
    apart = norm(flat[ends[first]] - flat[ends[second][:, ::-1]]).max(axis=1) > near
    first, second = first[apart], second[apart]
    order = np.argsort(first)
    edges = np.column_stack([border[first], border[second]])[order]
    normals = face_normals(folded, pattern.faces_vertices, pattern.faces_offsets)
    n1, n2 = normals[pattern.edges_faces[edges, 0]].swapaxes(0, 1)
    u = unit(np.diff(folded[pattern.edges_vertices[edges[:, 0]]], axis=1)[:, 0])
    angle = np.degrees(np.arctan2(dot(cross(n2, n1), u), dot(n1, n2)))
    angle[np.abs(angle) < FLAT_ANGLE_DEG] = 0.0
    real = np.abs(angle) < _LAYERED_DEG
    return edges[real], angle[real]
