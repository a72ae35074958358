"""Assembly of J' W J and blocks against dense sums."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.assembly import Blocks, NormalAssembly
from solver.errors import InvalidState


def dense(assembly, entries):
    lower = assembly.triangle.lower(entries).toarray()
    return lower + np.tril(lower, -1).T


def some_vertices(random, count, rows, width):
    """Distinct vertices in each row, some of them missing."""
    out = np.array([random.permutation(count)[:width] for _ in range(rows)]).reshape(rows, width)
    out[random.random(out.shape) < 0.15] = -1
    return out


def unknowns(vertices):
    return (3 * vertices[:, None] + np.arange(3)).ravel()


@given(seed=st.integers(0, 10_000), count=st.integers(4, 9))
@settings(max_examples=40, deadline=None)
def test_matrices_are_sums_of_products_and_blocks(seed, count):
    random = np.random.default_rng(seed)
    groups = [some_vertices(random, count, 6, 2), some_vertices(random, count, 3, 4)]
    gradients = [random.normal(size=(*group.shape, 3)) for group in groups]
    weights = [random.random(6), 0.3]
    added = some_vertices(random, count, 4, 3)
    half = random.normal(size=(4, 9, 9))
    blocks = Blocks(added, half + half.swapaxes(1, 2))
    plain = NormalAssembly.of(count, groups)
    wide = plain.extended([added])
    assert wide.covers(added)
    assert all(wide.covers(group) for group in groups)
    expected = np.zeros((3 * count, 3 * count))
    for group, gradient, weight in zip(groups, gradients, weights, strict=True):
        for row, slope, factor in zip(
            group, gradient, np.broadcast_to(weight, len(group)), strict=True
        ):
            own = row >= 0
            flat = slope[own].ravel()
            expected[np.ix_(unknowns(row[own]), unknowns(row[own]))] += factor * np.outer(
                flat, flat
            )
    alone = dense(plain, plain.matrix(gradients, weights))
    assert alone == pytest.approx(expected, abs=1e-12)
    assert dense(wide, wide.matrix(gradients, weights)) == pytest.approx(expected, abs=1e-12)
    for row, block in zip(blocks.vertices, blocks.matrices, strict=True):
        places, kept = unknowns(row[row >= 0]), np.repeat(row >= 0, 3)
        expected[np.ix_(places, places)] += block[np.ix_(kept, kept)]
    found = dense(wide, wide.matrix(gradients, weights, [blocks]))
    assert found == pytest.approx(expected, abs=1e-12)


def test_what_is_covered():
    line = NormalAssembly.of(4, [np.array([[0, 1], [1, 2]])])
    assert line.covers(np.array([[2, 1], [3, -1]]))  # every vertex by itself is
    assert not line.covers(np.array([[0, 2]]))
    assert line.extended([np.array([[0, 2]])]).covers(np.array([[2, 1, 0]]))
    assert not line.extended([np.array([[0, 2]])]).covers(np.array([[3, 0]]))
    with pytest.raises(InvalidState, match="twice"):
        line.covers(np.array([[1, 1]]))
