"""Clearance of all pairs of bodies at ten states, against building the bodies once.

    pytest tests/bench --benchmark-only

Ratios, the exponent of the cost and the peak of memory are in the benchmark's `extra_info`. The
states are exact folds of Miura sheets, so that the time of a simulation is not in it.
"""

import time
import tracemalloc
from dataclasses import replace

import numpy as np

from fab.clearance.thick_inspection import inspect_thick
from fab.folding.folded_states import Stage, flat_panels, panels_at
from fab.geometry.booleans import joined_mesh
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from solver import Miura

PANELS = PanelSettings(thickness_mm=0.8, gap_mm=0.4)
HINGES = HingeSettings(web_mm=0.2, relief_mm=0.1)


def folds(faces: int):
    """A Miura sheet of about as many faces, 20 mm each, and ten states from flat to its target."""
    side = round(faces**0.5)
    shares = np.linspace(0, 1, 10)
    states, target = [], None
    for share in shares[:0:-1]:
        mesh = Miura(columns=side, rows=side, fold=np.radians(45) * share).grow().mesh
        pattern = crease_pattern(mesh, develop(mesh), 20.0)
        target = pattern if target is None else target
        stage = Stage.TARGET if share == 1 else Stage.BETWEEN
        states.append(panels_at(target, pattern.folded_coords, stage, float(share)))
    assert max(state.bend_mm for state in states) < 1e-6
    return target, [flat_panels(target), *states[::-1]]


def seconds(ask, rounds: int) -> float:
    taken = []
    for _ in range(rounds):
        begin = time.perf_counter()
        ask()
        taken.append(time.perf_counter() - begin)
    return float(np.median(taken))


def test_clearance_against_building(benchmark):
    sizes = np.array([100, 400, 1600, 6400])
    costs, ratios, peaks = [], [], []
    for size in sizes:
        pattern, states = folds(size)
        sheet, _ = thicken(pattern, PANELS, HINGES)
        joined = joined_mesh(sheet.joining)

        def check(sheet=sheet, joined=joined, states=states):
            return inspect_thick(sheet, joined, states)

        def build(pattern=pattern):
            return thicken(pattern, PANELS, HINGES)

        rounds = 3 if size < 6400 else 1
        costs.append(seconds(check, rounds))
        ratios.append(round(costs[-1] / seconds(build, 3), 1))
        tracemalloc.start()
        figures, findings = check()
        peaks.append(round(tracemalloc.get_traced_memory()[1] / 1e6))
        tracemalloc.stop()
        assert findings == []
        assert figures.solids.panels == size
        assert all(state.clearance_min_mm > 0.28 for state in figures.clearance.states)
    benchmark.pedantic(check, rounds=1)
    exponent = float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])
    benchmark.extra_info.update(per_building=ratios, exponent=round(exponent, 2), peak_mb=peaks)
    print(f"\ncheck / build = {ratios}, exponent {exponent:.2f}, peak {peaks} MB, {costs} s")
    # a wrong pose is seen at every size
    state = states[-1]
    shifts = state.shifts.copy()
    shifts[0] += 0.2
    _, findings = inspect_thick(sheet, joined, [replace(state, shifts=shifts)])
    assert findings
