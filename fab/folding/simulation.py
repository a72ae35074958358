"""Does a pattern fold to its target?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from functools import partial

from fab.errors import Finding
from fab.folding.bar_hinge_model import framework
from fab.folding.dynamics import fold_dynamically
from fab.folding.fold_settings import FoldSettings
from fab.folding.folding_path import closing_way
from fab.folding.quasi_static import Folding, fold
from fab.folding.verdict import Verdict, findings_of, judge
from fab.pattern.crease_pattern import CreasePattern

__all__ = ["Solver", "simulated"]


# Ways of more hinges take minutes to find.
_MOST_HINGES = 2000


class Solver(StrEnum):
    """How the sheet is folded: from rest to rest, or by masses that move."""

    QUASI_STATIC = "quasi-static"
    DYNAMIC = "dynamic"


def simulated(
    pattern: CreasePattern,
    settings: FoldSettings,
    solver: Solver = Solver.QUASI_STATIC,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[Folding, Verdict, list[Finding]]:
    """Fold a pattern and judge it. Raises `InvalidValue` where it has no area.

    A sheet that locks when all its creases fold at once is folded again, in turn.
    """
    tell = progress if progress is not None else lambda *_: None
    frame = framework(pattern, settings)

    def step(done: int, total: int) -> None:
        tell("fold", done, total)

    if solver is Solver.DYNAMIC:
        folding = fold_dynamically(frame, settings.steps, progress=step)
    else:
        folding = fold(frame, settings.steps, step)
    tell("judge", 0, 1)
    verdict = judge(folding)
    tell("judge", 1, 1)
    if solver is Solver.QUASI_STATIC and verdict.locked and len(frame.hinges_edge) <= _MOST_HINGES:
        way = closing_way(frame, partial(tell, "order"))
        again = fold(frame, settings.steps, step, way.angles)
        judged = judge(again)
        solved = folding.iterations + way.iterations + again.iterations
        if judged.reached:
            folding, verdict = again, judged
        verdict = replace(verdict, iterations=solved)
    return folding, verdict, findings_of(verdict)
