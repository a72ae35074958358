"""What an order of layers must satisfy: conditions on pairs of regions of a flat-folded sheet.

For each pair of regions that overlap there is a variable: which of them is above. Where edges lie
on each other or on regions, no sheet may pass through another (Akitaya, Demaine and Ku 2024,
Computing flat-folded states): taco-tortilla, a region that goes on across a fold is not between its
sides; taco-taco, of two folds at one place none is between the sides of the other unless all of it
is; and transitivity, regions over one cell have an order. Flat creases join faces into one region,
so that two regions that go on across an edge (tortilla-tortilla) are one variable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.layers.cells import Cells, members
from fab.layers.flat_form import FlatForm
from solver.graphs import EdgeIndex
from solver.vectors import IntArray

__all__ = ["Conditions", "conditions_of", "overlapping", "triples"]


@dataclass(frozen=True)
class Conditions:
    """Variables and conditions. Literal v + 1 says that the second region of pair v is above the
    first, -(v + 1) that it is below.

    Attributes
    ----------
    pairs : shape (n, 2), regions that overlap, the lower number first.
    equal : shape (m, 2), literals that are equal (taco-tortilla); equal_regions : shape (m, 3).
    clauses : shape (k, 3), of each row one literal is true (taco-taco); clauses_regions : (k, 4).
    known : shape (c,), literals that letters of creases make true; known_edges : their edges.
    stacks : regions over a cell, rising, for transitivity; none is part of another one.
    """

    pairs: IntArray
    equal: IntArray
    equal_regions: IntArray
    clauses: IntArray
    clauses_regions: IntArray
    known: IntArray
    known_edges: IntArray
    stacks: tuple[IntArray, ...]
    index: EdgeIndex

    def above(self, first: IntArray, second: IntArray) -> IntArray:
        """Literals that say that the first regions are above the second ones, shape (n,).

        0 where the two do not overlap.
        """
        place = self.index.find(np.column_stack([first, second]))
        return np.where(place < 0, 0, np.where(first > second, place + 1, -(place + 1)))

    @property
    def triple_count(self) -> int:
        """Number of triples of regions over one cell, those over several counted again."""
        sizes = [len(stack) for stack in self.stacks]
        return sum(n * (n - 1) * (n - 2) // 6 for n in sizes)


def triples(stack: IntArray) -> IntArray:
    """All triples of a stack, rising, shape (n, 3)."""
    size = len(stack)
    first, second = np.triu_indices(size, 1)
    rest = size - 1 - second
    row = np.repeat(np.arange(len(first)), rest)
    third = np.arange(len(row)) - np.repeat(np.cumsum(rest) - rest, rest) + second[row] + 1
    return stack[np.column_stack([first[row], second[row], third])]


def conditions_of(form: FlatForm, cells: Cells) -> Conditions:
    """The conditions of a folded form."""
    region_masks = _region_masks(form, cells)
    count = form.region_count
    stacks = _stacks(region_masks, cells)
    pairs = _pairs(stacks, count)
    index = EdgeIndex.of(pairs, count)
    folds, crossings, through = _at_edges(form, cells, region_masks)
    empty = np.empty((0, 3), np.int64)
    # a fold (a, b) and a region c that goes on across it
    taco = np.unique(np.concatenate([empty, *through]), axis=0)
    twice = np.unique(np.concatenate([np.empty((0, 4), np.int64), *crossings]), axis=0)
    none = np.empty(0, np.int64)
    blank = Conditions(pairs, empty, empty, empty, empty, none, none, stacks, index)
    equal = np.column_stack(
        [blank.above(taco[:, 0], taco[:, 2]), blank.above(taco[:, 1], taco[:, 2])]
    )
    fine = (equal != 0).all(axis=1)
    clauses, of_rows = _uncrossed(blank, twice)
    known = blank.above(folds[:, 1], folds[:, 0]) * folds[:, 2]
    lettered = known != 0
    return Conditions(
        pairs,
        equal[fine],
        taco[fine],
        clauses,
        of_rows,
        known[lettered],
        folds[lettered, 3],
        stacks,
        index,
    )


def overlapping(form: FlatForm, cells: Cells) -> IntArray:
    """Pairs of faces that overlap, lower number first, shape (n, 2); none within one region."""
    count = form.sheet.face_count
    pairs = _pairs(_stacks(cells.masks, cells), count)
    region = form.faces_region[pairs]
    apart: IntArray = pairs[region[:, 0] != region[:, 1]]
    return apart


def _region_masks(form: FlatForm, cells: Cells) -> list[int]:
    """The regions that cover each cell, as bits."""
    count, faces = form.region_count, form.sheet.face_count
    if count == faces:
        return cells.masks
    out = []
    seen: dict[int, int] = {}
    for mask in cells.masks:
        if mask not in seen:
            regions = 0
            for region in np.unique(form.faces_region[members(mask)]).tolist():
                regions |= 1 << region
            seen[mask] = regions
        out.append(seen[mask])
    return out


def _stacks(masks: list[int], cells: Cells) -> tuple[IntArray, ...]:
    """Sets of regions over real cells that are not part of the set over a cell beside them."""
    real = [mask if good else 0 for mask, good in zip(masks, cells.real.tolist(), strict=True)]
    part = {0}
    for left, right in cells.edges_cells.tolist():
        first, second = real[left], real[right]
        if first != second:
            common = first & second
            if common == first:
                part.add(first)
            elif common == second:
                part.add(second)
    distinct = [mask for mask in dict.fromkeys(real) if mask not in part]
    return tuple(members(mask) for mask in distinct if mask & (mask - 1))


def _pairs(stacks: tuple[IntArray, ...], count: int) -> IntArray:
    keys = [np.empty(0, np.int64)]
    for stack in stacks:
        first, second = np.triu_indices(len(stack), 1)
        keys.append(stack[first] * count + stack[second])
    return np.column_stack(np.divmod(np.unique(np.concatenate(keys)), max(count, 1)))


def _at_edges(
    form: FlatForm, cells: Cells, masks: list[int]
) -> tuple[IntArray, list[IntArray], list[IntArray]]:
    """All folds, rows (first region, second, literal's sign, edge); pairs of folds at one place,
    rows of four regions; and folds with regions that go on across them, rows of three.
    """
    sheet, region = form.sheet, form.faces_region
    first, second = region[sheet.edges_faces].T
    # the second region is above the first one: valleys of faces that look up
    sign = form.edges_sign * np.where(form.faces_turned[sheet.edges_faces[:, 0]], -1, 1)
    own = np.flatnonzero(form.edges_folded)
    # that the first one is below: above(second, first)
    folds = np.column_stack([first, second, sign, np.arange(len(first))])[own]
    edges_faces = sheet.edges_faces.tolist()
    folded = form.edges_folded.tolist()
    joined = (sheet.edges_joining & ~form.edges_folded).tolist()
    regions = region.tolist()
    sides, real = cells.edges_cells.tolist(), cells.real.tolist()
    lines, bounds = cells.edges_lines.tolist(), cells.edges_offsets.tolist()
    crossings, through = [], []
    seen: set[tuple[tuple[tuple[int, int], ...], int]] = set()
    for edge, (left, right) in enumerate(sides):
        here = lines[bounds[edge] : bounds[edge + 1]]
        ending = 0  # regions that end here
        left_folds: list[tuple[int, int]] = []
        right_folds: list[tuple[int, int]] = []
        for line in here:
            a, b = edges_faces[line]
            if joined[line]:  # both sides are one region, which goes on here
                continue
            ending |= 1 << regions[a]
            if b >= 0:
                ending |= 1 << regions[b]
            if folded[line]:
                pair = (regions[a], regions[b])
                (left_folds if cells.masks[left] >> a & 1 else right_folds).append(pair)
        if not (left_folds or right_folds):
            continue
        across = masks[left] & masks[right] & ~ending
        for folds_here, cell in ((left_folds, left), (right_folds, right)):
            if not folds_here or not real[cell]:
                continue
            key = (tuple(sorted(folds_here)), across)
            if key in seen:
                continue
            seen.add(key)
            pairs = np.array(key[0], np.int64)
            over = members(across)
            if len(over):
                row, column = np.divmod(np.arange(len(pairs) * len(over)), len(over))
                through.append(np.column_stack([pairs[row], over[column]]))
            if len(pairs) > 1:
                one, other = np.triu_indices(len(pairs), 1)
                crossings.append(np.column_stack([pairs[one], pairs[other]]))
    return folds, crossings, through


def _uncrossed(known: Conditions, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Clauses that keep pairs of folds (a, b) and (c, d) from crossing, and their regions.

    a < c < b < d is none of the orders, nor are those with a and b, c and d, or both pairs changed.
    """
    clauses, of_rows = [np.empty((0, 3), np.int64)], [np.empty((0, 4), np.int64)]
    for flip in range(8):
        a, b, c, d = rows.T
        if flip & 1:
            a, b = b, a
        if flip & 2:
            c, d = d, c
        if flip & 4:
            a, b, c, d = c, d, a, b
        # not (c above a and b above c and d above b)
        clause = np.column_stack([known.above(a, c), known.above(c, b), known.above(b, d)])
        fine = (clause != 0).all(axis=1)
        clauses.append(clause[fine])
        of_rows.append(rows[fine])
    return np.concatenate(clauses), np.concatenate(of_rows)
