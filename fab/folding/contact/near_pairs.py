"""Pairs of parts that may come near each other while every vertex stays within a box of its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fab.folding.contact.surface import Pairs, Surface
from solver.vectors import FloatArray, IntArray

__all__ = ["NearPairs", "near_pairs"]

# Parts whose boxes are looked up at a time: this bounds the memory, not the answer.
_AT_ONCE = 8192


@dataclass(frozen=True)
class NearPairs:
    """The pairs that may be near.

    Attributes
    ----------
    pairs : all that come within the reach for which they were found.
    low, high : shape (nv, 3), the box of every vertex.
    margin : by which the boxes are larger than was needed when they were made.
    """

    pairs: Pairs
    low: FloatArray
    high: FloatArray
    margin: float

    @cached_property
    def span(self) -> float:
        """Mean side of the boxes."""
        return float((self.high - self.low).mean())

    def covers(self, coords: FloatArray) -> bool:
        """Whether all vertices are in their boxes, so that no other pairs are near."""
        return bool((coords >= self.low).all() and (coords <= self.high).all())


def near_pairs(
    surface: Surface, low: FloatArray, high: FloatArray, reach: float, margin: float
) -> NearPairs:
    """The pairs that come within `reach` of each other while the vertices are in their boxes.

    low, high : shape (nv, 3), the boxes, which `margin` enlarges.

    Cost: O(n log n) for a sheet that is spread out, more where many layers lie on one another.
    """
    import shapely  # not needed where nothing touches

    low, high = low - margin, high + margin
    middle = (low + high) / 2
    middle = middle - middle.mean(axis=0)
    across = int(np.argmin((middle**2).sum(axis=0)))  # boxes are sorted by the other two
    order = [axis for axis in range(3) if axis != across] + [across]
    inflated = np.stack([low - reach / 2, high + reach / 2])[:, :, order]

    def boxes(members: IntArray) -> FloatArray:
        return np.stack([inflated[0, members].min(axis=1), inflated[1, members].max(axis=1)])

    def shapes(ends: FloatArray) -> Any:
        return shapely.box(ends[0, :, 0], ends[0, :, 1], ends[1, :, 0], ends[1, :, 1])

    def meeting(of: FloatArray, tree: Any, over: FloatArray) -> tuple[IntArray, IntArray]:
        found = []
        every = shapes(of)
        for start in range(0, of.shape[1], _AT_ONCE):
            first, second = tree.query(every[start : start + _AT_ONCE])
            first = first + start
            near = (of[0, first, 2] <= over[1, second, 2]) & (over[0, second, 2] <= of[1, first, 2])
            found.append(np.stack([first[near], second[near]]))
        pairs = np.concatenate(found, axis=1)
        return pairs[0], pairs[1]

    corners, ends = boxes(surface.triangles), boxes(surface.edges)
    vertices, triangles = meeting(inflated, shapely.STRtree(shapes(corners)), corners)
    first, second = meeting(ends, shapely.STRtree(shapes(ends)), ends)
    once = first < second
    edges = np.column_stack([first[once], second[once]])
    # whatever order the tree gives them in
    sides = np.lexsort((triangles, vertices))
    edges = edges[np.lexsort((edges[:, 1], edges[:, 0]))]
    pairs = surface.pairs(vertices[sides], triangles[sides], edges, reach - surface.gap)
    return NearPairs(pairs, low, high, margin)
