"""Numbers of the points at which rims of sheets meet, engraved beside them on both sheets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.drawings.cut_paths import Layer
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.meeting_rims import MeetingRims
from fab.sheets.labels import engraved, number_text
from fab.sheets.piece_labels import EdgeTexts, number_labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["RimPoints", "rim_marks", "rim_points"]

# Greatest height of the numbers, mm.
_LABEL_MM = 4.0
# Numbers are in the middle of this share of an edge, from its vertex that has the number.
_BESIDE = 0.5


@dataclass(frozen=True)
class RimPoints:
    """What is engraved at the ends of edges of the boundary.

    Attributes
    ----------
    texts : n of them.
    edges : the edge beside each point, shape (n,); its face is to its left.
    at_end : whether the point is where the edge ends, not where it starts, shape (n,).
    """

    texts: tuple[str, ...]
    edges: IntArray
    at_end: BoolArray

    @classmethod
    def none(cls) -> RimPoints:
        """No points."""
        return cls((), np.empty(0, np.int64), np.empty(0, bool))

    def chosen(self, which: BoolArray) -> RimPoints:
        """Some of them, shape (n,)."""
        texts = tuple(text for text, kept in zip(self.texts, which.tolist(), strict=True) if kept)
        return RimPoints(texts, self.edges[which], self.at_end[which])

    def lines(self, ends: FloatArray) -> FloatArray:
        """The part of each edge that its number is beside; both shapes (n, 2, 2), of the edges."""
        lines = ends.copy()
        middle = ends[:, 0] + _BESIDE * (ends[:, 1] - ends[:, 0])
        lines[self.at_end, 0] = middle[self.at_end]
        lines[~self.at_end, 1] = middle[~self.at_end]
        return lines


def rim_points(
    meeting: MeetingRims, prefix: str = "", glued: IntArray | None = None, before: int = 0
) -> RimPoints:
    """The numbers of all points on both sheets.

    prefix : of the numbers, where others are engraved too. glued : ends of edges that are glued
    along their length and have numbers of their own: points between two of these have none.
    before : how many points others have, which are counted first.
    """
    count = len(meeting.edges)
    numbers = np.tile(before + np.arange(1, count + 1), 2)
    texts = tuple(f"{prefix}{number_text(number)}" for number in numbers.tolist())
    points = RimPoints(texts, meeting.edges.T.ravel(), np.arange(2 * count) >= count)
    if glued is None:
        return points
    return points.chosen(~np.tile(np.isin(meeting.vertices, glued).all(axis=1), 2))


def rim_marks(pattern: CreasePattern, meeting: MeetingRims) -> list[Layer]:
    """The numbers, engraved beside their vertices on both sheets, where there is room."""
    points = rim_points(meeting)
    ends = pattern.vertices_coords[pattern.edges_vertices[points.edges]]
    beside = EdgeTexts(points.texts, pattern.edges_faces[points.edges, 0], points.lines(ends))
    labels = number_labels(pattern, beside, _LABEL_MM)
    return [engraved([label for label in labels if label is not None])]
