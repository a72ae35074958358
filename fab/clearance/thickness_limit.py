"""The largest thickness at which no panels of a sheet overlap in a folded state.

Thinner panels lie within thicker ones, unless knuckles set these back farther. So the pairs that
overlap at one thickness are all that can overlap below it, and the bound is found by bisection.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fab.clearance.checked_bodies import checked_bodies
from fab.clearance.pair_checks import check_pairs
from fab.folding.folded_states import (
    FoldedState,
    Stage,
    folded_states,
    known_target,
    states_within,
)
from fab.folding.last_states import with_state_at_limit
from fab.geometry.booleans import manifolds
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings, least_thickness_mm
from fab.panels.inset_limits import largest_where
from fab.panels.thick_sheet import ThickSheet, rigid_sheet
from fab.pattern.crease_pattern import CreasePattern, scaled
from fab.progress import Progress, silent
from solver.vectors import IntArray

__all__ = ["Collisions", "clear_up_to", "collisions"]


@dataclass(frozen=True)
class Collisions:
    """Whether panels overlap at the target, for any thickness, in mm, and scale of the sheet.

    Called with a thickness, it is `clear_up_to` there. target : the state, for the scale 1; found
    when it is first needed.
    """

    pattern: CreasePattern
    panel: PanelSettings
    hinge: HingeSettings
    target: Callable[[], FoldedState]

    def __call__(self, thickness_mm: float) -> float | None:
        return clear_up_to(self.pattern, self._panel(thickness_mm), self.hinge, self.target())

    def free(self, thickness_mm: float, scale: float) -> bool:
        """Whether no panels overlap at a scale, more deeply than faces that bend explain."""
        state = self.target()
        larger = replace(state, shifts=scale * state.shifts, bend_mm=scale * state.bend_mm)
        pattern = scaled(self.pattern, factor=scale)
        sheet, _ = rigid_sheet(pattern, self._panel(thickness_mm), self.hinge)
        return not len(_overlapping(sheet, larger))

    def _panel(self, thickness_mm: float) -> PanelSettings:
        return self.panel.model_copy(update={"thickness_mm": thickness_mm})


def collisions(
    pattern: CreasePattern,
    panel: PanelSettings,
    hinge: HingeSettings,
    progress: Progress = silent,
    states: Sequence[FoldedState] | None = None,
) -> Collisions:
    """Whether panels overlap at the target of a pattern.

    The target is the folded form of the pattern or of its angles; where the fold limit of the
    panels stops the sheet before it, or there is no such form, it is the last state of the
    simulated fold that is within the limit. States are simulated when the function is first called.

    states : of the pattern, where they are known. Raises `InvalidJob` where panels cannot have such
    hinges.
    """

    @cache
    def target() -> FoldedState:
        faces, limit = np.arange(pattern.face_count), panel.fold_limit_deg
        known = known_target(pattern) if states is None else None
        if known is not None and not len(states_within(pattern, faces, [known], limit)[1]):
            return known
        every = folded_states(pattern, progress=progress)[0] if states is None else states
        every = with_state_at_limit(pattern, faces, every, limit)
        within = states_within(pattern, faces, every, limit)[0]
        return next((s for s in reversed(within) if s.stage != Stage.BETWEEN), within[-1])

    return Collisions(pattern, panel, hinge, target)


def clear_up_to(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings, state: FoldedState
) -> float | None:
    """The largest thickness, mm, at most that of the panels, at which none overlap in a state.

    Overlaps count that are deeper than faces that bend explain. None where some overlap at every
    thickness. Exact to 1e-9 of itself.

    Raises `InvalidJob` where panels cannot have such hinges.
    """

    def overlapping(thickness_mm: float, among: IntArray | None = None) -> IntArray:
        given = panel.model_copy(update={"thickness_mm": thickness_mm})
        return _overlapping(rigid_sheet(pattern, given, hinge)[0], state, among)

    least, most = least_thickness_mm(panel, hinge), panel.thickness_mm
    suspects = found = overlapping(most)
    while len(found):
        among = suspects
        below = largest_where(lambda t: not len(overlapping(t, among)), least, most)  # noqa: B023
        if below is None:
            return None
        # panels that come back when thinner, or nearer to others, may overlap as well
        most, found = below, overlapping(below)
        suspects = np.union1d(suspects, found)
    return most


def _overlapping(sheet: ThickSheet, state: FoldedState, among: IntArray | None = None) -> IntArray:
    """Faces whose panels overlap others, rising. among : the only faces to check."""
    if among is not None:
        sheet = _only(sheet, among)
    if len(sheet.bodies) < 2:
        return np.empty(0, np.int64)
    every = np.arange(len(sheet.bodies))
    check = check_pairs(sheet, checked_bodies(sheet, manifolds(sheet.bodies), every), state)
    rows = check.overlapping
    return np.unique(check.faces[check.pairs[rows[check.deep[rows]]]])


def _only(sheet: ThickSheet, faces: IntArray) -> ThickSheet:
    """The panels of some faces."""
    chosen = np.flatnonzero(np.isin(sheet.faces, faces))
    bodies = sheet.bodies.chosen(chosen)
    return replace(
        sheet,
        bodies=bodies,
        names=tuple(sheet.names[body] for body in chosen.tolist()),
        faces=sheet.faces[chosen],
        creases=sheet.creases[chosen],
        flexible=sheet.flexible[chosen],
        joining=bodies,
    )
