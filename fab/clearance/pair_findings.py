"""Pairs of bodies that overlap or come too near in some states, as findings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fab.clearance.pair_checks import OVERLAP_MM3, PairCheck
from fab.clearance.thickness_limit import clear_up_to
from fab.errors import Finding, Severity, counted
from fab.folding.folded_states import Stage
from fab.panels.inset_limits import rounded_down
from fab.panels.thick_sheet import ThickSheet
from solver.vectors import BoolArray, IntArray

__all__ = ["pair_findings"]

# Panels without a common crease are close at less than this share of the least promised distance.
_CLOSE = 0.5
# Panels that are nearer than this touch.
_TOUCHING_MM = 1e-6
_ROUNDING_REL = 1e-6
# Faces that bend by less are flat.
_BENT_MM = 1e-3
# Pairs of each kind that have a finding of their own in one state.
_LISTED_PAIRS = 10


def pair_findings(
    sheet: ThickSheet,
    checks: Sequence[PairCheck],
    least_gap_mm: float | None = None,
    jammed_from: float | None = None,
) -> list[Finding]:
    """Findings of pairs in all states: one a pair when flat and at the target, the worst first.

    Between these states there is one finding for all overlaps, and one for all that is too near.
    least_gap_mm : that the printer keeps open, where it is known. jammed_from : the share of the
    fold from which on panels overlap on their way.
    """
    between = [check for check in checks if check.state.stage == Stage.BETWEEN]
    ends = [check for check in checks if check.state.stage != Stage.BETWEEN]
    findings = [finding for check in ends for finding in _of_state(sheet, check, least_gap_mm)]
    return [*findings, *_jams(sheet, between, jammed_from), *_near_between(sheet, between)]


def _of_state(sheet: ThickSheet, check: PairCheck, least_gap_mm: float | None) -> list[Finding]:
    """Findings of the flat state or of the target."""
    near, fused, close = (
        rows[np.argsort(check.apart_mm[rows], kind="stable")]
        for rows in (_too_near(check), *_close(sheet, check, least_gap_mm))
    )
    findings = _overlaps(sheet, check)
    for row in near[:_LISTED_PAIRS].tolist():
        code, cure = "clearance-too-small", "Raise gap_mm, or enlarge the sheet."
        measure = f"are {check.apart_mm[row]:.4g} mm apart, not {check.wanted_mm[row]:.4g}"
        findings.append(_finding(sheet, check, row, len(near), code, Severity.ERROR, measure, cure))
    for row in fused[:_LISTED_PAIRS].tolist():
        code, cure = "panels-touch", "Move them apart in the pattern, or join them by a crease."
        if _of_two_pieces(sheet, check)[row]:
            cure = "Move the pieces apart in the pattern, or name a printer: it sets them apart."
        measure = "touch without a common crease: they are printed as one"
        findings.append(
            _finding(sheet, check, row, len(fused), code, Severity.ERROR, measure, cure)
        )
    for row in close[:_LISTED_PAIRS].tolist():
        code, cure = "panels-close", "Raise gap_mm, or lower thickness_mm."
        measure = f"are {check.apart_mm[row]:.4g} mm apart, without a common crease"
        findings.append(
            _finding(sheet, check, row, len(close), code, Severity.WARNING, measure, cure)
        )
    return findings


def _overlaps(sheet: ThickSheet, check: PairCheck) -> list[Finding]:
    rows = check.overlapping
    cure = _cure(sheet, check) if len(rows) else ""
    bent = f", where rigid panels lie up to {check.state.bend_mm:.3g} mm off the bent faces"
    findings = []
    for row in rows[:_LISTED_PAIRS].tolist():
        shared, depth = check.overlap_mm3[row], check.depth_mm[row]
        measure = f"share {shared:.3g} mm3, up to {depth:.3g} mm deep"
        measure += bent if _bends(check) else ""
        # faces that bend may have more room than the rigid ones nearest to them
        severity = Severity.ERROR if check.deep[row] else Severity.WARNING
        findings.append(
            _finding(sheet, check, row, len(rows), "solids-overlap", severity, measure, cure)
        )
    return findings


def _finding(
    sheet: ThickSheet,
    check: PairCheck,
    row: int,
    count: int,
    code: str,
    severity: Severity,
    measure: str,
    cure: str,
) -> Finding:
    """The finding of one of `count` pairs."""
    text, panels, creases = _named(sheet, check, row)
    more = f" (one of {count} pairs)" if count > _LISTED_PAIRS else ""
    text = f"{check.state.name}: {text} {measure}{more}. {cure}"
    return Finding(code, severity, text, creases, panels)


def _too_near(check: PairCheck) -> IntArray:
    """Panels across a crease that are nearer than promised, without overlapping."""
    near = ~check.may_touch & (check.edges >= 0) & (check.apart_mm < check.wanted_mm)
    return np.flatnonzero(near & (check.overlap_mm3 <= OVERLAP_MM3))


def _close(
    sheet: ThickSheet, check: PairCheck, least_gap_mm: float | None
) -> tuple[IntArray, IntArray]:
    """Other panels that touch when flat, and those that come closer than all creases do."""
    other = ~check.may_touch & (check.edges < 0) & (check.overlap_mm3 <= OVERLAP_MM3)
    bound = _CLOSE * check.wanted_mm
    if check.state.stage != Stage.FLAT:
        return np.empty(0, np.int64), np.flatnonzero(other & (check.apart_mm < bound))
    if least_gap_mm is not None:  # pieces keep it by their places
        kept = np.minimum(least_gap_mm * (1 - _ROUNDING_REL), check.wanted_mm)
        bound = np.where(_of_two_pieces(sheet, check), kept, np.maximum(bound, kept))
    fused = other & (check.apart_mm <= _TOUCHING_MM)
    return np.flatnonzero(fused), np.flatnonzero(other & ~fused & (check.apart_mm < bound))


def _of_two_pieces(sheet: ThickSheet, check: PairCheck) -> BoolArray:
    """Whether the panels of each pair belong to different pieces of the sheet, shape (n,)."""
    first, second = sheet.pattern.faces_piece[check.faces[check.pairs]].T
    return np.asarray(first != second)


def _named(
    sheet: ThickSheet, check: PairCheck, pair: int
) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
    """Both bodies in words, their panels and their crease."""
    first, second = check.pairs[pair].tolist()
    panels = tuple(int(face) for face in check.faces[[first, second]] if face >= 0)
    text = f"{check.names[first]} and {check.names[second]}"
    edge = int(check.edges[pair])
    if edge < 0:
        return text, panels, ()
    limit = sheet.panel.fold_limit_deg
    angle, end = check.state.angles_deg[edge], sheet.pattern.edges_foldAngle[edge]
    end = min(max(end, -limit), limit)
    text += f" across crease {edge} (at {angle:.4g} degrees, made for {end:.4g})"
    return text, panels, (edge,)


def _cure(sheet: ThickSheet, check: PairCheck) -> str:
    """What keeps panels that overlap in a state apart: how thin they must be."""
    if check.state.stage == Stage.FLAT:
        return "The flat sheet overlaps itself, or its faces are too thin for their gaps."
    given = sheet.panel.thickness_mm
    bound = clear_up_to(sheet.pattern, sheet.panel, sheet.hinge, check.state)
    if bound is None:
        return (
            "Panels overlap at every thickness that these hinges allow: fold less, or raise gap_mm."
        )
    if bound == given:
        return "Raise gap_mm or clearance_mm, or fold less."
    bent = check.state.bend_mm > _BENT_MM
    beyond = " in this state by more than bent faces explain" if bent else ""
    return (
        f"No panels overlap{beyond} with thickness_mm at most {rounded_down(bound)}; or raise "
        "gap_mm, or fold less."
    )


def _jams(
    sheet: ThickSheet, checks: Sequence[PairCheck], jammed_from: float | None
) -> list[Finding]:
    """One finding for all overlaps between flat and the target."""
    deep = [
        (float(check.depth_mm[row]), check, row)
        for check in checks
        for row in np.flatnonzero(check.overlap_mm3 > OVERLAP_MM3).tolist()
    ]
    if not deep:
        return []
    depth, check, row = max(deep, key=lambda item: item[0])
    text, panels, creases = _named(sheet, check, row)
    begin = "" if jammed_from is None else f", from {100 * jammed_from:.4g} % of the fold on"
    return [
        Finding(
            "panels-jam",
            Severity.WARNING,
            f"panels jam between flat and the target{begin}: {_states(deep)}. Worst are {text}, "
            f"up to {depth:.3g} mm deep {check.state.name}, {_off_the_sheet(check)}: they "
            f"{'bend by as much, or ' if _bends(check) else ''}do not pass. Raise gap_mm, or lower "
            "thickness_mm or fold_limit_deg.",
            creases,
            panels,
        )
    ]


def _near_between(sheet: ThickSheet, checks: Sequence[PairCheck]) -> list[Finding]:
    """One finding for all that come too near between flat and the target."""
    near = [
        (float(check.wanted_mm[row] - check.apart_mm[row]), check, row)
        for check in checks
        for row in _too_near(check).tolist()
    ]
    if not near:
        return []
    _, check, row = max(near, key=lambda item: item[0])
    text, panels, creases = _named(sheet, check, row)
    return [
        Finding(
            "clearance-between",
            Severity.WARNING,
            f"panels come nearer between flat and the target than at either: {_states(near)}. "
            f"Worst are {text}, {check.apart_mm[row]:.4g} mm apart {check.state.name}, "
            f"{_off_the_sheet(check)}. Raise gap_mm.",
            creases,
            panels,
        )
    ]


def _bends(check: PairCheck) -> bool:
    """Whether faces have to bend in a state."""
    return check.state.bend_mm > _BENT_MM


def _off_the_sheet(check: PairCheck) -> str:
    """How far panels are from the faces of the simulated sheet in a state."""
    if not _bends(check):
        return "where no face bends"
    return f"where rigid panels lie up to {check.state.bend_mm:.3g} mm off the simulated sheet"


def _states(found: Sequence[tuple[float, PairCheck, int]]) -> str:
    """How many pairs, and in which states."""
    counts: dict[str, int] = {}
    for _, check, _ in found:
        counts[check.state.name] = counts.get(check.state.name, 0) + 1
    return ", ".join(f"{counted(count, 'pair')} {name}" for name, count in counts.items())
