"""How high each face is in a stack of layers, so that drawings show them apart."""

from __future__ import annotations

from collections import deque

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, vstack
from scipy.sparse.csgraph import connected_components

from fab.layers.cells import Cells
from fab.layers.conditions import Conditions
from fab.layers.flat_form import FlatForm
from solver.graphs import weighted_graph
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["corner_heights"]

# Regions in a circle are tilted by a linear program of up to so many conditions.
_MOST_ROWS = 40_000
# Parts of a layer by which they are apart at corners of cells, tried one after another.
_AT_CORNERS = (0.5, 0.0)


def corner_heights(
    form: FlatForm, cells: Cells, conditions: Conditions, values: IntArray
) -> FloatArray:
    """Heights of all corners of all faces, in layers, shape (len(faces_vertices),).

    Upwards is where faces look that are not turned. A face is everywhere at least one layer above
    those that are under it. Faces that are above one another in a circle, as those of twists are,
    are tilted; where that cannot be, they are at the mean of their places.

    values : of each pair of regions, 1 where the second one is above, else -1.
    """
    sheet = form.sheet
    face = np.repeat(np.arange(sheet.face_count), np.diff(sheet.faces_offsets))
    region = form.faces_region[face]
    steps = _steps(conditions, values)
    count = form.region_count
    level = _levels(steps, count)
    if level is not None:
        return level[region]
    points = form.coords[sheet.faces_vertices]
    planes = _planes(form, cells, conditions, values)
    if planes is not None:
        scale = float(np.hypot(*np.ptp(form.coords, axis=0)))
        local = (points - form.coords.mean(axis=0)) / scale
        return np.asarray(planes[region, 0] + (planes[region, 1:] * local).sum(axis=1))
    return _mean_levels(steps, count)[region]


def _ranked(stack: IntArray, conditions: Conditions, values: IntArray) -> IntArray:
    """Regions over one cell, the lowest first."""
    first, second = np.triu_indices(len(stack), 1)
    place = conditions.index.find(np.column_stack([stack[first], stack[second]]))
    up = values[place] > 0
    under = np.bincount(np.where(up, second, first), minlength=len(stack))
    return stack[np.argsort(under, kind="stable")]


def _steps(conditions: Conditions, values: IntArray) -> IntArray:
    """Pairs of regions of which the second one is next above the first over a cell, (n, 2)."""
    rows = [np.empty((0, 2), np.int64)]
    for stack in conditions.stacks:
        ranked = _ranked(stack, conditions, values)
        rows.append(np.column_stack([ranked[:-1], ranked[1:]]))
    return np.unique(np.concatenate(rows), axis=0)


def _levels(steps: IntArray, count: int) -> FloatArray | None:
    """The number of regions one above another under each; None where they are in a circle."""
    above: list[list[int]] = [[] for _ in range(count)]
    waiting = np.bincount(steps[:, 1], minlength=count).tolist()
    for low, high in steps.tolist():
        above[low].append(high)
    level = [0] * count
    todo = deque(region for region in range(count) if not waiting[region])
    done = 0
    while todo:
        low = todo.popleft()
        done += 1
        for high in above[low]:
            level[high] = max(level[high], level[low] + 1)
            waiting[high] -= 1
            if not waiting[high]:
                todo.append(high)
    return np.array(level, float) if done == count else None


def _mean_levels(steps: IntArray, count: int) -> FloatArray:
    """Levels of sets of regions in a circle, and within each by how many steps lead to a region."""
    graph = weighted_graph(np.ones(len(steps)), steps, count)
    number, label = connected_components(graph, connection="strong")
    between = np.unique(label[steps], axis=0)
    level = _levels(between[between[:, 0] != between[:, 1]], number)
    assert level is not None  # of sets of regions there is no circle
    within = steps[label[steps[:, 0]] == label[steps[:, 1]]]
    rise = np.bincount(within[:, 1], minlength=count) - np.bincount(within[:, 0], minlength=count)
    reach = float(np.abs(rise).max(initial=0)) + 1
    return np.asarray(level[label] + rise / (2 * reach))


def _planes(
    form: FlatForm, cells: Cells, conditions: Conditions, values: IntArray
) -> FloatArray | None:
    """A plane of each region, height and slopes over the diagonal, shape (count, 3).

    Over the middle of each cell regions are a layer apart, and at its corners a part of one where
    that can be: where circles close, as in the middle of a pinwheel, they meet.
    """
    rows = _over_cells(form, cells, conditions, values)
    if rows is None:
        return None
    low, high, points, inner = rows
    middle, scale = form.coords.mean(axis=0), float(np.hypot(*np.ptp(form.coords, axis=0)))
    height = np.column_stack([np.ones(len(points)), (points - middle) / scale])
    count = form.region_count
    unknown = 3 * count + 1  # the last one is the largest height
    row = np.repeat(np.arange(len(points)), 3)
    columns = [(3 * each[:, None] + np.arange(3)).ravel() for each in (low, high)]
    apart = coo_array(
        (
            np.concatenate([height.ravel(), -height.ravel()]),
            (np.tile(row, 2), np.concatenate(columns)),
        ),
        shape=(len(points), unknown),
    )
    first = 3 * np.arange(count)
    both = np.concatenate([first, first])
    limited = coo_array(
        (
            np.concatenate([np.repeat([1.0, -1.0], count), -np.ones(2 * count)]),
            (
                np.tile(np.arange(2 * count), 2),
                np.concatenate([both, np.full(2 * count, unknown - 1)]),
            ),
        ),
        shape=(2 * count, unknown),
    )
    cost = np.zeros(unknown)
    cost[-1] = 1.0
    for part in _AT_CORNERS:
        found = linprog(
            cost,
            A_ub=vstack([apart, limited]).tocsr(),
            b_ub=np.concatenate([-np.where(inner, 1.0, part), np.zeros(2 * count)]),
            bounds=(None, None),
            method="highs",
        )
        if found.status == 0:
            return np.asarray(found.x[:-1]).reshape(-1, 3)
    return None


def _over_cells(
    form: FlatForm, cells: Cells, conditions: Conditions, values: IntArray
) -> tuple[IntArray, IntArray, FloatArray, BoolArray] | None:
    """Regions next above one another at corners and middles of cells: the lower one, the upper one,
    the point, and whether it is a middle; None where these are too many.
    """
    low, high, points, inner = [], [], [], []
    rows = 0
    for cell in np.flatnonzero(cells.real).tolist():
        stack = np.unique(form.faces_region[cells.faces(cell)])
        if len(stack) < 2:
            continue
        ranked = _ranked(stack, conditions, values)
        ring = cells.vertices_coords[cells.corners[cells.offsets[cell] : cells.offsets[cell + 1]]]
        own = np.vstack([ring, ring.mean(axis=0)])
        low.append(np.repeat(ranked[:-1], len(own)))
        high.append(np.repeat(ranked[1:], len(own)))
        points.append(np.tile(own, (len(ranked) - 1, 1)))
        inner.append(np.tile(np.arange(len(own)) == len(ring), len(ranked) - 1))
        rows += len(low[-1])
        if rows > _MOST_ROWS:
            return None
    return np.concatenate(low), np.concatenate(high), np.concatenate(points), np.concatenate(inner)
