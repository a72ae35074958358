"""Perforation of a whole pattern against copying its dashes, and in microseconds a dash.

    pytest tests/bench/test_perforation_bench.py --benchmark-only -s

Both figures are in the benchmark's `extra_info`.
"""

import time

import numpy as np
import pytest

from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.sheets.crease_styles import DashDotStyle, DashStyle, DotStyle, LatticeStyle
from fab.sheets.perforation import cut_layers
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.relief_holes import ReliefSettings
from solver import Miura

STYLES = [
    DashStyle(cut_mm=0.5, gap_mm=0.25),
    DashDotStyle(cut_mm=0.6, dot_mm=0.15, gap_mm=0.2),
    DotStyle(dot_mm=0.1, pitch_mm=0.5),
    LatticeStyle(cut_mm=1.5, gap_mm=0.4, rows=3, pitch_mm=0.5),
]


def seconds_of(ask, rounds):
    """The least of several, of this process alone: other work on the machine does not count."""
    taken = []
    for _ in range(rounds):
        begin = time.process_time()
        ask()
        taken.append(time.process_time() - begin)
    return min(taken)


@pytest.mark.parametrize("relief", [None, ReliefSettings(web_mm=0.5)], ids=["plain", "relief"])
@pytest.mark.parametrize("style", STYLES, ids=lambda style: style.kind)
def test_perforation_costs_at_most_two_microseconds_a_dash(benchmark, style, relief):
    mesh = Miura(columns=100, rows=100).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    settings = PerforationSettings(mountain=style, valley=style, relief=relief)

    def perforate():
        return cut_layers(pattern, settings, 0.05)

    layers, _ = perforate()
    segments = np.concatenate([layer.segments for layer in layers])
    assert len(segments) > 100_000
    seconds = seconds_of(perforate, 3)
    copying = seconds_of(lambda: segments.copy(), 15)
    benchmark.pedantic(perforate, rounds=1)
    per_dash = 1e6 * seconds / len(segments)
    benchmark.extra_info.update(us_per_dash=per_dash, per_copy=seconds / copying)
    print(
        f"\n{style.kind}: {len(segments)} dashes, {per_dash:.3f} us a dash, "
        f"{seconds / copying:.0f} times copying them"
    )
    assert per_dash < 2.0
