"""Closed cuts as a tool begins and ends them: led in from what is thrown away, and overcut.

A knife does not cut where it comes down as it cuts later, and a closed cut whose end just meets its
start stays uncut there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.geometry.rings import is_hole
from solver.vectors import FloatArray, IntArray, unit

__all__ = ["led_in"]

# What is cut through along closed lines.
_THROUGH = (Operation.RELIEF, Operation.HOLE, Operation.CUT)
# Shares of the length at which a lead-in is tried, the whole of it first.
_SHARES = (1.0, 0.5, 0.25)
# Corners of an outline at which one is tried, evenly spread.
_MOST_TRIED = 24
# Shorter sums of two unit vectors have no direction of their own.
_STRAIGHT = 1e-3
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
        shapely.prepare(figures)
        width, depth = paths.size_mm
        sheet = shapely.box(margin_mm, margin_mm, width - margin_mm, depth - margin_mm)
        piece = np.array([is_hole(ring) == turned_over for ring in rings], dtype=bool)
        return cls(figures, piece, shapely.STRtree(lines), sheet)

    def lead_in(self, ring: FloatArray, number: int, length_mm: float) -> tuple[int, FloatArray]:
        """The corner at which a ring begins, and where its lead-in begins, shape (1 or 0, 2)."""
        if not length_mm:
            return 0, ring[:0]
        corners, directions = _directions(ring)
        figure, starts = self.figures[number], ring[corners]
        for share in _SHARES:
            begins = starts + share * length_mm * directions
            waste = shapely.contains_xy(figure, begins[:, 0], begins[:, 1]) != self.piece[number]
            for i in np.flatnonzero(waste).tolist():
                if self._clear(starts[i], begins[i]):
                    return int(corners[i]), begins[i][None]
        return 0, ring[:0]

    def _clear(self, start: FloatArray, begin: FloatArray) -> bool:
        """Whether a lead-in from `begin` to `start` stays on the sheet and crosses nothing."""
        span = begin - start
        free = 2 * _CLEAR_MM / max(float(np.hypot(*span)), 2 * _CLEAR_MM)
        lead = shapely.LineString([begin, start + free * span])
        return self.sheet.covers(lead) and not len(self.tree.query(lead, "dwithin", _CLEAR_MM))


def _directions(ring: FloatArray) -> tuple[IntArray, FloatArray]:
    """Corners, (n,), and directions from there, (n, 2), in which lead-ins may begin, best first.

    All that are in line with the side that follows come before those that halve the corner.
    """
    corners = np.arange(0, len(ring), max(1, len(ring) // _MOST_TRIED))
    onward = unit(np.roll(ring, -1, axis=0) - ring)[corners]
    back = unit(np.roll(ring, 1, axis=0) - ring)[corners]
    aside = np.column_stack([-onward[:, 1], onward[:, 0]])
    middle = onward + back
    straight = np.hypot(*middle.T) < _STRAIGHT
    middle = unit(np.where(straight[:, None], aside, middle))
    return np.tile(corners, 3), np.concatenate([-onward, middle, -middle])
