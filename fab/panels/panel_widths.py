"""How wide panels are at their bottom and their top."""

from __future__ import annotations

import numpy as np

from fab.panels.bevelled_panels import Panels
from solver.vectors import FloatArray

__all__ = ["panel_widths_mm"]

# Corners are at the bottom or the top but for rounding.
_AT_HEIGHT_MM = 1e-6


def panel_widths_mm(panels: Panels) -> FloatArray:
    """Least width of the bottom or the top of every panel, whichever is less, mm, shape (n,).

    Over the directions across its sides, one of which has the least width of a convex panel.
    """
    bodies, sides = panels.bodies, panels.sides
    out = np.full(len(bodies), np.inf)
    sizes = np.diff(sides.offsets)[panels.faces]
    ends = np.cumsum(sizes)
    body = np.repeat(np.arange(len(bodies)), sizes)
    side = np.arange(len(body)) + np.repeat(sides.offsets[panels.faces] - (ends - sizes), sizes)
    for z in panels.heights_mm:
        rows = np.flatnonzero(np.abs(bodies.vertices_coords[:, 2] - z) <= _AT_HEIGHT_MM)
        starts = np.searchsorted(bodies.vertices_body[rows], np.arange(len(bodies) + 1))
        counts = np.diff(starts)[body]
        first = np.cumsum(counts) - counts
        point = np.arange(int(counts.sum())) + np.repeat(starts[body] - first, counts)
        across = np.repeat(sides.inward[side], counts, axis=0)
        along = (bodies.vertices_coords[rows[point], :2] * across).sum(axis=1)
        level = np.flatnonzero(counts)  # sides of panels that have corners at this height
        begin, width = first[level], np.zeros(len(body))
        width[level] = np.maximum.reduceat(along, begin) - np.minimum.reduceat(along, begin)
        np.minimum.at(out, body, width)
    return out
