"""Rigid motions of the faces of a sheet from flat to a folded state."""

from __future__ import annotations

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray

__all__ = ["face_poses"]


def face_poses(pattern: CreasePattern, coords: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Motions x -> turn x + shift of all faces from flat to `coords`, shape (nv, 3), mm.

    The best rigid motion of the corners of each face (Kabsch 1976), never mirrored: exact for a
    folded form, the nearest one for a state in which faces are bent or stretched. Returns shapes
    (nf, 3, 3) and (nf, 3).
    """
    flat = np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])
    turns = np.empty((pattern.face_count, 3, 3))
    shifts = np.empty((pattern.face_count, 3))
    for faces, corners in pattern.faces_by_size():
        turns[faces], shifts[faces] = _fitted(flat[corners], coords[corners])
    return turns, shifts


def _fitted(flat: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Best rigid motions between point sets, shapes (k, n, 3)."""
    middle, goal = flat.mean(axis=1), moved.mean(axis=1)
    spread = (flat - middle[:, None]).swapaxes(1, 2) @ (moved - goal[:, None])
    left, _, right = np.linalg.svd(spread)
    left, right = left.swapaxes(1, 2), right.swapaxes(1, 2)
    sign = np.ones((len(flat), 3))
    sign[:, 2] = np.linalg.det(right @ left)
    turn = (right * sign[:, None, :]) @ left
    return turn, goal - np.squeeze(turn @ middle[:, :, None], axis=2)
