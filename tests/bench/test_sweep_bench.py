"""Sweeps beside a bare pool of processes: what tables, parts and resuming cost, in one run.

`pytest tests/bench/test_sweep_bench.py --benchmark-only -s`; QUADFOLD_SWEEP=10000 for a large one.
"""

import os
import resource
import time

import pytest

from fab.sweeps.rows import Batch
from fab.sweeps.sweep_run import run_sweep
from fab.sweeps.sweep_settings import load_sweep
from fab.sweeps.variations import variations_of
from fab.sweeps.workers import batch_rows, local_pool

COUNT = int(os.environ.get("QUADFOLD_SWEEP", "400"))
JOBS, BATCH = 2, 50
BOUND = 0.85
SWEEP = """
name = "bench"
base = "curved_fold"
[axes]
design.k_deg = {{ from = 180.2, to = 181.5, steps = {count} }}
"""


def sweep_of(folder, count):
    path = folder / "bench.toml"
    path.write_text(SWEEP.format(count=count))
    return load_sweep(path)


def bare_seconds(sweep):
    """Of a pool that is given all batches at once, and drops what it gets."""
    every = list(variations_of(sweep, "bench"))
    batches = [Batch(sweep, tuple(every[i : i + BATCH])) for i in range(0, len(every), BATCH)]
    began = time.perf_counter()
    with local_pool(JOBS, sweep.limits) as pool:
        for rows in pool.map(batch_rows, batches):
            assert all(row["status"] == "made" for row in rows)
    return time.perf_counter() - began


@pytest.mark.benchmark(group="sweep")
def test_a_sweep_keeps_up_with_a_bare_pool(benchmark, tmp_path):
    sweep = sweep_of(tmp_path, COUNT)
    bare = bare_seconds(sweep)

    def swept():
        result = run_sweep(sweep, tmp_path / "out", jobs=JOBS)
        assert result.statuses == {"made": COUNT}

    benchmark.pedantic(swept, rounds=1)
    whole = benchmark.stats.stats.total
    parent_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"\n{COUNT} variations of 1000 quads: {whole:.1f} s, a bare pool {bare:.1f} s, ratio "
        f"{bare / whole:.2f}; parent at most {parent_mb:.0f} MB"
    )
    assert bare / whole >= BOUND
