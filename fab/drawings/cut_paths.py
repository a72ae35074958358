"""Cut paths: the lines that a machine runs along, by what it does along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from solver.vectors import FloatArray

__all__ = ["CutPaths", "Layer", "Operation", "chained", "joined", "polylines"]

# Ends nearer than this are one point in files of six decimals.
_SAME_MM = 1e-6


class Operation(StrEnum):
    """What the machine does along a line, in the order of the work; each is a layer of drawings."""

    ENGRAVE = "ENGRAVE"
    MOUNTAIN = "MOUNTAIN"
    VALLEY = "VALLEY"
    RELIEF = "RELIEF"
    HOLE = "HOLE"
    CUT = "CUT"


@dataclass(frozen=True)
class Layer:
    """All lines of one operation, in millimetres.

    Attributes
    ----------
    segments : open lines, shape (n, 2, 2): line, end, coordinate.
    chains : open polylines, each of shape (m, 2), that are followed in one go.
    outlines : closed polylines, each of shape (m, 2), the first vertex not repeated.
    """

    operation: Operation
    segments: FloatArray = field(default_factory=lambda: np.empty((0, 2, 2)))
    outlines: tuple[FloatArray, ...] = ()
    chains: tuple[FloatArray, ...] = ()

    def moved(self, turn: FloatArray, shift: FloatArray) -> Layer:
        """The layer with every point p moved to turn @ p + shift; shapes (2, 2) and (2,)."""
        return replace(
            self,
            segments=self.segments @ turn.T + shift,
            outlines=tuple(outline @ turn.T + shift for outline in self.outlines),
            chains=tuple(chain @ turn.T + shift for chain in self.chains),
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
            chains = tuple(chain for layer in same for chain in layer.chains)
            out.append(Layer(operation, segments, outlines, chains))
    return tuple(out)


def polylines(layer: Layer) -> list[FloatArray]:
    """The lines of a layer in their order, each shape (m, 2), as a head follows them in one go.

    Segments that begin where the one before ends are one line; chains come after them; outlines end
    at their first vertex.

    >>> ends = [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 2.0]], [[5.0, 0.0], [6.0, 0.0]]]
    >>> [line.tolist() for line in polylines(Layer(Operation.ENGRAVE, np.array(ends)))]
    [[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]], [[5.0, 0.0], [6.0, 0.0]]]
    """
    return [
        *_runs(layer.segments),
        *layer.chains,
        *(np.concatenate([ring, ring[:1]]) for ring in layer.outlines),
    ]


def chained(segments: FloatArray) -> tuple[FloatArray, tuple[FloatArray, ...]]:
    """Segments that meet none of their neighbours, and chains of those that do.

    A segment is of a chain where it begins at the end of the one before it, so that a machine
    pierces once for a cut around a corner.

    >>> ends = [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 2.0]], [[5.0, 0.0], [6.0, 0.0]]]
    >>> segments, chains = chained(np.array(ends))
    >>> segments.tolist(), [chain.tolist() for chain in chains]
    ([[[5.0, 0.0], [6.0, 0.0]]], [[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]])
    """
    runs = _runs(segments)
    single = [run for run in runs if len(run) == 2]
    apart = np.stack(single) if single else np.empty((0, 2, 2))
    return apart, tuple(run for run in runs if len(run) > 2)


def _runs(segments: FloatArray) -> list[FloatArray]:
    """Polylines, each of shape (m, 2), of segments that follow each other."""
    apart = np.abs(segments[1:, 0] - segments[:-1, 1]).max(axis=1) > _SAME_MM
    parts = np.split(segments, np.flatnonzero(apart) + 1) if len(segments) else []
    return [np.concatenate([part[:1, 0], part[:, 1]]) for part in parts]
