"""Registration of both sides of a sheet, so that its drawings meet when it is turned over."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from fab.drawings.cut_paths import CutPaths, Layer, Operation, joined
from solver.errors import InvalidValue, require_finite, require_positive
from solver.vectors import FloatArray

__all__ = ["Axis", "Registration", "how_to_turn", "two_sided"]

_HOLE_CORNERS = 48
# Marks of the turning axis take this share of the border's width, in its middle.
_MARK_SHARE = 0.5
# Arms of the crosses, in diameters of the holes in whose middle they are.
_ARM = 0.25
# Sheets less wide or high, in borders, have no room for holes that show which side is up.
_LEAST_BORDERS = 4
# Paths may reach into the border by the rounding of coordinates, in mm.
_ROUNDING_MM = 1e-5
# What the back works on: it comes last, so it frees the pieces.
_BACK = (Operation.VALLEY, Operation.HOLE, Operation.CUT)


class Axis(StrEnum):
    """The line in the middle of the sheet about which it is turned over."""

    X = "x"
    Y = "y"


@dataclass(frozen=True)
class Registration:
    """How the two sides of a sheet find each other.

    Attributes
    ----------
    axis : "x": turned over about the horizontal line through the sheet's middle, y mirrored;
        "y": about the vertical one, x mirrored; where left out, about the longer one.
    hole_mm : diameter of the registration holes, for pins.
    clearance_mm : from the holes to the sheet's paths and to the border's edge.

    Raises `InvalidValue` for an unknown axis, and for lengths that are not positive.
    """

    axis: Axis | None = None
    hole_mm: float = 4.0
    clearance_mm: float = 3.0

    def __post_init__(self) -> None:
        if self.axis is not None and self.axis not in list(Axis):
            known = ", ".join(Axis)
            raise InvalidValue("axis", repr(self.axis), f"be one of {known}", "See `Axis`.")
        require_positive("hole_mm", self.hole_mm)
        require_positive("clearance_mm", self.clearance_mm)

    @property
    def border_mm(self) -> float:
        """Width of the strip that holes and marks take on all four sides of the sheet."""
        return self.hole_mm + 2 * self.clearance_mm

    def axis_of(self, size_mm: tuple[float, float]) -> Axis:
        """The axis about which a sheet of this size is turned."""
        if self.axis is not None:
            return Axis(self.axis)
        return Axis.X if size_mm[0] >= size_mm[1] else Axis.Y


def two_sided(
    paths: CutPaths, registration: Registration, margin_mm: float = 0.0, kerf_mm: float = 0.0
) -> tuple[CutPaths, CutPaths]:
    """Front and back drawing of a sheet, each as the sheet is placed on the machine.

    Parameters
    ----------
    paths : of a sheet as large as the stock, with nothing in its border: the strip of width
        `registration.border_mm` at a distance of `margin_mm` from the edges.
    kerf_mm : width of the beam; the registration holes are drawn smaller by it.

    Each crease is scored on the side on which it opens: mountains on the front, valleys on the
    back. The sheet is turned once. The front has engravings, mountains, relief holes and four
    registration holes; the back, mirrored, has the valleys and after them everything that is cut
    out. The last work of all frees the pieces: until then the sheet is whole, and its holes hold
    it. No line is in both drawings.

    The holes are symmetrical about the turning axis, and about no other axis: a sheet that is
    turned over wrongly does not fit its pins. The back has a small cross, engraved, in the middle
    of each, to place the sheet by. The axis is engraved in the border of the front.

    Raises `InvalidValue` for a negative margin, a kerf as wide as the holes, and for paths that
    reach into the border.
    """
    require_finite("margin_mm", margin_mm)
    if margin_mm < 0:
        raise InvalidValue("margin_mm", margin_mm, "be 0 or greater", "Give the free margin.")
    if not 0 <= kerf_mm < registration.hole_mm:
        bound = f"be from 0 to less than hole_mm = {registration.hole_mm:g}"
        raise InvalidValue("kerf_mm", kerf_mm, bound, "Take larger holes, or a finer beam.")
    _require_free(paths, margin_mm + registration.border_mm)
    size, axis = np.array(paths.size_mm), registration.axis_of(paths.size_mm)
    middles = _middles(size, axis, margin_mm + registration.border_mm / 2)
    holes = Layer(Operation.RELIEF, outlines=_holes(middles, registration.hole_mm - kerf_mm))
    crosses = Layer(Operation.ENGRAVE, _crosses(middles, _ARM * registration.hole_mm))
    marks = Layer(Operation.ENGRAVE, _marks(size, axis, margin_mm, registration.border_mm))
    turn, shift = np.eye(2), np.zeros(2)
    across = 1 if axis is Axis.X else 0
    turn[across, across], shift[across] = -1.0, size[across]
    front = [layer for layer in paths.layers if layer.operation not in _BACK]
    back = [layer.moved(turn, shift) for layer in paths.layers if layer.operation in _BACK]
    return (
        replace(paths, layers=joined([*front, marks, holes])),
        replace(paths, layers=joined([*back, crosses])),
    )


def how_to_turn(name: str, registration: Registration, size_mm: tuple[float, float]) -> str:
    """Instructions for the user of the drawings `name`_front and `name`_back of a sheet."""
    edges = {Axis.X: "upper edge becomes the lower", Axis.Y: "left edge becomes the right"}
    return (
        f"Take a sheet of {size_mm[0]:g} x {size_mm[1]:g} mm, as large as the drawing. Cut "
        f"{name}_front whole: it makes what is scored from this side, and four registration holes. "
        f"Turn the sheet over so that its {edges[registration.axis_of(size_mm)]} one, about the "
        "line engraved in its border; the holes come to lie where they were. Cut "
        f"{name}_back whole: its crosses lie in the middle of the holes, and it frees the pieces "
        "last."
    )


def _require_free(paths: CutPaths, border_mm: float) -> None:
    """Raise `InvalidValue` where little is left within the sheet's border, or lines are in it."""
    least = _LEAST_BORDERS * border_mm
    if min(paths.size_mm) < least:
        raise InvalidValue(
            "sheet",
            f"{paths.size_mm[0]:g} x {paths.size_mm[1]:g} mm",
            f"be at least {least:g} mm wide and high",
            "Its border holds the registration holes: take a larger sheet or smaller holes.",
        )
    points = [layer.segments.reshape(-1, 2) for layer in paths.layers]
    points += [line for layer in paths.layers for line in (*layer.outlines, *layer.chains)]
    every = np.concatenate([np.empty((0, 2)), *points])
    low, high = every - border_mm, np.array(paths.size_mm) - border_mm - every
    free = float(min(low.min(initial=np.inf), high.min(initial=np.inf))) + border_mm
    if free < border_mm - _ROUNDING_MM:
        raise InvalidValue(
            "distance of the paths from the sheet's edges",
            f"{free:.6g} mm",
            f"be at least {border_mm:g} mm",
            "Leave the border to the registration holes: place the paths on a larger sheet.",
        )


def _middles(size: FloatArray, axis: Axis, inset: float) -> FloatArray:
    """Two near the corners at the axis' start, two nearer to the axis at its end, shape (4, 2)."""
    along, across = size if axis is Axis.X else size[::-1]
    far, quarter = along - inset, across / 4 + inset / 2
    places = np.array(
        [[inset, inset], [inset, across - inset], [far, quarter], [far, across - quarter]]
    )
    return places if axis is Axis.X else places[:, ::-1]


def _holes(middles: FloatArray, hole_mm: float) -> tuple[FloatArray, ...]:
    """Polygons that are symmetrical about x and y, so that a hole and its mirror image coincide."""
    angle = (np.arange(_HOLE_CORNERS) + 0.5) * (2 * np.pi / _HOLE_CORNERS)
    ring = hole_mm / 2 * np.column_stack([np.cos(angle), np.sin(angle)])[::-1]
    return tuple(ring + middle for middle in middles)


def _crosses(middles: FloatArray, arm_mm: float) -> FloatArray:
    """Two lines through each middle, shape (8, 2, 2)."""
    arms = arm_mm * np.array([[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 1.0]]])
    out: FloatArray = (middles[:, None, None] + arms).reshape(-1, 2, 2)
    return out


def _marks(size: FloatArray, axis: Axis, margin: float, border: float) -> FloatArray:
    """The turning axis in the border at both of its ends, shape (2, 2, 2)."""
    along, across = size if axis is Axis.X else size[::-1]
    begin = margin + border * (1 - _MARK_SHARE) / 2
    end = margin + border * (1 + _MARK_SHARE) / 2
    marks = np.array(
        [
            [[begin, across / 2], [end, across / 2]],
            [[along - end, across / 2], [along - begin, across / 2]],
        ]
    )
    return marks if axis is Axis.X else marks[..., ::-1]
