"""Assembly of J' W J, the matrix of least squares over points in space.

Each row of J, one residual, has gradients at few vertices, with three coordinates each. Which
vertices these are does not change: where every product of gradients belongs in the matrix is found
once, and each later matrix is a few array operations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from solver.errors import InvalidState
from solver.sparse import Triangle
from solver.vectors import FloatArray, IntArray, scattered

__all__ = ["NormalAssembly"]


@dataclass(frozen=True)
class _Group:
    """Residuals that have equally many vertices, k.

    Attributes
    ----------
    order : shape (n, k), positions of each residual's vertices by rising number.
    first, second : shape (k (k + 1) / 2,), positions in that order of each pair, first >= second.
    sums : blocks of the matrix as sums of products, shape (blocks, n x pairs).
    """

    order: IntArray
    first: IntArray
    second: IntArray
    sums: csr_array


@dataclass(frozen=True)
class NormalAssembly:
    """Where the products of gradients are added in the lower triangle of J' W J.

    Coordinate c of vertex v is unknown 3 v + c.

    Attributes
    ----------
    count : number of vertices. triangle : sparsity of the matrix.
    vertices : of each group of residuals, shape (n, k) each, -1 for none.

    >>> line = NormalAssembly.of(2, [np.array([[0, 1]])])  # one residual, x of vertex 1 less 0's
    >>> gradient = np.array([[[-1.0, 0, 0], [1, 0, 0]]])
    >>> line.triangle.lower(line.matrix([gradient], [2.0])).toarray()[[0, 3]][:, [0, 3]].tolist()
    [[2.0, 0.0], [-2.0, 2.0]]
    >>> line.gradient([gradient], [2.0], [np.array([0.5])]).tolist()
    [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    """

    count: int
    triangle: Triangle
    vertices: tuple[IntArray, ...]
    _groups: tuple[_Group, ...]
    _entries: IntArray

    @classmethod
    def of(cls, count: int, vertices: Sequence[IntArray]) -> NormalAssembly:
        """The assembly of groups of residuals over `count` vertices.

        vertices : of each group, shape (n, k), -1 where a residual has fewer than k. Raises
        `InvalidState` where a residual names a vertex twice.
        """
        orders = [np.argsort(group, axis=1, kind="stable") for group in vertices]
        highs, lows = [], []
        for group, order in zip(vertices, orders, strict=True):
            rising = np.take_along_axis(group, order, axis=1)
            if ((rising[:, 1:] == rising[:, :-1]) & (rising[:, 1:] >= 0)).any():
                raise InvalidState(
                    "vertices",
                    "a residual names a vertex twice",
                    "Give each vertex once, with the sum of its gradients.",
                )
            first, second = np.tril_indices(group.shape[1])
            highs.append(rising[:, first].ravel())
            lows.append(rising[:, second].ravel())
        # blocks are found as the entries of a matrix that has one row for each vertex
        blocks, slots = Triangle.of(count, _joined(highs), _joined(lows))
        number = len(blocks.rows)
        groups, begin = [], 0
        for group, order, high in zip(vertices, orders, highs, strict=True):
            part = slots[begin : begin + len(high)]
            begin += len(high)
            used = np.flatnonzero(part < number)
            ones = np.ones(len(used))
            sums = csr_array((ones, (part[used], used)), shape=(number, len(part)))
            groups.append(_Group(order, *np.tril_indices(group.shape[1]), sums))
        triangle, entries = _expanded(blocks)
        return cls(count, triangle, tuple(vertices), tuple(groups), entries)

    def matrix(
        self, gradients: Sequence[FloatArray], weights: Sequence[float | FloatArray]
    ) -> FloatArray:
        """Entries of J' W J in `triangle`, shape (entries,).

        gradients : of each group, shape (n, k, 3); what is given for vertex -1 does not count.
        weights : of each group, one number or one for each residual, shape (n,).
        """
        total = np.zeros((self._groups[0].sums.shape[0], 9)) if self._groups else np.zeros((0, 9))
        for group, gradient, weight in zip(self._groups, gradients, weights, strict=True):
            rising = np.take_along_axis(gradient, group.order[:, :, None], axis=1)
            weighted = rising * np.asarray(weight, float).reshape(-1, 1, 1)
            products = weighted[:, group.first, :, None] * rising[:, group.second, None, :]
            total += group.sums @ products.reshape(-1, 9)
        return total.ravel()[self._entries]

    def gradient(
        self,
        gradients: Sequence[FloatArray],
        weights: Sequence[float | FloatArray],
        values: Sequence[FloatArray],
    ) -> FloatArray:
        """J' W r, shape (count, 3).

        values : the residuals r of each group, shape (n,); the rest as for `matrix`.
        """
        total = np.zeros((self.count, 3))
        for group, gradient, weight, value in zip(
            self.vertices, gradients, weights, values, strict=True
        ):
            there = group >= 0
            pulls = np.asarray(weight * value).reshape(-1, 1, 1) * gradient
            total += scattered(group[there], pulls[there], self.count)
        return total


def _joined(arrays: Sequence[IntArray]) -> IntArray:
    return np.concatenate(arrays) if arrays else np.empty(0, np.int64)


def _expanded(blocks: Triangle) -> tuple[Triangle, IntArray]:
    """The triangle in which each entry of `blocks` is one of 3 x 3 numbers.

    And where each of its entries is in the blocks, one after another, row by row.
    """
    low = np.repeat(np.arange(blocks.size), np.diff(blocks.bounds))
    row, column = np.divmod(np.arange(9), 3)
    rows = (3 * blocks.rows[:, None] + row).ravel()
    columns = (3 * low[:, None] + column).ravel()
    kept = np.flatnonzero(rows >= columns)
    order = kept[np.lexsort((rows[kept], columns[kept]))]
    size = 3 * blocks.size
    bounds = np.searchsorted(columns[order], np.arange(size + 1))
    return Triangle(size, bounds, rows[order]), order
