"""Strips and single vertices that fold flat, and all orders of their layers by brute force."""

from __future__ import annotations

from itertools import combinations, pairwise, permutations

import numpy as np
from flat_patterns import pattern_of

from fab.pattern.crease_pattern import CreasePattern


def strip(lengths, letters) -> CreasePattern:
    """Faces in a row, of some lengths, with creases of some letters between them."""
    x = np.concatenate([[0.0], np.cumsum(lengths)])
    count = len(x)
    coords = [[each, y] for y in (0.0, 5.0) for each in x]
    faces = [[i, i + 1, count + i + 1, count + i] for i in range(count - 1)]
    return lettered(coords, faces, letters)


def vertex(angles_deg, letters) -> CreasePattern:
    """Triangles around one vertex; crease i is between the faces i - 1 and i."""
    turn = np.radians(np.concatenate([[0.0], np.cumsum(angles_deg)[:-1]]))
    rim = np.column_stack([np.cos(turn), np.sin(turn)])
    count = len(turn)
    faces = [[0, 1 + i, 1 + (i + 1) % count] for i in range(count)]
    return lettered(np.vstack([[0.0, 0.0], rim]), faces, letters)


def lettered(coords, faces, letters) -> CreasePattern:
    """Faces with letters of their creases, by the lower and then the higher vertex; folded flat."""
    plain = pattern_of(coords, faces)
    inner = np.flatnonzero(plain.edges_assignment != "B")
    ends = np.sort(plain.edges_vertices[inner], axis=1)
    every = np.full(len(plain.edges_vertices), "B")
    every[inner[np.lexsort(ends.T[::-1])]] = list(letters)
    return pattern_of(coords, faces, every, angle=180.0)


def brute_force_orders(sizes, letters, closed: bool) -> set[frozenset[tuple[int, int]]]:
    """All orders of faces that are folded onto one line, by trying all permutations.

    Each is the set of pairs (lower, upper) of faces that overlap. sizes : of the faces, integers.
    letters : of creases; crease i is after face i, or before it where the strip is closed.
    """
    count = len(sizes)
    steps = [size * (1 if i % 2 == 0 else -1) for i, size in enumerate(sizes)]
    ends = np.concatenate([[0], np.cumsum(steps)]).tolist()
    spans = [(min(a, b), max(a, b)) for a, b in pairwise(ends)]
    creases = [(i, i + 1, ends[i + 1]) for i in range(count - 1)]
    if closed:
        assert ends[-1] == 0
        creases = [((i - 1) % count, i, ends[i]) for i in range(count)]
    over = [
        (i, j)
        for i, j in combinations(range(count), 2)
        if min(spans[i][1], spans[j][1]) > max(spans[i][0], spans[j][0])
    ]
    found = set()
    for order in permutations(range(count)):
        if fits(order, spans, creases, letters):
            found.add(frozenset((i, j) if order[i] < order[j] else (j, i) for i, j in over))
    return found


def fits(height, spans, creases, letters) -> bool:
    """Whether layers at some heights pass through no crease and have the letters of all."""
    for (a, b, _), letter in zip(creases, letters, strict=True):
        up = height[b] > height[a]
        if letter != "U" and up != ((letter == "V") == (a % 2 == 0)):
            return False
    for a, b, x in creases:
        low, high = sorted((height[a], height[b]))
        for face, span in enumerate(spans):
            if span[0] < x < span[1] and low < height[face] < high:
                return False
    for (a, b, x), (c, d, y) in combinations(creases, 2):
        same_side = (spans[a][0] == x) == (spans[c][0] == y)
        if x == y and same_side and len({a, b, c, d}) == 4:
            low, high = sorted((height[a], height[b]))
            if (low < height[c] < high) != (low < height[d] < high):
                return False
    return True


def chosen_order(rows, turned) -> frozenset[tuple[int, int]]:
    """Pairs (lower, upper) of rows of faceOrders; turned : whether each face looks down."""
    return frozenset(
        (g, f) if (side > 0) != turned[g] else (f, g) for f, g, side in np.asarray(rows).tolist()
    )
