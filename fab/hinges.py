"""What joins two panels along their crease?

A web: a thin strip across the gap at the height of the axes, ending before the corners of both
panels, so that the vertices of the pattern stay open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from fab.bodies import Bodies, stacked
from fab.crease import CreasePattern
from fab.errors import Finding, Severity
from fab.panels import Panels, spans
from fab.settings import Settings
from solver.vectors import FloatArray, IntArray

__all__ = ["HingeSettings", "Webs", "crease_sides", "make_webs", "web_setbacks"]


class HingeSettings(Settings):
    """Web hinges."""

    web_mm: float = Field(
        default=0.4, ge=0.01, le=1000, description="thickness of the web: one or two layers"
    )
    relief_mm: float = Field(
        default=0.3,
        ge=0.01,
        le=1000,
        description="from the end of a web to the nearest panel corner or vertex",
    )
    strain_max: float = Field(
        default=0.5,
        gt=0,
        le=10,
        description="how far the outside of a web may stretch; it is made long enough",
    )


@dataclass(frozen=True)
class Webs:
    """The webs of a pattern.

    Attributes
    ----------
    bodies : one for each web, from panel to panel.
    creases : the edge of each web, shape (n,).
    ends : shape (n, 2), from where to where it runs, mm along its crease.
    heights_mm : bottom and top of all webs, over the axes.
    """

    bodies: Bodies
    creases: IntArray
    ends: FloatArray
    heights_mm: tuple[float, float]


def web_setbacks(pattern: CreasePattern, settings: HingeSettings) -> FloatArray:
    """Setback that the web of each crease needs, mm, shape (ne,).

    A web of thickness w and length 2 s bent by rho stretches its outside by w rho / (4 s).
    """
    rho = np.abs(np.radians(pattern.edges_foldAngle))
    return np.asarray(settings.web_mm * rho / (4 * settings.strain_max))


def make_webs(
    pattern: CreasePattern, panels: Panels, settings: HingeSettings, overlap_mm: float = 0.0
) -> tuple[Webs, list[Finding]]:
    """One web for each crease that has panels on both sides and room between their corners.

    overlap_mm : how far webs reach into their panels, for joining them to one body.
    """
    low_mm, high_mm = panels.heights_mm
    below = float(np.clip(-settings.web_mm / 2, low_mm, high_mm - settings.web_mm))
    heights = below, below + settings.web_mm
    levels = np.array([below, 0.0, heights[1]]) if below < 0 < heights[1] else np.array(heights)
    first, second = crease_sides(pattern, panels)
    creases = np.flatnonzero((first >= 0) & (second >= 0))
    ends = pattern.vertices_coords[pattern.edges_vertices[creases]]
    u = ends[:, 1] - ends[:, 0]
    length = np.hypot(*u.T)
    u /= length[:, None]
    normal = np.column_stack([-u[:, 1], u[:, 0]])
    low, high = np.zeros(len(creases)), length.copy()  # webs stay between the ends of their crease
    for z in levels.tolist():
        # the first face runs along its crease, the second one against it
        start, end = spans(panels.sides, panels.setbacks, z, first[creases])
        low, high = np.maximum(low, start), np.minimum(high, end)
        start, end = spans(panels.sides, panels.setbacks, z, second[creases])
        low, high = np.maximum(low, length - end), np.minimum(high, length - start)
    low, high = low + settings.relief_mm, high - settings.relief_mm
    fits = high - low >= settings.web_mm
    findings = _missing(creases[~fits])
    creases, origin, u, normal, low, high = (
        a[fits] for a in (creases, ends[:, 0], u, normal, low, high)
    )
    off = np.stack([panels.setbacks.at(z)[creases] for z in levels.tolist()], axis=1) + overlap_mm
    along = np.stack([high, low, low, high], axis=1)[:, :, None, None] * u[:, None, None]
    across = np.stack([off, off, -off, -off], axis=1)[..., None] * normal[:, None, None]
    rings = (origin[:, None, None] + along + across).reshape(-1, len(levels), 2)
    bodies = stacked(rings, np.arange(len(creases) + 1) * 4, levels)
    return Webs(bodies, creases, np.column_stack([low, high]), heights), findings


def _missing(creases: IntArray) -> list[Finding]:
    if not len(creases):
        return []
    return [
        Finding(
            "hinge-missing",
            Severity.WARNING,
            f"{len(creases)} creases are too short for a web between their panels' corners. "
            "Lower gap_mm or relief_mm, or enlarge the sheet.",
            creases=tuple(creases[:20].tolist()),
        )
    ]


def crease_sides(pattern: CreasePattern, panels: Panels) -> tuple[IntArray, IntArray]:
    """For every crease its side in the first and in the second face; -1 where no panel stands.

    Cuts (C) are no creases.
    """
    first = np.full(len(pattern.edges_vertices), -1)
    second = np.full(len(pattern.edges_vertices), -1)
    standing = np.zeros(pattern.face_count, bool)
    standing[panels.faces] = True
    edge, face = panels.sides.edges, panels.sides.faces
    joined = (
        (pattern.edges_faces[edge, 1] >= 0)
        & (pattern.edges_assignment[edge] != "C")
        & (pattern.edges_faces[edge, 0] != pattern.edges_faces[edge, 1])
        & standing[face]
    )
    side = np.flatnonzero(joined)
    is_first = pattern.edges_faces[edge[side], 0] == face[side]
    first[edge[side[is_first]]] = side[is_first]
    second[edge[side[~is_first]]] = side[~is_first]
    return first, second
