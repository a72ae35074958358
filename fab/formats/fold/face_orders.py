"""The order of faces that are on each other where the sheet is folded flat, written and read."""

from __future__ import annotations

from typing import Any

import numpy as np

from fab.errors import Finding, Severity
from fab.formats.fold.number_rows import number_rows
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["face_orders", "is_flat", "read_face_orders"]

# Over the diagonal: points nearer to a plane are in it. Files may have been written with 7 digits.
_PLANE = 1e-6
# From 180 degrees: creases that fold this far are folded flat.
_FLAT_DEG = 1e-3


def face_orders(pattern: CreasePattern) -> IntArray:
    """Rows [f, g, s] of FOLD's faceOrders, shape (n, 3); none where the folded form is not flat.

    s is 1 where f is on the side of g to which g's normal points, -1 on the other. Rows are given
    for two faces that a mountain or valley folds onto each other, and for no others: their order
    does not follow from letters alone (`fab.layers` finds it).
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


def read_face_orders(
    rows: Any, count: int, number: IntArray, turned: BoolArray
) -> tuple[IntArray, list[Finding]]:
    """Rows of the faces of a pattern from those of a file, shape (n, 3), and findings.

    rows : the value of faceOrders. count : number of faces in the file. number : shape (nf,), the
    number that each face of the pattern has there; turned : shape (nf,), whether it runs the other
    way round in the pattern. Rows of faces that the pattern does not have are left out.
    """
    none = np.empty((0, 3), np.int64)
    found = number_rows(rows if isinstance(rows, list) else ["ragged"])
    fits = found.ndim == 2 and found.shape[1] == 3 and found.dtype.kind == "i"
    if fits:
        first, second, side = found.T
        named = (found[:, :2] >= 0).all() and (found[:, :2] < count).all()
        fits = bool(named and np.isin(side, [-1, 0, 1]).all() and (first != second).all())
    if not fits:
        text = (
            "faceOrders must be rows of two different faces and 1, -1 or 0: they are left out, and "
            "the order of layers is found anew."
        )
        return none, [Finding("face-orders-unknown", Severity.WARNING, text)]
    place = np.full(count, -1)
    place[number] = np.arange(len(number))
    first, second = place[found[:, 0]], place[found[:, 1]]
    known = (first >= 0) & (second >= 0)
    first, second, side = first[known], second[known], side[known]
    return np.column_stack([first, second, np.where(turned[second], -side, side)]), []


def is_flat(coords: FloatArray) -> bool:
    """Whether points, shape (n, 3), are in one plane."""
    arm = coords - coords.mean(axis=0)
    size = np.linalg.svd(arm, compute_uv=False) / np.sqrt(len(arm))
    return bool(size[-1] <= _PLANE * size[0])
