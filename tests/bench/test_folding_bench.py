"""Folding: seconds and systems per model, growth of cost, against our own dynamic solver.

pytest tests/bench/test_folding_bench.py --benchmark-only -s
"""

import time

import numpy as np
import pytest

from fab.folding.bar_hinge_model import framework
from fab.folding.dynamics import DynamicSettings, integrate
from fab.folding.quasi_static import aligned, fold
from fab.folding.verdict import judge
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from solver import Crumpled, CurvedFold, Miura, SurfaceFit
from solver.vectors import norm


def frame_of(design):
    mesh = design.grow().mesh.cut_open()
    return framework(crease_pattern(mesh, develop(mesh), 10.0))


def seconds(work):
    begin = time.perf_counter()
    out = work()
    return time.perf_counter() - begin, out


DESIGNS = [Crumpled(), CurvedFold(), SurfaceFit()]


@pytest.mark.parametrize("design", DESIGNS, ids=lambda design: type(design).__name__)
def test_models_fold(benchmark, design):
    frame = frame_of(design)
    folding = benchmark.pedantic(lambda: fold(frame), rounds=1)
    verdict = judge(folding)
    faces = frame.sheet.pattern.face_count
    name, off = type(design).__name__, verdict.rmsd_rel
    print(f"\n{name}: {faces} faces, {folding.iterations} systems, off by {off:.1e}")
    assert verdict.reached


def test_the_cost_of_a_newton_solve_grows_little_faster_than_the_sheet(benchmark):
    sizes, costs = [], []
    for side in (10, 18, 32, 56, 100):
        frame = frame_of(Miura(columns=side, rows=side))
        frame.linearised(frame.vertices_coords, frame.hinges_target)  # finds the pattern once
        taken, folding = seconds(lambda frame=frame: fold(frame, 2))
        sizes.append(side * side)
        costs.append(taken / folding.iterations)
    exponent = float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])
    benchmark.pedantic(lambda: None, rounds=1)
    benchmark.extra_info.update(exponent=round(exponent, 2))
    listed = ", ".join(f"{n}: {1e3 * c:.1f} ms" for n, c in zip(sizes, costs, strict=True))
    print(f"\nper system: {listed}; exponent {exponent:.2f}")
    assert exponent < 1.3


def test_rest_to_rest_is_ten_times_faster_than_masses_that_move(benchmark):
    """Both from flat; the dynamic solver until it has the error that the other one ends with, or
    rests, or has taken a hundred times as long."""
    ratios = {}
    for name, design in (("Miura", Miura()), ("CurvedFold", CurvedFold(columns=30))):
        frame = frame_of(design)
        form = frame.sheet.pattern.folded_coords / frame.size_mm
        quick, folding = seconds(lambda frame=frame: fold(frame))
        wanted = max(error(folding.states[-1].coords, form), 1e-6)
        motion, slow = None, 0.0
        while slow < 100 * quick:
            settings = DynamicSettings(steps=500, settled_speed=0.0)
            taken, motion = seconds(
                lambda f=frame, s=settings, m=motion: integrate(f, f.hinges_target, s, m)
            )
            slow += taken
            if not motion.finite or error(motion.coords, form) <= wanted:
                break
        ratios[name] = round(slow / quick, 1)
        print(f"\n{name}: {slow / quick:.0f} times as long, to {error(motion.coords, form):.1e}")
    benchmark.pedantic(lambda: None, rounds=1)
    benchmark.extra_info.update(ratios)
    assert min(ratios.values()) > 10


def error(coords, form) -> float:
    off = aligned(coords, form) - form
    return float(np.sqrt((off**2).sum(axis=1).mean()) / norm(np.ptp(form, axis=0)))
