"""Blocks: pieces laid side to side along straight sides of equal length, to be placed as one.

A block grows from its largest piece. Every further one is laid against a free side, where the block
stays most compact, and of equal places where most of its sides lie along others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from fab.geometry.boxes import smallest_box
from fab.layout.block_places import (
    DECIMALS,
    SAME_MM,
    BlockPiece,
    Member,
    Places,
    Shapes,
    differences_deg,
    lengths,
    lying_at,
    overlaps,
    places_against,
)
from fab.layout.turned_pieces import rotation
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Block", "blocks"]

# Pieces are apart within this, mm.
_ON_LINE_MM = 1e-6
# Touching pieces may overlap by rounding, in mm2 for each mm of outline.
_OVERLAP_REL = 1e-5
# Members are grown by this to be one polygon where they touch, mm.
_GROWN_MM = 1e-6
_MOST_MEMBERS = 300


@dataclass(frozen=True)
class Block:
    """Pieces that are placed as one.

    Attributes
    ----------
    members : one or more. outline : around all of them. copies : how many such blocks there are.
    first : whether its pieces have priority.
    """

    members: tuple[Member, ...]
    outline: shapely.Polygon
    copies: int
    first: bool


def blocks(
    pieces: Sequence[BlockPiece],
    room_mm: FloatArray,
    gap_mm: float,
    kerf_mm: float,
    rotations_deg: Sequence[float] | None = None,
) -> list[Block]:
    """All copies of all pieces in blocks that fit a room; those without partners alone.

    Members of a block touch, a kerf between them, or are at least `gap_mm` apart.

    room_mm : shape (2,). rotations_deg : by which blocks are turned on the bed, so that pieces of a
    block lie turned to each other by differences of these alone; None for any.
    """
    out = []
    left = np.array([piece.copies for piece in pieces], np.int64)
    area = np.array([piece.outline.area for piece in pieces])
    first = np.array([piece.first for piece in pieces], bool)
    while left.any():
        present = np.flatnonzero(left)
        seed = int(present[np.argmax(area[present])])
        allowed = np.where(first == first[seed], left, 0)
        grown = _Growing(pieces, room_mm, gap_mm, kerf_mm, rotations_deg, seed)
        grown.grow(allowed)
        count = np.bincount([member.piece for member in grown.members], minlength=len(pieces))
        times = int((left[count > 0] // count[count > 0]).min())
        out.append(Block(tuple(grown.members), grown.outline(), times, bool(first[seed])))
        left = left - times * count
    return out


class _Growing:
    """A block that is growing from one piece.

    Attributes
    ----------
    members, shapes, sides : those so far, their outlines in the block, and the sides of each.
    places : where pieces that are left may be laid.
    box : around the block in each turn that it may have, shape (t, 2, 2).
    """

    def __init__(
        self,
        pieces: Sequence[BlockPiece],
        room_mm: FloatArray,
        gap_mm: float,
        kerf_mm: float,
        rotations_deg: Sequence[float] | None,
        seed: int,
    ) -> None:
        self.pieces, self.room, self.gap, self.kerf = pieces, room_mm, gap_mm, kerf_mm
        self.differences = None if rotations_deg is None else differences_deg(rotations_deg)
        turns = (0.0, 90.0) if rotations_deg is None else rotations_deg
        self.turns = np.array([rotation(angle) for angle in turns])
        base = 0.0
        if rotations_deg is None:  # upright, so that its box says how compact it is
            corner = smallest_box(pieces[seed].outline)
            along = corner[1] - corner[0]
            base = float(-np.degrees(np.arctan2(along[1], along[0])))
        self.seed = seed
        self.members: list[Member] = []
        self.shapes: list[shapely.Polygon] = []
        self.sides: list[FloatArray] = []
        self.places: dict[int, Places] = {}
        lying = lying_at(pieces[seed], np.array([base]), np.zeros((1, 2)), self.turns)
        self.box = lying.boxes[0]
        self._add(seed, lying, 0)

    def grow(self, left: IntArray) -> None:
        """Lay pieces against the block until none fits; left : copies of each, seed included."""
        left = left.copy()
        left[self.seed] -= 1
        self._find(self.sides[0], np.flatnonzero(left).tolist())
        while len(self.members) < _MOST_MEMBERS:
            best = self._best()
            if best is None:
                return
            piece, number = best
            places = self.places[piece]
            left[piece] -= 1
            if not left[piece]:
                del self.places[piece]
            self.box = self._boxes_with(places)[number]
            self._add(piece, places, number)
            new, shape = places.sides[number], self.shapes[-1]
            for other, there in self.places.items():
                kept = there.chosen(self._holds(there.shapes, shape))
                runs = overlaps(kept.sides.reshape(-1, 2, 2), new, self.kerf).sum(axis=1)
                along = kept.along + runs.reshape(kept.sides.shape[:2]).sum(axis=1)
                self.places[other] = replace(kept, along=along)
            taken = overlaps(new, np.concatenate(self.sides), self.kerf).sum(axis=1)
            free = taken < lengths(new) - SAME_MM
            self._find(new[free], np.flatnonzero(left).tolist())

    def outline(self) -> shapely.Polygon:
        """The polygon around all members, which have room for other pieces in their holes."""
        if len(self.members) == 1:
            return self.shapes[0]
        grown = [shape.buffer(_GROWN_MM, join_style="mitre") for shape in self.shapes]
        return max(shapely.get_parts(shapely.union_all(grown)), key=lambda part: part.area)

    def _add(self, piece: int, places: Places, number: int) -> None:
        self.members.append(Member(piece, places.turns[number], places.shifts[number]))
        self.shapes.append(places.shapes[number])
        self.sides.append(places.sides[number])

    def _boxes_with(self, places: Places) -> FloatArray:
        """Boxes of the block with a piece in each place, in each turn, shape (p, t, 2, 2)."""
        low = np.minimum(self.box[:, 0], places.boxes[:, :, 0])
        high = np.maximum(self.box[:, 1], places.boxes[:, :, 1])
        return np.stack([low, high], axis=2)

    def _best(self) -> tuple[int, int] | None:
        """The piece and its place after which the block is most compact, or None."""
        rows = []
        for piece, places in self.places.items():
            boxes = self._boxes_with(places)
            sizes = boxes[:, :, 1] - boxes[:, :, 0]
            within = np.asarray((sizes <= self.room - 3 * _GROWN_MM).all(axis=2))
            fits = np.flatnonzero(within.any(axis=1))
            if not len(fits):
                continue
            size, middle = sizes[fits, 0], places.sides[fits].mean(axis=(1, 2))
            ranks = [size.max(axis=1), -places.along[fits], size.prod(axis=1), *middle.T[::-1]]
            ranks = [rank.round(DECIMALS) for rank in ranks]
            first = int(np.lexsort(ranks[::-1])[0])
            rows.append((tuple(float(rank[first]) for rank in ranks), piece, int(fits[first])))
        return min(rows)[1:] if rows else None

    def _find(self, free: FloatArray, pieces: Sequence[int]) -> None:
        """Add places of pieces against some sides, shape (k, 2, 2), that are free."""
        tree = shapely.STRtree(self.shapes)
        for piece in pieces:
            found = places_against(
                self.pieces[piece], free, self.kerf, self.turns, self.differences
            )
            known = self.places.get(piece)
            if not len(found):
                continue
            every = found if known is None else known.beside(found)
            _, first = np.unique(every.corners, axis=0, return_index=True)
            old = 0 if known is None else len(known)
            new = every.chosen(np.sort(first[first >= old]))
            near, member = tree.query(new.shapes, predicate="dwithin", distance=self.gap)
            apart = self._holds(new.shapes[near], np.array(self.shapes)[member])
            good = np.ones(len(new), bool)
            good[near[~apart]] = False
            new = new.chosen(good)
            beside = [self.sides[number] for number in np.unique(member).tolist()]
            others = np.concatenate([*beside, np.empty((0, 2, 2))])
            runs = overlaps(new.sides.reshape(-1, 2, 2), others, self.kerf).sum(axis=1)
            new = replace(new, along=runs.reshape(new.sides.shape[:2]).sum(axis=1))
            self.places[piece] = new if known is None else known.beside(new)

    def _holds(self, shapes: Shapes, others: Shapes | shapely.Polygon) -> BoolArray:
        """Whether each shape touches the other or is apart from it, and does not overlap it."""
        distance = shapely.distance(shapes, others)
        common = shapely.area(shapely.intersection(shapes, others))
        touching = (distance < 2 * SAME_MM) & (common <= _OVERLAP_REL * shapely.length(shapes))
        return np.asarray((distance >= self.gap - _ON_LINE_MM) | touching)
