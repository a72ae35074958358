"""Simulation of a crease pattern that folds from flat, with its verdict."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum
from functools import partial

from fab.errors import Finding
from fab.folding.bar_hinge_model import framework
from fab.folding.dynamics import fold_dynamically
from fab.folding.fold_settings import FoldSettings
from fab.folding.folding_path import closing_path
from fab.folding.quasi_static import Folding, fold
from fab.folding.verdict import Verdict, findings_of, judge
from fab.pattern.crease_pattern import CreasePattern
from fab.progress import Progress, silent

__all__ = ["Solver", "fold_and_judge"]


# Folding paths of more hinges take minutes to find.
_MOST_HINGES = 2000


class Solver(StrEnum):
    """How the sheet is folded: from rest to rest, or by masses that move."""

    QUASI_STATIC = "quasi-static"
    DYNAMIC = "dynamic"


def fold_and_judge(
    pattern: CreasePattern,
    settings: FoldSettings,
    solver: Solver = Solver.QUASI_STATIC,
    progress: Progress = silent,
) -> tuple[Folding, Verdict, list[Finding]]:
    """Fold a pattern from flat, and judge whether it reaches its target.

    A sheet that gets stuck when all its creases fold at once is folded again, along a folding path
    (up to 2,000 hinges, quasi-static only).

    pattern : in millimetres.
    progress : called with the stages "fold", "judge" and, for a folding path, "order".

    Raises `InvalidValue` for a sheet that is not from 1e-100 to 1e100 mm across, and for a face
    without area.
    """
    frame = framework(pattern, settings)
    if solver is Solver.DYNAMIC:
        folding = fold_dynamically(frame, settings.steps, progress=partial(progress, "fold"))
    else:
        folding = fold(frame, settings.steps, partial(progress, "fold"))
    progress("judge", 0, 1)
    verdict = judge(folding)
    progress("judge", 1, 1)
    stuck = solver is Solver.QUASI_STATIC and verdict.in_local_minimum
    if stuck and len(frame.hinges_edge) <= _MOST_HINGES:
        folding, verdict = _along_a_path(folding, verdict, settings.steps, progress)
    return folding, verdict, findings_of(verdict)


def _along_a_path(
    stuck: Folding, verdict: Verdict, steps: int, progress: Progress
) -> tuple[Folding, Verdict]:
    """The fold along a folding path, or the first one where that does not reach the target either.

    Iterations of the verdict are those of both folds and of the path.
    """
    path = closing_path(stuck.frame, partial(progress, "order"))
    again = fold(stuck.frame, steps, partial(progress, "fold"), path.angles)
    judged = judge(again)
    iterations = stuck.iterations + path.iterations + again.iterations
    if judged.reached:
        return again, replace(judged, iterations=iterations)
    return stuck, replace(verdict, iterations=iterations)
