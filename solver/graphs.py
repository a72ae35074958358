"""Graphs given as pairs of numbers: components, sparse matrices, and edges found by their ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from solver.vectors import FloatArray, IntArray

__all__ = ["EdgeIndex", "edge_keys", "labels", "weighted_graph"]


def labels(pairs: IntArray, count: int) -> IntArray:
    """Number of the connected component of each of `count` nodes, shape (count,).

    pairs : shape (n, 2), nodes that are joined. Components are numbered by their least node.

    >>> labels(np.array([[0, 3], [3, 1]]), 5).tolist()
    [0, 0, 1, 0, 2]
    """
    pairs = np.asarray(pairs, np.int64).reshape(-1, 2)
    graph = weighted_graph(np.ones(len(pairs)), pairs, count)
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def weighted_graph(weights: FloatArray | IntArray, pairs: IntArray, count: int) -> csr_array:
    """The matrix of a graph of `count` nodes, for `scipy.sparse.csgraph`.

    weights : shape (n,), not zero; pairs : shape (n, 2), from node to node. Weights of equal pairs
    are added. Nodes have 32-bit numbers: most releases of scipy search no other graphs.

    >>> weighted_graph(np.array([2.0, 3.0]), np.array([[0, 1], [0, 1]]), 2).toarray().tolist()
    [[0.0, 5.0], [0.0, 0.0]]
    """
    from_node, to_node = np.asarray(pairs, np.int32).reshape(-1, 2).T
    return csr_array((weights, (from_node, to_node)), shape=(count, count))


@dataclass(frozen=True)
class EdgeIndex:
    """Edges of a graph of `count` nodes, found by their ends.

    Attributes
    ----------
    keys : shape (n,), sorted; edges : shape (n,), the number of the edge that each key is of.
    count : number of nodes. directed : whether (a, b) differs from (b, a).

    >>> index = EdgeIndex.of(np.array([[4, 1], [0, 2], [1, 4]]), 5)
    >>> index.find(np.array([[1, 4], [2, 0], [0, 1]])).tolist()
    [0, 1, -1]
    """

    keys: IntArray
    edges: IntArray
    count: int
    directed: bool

    @classmethod
    def of(cls, ends: IntArray, count: int, *, directed: bool = False) -> EdgeIndex:
        """The index of edges with these ends, shape (n, 2), below `count`."""
        keys = edge_keys(ends, count, directed=directed)
        order = np.argsort(keys, kind="stable")
        return cls(keys[order], np.asarray(order, np.int64), count, directed)

    def find(self, ends: IntArray) -> IntArray:
        """The first edge between each pair of nodes, shape (m,); -1 where there is none.

        ends : shape (m, 2).
        """
        wanted = edge_keys(ends, self.count, directed=self.directed)
        if not len(self.keys):
            return np.full(len(wanted), -1)
        place = np.searchsorted(self.keys, wanted).clip(max=len(self.keys) - 1)
        return np.where(self.keys[place] == wanted, self.edges[place], -1)


def edge_keys(ends: IntArray, count: int, *, directed: bool = False) -> IntArray:
    """One number for each pair of nodes, shape (n, 2), below `count`: equal for equal pairs.

    Undirected pairs have the same number in both orders.
    """
    ends = np.asarray(ends, np.int64).reshape(-1, 2)
    first, second = ends.T if directed else (ends.min(axis=1), ends.max(axis=1))
    return np.asarray(first * count + second, np.int64)
