"""Placing twenty to two thousand pieces: seconds per piece, and the share of the beds in use.

    pytest tests/bench --benchmark-only -s

`used` leaves out the last sheet. `relative_cost` is the time per piece over that of a fifth of the
pieces of the same kind, in the same run.
"""

import time

import pytest
from flat_patterns import stars

from fab.layout.nesting import nest

BED = (600.0, 400.0)


@pytest.mark.parametrize("count", [400, 2000])
def test_cost_of_a_piece(benchmark, count):
    begin = time.perf_counter()
    nest(stars(count // 5, count // 5), BED, 2.0)
    fifth = time.perf_counter() - begin
    placements = benchmark.pedantic(nest, args=(stars(count, count), BED, 2.0), rounds=1)
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
