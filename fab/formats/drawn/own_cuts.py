"""Cuts of our own sheets as they were before they got bridges, closed slots or shared sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely

from fab.formats.drawn.dashes import facing
from fab.formats.drawn.line_soup import LineSoup
from fab.geometry.arrangement import arrangement
from fab.geometry.planar_graph import walks_of, without_dangling
from fab.geometry.rings import is_hole, ring_areas
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["shared_sides", "without_bridges", "without_slots"]

_DASHED = ("MOUNTAIN", "VALLEY")
# Sides of a slot.
_SIDES = 4
# Bridges are up to 20 mm wide, and the gap is wider by the kerf.
_WIDEST_GAP_MM = 30.0
# Outlines nearer to each other than this share a side.
_SAME_MM = 2e-3
# Pieces are larger; the loops in which a drag knife swivels are not.
_LEAST_PIECE_MM2 = 4.0


def without_slots(
    soup: LineSoup, operations: Sequence[str], closed: Sequence[bool]
) -> tuple[LineSoup, tuple[bool, ...], int]:
    """Closed slots along creases as dashes in their middle, which elements are closed, and a count.

    operations : the layer of each element; closed : which are closed.
    """
    sides = np.bincount(soup.lines_element, minlength=len(closed))
    slot = np.array(closed, bool) & np.isin(operations, _DASHED) & (sides == _SIDES)
    if not slot.any():
        return soup, tuple(closed), 0
    of_slot = np.flatnonzero(slot[soup.lines_element])
    order = np.argsort(soup.lines_element[of_slot], kind="stable")
    rows = of_slot[order].reshape(-1, _SIDES)
    middles = soup.lines_coords[rows].mean(axis=2)  # of the sides, shape (n, 4, 2)
    along = np.stack([middles[:, [0, 2]], middles[:, [1, 3]]], axis=1)
    length = np.hypot(*(along[:, :, 1] - along[:, :, 0]).transpose(2, 0, 1))
    coords = soup.lines_coords.copy()
    coords[rows[:, 0]] = along[np.arange(len(rows)), np.argmax(length, axis=1)]
    kept = np.ones(len(coords), bool)
    kept[rows[:, 1:]] = False
    open_now = np.array(closed, bool) & ~slot
    return _chosen(replace(soup, lines_coords=coords), kept), tuple(open_now.tolist()), len(rows)


def without_bridges(
    soup: LineSoup, operations: Sequence[str], closed: Sequence[bool]
) -> tuple[LineSoup, tuple[bool, ...], int]:
    """Outlines closed where they have bridges, which elements are closed, and how many bridges.

    Cuts whose ends face each other in a ring are one outline, counterclockwise; cuts that end
    without one that faces them stay as they are.
    """
    arcs = _arcs(soup, operations, closed)
    if not arcs:
        return soup, tuple(closed), 0
    numbers = list(arcs)
    ends = np.array([line[[0, -1]] for line in arcs.values()]).reshape(-1, 2)
    inner = np.array([line[[1, -2]] for line in arcs.values()]).reshape(-1, 2)
    outward = ends - inner
    length = np.hypot(*outward.T)
    every = np.arange(len(ends))
    other, gap = facing(ends, outward / length[:, None], every, length, _noise(soup))
    paired = (other >= 0) & (gap <= _WIDEST_GAP_MM)
    paired &= other[other] == every
    done: set[int] = set()
    kept = np.ones(len(soup.lines_coords), bool)
    now_closed = list(closed)
    rings: list[tuple[int, FloatArray]] = []
    bridges = 0
    for first in range(len(numbers)):
        if first in done:
            continue
        loop = _loop(first, other, paired)
        done |= {end // 2 for end in loop}
        if not loop:
            continue
        parts = [arcs[numbers[end // 2]][:: 1 if end % 2 else -1] for end in loop]
        ring = np.concatenate(parts)
        rings.append((numbers[first], ring[::-1] if is_hole(ring) else ring))
        now_closed[numbers[first]] = True
        kept[np.isin(soup.lines_element, [numbers[end // 2] for end in loop])] = False
        bridges += len(loop)
    if not rings:
        return soup, tuple(closed), 0
    lines = np.concatenate([np.stack([r, np.roll(r, -1, axis=0)], axis=1) for _, r in rings])
    element = np.repeat([number for number, _ in rings], [len(ring) for _, ring in rings])
    sources = np.array([np.flatnonzero(soup.lines_element == number)[0] for number, _ in rings])
    source = np.repeat(sources, [len(ring) for _, ring in rings])
    whole = _chosen(soup, kept)
    whole = replace(
        whole,
        lines_coords=np.concatenate([whole.lines_coords, lines]),
        lines_assignment=np.concatenate([whole.lines_assignment, soup.lines_assignment[source]]),
        lines_foldAngle=np.concatenate([whole.lines_foldAngle, soup.lines_foldAngle[source]]),
        lines_element=np.concatenate([whole.lines_element, element]),
    )
    return whole, tuple(now_closed), bridges


def shared_sides(
    soup: LineSoup, operations: Sequence[str], closed: Sequence[bool]
) -> tuple[LineSoup, BoolArray, BoolArray]:
    """The drawing with the outlines of pieces side to side, which share sides that are cut once,
    split where they meet; which lines are sides around such pieces, and which are between two.

    Cuts that enclose nothing are neither. What has no line within, and pieces that have some on all
    sides, is a gap that they enclose.
    """
    cut = np.array(operations, dtype=object) == "CUT"
    which = np.flatnonzero(cut[soup.lines_element])
    is_open = ~np.array(closed, bool)[soup.lines_element[which]]
    nowhere = np.zeros(len(soup.lines_coords), bool)
    if not is_open.any():
        return soup, nowhere, nowhere
    mm = soup.mm_per_unit or 1.0
    graph = arrangement(soup.lines_coords[which], _SAME_MM / mm)
    edges = graph.edges_vertices
    around = np.flatnonzero(without_dangling(edges))
    part = labels(edges[around], len(graph.vertices_coords))[edges[:, 0]]
    line, edge = graph.line_pairs
    opened = np.isin(around, edge[is_open[line]])
    around = around[np.isin(part[around], part[around[opened]])]
    if not len(around):
        return soup, nowhere, nowhere
    corners, offsets, walk = walks_of(graph.vertices_coords, edges[around])
    gone = nowhere.copy()
    gone[which[line[np.isin(edge, around)]]] = True
    rings = [graph.vertices_coords[corners[i:j]] for i, j in pairwise(offsets.tolist())]
    marks = shapely.multipoints(soup.lines_coords[~gone].mean(axis=1))
    piece = ring_areas(graph.vertices_coords[corners], offsets) * mm * mm > _LEAST_PIECE_MM2
    bare = piece & ~shapely.intersects([shapely.Polygon(ring) for ring in rings], marks)
    sides = walk.reshape(2, -1)
    beside_others = piece[sides].all(axis=0) & ~bare[sides].all(axis=0)
    bare[sides[:, ~beside_others]] = False
    piece &= ~bare
    between = piece[sides].all(axis=0)
    if not between.any():
        return soup, nowhere, nowhere
    first = which[graph.edges_lines[graph.edges_offsets[around]]]
    rest, new = _chosen(soup, ~gone), _chosen(soup, first)
    split = replace(
        rest,
        lines_coords=np.concatenate([rest.lines_coords, graph.vertices_coords[edges[around]]]),
        lines_assignment=np.concatenate([rest.lines_assignment, new.lines_assignment]),
        lines_foldAngle=np.concatenate([rest.lines_foldAngle, new.lines_foldAngle]),
        lines_element=np.concatenate([rest.lines_element, new.lines_element]),
    )
    before = np.zeros(len(rest.lines_coords), bool)
    return split, np.append(before, ~between), np.append(before, between)


def _arcs(
    soup: LineSoup, operations: Sequence[str], closed: Sequence[bool]
) -> dict[int, FloatArray]:
    """The open cuts that are one line each, by their element, each of shape (m, 2)."""
    out: dict[int, FloatArray] = {}
    for number in np.unique(soup.lines_element).tolist():
        if operations[number] != "CUT" or closed[number]:
            continue
        lines = soup.lines_coords[soup.lines_element == number]
        if np.array_equal(lines[1:, 0], lines[:-1, 1]):
            out[number] = np.concatenate([lines[:1, 0], lines[:, 1]])
    return out


def _loop(first: int, other: IntArray, paired: np.ndarray) -> list[int]:
    """The ends at which arcs are left on a way around from the first one; none where it is open.

    Arc i has the ends 2 i and 2 i + 1.
    """
    out: list[int] = []
    end = 2 * first + 1
    while paired[end]:
        out.append(end)
        entered = int(other[end])
        end = entered ^ 1
        if entered == 2 * first:
            return out
        if len(out) > len(paired):
            break
    return []


def _noise(soup: LineSoup) -> float:
    """How far points are from where they are meant: files have six decimals."""
    return 2e-6 / (soup.mm_per_unit or 1.0)


def _chosen(soup: LineSoup, which: BoolArray | IntArray) -> LineSoup:
    """Some of the lines."""
    return replace(
        soup,
        lines_coords=soup.lines_coords[which],
        lines_assignment=soup.lines_assignment[which],
        lines_foldAngle=soup.lines_foldAngle[which],
        lines_element=soup.lines_element[which],
    )
