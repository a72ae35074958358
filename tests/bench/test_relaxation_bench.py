"""Relaxation: against one growth of the same size, cost of a round, against scipy's least squares.

pytest tests/bench/test_relaxation_bench.py --benchmark-only -s
"""

import time

import numpy as np
import pytest
from relaxed_surfaces import bump, bump_sheet, hemisphere
from scipy.optimize import least_squares
from scipy.sparse import csr_array

from solver import Status, fit_surface
from solver.relaxation import RelaxationStatus, Wishes, pleated_patch, relaxed_sheet
from solver.relaxation.sheet_fit import sheet_terms


def seconds(work):
    begin = time.perf_counter()
    out = work()
    return time.perf_counter() - begin, out


def test_relaxation_against_one_growth_of_the_same_size(benchmark):
    """A low bump that growth covers; both 40 columns and about as many rows."""
    surface = bump(0.2)
    sheet = pleated_patch(surface, 40, zigzag=3.0, spacing=1.0, thickness=1.0)
    growths, sizes = [], []
    for _ in range(3):
        taken, growth = seconds(
            lambda: fit_surface(surface, 40, zigzag=3.0, row_step=1.0, thickness=1.0, turn=0.0)
        )
        growths.append(taken)
        sizes.append(len(growth.mesh.faces_vertices))
    taken, fit = seconds(lambda: relaxed_sheet(surface, sheet))
    benchmark.pedantic(lambda: None, rounds=1)
    faces = len(fit.mesh.faces_vertices)
    per_growth = np.median(growths) / sizes[0] * faces
    ratio = taken / per_growth
    benchmark.extra_info.update(ratio=round(ratio, 1))
    print(
        f"\n{faces} faces in {taken:.2f} s, {fit.relaxation.rounds} rounds; growth {growth.status} "
        f"{sizes[0]} faces in {np.median(growths):.2f} s; ratio per face {ratio:.1f}"
    )
    assert growth.status is Status.GROWN
    assert fit.relaxation.status is RelaxationStatus.RELAXED
    assert ratio <= 15


@pytest.mark.parametrize("sizes", [(20, 28, 40, 56, 80)])
def test_the_cost_of_a_round_grows_little_faster_than_the_sheet(benchmark, sizes):
    """160 by hand: add it to the sizes."""
    faces, costs = [], []
    for columns in sizes:
        target, sheet = hemisphere(columns)
        start = sheet.points(target)
        ticks = []
        relaxed_sheet(
            target,
            sheet,
            Wishes(),
            start=start,
            rounds=8,
            progress=lambda number, residual, ticks=ticks: ticks.append(time.perf_counter()),
        )
        faces.append(len(start))
        costs.append(float(np.median(np.diff(ticks))))
    exponent = float(np.polyfit(np.log(faces), np.log(costs), 1)[0])
    benchmark.pedantic(lambda: None, rounds=1)
    benchmark.extra_info.update(exponent=round(exponent, 2))
    listed = ", ".join(f"{n}: {1e3 * c:.0f} ms" for n, c in zip(faces, costs, strict=True))
    print(f"\nper round: {listed}; exponent {exponent:.2f}")
    assert exponent <= 1.35


def test_relaxation_against_scipy_least_squares(benchmark):
    """The same terms with the hard ones at the weight 1e4, by `least_squares` (trf, lsmr), for as
    long as it takes to come as near to zero as relaxation does before its projection, or a hundred
    times as long."""
    target, sheet = bump_sheet(0.5)
    hard, soft = sheet_terms(target, sheet, Wishes())
    start = sheet.points(target)
    weighted = [(term, 100.0) for term in hard] + [(w.term, w.weight**0.5) for w in soft]

    def parts(x):
        return [(term.linearised(x.reshape(-1, 3)), weight) for term, weight in weighted]

    def values(x):
        return np.concatenate([weight * linear.values for linear, weight in parts(x)])

    def jacobian(x):
        rows, columns, data, begin = [], [], [], 0
        for linear, weight in parts(x):
            count, width = linear.term.vertices.shape
            there = np.repeat(linear.term.vertices.ravel() >= 0, 3)
            rows.append(np.repeat(begin + np.arange(count), 3 * width)[there])
            unknowns = 3 * linear.term.vertices[:, :, None] + np.arange(3)
            columns.append(unknowns.ravel()[there])
            data.append(weight * linear.gradients.ravel()[there])
            begin += count
        entries = np.concatenate(data), (np.concatenate(rows), np.concatenate(columns))
        return csr_array(entries, shape=(begin, x.size))

    taken, fit = seconds(lambda: relaxed_sheet(target, sheet))
    slow, other = seconds(
        lambda: least_squares(
            values, start.ravel(), jacobian, method="trf", tr_solver="lsmr", max_nfev=100
        )
    )
    residual = max(np.abs(t.linearised(other.x.reshape(-1, 3)).values).max() for t in hard)
    benchmark.pedantic(lambda: None, rounds=1)
    benchmark.extra_info.update(times_as_long=round(slow / taken, 1))
    print(
        f"\nrelaxation {taken:.2f} s to {fit.relaxation.hard_residual:.1e}; least_squares "
        f"{slow:.2f} s and {other.nfev} evaluations to {residual:.1e}"
    )
    assert slow > 2 * taken
    assert residual > 1e-7
