"""Cut paths: the lines that a machine runs along, by what it does along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from solver.vectors import FloatArray

__all__ = ["CutPaths", "Layer", "Operation", "joined"]


class Operation(StrEnum):
    """What the machine does along a line, in the order of the work; each is a layer of drawings."""

    ENGRAVE = "ENGRAVE"
    MOUNTAIN = "MOUNTAIN"
    VALLEY = "VALLEY"
    RELIEF = "RELIEF"
    CUT = "CUT"


@dataclass(frozen=True)
class Layer:
    """All lines of one operation, in millimetres.

    Attributes
    ----------
    segments : open lines, shape (n, 2, 2): line, end, coordinate.
    outlines : closed polylines, each of shape (m, 2), the first vertex not repeated.
    """

    operation: Operation
    segments: FloatArray = field(default_factory=lambda: np.empty((0, 2, 2)))
    outlines: tuple[FloatArray, ...] = ()

    def moved(self, turn: FloatArray, shift: FloatArray) -> Layer:
        """The layer with every point p moved to turn @ p + shift; shapes (2, 2) and (2,)."""
        return replace(
            self,
            segments=self.segments @ turn.T + shift,
            outlines=tuple(outline @ turn.T + shift for outline in self.outlines),
        )


@dataclass(frozen=True)
class CutPaths:
    """What is on a sheet, in the order of the work; all of it is within (0, 0) to `size_mm`.

    on_bed : whether `size_mm` is the bed of a machine, so that pages are exactly as large.
    """

    layers: tuple[Layer, ...]
    size_mm: tuple[float, float]
    on_bed: bool = False


def joined(layers: Sequence[Layer]) -> tuple[Layer, ...]:
    """One layer for each operation that occurs, in the order of the work.

    >>> layers = [Layer(Operation.CUT), Layer(Operation.ENGRAVE), Layer(Operation.CUT)]
    >>> [layer.operation.value for layer in joined(layers)]
    ['ENGRAVE', 'CUT']
    """
    out = []
    for operation in Operation:
        same = [layer for layer in layers if layer.operation is operation]
        if same:
            segments = np.concatenate([layer.segments for layer in same])
            outlines = tuple(outline for layer in same for outline in layer.outlines)
            out.append(Layer(operation, segments, outlines))
    return tuple(out)
