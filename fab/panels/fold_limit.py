"""The largest fold limit at which a sheet of thick panels can be made.

Where creases fold by 180 degrees, or nearly, no setback leaves room between panels with their axis
between them: such panels fold as far as they can.
"""

from __future__ import annotations

import numpy as np

from fab.errors import Finding, Severity, counted, first_few
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.feasibility import SLIVERS_REL, Feasibility
from fab.panels.hinges import HingeSettings
from fab.panels.inset_limits import largest_where, rounded_down
from fab.panels.lost_faces import lifting
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import IntArray

__all__ = ["panels_within_reach", "reachable_limit_deg", "widest_gap_mm"]

# Faces without a panel on a sheet so many times as large are lost to folds, not to their size.
_LARGER = 10.0
# Slivers are given up, and hinges of short creases, where the others fold that much further.
_FURTHER = 1.5
# Panels go back from their axis for clearance no farther than to gaps so many times as wide: near
# 180 degrees they would lose most of their faces to it for a degree or two.
_WIDEST_GAP = 10.0
# Panels that fold by less are too thick for their sheet.
_HARDLY_DEG = 15.0
_LEAST_LIMIT_DEG = 1e-3
_EXACT = 1e-5


def panels_within_reach(
    pattern: CreasePattern,
    panel: PanelSettings,
    hinge: HingeSettings,
    least_width_mm: float = 0.0,
) -> tuple[PanelSettings, list[Finding]]:
    """Settings of panels whose creases fold as far as they can, and a finding that says how far.

    As they are where a fold limit is given, and where all faces have a panel on this sheet or on
    one 10 times as large, or at no fold limit of 15 degrees or more.

    least_width_mm : of panels, at their bottom and top.
    """
    if "fold_limit_deg" in panel.model_fields_set:
        return panel, []
    feasibility = Feasibility(pattern, panel, hinge, least_width_mm)
    lost = ~feasibility.faces_feasible()
    if lost.any():
        lost &= ~feasibility.faces_feasible(scale=_LARGER)
    limit = reachable_limit_deg(feasibility) if lost.any() else None
    if limit is None or limit < _HARDLY_DEG:
        return panel, []
    made = panel.model_copy(update={"fold_limit_deg": limit})
    return made, [_limited(feasibility, np.flatnonzero(lost), limit)]


def widest_gap_mm(panel: PanelSettings) -> float:
    """How wide clearance may make the gaps of panels that fold as far as they can."""
    return max(panel.gap_mm, _WIDEST_GAP * panel.clearance_mm)


def reachable_limit_deg(feasibility: Feasibility) -> float | None:
    """The largest fold limit that works for a sheet, degrees, rounded down to four digits, or None.

    All faces have a panel and all creases between them their hinge, and no gap is wider than
    gap_mm, ten times clearance_mm, or what its hinge needs. Where without faces of up to 1 % of the
    area, or without hinges of creases whose panels others hold together, panels fold further by
    half or more, it is the largest for these.
    """
    widest = widest_gap_mm(feasibility.panel)
    whole = feasibility.largest_limit_deg(hinges=True, widest_mm=widest)
    rest = feasibility.largest_limit_deg(spare_rel=SLIVERS_REL, widest_mm=widest)
    if rest is not None and (whole is None or rest >= _FURTHER * whole):
        parts = feasibility.parts(_LEAST_LIMIT_DEG)
        rest = largest_where(
            lambda limit: feasibility.parts(limit) <= parts, _LEAST_LIMIT_DEG, rest, _EXACT
        )
        if rest is not None and (whole is None or rest >= _FURTHER * whole):
            whole = rest
    return None if whole is None else float(rounded_down(whole))


def _limited(feasibility: Feasibility, faces: IntArray, limit_deg: float) -> Finding:
    """How far panels fold in place of creases that fold too far. faces : beside these creases."""
    pattern = feasibility.pattern
    size = np.abs(pattern.edges_foldAngle)
    over = np.flatnonzero(pattern.edges_joining & (size > limit_deg))
    all_fit = feasibility.faces_feasible(limit_deg=limit_deg).all()
    most = feasibility.largest_limit_deg(hinges=True)
    wider = "panels.fold_limit_deg sets another."
    if most is not None and float(rounded_down(most)) > limit_deg:
        wider = f"With wider gaps it may be up to {rounded_down(most)}: set panels.fold_limit_deg."
    text = (
        f"{counted(len(over), 'crease folds', 'creases fold')} by up to "
        f"{size[over].max(initial=0.0):.7g} degrees, too far for panels with their axis between "
        f"them: panels are made for fold_limit_deg = {limit_deg:g}, the largest that leaves room "
        f"for {'all of them' if all_fit else 'all but slivers of them'} at their gaps. {wider}"
    )
    lifted = lifting(feasibility, faces)
    if lifted:
        text += f" To fold all the way, {lifted}."
    return Finding("fold-limited", Severity.WARNING, text, first_few(over))
