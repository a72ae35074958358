"""Filling of beds with pieces, one sheet after another.

U-Nesting places pieces by no-fit polygons, in batches, since its cost grows with the square of all
corners. Its answers are checked; where one is wrong, boxes side by side, or one piece alone, take
its place. What is left may lie in the gaps between and in the holes of the pieces
(`fab.layout.gap_filling`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import shapely

from fab.layout.gap_filling import Gaps
from fab.layout.turned_pieces import ROUNDING_MM, Spot, TurnedPiece, lying
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Filling"]

# Area offered to a sheet at once, in areas of the sheet: more fills its gaps, and takes longer.
_OFFERED = 1.1
# Corners of a batch: it takes a second or two. More corners use the bed better, by 3 % from 320 to
# 640 in the benchmark.
_BATCH_CORNERS = 480
# A batch of up to this many pieces is worth a search, of this many rounds.
_SEARCHED = 16
_ITERATIONS = 10
# About this many pieces are tried in the gaps of a sheet; each takes some 30 ms.
_TRIED = 100


@dataclass
class _Free:
    """The rectangle of a sheet that batches may still take: its lower left corner and its size.

    full : whether a batch did not fit it as a whole.
    """

    corner: FloatArray
    size: FloatArray
    full: bool = False

    def take(self, taken: FloatArray) -> None:
        """Keep the larger of two rectangles, beside what is taken or above it, shape (2,)."""
        rest = np.maximum(self.size - taken, 0.0)
        axis = int(rest[1] * self.size[0] > rest[0] * self.size[1])
        self.corner, self.size = self.corner.copy(), self.size.copy()
        self.corner[axis] += taken[axis]
        self.size[axis] = rest[axis]


class Filling:
    """Filling of one sheet after another; what was found once is not searched for again.

    Attributes
    ----------
    order : pieces, the largest first. area : of each piece with its holes, mm2; net_area :
        without them.
    found : what was placed, by how many of each piece were offered, and to which rectangle or
        between which pieces: sheets repeat.
    """

    def __init__(self, pieces: list[TurnedPiece], room: FloatArray, gap_mm: float) -> None:
        self.pieces = pieces
        self.room = room
        self.gap_mm = gap_mm
        self.area = np.array([piece.filled_area for piece in pieces])
        self.net_area = np.array([piece.outline.area for piece in pieces])
        self.order = np.argsort(-self.area, kind="stable")
        self.found: dict[tuple[bytes, bytes], list[Spot]] = {}

    def sheet(self, left: IntArray, first: BoolArray, report: Callable[[int], None]) -> list[Spot]:
        """What lies on the next sheet, of those copies of each piece that are left.

        Each batch lies in the larger of the two rectangles that the one before left free, beside it
        or above. The first that is not placed whole is the last. Then the gaps are filled.

        first : pieces that are all placed before any others, which take the room that is left,
        shape (n,). report : called after each batch with the number of copies that are then left.
        """
        free = _Free(np.zeros(2), self.room)
        spots: list[Spot] = []
        for which in (first, ~first) if first.any() else (~first,):
            now = np.where(which, left, 0)
            waiting = int((left - now).sum())

            def told(unplaced: int, waiting: int = waiting) -> None:
                report(unplaced + waiting)

            placed = self._placed(now, free, spots, told)
            spots += placed
            left = left - self.counts(placed)
        return spots

    def _placed(
        self, left: IntArray, free: _Free, spots: list[Spot], report: Callable[[int], None]
    ) -> list[Spot]:
        """What is placed besides `spots`, by batches in the free rectangle and in gaps."""
        new: list[Spot] = []
        while not free.full and (offered := _offer(self.pieces, self.order, left, free.size)).any():
            batch = self._batch(offered, free.size)
            new += [replace(spot, shift=spot.shift + free.corner) for spot in batch]
            left = left - self.counts(batch)
            report(int(left.sum()))
            if len(batch) < offered.sum():
                free.full = True
                break
            taken = shapely.total_bounds(np.array(lying(self.pieces, batch)))[2:] + self.gap_mm
            free.take(taken)
        if left.any():
            more = self._in_gaps(left, [*spots, *new])
            new += more
            if more:
                free.full = True  # they may lie in it
                report(int(left.sum()) - len(more))
        return new

    def _batch(self, offered: IntArray, free: FloatArray) -> list[Spot]:
        key = offered.tobytes(), free.tobytes()
        if key not in self.found:
            self.found[key] = _fill(self.pieces, offered, free, self.gap_mm)
        return self.found[key]

    def _in_gaps(self, left: IntArray, spots: list[Spot]) -> list[Spot]:
        """What is placed in the gaps between spots."""
        free_area = self.room.prod() - self.net_area[[spot.piece for spot in spots]].sum()
        offered = np.minimum(left, (free_area / self.net_area).astype(int))
        lying = np.array([[spot.piece, *spot.turn.ravel(), *spot.shift] for spot in spots])
        key = offered.tobytes(), lying.tobytes()
        if key not in self.found:
            self.found[key] = _between(
                self.pieces, self.order, offered, self.room, self.gap_mm, spots
            )
        return self.found[key]

    def counts(self, spots: list[Spot]) -> IntArray:
        """Number of copies of each piece."""
        return np.bincount([spot.piece for spot in spots], minlength=len(self.pieces))


def _between(
    pieces: list[TurnedPiece],
    order: IntArray,
    left: IntArray,
    room: FloatArray,
    gap_mm: float,
    spots: list[Spot],
) -> list[Spot]:
    """Pieces placed in the gaps of a sheet, of those that are left, the largest first.

    Where many are left, a sample of all sizes is tried.
    """
    gaps = Gaps(lying(pieces, spots), room, gap_mm)
    more = []
    tried = order[left[order] > 0]
    for number in tried[:: 1 + len(tried) // _TRIED].tolist():
        turns = pieces[number].turns
        turned = lying(pieces, [Spot(number, turn, np.zeros(2)) for turn in turns])
        for _ in range(left[number]):
            found = gaps.place(turned)
            if found is None:
                break
            turn, shift = found
            more.append(Spot(number, turns[turn], shift))
    return more


def _offer(
    pieces: list[TurnedPiece], order: IntArray, left: IntArray, free: FloatArray
) -> IntArray:
    """How many of each piece to offer to a rectangle: the largest that are left and fit it."""
    open_area, open_corners = _OFFERED * float(free.prod()), _BATCH_CORNERS
    offered = np.zeros_like(left)
    for number in order[left[order] > 0].tolist():
        piece = pieces[number]
        if open_area <= 0:
            break
        if piece.turn_that_fits(free) is None:
            continue
        corners = len(piece.envelope.exterior.coords) - 1
        if offered.any() and corners > open_corners:
            break
        most = min(int(np.ceil(open_area / piece.envelope.area)), max(open_corners // corners, 1))
        offered[number] = min(left[number], most)
        open_area -= offered[number] * piece.envelope.area
        open_corners -= offered[number] * corners
    return offered


def _fill(
    pieces: list[TurnedPiece], offered: IntArray, room: FloatArray, gap_mm: float
) -> list[Spot]:
    """One batch: the valid answer that covers most, at least the largest piece alone.

    Outlines side by side ("nfp"), boxes side by side ("blf"), and, where not all are placed by
    these and they are few, a search over orders and turns of the outlines ("alns").
    """

    def covered(spots: list[Spot]) -> float:
        return float(sum(pieces[spot.piece].filled_area for spot in spots))

    numbers = np.flatnonzero(offered).tolist()
    largest = max(numbers, key=lambda n: pieces[n].filled_area)
    turn = pieces[largest].turn_that_fits(room) or 0
    best = [Spot(largest, pieces[largest].turns[turn], np.zeros(2))]
    for strategy in ("nfp", "blf", "alns"):
        if len(best) == offered.sum() or (strategy == "alns" and offered.sum() > _SEARCHED):
            break
        boxes = strategy == "blf"
        # a box stands for its piece in quarter turns from the first alone
        allowed = {n: pieces[n].quarter_turns if boxes else slice(None) for n in numbers}
        wanted = [
            (
                n,
                piece.box if boxes else piece.envelope,
                piece.turns_deg[allowed[n]] - boxes * piece.turns_deg[0],
            )
            for n, piece in ((n, pieces[n]) for n in numbers)
        ]
        spots = [
            Spot(n, pieces[n].turns[allowed[n]][turn], shift)
            for n, turn, shift in _solve(wanted, offered, strategy, room, gap_mm)
        ]
        if covered(spots) > covered(best) and _holds(pieces, spots, room, gap_mm):
            best = spots
    return _to_corner(pieces, best)


def _solve(
    wanted: list[tuple[int, shapely.Polygon, FloatArray]],
    offered: IntArray,
    strategy: str,
    room: FloatArray,
    gap_mm: float,
) -> list[tuple[int, int, FloatArray]]:
    """Piece, number of its turn and shift of all that fits on one sheet; empty where refused.

    wanted : piece, its shape and the angles that it may take, in degrees.
    """
    import u_nesting

    settings = {"strategy": strategy, "spacing": float(gap_mm), "time_limit_ms": 0}
    if strategy == "alns":
        settings |= {"seed": 1, "max_iterations": _ITERATIONS}
    result = u_nesting.solve_2d(
        [
            {
                "id": str(number),
                "polygon": shapely.get_coordinates(shape.exterior)[:-1].tolist(),
                "rotations": turns_deg.tolist(),
                "quantity": int(offered[number]),
            }
            for number, shape, turns_deg in wanted
        ],
        {"width": float(room[0]), "height": float(room[1])},
        settings,
    )
    angles = {number: turns_deg for number, _, turns_deg in wanted}
    found = []
    for placed in result["placements"]:
        number = int(placed["geometry_id"])
        turn = _nearest_turn(np.degrees(placed["rotation"][0]), angles[number])
        found.append((number, turn, np.array(placed["position"])))
    return found


def _nearest_turn(angle_deg: float, turns_deg: FloatArray) -> int:
    """The turn nearest to an angle, which comes back in single precision."""
    return int(np.argmin(np.abs((turns_deg - angle_deg + 180.0) % 360.0 - 180.0)))


def _holds(pieces: list[TurnedPiece], spots: list[Spot], room: FloatArray, gap_mm: float) -> bool:
    """Whether all gaps are kept and everything together fits the room, wherever it lies."""
    placed = lying(pieces, spots)
    bounds = shapely.total_bounds(np.array(placed))
    if (bounds[2:] - bounds[:2] > room + ROUNDING_MM).any():
        return False
    near = shapely.STRtree(placed).query(
        placed, predicate="dwithin", distance=gap_mm - min(ROUNDING_MM, gap_mm / 2)
    )
    return bool((near[0] == near[1]).all())


def _to_corner(pieces: list[TurnedPiece], spots: list[Spot]) -> list[Spot]:
    """All moved together until they touch the lower and the left border of the room."""
    low = shapely.total_bounds(np.array(lying(pieces, spots)))[:2]
    return [Spot(spot.piece, spot.turn, spot.shift - low) for spot in spots]
