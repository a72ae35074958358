"""Several patterns as one, side by side, flat and folded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, IntArray

__all__ = ["SideBySide", "side_by_side"]

# Between two patterns, as a share of the longest side of all.
_APART_REL = 0.1


@dataclass(frozen=True)
class SideBySide:
    """A pattern of several.

    Attributes
    ----------
    pattern : all of them, along x.
    first_edges, first_faces : numbers in it of the first edge and face of each.
    """

    pattern: CreasePattern
    first_edges: IntArray
    first_faces: IntArray


def side_by_side(patterns: Sequence[CreasePattern]) -> SideBySide:
    """One pattern of several, whose folded form is known where that of all is."""
    vertices = _firsts([len(each.vertices_coords) for each in patterns])
    edges = _firsts([len(each.edges_vertices) for each in patterns])
    faces = _firsts([each.face_count for each in patterns])
    corners = _firsts([len(each.faces_vertices) for each in patterns])
    edges_faces = [
        np.where(each.edges_faces >= 0, each.edges_faces + first, -1)
        for each, first in zip(patterns, faces.tolist(), strict=True)
    ]
    offsets = [
        each.faces_offsets[:-1] + first
        for each, first in zip(patterns, corners.tolist(), strict=True)
    ]
    total = sum(len(each.faces_vertices) for each in patterns)
    folded = [each.folded_coords for each in patterns if each.folded_coords is not None]
    pattern = CreasePattern(
        _in_a_row([each.vertices_coords for each in patterns]),
        np.concatenate(
            [each.edges_vertices + first for each, first in zip(patterns, vertices, strict=True)]
        ),
        np.concatenate(edges_faces),
        np.concatenate([each.edges_assignment for each in patterns]),
        np.concatenate([each.edges_foldAngle for each in patterns]),
        np.concatenate(
            [each.faces_vertices + first for each, first in zip(patterns, vertices, strict=True)]
        ),
        np.concatenate([*offsets, [total]]),
        _in_a_row(folded) if len(folded) == len(patterns) else None,
    )
    return SideBySide(pattern, edges, faces)


def _firsts(counts: Sequence[int]) -> IntArray:
    """The number that the first of each group has, if all are counted in a row."""
    return np.cumsum([0, *counts[:-1]])


def _in_a_row(points: Sequence[FloatArray]) -> FloatArray:
    """Groups of points moved along x so that their boxes are apart, and begin at 0."""
    gap = _APART_REL * max(float(np.ptp(each, axis=0).max()) for each in points)
    moved, place = [], 0.0
    for each in points:
        low, high = each[:, 0].min(), each[:, 0].max()
        shift = np.zeros(each.shape[1])
        shift[0] = place - low
        moved.append(each + shift)
        place += float(high - low) + gap
    return np.concatenate(moved)
