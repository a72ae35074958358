"""Where a print lies on the bed of its printer: in the middle, turned only where it has to be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.vectors import FloatArray

__all__ = ["UNMOVED", "BedPlace", "fitting_box", "place_on_bed"]

_TOLERANCE_MM = 1e-6
_DEGREES = 180


@dataclass(frozen=True)
class BedPlace:
    """A turn about z, counterclockwise in degrees, and a shift in mm after it."""

    turn_deg: float = 0.0
    shift_mm: tuple[float, float] = (0.0, 0.0)

    def moved(self, points: FloatArray) -> FloatArray:
        """Points of the plane, shape (n, 2), where they lie on the bed."""
        turn = np.radians(self.turn_deg)
        cosine, sine = np.cos(turn), np.sin(turn)
        return np.asarray(points @ np.array([[cosine, sine], [-sine, cosine]]) + self.shift_mm)


UNMOVED = BedPlace()


def fitting_box(points: FloatArray, room_mm: tuple[float, float]) -> tuple[int, FloatArray, float]:
    """The box around points, at any whole degree, that fits a room best, or misses it least.

    points : shape (n, 2). Returns the direction of its longer side in degrees, its shorter and its
    longer side, and by how much it is larger than the room, 0 or less where it fits.

    >>> square = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])
    >>> direction, sides, over = fitting_box(square, (2.0, 4.0))
    >>> direction, sides.round(9).tolist(), round(over, 9)
    (0, [1.0, 3.0], -1.0)
    """
    # every degree, and the directions of the sides of the box of least area come near to them
    turn = np.radians(np.arange(_DEGREES))
    spans = np.ptp(points @ np.stack([np.cos(turn), np.sin(turn)]), axis=0)
    half = _DEGREES // 2
    boxes = np.sort(np.stack([spans[:half], spans[half:]]), axis=0)
    over = (boxes - np.sort(room_mm)[:, None]).max(axis=0)
    best = int(over.argmin())
    longer = best if spans[best] >= spans[best + half] else best + half
    return longer, boxes[:, best], float(over[best])


def place_on_bed(
    points: FloatArray, bed_mm: tuple[float, float], room_mm: tuple[float, float]
) -> BedPlace:
    """The place of a print in the middle of a bed, with equal room for a brim on opposite sides.

    points : shape (n, 2), of the print. It keeps its direction where it fits the room so, within
    the margins of the bed, and is turned as little as helps where not. What is larger than the
    room lies in the middle all the same.
    """
    turn = 0.0
    if (np.ptp(points, axis=0) > np.array(room_mm) + _TOLERANCE_MM).any():
        longer, _, over = fitting_box(points, room_mm)
        if over <= _TOLERANCE_MM:
            turn = -float(longer) if room_mm[0] >= room_mm[1] else 90.0 - longer
            turn = (turn + 90.0) % 180.0 - 90.0
    turned = BedPlace(turn).moved(points)
    middle = (turned.min(axis=0) + turned.max(axis=0)) / 2
    x, y = (np.array(bed_mm) / 2 - middle).tolist()
    return BedPlace(turn, (x, y))
