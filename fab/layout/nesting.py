"""Nesting: where each piece lies, and on which sheet of the bed's size.

Pieces are turned and shifted, never mirrored. U-Nesting places them by no-fit polygons, in batches,
since its cost grows with the square of all corners. Its answers are checked; where one is wrong,
boxes side by side, or one piece alone, take its place. What is left may lie in the gaps between
and in the holes of the pieces (`fab.layout.gap_filling`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from fab.geometry.boxes import smallest_box
from fab.layout.gap_filling import Gaps
from fab.progress import Steps, no_steps
from solver.errors import (
    InvalidState,
    InvalidValue,
    require_count,
    require_number,
    require_positive,
)
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Placement", "Placements", "nest"]

# Gaps and borders may fall short by the rounding of coordinates, in mm.
_ROUNDING_MM = 1e-9
# Most corners of an envelope: no-fit polygons of concave outlines cost the square of their corners.
_MOST_CORNERS = 20
# A piece that fills this share of its convex hull is placed as its hull.
_NEARLY_CONVEX = 0.95
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
# Boxes turned by less, in degrees, are the same box.
_SAME_TURN_DEG = 1e-4


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
    used : share of the bed that pieces cover on each sheet, shape (number of sheets,), falling,
        read-only.
    """

    items: tuple[Placement, ...]
    used: FloatArray

    def __post_init__(self) -> None:
        self.used.flags.writeable = False


@dataclass(frozen=True)
class _Piece:
    """A piece with the turns it may take, and the shape that is placed in its stead.

    Attributes
    ----------
    turns_deg, turns : angles and their matrices, shapes (k,) and (k, 2, 2): four that are a quarter
        turn apart, or those that are allowed. In the first the piece's box fits the room.
    sizes : of the piece's box in each turn, shape (k, 2). box : that in the first turn.
    envelope : a polygon of few corners, without holes, around the piece.
    """

    outline: shapely.Polygon
    turns_deg: FloatArray
    turns: FloatArray
    sizes: FloatArray
    box: shapely.Polygon
    envelope: shapely.Polygon

    @property
    def quarter_turns(self) -> BoolArray:
        """Which turns are whole quarters of a turn from the first, shape (k,)."""
        rest = (self.turns_deg - self.turns_deg[0] + 45.0) % 90.0 - 45.0
        return np.asarray(np.abs(rest) < _SAME_TURN_DEG)

    @property
    def filled_area(self) -> float:
        """Area of the piece and its holes, mm2."""
        return float(shapely.Polygon(self.outline.exterior).area)


@dataclass(frozen=True)
class _Spot:
    """A piece, the rotation matrix that turns it, and its shift in mm."""

    piece: int
    turn: FloatArray
    shift: FloatArray


def nest(
    outlines: Sequence[shapely.Polygon | FloatArray],
    bed_mm: tuple[float, float],
    gap_mm: float,
    copies: int | Sequence[int] = 1,
    margin_mm: float = 0.0,
    progress: Steps = no_steps,
    *,
    rotations_deg: Sequence[float] | None = None,
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
        _piece(number, outline, room, rotations_deg) for number, outline in enumerate(outlines)
    ]
    filling = _Filling(pieces, room, gap_mm)
    left = np.array(counts, np.int64)
    total = int(left.sum())
    filled: list[list[_Spot]] = []
    while left.any():
        spots = filling.sheet(left, lambda unplaced: progress(total - unplaced, total))
        left = left - filling.counts(spots)
        filled.append(spots)
    used = np.array([filling.net_area[[spot.piece for spot in spots]].sum() for spots in filled])
    by_use = np.argsort(-used, kind="stable")
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


def _piece(
    number: int,
    outline: shapely.Polygon | FloatArray,
    room: FloatArray,
    rotations_deg: Sequence[float] | None,
) -> _Piece:
    polygon = shapely.Polygon(outline)
    if not (polygon.is_valid and polygon.area > 0):
        why = "no area" if polygon.is_valid else shapely.is_valid_reason(polygon)
        raise InvalidState(
            "outlines",
            f"outline {number} has no area, or crosses itself: {why}",
            "Split the piece where it overlaps itself.",
        )
    if rotations_deg is None:
        groups = np.array([0.0, *_box_turns_deg(polygon)])[:, None] + np.arange(4) * 90.0
    else:
        groups = np.array([rotations_deg], float)
    turns_deg, each = groups.ravel(), groups.shape[1]
    turns = np.array([_rotation(angle) for angle in turns_deg])
    turned = shapely.get_coordinates(polygon.exterior) @ turns.swapaxes(1, 2)
    boxes = np.stack([turned.min(axis=1), turned.max(axis=1)], axis=1)
    size = boxes[:, 1] - boxes[:, 0]
    area = size.prod(axis=1)
    fit = np.flatnonzero((size <= room + _ROUNDING_MM).all(axis=1))
    if not len(fit):
        width, height = size[np.argmin(area)]
        as_turned = "as it lies or turned" if rotations_deg is None else "as it may be turned"
        raise InvalidValue(
            f"size of piece {number}",
            f"{width:.6g} x {height:.6g} mm",
            f"fit between the bed's margins, {room[0]:.6g} x {room[1]:.6g} mm, {as_turned}",
            "Split it into pieces, scale it down, lower the margin or use a larger bed.",
        )
    first = int(fit[area[fit] <= area[fit].min() * (1 + 1e-9)][0])
    order = first // each * each + (first + np.arange(each)) % each
    low, high = boxes[first]
    box = shapely.box(*low, *high)
    return _Piece(polygon, turns_deg[order], turns[order], size[order], box, _envelope(polygon))


def _rotation(angle_deg: float) -> FloatArray:
    """The matrix of a rotation; exact where it is a multiple of 90 degrees."""
    whole, rest = divmod(angle_deg, 90.0)
    c, s = np.cos(np.radians(rest)), np.sin(np.radians(rest))
    quarter = np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), int(whole) % 4)
    out: FloatArray = quarter @ np.array([[c, -s], [s, c]])
    return out


def _box_turns_deg(polygon: shapely.Polygon) -> list[float]:
    """The turn to the box of least area, in (0, 90) degrees; none where that is upright already."""
    corner = smallest_box(polygon)
    side = corner[1] - corner[0]
    turn = float(-np.degrees(np.arctan2(side[1], side[0])) % 90.0)
    return [turn] if _SAME_TURN_DEG < turn < 90 - _SAME_TURN_DEG else []


def _envelope(polygon: shapely.Polygon) -> shapely.Polygon:
    """A polygon without holes and with few corners that contains the piece."""
    filled = shapely.Polygon(polygon.exterior)
    hull = filled.convex_hull
    shape = hull if filled.area >= _NEARLY_CONVEX * hull.area else filled
    tolerance = 1e-3 * float(np.hypot(*np.ptp(shapely.get_coordinates(filled), axis=0)))
    around = shape
    while len(around.exterior.coords) > _MOST_CORNERS + 1:
        try:
            coarse = shape.simplify(tolerance).buffer(tolerance, join_style="mitre")
        except shapely.GEOSException:  # the mitres of needles overflow
            return hull
        if not isinstance(coarse, shapely.Polygon):  # a thin piece, torn by rounding
            return hull
        around = shapely.Polygon(coarse.exterior).simplify(0.0)
        tolerance *= 1.2
    return around if around.contains(filled) or around is shape else hull


class _Filling:
    """Filling of one sheet after another; what was found once is not searched for again.

    Attributes
    ----------
    order : pieces, the largest first. area : of each piece with its holes, mm2; net_area :
        without them.
    found : what was placed, by how many of each piece were offered, and to which rectangle or
        between which pieces: sheets repeat.
    """

    def __init__(self, pieces: list[_Piece], room: FloatArray, gap_mm: float) -> None:
        self.pieces = pieces
        self.room = room
        self.gap_mm = gap_mm
        self.area = np.array([piece.filled_area for piece in pieces])
        self.net_area = np.array([piece.outline.area for piece in pieces])
        self.order = np.argsort(-self.area, kind="stable")
        self.found: dict[tuple[bytes, bytes], list[_Spot]] = {}

    def sheet(self, left: IntArray, report: Callable[[int], None]) -> list[_Spot]:
        """What lies on the next sheet, of those copies of each piece that are left.

        Each batch lies in the larger of the two rectangles that the one before left free, beside it
        or above. The first that is not placed whole is the last. Then the gaps are filled.

        report : called after each batch with the number of copies that are then left.
        """
        spots: list[_Spot] = []
        corner, free = np.zeros(2), self.room
        while (offered := _offer(self.pieces, self.order, left, free)).any():
            batch = self._batch(offered, free)
            spots += [replace(spot, shift=spot.shift + corner) for spot in batch]
            left = left - self.counts(batch)
            report(int(left.sum()))
            if len(batch) < offered.sum():
                break
            taken = shapely.total_bounds(np.array(_lying(self.pieces, batch)))[2:] + self.gap_mm
            rest = np.maximum(free - taken, 0.0)
            axis = int(rest[1] * free[0] > rest[0] * free[1])
            corner, free = corner.copy(), free.copy()
            corner[axis] += taken[axis]
            free[axis] = rest[axis]
        if left.any():
            more = self._in_gaps(left, spots)
            spots += more
            if more:
                report(int(left.sum()) - len(more))
        return spots

    def _batch(self, offered: IntArray, free: FloatArray) -> list[_Spot]:
        key = offered.tobytes(), free.tobytes()
        if key not in self.found:
            self.found[key] = _fill(self.pieces, offered, free, self.gap_mm)
        return self.found[key]

    def _in_gaps(self, left: IntArray, spots: list[_Spot]) -> list[_Spot]:
        free_area = self.room.prod() - self.net_area[[spot.piece for spot in spots]].sum()
        offered = np.minimum(left, (free_area / self.net_area).astype(int))
        lying = np.array([[spot.piece, *spot.turn.ravel(), *spot.shift] for spot in spots])
        key = offered.tobytes(), lying.tobytes()
        if key not in self.found:
            self.found[key] = _between(
                self.pieces, self.order, offered, self.room, self.gap_mm, spots
            )
        return self.found[key]

    def counts(self, spots: list[_Spot]) -> IntArray:
        """Number of copies of each piece."""
        return np.bincount([spot.piece for spot in spots], minlength=len(self.pieces))


def _between(
    pieces: list[_Piece],
    order: IntArray,
    left: IntArray,
    room: FloatArray,
    gap_mm: float,
    spots: list[_Spot],
) -> list[_Spot]:
    """Pieces placed in the gaps of a sheet, of those that are left, the largest first.

    Where many are left, a sample of all sizes is tried.
    """
    gaps = Gaps(_lying(pieces, spots), room, gap_mm)
    more = []
    tried = order[left[order] > 0]
    for number in tried[:: 1 + len(tried) // _TRIED].tolist():
        turns = pieces[number].turns
        turned = _lying(pieces, [_Spot(number, turn, np.zeros(2)) for turn in turns])
        for _ in range(left[number]):
            found = gaps.place(turned)
            if found is None:
                break
            turn, shift = found
            more.append(_Spot(number, turns[turn], shift))
    return more


def _offer(pieces: list[_Piece], order: IntArray, left: IntArray, free: FloatArray) -> IntArray:
    """How many of each piece to offer to a rectangle: the largest that are left and fit it."""
    open_area, open_corners = _OFFERED * float(free.prod()), _BATCH_CORNERS
    offered = np.zeros_like(left)
    for number in order[left[order] > 0].tolist():
        piece = pieces[number]
        if open_area <= 0:
            break
        if _turn_that_fits(piece, free) is None:
            continue
        corners = len(piece.envelope.exterior.coords) - 1
        if offered.any() and corners > open_corners:
            break
        most = min(int(np.ceil(open_area / piece.envelope.area)), max(open_corners // corners, 1))
        offered[number] = min(left[number], most)
        open_area -= offered[number] * piece.envelope.area
        open_corners -= offered[number] * corners
    return offered


def _turn_that_fits(piece: _Piece, free: FloatArray) -> int | None:
    """The first turn in which a piece's box fits a rectangle."""
    fit = np.flatnonzero((piece.sizes <= free + _ROUNDING_MM).all(axis=1))
    return int(fit[0]) if len(fit) else None


def _fill(pieces: list[_Piece], offered: IntArray, room: FloatArray, gap_mm: float) -> list[_Spot]:
    """One batch: the valid answer that covers most, at least the largest piece alone.

    Outlines side by side ("nfp"), boxes side by side ("blf"), and, where not all are placed by
    these and they are few, a search over orders and turns of the outlines ("alns").
    """

    def covered(spots: list[_Spot]) -> float:
        return float(sum(pieces[spot.piece].filled_area for spot in spots))

    numbers = np.flatnonzero(offered).tolist()
    largest = max(numbers, key=lambda n: pieces[n].filled_area)
    turn = _turn_that_fits(pieces[largest], room) or 0
    best = [_Spot(largest, pieces[largest].turns[turn], np.zeros(2))]
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
            _Spot(n, pieces[n].turns[allowed[n]][turn], shift)
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


def _lying(pieces: list[_Piece], spots: list[_Spot]) -> list[shapely.Polygon]:
    """The outlines of pieces where they lie."""
    return [
        shapely.transform(
            pieces[spot.piece].outline, lambda p, spot=spot: p @ spot.turn.T + spot.shift
        )
        for spot in spots
    ]


def _holds(pieces: list[_Piece], spots: list[_Spot], room: FloatArray, gap_mm: float) -> bool:
    """Whether all gaps are kept and everything together fits the room, wherever it lies."""
    lying = _lying(pieces, spots)
    bounds = shapely.total_bounds(np.array(lying))
    if (bounds[2:] - bounds[:2] > room + _ROUNDING_MM).any():
        return False
    near = shapely.STRtree(lying).query(
        lying, predicate="dwithin", distance=gap_mm - min(_ROUNDING_MM, gap_mm / 2)
    )
    return bool((near[0] == near[1]).all())


def _to_corner(pieces: list[_Piece], spots: list[_Spot]) -> list[_Spot]:
    """All moved together until they touch the lower and the left border of the room."""
    low = shapely.total_bounds(np.array(_lying(pieces, spots)))[:2]
    return [_Spot(spot.piece, spot.turn, spot.shift - low) for spot in spots]
