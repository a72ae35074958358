"""Rows near a target made into a seed that is exactly planar and developable."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import MatrixRankWarning, spsolve

from solver.measure import angle_excess
from solver.mesh import QuadMesh, interior_vertices
from solver.targets.base import Target
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, norm

__all__ = ["assembled", "planarised", "planarity_rows", "sector_rows"]

_STEPS = 30


def planarised(
    target: Target, places: FloatArray, offsets: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Rows with planar quads, developable inner vertices, each on its offset (S27, S28).

    places : of the rows, shape (R, m + 1, d); offsets : of each row from the target, shape (R,).
    Returns points (R, m + 1, 3) and their places; None where the constraints cannot be met from
    there. Gauss-Newton; the vertices move least: each step is the shortest that meets the
    linearised constraints.
    """
    rows, width = places.shape[:2]
    flat = places.reshape(rows * width, -1)
    level = np.repeat(offsets, width)
    points = target.point(flat) + level[:, None] * target.normal(flat)
    if not np.isfinite(points).all():
        return None
    quads = QuadMesh.from_rows(points.reshape(rows, width, 3)).faces_vertices
    inside = interior_vertices(quads, len(points))
    scale = float(norm(points[quads[:, 2]] - points[quads[:, 0]]).max())
    everywhere = np.arange(len(points))
    with np.errstate(all="ignore"):  # what fails is NaN and ends the search
        for _ in range(_STEPS):
            distance, gradient, flat = target.distance(points, flat)
            parts = [
                planarity_rows(points, quads, scale),
                sector_rows(points, quads, inside),
                ((distance - level) / scale, (everywhere, everywhere, gradient / scale)),
            ]
            miss = np.concatenate([part[0] for part in parts])
            jacobian = assembled([(len(part[0]), *part[1]) for part in parts], len(points))
            step = _shortest_step(jacobian, miss)
            if not np.abs(step).max() < scale * width:
                return None
            points = points + step.reshape(-1, 3)
            if np.abs(step).max() < 1e-15 * scale:
                break
    if not np.abs(miss).max() < 1e-9:
        return None
    flat = target.distance(points, flat)[2]
    return points.reshape(rows, width, 3), flat.reshape(rows, width, -1)


def _shortest_step(jacobian: csr_array, miss: FloatArray) -> FloatArray:
    """The least change that makes up for `miss`; NaN where there is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MatrixRankWarning)
        try:
            out: FloatArray = jacobian.T @ spsolve((jacobian @ jacobian.T).tocsc(), -miss)
        except RuntimeError:  # the factorisation gave up on the numbers
            return np.full(jacobian.shape[1], np.nan)
    return out


def planarity_rows(
    points: FloatArray, quads: IntArray, scale: float
) -> tuple[FloatArray, tuple[IntArray, IntArray, FloatArray]]:
    """Volume of each quad over scale^3, with (constraint, vertex, gradient) triples."""
    p = points[quads]
    e = (p[:, 1:] - p[:, :1]) / scale
    slopes = [cross(e[:, 1], e[:, 2]), cross(e[:, 2], e[:, 0]), cross(e[:, 0], e[:, 1])]
    gradients = np.stack([-(slopes[0] + slopes[1] + slopes[2]), *slopes], axis=1) / scale
    constraint = np.repeat(np.arange(len(quads)), 4)
    return dot(e[:, 0], slopes[0]), (constraint, quads.ravel(), gradients.reshape(-1, 3))


def sector_rows(
    points: FloatArray, quads: IntArray, inside: BoolArray
) -> tuple[FloatArray, tuple[IntArray, IntArray, FloatArray]]:
    """Angle excess of each inner vertex, with (constraint, vertex, gradient) triples."""
    excess = angle_excess(points, quads, inside)[inside]
    number = np.cumsum(inside) - 1
    corner = quads.ravel()
    ends = np.roll(quads, -1, axis=1).ravel(), np.roll(quads, 1, axis=1).ravel()
    keep = inside[corner]
    corner, after, before = corner[keep], ends[0][keep], ends[1][keep]
    u, v = points[after] - points[corner], points[before] - points[corner]
    size_u, size_v = norm(u)[:, None], norm(v)[:, None]
    u, v = u / size_u, v / size_v
    cosine = dot(u, v)[:, None]
    sine = norm(cross(u, v))[:, None]
    by_u, by_v = (cosine * u - v) / (size_u * sine), (cosine * v - u) / (size_v * sine)
    constraint = np.tile(number[corner], 3)
    vertex = np.concatenate([after, before, corner])
    return excess, (constraint, vertex, np.concatenate([by_u, by_v, -by_u - by_v]))


def assembled(parts: list[tuple[int, IntArray, IntArray, FloatArray]], count: int) -> csr_array:
    """One sparse Jacobian of all constraints over the 3 x count coordinates."""
    rows, columns, values = [], [], []
    begin = 0
    for size, constraint, vertex, gradient in parts:
        rows.append(np.repeat(constraint + begin, 3))
        columns.append((3 * vertex[:, None] + np.arange(3)).ravel())
        values.append(gradient.ravel())
        begin += size
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return csr_array(entries, shape=(begin, 3 * count))
