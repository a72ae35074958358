"""Inspection of a thick sheet: whether its bodies are sound, and stay apart flat and folded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fab.clearance.checked_bodies import checked_bodies
from fab.clearance.pair_checks import PairCheck, check_pairs
from fab.clearance.pair_findings import pair_findings
from fab.clearance.soundness import SolidFigures, inspect_solids
from fab.errors import Finding, Severity, counted, first_few
from fab.folding.folded_states import FoldedState, Stage, states_within
from fab.folding.last_states import last_state, states_between
from fab.geometry.bodies import TriangleMesh
from fab.geometry.booleans import manifolds
from fab.panels.thick_sheet import ThickSheet
from fab.progress import Progress, silent
from solver.vectors import IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = [
    "ClearanceFigures",
    "StateFigures",
    "ThickFigures",
    "inspect_clearance",
    "inspect_thick",
]

# Halvings of the part of a fold in which panels begin to jam.
_HALVINGS = 10


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
class ClearanceFigures:
    """What was measured of pairs of bodies.

    Attributes
    ----------
    pairs_checked, overlap_max_mm3 : over all states.
    clearance_min_mm : least distance of two panels in any state; None where there are not two.
    states : figures of every state, the flat one first.
    """

    pairs_checked: int
    overlap_max_mm3: float
    clearance_min_mm: float | None
    states: tuple[StateFigures, ...]


@dataclass(frozen=True)
class ThickFigures:
    """What the inspection of a thick sheet measured: of its bodies, and of pairs of them."""

    solids: SolidFigures
    clearance: ClearanceFigures


def inspect_thick(
    sheet: ThickSheet,
    joined: TriangleMesh,
    states: Sequence[FoldedState],
    *,
    limit_deg: float = 180.0,
    limit_given: bool = True,
    least_gap_mm: float | None = None,
    progress: Progress = silent,
) -> tuple[ThickFigures, list[Finding]]:
    """Check every body of a sheet, and all pairs of them in every state.

    joined : the surface of all bodies. states, limit_deg, limit_given, least_gap_mm, progress : as
    in `inspect_clearance`.
    """
    solids = manifolds(sheet.bodies)
    figures, findings = inspect_solids(sheet, solids, joined)
    clearance, found = inspect_clearance(
        sheet,
        solids,
        states,
        limit_deg=limit_deg,
        limit_given=limit_given,
        least_gap_mm=least_gap_mm,
        progress=progress,
    )
    return ThickFigures(figures, clearance), [*findings, *found]


def inspect_clearance(
    sheet: ThickSheet,
    solids: list[Manifold],
    states: Sequence[FoldedState],
    *,
    limit_deg: float = 180.0,
    limit_given: bool = True,
    least_gap_mm: float | None = None,
    progress: Progress = silent,
) -> tuple[ClearanceFigures, list[Finding]]:
    """Check all pairs of bodies in every state; those that bend when flat alone.

    solids : the bodies of the sheet as manifold3d solids. states : of the sheet's pattern, the flat
    one first (`fab.folding.folded_states`). From the first one on in which a crease is folded over
    limit_deg, for which panels are not made, they are left out, and the last one before counts as
    the target, if the limit was given: one that was found is no wish, and panels that jam before it
    stop there. least_gap_mm : between bodies, that the printer keeps open, where it is known.
    progress : called with (stage, steps done, steps in the stage).
    """
    reached, beyond = states_within(sheet.pattern, sheet.panels.faces, states, limit_deg)
    findings = []
    if len(beyond):
        findings = _blocked(states, reached, beyond, limit_deg, limit_given=limit_given)
        reached = reached if limit_given else list(states[: len(reached)])
    every = checked_bodies(sheet, solids, np.arange(len(sheet.bodies)))
    rigid = checked_bodies(sheet, solids, sheet.rigid)
    checks: list[PairCheck] = []
    for number, state in enumerate(reached):
        progress("clearance", number, len(reached))
        checks.append(check_pairs(sheet, every if state.stage == Stage.FLAT else rigid, state))
    progress("clearance", len(reached), len(reached))
    return _figures([_measured(check) for check in checks]), [
        *findings,
        *pair_findings(sheet, checks, least_gap_mm, _jammed_from(sheet, solids, reached, checks)),
    ]


def _jammed_from(
    sheet: ThickSheet,
    solids: list[Manifold],
    states: Sequence[FoldedState],
    checks: Sequence[PairCheck],
) -> float | None:
    """The share of the fold from which on panels overlap on their way; None where they do not."""
    jammed = (
        number
        for number, check in enumerate(checks)
        if check.state.stage == Stage.BETWEEN and len(check.overlapping)
    )
    first = next(jammed, None)
    if not first:  # none, or in the first state that is looked at
        return None
    check = checks[first]
    faces = check.faces[check.pairs[check.overlapping]]
    pairs = checked_bodies(sheet, solids, sheet.rigid[np.isin(sheet.faces[sheet.rigid], faces)])

    def apart(state: FoldedState) -> bool:
        return not len(check_pairs(sheet, pairs, state).overlapping)

    between = states_between(sheet.pattern)
    return last_state(between, states[first - 1], states[first], apart, _HALVINGS).share


def _figures(states: list[StateFigures]) -> ClearanceFigures:
    return ClearanceFigures(
        sum(state.pairs_checked for state in states),
        max((state.overlap_max_mm3 for state in states), default=0.0),
        min((s.clearance_min_mm for s in states if s.clearance_min_mm is not None), default=None),
        tuple(states),
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


def _blocked(
    states: Sequence[FoldedState],
    reached: Sequence[FoldedState],
    beyond: IntArray,
    limit_deg: float,
    *,
    limit_given: bool,
) -> list[Finding]:
    """The finding of a sheet whose creases fold over the limit of its panels.

    beyond : creases that do in the state after those that are reached.
    """
    share = reached[-1].share if reached else 0.0
    angle = float(np.abs(states[-1].angles_deg[beyond]).max())
    first = beyond[np.abs(reached[-1].angles_deg[beyond]).argmax()] if reached else beyond[0]
    others = len(beyond) - 1
    more = f" and {counted(others, 'more does', 'more do')} soon after" if others else ""
    cure = (
        "Raise fold_limit_deg where the panels allow it, or give a pattern that folds less."
        if limit_given
        else "Thinner panels or a larger sheet fold further."
    )
    text = (
        f"panels fold to {100 * share:.4g} % of the target, checked up to there: crease {first} "
        f"reaches fold_limit_deg = {limit_deg:g} degrees then{more}, on the way to {angle:.4g} at "
        f"the end. {cure}"
    )
    return [Finding("fold-blocked", Severity.WARNING, text, creases=first_few(beyond))]
