"""Places of pieces beside others, with sides of equal length against each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.layout.turned_pieces import rotation
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "DECIMALS",
    "SAME_MM",
    "BlockPiece",
    "Member",
    "Places",
    "Shapes",
    "differences_deg",
    "lengths",
    "lying_at",
    "overlaps",
    "places_against",
    "straight_sides",
]

# Sides are equal, and lie along each other, within this, mm: what files round to.
SAME_MM = 1e-3
# Turns are allowed within this, degrees.
_SAME_DEG = 1e-6
# Sides shorter than this share of their outline are not laid against others.
_LEAST_SHARE = 0.05
# Places that differ by less are the same, in decimals of a mm.
DECIMALS = 4

Shapes = NDArray[np.object_]


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

    @cached_property
    def hull(self) -> FloatArray:
        """Corners of its convex hull, shape (h, 2)."""
        out: FloatArray = shapely.get_coordinates(self.outline.convex_hull)
        return out


@dataclass(frozen=True)
class Member:
    """A piece of a block: its point p at turn @ p + shift, shapes (2, 2) and (2,)."""

    piece: int
    turn: FloatArray
    shift: FloatArray


@dataclass(frozen=True)
class Places:
    """Where copies of one piece may be laid against a block: they touch it and overlap nothing.

    Attributes
    ----------
    turns, shifts : as of `Member`, shapes (p, 2, 2) and (p, 2).
    sides : of the piece there, shape (p, k, 2, 2); along : how far others run along them, (p,).
    shapes : its outline there, shape (p,).
    boxes : around it in each turn that the block may have, shape (p, t, 2, 2).
    """

    turns: FloatArray
    shifts: FloatArray
    sides: FloatArray
    along: FloatArray
    shapes: Shapes
    boxes: FloatArray

    def __len__(self) -> int:
        return len(self.turns)

    @property
    def corners(self) -> NDArray[np.complex128]:
        """Corners in the order of their coordinates: those of alike places are alike, (p, k)."""
        points = self.sides[:, :, 0] @ [1, 1j]
        return np.sort(points.round(DECIMALS), axis=1)

    def chosen(self, which: IntArray | BoolArray) -> Places:
        """Some of them."""
        return Places(
            self.turns[which],
            self.shifts[which],
            self.sides[which],
            self.along[which],
            self.shapes[which],
            self.boxes[which],
        )

    def beside(self, other: Places) -> Places:
        """These and others."""
        return Places(
            np.concatenate([self.turns, other.turns]),
            np.concatenate([self.shifts, other.shifts]),
            np.concatenate([self.sides, other.sides]),
            np.concatenate([self.along, other.along]),
            np.concatenate([self.shapes, other.shapes]),
            np.concatenate([self.boxes, other.boxes]),
        )


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
    length = lengths(sides)
    out: FloatArray = sides[length >= _LEAST_SHARE * length.sum()]
    return out


def places_against(
    piece: BlockPiece,
    free: FloatArray,
    kerf_mm: float,
    turns: FloatArray,
    turns_deg: FloatArray | None,
) -> Places:
    """A piece with each of its sides against free ones of its length, a kerf away.

    free : shape (k, 2, 2). turns : of the block on the bed, shape (t, 2, 2). turns_deg : by which
    pieces may be turned to each other, in degrees; None for any.
    """
    own = piece.sides
    alike = np.abs(lengths(free)[:, None] - lengths(own)) < SAME_MM
    target, side = np.nonzero(alike)
    angles = _turns_against(free[target], own[side], turns_deg)
    allowed = np.isfinite(angles)
    targets, sides, angles = free[target[allowed]], own[side[allowed]], angles[allowed]
    ahead = targets[:, 1] - targets[:, 0]
    outwards = np.column_stack([ahead[:, 1], -ahead[:, 0]]) / lengths(targets)[:, None]
    # middles of both sides, so that rounding of their lengths is shared
    middles = np.einsum("pij,pj->pi", _rotations(angles), sides.mean(axis=1))
    return lying_at(piece, angles, targets.mean(axis=1) + kerf_mm * outwards - middles, turns)


def lying_at(
    piece: BlockPiece, angles_deg: FloatArray, shifts: FloatArray, block_turns: FloatArray
) -> Places:
    """A piece in some places, shapes (p,) and (p, 2), with nothing along its sides.

    block_turns : of the block on the bed, shape (t, 2, 2).
    """
    turns = _rotations(angles_deg)
    corners = piece.sides.reshape(-1, 2) @ turns.swapaxes(1, 2) + shifts[:, None]
    hull = piece.hull @ turns.swapaxes(1, 2) + shifts[:, None]
    points = hull[:, None] @ block_turns.swapaxes(1, 2)
    shapes = np.empty(len(turns), object)
    for number, (turn, shift) in enumerate(zip(turns, shifts, strict=True)):
        shapes[number] = shapely.transform(
            piece.outline, lambda p, turn=turn, shift=shift: p @ turn.T + shift
        )
    return Places(
        turns,
        shifts,
        corners.reshape(len(turns), len(piece.sides), 2, 2),
        np.zeros(len(turns)),
        shapes,
        np.stack([points.min(axis=2), points.max(axis=2)], axis=2),
    )


def _turns_against(
    targets: FloatArray, sides: FloatArray, turns_deg: FloatArray | None
) -> FloatArray:
    """Turns that bring sides against others, NaN where that is not allowed, shape (p,)."""
    ahead, own = targets[:, 1] - targets[:, 0], sides[:, 1] - sides[:, 0]
    angles = np.arctan2(-ahead[:, 1], -ahead[:, 0]) - np.arctan2(own[:, 1], own[:, 0])
    turned = np.degrees(angles) % 360.0
    exact = np.arange(4) * 90.0 if turns_deg is None else turns_deg
    rest = (exact - turned[:, None] + 180.0) % 360.0 - 180.0
    nearest = np.abs(rest).argmin(axis=1)
    near = np.abs(rest[np.arange(len(rest)), nearest]) < _SAME_DEG
    return np.where(near, exact[nearest], turned if turns_deg is None else np.nan)


def differences_deg(rotations_deg: Sequence[float]) -> FloatArray:
    """Turns after which every allowed one is allowed again, in degrees."""
    allowed = np.array(rotations_deg, float)
    turns = allowed - allowed[0]
    after = (allowed[None] + turns[:, None]) % 360.0
    rest = (after[..., None] - allowed + 180.0) % 360.0 - 180.0
    kept = (np.abs(rest) < _SAME_DEG).any(axis=2).all(axis=1)
    out: FloatArray = turns[kept] % 360.0
    return out


def _rotations(angles_deg: FloatArray) -> FloatArray:
    """Matrices of rotations, exact for quarter turns, shape (p, 2, 2)."""
    known = {angle: rotation(angle) for angle in np.unique(angles_deg).tolist()}
    return np.array([known[angle] for angle in angles_deg.tolist()]).reshape(-1, 2, 2)


def overlaps(sides: FloatArray, others: FloatArray, kerf_mm: float) -> FloatArray:
    """How far each side runs along each other one, a kerf apart; shapes (m, 2, 2) to (m, k)."""
    start = sides[:, None, 0]
    ahead = sides[:, None, 1] - start
    length = np.hypot(ahead[..., 0], ahead[..., 1])
    unit = ahead / length[..., None]
    arms = others[None] - start[:, :, None]  # (m, k, 2, 2)
    across = unit[..., None, 0] * arms[..., 1] - unit[..., None, 1] * arms[..., 0]
    place = (unit[:, :, None] * arms).sum(axis=-1)
    facing = (np.abs(across + kerf_mm) < SAME_MM).all(axis=-1)
    facing &= place[..., 0] > place[..., 1]
    overlap = np.minimum(place[..., 0], length) - np.maximum(place[..., 1], 0.0)
    out: FloatArray = np.where(facing, np.maximum(overlap, 0.0), 0.0)
    return out


def lengths(sides: FloatArray) -> FloatArray:
    """Lengths of sides, shape (k, 2, 2) to (k,)."""
    out: FloatArray = np.hypot(*(sides[:, 1] - sides[:, 0]).T)
    return out
