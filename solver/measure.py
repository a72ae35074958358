"""Measures of exactness: planarity, developability, isometry of the flat and the folded sheet.

All functions take faces of one size, shape (nf, n); meshes of mixed sizes call them once for each.
"""

from __future__ import annotations

import numpy as np

from solver.errors import InvalidValue
from solver.mesh import interior_vertices
from solver.vectors import (
    SMALLEST,
    BoolArray,
    FloatArray,
    IntArray,
    cross,
    dot,
    norm,
    numbers,
    points,
)

__all__ = ["angle_excess", "developability", "isometry", "planarity", "sector_angles"]


def _checked(vertices_coords: FloatArray, faces_vertices: IntArray) -> tuple[FloatArray, IntArray]:
    """Points (nv, 3) and faces (nf, n) that name them; raises `InvalidValue` for others."""
    coords, faces = points("vertices_coords", vertices_coords), np.asarray(faces_vertices)
    size = np.abs(coords).max(initial=0.0)
    if 0 < size < SMALLEST:
        raise InvalidValue(
            "largest coordinate", size, f"be at least {SMALLEST:g}", "Scale the sheet."
        )
    if faces.ndim != 2 or faces.shape[1] < 3 or faces.dtype.kind not in "iu":
        raise InvalidValue(
            "faces_vertices",
            f"array of shape {faces.shape} ({faces.dtype})",
            "hold vertex numbers, with shape (nf, 3) or more columns",
            "Measure faces of each size on their own.",
        )
    if faces.size and not 0 <= faces.min() <= faces.max() < len(coords):
        raise InvalidValue(
            "vertex numbers of the faces",
            f"{faces.min()} to {faces.max()}",
            f"be from 0 to {len(coords) - 1}",
            "Give the vertices that the faces belong to.",
        )
    return coords, faces


def planarity(vertices_coords: FloatArray, faces_vertices: IntArray) -> FloatArray:
    """Distance of each face from flat over its longest diagonal: dimensionless, shape (nf,).

    The distance is the spread of the corners along the face's area normal; for a quad it is the
    distance between the two diagonals. Diagonals join the neighbours of a corner. A face without
    area (its diagonals parallel) gives NaN, a triangle 0. Raises `InvalidValue` for faces of other
    shapes, or that name no vertex.

    A unit square with two opposite corners raised by 0.1:

    >>> twisted = np.array([[0, 0, 0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.1]])
    >>> planarity(twisted, np.array([[0, 1, 2, 3]])).round(6)  # 0.1 / sqrt 2
    array([0.070711])
    """
    vertices_coords, faces_vertices = _checked(vertices_coords, faces_vertices)
    corners = vertices_coords[faces_vertices]
    if faces_vertices.shape[1] == 4:
        first = corners[:, 2] - corners[:, 0]
        second = corners[:, 3] - corners[:, 1]
        normal = cross(first, second)
        gap = np.abs(dot(normal, corners[:, 1] - corners[:, 0]))
        longest = np.maximum(dot(first, first), dot(second, second))
        with np.errstate(invalid="ignore", divide="ignore"):
            out: FloatArray = gap / (norm(normal) * np.sqrt(longest))
        return out
    centred = corners - corners.mean(axis=1, keepdims=True)
    normal = cross(centred, np.roll(centred, -1, axis=1)).sum(axis=1)
    diagonals = norm(np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)).max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        heights = np.einsum("fni,fi->fn", centred, normal / norm(normal)[:, None])
        spread: FloatArray = np.ptp(heights, axis=1) / diagonals
    return spread


def sector_angles(vertices_coords: FloatArray, faces_vertices: IntArray) -> FloatArray:
    """Inner angle of every face at every corner, radians in [0, 2 pi), shape (nf, n).

    Corners that turn against the face's area normal are reflex.
    """
    corners = vertices_coords[faces_vertices]
    after = np.roll(corners, -1, axis=1) - corners
    turn = cross(after, -np.roll(after, 1, axis=1))
    angle = np.arctan2(norm(turn), -dot(after, np.roll(after, 1, axis=1)))
    reflex = dot(turn, turn.sum(axis=1, keepdims=True)) < 0
    return np.where(reflex, 2 * np.pi - angle, angle)


def angle_excess(
    vertices_coords: FloatArray, faces_vertices: IntArray, inside: BoolArray
) -> FloatArray:
    """Sum of the sector angles minus 2 pi, radians, at the vertices `inside`; 0 elsewhere.

    Returns shape (nv,).
    """
    angles = sector_angles(vertices_coords, faces_vertices)
    total = np.bincount(faces_vertices.ravel(), angles.ravel(), len(vertices_coords))
    return np.where(inside, total - 2 * np.pi, 0.0)


def developability(vertices_coords: FloatArray, faces_vertices: IntArray) -> FloatArray:
    """|2 pi - sum of sector angles| at every vertex, radians, shape (nv,); 0 at the boundary.

    Three squares around the corner of a cube lack a right angle there:

    >>> cube = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]]
    >>> faces = np.array([[0, 1, 2, 3], [0, 4, 5, 1], [0, 3, 6, 4]])
    >>> np.degrees(developability(cube, faces)).round(9).tolist()
    [90.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """
    vertices_coords, faces_vertices = _checked(vertices_coords, faces_vertices)
    inside = interior_vertices(faces_vertices, len(vertices_coords))
    return np.abs(angle_excess(vertices_coords, faces_vertices, inside))


def isometry(
    vertices_coords: FloatArray, flat_coords: FloatArray, faces_vertices: IntArray
) -> FloatArray:
    """Largest relative change of a side or diagonal of each face, shape (nf,), dimensionless.

    vertices_coords : folded, shape (nv, 3); flat_coords : developed, shape (nv, 2) or (nv, 3).

    >>> folded = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    >>> isometry(folded, folded * [1, 1.5, 1], np.array([[0, 1, 2]]))
    array([0.5])
    """
    vertices_coords, faces_vertices = _checked(vertices_coords, faces_vertices)
    flat_coords = numbers("flat_coords", flat_coords)
    if flat_coords.shape not in ((len(vertices_coords), 2), (len(vertices_coords), 3)):
        raise InvalidValue(
            "flat_coords",
            f"array of shape {flat_coords.shape}",
            f"have shape ({len(vertices_coords)}, 2) or ({len(vertices_coords)}, 3)",
            "Give one flat point for each vertex.",
        )
    worst = np.zeros(len(faces_vertices))
    for step in (1, 2) if faces_vertices.shape[1] > 3 else (1,):
        ends = np.roll(faces_vertices, -step, axis=1)
        folded = norm(vertices_coords[ends] - vertices_coords[faces_vertices])
        flat = norm(flat_coords[ends] - flat_coords[faces_vertices])
        with np.errstate(invalid="ignore", divide="ignore"):
            change = np.abs(flat - folded) / folded
        np.maximum(worst, change.max(axis=1), out=worst)
    return worst
