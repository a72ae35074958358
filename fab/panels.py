"""Which solid stands on each face of the sheet, set back from its creases?

Every panel is a prism between two rings of corners, the bottom one on z = 0 with the crease axes
and the top one at the sheet's thickness. A side on a crease is set back, one on the outline is not:

        gap
      |<--->|
    +-+     +-----+   top ring, z = thickness
    | |     |     |
    +-+--x--+-----+   bottom ring, z = 0, with the crease's axis x
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from fab.crease import CreasePattern
from fab.errors import Finding, Severity
from fab.polygons import are_convex, next_corner, ring_areas
from fab.settings import Settings
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["PanelSettings", "Panels", "Prisms", "make_panels"]

# A side of a panel that is shorter than this after its setbacks is none.
_SHORTEST_SIDE_MM = 0.05


class PanelSettings(Settings):
    """Thickness of the panels and the gap between them."""

    thickness_mm: float = Field(default=1.6, ge=0.01, le=1000, description="height of the panels")
    gap_mm: float = Field(
        default=1.0, ge=0.01, le=1000, description="between two panels, across their crease"
    )


@dataclass(frozen=True)
class Prisms:
    """Solids between a bottom ring on z = 0 and a top ring at a height, sides planar.

    Attributes
    ----------
    offsets : prism i has the corners offsets[i]:offsets[i + 1], counterclockwise; shape (n + 1,).
    bottom, top : corners, mm, shape (total, 2).
    heights_mm : shape (n,).
    """

    offsets: IntArray
    bottom: FloatArray
    top: FloatArray
    heights_mm: FloatArray

    def __len__(self) -> int:
        return len(self.heights_mm)

    def ring(self, i: int) -> slice:
        """Corners of prism i."""
        return slice(int(self.offsets[i]), int(self.offsets[i + 1]))

    def volumes_mm3(self) -> FloatArray:
        """Exact volumes h (A_bottom + 4 A_middle + A_top) / 6 (prismatoid formula)."""
        rings = (self.bottom, (self.bottom + self.top) / 2, self.top)
        low, middle, high = (ring_areas(ring, self.offsets) for ring in rings)
        out: FloatArray = self.heights_mm * (low + 4 * middle + high) / 6
        return out


@dataclass(frozen=True)
class Panels:
    """The panels of a pattern.

    Attributes
    ----------
    prisms : one for each panel.
    faces : the face of each panel, shape (n,); creases : the edge under each side, -1 on the
        outline, shape (total,): side j runs from corner j to the next.
    """

    prisms: Prisms
    faces: IntArray
    creases: IntArray


def make_panels(pattern: CreasePattern, settings: PanelSettings) -> tuple[Panels, list[Finding]]:
    """One panel for each face; faces that lose a side to their gaps are left out, and named."""
    corners, offsets = pattern.faces_vertices, pattern.faces_offsets
    following = next_corner(offsets)
    creases = _side_edges(pattern, corners, corners[following])
    on_crease = pattern.edges_faces[creases, 1] >= 0
    setback = np.where(on_crease, settings.gap_mm / 2, 0.0)
    start = pattern.vertices_coords[corners]
    ring, kept = inset(start, offsets, setback)
    bent = (np.diff(offsets) > 4) & ~are_convex(start, offsets)
    findings = []
    for faces, code, why in (
        (
            np.flatnonzero(~kept & ~bent),
            "panel-vanishes",
            f"lose a side to gaps of {settings.gap_mm:g} mm on their creases and have no panel. "
            "Lower gap_mm or enlarge the sheet.",
        ),
        (
            np.flatnonzero(bent),
            "panel-not-convex",
            "have more than 4 sides and are not convex; they have no panel. Split them by creases.",
        ),
    ):
        if len(faces):
            text = f"{len(faces)} faces {why}"
            named = tuple(faces[:20].tolist())
            findings.append(Finding(code, Severity.ERROR, text, panels=named))
    kept &= ~bent
    chosen = np.repeat(kept, np.diff(offsets))
    sizes = np.diff(offsets)[kept]
    prisms = Prisms(
        np.concatenate([[0], np.cumsum(sizes)]),
        ring[chosen],
        ring[chosen],
        np.full(int(kept.sum()), settings.thickness_mm),
    )
    labels = np.where(on_crease, creases, -1)[chosen]
    return Panels(prisms, np.flatnonzero(kept), labels), findings


def _side_edges(pattern: CreasePattern, start: IntArray, end: IntArray) -> IntArray:
    """The edge between each pair of vertices."""
    count = len(pattern.vertices_coords)
    low, high = pattern.edges_vertices.min(axis=1), pattern.edges_vertices.max(axis=1)
    order = np.argsort(low * count + high)
    wanted = np.minimum(start, end) * count + np.maximum(start, end)
    out: IntArray = order[np.searchsorted((low * count + high)[order], wanted)]
    return out


def inset(
    corners: FloatArray, offsets: IntArray, setback: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Polygons with each side moved inwards by its own setback.

    corners : counterclockwise rings, shape (total, 2); setback : of the side from each corner to
    the next, shape (total,). Returns the new corners, and which polygons keep all their sides in
    direction, each at least `_SHORTEST_SIDE_MM` long, shape (n,).

    With unit directions d1, d2 of the sides before and after a corner and their setbacks s1, s2,
    the corner moves by (s1 d2 - s2 d1) / (d1 x d2).
    """
    following = next_corner(offsets)
    side = corners[following] - corners
    length = np.hypot(side[:, 0], side[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        after = side / length[:, None]
        before = np.empty_like(after)
        before[following] = after
        s2 = setback
        s1 = np.empty_like(s2)
        s1[following] = s2
        sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        move = (s1[:, None] * after - s2[:, None] * before) / sine[:, None]
    # straight corners: both sides move alike, or there is no corner to move to
    straight = (np.abs(sine) < 1e-9) & (s1 == s2)
    move[straight] = (s2[:, None] * np.column_stack([-after[:, 1], after[:, 0]]))[straight]
    moved = corners + move
    with np.errstate(invalid="ignore"):
        along = ((moved[following] - moved) * after).sum(axis=1)
        fine = np.isfinite(along) & (along >= np.minimum(_SHORTEST_SIDE_MM, length / 2))
    kept = np.logical_and.reduceat(fine, offsets[:-1])
    return moved, kept
