"""A thick sheet: the solid bodies of a crease pattern, and the face that each moves with."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fab.errors import Finding
from fab.geometry.bodies import Bodies, bodies_of, concatenated
from fab.panels.alignment_holes import drilled
from fab.panels.anchors import anchored
from fab.panels.bevelled_panels import Panels, PanelSettings, make_panels
from fab.panels.film import make_film
from fab.panels.first_layer import relieved
from fab.panels.hinge_room import crease_sides
from fab.panels.hinges import (
    HingeSettings,
    crease_kinds,
    heights_and_setbacks,
    require_fitting_hinges,
)
from fab.panels.inner_edges import slitted
from fab.panels.knuckled_panels import barrels_of, with_knuckles
from fab.panels.knuckles import Knuckles, make_knuckles
from fab.panels.lost_faces import inspect_feasibility
from fab.panels.snap_slots import with_snap_slots
from fab.panels.webs import make_webs
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, IntArray

__all__ = ["ThickSheet", "rigid_sheet", "thicken"]


@dataclass(frozen=True)
class ThickSheet:
    """A crease pattern in solid bodies, flat, the axes of its creases at z = 0.

    Attributes
    ----------
    pattern : in mm; panel, hinge : the settings that it is made with.
    panels : the panels of its faces, without hinges.
    bodies : all solids: first one for each panel, with its knuckles, then webs, then films.
    names : such as "panel_3", "hinge_12" and "film_0", by face and by edge.
    faces : shape (n,), the face that each body moves with; -1 where it bends, as webs and films do.
    creases : shape (n,), the edge that a web belongs to; -1 for others.
    flexible : shape (n,), whether it is of the second, softer material.
    knuckles : where barrels of two panels turn about a pin.
    held : shape (k,), the edges at which a hinge of any kind holds two panels together.
    joining : bodies that, joined with one another, make the printed surface: as `bodies`, but
        webs reach into their panels. Panels stand on a film without a gap. What is laid into the
        print is not among them.
    """

    pattern: CreasePattern
    panel: PanelSettings
    hinge: HingeSettings
    panels: Panels
    bodies: Bodies
    names: tuple[str, ...]
    faces: IntArray
    creases: IntArray
    flexible: BoolArray
    knuckles: Knuckles
    held: IntArray
    joining: Bodies

    @property
    def laid(self) -> BoolArray:
        """Which bodies are laid into the print and not printed, shape (n,): embedded films."""
        return self.flexible & (self.creases < 0) & self.hinge.embedded

    @property
    def rigid(self) -> IntArray:
        """Numbers of the bodies that move with a face."""
        return np.flatnonzero(self.faces >= 0)


def rigid_sheet(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings
) -> tuple[ThickSheet, list[Finding]]:
    """Panels with their knuckles, without what bends: all that can collide when folded.

    Of faces without a panel those that are not convex are named; for the others see
    `fab.panels.feasibility`.

    Raises `InvalidJob` where panels cannot have such hinges.
    """
    require_fitting_hinges(panel, hinge)
    heights, back = heights_and_setbacks(pattern, panel, hinge)
    panels, findings = make_panels(pattern, heights, back)
    knuckles, without = make_knuckles(pattern, panels, hinge)
    findings += without
    rigid = panels
    if hinge.hole_mm > 0:
        rigid, without = drilled(panels, hinge.hole_mm, hinge.wall_mm)
        findings += without
    bodies = rigid.bodies
    if len(knuckles.creases):
        bodies = with_knuckles(pattern, rigid, knuckles, hinge)
        if hinge.snap:
            barrels = barrels_of(pattern, panels, knuckles)
            bodies = with_snap_slots(panels, barrels, bodies, hinge)
    bodies, without = slitted(pattern, panels, bodies)
    findings += without
    sheet = ThickSheet(
        pattern,
        panel,
        hinge,
        panels,
        bodies,
        names=tuple(f"panel_{face}" for face in panels.faces),
        faces=panels.faces,
        creases=np.full(len(bodies), -1),
        flexible=np.zeros(len(bodies), bool),
        knuckles=knuckles,
        held=knuckles.creases,
        joining=bodies,
    )
    return sheet, findings


def thicken(
    pattern: CreasePattern,
    panel: PanelSettings,
    hinge: HingeSettings,
    least_width_mm: float = 0.0,
) -> tuple[ThickSheet, list[Finding]]:
    """Panels and hinges of a pattern, and findings about them.

    least_width_mm : that advice leaves to panels, such as a printer's nozzle.

    Raises `InvalidJob` where panels cannot have such hinges.
    """
    rigid, findings = rigid_sheet(pattern, panel, hinge)
    panels = rigid.panels
    findings = [
        *inspect_feasibility(pattern, panel, hinge, panels.faces, least_width_mm),
        *findings,
    ]
    webs, without = make_webs(pattern, panels, hinge)
    findings += without
    held = [webs.creases, rigid.held]
    film = bodies_of([])
    if "film" in hinge.kinds and len(panels.bodies):
        film = make_film(pattern, panels, hinge, panel.gap_mm)
        first, second = crease_sides(pattern, panels)
        under = crease_kinds(pattern, hinge) == "film"
        held.append(np.flatnonzero((first >= 0) & (second >= 0) & under))
    bending = len(webs.bodies) + len(film)
    sheet = replace(
        rigid,
        bodies=concatenated([rigid.bodies, webs.bodies, film]),
        names=(
            *rigid.names,
            *(f"hinge_{e}" for e in webs.creases),
            *(f"film_{i}" for i in range(len(film))),
        ),
        faces=np.concatenate([rigid.faces, np.full(bending, -1)]),
        creases=np.concatenate([rigid.creases, webs.creases, np.full(len(film), -1)]),
        flexible=np.concatenate([rigid.flexible, np.ones(bending, bool)]),
        held=np.sort(np.concatenate(held)),
        joining=concatenated([rigid.bodies, webs.reaching, *([] if hinge.embedded else [film])]),
    )
    spread = min(panel.first_layer_mm or 0.0, panel.thickness_mm / 4)
    if spread > 0:
        rigid_ones = sheet.faces >= 0
        bodies, joining, note = relieved(
            sheet.bodies, sheet.joining, rigid_ones, spread, hinge.play_mm
        )
        sheet = replace(sheet, bodies=bodies, joining=joining)
        findings += note
    if hinge.anchor_mm > 0:
        bodies, without = anchored(pattern, panels, webs.creases, sheet.bodies, hinge)
        sheet = replace(sheet, bodies=bodies)
        findings += without
    return sheet, findings
