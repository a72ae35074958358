"""Findings of faces that have no panel, with the thickness, size or fold limit that saves them."""

from __future__ import annotations

import numpy as np

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.rings import are_convex
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.feasibility import SLIVERS_REL, Feasibility
from fab.panels.hinges import HingeSettings, least_thickness_mm
from fab.panels.inset_limits import rounded_down, rounded_up
from fab.panels.setbacks import sides_of
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import IntArray

__all__ = ["inspect_feasibility", "lifting"]


# Advice without slivers is given where it is better by this factor.
_BETTER = 1.1
_TOO_THICK = (
    " No thickness that its hinges allow helps; lower gap_mm, clearance_mm or fold_limit_deg."
)


def inspect_feasibility(
    pattern: CreasePattern,
    panel: PanelSettings,
    hinge: HingeSettings,
    faces: IntArray,
    least_width_mm: float = 0.0,
) -> list[Finding]:
    """Findings of convex faces that have no panel, with what would save them.

    Slivers, faces of up to 1 % of the area of the sheet together, are a warning: they stay open.

    faces : those that have a panel. least_width_mm : that advice leaves to panels.
    """
    sides = sides_of(pattern)
    lost = are_convex(sides.start, sides.offsets)
    lost[faces] = False
    if not lost.any():
        return []
    feasibility = Feasibility(pattern, panel, hinge, least_width_mm)
    hopeless = lost & np.isinf(feasibility.scales())
    vanished = np.flatnonzero(lost & ~hopeless)
    findings = []
    if hopeless.any():
        chosen = np.flatnonzero(hopeless)
        text, creases = _overfolded(feasibility, chosen)
        named = first_few(creases), first_few(chosen)
        findings.append(Finding("fold-too-far", Severity.ERROR, text, *named))
    if len(vanished):
        small = not hopeless.any() and feasibility.faces_share[vanished].sum() <= SLIVERS_REL
        severity = Severity.WARNING if small else Severity.ERROR
        text = (_slivers if small else _vanished)(feasibility, vanished)
        findings.append(Finding("panel-vanishes", severity, text, panels=first_few(vanished)))
    return findings


def _slivers(feasibility: Feasibility, faces: IntArray) -> str:
    """What becomes of faces that are a small part of the sheet, and what would save them."""
    share, several = feasibility.faces_share[faces].sum(), len(faces) > 1
    cures, thick = _cures(feasibility, faces)
    text = (
        f"{counted(len(faces), 'face has', 'faces have')} no panel, {_percent(share)} of the "
        f"sheet's area: {'they stay' if several else 'it stays'} open, as a part of the gaps "
        f"around {'them' if several else 'it'}. {'All of them have' if several else 'It has'} one "
        f"with {', or '.join(cures)}."
    )
    return text if thick else text + _TOO_THICK


def _vanished(feasibility: Feasibility, faces: IntArray) -> str:
    """The largest thickness and the smallest sheet with which all of some convex faces have one."""
    scales = feasibility.scales()[faces]
    cures, thick = _cures(feasibility, faces)
    several = len(faces) > 1
    text = (
        f"{counted(len(faces), 'face has', 'faces have')} no panel: the setbacks of "
        f"{'their' if several else 'its'} creases leave nothing of {'them' if several else 'it'}. "
        f"{'All of them have' if several else 'It has'} one with {', or '.join(cures)}."
    )
    if several:
        text += f" Face {faces[scales.argmax()]} needs most."
    if not thick:
        text += _TOO_THICK
    rest = feasibility.least_scale(faces=faces, spare_rel=SLIVERS_REL)
    if rest is not None and scales.max() > _BETTER * rest:
        needy = faces[scales > rest]
        rest_cures, _ = _cures(feasibility, faces, SLIVERS_REL)
        text += (
            f" Without {_those(feasibility, needy)} the others have one with "
            f"{', or '.join(rest_cures)}."
        )
    return text


def _cures(
    feasibility: Feasibility, faces: IntArray, spare_rel: float = 0.0
) -> tuple[list[str], bool]:
    """Thickness and size with which faces have a panel, rounded to the safe side.

    spare_rel : share of the sheet's area that may be without. Also whether there is a thickness.
    """
    thickness = feasibility.largest_thickness_mm(faces, spare_rel=spare_rel)
    scale = feasibility.least_scale(faces=faces, spare_rel=spare_rel)
    # still thick enough for the hinges
    least = least_thickness_mm(feasibility.panel, feasibility.hinge)
    thick = thickness is not None and float(rounded_down(thickness)) >= least
    cures = []
    if thickness is not None and thick:
        cures.append(f"thickness_mm at most {rounded_down(thickness)}")
    if scale is not None:
        cures.append(f"a sheet at least {rounded_up(scale)} times as large")
    return cures, thick


def _those(feasibility: Feasibility, faces: IntArray) -> str:
    """Slivers by number and share, such as "face 7 (0.2 % of the area)"."""
    share = _percent(feasibility.faces_share[faces].sum())
    if len(faces) == 1:
        return f"face {faces[0]} ({share} of the sheet's area)"
    named = ", ".join(str(face) for face in faces[:3].tolist())
    more = ", ..." if len(faces) > 3 else ""
    return f"{len(faces)} faces ({named}{more}; {share} of the sheet's area)"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"


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
    rest = feasibility.largest_limit_deg(faces, spare_rel=SLIVERS_REL)
    lifted = lifting(feasibility, faces)
    if lifted:
        cures.append(lifted)
    if cures:
        text += f"All of them have one if you {', or '.join(cures)}."
    if rest is not None and rest > _BETTER * (limit or 0.0):
        fits = feasibility.faces_feasible(limit_deg=rest)
        needy = faces[~fits[faces]]
        text += (
            f" Without {_those(feasibility, needy)} the others have one with fold_limit_deg at "
            f"most {rounded_down(rest)}."
        )
    return text, creases


def lifting(feasibility: Feasibility, faces: IntArray) -> str:
    """How to lift panels off the axes of mountains, where faces have one then; else empty."""
    creases = feasibility.overfolded(faces)
    lifted = feasibility.lifted()
    mountains = bool((feasibility.pattern.edges_foldAngle[creases] < 0).all())
    if not mountains or not lifted.faces_feasible()[faces].all():
        return ""
    bare = "" if set(feasibility.hinge.kinds) == {"none"} else " and hinges.kind = none"
    return (
        "lift the panels off the axes of these mountains, with panels.axis = offset, "
        f"panels.axis_mm = {lifted.panel.axis_mm:g}{bare}"
    )
