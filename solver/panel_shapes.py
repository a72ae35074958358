"""Panels that are alike: shapes that may be turned and turned over, and in how few they fall.

The shape of a polygon is given by the lengths of its sides and diagonals. Two are as unlike as the
most that one of these lengths differs by, laid on each other as well as can be.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial import cKDTree

from solver.vectors import FloatArray, IntArray, norm

__all__ = ["PanelCount", "PanelShapes", "different_shapes", "shape_lengths", "shape_sides"]

# Rounds in which templates come to the middles of their panels.
_ROUNDS = 12
# Halvings of the interval in which the least distance of so many templates is.
_HALVINGS = 16
# Lengths are the same within this share of the longest.
_SAME = 1e-9
# Lengths that are compared at once.
_AT_ONCE = 4_000_000


@dataclass(frozen=True)
class PanelCount:
    """How many different panels there may be at most, and by how much alike ones may differ.

    Attributes
    ----------
    most : number of templates. within : largest difference of a side or diagonal from that of its
        template.
    shapes : the templates; None: the best for the sheet that is asked of.
    """

    most: int
    within: float
    shapes: PanelShapes | None = None

    def templates(self, lengths: FloatArray) -> PanelShapes:
        """The templates of panels with these `shape_lengths`, (n, k)."""
        return PanelShapes.of(lengths, self.most) if self.shapes is None else self.shapes


def shape_sides(count: int) -> IntArray:
    """Corners of the ends of each side and diagonal of a polygon with `count` corners, (k, 2).

    All sides first, then diagonals over two sides, over three and so on, each from every corner.
    """
    start = np.tile(np.arange(count), count // 2)
    return np.column_stack([start, (start + np.repeat(np.arange(count // 2) + 1, count)) % count])


def shape_lengths(corners: FloatArray) -> FloatArray:
    """Lengths of the `shape_sides` of polygons with corners (n, c, 2) or (n, c, 3), shape (n, k).

    >>> shape_lengths(np.array([[[0.0, 0], [4, 0], [4, 3], [0, 3]]])).tolist()
    [[4.0, 3.0, 4.0, 3.0, 5.0, 5.0, 5.0, 5.0]]
    """
    ends = corners[:, shape_sides(corners.shape[1])]
    return norm(ends[:, :, 1] - ends[:, :, 0])


@cache
def _images(lengths: int) -> IntArray:
    """Places of the lengths of a polygon that is turned or turned over, shape (2 c, k)."""
    corners = next(c for c in range(3, lengths + 1) if c * (c // 2) == lengths)
    start, over = np.arange(corners), np.repeat(np.arange(corners // 2), corners)
    out = []
    for turn in range(corners):
        turned = np.tile((start + turn) % corners, corners // 2)
        out.append(over * corners + turned)
        out.append(over * corners + (-turned - over - 1) % corners)
    return np.array(out)


@dataclass(frozen=True)
class PanelShapes:
    """Templates of panels.

    Attributes
    ----------
    templates : their `shape_lengths`, shape (m, k).
    """

    templates: FloatArray

    @classmethod
    def of(cls, lengths: FloatArray, most: int) -> PanelShapes:
        """About the best templates, at most so many, of panels with the lengths (n, k)."""
        best = cls(lengths[np.unique(_fewest(lengths, most))])
        shapes, unlike = best, float(best.unlike(lengths).max(initial=0.0))
        for _ in range(_ROUNDS):
            shapes = shapes.centred(lengths)
            found = float(shapes.unlike(lengths).max(initial=0.0))
            if found < unlike:
                best, unlike = shapes, found
        return best

    def nearest(self, lengths: FloatArray) -> IntArray:
        """The nearest template of each panel, shape (n,)."""
        return self._nearest(lengths)[0]

    def laid(self, lengths: FloatArray) -> FloatArray:
        """Lengths of the nearest template of each panel, laid on its own, shape (n, k)."""
        which, image = self._nearest(lengths)
        return np.take_along_axis(self.templates[which], _images(lengths.shape[1])[image], axis=1)

    def unlike(self, lengths: FloatArray) -> FloatArray:
        """The largest difference of each panel's lengths from those of its template, (n,)."""
        out: FloatArray = np.abs(lengths - self.laid(lengths)).max(axis=1)
        return out

    def centred(self, lengths: FloatArray) -> PanelShapes:
        """Templates in the middle between the extremes of the panels that are nearest to them."""
        which, image = self._nearest(lengths)
        own = np.empty_like(lengths)  # the panel's lengths, laid on its template
        np.put_along_axis(own, _images(lengths.shape[1])[image], lengths, axis=1)
        low, high = np.full_like(self.templates, np.inf), np.full_like(self.templates, -np.inf)
        np.minimum.at(low, which, own)
        np.maximum.at(high, which, own)
        templates = self.templates.copy()
        used = np.unique(which)
        templates[used] = (low[used] + high[used]) / 2
        return PanelShapes(templates)

    def _nearest(self, lengths: FloatArray) -> tuple[IntArray, IntArray]:
        """The nearest template of each panel, and its image that is nearest, each (n,)."""
        images = _images(lengths.shape[1])
        flat = self.templates[:, images].reshape(-1, lengths.shape[1])
        found = np.empty(len(lengths), np.int64)
        block = max(1, _AT_ONCE // flat.size)
        for first in range(0, len(lengths), block):
            part = lengths[first : first + block]
            far = np.abs(part[:, None] - flat).max(axis=2)
            found[first : first + block] = far.argmin(axis=1)
        return found // len(images), found % len(images)


def different_shapes(lengths: FloatArray, within: float) -> IntArray:
    """The panel that is the template of each panel, shape (n,).

    No side or diagonal differs by more than `within` from that of its template. Few templates are
    found one by one: the fewest would take a search.

    >>> kites = np.array([[[0.0, 0], [2, 1], [3, 3], [1, 2]], [[0, 0], [1, 2], [3, 3], [2, 1]]])
    >>> different_shapes(shape_lengths(np.concatenate([kites, 2 * kites])), 1e-9).tolist()
    [0, 0, 2, 2]
    """
    images = _images(lengths.shape[1])
    # sorted lengths differ by no more than lengths laid on each other do
    parts = np.sort(lengths.reshape(len(lengths), -1, len(images) // 2), axis=2)
    tree = cKDTree(parts.reshape(len(lengths), -1))
    reach = within + _SAME * float(lengths.max(initial=0.0))
    out = np.full(len(lengths), -1)
    for first in range(len(lengths)):
        if out[first] < 0:
            near = np.array(tree.query_ball_point(tree.data[first], reach, p=np.inf), np.int64)
            near = near[out[near] < 0]
            far = np.abs(lengths[near][:, None] - lengths[first][images]).max(axis=2).min(axis=1)
            out[near[far <= reach]] = first
    return out


def _fewest(lengths: FloatArray, most: int) -> IntArray:
    """`different_shapes` within the least distance with which there are so many at most."""
    found = different_shapes(lengths, 0.0)
    if len(np.unique(found)) <= most:
        return found
    low, high = 0.0, float(np.ptp(lengths))
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        tried = different_shapes(lengths, middle)
        if len(np.unique(tried)) > most:
            low = middle
        else:
            found, high = tried, middle
    return found
