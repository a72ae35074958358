"""A fold whose faces do not pass through each other, in whichever order gets to the target."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from fab.errors import Finding, Severity, counted
from fab.folding.bar_hinge_model import Framework
from fab.folding.contact.contact_fold import fold_in_contact
from fab.folding.contact.fold_orders import fold_orders
from fab.folding.contact.stops import Stop
from fab.folding.contact.work import OutOfWorkError, Work
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import Checkpoint, Folding
from fab.folding.tolerance import Tolerance
from fab.folding.verdict import Verdict, judge
from fab.pattern.overlap import overlapping_faces
from fab.progress import Progress
from solver.vectors import IntArray

__all__ = ["flat_overlaps", "fold_past_contact"]

# Sheets of more hinges are folded in contact all at once, in no other order.
_MOST_HINGES = 300
# Pairs of parts that folds in contact may look at: a minute or two, the same on all machines.
_MOST_PAIRS = 1.5e8


def fold_past_contact(
    free: Folding,
    verdict: Verdict,
    settings: FoldSettings,
    progress: Progress,
    tolerance: Tolerance,
    checkpoint: Checkpoint | None = None,
) -> tuple[Folding, Verdict, list[Finding]]:
    """The fold in contact that reaches its target, or how far one gets, with findings.

    All creases at once, then in other orders (`fold_orders`, up to 300 hinges), if the fold without
    contact reaches its target. Where none does, that of all creases at once is given with
    `settings.in_contact`; else that without contact, with the stop of the other, unless its angles
    do not close.

    A fold that takes too much work, such as that of a long ribbon in many layers, is given up, and
    a finding says how far it came; so are further orders.

    Parameters
    ----------
    free, verdict : the fold without contact and its verdict.
    progress : called with the stages "contact" and "order".
    checkpoint : what keeps each of the folds, as for `fab.folding.quasi_static.fold`.
    """
    frame = free.frame
    over = flat_overlaps(frame)
    if len(over):
        return free, verdict, [_not_possible(over)]
    watch = _Watch(progress)
    runs = partial(
        fold_in_contact,
        frame,
        settings.steps,
        settings.thickness_mm,
        watch,
        work=Work(_MOST_PAIRS),
        checkpoint=checkpoint,
    )
    try:
        first = made = runs()
    except OutOfWorkError:
        return free, verdict, [_not_finished(watch.share)]
    judged = judge(made, tolerance)
    tried, iterations = 1, free.iterations + made.iterations
    if verdict.reached and not judged.reached and len(frame.hinges_edge) <= _MOST_HINGES:
        with suppress(OutOfWorkError):
            for path in fold_orders(frame, partial(progress, "order")):
                made = runs(path=path)
                tried, iterations = tried + 1, iterations + made.iterations
                judged = judge(made, tolerance)
                if judged.reached:
                    break
    if judged.reached:
        crossed = any(point.crossings for point in verdict.path)
        held = [_in_contact(tried)] if crossed else []
        return made, replace(judged, iterations=iterations), held
    stop = first.stopped and replace(first.stopped, orders=tried)
    closes = verdict.closes(tolerance)
    if not (closes or settings.in_contact):
        stop = None  # nothing gets there, in contact or not
    findings = [] if stop is None else [_stopped(stop, settings, verdict.reached, closes)]
    if settings.in_contact:
        made = replace(first, stopped=stop)
        return made, replace(judge(made, tolerance), iterations=iterations), findings
    return free, replace(verdict, stopped=stop, iterations=iterations), findings


class _Watch:
    """Progress of folds in contact, and the share that the last one came to."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self.share = progress, 0.0

    def __call__(self, done: float, total: int) -> None:
        self.share = done / total
        self._progress("contact", done, total)


def flat_overlaps(frame: Framework) -> IntArray:
    """Pairs of faces that lie on each other in the flat sheet, shape (n, 2)."""
    sheet = frame.sheet.pattern
    return overlapping_faces(
        sheet.vertices_coords, sheet.faces_vertices, sheet.faces_offsets, sheet.edges
    )


def _not_possible(pairs: IntArray) -> Finding:
    first, second = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))][0].tolist()
    more = f", and {counted(len(pairs) - 1, 'more pair')}" if len(pairs) > 1 else ""
    text = (
        f"faces {first} and {second} lie on each other in the flat sheet{more}: neither is above "
        "the other, so that the fold is simulated without contact. Cut the sheet into pieces."
    )
    return Finding("contact-not-possible", Severity.WARNING, text, panels=(first, second))


def _not_finished(share: float) -> Finding:
    text = (
        f"in contact the sheet was folded to {share:.0%} of the fold, then given up after looking "
        f"at {_MOST_PAIRS / 1e6:g} million pairs of its parts: whether its faces keep it from its "
        "target is not known. What is shown is folded without contact; a smaller part of the sheet "
        "takes less."
    )
    return Finding("contact-not-finished", Severity.WARNING, text)


def _in_contact(tried: int) -> Finding:
    order = "in the order in which contact lets its creases fold" if tried == 1 else "in turn"
    text = (
        "folded all at once without contact, its faces pass through each other: the sheet is "
        f"folded {order} instead, and they do not."
    )
    return Finding("folded-in-contact", Severity.NOTE, text)


def _stopped(stop: Stop, settings: FoldSettings, reached: bool, closes: bool) -> Finding:
    """Where a fold is stopped. reached, closes : of the fold without contact."""
    x, y, z = (f"{value:.4g}" for value in stop.point_mm)
    (u, v), _ = stop.flat_mm
    first, second = stop.faces
    who = f"faces {first} and {second} press on each other"
    if first == second:
        who = f"parts of face {first} press on each other"
    text = (
        f"{who} from {stop.share:.1%} of the fold on, at ({x}, {y}, {z}) mm, "
        f"({u:.4g}, {v:.4g}) mm in the flat sheet"
    )
    if not closes:
        text += ". Its fold angles do not close, so that no order of folding gets to its target."
    elif stop.orders > 1:
        text += (
            f", and keep it from its target: {counted(stop.orders, 'order')} of folding were "
            "tried, and none gets there."
        )
    else:
        text += ", and keep it from its target: all creases fold at once, no other order was tried."
    if settings.thickness_mm > 0:
        text += (
            f" The sheet is {settings.thickness_mm:g} mm thick, and its layers take that room: try "
            "a lower thickness_mm."
        )
    if reached and not settings.in_contact:
        text += (
            " Another order may get there, so that this is a warning: what is shown passes through "
            "itself. --contact shows where the sheet stops, as an error."
        )
    severity = Severity.ERROR if settings.in_contact else Severity.WARNING
    return Finding("stopped-by-contact", severity, text, panels=stop.faces)
