"""Relaxation: against one growth, cost of a round, large sheets, against other methods.

pytest tests/bench/test_relaxation_bench.py --benchmark-only -s

Seconds are of the processor, all threads together, so that what else runs does not count.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from relaxed_surfaces import bump, bump_sheet, hemisphere
from scipy.optimize import least_squares
from scipy.sparse import csr_array

from solver import Status, fit_surface
from solver.relaxation import RelaxationStatus, Wishes, pleated_patch, relaxed_sheet
from solver.relaxation.projection import projected
from solver.relaxation.sheet_fit import sheet_terms


def seconds(work):
    begin = time.process_time()
    out = work()
    return time.process_time() - begin, out


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


def test_the_cost_of_a_round_grows_little_faster_than_the_sheet(benchmark):
    """Square sheets over a hemisphere, from 20 to 160 columns."""
    faces, costs = [], []
    for columns in (20, 28, 40, 56, 80, 112, 160):
        target, sheet = hemisphere(columns)
        start = sheet.points(target)
        ticks = []
        relaxed_sheet(
            target,
            sheet,
            Wishes(),
            start=start,
            rounds=9,
            progress=lambda number, residual, ticks=ticks: ticks.append(time.process_time()),
        )
        faces.append(len(sheet.faces_vertices))
        costs.append(float(np.median(np.diff(ticks))))
    exponent = float(np.polyfit(np.log(faces), np.log(costs), 1)[0])
    benchmark.pedantic(lambda: None, rounds=1)
    benchmark.extra_info.update(exponent=round(exponent, 2))
    listed = ", ".join(f"{n}: {1e3 * c:.0f} ms" for n, c in zip(faces, costs, strict=True))
    print(f"\nper round, by faces: {listed}; exponent {exponent:.2f}")
    assert exponent <= 1.35


HEMISPHERE = """
import json, resource, sys, time
import numpy as np
sys.path[:0] = sys.argv[1:]
from surface_meshes import cap, mesh_of
from solver import Status, developability, planarity
from solver.relaxed_fit import relaxed_fit
from solver.self_intersection import crossing_faces

mesh = mesh_of(cap(np.pi / 2, 60, 150))
begin = time.process_time(), time.perf_counter()
fit = relaxed_fit(mesh, 160)
seconds = time.process_time() - begin[0], time.perf_counter() - begin[1]
coords, faces = fit.mesh.vertices_coords, fit.mesh.faces_vertices
print(json.dumps({
    "status": fit.status, "sheets": fit.chosen["sheets"], "faces": len(faces),
    "cpu_s": round(seconds[0]), "wall_s": round(seconds[1]),
    "gb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20, 2),
    "planarity": planarity(coords, faces).max(),
    "developability": developability(coords, faces).max(),
    "crossings": len(crossing_faces(coords, *fit.mesh.polygons)),
    "coverage": fit.coverage,
    "off": float(np.abs(fit.deviations).max() / fit.chosen["step"]),
}))
"""


def test_160_columns_on_a_hemisphere(benchmark):
    """By the search that jobs use, in a process of its own for its memory."""
    tests = Path(__file__).parents[1]
    done = benchmark.pedantic(
        subprocess.run,
        args=([sys.executable, "-c", HEMISPHERE, str(tests)],),
        kwargs={"capture_output": True, "text": True, "check": True},
        rounds=1,
    )
    figures = json.loads(done.stdout)
    benchmark.extra_info.update(figures)
    print(f"\nhemisphere of 160 columns: {figures}")
    assert figures["status"] == Status.GROWN
    assert figures["sheets"] == 1
    assert figures["crossings"] == 0
    assert max(figures["planarity"], figures["developability"]) <= 1e-12
    assert figures["coverage"] >= 0.99
    assert figures["off"] <= 0.15
    assert figures["gb"] <= 3
    assert figures["cpu_s"] <= 300  # on two cores, no more seconds than that


def test_relaxation_against_minimal_norm_gauss_newton(benchmark):
    """The shortest steps that meet the hard terms, from the same start, without any soft term."""
    target, sheet = bump_sheet(0.5, 40)
    hard, soft = sheet_terms(target, sheet, Wishes())
    quick, bare = seconds(lambda: projected(sheet.points(target), hard, sheet.cell.step))
    taken, fit = seconds(lambda: relaxed_sheet(target, sheet))
    off = float(np.abs(soft[0].term.linearised(bare.coords).values).max())
    least = float(np.abs(fit.deviations).max())
    dome, grid = hemisphere(24)
    lost = projected(grid.points(dome), sheet_terms(dome, grid, Wishes())[0], grid.cell.step)
    benchmark.pedantic(lambda: None, rounds=1)
    benchmark.extra_info.update(times_nearer=round(off / least, 1))
    print(
        f"\nrelaxation {taken:.2f} s, {least:.3f} steps off at {fit.relaxation.hard_residual:.0e}; "
        f"Gauss-Newton {quick:.2f} s, {off:.3f} steps off at {bare.residuals[-1]:.0e}; on a "
        f"hemisphere it ends at {lost.residuals[-1]:.1g}"
    )
    assert off > 5 * least
    assert lost.residuals[-1] > 0.01


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
