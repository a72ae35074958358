"""How is a sheet scored on both sides, so that both drawings meet when it is turned over?"""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from fab.paths import CutPaths, Layer, Operation, joined
from solver.errors import InvalidValue, require_positive
from solver.vectors import FloatArray

__all__ = ["Axis", "two_sided"]

_HOLE_CORNERS = 48
# Marks of the turning axis lie across this share of the border, in its middle.
_MARK_SHARE = 0.5


class Axis(StrEnum):
    """The line in the middle of the sheet about which it is turned over."""

    X = "x"
    Y = "y"


def two_sided(
    paths: CutPaths, axis: Axis = Axis.X, hole_mm: float = 4.0, clearance_mm: float = 3.0
) -> tuple[CutPaths, CutPaths]:
    """Front and back drawing of a sheet, on the same rectangle with a border for registration.

    Parameters
    ----------
    axis : "x": turned over about the horizontal line through the sheet's middle, y mirrored;
        "y": about the vertical one, x mirrored.
    hole_mm : diameter of the registration holes, for pins.
    clearance_mm : from the holes to the sheet's paths and to the border's edge; the border is the
        hole and twice that wide.

    The front has everything but the valleys, the back the valleys, mirrored. The order of work:
    the front's engravings, mountains and relief holes; the back; and, turned again, the cuts of the
    front, which free the piece. The four registration holes lie on the front's relief layer, to be
    cut with it, and on the back as engraved rings, to be laid over them: nothing is cut twice. They
    are symmetrical about the turning axis, which is engraved in the border of both drawings, and
    about no other one: a sheet turned the wrong way does not fit its pins.

    Raises `InvalidValue` for an unknown axis, and for lengths that are not positive.
    """
    if axis not in list(Axis):
        raise InvalidValue("axis", repr(axis), f"be one of {', '.join(Axis)}", "See `Axis`.")
    require_positive("hole_mm", hole_mm)
    require_positive("clearance_mm", clearance_mm)
    border = hole_mm + 2 * clearance_mm
    size = np.array(paths.size_mm) + 2 * border
    holes = _holes(size, axis, border, hole_mm)
    marks = Layer(Operation.ENGRAVE, _marks(size, axis, border))
    turn, shift = np.eye(2), np.zeros(2)
    across = 1 if Axis(axis) is Axis.X else 0
    turn[across, across], shift[across] = -1.0, size[across]
    inside = [layer.moved(np.eye(2), np.full(2, border)) for layer in paths.layers]
    front = [layer for layer in inside if layer.operation is not Operation.VALLEY]
    valleys = [layer for layer in inside if layer.operation is Operation.VALLEY]
    back = [layer.moved(turn, shift) for layer in valleys]
    size_mm = (float(size[0]), float(size[1]))
    return (
        CutPaths(joined([*front, marks, Layer(Operation.RELIEF, outlines=holes)]), size_mm),
        CutPaths(joined([*back, marks, Layer(Operation.ENGRAVE, outlines=holes)]), size_mm),
    )


def _holes(size: FloatArray, axis: Axis, border: float, hole_mm: float) -> tuple[FloatArray, ...]:
    """Two holes near the corners at the axis' start, two nearer to the axis at its end.

    Each is drawn symmetrical about both directions, so that a ring and its mirror coincide.
    """
    along, across = size if Axis(axis) is Axis.X else size[::-1]
    near, far = border / 2, along - border / 2
    places = np.array(
        [[near, border / 2], [near, across - border / 2], [far, across / 4], [far, across * 3 / 4]]
    )
    angle = (np.arange(_HOLE_CORNERS) + 0.5) * (2 * np.pi / _HOLE_CORNERS)
    ring = hole_mm / 2 * np.column_stack([np.cos(angle), np.sin(angle)])[::-1]
    if Axis(axis) is Axis.Y:
        places = places[:, ::-1]
    return tuple(ring + place for place in places)


def _marks(size: FloatArray, axis: Axis, border: float) -> FloatArray:
    """The turning axis in the border at both of its ends, shape (2, 2, 2)."""
    along, across = size if Axis(axis) is Axis.X else size[::-1]
    begin, end = border * (1 - _MARK_SHARE) / 2, border * (1 + _MARK_SHARE) / 2
    marks = np.array(
        [
            [[begin, across / 2], [end, across / 2]],
            [[along - end, across / 2], [along - begin, across / 2]],
        ]
    )
    return marks if Axis(axis) is Axis.X else marks[..., ::-1]
