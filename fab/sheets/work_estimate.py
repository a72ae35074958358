"""Estimate of a machine's work on a sheet: pierces, lengths by kind of work, and time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.sheets.materials import Speeds
from fab.sheets.tours import lengths, travel_mm
from solver.vectors import FloatArray

__all__ = ["Estimate", "estimate"]


@dataclass(frozen=True)
class Estimate:
    """What a machine does with a sheet, for the order in which its lines are.

    Attributes
    ----------
    pierces : lines, chains and outlines cut through; engraved ones need none.
    cut_mm, perforate_mm, engrave_mm : length of the work.
    travel_mm : from the origin to the first line and from line to line, without the return.
    minutes : all lengths at their speeds, and the pierces.
    """

    pierces: int
    cut_mm: float
    perforate_mm: float
    engrave_mm: float
    travel_mm: float
    minutes: float


def estimate(paths: CutPaths, speeds: Speeds) -> Estimate:
    """Lengths and time for the lines in the order in which they are; see `Estimate`."""
    pierces = 0
    cut = perforate = engrave = 0.0
    stops = [np.empty((0, 2))]
    for layer in paths.layers:
        length = _length_mm(layer)
        if layer.operation is Operation.ENGRAVE:
            engrave += float(length)
        else:
            pierces += len(layer.segments) + len(layer.chains) + len(layer.outlines)
            if layer.operation in (Operation.MOUNTAIN, Operation.VALLEY):
                perforate += float(length)
            else:
                cut += float(length)
        stops.append(layer.segments.reshape(-1, 2))
        stops += [chain[[0, -1]] for chain in layer.chains]
        stops += [outline[[0, 0]] for outline in layer.outlines]
    travel = travel_mm(np.concatenate(stops).reshape(-1, 2, 2), np.zeros(2))
    seconds = (
        cut / speeds.cut_mm_s
        + perforate / speeds.perforate_mm_s
        + engrave / speeds.engrave_mm_s
        + travel / speeds.travel_mm_s
        + pierces * speeds.pierce_s
    )
    return Estimate(pierces, cut, perforate, engrave, travel, seconds / 60)


def _length_mm(layer: Layer) -> float:
    """Length of all lines of a layer."""
    length = lengths(layer.segments).sum()
    sides = [np.stack([chain[:-1], chain[1:]], axis=1) for chain in layer.chains]
    sides += map(_sides, layer.outlines)
    length += sum(lengths(own).sum() for own in sides)
    return float(length)


def _sides(outline: FloatArray) -> FloatArray:
    """Sides of a closed polyline, shape (m, 2, 2)."""
    return np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)
