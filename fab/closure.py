"""Do the fold angles around each vertex close, so that faces can stay flat when they are folded?"""

from __future__ import annotations

import numpy as np

from fab.crease import CreasePattern
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["closure_gaps_deg"]


def closure_gaps_deg(pattern: CreasePattern) -> FloatArray:
    """Angle by which the faces around each vertex miss each other, degrees, shape (nv,).

    Turning about every crease in turn, once around a vertex, must end where it began. NaN where
    nothing has to close: on the border, at cuts, at unassigned creases without an angle, where no
    crease is, and where the sheet turns around the vertex more than once.
    """
    count = len(pattern.vertices_coords)
    gaps = np.full(count, np.nan)
    vertex, direction, angle = _spokes(pattern)
    order = np.lexsort((direction, vertex))
    vertex, direction, angle = vertex[order], direction[order], angle[order]
    begin = np.flatnonzero(np.diff(vertex, prepend=-1))
    degrees = np.diff(begin, append=len(vertex))
    for degree in np.unique(degrees).tolist():
        first = begin[degrees == degree]
        around = first[:, None] + np.arange(degree)
        gaps[vertex[first]] = _gaps(direction[around], np.radians(angle[around]))
    gaps[~_closed(pattern)] = np.nan
    return gaps


def _spokes(pattern: CreasePattern) -> tuple[IntArray, FloatArray, FloatArray]:
    """For both ends of each edge between two faces: vertex, direction (radians), fold angle."""
    one, two = pattern.edges_faces.T
    between = (two >= 0) & (one != two)
    pairs, angle = pattern.edges_vertices[between], pattern.edges_foldAngle[between]
    span = pattern.vertices_coords[pairs[:, 1]] - pattern.vertices_coords[pairs[:, 0]]
    directions = [np.arctan2(sign * span[:, 1], sign * span[:, 0]) for sign in (1, -1)]
    return pairs.T.ravel(), np.concatenate(directions), np.tile(angle, 2)


def _closed(pattern: CreasePattern) -> BoolArray:
    """Vertices around which faces lie once, with creases that are all known, shape (nv,)."""
    letters, (one, two) = pattern.edges_assignment, pattern.edges_faces.T
    unknown = (letters == "C") | ((letters == "U") & (pattern.edges_foldAngle == 0))
    open_edges = (two < 0) | (unknown & (one != two))
    turn = np.zeros(len(pattern.vertices_coords))
    for _, faces in pattern.faces_by_size():
        corner = pattern.vertices_coords[faces]
        z = (np.roll(corner, -1, axis=1) - corner) @ [1, 1j]
        back = (np.roll(corner, 1, axis=1) - corner) @ [1, 1j]
        np.add.at(turn, faces, np.angle(back / z) % (2 * np.pi))
    out: BoolArray = np.abs(turn - 2 * np.pi) < 1e-6
    out[pattern.edges_vertices[open_edges]] = False
    return out


def _gaps(direction: FloatArray, angle: FloatArray) -> FloatArray:
    """Angle (degrees) of the product of the rotations in each row; all of shape (n, degree).

    As quaternions (w, x, y, z) about axes in the plane.
    """
    w, x, y, z = (np.full(len(direction), value) for value in (1.0, 0.0, 0.0, 0.0))
    for d, a in zip(direction.T, angle.T / 2, strict=True):
        c, p, q = np.cos(a), np.sin(a) * np.cos(d), np.sin(a) * np.sin(d)
        w, x, y, z = (
            w * c - x * p - y * q,
            w * p + x * c - z * q,
            w * q + y * c + z * p,
            x * q - y * p + z * c,
        )
    out: FloatArray = np.degrees(2 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w)))
    return out
