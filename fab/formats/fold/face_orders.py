"""The order of faces that are on each other where the sheet is folded flat."""

from __future__ import annotations

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, IntArray

__all__ = ["face_orders", "is_flat"]

# Over the diagonal: points nearer to a plane are in it. Files may have been written with 7 digits.
_PLANE = 1e-6
# From 180 degrees: creases that fold this far are folded flat.
_FLAT_DEG = 1e-3


def face_orders(pattern: CreasePattern) -> IntArray:
    """Rows [f, g, s] of FOLD's faceOrders, shape (n, 3); none where the folded form is not flat.

    s is 1 where f is on the side of g to which g's normal points, -1 on the other. Rows are given
    for two faces that a mountain or valley folds onto each other, and for no others: their order
    does not follow from letters alone.
    """
    folded = pattern.folded_coords
    if folded is None or not is_flat(folded):
        return np.empty((0, 3), np.int64)
    sign = np.sign(pattern.edges_foldAngle).astype(np.int64)
    folded_on = (
        np.isin(pattern.edges_assignment, ["M", "V"])
        & (np.abs(pattern.edges_foldAngle) >= 180 - _FLAT_DEG)
        & (pattern.edges_faces[:, 0] != pattern.edges_faces[:, 1])
    )
    rows: IntArray = np.column_stack([pattern.edges_faces, sign])[folded_on]
    return rows


def is_flat(coords: FloatArray) -> bool:
    """Whether points, shape (n, 3), are in one plane."""
    arm = coords - coords.mean(axis=0)
    size = np.linalg.svd(arm, compute_uv=False) / np.sqrt(len(arm))
    return bool(size[-1] <= _PLANE * size[0])
