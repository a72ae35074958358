"""Pieces of a pattern set apart, where they touch, overlap, or come nearer than a gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.affinity import translate

from fab.geometry.rings import by_size
from fab.pattern.crease_pattern import CreasePattern
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["set_apart", "shifts_apart"]

# Gaps that fall short by this share of the sheet are rounding.
_ROUNDING_REL = 1e-9
# Places are tried, the nearest ones first, up to this many.
_PLACES = 256


def set_apart(pattern: CreasePattern, gap_mm: float) -> tuple[CreasePattern, IntArray, FloatArray]:
    """The pattern with its pieces at least `gap_mm` apart, and how far each face has moved.

    A piece is what hangs together by edges, cuts between two of its faces included. Vertices that
    several pieces share are repeated; faces and edges keep their numbers. Pieces move as
    `shifts_apart` has it.

    Returns the pattern, the first face of each piece that moved, shape (k,), and its shift in mm,
    shape (k, 2).
    """
    joined = pattern.edges_faces[(pattern.edges_faces >= 0).all(axis=1)]
    piece = labels(joined, pattern.face_count)
    count = int(piece.max(initial=-1)) + 1
    none = np.empty(0, np.int64), np.empty((0, 2))
    if count < 2:
        return pattern, *none
    shifts = shifts_apart(_regions(pattern, piece, count), gap_mm)
    if not shifts.any():
        return pattern, *none
    _, first = np.unique(piece, return_index=True)
    moved = np.flatnonzero(shifts.any(axis=1))
    order = np.argsort(first[moved])
    return (
        _moved(pattern, piece, shifts),
        first[moved][order],
        shifts[moved][order],
    )


def shifts_apart(regions: NDArray[np.object_], gap_mm: float) -> FloatArray:
    """Shifts of plane regions after which all are at least `gap_mm` apart, shape (n, 2).

    The first region stays, and so does each that is apart from those before it. Any other moves to
    the nearest place where its box is beside the boxes of those before it or in line with its own
    place; one that has no such place near moves to the right of all.
    """
    low_x, low_y, high_x, high_y = shapely.bounds(regions).T
    low, high = np.column_stack([low_x, low_y]), np.column_stack([high_x, high_y])
    close = gap_mm - _ROUNDING_REL * float(np.ptp(np.concatenate([low, high]), axis=0).max())
    placed = regions.copy()
    shifts = np.zeros((len(regions), 2))
    for i in range(1, len(regions)):
        others = low[:i], high[:i]
        for shift in _places(low[i], high[i], *others, gap_mm):
            boxes = _near(low[i] + shift, high[i] + shift, *others, close)
            region = translate(regions[i], *shift)
            if not shapely.dwithin(placed[:i][boxes], region, close).any():
                break
        else:
            shift = np.array([high[:i, 0].max() + gap_mm - low[i, 0], 0.0])
            region = translate(regions[i], *shift)
        placed[i], shifts[i] = region, shift
        low[i] += shift
        high[i] += shift
    return shifts


def _places(
    low: FloatArray, high: FloatArray, others_low: FloatArray, others_high: FloatArray, gap: float
) -> FloatArray:
    """Shifts of a box in place, and beside other boxes, the nearest first, shape (k, 2)."""
    steps = [
        np.unique(
            np.concatenate(
                [
                    [0.0],
                    others_high[:, axis] + gap - low[axis],
                    others_low[:, axis] - gap - high[axis],
                ]
            )
        )
        for axis in (0, 1)
    ]
    near = [step[np.argsort(np.abs(step), kind="stable")[:_PLACES]] for step in steps]
    grid = np.stack(np.meshgrid(*near, indexing="ij"), axis=-1).reshape(-1, 2)
    # of equally near ones to the right first, then upwards
    far = np.round(np.hypot(*grid.T), 9)
    return grid[np.lexsort((-grid[:, 1], -grid[:, 0], far))][:_PLACES]


def _near(
    low: FloatArray, high: FloatArray, others_low: FloatArray, others_high: FloatArray, gap: float
) -> BoolArray:
    return np.asarray(((others_low - gap < high) & (low < others_high + gap)).all(axis=1))


def _regions(pattern: CreasePattern, piece: IntArray, count: int) -> NDArray[np.object_]:
    """The plane region of each piece, shape (count,)."""
    faces = np.empty(pattern.face_count, object)
    for numbers, corners in by_size(pattern.faces_vertices, pattern.faces_offsets):
        faces[numbers] = shapely.polygons(pattern.vertices_coords[corners])
    order = np.argsort(piece, kind="stable")
    ends = np.searchsorted(piece[order], np.arange(count + 1))
    out = np.empty(count, object)
    for i in range(count):
        own = faces[order[ends[i] : ends[i + 1]]]
        out[i] = own[0] if len(own) == 1 else shapely.union_all(own)
    return out


def _moved(pattern: CreasePattern, piece: IntArray, shifts: FloatArray) -> CreasePattern:
    """The pattern with every piece moved; vertices that several pieces share are repeated."""
    corners, count = pattern.faces_vertices, len(pattern.vertices_coords)
    face = pattern.edges_faces.max(axis=1)
    beside = face >= 0
    vertices = np.concatenate([corners, pattern.edges_vertices[beside].ravel()])
    owners = np.concatenate(
        [np.repeat(piece, np.diff(pattern.faces_offsets)), np.repeat(piece[face[beside]], 2)]
    )
    pairs, place = np.unique(np.column_stack([vertices, owners]), axis=0, return_inverse=True)
    repeated = np.concatenate([[False], pairs[1:, 0] == pairs[:-1, 0]])
    number = pairs[:, 0].copy()
    number[repeated] = count + np.arange(int(repeated.sum()))
    source = np.concatenate([np.arange(count), pairs[repeated, 0]])
    by = np.zeros((len(source), 2))
    by[number] = shifts[pairs[:, 1]]
    moved = number[place.ravel()]
    edges = pattern.edges_vertices.copy()
    edges[beside] = moved[len(corners) :].reshape(-1, 2)
    folded = pattern.folded_coords
    return replace(
        pattern,
        vertices_coords=pattern.vertices_coords[source] + by,
        edges_vertices=edges,
        faces_vertices=moved[: len(corners)],
        folded_coords=None if folded is None else folded[source],
    )
