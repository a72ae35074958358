"""The part of a surface's domain that a sheet covers, and the faces of a sheet in one piece."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from solver.targets.base import Target
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["coverage", "one_piece", "outline", "rim", "windings"]

# Sample points of the domain, along u and along v, by which coverage is counted.
_SAMPLES = 100
# Parts of an outline's edge that are taken as straight in the surface's parameters.
_PARTS = 4


def rim(grid: FloatArray) -> FloatArray:
    """Once around a grid (R, C, d), shape (n, d)."""
    return np.concatenate([grid[0], grid[1:, -1], grid[-1, -2::-1], grid[-2:0:-1, 0]])


def outline(target: Target, points: FloatArray, places: FloatArray) -> FloatArray:
    """Parameters of the surface under a closed line in space, shape (n, 2).

    points : the line's vertices, shape (k, 3); places : nearest to them, shape (k, d).
    """
    ends = np.roll(points, -1, axis=0), np.roll(places, -1, axis=0)
    shares = np.arange(_PARTS)[:, None] / _PARTS
    between = points[:, None] + shares * (ends[0] - points)[:, None]
    guess = (places[:, None] + shares * (ends[1] - places)[:, None]).reshape(-1, places.shape[1])
    uv = target.distance(between.reshape(-1, 3), guess)[2][:, :2]
    return np.where(np.isfinite(uv), uv, guess[:, :2])


def coverage(target: Target, outlines: list[FloatArray]) -> float:
    """Share of the domain within outlines (n, 2), counted on a grid of its parameters.

    What an outline goes around, however often, is under the sheet for certain.
    """
    grid = (np.arange(_SAMPLES) + 0.5) * (2 / _SAMPLES) - 1.0
    uv = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    inside = uv[target.inside(target.places(uv))]
    return float((windings(outlines, inside) != 0).mean()) if len(inside) else 0.0


def windings(outlines: list[FloatArray], points: FloatArray) -> IntArray:
    """How often closed outlines (k, 2) go around points (n, 2), counterclockwise."""
    out = np.zeros(len(points), np.int64)
    x, y = points.T
    starts = np.concatenate(outlines)
    ends = np.concatenate([np.roll(outline, -1, axis=0) for outline in outlines])
    for (x0, y0), (x1, y1) in zip(starts.tolist(), ends.tolist(), strict=True):
        turn = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
        if y0 < y1:
            out += (y0 <= y) & (y < y1) & (turn > 0)
        else:
            out -= (y1 <= y) & (y < y0) & (turn < 0)
    return out


def one_piece(kept: BoolArray, cells: BoolArray | None = None) -> BoolArray:
    """The largest piece of the cells kept, filled up where two of them touch in a corner alone.

    cells : those that exist, all if left out. Of the two beside such a corner one at least must.
    """
    cells = np.ones(kept.shape, bool) if cells is None else cells
    labels, _ = ndimage.label(kept)
    out: BoolArray = labels == np.bincount(labels[kept]).argmax()
    while True:
        a, b, c, d = out[:-1, :-1], out[:-1, 1:], out[1:, :-1], out[1:, 1:]
        rising, falling = b & c & ~a & ~d, a & d & ~b & ~c
        if not (rising | falling).any():
            return out
        a |= rising & cells[:-1, :-1]
        d |= rising & ~cells[:-1, :-1]
        b |= falling & cells[:-1, 1:]
        c |= falling & ~cells[:-1, 1:]
