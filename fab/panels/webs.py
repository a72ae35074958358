"""Webs: thin strips that join panels across their gaps.

A web lies at the height of the axes, from panel to panel. Around a vertex of the pattern all webs
end beyond the farthest corner of its panels, so that the vertex stays open: a relief hole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.bodies import Bodies, stacked
from fab.panels.bevelled_panels import Panels
from fab.panels.hinge_room import crease_runs, crease_sides, vertex_distances
from fab.panels.hinges import HingeSettings, crease_kinds
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, IntArray

__all__ = ["Webs", "inner_vertices", "make_webs"]


@dataclass(frozen=True)
class Webs:
    """The webs of a pattern.

    Attributes
    ----------
    bodies : one for each web, from panel to panel.
    reaching : the same webs, a little into their panels, to be joined with them.
    creases : the edge of each web, shape (n,).
    """

    bodies: Bodies
    reaching: Bodies
    creases: IntArray


# How far webs reach into their panels where both become one body.
_REACH_MM = 1e-3


def make_webs(
    pattern: CreasePattern, panels: Panels, settings: HingeSettings
) -> tuple[Webs, list[Finding]]:
    """One web for each crease of that kind that has panels on both sides and room between them.

    A finding names the creases that are too short for one.
    """
    low_mm, high_mm = panels.heights_mm
    below = float(np.clip(-settings.web_mm / 2, low_mm, high_mm - settings.web_mm))
    heights = below, below + settings.web_mm
    levels = np.array([below, 0.0, heights[1]]) if below < 0 < heights[1] else np.array(heights)
    first, second = crease_sides(pattern, panels)
    chosen = crease_kinds(pattern, settings) == "web"
    creases = np.flatnonzero((first >= 0) & (second >= 0) & chosen)
    first, second = first[creases], second[creases]
    length = panels.sides.length_mm[first]
    _, hole = vertex_distances(pattern, panels, levels)
    hole[~inner_vertices(pattern)] = 0.0
    hole = hole[pattern.edges_vertices[creases]]
    low, high = crease_runs(panels, first, second, levels, up_to_axis=False).T
    low = np.maximum(low, hole[:, 0]) + settings.relief_mm
    high = np.minimum(high, length - hole[:, 1]) - settings.relief_mm
    fits = high - low >= settings.web_mm
    findings = _missing(creases[~fits])
    creases, side, low, high = creases[fits], first[fits], low[fits], high[fits]
    off = np.stack([panels.setbacks.at(z)[creases] for z in levels.tolist()], axis=1)
    u, normal = panels.sides.along[side], panels.sides.inward[side]
    origin = panels.sides.start[side]

    def strips(reach_mm: float) -> Bodies:
        across = off + reach_mm
        corners = np.stack([across, across, -across, -across], axis=1)[..., None]
        along = np.stack([high, low, low, high], axis=1)[:, :, None, None]
        rings = origin[:, None, None] + along * u[:, None, None] + corners * normal[:, None, None]
        return stacked(rings.reshape(-1, len(levels), 2), np.arange(len(creases) + 1) * 4, levels)

    return Webs(strips(0.0), strips(_REACH_MM), creases), findings


def inner_vertices(pattern: CreasePattern) -> BoolArray:
    """Which vertices have faces all around, shape (nv,)."""
    inner = np.zeros(len(pattern.vertices_coords), bool)
    inner[pattern.faces_vertices] = True
    inner[pattern.edges_vertices[pattern.edges_faces[:, 1] < 0]] = False
    return inner


def _missing(creases: IntArray) -> list[Finding]:
    if not len(creases):
        return []
    return [
        Finding(
            "hinge-missing",
            Severity.WARNING,
            f"{counted(len(creases), 'crease is', 'creases are')} too short for a web between "
            f"{'its' if len(creases) == 1 else 'their'} panels' corners. "
            "Lower gap_mm or relief_mm, or enlarge the sheet.",
            creases=first_few(creases),
        )
    ]
