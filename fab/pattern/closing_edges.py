"""Boundary edges that come together when a sheet is folded, such as those of a cut ring."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.kinematics import fold_by_angles, unknown_angles
from fab.pattern.open_cuts import Opened, opened
from solver.graphs import labels
from solver.polygons import face_normals
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["closing_edges", "closing_edges_by_angles", "folded_by_angles"]

# Folded ends nearer than this share of the sheet are one point.
_CLOSED_REL = 1e-6
# Faces that lie on each other when folded are layers, no seam.
_LAYERED_DEG = 179.0


def closing_edges(pattern: CreasePattern) -> tuple[IntArray, FloatArray]:
    """Pairs of boundary edges that are one edge in the folded form, (n, 2), and their fold angles.

    Edges that lie on each other when flat too are a slit. Layers folded flat on each other are no
    seam, nor are edges that meet because all creases between their faces are folded flat.
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
    real = (np.abs(angle) < _LAYERED_DEG) & ~_joined_flat(pattern, pattern.edges_faces[edges, 0])
    return edges[real], angle[real]


def closing_edges_by_angles(pattern: CreasePattern) -> tuple[IntArray, FloatArray]:
    """As `closing_edges`, by the fold angles of a pattern whose folded form is not known.

    There are none where an angle is not known, or where the angles do not close.
    """
    whole = folded_by_angles(pattern)
    if whole is None:
        return np.empty((0, 2), np.int64), np.empty(0)
    edges, angle = closing_edges(whole.pattern)
    edges = whole.edges_source[edges]
    outer = (pattern.edges_faces[edges, 1] < 0).all(axis=1)
    return edges[outer], angle[outer]


def folded_by_angles(pattern: CreasePattern) -> Opened | None:
    """The pattern with its cuts open and with the folded form that its fold angles give.

    None where all creases are flat or folded flat, where an angle is not known, and where the
    angles do not close. Its faces are those of the pattern, in their order.
    """
    if _flat(pattern).all():
        return None
    whole = opened(pattern)
    letters = whole.pattern.edges_assignment
    if (unknown_angles(whole.pattern) & (letters != "C")).any():
        return None
    shape = fold_by_angles(whole.pattern)
    size = float(norm(np.ptp(pattern.vertices_coords, axis=0)))
    if shape.gap_mm > _CLOSED_REL * size or shape.gap_rad > _CLOSED_REL:
        return None
    return replace(whole, pattern=replace(whole.pattern, folded_coords=shape.folded_coords))


def _joined_flat(pattern: CreasePattern, pairs: IntArray) -> BoolArray:
    """Which pairs of faces, shape (n, 2), flat creases and flat folds alone lead between."""
    flat = pattern.edges_joining & _flat(pattern)
    part = labels(pattern.edges_faces[flat], pattern.face_count)
    out: BoolArray = part[pairs[:, 0]] == part[pairs[:, 1]]
    return out


def _flat(pattern: CreasePattern) -> BoolArray:
    """Which edges are flat, or folded flat, shape (ne,)."""
    angle = np.abs(pattern.edges_foldAngle)
    out: BoolArray = (angle < FLAT_ANGLE_DEG) | (angle >= _LAYERED_DEG)
    return out
