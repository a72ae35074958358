"""Faces that can have a panel, and the thickness, size or fold limit that saves the others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.rings import are_convex
from fab.panels.bevelled_panels import (
    LEAST_RADIUS_MM,
    MOST_THICKNESS_MM,
    PanelSettings,
    make_panels,
)
from fab.panels.hinges import (
    HingeSettings,
    crease_kinds,
    heights_and_setbacks,
    hinges_fit,
    least_thickness_mm,
)
from fab.panels.inset_limits import inradii, largest_where, rounded_down, rounded_up, scale_bounds
from fab.panels.knuckles import knuckles_turn
from fab.panels.setbacks import Setbacks, sides_of
from fab.pattern.crease_pattern import CreasePattern, scaled
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Feasibility", "inspect_feasibility"]

# A sheet that must be larger by more than this factor has no size.
_MOST_TIMES = 1e6
# Fold limits are looked for down to this.
_LEAST_LIMIT_DEG = 1e-3


class Feasibility:
    """Which faces of a pattern can have a panel, at any thickness, scale and fold limit.

    A panel that is feasible is so at every smaller thickness and fold limit, and at every larger
    scale.
    """

    def __init__(self, pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings) -> None:
        self.pattern, self.panel, self.hinge = pattern, panel, hinge
        self._sides = sides_of(pattern)
        self._convex = are_convex(self._sides.start, self._sides.offsets)

    def faces_feasible(
        self,
        thickness_mm: float | None = None,
        *,
        scale: float = 1.0,
        limit_deg: float | None = None,
    ) -> BoolArray:
        """Whether each face has a panel, shape (nf,).

        thickness_mm, limit_deg : those of the settings where left out. scale : of the pattern.
        """
        heights, back = self._limits(thickness_mm, limit_deg)
        start = scale * self._sides.start
        sides = replace(self._sides, start=start, length_mm=scale * self._sides.length_mm)
        radii = [inradii(sides, back.at(z)) for z in heights]
        fits: BoolArray = np.minimum(*radii) >= LEAST_RADIUS_MM
        if not self._convex.all():
            panels, _ = make_panels(scaled(self.pattern, factor=scale), heights, back)
            fits[~self._convex] = np.isin(np.flatnonzero(~self._convex), panels.faces)
        return fits

    def largest_thickness_mm(self, faces: IntArray | None = None) -> float | None:
        """The largest thickness, mm, at which some faces, or all, have a panel.

        At least what panels of such an axis and such hinges need, at most 1000 mm; None where no
        thickness between these helps.
        """
        chosen = self._chosen(faces)
        least = least_thickness_mm(self.panel, self.hinge)

        def holds(thickness_mm: float) -> bool:
            panel = self.panel.model_copy(update={"thickness_mm": thickness_mm})
            fits = hinges_fit(panel, self.hinge)
            return fits and bool(self.faces_feasible(thickness_mm)[chosen].all())

        return largest_where(holds, least, MOST_THICKNESS_MM)

    def largest_limit_deg(self, faces: IntArray | None = None) -> float | None:
        """The largest fold limit, degrees, at which some faces, or all, have a panel, or None.

        All creases with knuckles, where there are any, turn as far.
        """
        chosen = self._chosen(faces)
        knuckled = crease_kinds(self.pattern, self.hinge) == "knuckle"

        def holds(limit: float) -> bool:
            _, back = self._limits(limit_deg=limit)
            turns = knuckles_turn(back, self.hinge)[knuckled].all()
            return bool(turns and self.faces_feasible(limit_deg=limit)[chosen].all())

        return largest_where(holds, _LEAST_LIMIT_DEG, 180.0)

    def least_scale(
        self, thickness_mm: float | None = None, faces: IntArray | None = None
    ) -> float | None:
        """The smallest scale at which some faces, or all, have a panel, or None."""
        chosen = self._chosen(faces)
        scale = float(self.scales(thickness_mm)[self._convex & chosen].max(initial=0.0))
        if scale > _MOST_TIMES:
            return None
        if self._convex[chosen].all():
            return scale
        small = largest_where(
            lambda x: bool(self.faces_feasible(thickness_mm, scale=1 / x)[chosen].all()),
            1 / _MOST_TIMES,
            _MOST_TIMES,
        )
        return None if small is None else 1 / small

    def scales(self, thickness_mm: float | None = None) -> FloatArray:
        """The smallest scale for each convex face, shape (nf,); infinite where no size helps."""
        heights, back = self._limits(thickness_mm)
        out = scale_bounds(self._sides, back, heights, LEAST_RADIUS_MM)
        return np.where(out > _MOST_TIMES, np.inf, out)

    def overfolded(self, faces: IntArray) -> IntArray:
        """Creases of some faces that fold too far for any setback to leave room, rising."""
        heights, back = self._limits()
        far = np.maximum(*(back.at(z) for z in heights))
        own = np.isin(self._sides.faces, faces)
        longest = self._sides.length_mm[own].max(initial=0.0)
        edges = np.unique(self._sides.edges[own])
        over: IntArray = edges[far[edges] > _MOST_TIMES * longest]
        return over

    def lifted(self) -> Feasibility:
        """The same panels above their axes, by half of their clearance, without hinges."""
        below = {"axis": "offset", "axis_mm": -self.panel.clearance_mm / 2}
        panel = self.panel.model_copy(update=below)
        return Feasibility(self.pattern, panel, HingeSettings(kind="none"))

    def _chosen(self, faces: IntArray | None) -> BoolArray:
        chosen = np.full(len(self._convex), faces is None)
        if faces is not None:
            chosen[faces] = True
        return chosen

    def _limits(
        self, thickness_mm: float | None = None, limit_deg: float | None = None
    ) -> tuple[tuple[float, float], Setbacks]:
        given = {"thickness_mm": thickness_mm, "fold_limit_deg": limit_deg}
        changes = {key: value for key, value in given.items() if value is not None}
        return heights_and_setbacks(self.pattern, self.panel.model_copy(update=changes), self.hinge)


def inspect_feasibility(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings, faces: IntArray
) -> list[Finding]:
    """Findings of convex faces that have no panel, with what would save them.

    faces : those that have one.
    """
    sides = sides_of(pattern)
    lost = are_convex(sides.start, sides.offsets)
    lost[faces] = False
    if not lost.any():
        return []
    feasibility = Feasibility(pattern, panel, hinge)
    hopeless = lost & np.isinf(feasibility.scales())
    findings = []
    for code, chosen, described in (
        ("fold-too-far", np.flatnonzero(hopeless), _overfolded),
        ("panel-vanishes", np.flatnonzero(lost & ~hopeless), _vanished),
    ):
        if len(chosen):
            text, creases = described(feasibility, chosen)
            named = first_few(creases), first_few(chosen)
            findings.append(Finding(code, Severity.ERROR, text, *named))
    return findings


def _vanished(feasibility: Feasibility, faces: IntArray) -> tuple[str, IntArray]:
    """The largest thickness and the smallest sheet with which all of some convex faces have one."""
    thickness = feasibility.largest_thickness_mm(faces)
    scales = feasibility.scales()[faces]
    cures = []
    # rounded to the safe side, and still thick enough for the hinges
    least = least_thickness_mm(feasibility.panel, feasibility.hinge)
    thick = thickness is not None and float(rounded_down(thickness)) >= least
    if thickness is not None and thick:
        cures.append(f"thickness_mm at most {rounded_down(thickness)}")
    cures.append(f"a sheet at least {rounded_up(scales.max())} times as large")
    several = len(faces) > 1
    text = (
        f"{counted(len(faces), 'face has', 'faces have')} no panel: the setbacks of "
        f"{'their' if several else 'its'} creases leave nothing of {'them' if several else 'it'}. "
        f"{'All of them have' if several else 'It has'} one with {', or '.join(cures)}."
    )
    if several:
        text += f" Face {faces[scales.argmax()]} needs most."
    if not thick:
        text += " No thickness that its hinges allow helps; lower gap_mm, clearance_mm or "
        text += "fold_limit_deg."
    return text, np.empty(0, np.int64)


def _overfolded(feasibility: Feasibility, faces: IntArray) -> tuple[str, IntArray]:
    """Creases that fold too far at every size, and the largest angle that can be reached."""
    creases = feasibility.overfolded(faces)
    angles = feasibility.pattern.edges_foldAngle[creases]
    limit = feasibility.largest_limit_deg(faces)
    text = (
        f"{counted(len(creases), 'crease folds', 'creases fold')} too far for panels, by up to "
        f"{np.abs(angles).max(initial=0.0):.7g} degrees: no setback leaves room between panels "
        "with their axis between them. "
        f"{counted(len(faces), 'face', 'faces')} beside them "
        f"{'has' if len(faces) == 1 else 'have'} no panel at any size. "
    )
    cures = []
    if limit is None:
        text += (
            "As given no fold_limit_deg helps: lower thickness_mm or gap_mm, or enlarge the sheet."
        )
    else:
        cures.append(f"set panels.fold_limit_deg to at most {rounded_down(limit)}")
    lifted = feasibility.lifted()
    if (angles < 0).all() and lifted.faces_feasible()[faces].all():
        bare = "" if set(feasibility.hinge.kinds) == {"none"} else " and hinges.kind = none"
        cures.append(
            "lift the panels off the axes of these mountains, with panels.axis = offset, "
            f"panels.axis_mm = {lifted.panel.axis_mm:g}{bare}"
        )
    if cures:
        text += f"All of them have one if you {', or '.join(cures)}."
    return text, creases
