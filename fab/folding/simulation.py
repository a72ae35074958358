"""Simulation of a crease pattern that folds from flat, with its verdict."""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum
from functools import partial

import numpy as np

from fab.errors import Finding, Severity
from fab.folding.bar_hinge_model import Framework, framework
from fab.folding.contact.past_contact import fold_past_contact
from fab.folding.dynamics import fold_dynamically
from fab.folding.fold_settings import FoldSettings
from fab.folding.folding_path import closing_path
from fab.folding.misplaced_vertices import (
    Misplaced,
    OpenVertex,
    misplaced_vertices,
    open_vertex,
)
from fab.folding.quasi_static import Checkpoint, Folding, fold
from fab.folding.rigid_findings import findings_of_fold
from fab.folding.rigid_folding import RigidFold, fold_rigidly
from fab.folding.rigid_motion import RigidMotion
from fab.folding.target_forms import inspect_form
from fab.folding.tolerance import Tolerance
from fab.folding.verdict import Verdict, findings_of, judge
from fab.pattern.crease_pattern import CreasePattern
from fab.progress import Progress, silent

__all__ = ["Solver", "fold_and_judge", "fold_rigidly_and_judge"]

# Folding paths of more hinges take minutes to find.
_MOST_HINGES = 2000
# Larger sheets are folded in contact only on request.
_MOST_HINGES_IN_CONTACT = 1000


class Solver(StrEnum):
    """How the sheet is folded: from rest to rest, by masses that move, or along a rigid motion."""

    QUASI_STATIC = "quasi-static"
    DYNAMIC = "dynamic"
    RIGID = "rigid"


def fold_and_judge(
    pattern: CreasePattern,
    settings: FoldSettings,
    solver: Solver = Solver.QUASI_STATIC,
    progress: Progress = silent,
    tolerance: Tolerance | None = None,
    checkpoint: Checkpoint | None = None,
) -> tuple[Folding, Verdict, list[Finding]]:
    """Fold a pattern from flat, and judge whether it reaches its target.

    By the first two solvers; the third is `fold_rigidly_and_judge`. A sheet that gets stuck when
    all its creases fold at once is folded again, along a folding path (up to 2,000 hinges,
    quasi-static only). With `settings.in_contact`, or where it is None and faces pass through each
    other, it is folded again in contact (`fab.folding.contact.past_contact`).

    pattern : in millimetres.
    tolerance : how exactly the target must be reached; by default 0.1 degrees.
    progress : called with the stages "fold", "judge", "order" for a folding path, and "contact".
    checkpoint : what keeps quasi-static folds, as for `fab.folding.quasi_static.fold`.

    Raises `InvalidValue` for a sheet that is not from 1e-100 to 1e100 mm across, and for a face
    without area.
    """
    tolerance = tolerance or Tolerance()
    frame = framework(pattern, settings)
    if solver is Solver.DYNAMIC:
        folding = fold_dynamically(frame, settings.steps, progress=partial(progress, "fold"))
    else:
        folding = fold(frame, settings.steps, partial(progress, "fold"), checkpoint=checkpoint)
    progress("judge", 0, 1)
    verdict = judge(folding, tolerance)
    progress("judge", 1, 1)
    stuck = solver is Solver.QUASI_STATIC and verdict.in_local_minimum
    if stuck and len(frame.hinges_edge) <= _MOST_HINGES:
        folding, verdict = _along_a_path(
            folding, verdict, settings.steps, progress, tolerance, checkpoint
        )
    held: list[Finding] = []
    if solver is Solver.QUASI_STATIC and _contact_wanted(settings, frame, verdict):
        folding, verdict, held = fold_past_contact(
            folding, verdict, settings, progress, tolerance, checkpoint
        )
    findings = [
        *inspect_form(frame, tolerance),
        *findings_of(verdict, tolerance, _misplaced(frame, verdict), _worst(frame, verdict)),
        *held,
        *_thickness_unused(settings, solver),
    ]
    return folding, verdict, findings


def _thickness_unused(settings: FoldSettings, solver: Solver) -> list[Finding]:
    """That a thickness is given of which a fold without contact knows nothing."""
    if not settings.thickness_mm or (solver is Solver.QUASI_STATIC and settings.in_contact):
        return []
    cure = "Leave out contact = false (--no-contact)."
    if solver is not Solver.QUASI_STATIC:
        cure = f"The {solver} solver folds without: take the quasi-static one."
    text = (
        f"thickness_mm = {settings.thickness_mm:g} is not used: it keeps layers apart in contact "
        f"alone. {cure}"
    )
    return [Finding("thickness-not-used", Severity.NOTE, text)]


def _contact_wanted(settings: FoldSettings, frame: Framework, verdict: Verdict) -> bool:
    """Whether a sheet is folded again in contact.

    By default where faces cross on the way, up to 1,000 hinges.
    """
    if settings.in_contact is not None:
        return settings.in_contact
    few = len(frame.hinges_edge) <= _MOST_HINGES_IN_CONTACT
    return few and any(point.crossings for point in verdict.path)


def fold_rigidly_and_judge(
    pattern: CreasePattern,
    motion: RigidMotion,
    settings: FoldSettings,
    progress: Progress = silent,
    tolerance: Tolerance | None = None,
    *,
    fold_flat: bool = False,
) -> tuple[RigidFold, Verdict, list[Finding]]:
    """Fold a pattern along its rigid motion, and judge whether it reaches its target.

    motion : that of the pattern, with a path. progress : called with the stages "fold" and "judge".
    tolerance : as for `fold_and_judge`; fold_flat : as for `fold_rigidly`.
    """
    tolerance = tolerance or Tolerance()
    frame = framework(pattern, settings)
    made = fold_rigidly(
        frame, motion, settings.steps, partial(progress, "fold"), fold_flat=fold_flat
    )
    progress("judge", 0, 1)
    verdict = judge(made.folding, tolerance)
    progress("judge", 1, 1)
    findings = [
        *inspect_form(frame, tolerance),
        *findings_of(verdict, tolerance, _misplaced(frame, verdict), _worst(frame, verdict)),
        *findings_of_fold(motion, made, fold_flat),
        *_thickness_unused(settings, Solver.RIGID),
    ]
    return made, verdict, findings


def _misplaced(frame: Framework, verdict: Verdict) -> list[Misplaced]:
    """The open vertices that are off their places, by their numbers in the pattern."""
    source = frame.sheet.vertices_source
    own = np.flatnonzero(np.isin(source, verdict.open_vertices))
    found = misplaced_vertices(frame.sheet.pattern, own)
    return [replace(each, vertex=int(source[each.vertex])) for each in found]


def _worst(frame: Framework, verdict: Verdict) -> OpenVertex | None:
    """The vertex that misses most, by its number in the pattern; None where all close."""
    if not verdict.open_vertices:
        return None
    number = verdict.open_vertices[0]
    own = int(np.flatnonzero(frame.sheet.vertices_source == number)[0])
    return replace(open_vertex(frame.sheet.pattern, own), vertex=number)


def _along_a_path(
    stuck: Folding,
    verdict: Verdict,
    steps: int,
    progress: Progress,
    tolerance: Tolerance,
    checkpoint: Checkpoint | None,
) -> tuple[Folding, Verdict]:
    """The fold along a folding path, or the first one where that does not reach the target either.

    Iterations of the verdict are those of both folds and of the path.
    """
    path = closing_path(stuck.frame, partial(progress, "order"))
    again = fold(stuck.frame, steps, partial(progress, "fold"), path.angles, checkpoint=checkpoint)
    judged = judge(again, tolerance)
    iterations = stuck.iterations + path.iterations + again.iterations
    if judged.reached:
        return again, replace(judged, iterations=iterations)
    return stuck, replace(verdict, iterations=iterations)
