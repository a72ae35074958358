"""Scales of colours: named, with a unit, and the same for every sheet."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from solver.errors import InvalidValue
from solver.vectors import FloatArray

__all__ = ["STRAIN", "Scale", "ScaleKind", "distance_scale"]

# The least distance that has the strongest colour, mm: that of a sheet of paper or so.
_LEAST_DISTANCE_MM = 0.1
# The share of all distances that is within a scale.
_HELD = 0.98


class ScaleKind(StrEnum):
    """How values are spread over the colours."""

    LINEAR = "linear"
    LOGARITHMIC = "logarithmic"


@dataclass(frozen=True)
class Scale:
    """Which values have the colours at both ends of a scale.

    Attributes
    ----------
    name, unit : what is shown, such as "strain" in "%".
    low, high : values at its ends; what is beyond them has the colours of the ends.
    kind : linear, or logarithmic.
    signed : whether the middle of the scale is zero, and its two halves differ in hue.
    """

    name: str
    unit: str
    low: float
    high: float
    kind: ScaleKind = ScaleKind.LINEAR
    signed: bool = False

    def __post_init__(self) -> None:
        least = 0.0 if self.kind is ScaleKind.LOGARITHMIC else -np.inf
        if not least < self.low < self.high < np.inf:
            cure = "Give a scale its lower end first; logarithmic ones begin above 0."
            bound = f"be finite, rise, and begin above {least:g}"
            raise InvalidValue("scale", (self.low, self.high), bound, cure)

    def shares(self, values: FloatArray) -> FloatArray:
        """Where values are on the scale, from 0 to 1, in an array of their shape.

        >>> STRAIN.shares(np.array([0.0, 0.01, 0.1, 1.0, 50.0])).round(12).tolist()
        [0.0, 0.0, 0.333333333333, 0.666666666667, 1.0]
        """
        low, high = self.low, self.high
        values = np.clip(values, low, high)
        if self.kind is ScaleKind.LOGARITHMIC:
            low, high = float(np.log(low)), float(np.log(high))
            values = np.log(values)
        return np.asarray((values - low) / (high - low))

    def value_at(self, share: float) -> float:
        """The value at a place of the scale, 0 to 1."""
        if self.kind is ScaleKind.LOGARITHMIC:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + (self.high - self.low) * share


# Paper stretches by some hundredths of a percent as it is folded, and tears at some percent.
STRAIN = Scale("strain", "%", 0.01, 10.0, ScaleKind.LOGARITHMIC)


def distance_scale(distances_mm: FloatArray) -> Scale:
    """The scale of signed distances to a surface: to the next of 0.1, 0.2, 0.5, 1, 2, 5 ... mm.

    That holds 98 % of them: a few faces at a rim may be far off.

    >>> distance_scale(np.array([-1e-9, 1e-9])).high, distance_scale(np.array([-1.3, 0.2])).high
    (0.1, 2.0)
    """
    largest = float(np.quantile(np.abs(distances_mm), _HELD)) if len(distances_mm) else 0.0
    high = _LEAST_DISTANCE_MM
    if largest > high:
        power = 10.0 ** int(np.floor(np.log10(largest)))
        high = next(power * step for step in (1, 2, 5, 10) if power * step >= largest * (1 - 1e-9))
    high = float(f"{high:.3g}")
    return Scale("distance to the surface", "mm", -high, high, signed=True)
