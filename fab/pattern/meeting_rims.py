"""Rims of several sheets that meet when folded: which vertices are glued to which, and how near."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.graphs import labels
from solver.nearest_pairs import nearest_pairs
from solver.vectors import BoolArray, FloatArray, IntArray, dot, norm

__all__ = ["MeetingRims", "meeting_rims"]

# Vertices farther apart than this share of the mean length of edges of the rims do not meet.
_REACH = 0.6
# Those that are nearer than so many of it to a rim of another sheet are along the seam.
_ALONG = 2.0
# Vertices nearer than this share of it are one point.
_SAME = 1e-6


@dataclass(frozen=True)
class MeetingRims:
    """Pairs of vertices at the rims of different sheets, in the order in which they are glued.

    Sheets are joined one after another, each to those before it, along its rim. Pairs are numbered
    in that order, from 1.

    Attributes
    ----------
    vertices : of the earlier and of the later sheet, shape (n, 2).
    sheets : numbers of their sheets, from 0, shape (n, 2).
    gaps_mm : distances of both in the folded form, shape (n,).
    edges : of the rim of either sheet, beside the vertices, that face each other, shape (n, 2).
    rim_gaps_mm : distances of all vertices along the seam, those between pairs too, from rims of
        other sheets in the folded form, shape (k,).
    edge_mm : mean length of edges of the rims.
    """

    vertices: IntArray
    sheets: IntArray
    gaps_mm: FloatArray
    edges: IntArray
    rim_gaps_mm: FloatArray
    edge_mm: float

    @property
    def touching(self) -> BoolArray:
        """Which pairs are one point, shape (n,)."""
        return np.asarray(self.gaps_mm <= _SAME * self.edge_mm)

    def vertices_seam(self, count: int) -> IntArray:
        """The number of the pair that each of `count` vertices is in, 0 for none, (count,)."""
        out = np.zeros(count, np.int64)
        out[self.vertices] = np.arange(1, len(self.vertices) + 1)[:, None]
        return out

    def report(self) -> dict[str, Any]:
        """How many meet and how far they are apart, and each pair with its number."""
        rows = zip(self.vertices.tolist(), self.sheets.tolist(), self.gaps_mm.tolist(), strict=True)
        return {
            "points": len(self.vertices),
            "points_touching": int(self.touching.sum()),
            "points_gap_max_mm": float(self.gaps_mm.max()),
            "rim_vertices": len(self.rim_gaps_mm),
            "rim_gap_mean_mm": float(self.rim_gaps_mm.mean()),
            "rim_gap_max_mm": float(self.rim_gaps_mm.max()),
            "numbers": [
                {"number": k, "sheets": [a + 1, b + 1], "vertices": both, "gap_mm": gap}
                for k, (both, (a, b), gap) in enumerate(rows, 1)
            ],
        }


def meeting_rims(pattern: CreasePattern) -> MeetingRims | None:
    """Where rims of the sheets of a pattern meet; None where none do, or there is one sheet."""
    folded = pattern.folded_coords
    border = np.flatnonzero(pattern.edges_faces[:, 1] < 0)
    if folded is None or not len(border) or not pattern.faces_piece.any():
        return None
    ends = pattern.edges_vertices[border]
    piece = pattern.faces_piece[pattern.edges_faces[border, 0]]
    length = float(norm(folded[ends[:, 1]] - folded[ends[:, 0]]).mean())
    begins, first = np.unique(ends[:, 0], return_index=True)  # the edge that starts at each vertex
    _, last = np.unique(ends[:, 1], return_index=True)  # and the one that ends there
    sheet = piece[first]
    pairs = nearest_pairs(folded[begins], sheet, _REACH * length)
    if not len(pairs):
        return None
    pairs = np.where((sheet[pairs[:, 0]] > sheet[pairs[:, 1]])[:, None], pairs[:, ::-1], pairs)
    partner = np.full(len(begins), -1)
    partner[pairs], partner[pairs[:, ::-1]] = sheet[pairs[:, ::-1]], sheet[pairs]
    following = np.searchsorted(begins, ends[first, 1])
    place = _places(following, partner)
    order = np.lexsort((place[pairs[:, 1]], sheet[pairs[:, 0]], sheet[pairs[:, 1]]))
    pairs = pairs[order]
    vertices = begins[pairs]
    return MeetingRims(
        vertices,
        sheet[pairs],
        norm(folded[vertices[:, 1]] - folded[vertices[:, 0]]),
        # faces are to the left of both rims, so that they run against each other
        np.column_stack([border[first[pairs[:, 0]]], border[last[pairs[:, 1]]]]),
        _rim_gaps(folded[begins], folded[ends], sheet, piece, _ALONG * length),
        length,
    )


def _rim_gaps(
    points: FloatArray, ends: FloatArray, sheet: IntArray, piece: IntArray, reach: float
) -> FloatArray:
    """Distances of points from edges of other sheets, of those within reach.

    points, sheet : shapes (n, 3) and (n,). ends, piece : of the edges, (m, 2, 3) and (m,).
    """
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    out = []
    for point, own in zip(points, sheet.tolist(), strict=True):
        others = piece != own
        share = dot(point - start[others], along[others]) / dot(along[others], along[others])
        foot = start[others] + np.clip(share, 0, 1)[:, None] * along[others]
        out.append(float(norm(point - foot).min()))
    gaps = np.array(out)
    return gaps[gaps <= reach]


def _places(following: IntArray, partner: IntArray) -> IntArray:
    """Places of vertices along their loops, from where they come to another partner, shape (n,).

    following : the next vertex along the rim of each, shape (n,). partner : the sheet that each
    meets, -1 for none, shape (n,).
    """
    count = len(following)
    before = np.empty(count, np.int64)
    before[following] = np.arange(count)
    known = partner.copy()
    for vertex in np.flatnonzero(partner < 0).tolist():  # as the last one that meets another has it
        back = vertex
        for _ in range(count):
            if partner[back] >= 0:
                break
            back = int(before[back])
        known[vertex] = partner[back]
    loop = labels(np.column_stack([np.arange(count), following]), count)
    out, done = np.zeros(count, np.int64), 0
    for number in range(int(loop.max(initial=-1)) + 1):
        own = np.flatnonzero(loop == number)
        turns = own[known[own] != known[before[own]]]
        vertex = int(turns[0] if len(turns) else own[0])
        for _ in range(len(own)):
            out[vertex] = done
            done += 1
            vertex = int(following[vertex])
    return out
