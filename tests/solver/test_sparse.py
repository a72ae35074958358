"""Symmetric sparse systems against dense ones, and the assembly of their matrices."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver import InvalidState, InvalidValue
from solver.assembly import NormalAssembly
from solver.sparse import SymmetricSystem, Triangle

seeds = st.integers(0, 2**32 - 1)


def random_matrix(seed, size, definite):
    """A sparse symmetric matrix, dense, that is not nearly singular."""
    rng = np.random.default_rng(seed)
    dense = np.where(rng.random((size, size)) < 0.2, rng.normal(size=(size, size)), 0)
    dense = dense + dense.T
    shift = np.abs(dense).sum(axis=1) + 1
    return dense + np.diag(shift if definite else shift * rng.choice([-1, 1], size))


def system_of(dense):
    """Its analysis, and its entries: those of both triangles are one number."""
    rows, columns = np.nonzero(dense)
    kept = rows >= columns
    rows, columns = rows[kept], columns[kept]
    triangle, slots = Triangle.of(len(dense), rows, columns)
    return SymmetricSystem(triangle), triangle.summed(slots, dense[rows, columns])


@given(seeds, st.integers(1, 40), st.booleans())
def test_solutions_and_inertia_are_those_of_the_dense_matrix(seed, size, definite):
    dense = random_matrix(seed, size, definite)
    right = np.random.default_rng(seed).normal(size=size)
    system, data = system_of(dense)
    factors = system.factorised(data)
    solution = factors.solve(right)
    assert solution.good
    assert solution.solver == "rslab"
    np.testing.assert_allclose(dense @ solution.x, right, atol=1e-12 * size)
    positive = int((np.linalg.eigvalsh(dense) > 0).sum())
    assert factors.inertia == (positive, size - positive, 0)


@given(seeds, st.integers(1, 12))
def test_a_triangle_holds_each_entry_once(seed, size):
    rng = np.random.default_rng(seed)
    rows, columns = rng.integers(-1, size, (2, 50))
    values = rng.normal(size=50)
    triangle, slots = Triangle.of(size, rows, columns)
    wanted = np.zeros((size, size))
    there = (rows >= 0) & (columns >= 0)
    low, high = np.minimum(rows, columns)[there], np.maximum(rows, columns)[there]
    np.add.at(wanted, (high, low), values[there])
    lower = triangle.lower(triangle.summed(slots, values))
    np.testing.assert_allclose(lower.toarray(), wanted, atol=1e-14)
    assert lower.has_canonical_format
    assert (triangle.rows[triangle.diagonal] == np.arange(size)).all()


def test_super_lu_takes_over_where_rslab_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "rslab", None)
    dense = random_matrix(3, 30, definite=False)
    system, data = system_of(dense)
    factors = system.factorised(data)
    solution = factors.solve(np.ones(30))
    assert solution.good
    assert solution.solver == "SuperLU"
    assert factors.inertia is None
    np.testing.assert_allclose(dense @ solution.x, 1, atol=1e-12)


@pytest.mark.parametrize("fault", ["fails", "is wrong"])
def test_super_lu_takes_over_where_rslab(monkeypatch, fault):
    class Wrong:
        inertia = (30, 0, 0)

        def factor(self, data):
            if fault == "fails":
                raise RuntimeError("a pivot is zero")
            return self

        def solve(self, right):
            return 2 * right

    import rslab

    monkeypatch.setattr(rslab, "analyze", lambda *args, **kwargs: Wrong())
    dense = random_matrix(4, 30, definite=True)
    system, data = system_of(dense)
    solution = system.factorised(data).solve(np.ones(30))
    assert solution.good
    assert solution.solver == "SuperLU"
    np.testing.assert_allclose(dense @ solution.x, 1, atol=1e-12)


@pytest.mark.parametrize("data", [[1.0, 1.0, 1.0], [0.0, 0.0, 0.0], [np.nan, 1.0, 1.0]])
def test_a_singular_matrix_has_no_good_solution(data):
    triangle, _ = Triangle.of(2, np.array([1]), np.array([0]))
    factors = SymmetricSystem(triangle).factorised(np.array(data))
    assert not factors.solve(np.array([1.0, 2.0])).good


def test_badly_scaled_systems_are_solved_to_rounding():
    triangle, _ = Triangle.of(2, np.array([1]), np.array([0]))
    factors = SymmetricSystem(triangle).factorised(np.array([1e8, 1.0, 1e-6]))
    assert factors.solve(np.array([1.0, 1.0])).error < 1e-15


def test_the_entries_must_be_those_of_the_triangle():
    triangle, _ = Triangle.of(2, np.array([1]), np.array([0]))
    with pytest.raises(InvalidValue, match=r"have shape \(3,\)"):
        SymmetricSystem(triangle).factorised(np.ones(4))


@given(seeds, st.integers(5, 9))
def test_assembled_matrices_are_products_of_jacobians(seed, count):
    rng = np.random.default_rng(seed)
    groups = [
        np.array([rng.permutation(count)[:width] for _ in range(number)])
        for width, number in ((1, 6), (2, 8), (5, 4))
    ]
    groups[2][rng.random(groups[2].shape) < 0.3] = -1
    gradients = [rng.normal(size=(*group.shape, 3)) for group in groups]
    weights = [2.0, rng.random(8), 0.5]
    values = [rng.normal(size=len(group)) for group in groups]
    rows, scale = [], []
    for group, gradient, weight in zip(groups, gradients, weights, strict=True):
        dense = np.zeros((len(group), count + 1, 3))
        dense[np.arange(len(group))[:, None], group] = gradient
        rows.append(dense[:, :count].reshape(len(group), -1))
        scale.append(np.broadcast_to(weight, len(group)))
    jacobian, w = np.concatenate(rows), np.concatenate(scale)
    assembly = NormalAssembly.of(count, groups)
    lower = assembly.triangle.lower(assembly.matrix(gradients, weights))
    wanted = jacobian.T @ (w[:, None] * jacobian)
    np.testing.assert_allclose(lower.toarray(), np.tril(wanted), atol=1e-13)
    pull = assembly.gradient(gradients, weights, values)
    np.testing.assert_allclose(pull.ravel(), jacobian.T @ (w * np.concatenate(values)), atol=1e-13)


def test_a_residual_names_each_vertex_once():
    with pytest.raises(InvalidState, match="names a vertex twice"):
        NormalAssembly.of(3, [np.array([[0, 2, 0]])])
