"""Edges of a file and the faces between them, on their way to a crease pattern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fab.errors import Finding, Severity, first_few
from fab.formats.drawn.line_soup import Letters
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Faces", "Lines", "Repair", "listed", "places_of"]

# A finding has up to this many places; its text has the count of all.
_PLACES = 200


@dataclass(frozen=True)
class Lines:
    """Edges between numbered vertices, each pair of vertices once.

    Attributes
    ----------
    path : of the file, for messages.
    coords : all vertices, mm, shape (nv, 2).
    pairs, letters, angles : vertices, assignment, fold angle; shapes (n, 2), (n,), (n,).
    number : what findings call the edges: their numbers in a FOLD file, shape (n,).
    planar : numbers of the edges in the planar graph of the file's lines, shape (n,).
    elements, element : of drawings, what the file calls its elements, and that of each edge.
    downwards : whether y points down in the file, and so in messages.
    """

    path: Path
    coords: FloatArray
    pairs: IntArray
    letters: Letters
    angles: FloatArray
    number: IntArray
    planar: IntArray
    elements: tuple[str, ...] = ()
    element: IntArray | None = None
    downwards: bool = False

    def part(self, which: IntArray | BoolArray) -> Lines:
        """Some of the lines."""
        return replace(
            self,
            pairs=self.pairs[which],
            letters=self.letters[which],
            angles=self.angles[which],
            number=self.number[which],
            planar=self.planar[which],
            element=None if self.element is None else self.element[which],
        )

    def keys(self, pairs: IntArray | None = None) -> IntArray:
        """A number for each pair of vertices, whichever of them is first; by default the own."""
        ends = self.pairs if pairs is None else pairs
        out: IntArray = ends.min(axis=1) * len(self.coords) + ends.max(axis=1)
        return out

    def name(self, row: int) -> str:
        """What the file calls one of the lines."""
        if self.element is None:
            return f"edge {self.number[row]}"
        return self.elements[int(self.element[row])]

    def named(self, rows: IntArray) -> str:
        """What the file calls some of the lines: all, or how many and the first."""
        if self.element is None:
            return listed("edge", np.sort(self.number[rows]))
        if len(rows) == 1:
            return f"{self.name(rows[0])} at {self.place(rows[0])}"
        return f"{len(rows)} edges, the first of {self.name(rows[0])} at {self.place(rows[0])},"

    def place(self, row: int) -> str:
        """The middle of a line, in messages."""
        return self.point(self.coords[self.pairs[row]].mean(axis=0))

    def point(self, point: FloatArray) -> str:
        """A point in messages, as the file has it."""
        x, y = point * [1.0, -1.0] if self.downwards else point
        return f"({x:.6g}, {y + 0.0:.6g}) mm"

    def middles(self, rows: IntArray | BoolArray) -> FloatArray:
        """The middles of some of the lines, shape (n, 2)."""
        out: FloatArray = self.coords[self.pairs[rows]].mean(axis=1)
        return out


@dataclass(frozen=True)
class Faces:
    """Counterclockwise faces, one after another as in a crease pattern.

    number : numbers of the faces in the file, shape (nf,).
    """

    corners: IntArray
    offsets: IntArray
    number: IntArray

    def ring(self, face: int) -> IntArray:
        """The corners of one face."""
        return self.corners[self.offsets[face] : self.offsets[face + 1]]


@dataclass(frozen=True)
class Repair:
    """A finding about edges of the planar graph, which are not yet those of the pattern.

    places : in the drawing, mm, y upwards, shape (n, 2).
    """

    code: str
    severity: Severity
    text: str
    edges: IntArray
    places: FloatArray = field(default_factory=lambda: np.empty((0, 2)))

    def finding(self, numbers: IntArray) -> Finding:
        """The finding; `numbers` gives the pattern's edge of each planar one, -1 where none is."""
        edges = numbers[self.edges]
        creases = first_few(np.unique(edges[edges >= 0]))
        return Finding(
            self.code, self.severity, self.text, creases=creases, places=places_of(self.places)
        )


def listed(kind: str, numbers: IntArray | Sequence[int], several: str = "") -> str:
    """Such as "edges 3, 5, 8, 9, 12 and 7 more"."""
    more = f" and {len(numbers) - 5} more" if len(numbers) > 5 else ""
    noun = (several or f"{kind}s") if len(numbers) > 1 else kind
    return f"{noun} {', '.join(map(str, numbers[:5]))}{more}"


def places_of(points: FloatArray) -> tuple[tuple[float, float], ...]:
    """The first 200 of some points, shape (n, 2), as a finding lists them."""
    return tuple((float(x), float(y)) for x, y in points[:_PLACES])
