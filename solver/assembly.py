"""Assembly of J' W J, the matrix of least squares over points in space.

Each row of J, one residual, has gradients at few vertices, with three coordinates each. Which
vertices these are does not change: where every product of gradients belongs in the matrix is found
once, and each later matrix is a few array operations. Blocks of second derivatives may be added,
whose vertices may change from matrix to matrix within the sparsity (`NormalAssembly.covers`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from solver.errors import InvalidState
from solver.sparse import Triangle
from solver.vectors import FloatArray, IntArray, scattered

__all__ = ["Blocks", "NormalAssembly"]

# Products that are added up at a time: so many stay in a processor's cache.
_PRODUCTS = 8192


@dataclass(frozen=True)
class Blocks:
    """Symmetric matrices, each over the coordinates of k vertices, that are added up.

    Attributes
    ----------
    vertices : shape (n, k), distinct in each row, -1 for none.
    matrices : shape (n, 3 k, 3 k); coordinate c of the vertex at position j is number 3 j + c.
    """

    vertices: IntArray
    matrices: FloatArray


@dataclass(frozen=True)
class _Run:
    """Blocks one after another, with the products of gradients that are added in them.

    Attributes
    ----------
    high, low : gradients whose product each is, by their places among all gradients, one residual
        after another, shape (n,).
    starts : where the products of each block begin, shape (end - begin,).
    begin, end : of the blocks, among those that have products.
    """

    high: IntArray
    low: IntArray
    starts: IntArray
    begin: int
    end: int


@dataclass(frozen=True)
class NormalAssembly:
    """Where the products of gradients are added in the lower triangle of J' W J.

    Coordinate c of vertex v is unknown 3 v + c.

    Attributes
    ----------
    count : number of vertices. triangle : sparsity of the matrix.
    vertices : of each group of residuals, shape (n, k) each, -1 for none.
    blocks : pairs of vertices that have entries, as the sparsity of a matrix over the vertices.

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
    blocks: Triangle
    _runs: tuple[_Run, ...]
    _filled: IntArray
    _entries: IntArray

    @classmethod
    def of(
        cls, count: int, vertices: Sequence[IntArray], beside: Sequence[IntArray] = ()
    ) -> NormalAssembly:
        """The assembly of groups of residuals over `count` vertices.

        vertices : of each group, shape (n, k), -1 where a residual has fewer than k. beside : those
        of blocks that may be added, shape (n, k) each. Raises `InvalidState` where a residual names
        a vertex twice.
        """
        pairs = [_Pairs.of(group) for group in [*vertices, *beside]]
        # blocks are found as the entries of a matrix that has one row for each vertex
        blocks, slots = Triangle.of(
            count, _joined([each.high for each in pairs]), _joined([each.low for each in pairs])
        )
        triangle, entries = _expanded(blocks)
        firsts, seconds, begin = [], [], 0
        for each in pairs[: len(vertices)]:
            residual = begin + each.order.shape[1] * np.arange(len(each.order))[:, None]
            firsts.append((residual + each.order[:, each.first]).ravel())
            seconds.append((residual + each.order[:, each.second]).ravel())
            begin += each.order.size
        high, low = _joined(firsts), _joined(seconds)
        used = np.flatnonzero(slots[: len(high)] < len(blocks.rows))
        used = used[np.argsort(slots[used], kind="stable")]
        filled, starts = np.unique(slots[used], return_index=True)
        runs = tuple(_runs(high[used], low[used], starts))
        return cls(count, triangle, tuple(vertices), blocks, runs, filled, entries)

    def covers(self, vertices: IntArray) -> bool:
        """Whether blocks over these vertices, shape (n, k), may be added to the matrix."""
        places, number = self._places(_Pairs.of(vertices)), len(self.blocks.rows)
        return bool((places <= number).all())

    def extended(self, beside: Sequence[IntArray]) -> NormalAssembly:
        """The same residuals, and the sparsity of further blocks besides that of these."""
        return NormalAssembly.of(self.count, self.vertices, [self.joined, *beside])

    @property
    def joined(self) -> IntArray:
        """All pairs of two vertices that have entries, shape (n, 2)."""
        low = np.repeat(np.arange(self.count), np.diff(self.blocks.bounds))
        off = np.flatnonzero(self.blocks.rows != low)
        return np.column_stack([self.blocks.rows[off], low[off]])

    def matrix(
        self,
        gradients: Sequence[FloatArray],
        weights: Sequence[float | FloatArray],
        blocks: Sequence[Blocks] = (),
    ) -> FloatArray:
        """Entries of J' W J in `triangle`, shape (entries,), and of the blocks that are added.

        gradients : of each group, shape (n, k, 3); what is given for vertex -1 does not count.
        weights : of each group, one number or one for each residual, shape (n,).
        blocks : each of them covered.
        """
        pairs = list(zip(gradients, weights, strict=True))
        plain = _columns([gradient for gradient, _ in pairs])
        weighted = _columns([_times(weight, gradient) for gradient, weight in pairs])
        count = len(self.blocks.rows)
        total = np.zeros((3, 3, count))
        sums = total if len(self._filled) == count else np.empty((3, 3, len(self._filled)))
        for run in self._runs:
            left = weighted.take(run.high, axis=1)[:, None]
            products = left * plain.take(run.low, axis=1)[None]
            np.add.reduceat(products, run.starts, axis=2, out=sums[:, :, run.begin : run.end])
        if sums is not total:
            total[:, :, self._filled] = sums
        for added in blocks:
            total += self._summed(added)
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
            pulls = _times(weight * value, gradient)
            total += scattered(group[there], pulls[there], self.count)
        return total

    def _summed(self, added: Blocks) -> FloatArray:
        """Blocks of the matrix, shape (3, 3, blocks), of those that are added."""
        count, width = added.vertices.shape
        pairs = _Pairs.of(added.vertices)
        parts = added.matrices.reshape(count, width, 3, width, 3).swapaxes(2, 3)
        row = np.arange(count)[:, None]
        products = parts[row, pairs.order[:, pairs.first], pairs.order[:, pairs.second]]
        sums = _sums(self._places(pairs), len(self.blocks.rows))
        return np.asarray((sums @ products.reshape(-1, 9)).T.reshape(3, 3, -1))

    def _places(self, pairs: _Pairs) -> IntArray:
        """Slots of pairs in `blocks`: their number for none, more where they are not covered."""
        number = len(self._keys)
        keys = pairs.low.astype(np.int64) * self.count + pairs.high
        places = np.searchsorted(self._keys, keys)
        found = self._keys[np.minimum(places, number - 1)] == keys if number else keys < 0
        return np.where(pairs.low < 0, number, np.where(found, places, number + 1))

    @cached_property
    def _keys(self) -> IntArray:
        low = np.repeat(np.arange(self.count, dtype=np.int64), np.diff(self.blocks.bounds))
        return low * self.count + self.blocks.rows


@dataclass(frozen=True)
class _Pairs:
    """Pairs of the k vertices of residuals or blocks.

    Attributes
    ----------
    order : shape (n, k), positions of each residual's vertices by rising number.
    first, second : shape (k (k + 1) / 2,), positions in that order of each pair, first >= second.
    high, low : numbers of both vertices, one residual after another, -1 for none.
    """

    order: IntArray
    first: IntArray
    second: IntArray
    high: IntArray
    low: IntArray

    @classmethod
    def of(cls, vertices: IntArray) -> _Pairs:
        order = np.argsort(vertices, axis=1, kind="stable")
        rising = np.take_along_axis(vertices, order, axis=1)
        if ((rising[:, 1:] == rising[:, :-1]) & (rising[:, 1:] >= 0)).any():
            raise InvalidState(
                "vertices",
                "a residual names a vertex twice",
                "Give each vertex once, with the sum of its gradients.",
            )
        first, second = np.tril_indices(vertices.shape[1])
        return cls(order, first, second, rising[:, first].ravel(), rising[:, second].ravel())


def _sums(places: IntArray, number: int) -> csr_array:
    """The matrix that adds what belongs to each of `number` places, shape (number, n)."""
    used = np.flatnonzero(places < number)
    return csr_array((np.ones(len(used)), (places[used], used)), shape=(number, len(places)))


def _runs(high: IntArray, low: IntArray, starts: IntArray) -> Iterator[_Run]:
    """The products of all blocks, in runs that a processor's cache holds."""
    ends = np.append(starts[1:], len(high))
    begin = 0
    while begin < len(starts):
        first = starts[begin]
        end = max(int(np.searchsorted(ends, first + _PRODUCTS, side="right")), begin + 1)
        part = slice(first, ends[end - 1])
        yield _Run(high[part], low[part], starts[begin:end] - first, begin, end)
        begin = end


def _columns(gradients: Sequence[FloatArray]) -> FloatArray:
    """All gradients, one residual after another, shape (3, n)."""
    rows = [gradient.reshape(-1, 3) for gradient in gradients]
    return np.ascontiguousarray(np.concatenate(rows).T) if rows else np.empty((3, 0))


def _times(weight: float | FloatArray, gradient: FloatArray) -> FloatArray:
    """Gradients, shape (n, k, 3), times a weight of each residual."""
    return np.asarray(weight, float).reshape(-1, 1, 1) * gradient


def _joined(arrays: Sequence[IntArray]) -> IntArray:
    return np.concatenate(arrays) if arrays else np.empty(0, np.int64)


def _expanded(blocks: Triangle) -> tuple[Triangle, IntArray]:
    """The triangle in which each entry of `blocks` is one of 3 x 3 numbers.

    And where each of its entries is in the blocks: in an array of shape (3, 3, blocks).
    """
    low = np.repeat(np.arange(blocks.size), np.diff(blocks.bounds))
    row, column = np.divmod(np.arange(9), 3)
    rows = (3 * blocks.rows[:, None] + row).ravel()
    columns = (3 * low[:, None] + column).ravel()
    kept = np.flatnonzero(rows >= columns)
    order = kept[np.lexsort((rows[kept], columns[kept]))]
    size = 3 * blocks.size
    bounds = np.searchsorted(columns[order], np.arange(size + 1))
    block, place = np.divmod(order, 9)
    return Triangle(size, bounds, rows[order]), place * len(blocks.rows) + block
