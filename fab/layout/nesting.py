"""Nesting: where each piece lies, and on which sheet of the bed's size.

Pieces are turned and shifted, never mirrored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fab.layout.bed_filling import Filling
from fab.layout.turned_pieces import Spot, turned_piece
from fab.progress import Steps, no_steps
from solver.errors import (
    InvalidValue,
    require_count,
    require_number,
    require_positive,
)
from solver.vectors import FloatArray

__all__ = ["Placement", "Placements", "nest"]


@dataclass(frozen=True)
class Placement:
    """Where one copy of a piece lies: its point p at turn @ p + shift on the sheet.

    Attributes
    ----------
    piece, copy, sheet : counted from 0.
    turn : rotation, shape (2, 2), read-only.
    shift : shape (2,), mm, read-only.
    """

    piece: int
    copy: int
    sheet: int
    turn: FloatArray
    shift: FloatArray

    def __post_init__(self) -> None:
        self.turn.flags.writeable = False
        self.shift.flags.writeable = False


@dataclass(frozen=True)
class Placements:
    """All copies of all pieces on their sheets.

    Attributes
    ----------
    items : sorted by sheet, piece and copy.
    used : share of the bed that pieces cover on each sheet, shape (number of sheets,), falling
        but for sheets with pieces that are to be first; read-only.
    """

    items: tuple[Placement, ...]
    used: FloatArray

    def __post_init__(self) -> None:
        self.used.flags.writeable = False


def nest(
    outlines: Sequence[shapely.Polygon | FloatArray],
    bed_mm: tuple[float, float],
    gap_mm: float,
    copies: int | Sequence[int] = 1,
    margin_mm: float = 0.0,
    progress: Steps = no_steps,
    *,
    rotations_deg: Sequence[float] | None = None,
    first: Sequence[bool] | None = None,
) -> Placements:
    """Place `copies` of every piece on as few sheets as a greedy filling needs.

    Pieces turn by multiples of 90 degrees from the rotation in which their box is least, or from
    that of their outline where they fit the bed in no other. Each sheet takes the largest pieces
    left, batch by batch from its lower left corner, and what is left in the gaps and holes; the
    sheet used least is the last. The same pieces give the same placements. The cost grows with the
    number of pieces; copies of full sheets are free.

    Parameters
    ----------
    outlines : polygons as they are cut (kerf included), mm, holes allowed; or corners, shape
        (m, 2).
    bed_mm : width and height of the bed.
    gap_mm : least distance of two pieces.
    copies : of all pieces, or of each.
    margin_mm : least distance of a piece from the bed's edges.
    progress : called after each batch with the number of pieces placed and of all.
    rotations_deg : by which pieces may be turned, at least one; None for any: see above.
    first : whether all copies of a piece come before the others: on the first sheets, on as many
        as they need alone. Others take the room that they leave.

    Raises `InvalidValue` for an outline that crosses itself or has no area, for a piece that does
    not fit the bed in any of its turns, and for a gap, margin or number of copies out of bounds.

    >>> placements = nest([shapely.box(0, 0, 60, 30)], (124.0, 64.0), gap_mm=2.0, copies=5)
    >>> [(item.copy, item.sheet) for item in placements.items]
    [(0, 0), (1, 0), (2, 0), (3, 0), (4, 1)]
    >>> placements.used.round(3).tolist()
    [0.907, 0.227]
    """
    room = _room(bed_mm, margin_mm)
    require_positive("gap_mm", gap_mm, "Pieces that touch would be cut along one line twice.")
    counts = [copies] * len(outlines) if isinstance(copies, int) else list(copies)
    for count in [copies] if isinstance(copies, int) else counts:
        require_count("copies", count, 1, "Cut at least one of each piece.")
    if len(counts) != len(outlines):
        raise InvalidValue(
            "copies", counts, f"have {len(outlines)} numbers", "Give one for each piece."
        )
    if rotations_deg is not None and not (len(rotations_deg) and np.isfinite(rotations_deg).all()):
        raise InvalidValue(
            "rotations_deg", list(rotations_deg), "be one angle or more", "Give [0] for no turn."
        )
    pieces = [
        turned_piece(number, outline, room, rotations_deg)
        for number, outline in enumerate(outlines)
    ]
    filling = Filling(pieces, room, gap_mm)
    early = np.zeros(len(pieces), bool) if first is None else np.array(first, bool)
    left = np.array(counts, np.int64)
    total = int(left.sum())
    filled: list[list[Spot]] = []
    while left.any():
        spots = filling.sheet(left, early, lambda unplaced: progress(total - unplaced, total))
        left = left - filling.counts(spots)
        filled.append(spots)
    used = np.array([filling.net_area[[spot.piece for spot in spots]].sum() for spots in filled])
    late = np.array([not early[[spot.piece for spot in spots]].any() for spots in filled], bool)
    by_use = np.lexsort((-used, late))
    items: list[Placement] = []
    seen = [0] * len(pieces)
    for sheet, number in enumerate(by_use.tolist()):
        for spot in sorted(filled[number], key=lambda s: (s.piece, s.shift[1], s.shift[0])):
            shift = spot.shift + margin_mm
            items.append(Placement(spot.piece, seen[spot.piece], sheet, spot.turn.copy(), shift))
            seen[spot.piece] += 1
    return Placements(tuple(items), used[by_use] / (bed_mm[0] * bed_mm[1]))


def _room(bed_mm: tuple[float, float], margin_mm: float) -> FloatArray:
    """Width and height between the margins, shape (2,)."""
    for side in bed_mm:
        require_positive("bed_mm", side)
    require_number("margin_mm", margin_mm)
    if not 0 <= margin_mm < min(bed_mm) / 2:
        bound = f"lie from 0 to less than half the bed's shorter side ({min(bed_mm) / 2:g} mm)"
        raise InvalidValue("margin_mm", margin_mm, bound, "Lower the margin or use a larger bed.")
    return np.array(bed_mm, float) - 2 * margin_mm
