"""Seams: the edges along which the pieces of a sheet are glued together.

A seam is an inner edge of the pattern whose faces are in two pieces, or a pair of edges of its
boundary that come together when it is folded. It has two sides, 0 and 1, and along each the face of
that side lies to the left:

        side 1    <--------    face 1, of one piece
        side 0    -------->    face 0, of the other
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Seam", "SeamSides", "numbered_seams", "places_of", "seam_sides"]


@dataclass(frozen=True)
class Seam:
    """An edge along which two pieces, or two edges of the same piece, are glued together.

    Attributes
    ----------
    label : running number, in the order of assembling; it is engraved on both sides
        (`fab.sheets.labels.number_text`).
    edges : numbers in the whole pattern, of the first and the second side; the same number twice,
        unless the pattern is open at this seam and its folded form is closed.
    pieces : numbers of the pieces of both sides.
    piece_edges : numbers of the edge in the patterns of both pieces.
    length_mm, fold_angle_deg : the fold angle as in a pattern, between the faces of both sides.
    tab : the side that carries the tab, 0 or 1, the first of two; None where there is none.
    stitches : how many pairs of stitching holes it has.
    """

    label: int
    edges: tuple[int, int]
    pieces: tuple[int, int]
    piece_edges: tuple[int, int]
    length_mm: float
    fold_angle_deg: float
    tab: int | None
    stitches: int = 0


@dataclass(frozen=True)
class SeamSides:
    """Both sides of all seams, in the order of assembling, before they have tabs.

    Attributes
    ----------
    edges, faces, pieces : of both sides, shape (n, 2): seam, side.
    vertices : ends of the edges, shape (n, 2, 2): seam, side, end; from the first end to the second
        the face of the side lies to the left.
    foldAngle : degrees, shape (n,).
    """

    edges: IntArray
    faces: IntArray
    vertices: IntArray
    pieces: IntArray
    foldAngle: FloatArray  # noqa: N815 (the FOLD format's own name)

    def __len__(self) -> int:
        return len(self.edges)


def seam_sides(
    pattern: CreasePattern,
    faces_piece: IntArray,
    joined: BoolArray,
    closing: IntArray,
    closing_angle: FloatArray,
) -> SeamSides:
    """All seams: each piece's to the pieces before it, and last those within the piece.

    Parameters
    ----------
    faces_piece : number of the piece that each face is in, in the order of assembling, shape (nf,).
    joined : which edges join their two faces, shape (ne,).
    closing, closing_angle : pairs of boundary edges that come together, shape (m, 2), and their
        fold angles in degrees, shape (m,); see `fab.pattern.closing_edges`.
    """
    inner = np.flatnonzero(joined)
    inner = inner[np.ptp(faces_piece[pattern.edges_faces[inner]], axis=1) > 0]
    edges = np.concatenate([np.column_stack([inner, inner]), closing])
    faces = np.concatenate([pattern.edges_faces[inner], pattern.edges_faces[closing, 0]])
    ends = pattern.edges_vertices[edges]
    ends[: len(inner), 1] = ends[: len(inner), 1, ::-1]
    angle = np.concatenate([pattern.edges_foldAngle[inner], closing_angle])
    pieces = faces_piece[faces]
    # seams of the same two pieces follow each other, in the order in which neighbours are met
    order = np.lexsort((edges[:, 0], pieces.min(axis=1), pieces.max(axis=1)))
    return SeamSides(edges[order], faces[order], ends[order], pieces[order], angle[order])


def places_of(wanted: IntArray, numbers: IntArray) -> IntArray:
    """Where `numbers`, shape (n,), has each of `wanted`, shape (m,), all of which it has.

    >>> places_of(np.array([7, 3]), np.array([3, -1, 7])).tolist()
    [2, 0]
    """
    order = np.argsort(numbers, kind="stable")
    out: IntArray = order[np.searchsorted(numbers[order], wanted)]
    return out


def numbered_seams(
    pattern: CreasePattern,
    pieces_edges: Sequence[IntArray],
    sides: SeamSides,
    seams_tab: IntArray,
    seams_stitches: IntArray,
    before: int = 0,
) -> tuple[Seam, ...]:
    """The seams with their labels, lengths, and the numbers of their edges in both pieces.

    Parameters
    ----------
    pieces_edges : for each piece the numbers in the whole pattern of its edges.
    seams_tab : the side that carries the tab of each seam, -1 for none, shape (n,).
    seams_stitches : how many stitches each has, shape (n,).
    before : how many seams have labels already.
    """
    ends = pattern.vertices_coords[pattern.edges_vertices[sides.edges[:, 0]]]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    own = np.full(sides.edges.shape, -1)
    for number, edges in enumerate(pieces_edges):
        seam, side = np.nonzero(sides.pieces == number)
        own[seam, side] = places_of(sides.edges[seam, side], edges)
    return tuple(
        Seam(
            before + i + 1, (e, f), (p, q), (u, v), size, angle, None if tab < 0 else tab, stitches
        )
        for i, ((e, f), (p, q), (u, v), size, angle, tab, stitches) in enumerate(
            zip(
                sides.edges.tolist(),
                sides.pieces.tolist(),
                own.tolist(),
                length.tolist(),
                sides.foldAngle.tolist(),
                seams_tab.tolist(),
                seams_stitches.tolist(),
                strict=True,
            )
        )
    )
