"""Orders of folding, for sheets that are stopped when all their creases fold at once.

Each order is a folding path (`fab.folding.quasi_static.fold`): some creases turn first, others
after them. Which ones may be in each other's way is not known: so a handful of orders is tried,
always the same ones.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fab.folding.bar_hinge_model import Framework
from fab.folding.folding_path import closing_path
from fab.progress import Steps, no_steps
from solver.vectors import FloatArray, IntArray

__all__ = ["fold_orders"]

# Creases fold in up to this many groups, one after another.
_GROUPS = 6


def fold_orders(frame: Framework, progress: Steps = no_steps) -> Iterator[FloatArray]:
    """Folding paths, shape (n, nh) each, radians: stations from flat to the target.

    Outer creases first, inner ones first, along the sheet from either end, and as the vertices
    close best (`fab.folding.folding_path.closing_path`). Orders with one group are left out.

    progress : as for `closing_path`.
    """
    turning = np.flatnonzero(frame.hinges_target != 0)
    ends = frame.vertices_coords[frame.hinges_vertices[:, :2]]
    middles = ends.mean(axis=1)[:, :2]
    box = frame.vertices_coords[:, :2]
    centre = (box.min(axis=0) + box.max(axis=0)) / 2
    out = np.hypot(*(middles - centre).T)
    along = middles[:, int(np.argmax(np.ptp(box, axis=0)))]
    for key in (-out, out, along, -along):
        groups = _groups(key[turning])
        if len(groups) > 1:
            yield _one_after_another(frame, [turning[group] for group in groups])
    yield closing_path(frame, progress).angles


def _groups(key: FloatArray) -> list[IntArray]:
    """Places by rising key, in up to six groups; equal keys are in one group."""
    values = np.unique(key.round(9))
    rank = np.searchsorted(values, key.round(9))
    group = rank * min(_GROUPS, len(values)) // max(len(values), 1)
    return [np.flatnonzero(group == number) for number in np.unique(group)]


def _one_after_another(frame: Framework, groups: list[IntArray]) -> FloatArray:
    path = np.zeros((len(groups) + 1, len(frame.hinges_target)))
    for number, group in enumerate(groups):
        path[number + 1 :, group] = frame.hinges_target[group]
    return path
