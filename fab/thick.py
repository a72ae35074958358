"""Which bodies is a thick sheet made of, and with which face does each of them move?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.bodies import Bodies, concatenated
from fab.crease import CreasePattern
from fab.errors import Finding
from fab.hinges import HingeSettings, make_webs, web_setbacks
from fab.panels import Panels, PanelSettings, make_panels
from fab.poses import face_poses
from fab.setbacks import Setbacks, setbacks
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["ThickSheet", "heights_and_setbacks", "thicken"]

# Webs reach so far into their panels where both become one body.
_OVERLAP_MM = 1e-3


@dataclass(frozen=True)
class ThickSheet:
    """A crease pattern in solid bodies, flat, the axes of its creases at z = 0.

    Attributes
    ----------
    pattern : in mm; panels : what stands on its faces.
    bodies : all solids; names : such as "panel_3" and "hinge_12", by face and by edge.
    faces : shape (n,), the face that each body moves with; -1 where it bends, as webs do.
    creases : shape (n,), the edge that each body belongs to; -1 for panels.
    flexible : shape (n,), whether it is of the second, softer material.
    joining : bodies that, joined with one another, make the printed surface: as `bodies`, but
        those that are one with a panel reach into it.
    """

    pattern: CreasePattern
    panels: Panels
    bodies: Bodies
    names: tuple[str, ...]
    faces: IntArray
    creases: IntArray
    flexible: BoolArray
    joining: Bodies

    @property
    def rigid(self) -> IntArray:
        """Numbers of the bodies that move with a face."""
        return np.flatnonzero(self.faces >= 0)

    def posed(self, coords: FloatArray) -> Bodies:
        """The rigid bodies, in the order of `rigid`, where a folded state has their faces.

        coords : shape (nv, 3), mm, of the pattern's vertices.
        """
        turns, shifts = face_poses(self.pattern, coords)
        owner = self.faces[self.rigid]
        return self.bodies.chosen(self.rigid).moved(turns[owner], shifts[owner])


def heights_and_setbacks(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings
) -> tuple[tuple[float, float], Setbacks]:
    """Bottom and top of the panels of a pattern over their axes, mm, and what they are set back."""
    heights = panel.heights_mm
    back = setbacks(
        pattern,
        heights,
        gap_mm=panel.gap_mm,
        clearance_mm=panel.clearance_mm,
        hinge_mm=web_setbacks(pattern, hinge),
        limit_deg=panel.fold_limit_deg,
    )
    return heights, back


def thicken(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings
) -> tuple[ThickSheet, list[Finding]]:
    """Panels and hinges of a pattern, and what is to be told of them."""
    heights, back = heights_and_setbacks(pattern, panel, hinge)
    panels, findings = make_panels(pattern, heights, back)
    webs, missing = make_webs(pattern, panels, hinge)
    reaching, _ = make_webs(pattern, panels, hinge, _OVERLAP_MM)
    count, hinges = len(panels.bodies), len(webs.bodies)
    names = [f"panel_{face}" for face in panels.faces] + [f"hinge_{e}" for e in webs.creases]
    none = np.full(count, -1)
    return (
        ThickSheet(
            pattern,
            panels,
            concatenated([panels.bodies, webs.bodies]),
            tuple(names),
            np.concatenate([panels.faces, np.full(hinges, -1)]),
            np.concatenate([none, webs.creases]),
            np.arange(count + hinges) >= count,
            concatenated([panels.bodies, reaching.bodies]),
        ),
        findings + missing,
    )
