"""Placing twenty to two thousand pieces: seconds per piece, and the share of the beds in use.

    pytest tests/bench --benchmark-only -s

`used` leaves out the last sheet. `relative_cost` is the time per piece over that of a fifth of the
pieces of the same kind, in the same run.
"""

import time

import numpy as np
import pytest

from fab.nesting import nest

BED = (600.0, 400.0)


def stars(count, size=60.0):
    """Concave pieces of four to eleven corners, seen whole from their middle."""
    rng = np.random.default_rng(count)
    out = []
    for _ in range(count):
        corners = rng.integers(4, 12)
        angle = (np.arange(corners) + rng.uniform(0, 0.8, corners)) * 2 * np.pi / corners
        radius = size / 2 * rng.uniform(0.4, 1, corners)
        out.append(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
    return out


@pytest.mark.parametrize("count", [400, 2000])
def test_cost_of_a_piece(benchmark, count):
    begin = time.perf_counter()
    nest(stars(count // 5), BED, 2.0)
    fifth = time.perf_counter() - begin
    placements = benchmark.pedantic(nest, args=(stars(count), BED, 2.0), rounds=1)
    seconds = benchmark.stats.stats.median
    figures = {
        "sheets": len(placements.used),
        "used": round(float(placements.used[:-1].mean()), 3),
        "relative_cost": round(seconds / (5 * fifth), 2),
        "ms_per_piece": round(1e3 * seconds / count),
    }
    benchmark.extra_info.update(figures)
    print(f"\n{count} pieces: {figures}")
    assert figures["relative_cost"] < 3
