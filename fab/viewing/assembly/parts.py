"""What an assembly guide is about: pieces, joints between them, sheets that they are cut from."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.assembly.piece_colours import piece_colours
from solver.vectors import FloatArray, IntArray

__all__ = ["Assembly", "CutPiece", "CutSheet", "Hold", "Joint", "Model", "Motion", "Point"]


@dataclass(frozen=True)
class CutPiece:
    """A piece of the pattern.

    Attributes
    ----------
    name : its letters.
    faces : numbers in the pattern, shape (n,).
    tabs : outlines of its tabs as they lie in the flat pattern, mm, each of shape (m, 2).
    outline : rings along which it is cut, each of shape (k, 2), mm, in a plane of its own.
    lettered : whether its letters are engraved on it.
    """

    name: str
    faces: IntArray
    tabs: tuple[FloatArray, ...]
    outline: tuple[FloatArray, ...]
    lettered: bool = True


class Hold(Enum):
    """What holds the two sides of a joint together."""

    TAB = "a tab of one side, under the other"
    TABS = "tabs of both sides, on each other"
    TONGUE = "a tongue of one side, in a slot of the other"
    STITCHES = "thread"
    TAPE = "tape"
    DOVETAIL = "tongues in pockets"
    PIN = "pins"


@dataclass(frozen=True)
class Joint:
    """A seam of two pieces, or of two edges of the same piece.

    Attributes
    ----------
    label : its number, in the order of assembling; engraved : as it is on the pieces, with a full
        stop where upside down it would be another one.
    edges : of the pattern, on both sides; the same twice where they lie on each other when flat.
    pieces : numbers of the pieces.
    hold : what holds it. holder : number of the piece that has the tab or the tongue, if one has.
    stitches : how many.
    """

    label: int
    engraved: str
    edges: tuple[int, int]
    pieces: tuple[int, int]
    length_mm: float
    fold_angle_deg: float
    hold: Hold
    holder: int | None
    stitches: int = 0

    @property
    def closing(self) -> bool:
        """Whether its edges are apart in the flat sheet, and come together when it is folded."""
        return self.edges[0] != self.edges[1]


@dataclass(frozen=True)
class Point:
    """A point at which rims of sheets are glued together.

    text : that is engraved beside it on both; vertices : on both sheets.
    """

    text: str
    vertices: tuple[int, int]


class Motion(Enum):
    """How the faces of a sheet move as it folds."""

    TOGETHER = "flat, all creases at once"
    RIGID = "flat"
    BENDS = "bending"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Model:
    """A pattern that is cut in pieces and put together.

    Attributes
    ----------
    name : of the pattern.
    pattern : flat, in mm.
    formed : the same faces in their folded form, where it is known; its cuts may be open.
    upright : whether z is up in the folded form.
    pieces : in the order of assembling; joints : in the order of gluing; points : likewise.
    facts : names and values of what is stated of it.
    copies : how many are made.
    first, total : pieces of models before it, and of all, whose colours all differ.
    motion : of its faces.
    seam : what a joint is called.
    """

    name: str
    pattern: CreasePattern
    formed: CreasePattern | None
    upright: bool
    pieces: tuple[CutPiece, ...]
    joints: tuple[Joint, ...]
    points: tuple[Point, ...]
    facts: tuple[tuple[str, str], ...]
    copies: int
    first: int
    total: int
    motion: Motion = Motion.UNKNOWN
    seam: str = "seam"

    @cached_property
    def faces_piece(self) -> IntArray:
        """The piece that each face is in, shape (nf,)."""
        out = np.full(self.pattern.face_count, -1)
        for number, piece in enumerate(self.pieces):
            out[piece.faces] = number
        return out

    @cached_property
    def colours(self) -> FloatArray:
        """Red, green and blue of the upper side of each piece, from 0 to 1, shape (n, 3)."""
        return piece_colours(self.total)[self.first : self.first + len(self.pieces)]

    @property
    def alone(self) -> bool:
        """Whether it is one piece that needs no letters."""
        return self.total == 1


@dataclass(frozen=True)
class CutSheet:
    """A sheet of the stock, or several alike; or a plate of a printer.

    Attributes
    ----------
    numbers : of the sheets, counted from 1.
    size_mm : of the stock.
    pieces : of each piece on it the number among the pieces of all models, and its turn (2, 2) and
        shift (2,), as in nesting.
    minutes : of cutting one of them, where that is known.
    noun : what it is called.
    """

    numbers: tuple[int, ...]
    size_mm: tuple[float, float]
    pieces: tuple[tuple[int, FloatArray, FloatArray], ...]
    minutes: float | None
    noun: str = "sheet"


@dataclass(frozen=True)
class Assembly:
    """All that a guide shows: models, and the sheets from which they are cut together.

    facts : names and values of what is stated at the head. made_by : the command.
    cutting : sentences on what is to be done when the sheets are cut.
    face_down : whether they are cut face down.
    caution : what is to be read before anything is made; empty where there is nothing.
    """

    name: str
    made_by: str
    models: tuple[Model, ...]
    sheets: tuple[CutSheet, ...]
    facts: tuple[tuple[str, str], ...]
    cutting: tuple[str, ...] = ()
    face_down: bool = False
    caution: str = ""
