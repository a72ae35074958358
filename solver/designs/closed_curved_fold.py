"""Curved folds around closed curves, plane, saddle-shaped or knotted (figure S14)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver.errors import InvalidValue, require_count, require_length
from solver.front import Front
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.mesh import QuadMesh
from solver.transfer import Closing
from solver.vectors import FloatArray, cross, unit

__all__ = ["CLOSED_CURVES", "ClosedCurvedFold", "closed_zigzag"]

# Amplitudes of x = sum X cos ht, y = sum Y sin ht, z = sum Z sin ht, one row for each h = 1, 2, ...
# A half turn about the x axis takes such a curve, run backwards, onto itself.
CLOSED_CURVES = {
    "circle": np.array([[1.0, 1.0, 0.0]]),
    "ellipse": np.array([[1.0, 0.6, 0.0]]),
    "saddle": np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 0.15]]),
    "trefoil": np.array([[0.5, 0.5, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.5]]),
    "figure_eight": np.array(
        [[0.25, 0.25, 0], [0, 0, 0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.5], [0.25, 0.25, 0.0]]
    ),
}


@dataclass(frozen=True)
class ClosedCurvedFold:
    """Seed: a closed curve with a zigzag in its osculating planes, k = pi. Lengths: one.

    With k = pi the flat seed is a straight line, and one vertex turns the flap angle alpha into
    pi - alpha + delta: once around an even zigzag it comes back for all flap angles, where the
    deltas add up to nothing with alternating signs, or else for none. The half turn that takes the
    curves onto themselves sees to the former. With any other k alike at all vertices a plane
    zigzag closes lying flat alone; one of odd count, half twisted, lies flat somewhere.
    Later strips close for two: one continues the faces behind, the other one, taken here, folds.

    Attributes
    ----------
    curve : circle, ellipse or saddle, 2 wide; the knots trefoil or figure_eight, 3 wide.
    columns : number of quads around, even.
    zigzag : half the swing of the vertices across the curve, along its principal normal.
    flap_angle : of the first strip, at its first vertex, radians.
    crease_length : of every crease across a strip.
    strips : how many to grow.
    """

    curve: str = "trefoil"
    columns: int = 120
    zigzag: float = 0.06
    flap_angle: float = field(default=np.radians(115), metadata={"angle": True})
    crease_length: float = 0.1
    strips: int = 10

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        if self.curve not in CLOSED_CURVES:
            raise InvalidValue(
                "curve", self.curve, f"be one of {', '.join(CLOSED_CURVES)}", "circle is simplest."
            )
        require_count("columns", self.columns, 4, "A zigzag turns at least four times.")
        if self.columns % 2:
            raise InvalidValue("columns", self.columns, "be even", "A zigzag closes in pairs.")
        require_length("zigzag", abs(self.zigzag))
        require_length("crease_length", self.crease_length)
        loop = closed_zigzag(CLOSED_CURVES[self.curve], self.columns, self.zigzag)
        seed = QuadMesh.from_rows(loop[None], closed=True)

        def choose(front: Front, strip: int) -> Strip | Stop:
            closings = front.closings()
            if closings.case is Closing.FAMILY:
                return Strip(self.flap_angle, self.crease_length)
            if closings.case is not Closing.PAIR:
                return Stop(
                    Status.LOOP_NOT_CLOSED,
                    f"Strip {strip + 1}: the loop closes for no flap angle that folds "
                    f"({closings.case}). Another zigzag or flap angle may help.",
                )
            at, flap_angle = closings.start[1]
            rays = front.rays(flap_angle, at=at + 1)
            if front.self_intersections(rays.flap_angles[:, None]).any():
                return Stop(
                    Status.FACES_CROSS,
                    f"Strip {strip + 1}: new faces would cross old ones at the flap angles that "
                    "close the loop. A flap angle nearer to 180 degrees, a smaller zigzag or more "
                    "columns may help.",
                )
            return Strip(flap_angle, self.crease_length, at=at + 1)

        return grow(seed, self.strips, choose, k=np.pi, progress=progress)


def closed_zigzag(amplitudes: FloatArray, columns: int, zigzag: float) -> FloatArray:
    """Vertices on alternating sides of a closed curve, along its normal, shape (columns, 3).

    amplitudes : of x (cosines), y and z (sines) for each harmonic 1, 2, ..., shape (h, 3).
    """
    harmonic = np.arange(1, len(amplitudes) + 1)
    angle = 2 * np.pi * np.arange(columns)[:, None] * harmonic / columns
    even, odd = np.cos(angle), np.sin(angle)
    along = amplitudes * harmonic[:, None]
    bend = amplitudes * harmonic[:, None] ** 2
    point = np.column_stack([even @ amplitudes[:, :1], odd @ amplitudes[:, 1:]])
    first = np.column_stack([-odd @ along[:, :1], even @ along[:, 1:]])
    second = -np.column_stack([even @ bend[:, :1], odd @ bend[:, 1:]])
    normal = unit(cross(cross(first, second), first))
    side = (-1.0) ** np.arange(columns)
    out: FloatArray = point - zigzag * side[:, None] * normal
    return out
