"""Rigid motions of the faces of a sheet from flat to a folded state."""

from __future__ import annotations

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, norm

__all__ = ["bend_mm", "face_poses"]


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


def bend_mm(
    pattern: CreasePattern,
    coords: FloatArray,
    poses: tuple[FloatArray, FloatArray] | None = None,
) -> float:
    """Largest distance of a corner, at `coords` (nv, 3), from where its rigid face has it, mm.

    poses : those of `face_poses`, where they are known.
    """
    turns, shifts = face_poses(pattern, coords) if poses is None else poses
    face = np.repeat(np.arange(pattern.face_count), np.diff(pattern.faces_offsets))
    flat = pattern.vertices_coords[pattern.faces_vertices]
    placed = np.squeeze(turns[face, :, :2] @ flat[:, :, None], axis=2) + shifts[face]
    return float(norm(placed - coords[pattern.faces_vertices]).max(initial=0.0))


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
