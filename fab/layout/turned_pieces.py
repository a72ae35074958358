"""Pieces that are to lie on a sheet: the turns that they may take, and their envelopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fab.geometry.boxes import smallest_box
from solver.errors import InvalidState, InvalidValue
from solver.vectors import BoolArray, FloatArray

__all__ = ["ROUNDING_MM", "Spot", "TurnedPiece", "lying", "rotation", "turned_piece"]

# Gaps and borders may fall short by the rounding of coordinates, in mm.
ROUNDING_MM = 1e-9
# Most corners of an envelope: no-fit polygons of concave outlines cost the square of their corners.
_MOST_CORNERS = 20
# A piece that fills this share of its convex hull is placed as its hull.
_NEARLY_CONVEX = 0.95
# Boxes turned by less, in degrees, are the same box.
_SAME_TURN_DEG = 1e-4


@dataclass(frozen=True)
class TurnedPiece:
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

    def turn_that_fits(self, free: FloatArray) -> int | None:
        """The first turn in which the piece's box fits a rectangle, shape (2,)."""
        fit = np.flatnonzero((self.sizes <= free + ROUNDING_MM).all(axis=1))
        return int(fit[0]) if len(fit) else None

    @property
    def filled_area(self) -> float:
        """Area of the piece and its holes, mm2."""
        return float(shapely.Polygon(self.outline.exterior).area)


@dataclass(frozen=True)
class Spot:
    """A piece, the rotation matrix that turns it, and its shift in mm."""

    piece: int
    turn: FloatArray
    shift: FloatArray


def turned_piece(
    number: int,
    outline: shapely.Polygon | FloatArray,
    room: FloatArray,
    rotations_deg: Sequence[float] | None,
) -> TurnedPiece:
    """A piece with the turns in which it may lie in a room, shape (2,), mm.

    number : of the piece, for messages. rotations_deg : that are allowed; None for any.

    Raises `InvalidState` for an outline that crosses itself or has no area, `InvalidValue` for a
    piece that fits the room in none of its turns.
    """
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
    turns = np.array([rotation(angle) for angle in turns_deg])
    turned = shapely.get_coordinates(polygon.exterior) @ turns.swapaxes(1, 2)
    boxes = np.stack([turned.min(axis=1), turned.max(axis=1)], axis=1)
    size = boxes[:, 1] - boxes[:, 0]
    area = size.prod(axis=1)
    fit = np.flatnonzero((size <= room + ROUNDING_MM).all(axis=1))
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
    return TurnedPiece(
        polygon, turns_deg[order], turns[order], size[order], box, _envelope(polygon)
    )


def rotation(angle_deg: float) -> FloatArray:
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


def lying(pieces: list[TurnedPiece], spots: list[Spot]) -> list[shapely.Polygon]:
    """The outlines of pieces where they lie."""
    return [
        shapely.transform(
            pieces[spot.piece].outline, lambda p, spot=spot: p @ spot.turn.T + spot.shift
        )
        for spot in spots
    ]
