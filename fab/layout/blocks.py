"""Blocks: pieces laid side to side along straight sides of equal length, to be placed as one.

A block grows from its largest piece. Every further one is laid against a free side, where the block
stays most compact, and of equal places where most of its sides lie along others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely

from fab.geometry.boxes import smallest_box
from fab.layout.turned_pieces import rotation
from solver.vectors import FloatArray, IntArray

__all__ = ["Block", "BlockPiece", "Member", "blocks", "straight_sides"]

# Sides are equal, and lie along each other, within this, mm: what files round to.
_SAME_MM = 1e-3
_ON_LINE_MM = 1e-6
# Touching pieces may overlap by rounding, in mm2 for each mm of outline.
_OVERLAP_REL = 1e-5
# Turns are allowed within this, degrees.
_SAME_DEG = 1e-6
# Members are grown by this to be one polygon where they touch, mm.
_GROWN_MM = 1e-6
_MOST_MEMBERS = 300
# Sides shorter than this share of their outline are not laid against others.
_LEAST_SHARE = 0.05


@dataclass(frozen=True)
class BlockPiece:
    """A piece that may be laid side to side with others.

    Attributes
    ----------
    outline : as it is cut, kerf included, mm.
    sides : straight sides of the piece itself, with the piece to the left, shape (k, 2, 2).
    copies : how many there are.
    first : whether it has priority; blocks are of pieces alike in this.
    """

    outline: shapely.Polygon
    sides: FloatArray
    copies: int
    first: bool = False


@dataclass(frozen=True)
class Member:
    """A piece of a block: its point p at turn @ p + shift, shapes (2, 2) and (2,)."""

    piece: int
    turn: FloatArray
    shift: FloatArray


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


def straight_sides(ring: FloatArray) -> FloatArray:
    """The long sides of a ring, shape (m, 2), without corners on straight lines: shape (k, 2, 2).

    Those are long that have at least a twentieth of its length: chords of curves are not.

    >>> ring = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    >>> straight_sides(ring)[0].tolist()
    [[0.0, 0.0], [2.0, 0.0]]
    """
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    size = np.hypot(*before.T) * np.hypot(*after.T)
    sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    corners = ring[(np.abs(sine) > 1e-9 * size) | ((before * after).sum(axis=1) < 0)]
    sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    length = _lengths(sides)
    out: FloatArray = sides[length >= _LEAST_SHARE * length.sum()]
    return out


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


@dataclass(frozen=True)
class _Place:
    """Where a piece may be laid: the lower and upper corner of the block with it, and a rank."""

    rank: tuple[float, ...]
    member: Member
    sides: FloatArray
    box: FloatArray


@dataclass
class _Growing:
    """A block that is growing.

    Attributes
    ----------
    members, shapes : those so far, and their outlines in the block.
    sides : their sides in the block, shape (k, 2, 2); taken : how far others run along each, (k,).
    boxes : of the block in each turn that it may have on the bed, shape (t, 2, 2).
    """

    pieces: Sequence[BlockPiece]
    room: FloatArray
    gap: float
    kerf: float
    rotations_deg: Sequence[float] | None
    seed: int
    members: list[Member] = field(default_factory=list)
    shapes: list[shapely.Polygon] = field(default_factory=list)
    sides: FloatArray = field(default_factory=lambda: np.empty((0, 2, 2)))
    taken: FloatArray = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        turns = (0.0, 90.0) if self.rotations_deg is None else tuple(self.rotations_deg)
        self.turns = np.array([rotation(angle) for angle in turns])
        base = np.eye(2)
        if self.rotations_deg is None:  # upright, so that its box says how compact it is
            corner = smallest_box(self.pieces[self.seed].outline)
            along = corner[1] - corner[0]
            base = rotation(float(-np.degrees(np.arctan2(along[1], along[0]))))
        member = Member(self.seed, base, np.zeros(2))
        points = self._points(member)
        self.boxes = np.stack([points.min(axis=1), points.max(axis=1)], axis=1)
        self._add(member, self.pieces[self.seed].sides @ base.T, self.boxes)

    def grow(self, left: IntArray) -> None:
        """Lay pieces against the block until none fits; left : copies of each, seed included."""
        left = left.copy()
        left[self.seed] -= 1
        while left.any() and len(self.members) < _MOST_MEMBERS:
            for place in sorted(self._places(left), key=lambda place: place.rank):
                if self._holds(place.member):
                    self._add(place.member, place.sides, place.box)
                    left[place.member.piece] -= 1
                    break
            else:
                return

    def outline(self) -> shapely.Polygon:
        """The polygon around all members, which have room for other pieces in their holes."""
        if len(self.members) == 1:
            return self.shapes[0]
        grown = [shape.buffer(_GROWN_MM, join_style="mitre") for shape in self.shapes]
        return max(shapely.get_parts(shapely.union_all(grown)), key=lambda part: part.area)

    def _places(self, left: IntArray) -> Iterator[_Place]:
        """Where each piece that is left may be laid against a free side, with room on the bed."""
        seen = set()
        open_sides = self.sides[self.taken < _lengths(self.sides) - _SAME_MM]
        length = _lengths(open_sides)
        for number in np.flatnonzero(left).tolist():
            own = self.pieces[number].sides
            pairs = np.argwhere(np.abs(length[:, None] - _lengths(own)) < _SAME_MM)
            for target, side in pairs.tolist():
                member = self._against(number, open_sides[target], own[side])
                if member is None:
                    continue
                key = (number, *member.turn[0].round(6), *member.shift.round(4))
                if key in seen:
                    continue
                seen.add(key)
                points = self._points(member)
                low = np.minimum(self.boxes[:, 0], points.min(axis=1))
                high = np.maximum(self.boxes[:, 1], points.max(axis=1))
                if not ((high - low) <= self.room - 3 * _GROWN_MM).all(axis=1).any():
                    continue
                sides = own @ member.turn.T + member.shift
                size = (high - low)[0]
                along = _overlaps(sides, self.sides, self.kerf).sum()
                middle = sides.mean(axis=(0, 1))
                rank = (size.max(), -along, size.prod(), *middle[::-1])
                box = np.stack([low, high], axis=1)
                yield _Place(tuple(round(float(x), 5) for x in rank), member, sides, box)

    def _against(self, piece: int, target: FloatArray, side: FloatArray) -> Member | None:
        """The piece with a side against another, a kerf away; None where it may not turn so."""
        ahead, own = target[1] - target[0], side[1] - side[0]
        angle = np.arctan2(-ahead[1], -ahead[0]) - np.arctan2(own[1], own[0])
        angle_deg = float(np.degrees(angle)) % 360.0
        if self.rotations_deg is not None:
            rest = (self._differences() - angle_deg + 180.0) % 360.0 - 180.0
            nearest = int(np.argmin(np.abs(rest)))
            if abs(rest[nearest]) > _SAME_DEG:
                return None
            angle_deg += float(rest[nearest])
        quarter = round(angle_deg / 90.0) * 90.0
        turn = rotation(quarter if abs(angle_deg - quarter) < _SAME_DEG else angle_deg)
        outwards = np.array([ahead[1], -ahead[0]]) / np.hypot(*ahead)
        # middles of both sides, so that rounding of their lengths is shared
        shift = target.mean(axis=0) + self.kerf * outwards - turn @ side.mean(axis=0)
        return Member(piece, turn, shift)

    def _differences(self) -> FloatArray:
        """Turns after which every allowed one is allowed again, in degrees."""
        allowed = np.array(self.rotations_deg, float)
        turns = allowed - allowed[0]
        after = (allowed[None] + turns[:, None]) % 360.0
        rest = (after[..., None] - allowed + 180.0) % 360.0 - 180.0
        kept = (np.abs(rest) < _SAME_DEG).any(axis=2).all(axis=1)
        out: FloatArray = turns[kept] % 360.0
        return out

    def _points(self, member: Member) -> FloatArray:
        """Corners of a member in each turn of the block, shape (t, n, 2)."""
        ring = shapely.get_coordinates(self.pieces[member.piece].outline.exterior)
        out: FloatArray = (ring @ member.turn.T + member.shift) @ self.turns.swapaxes(1, 2)
        return out

    def _holds(self, member: Member) -> bool:
        """Whether a piece touches others or is apart from them, and overlaps none."""
        shape = self._shape(member)
        others = np.array(self.shapes)
        distance = shapely.distance(others, shape)
        near = distance < self.gap - _ON_LINE_MM
        if (distance[near] > 2 * _SAME_MM).any():
            return False
        common = shapely.area(shapely.intersection(others[near], shape))
        return bool((common <= _OVERLAP_REL * shape.length).all())

    def _shape(self, member: Member) -> shapely.Polygon:
        return shapely.transform(
            self.pieces[member.piece].outline, lambda p: p @ member.turn.T + member.shift
        )

    def _add(self, member: Member, sides: FloatArray, box: FloatArray) -> None:
        self.members.append(member)
        self.shapes.append(self._shape(member))
        self.boxes = box
        along = _overlaps(sides, self.sides, self.kerf)
        taken = self.taken + _overlaps(self.sides, sides, self.kerf).sum(axis=1)
        self.taken = np.concatenate([taken, along.sum(axis=1)])
        self.sides = np.concatenate([self.sides, sides])


def _overlaps(sides: FloatArray, others: FloatArray, kerf_mm: float) -> FloatArray:
    """How far each side runs along each other one, a kerf apart; shapes (m, 2, 2) to (m, k)."""
    start = sides[:, None, 0]
    ahead = sides[:, None, 1] - start
    length = np.hypot(ahead[..., 0], ahead[..., 1])
    unit = ahead / length[..., None]
    arms = others[None] - start[:, :, None]  # (m, k, 2, 2)
    across = unit[..., None, 0] * arms[..., 1] - unit[..., None, 1] * arms[..., 0]
    place = (unit[:, :, None] * arms).sum(axis=-1)
    facing = (np.abs(across + kerf_mm) < _SAME_MM).all(axis=-1)
    facing &= place[..., 0] > place[..., 1]
    overlap = np.minimum(place[..., 0], length) - np.maximum(place[..., 1], 0.0)
    out: FloatArray = np.where(facing, np.maximum(overlap, 0.0), 0.0)
    return out


def _lengths(sides: FloatArray) -> FloatArray:
    out: FloatArray = np.hypot(*(sides[:, 1] - sides[:, 0]).T)
    return out
