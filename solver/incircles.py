"""Widest circles in quads of space, behind setbacks of their sides, and how they change.

What is left of a quad behind its setbacks s are the points x of its plane with n . (x - a) >= s for
all sides, with the side's first corner a and its unit normal n inwards. The widest circle in it
touches up to three sides with weights w >= 0, sum w = 1, sum w n = 0, and its radius is
sum w (n . (x - a) - s): by the envelope theorem it changes as if its middle x and w stood still.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from solver.vectors import FloatArray, cross, dot, norm, unit

__all__ = ["Incircles", "incircles"]

# Sines below this are those of parallel sides.
_PARALLEL = 1e-12


@dataclass(frozen=True)
class Incircles:
    """Of n quads.

    Attributes
    ----------
    radii : shape (n,); negative where nothing is left: a circle would fit if all setbacks were less
        by as much. gradients : by the corners, shape (n, 4, 3). weights : of the sides, shape
        (n, 4): the radius falls by as much as the setback rises.
    """

    radii: FloatArray
    gradients: FloatArray
    weights: FloatArray


def incircles(corners: FloatArray, setbacks: FloatArray) -> Incircles:
    """Widest circles behind setbacks.

    corners : shape (n, 4, 3), counterclockwise; of quads that are not quite planar, as they are
    seen along the normal of their area. setbacks : of the side from each corner to the next, shape
    (n, 4). Quads without area have radius 0 or less.

    >>> square = np.array([[[0.0, 0, 5], [4, 0, 5], [4, 4, 5], [0, 4, 5]]])
    >>> incircles(square, np.array([[0.0, 1, 0, 0]])).radii.tolist()
    [1.5]
    """
    middle = corners.mean(axis=1, keepdims=True)
    arm = corners - middle
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = unit(cross(arm[:, 2] - arm[:, 0], arm[:, 3] - arm[:, 1]))
    normal = np.where(np.isfinite(normal), normal, 0.0)[:, None]
    arm = arm - dot(arm, np.broadcast_to(normal, arm.shape))[:, :, None] * normal
    side = np.roll(arm, -1, axis=1) - arm
    length = np.maximum(norm(side), np.finfo(float).tiny)
    along = side / length[:, :, None]
    inward = cross(np.broadcast_to(normal, along.shape), along)
    depth = -dot(inward, arm) - setbacks  # of the middle behind each setback
    radii, weights = _by_triples(along, normal[:, 0], depth)
    # the middle of the circle, from the sides that it touches
    touched = weights > 0
    pull = np.einsum("nk,nki,nkj->nij", touched, inward, inward)
    pull += normal[:, 0, :, None] * normal[:, 0, None, :]
    right = np.einsum("nk,nki->ni", touched * (radii[:, None] - depth), inward)
    centre = np.einsum("nij,nj->ni", np.linalg.pinv(pull, hermitian=True), right)
    share = dot(centre[:, None] - arm, along) / length
    first = -(weights * (1 - share))[:, :, None] * inward
    second = -(weights * share)[:, :, None] * inward
    return Incircles(radii, first + np.roll(second, 1, axis=1), weights)


def _by_triples(
    along: FloatArray, normal: FloatArray, depth: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Radii, shape (n,), and weights of sides, (n, 4): of the three that bound it most.

    Three sides balance with the sines between the other two.
    """
    radii = np.full(len(depth), np.inf)
    best = np.zeros_like(depth)
    rows = np.arange(len(depth))
    for i, j, k in combinations(range(4), 3):
        pairs = ((j, k), (k, i), (i, j))
        sines = np.stack([dot(cross(along[:, a], along[:, b]), normal) for a, b in pairs], axis=1)
        sines *= np.sign(sines.sum(axis=1))[:, None]
        sines[np.abs(sines) < _PARALLEL] = 0.0
        total = sines.sum(axis=1)
        weights = np.zeros_like(depth)
        weights[:, [i, j, k]] = sines / np.where(total > 0, total, 1.0)[:, None]
        bound = (weights * depth).sum(axis=1)
        binds = (sines >= 0).all(axis=1) & (total > 0) & (bound < radii)
        radii, best[rows[binds]] = np.where(binds, bound, radii), weights[binds]
    return np.where(np.isfinite(radii), radii, 0.0), best
