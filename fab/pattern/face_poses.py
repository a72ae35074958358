"""Rigid motions of the faces of a sheet from flat to a folded state."""

from __future__ import annotations

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, norm

__all__ = ["bend_mm", "face_poses", "nearest_motions"]


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
        turns[faces], shifts[faces] = nearest_motions(flat[corners], coords[corners])
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


def nearest_motions(points: FloatArray, onto: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Best rigid motions x -> turn x + shift of point sets onto others (Kabsch 1976).

    Both have shape (k, n, 3); the motions have shapes (k, 3, 3) and (k, 3), and never mirror.
    """
    middle, goal = points.mean(axis=1), onto.mean(axis=1)
    spread = (points - middle[:, None]).swapaxes(1, 2) @ (onto - goal[:, None])
    left, _, right = np.linalg.svd(spread)
    left, right = left.swapaxes(1, 2), right.swapaxes(1, 2)
    sign = np.ones((len(points), 3))
    sign[:, 2] = np.linalg.det(right @ left)
    turn = (right * sign[:, None, :]) @ left
    return turn, goal - np.squeeze(turn @ middle[:, :, None], axis=2)
