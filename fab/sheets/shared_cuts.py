"""Pieces placed side to side, so that the sides that they share are cut once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fab.geometry.rings import ring_areas
from fab.layout.block_places import BlockPiece, straight_sides
from fab.layout.blocks import Block, blocks
from fab.layout.nesting import Placement, Placements, nest
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.outlines import outlines_of
from fab.progress import Steps
from fab.sheets.sheet_request import SheetRequest
from solver.vectors import FloatArray

__all__ = ["placed_side_to_side"]


def placed_side_to_side(
    patterns: Sequence[CreasePattern],
    outlines: Sequence[shapely.Polygon],
    copies: Sequence[int],
    first: Sequence[bool],
    request: SheetRequest,
    progress: Steps,
) -> Placements:
    """Where each copy of each piece is, in blocks of those with equal sides.

    patterns, outlines : of the pieces, the outlines as they are cut. copies, first : of each, how
    many and whether it has priority. progress : called with the number of blocks placed, of all.

    Raises as `fab.layout.nesting.nest`.
    """
    machine, turns = request.machine, request.rotations_deg
    pieces = [
        BlockPiece(outline, straight_sides(_outer_ring(pattern)), many, early)
        for pattern, outline, many, early in zip(patterns, outlines, copies, first, strict=True)
    ]
    room = np.array(machine.bed_mm) - 2 * request.margin_mm
    made = blocks(pieces, room, request.gap_mm, machine.beam.widest_mm, turns)
    placed = nest(
        [block.outline for block in made],
        machine.bed_mm,
        request.gap_mm,
        [block.copies for block in made],
        request.margin_mm,
        progress,
        rotations_deg=turns,
        first=[block.first for block in made],
    )
    return _of_pieces(placed, made, outlines, machine.bed_mm)


def _outer_ring(pattern: CreasePattern) -> FloatArray:
    """The outermost ring of a piece, counterclockwise."""
    rings = outlines_of(pattern).rings
    ends = np.cumsum([0, *(len(ring) for ring in rings)])
    return rings[int(np.argmax(ring_areas(np.concatenate(rings), ends)))]


def _of_pieces(
    placed: Placements,
    made: Sequence[Block],
    outlines: Sequence[shapely.Polygon],
    bed_mm: tuple[float, float],
) -> Placements:
    """Where the pieces of placed blocks are."""
    lying = sorted(
        (
            (
                item.sheet,
                member.piece,
                item.turn @ member.turn,
                item.turn @ member.shift + item.shift,
            )
            for item in placed.items
            for member in made[item.piece].members
        ),
        key=lambda row: (row[0], row[1], *row[3][::-1]),
    )
    seen = [0] * len(outlines)
    used = np.zeros(len(placed.used))
    items = []
    for sheet, piece, turn, shift in lying:
        items.append(Placement(piece, seen[piece], sheet, turn, shift))
        seen[piece] += 1
        used[sheet] += outlines[piece].area
    return Placements(tuple(items), used / (bed_mm[0] * bed_mm[1]))
