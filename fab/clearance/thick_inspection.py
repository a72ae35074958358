"""Are all bodies sound, do they stay apart flat, folded and on the way, and can they be printed?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fab.clearance.pair_checks import OVERLAP_MM3, PairCheck, check_pairs, thick_bodies
from fab.clearance.soundness import held_together, inspect_joined, inspect_soundness
from fab.clearance.thickness_limit import clear_up_to
from fab.errors import Finding, Severity
from fab.folding.folded_states import FoldedState, Stage, states_within
from fab.geometry.bodies import TriangleMesh
from fab.geometry.booleans import manifolds
from fab.panels.inset_limits import rounded_down
from fab.panels.thick_sheet import ThickSheet
from fab.printing.printability import bed_area_mm2, inspect_print, inspect_webs
from fab.printing.printers import Printer, PrintMaterial
from solver.vectors import IntArray

__all__ = ["SolidFigures", "StateFigures", "inspect_thick"]

# Panels without a common crease are close at less than this share of the least promised distance.
_CLOSE = 0.5
# Faces that bend by less are flat.
_BENT_MM = 1e-3
_NAMED = 10


@dataclass(frozen=True)
class StateFigures:
    """What was measured in one state.

    Attributes
    ----------
    state : its name; share : of the target fold angles.
    pairs_checked : pairs of bodies with a common crease, or near each other.
    overlap_max_mm3 : largest common volume of two bodies.
    clearance_min_mm : least distance of two panels; None where there are not two near each other.
    closest : the names of these two.
    """

    state: str
    share: float
    pairs_checked: int
    overlap_max_mm3: float
    clearance_min_mm: float | None
    closest: tuple[str, ...]


@dataclass(frozen=True)
class SolidFigures:
    """What the check of the bodies measured.

    Attributes
    ----------
    panels : number of them; hinges : creases at which two of them hold together, by any hinge.
    bodies : number of pieces after joining.
    volume_mm3, flexible_mm3 : of all solids together, and of those that bend.
    mass_g : of all solids in the print material; None without one.
    bed_area_mm2 : of the sides that lie on the printer's bed.
    pairs_checked, overlap_max_mm3 : over all states.
    clearance_min_mm : least distance of two panels in any state; None where there are not two.
    states : figures of every state, the flat one first.
    """

    panels: int
    hinges: int
    bodies: int
    volume_mm3: float
    flexible_mm3: float
    mass_g: float | None
    bed_area_mm2: float
    pairs_checked: int
    overlap_max_mm3: float
    clearance_min_mm: float | None
    states: tuple[StateFigures, ...]


def inspect_thick(
    sheet: ThickSheet,
    joined: TriangleMesh,
    states: Sequence[FoldedState],
    *,
    limit_deg: float = 180.0,
    printer: Printer | None = None,
    material: PrintMaterial | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[SolidFigures, list[Finding]]:
    """Check every body, all pairs of bodies in every state, and whether a printer can print them.

    states : of the sheet's pattern, the flat one first (`fab.states`). From the first one on in
    which a crease is folded over limit_deg, for which panels are not made, they are left out, and
    the last one before counts as the target. material : of all bodies. progress : called with
    (stage, steps done, steps in the stage).

    Bodies that bend are checked flat alone.
    """
    tell = progress if progress is not None else lambda *_: None
    solids = manifolds(sheet.bodies)
    findings = [*inspect_soundness(sheet, solids), *inspect_joined(sheet, joined)]
    parts = held_together(sheet)
    pieces = len(np.unique(sheet.pattern.faces_piece[sheet.panels.faces]))
    if parts > pieces:
        findings.append(_loose(parts, pieces))
    reached, beyond = states_within(sheet.pattern, sheet.panels.faces, states, limit_deg)
    if len(beyond):
        findings.append(_blocked(states, reached, beyond, limit_deg))
    every = thick_bodies(sheet, solids, np.arange(len(sheet.bodies)))
    rigid = thick_bodies(sheet, solids, sheet.rigid)
    checks: list[PairCheck] = []
    for number, state in enumerate(reached):
        tell("clearance", number, len(reached))
        checks.append(check_pairs(sheet, every if state.stage == Stage.FLAT else rigid, state))
    tell("clearance", len(reached), len(reached))
    for check in checks:
        if check.state.stage != Stage.BETWEEN:
            findings += _reported(sheet, check)
    findings += _jammed(sheet, [check for check in checks if check.state.stage == Stage.BETWEEN])
    if printer is not None:
        findings += inspect_print(sheet, joined, printer)
    if material is not None:
        findings += inspect_webs(sheet, material, limit_deg)
    return _figures(sheet, joined, parts, [_measured(c) for c in checks], material), findings


def _figures(
    sheet: ThickSheet,
    joined: TriangleMesh,
    parts: int,
    states: list[StateFigures],
    material: PrintMaterial | None,
) -> SolidFigures:
    volumes = sheet.bodies.volumes_mm3()
    total = float(volumes.sum())
    count = len(sheet.panels.bodies)
    return SolidFigures(
        count,
        len(sheet.held),
        parts,
        total,
        float(volumes[sheet.flexible].sum()),
        None if material is None else total * material.density_kg_m3 * 1e-6,
        bed_area_mm2(joined),
        sum(state.pairs_checked for state in states),
        max((state.overlap_max_mm3 for state in states), default=0.0),
        min((s.clearance_min_mm for s in states if s.clearance_min_mm is not None), default=None),
        tuple(states),
    )


def _loose(parts: int, pieces: int) -> Finding:
    return Finding(
        "panels-loose",
        Severity.ERROR,
        f"The panels are joined into {parts} bodies, not {pieces}: some have no hinge. "
        "Lower gap_mm or relief_mm, or enlarge the sheet.",
    )


def _blocked(
    states: Sequence[FoldedState],
    reached: Sequence[FoldedState],
    beyond: IntArray,
    limit_deg: float,
) -> Finding:
    share = reached[-1].share if reached else 0.0
    following = float(np.abs(states[len(reached)].angles_deg[beyond]).max())
    angle = float(np.abs(states[-1].angles_deg[beyond]).max())
    return Finding(
        "fold-blocked",
        Severity.WARNING,
        f"panels fold to {share:.0%} of the target, checked up to there: beyond, {len(beyond)} "
        f"creases fold over fold_limit_deg = {limit_deg:g} degrees ({following:.4g} in the next "
        f"state that is known, {angle:.4g} at the end). Raise fold_limit_deg where the panels "
        "allow it, or give a pattern that folds less.".replace("%", " %"),
        creases=tuple(beyond[:20].tolist()),
    )


def _measured(check: PairCheck) -> StateFigures:
    closest = check.closest
    names: tuple[str, ...] = ()
    clear = None
    if closest is not None:
        clear = float(check.apart_mm[closest])
        names = tuple(check.names[body] for body in check.pairs[closest])
    return StateFigures(
        check.state.name,
        check.state.share,
        len(check.pairs),
        float(check.overlap_mm3.max(initial=0.0)),
        clear,
        names,
    )


def _too_near(check: PairCheck) -> IntArray:
    """Panels across a crease that are nearer than promised, without overlapping."""
    near = ~check.may_touch & (check.edges >= 0) & (check.apart_mm < check.wanted_mm)
    return np.flatnonzero(near & (check.overlap_mm3 <= OVERLAP_MM3))


def _close(check: PairCheck) -> IntArray:
    """Other panels that come closer than all creases do, or touch, without overlapping."""
    other = ~check.may_touch & (check.edges < 0) & (check.overlap_mm3 <= OVERLAP_MM3)
    return np.flatnonzero(other & (check.apart_mm < _CLOSE * check.wanted_mm))


def _named(
    sheet: ThickSheet, check: PairCheck, pair: int
) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
    """Both bodies in words, their panels and their crease."""
    one, two = check.pairs[pair].tolist()
    panels = tuple(int(f) for f in check.faces[[one, two]] if f >= 0)
    text = f"{check.names[one]} and {check.names[two]}"
    edge = int(check.edges[pair])
    if edge < 0:
        return text, panels, ()
    there, end = check.state.angles_deg[edge], sheet.pattern.edges_foldAngle[edge]
    text += f" across crease {edge} (at {there:.4g} degrees, made for {end:.4g})"
    return text, panels, (edge,)


def _reported(sheet: ThickSheet, check: PairCheck) -> list[Finding]:
    """Findings of the flat state and of the target: the worst pairs of each kind."""
    overlaps = check.overlapping
    cure = _cure(sheet, check) if len(overlaps) else ""
    near, close = (
        rows[np.argsort(check.apart_mm[rows], kind="stable")]
        for rows in (_too_near(check), _close(check))
    )
    findings = []
    for code, severity, rows, advice in (
        ("solids-overlap", Severity.ERROR, overlaps, cure),
        ("clearance-too-small", Severity.ERROR, near, "Raise gap_mm, or enlarge the sheet."),
        ("panels-close", Severity.WARNING, close, "Raise gap_mm, or lower thickness_mm."),
    ):
        for row in rows[:_NAMED].tolist():
            text, panels, creases = _named(sheet, check, row)
            if code == "solids-overlap":
                shared, depth = check.overlap_mm3[row], check.depth_mm[row]
                measure = f"share {shared:.3g} mm3, up to {depth:.3g} mm deep"
                # faces that bend may have more room than the rigid ones nearest to them
                severity = Severity.ERROR if check.deep[row] else Severity.WARNING
                bend = check.state.bend_mm
                if bend > _BENT_MM:
                    measure += f", where rigid panels lie up to {bend:.3g} mm off the bent faces"
            elif code == "clearance-too-small":
                measure = f"are {check.apart_mm[row]:.4g} mm apart, not {check.wanted_mm[row]:.4g}"
            else:
                measure = f"are {check.apart_mm[row]:.4g} mm apart, without a common crease"
            more = f" (one of {len(rows)} pairs)" if len(rows) > _NAMED else ""
            findings.append(
                Finding(
                    code,
                    severity,
                    f"{check.state.name}: {text} {measure}{more}. {advice}",
                    creases,
                    panels,
                )
            )
    return findings


def _cure(sheet: ThickSheet, check: PairCheck) -> str:
    """What keeps panels that overlap in a state apart: how thin they must be."""
    if check.state.stage == Stage.FLAT:
        return "The flat sheet overlaps itself, or its faces are too thin for their gaps."
    given = sheet.panel.thickness_mm
    bound = clear_up_to(sheet.pattern, sheet.panel, sheet.hinge, check.state)
    if bound is None:
        return "They do at every thickness that such hinges allow: fold less, or raise gap_mm."
    if bound == given:
        return "Raise gap_mm or clearance_mm, or fold less."
    return (
        f"No panels overlap with thickness_mm at most {rounded_down(bound)}; or raise gap_mm, or "
        "fold less."
    )


def _jammed(sheet: ThickSheet, checks: Sequence[PairCheck]) -> list[Finding]:
    """One finding for all overlaps on the way, and one for all that come too near."""
    findings = []
    deep = [
        (float(check.depth_mm[row]), check, row)
        for check in checks
        for row in np.flatnonzero(check.overlap_mm3 > OVERLAP_MM3).tolist()
    ]
    if deep:
        depth, check, row = max(deep, key=lambda item: item[0])
        text, panels, creases = _named(sheet, check, row)
        findings.append(
            Finding(
                "panels-jam",
                Severity.WARNING,
                f"panels jam between flat and the target: {_states(deep)}. Worst are {text}, up to "
                f"{depth:.3g} mm deep {check.state.name}, where rigid panels lie up to "
                f"{check.state.bend_mm:.3g} mm off the simulated sheet: they bend by as much, or "
                "do not pass. Raise gap_mm or lower thickness_mm.",
                creases,
                panels,
            )
        )
    near = [
        (float(check.wanted_mm[row] - check.apart_mm[row]), check, row)
        for check in checks
        for row in _too_near(check).tolist()
    ]
    if near:
        _, check, row = max(near, key=lambda item: item[0])
        text, panels, creases = _named(sheet, check, row)
        findings.append(
            Finding(
                "clearance-between",
                Severity.WARNING,
                f"panels come nearer on the way than at its ends: {_states(near)}. Worst are "
                f"{text}, {check.apart_mm[row]:.4g} mm apart {check.state.name}, where rigid "
                f"panels lie up to {check.state.bend_mm:.3g} mm off the simulated sheet. "
                "Raise gap_mm.",
                creases,
                panels,
            )
        )
    return findings


def _states(found: Sequence[tuple[float, PairCheck, int]]) -> str:
    """How many pairs, and in which states."""
    counts: dict[str, int] = {}
    for _, check, _ in found:
        counts[check.state.name] = counts.get(check.state.name, 0) + 1
    return ", ".join(f"{count} pairs {name}" for name, count in counts.items())
