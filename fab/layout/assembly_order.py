"""Order in which the pieces of a sheet are put together, and their names."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import breadth_first_order

from solver.graphs import weighted_graph
from solver.vectors import IntArray

__all__ = ["assembly_order", "piece_name"]


def assembly_order(pairs: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Pieces in the order of assembling, outwards from the first, and the rank of each.

    Both of shape (count,). A piece without neighbours among those before it begins anew.

    pairs : shape (n, 2), neighbours among `count` pieces; pairs of a piece with itself are ignored.

    >>> order, rank = assembly_order(np.array([[0, 2], [2, 1]]), 4)
    >>> order.tolist(), rank.tolist()
    ([0, 2, 1, 3], [0, 2, 1, 3])
    """
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    graph = weighted_graph(np.ones(len(pairs)), pairs, count)
    rank = np.full(count, -1)
    order: list[int] = []
    for first in range(count):
        if rank[first] < 0:
            reached = breadth_first_order(graph, first, directed=False, return_predecessors=False)
            rank[reached] = len(order) + np.arange(len(reached))
            order += reached.tolist()
    return np.array(order), rank


def piece_name(number: int) -> str:
    """The letters of a piece: A, B, ... Z, AA, AB, ...

    >>> [piece_name(number) for number in (0, 25, 26, 702)]
    ['A', 'Z', 'AA', 'AAA']
    """
    name = ""
    number += 1
    while number:
        number, letter = divmod(number - 1, 26)
        name = chr(ord("A") + letter) + name
    return name
