"""What triangles show at every pixel: what is in front hides what is behind.

A buffer of depths, pixel by pixel, is right also where faces pass through each other or are above
and below one another in a ring, which no order of painting whole faces is.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from solver.vectors import FloatArray, IntArray, cross

__all__ = ["nearest_triangles"]

# Triangles times rows, or pixels, that are worked on at once.
_AT_ONCE = 4_000_000
# Triangles narrower than this are slim, and have points so near to each other, in pixels.
_SLIM, _SPACING = 1.0, 0.7


def nearest_triangles(
    corners: FloatArray, width: int, height: int, *, slim: bool = True
) -> tuple[IntArray, FloatArray]:
    """The triangle that each pixel shows, -1 where there is none, and its height there.

    corners : shape (n, 3, 3): pixels from the left, from the top, and towards the viewer
    (`Camera.pixels`), finite. A pixel is covered where its centre is, and where the longest side of
    a triangle passes that is narrower than a pixel: slim faces are seen as lines, unless `slim` is
    false. Of triangles at the same height it shows the last. Both arrays have shape (height,
    width); heights are -inf where there is no triangle.

    >>> low = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    >>> high = np.array([[0.0, 0, 1], [2, 0, 1], [0, 2, 1]])
    >>> nearest_triangles(np.stack([high, low]), 4, 3)[0].tolist()
    [[0, 1, 1, -1], [1, 1, -1, -1], [1, -1, -1, -1]]
    """
    depth = np.full(height * width, -np.inf)
    owner = np.full(height * width, -1)
    # height = level + slope . (x, y): triangles seen from the side have no slope to trust
    normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.nan_to_num(-normal[:, :2] / normal[:, 2:], posinf=0.0, neginf=0.0)
    level = corners[:, 0, 2] - (slope * corners[:, 0, :2]).sum(axis=1)
    lowest, highest = corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
    top = _first_centre(corners[:, :, 1].min(axis=1), height)
    end = _first_centre(corners[:, :, 1].max(axis=1), height)
    for chunk in _chunks(end - top):
        triangle, row = _counted(end[chunk] - top[chunk])
        row += top[chunk][triangle]
        triangle += chunk.start
        left, right = _spans(corners[triangle], np.asarray(row + 0.5, np.float64))
        first = _first_centre(left, width)
        count = _first_centre(right, width) - first
        for part in _chunks(count):
            line, column = _counted(count[part])
            line += part.start
            column += first[line]
            shown, y = triangle[line], row[line]
            there = level[shown] + slope[shown, 0] * (column + 0.5) + slope[shown, 1] * (y + 0.5)
            there = np.clip(there, lowest[shown], highest[shown])
            pixel = y * width + column
            np.maximum.at(depth, pixel, there)
            visible = there >= depth[pixel]
            owner[pixel[visible]] = shown[visible]
    for pixel, there, shown in _slim(corners, width, height) if slim else ():
        np.maximum.at(depth, pixel, there)
        visible = there >= depth[pixel]
        owner[pixel[visible]] = shown[visible]
    return owner.reshape(height, width), depth.reshape(height, width)


def _slim(
    corners: FloatArray, width: int, height: int
) -> Iterator[tuple[IntArray, FloatArray, IntArray]]:
    """Pixels along slim triangles: their numbers, heights and triangles."""
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.hypot(sides[..., 0], sides[..., 1])
    twice = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
    slim = np.flatnonzero(np.abs(twice) < _SLIM * lengths.max(axis=1))
    longest = lengths[slim].argmax(axis=1)
    start, along = corners[slim, longest], sides[slim, longest]
    counts = np.ceil(lengths[slim, longest] / _SPACING).astype(np.int64) + 1
    for part in _chunks(counts):
        line, number = _counted(counts[part])
        line += part.start
        share = number / np.maximum(counts[line] - 1, 1)
        at = start[line] + share[:, None] * along[line]
        x, y = np.floor(at[:, 0]).astype(np.int64), np.floor(at[:, 1]).astype(np.int64)
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        yield (y * width + x)[inside], at[inside, 2], slim[line[inside]]


def _first_centre(places: FloatArray, count: int) -> IntArray:
    """The first of `count` pixels whose centre is at a place or beyond it; at most `count`."""
    return np.asarray(np.clip(np.ceil(places - 0.5), 0, count).astype(np.int64))


def _chunks(counts: IntArray) -> list[slice]:
    """Runs of items with given counts of parts, each run as large as is worked on at once."""
    total = np.cumsum(np.maximum(counts, 0))
    if not len(total):
        return []
    cuts = np.searchsorted(total, np.arange(_AT_ONCE, total[-1], _AT_ONCE))
    ends = np.unique([0, *cuts, len(counts)]).tolist()
    return [slice(a, b) for a, b in pairwise(ends)]


def _counted(counts: IntArray) -> tuple[IntArray, IntArray]:
    """For items with given counts of parts: the item of every part, and its number in it."""
    counts = np.maximum(counts, 0)
    item = np.repeat(np.arange(len(counts)), counts)
    return item, np.arange(len(item)) - np.repeat(np.cumsum(counts) - counts, counts)


def _spans(corners: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least and largest x of triangles (n, 3, 3) at the heights y, shapes (n,)."""
    x, height = corners[:, :, 0], corners[:, :, 1]
    left, right = np.full(len(y), np.inf), np.full(len(y), -np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        a, b = height[:, i], height[:, j]
        crosses = (a <= y) != (b <= y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = x[:, i] + (x[:, j] - x[:, i]) * (y - a) / (b - a)
        left = np.where(crosses, np.minimum(left, at), left)
        right = np.where(crosses, np.maximum(right, at), right)
    empty = left > right
    return np.where(empty, 0.0, left), np.where(empty, 0.0, right)
