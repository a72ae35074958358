"""What joins two panels along their crease?

A web: a thin strip on z = 0 across the gap, ending before the corners of both panels, so that the
vertices of the pattern stay open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from fab.crease import CreasePattern
from fab.errors import Finding, Severity
from fab.panels import Panels, Prisms
from fab.polygons import next_corner
from fab.settings import Settings
from solver.vectors import FloatArray, IntArray

__all__ = ["HingeSettings", "Webs", "make_webs"]


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


@dataclass(frozen=True)
class Webs:
    """The webs of a pattern.

    Attributes
    ----------
    prisms : one for each web; its corners are those on the first panel's side, from the end of the
        crease to its start, then those on the second panel's side.
    creases : the edge of each web, shape (n,).
    sides : the side (as numbered in `Panels.creases`) that the web touches on its first and second
        panel, shape (n, 2).
    """

    prisms: Prisms
    creases: IntArray
    sides: IntArray


def make_webs(
    pattern: CreasePattern, panels: Panels, settings: HingeSettings
) -> tuple[Webs, list[Finding]]:
    """One web for each crease that has panels on both sides and room between their corners."""
    first, second = _crease_sides(pattern, panels)
    creases = np.flatnonzero((first >= 0) & (second >= 0))
    sides = np.column_stack([first[creases], second[creases]])
    ends = pattern.vertices_coords[pattern.edges_vertices[creases]]
    u = ends[:, 1] - ends[:, 0]
    u /= np.hypot(u[:, 0], u[:, 1])[:, None]
    normal = np.column_stack([-u[:, 1], u[:, 0]])
    share = settings.web_mm / panels.prisms.heights_mm[0] if len(panels.prisms) else 0.0
    following = next_corner(panels.prisms.offsets)
    low = np.zeros(len(creases))  # webs stay between the ends of their crease
    high = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    setbacks = []
    for column in (0, 1):
        corner = sides[:, column]
        for height in (0.0, share):
            ring = (1 - height) * panels.prisms.bottom + height * panels.prisms.top
            arms = ring[corner] - ends[:, 0], ring[following[corner]] - ends[:, 0]
            along = [(arm * u).sum(axis=1) for arm in arms]
            low = np.maximum(low, np.minimum(*along))
            high = np.minimum(high, np.maximum(*along))
            setbacks.append((arms[0] * normal).sum(axis=1))
    low, high = low + settings.relief_mm, high - settings.relief_mm
    fits = high - low >= settings.web_mm
    findings = _missing(creases[~fits])
    creases, sides, origin = creases[fits], sides[fits], ends[fits, 0]
    u, normal, low, high = u[fits], normal[fits], low[fits], high[fits]

    def ring_at(one: FloatArray, two: FloatArray) -> FloatArray:
        at = np.stack([high, low, low, high], axis=1)
        off = np.stack([one, one, two, two], axis=1)
        points = origin[:, None] + at[..., None] * u[:, None] + off[..., None] * normal[:, None]
        flat: FloatArray = points.reshape(-1, 2)
        return flat

    below_first, above_first, below_second, above_second = (s[fits] for s in setbacks)
    prisms = Prisms(
        np.arange(len(creases) + 1) * 4,
        ring_at(below_first, below_second),
        ring_at(above_first, above_second),
        np.full(len(creases), settings.web_mm),
    )
    return Webs(prisms, creases, sides), findings


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


def _crease_sides(pattern: CreasePattern, panels: Panels) -> tuple[IntArray, IntArray]:
    """For every edge the side of its first and of its second panel; -1 where there is none."""
    first = np.full(len(pattern.edges_vertices), -1)
    second = np.full(len(pattern.edges_vertices), -1)
    owner = np.repeat(panels.faces, np.diff(panels.prisms.offsets))
    side = np.flatnonzero(panels.creases >= 0)
    edge = panels.creases[side]
    is_first = pattern.edges_faces[edge, 0] == owner[side]
    first[edge[is_first]] = side[is_first]
    second[edge[~is_first]] = side[~is_first]
    return first, second
