"""Closed cuts as a tool begins and ends them: led in from what is thrown away, and overcut.

A knife does not cut where it comes down as it cuts later, and a closed cut whose end just meets its
start stays uncut there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.geometry.rings import is_hole
from solver.vectors import FloatArray, unit

__all__ = ["led_in"]

# What is cut through along closed lines.
_THROUGH = (Operation.RELIEF, Operation.HOLE, Operation.CUT)
# Shares of the length at which a lead-in is tried, the whole of it first.
_SHARES = (1.0, 0.5, 0.25)
# Corners of an outline at which one is tried.
_MOST_TRIED = 100
# Lead-ins touch no other line to within this, mm, where they are not at the start of their own.
_CLEAR_MM = 1e-3

Shapes = NDArray[np.object_]


def led_in(
    paths: CutPaths,
    lead_in_mm: float,
    overcut_mm: float,
    margin_mm: float = 0.0,
    *,
    turned_over: bool = False,
) -> tuple[CutPaths, tuple[FloatArray, ...]]:
    """Closed cuts that begin `lead_in_mm` before their start and end `overcut_mm` after it.

    The lead-in is a straight cut in what is thrown away: outside of pieces, inside holes. At a
    corner of a piece it is in line with the side that follows. It crosses no cut and stays within
    the margin of the sheet, and it is shorter, or begins at another corner, where there is no room
    for it. Engraved lines and dashes stay as they are, and so do open cuts.

    turned_over : whether outlines have their material on the right, as on the back of a sheet; it
        is on the left otherwise.

    Returns the paths, in the same order, and the outlines that have no room for a lead-in.
    """
    if not lead_in_mm and not overcut_mm:
        return paths, ()
    room = _Room.of(paths, margin_mm, turned_over=turned_over)
    bare: list[FloatArray] = []
    layers: list[Layer] = []
    number = 0
    for layer in paths.layers:
        if layer.operation not in _THROUGH:
            layers.append(layer)
            continue
        chains = list(layer.chains)
        for outline in layer.outlines:
            start, lead = room.lead_in(outline, number, lead_in_mm)
            if lead_in_mm and not len(lead):
                bare.append(outline)
            ring = np.roll(outline, -start, axis=0)
            chains.append(np.concatenate([lead, ring, _overcut(ring, overcut_mm)]))
            number += 1
        layers.append(replace(layer, outlines=(), chains=tuple(chains)))
    return replace(paths, layers=tuple(layers)), tuple(bare)


def _overcut(ring: FloatArray, length_mm: float) -> FloatArray:
    """From the start of a ring on along it, at most once around; shape (k, 2), the start first."""
    closed = np.concatenate([ring, ring[:1]])
    at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    end = min(length_mm, float(at[-1]))
    if end <= 0:
        return closed[:1]
    places = np.concatenate([at[at < end], [end]])
    return np.column_stack([np.interp(places, at, closed[:, axis]) for axis in (0, 1)])


@dataclass(frozen=True)
class _Room:
    """What lead-ins must keep clear of.

    Attributes
    ----------
    figures : within each closed cut; piece : which of them are around material, shape (n,).
    tree : of all cuts; sheet : what they must stay on.
    """

    figures: Shapes
    piece: NDArray[np.bool_]
    tree: shapely.STRtree
    sheet: shapely.Polygon

    @classmethod
    def of(cls, paths: CutPaths, margin_mm: float, *, turned_over: bool) -> _Room:
        """The room of a sheet within its margin."""
        through = [layer for layer in paths.layers if layer.operation in _THROUGH]
        rings = [ring for layer in through for ring in layer.outlines]
        open_lines = [line for layer in through for line in (*layer.segments, *layer.chains)]
        lines = [shapely.LinearRing(ring) for ring in rings]
        lines += [shapely.LineString(line) for line in open_lines]
        figures = np.array([shapely.Polygon(ring) for ring in rings], dtype=object)
        width, depth = paths.size_mm
        sheet = shapely.box(margin_mm, margin_mm, width - margin_mm, depth - margin_mm)
        piece = np.array([is_hole(ring) == turned_over for ring in rings], dtype=bool)
        return cls(figures, piece, shapely.STRtree(lines), sheet)

    def lead_in(self, ring: FloatArray, number: int, length_mm: float) -> tuple[int, FloatArray]:
        """The corner at which a ring begins, and where its lead-in begins, shape (1 or 0, 2)."""
        if not length_mm:
            return 0, ring[:0]
        for share in _SHARES:
            for corner in range(min(len(ring), _MOST_TRIED)):
                for direction in _directions(ring, corner):
                    begin = ring[corner] + share * length_mm * direction
                    if self._free(number, ring[corner], begin):
                        return corner, begin[None]
        return 0, ring[:0]

    def _free(self, number: int, start: FloatArray, begin: FloatArray) -> bool:
        """Whether a lead-in from `begin` to `start` is in the waste, and crosses nothing."""
        span = begin - start
        short = start + span * min(1.0, _CLEAR_MM / float(np.hypot(*span)))
        lead = shapely.LineString([begin, start + 2 * (short - start)])
        if not self.sheet.covers(lead) or len(self.tree.query(lead, "dwithin", _CLEAR_MM)):
            return False
        within = bool(shapely.contains_xy(self.figures[number], *begin))
        return within != bool(self.piece[number])


def _directions(ring: FloatArray, corner: int) -> Iterator[FloatArray]:
    """Directions from a corner in which a lead-in may begin, the best first."""
    before, at, after = ring[corner - 1], ring[corner], ring[(corner + 1) % len(ring)]
    onward = unit(after - at)
    yield -onward
    middle = onward + unit(before - at)
    if np.hypot(*middle) < 1e-3:  # straight on
        middle = np.array([-onward[1], onward[0]])
    middle = unit(middle)
    yield middle
    yield -middle
