"""Trees of faces, from the middle of each piece of a sheet, and products of motions along them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from solver.graphs import edge_keys, labels, weighted_graph
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["FaceTree", "face_tree"]


@dataclass(frozen=True)
class FaceTree:
    """One tree for each piece of a sheet.

    Attributes
    ----------
    roots : the face nearest to the middle of each piece.
    parent : shape (n,), the face above each; roots are their own.
    link : shape (n,), the pair of neighbours over which each is reached; -1 at roots.
    forward : shape (n,), whether the face above is the first of that pair.
    """

    roots: IntArray
    parent: IntArray
    link: IntArray
    forward: BoolArray

    def poses(self, turns: FloatArray, shifts: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation and shift of every face, by products along the tree, doubling the stride.

        turns, shifts : shapes (pairs, 3, 3) and (pairs, 3), the motion x -> turn x + shift that
        carries the second face of each pair where the first one stays.
        """
        turn = np.broadcast_to(np.eye(3), (len(self.parent), 3, 3)).copy()
        shift = np.zeros((len(self.parent), 3))
        below = self.link >= 0
        own, by = turns[self.link[below]], shifts[self.link[below]]
        back = own.swapaxes(1, 2)
        forward = self.forward[below]
        turn[below] = np.where(forward[:, None, None], own, back)
        shift[below] = np.where(forward[:, None], by, -_applied(back, by))
        parent = self.parent
        while (parent != parent[parent]).any():
            shift = _applied(turn[parent], shift) + shift[parent]
            turn = turn[parent] @ turn
            parent = parent[parent]
        return turn, shift


def face_tree(centres: FloatArray, pairs: IntArray, lengths: FloatArray) -> FaceTree:
    """The trees that reach every face over the longest sides, which are known best.

    centres : shape (n, 2), middles of the faces; pairs : shape (m, 2), neighbours; lengths : shape
    (m,), of their common sides. Neighbours that share several sides are joined over the last.
    """
    count = len(centres)
    keys = edge_keys(pairs, count)
    _, last = np.unique(keys[::-1], return_index=True)
    chosen = len(keys) - 1 - last
    tree = minimum_spanning_tree(weighted_graph(1 / lengths[chosen], pairs[chosen], count))
    tree = tree + tree.T
    roots = _middles(centres, labels(pairs, count))
    parent = np.arange(count)
    for root in roots.tolist():
        order, above = breadth_first_order(tree, root, directed=False)
        parent[order[1:]] = above[order[1:]]
    number = weighted_graph(chosen + 1, pairs[chosen], count)
    forward = np.asarray(number[parent, np.arange(count)]).ravel()
    backward = np.asarray(number[np.arange(count), parent]).ravel()
    return FaceTree(roots, parent, np.maximum(forward, backward) - 1, forward > 0)


def _middles(centres: FloatArray, piece: IntArray) -> IntArray:
    size = np.bincount(piece)
    mean = np.stack([np.bincount(piece, column) for column in centres.T], axis=1) / size[:, None]
    order = np.lexsort([np.hypot(*(centres - mean[piece]).T), piece])
    _, first = np.unique(piece[order], return_index=True)
    return np.asarray(order[first], np.int64)


def _applied(turns: FloatArray, vectors: FloatArray) -> FloatArray:
    return np.asarray(np.squeeze(turns @ vectors[:, :, None], axis=2))
