"""A scheduler and workers of Dask in processes of their own, as on other machines."""

import os
import re
import signal
import subprocess
import sys
from contextlib import suppress

import pytest
from sweep_tables import rows_of

from fab.errors import InvalidJob
from fab.sweeps.cluster import ClusterSettings
from fab.sweeps.sweep_run import run_sweep
from fab.sweeps.sweep_settings import load_sweep

pytest.importorskip("distributed", reason="distributed is not installed")

# Small sheets: what is shown is who does it. Killing waits for rows, and not for a time.
JOB = """
name = "c"
sheet = { width_mm = 100.0 }
design = { kind = "curved_fold", columns = 20, strips = 3 }
"""
SWEEP = """
name = "s"
base = "base.toml"
[axes]
design.k_deg = { from = 180.2, to = 181.5, steps = 40 }
"""


def started(*words, mark):
    """A program of Dask, and what it says it is at."""
    process = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    for line in process.stderr:
        found = re.search(mark, line)
        if found:
            return process, found[0]
    raise AssertionError(f"{words[0]} ended with {process.wait()}")


@pytest.fixture(scope="module")
def cluster():
    """The address of a scheduler with two workers, and the processes of these.

    For both tests, of which each kills another of them.
    """
    quiet = ("--no-dashboard",)
    scheduler, address = started(
        "dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        *quiet,
        mark=r"tcp://127\.0\.0\.1:\d+",
    )
    workers = [
        started("dask_worker", address, "--nthreads", "1", *quiet, mark="Registered to")[0]
        for _ in range(2)
    ]
    yield address, scheduler, workers
    for process in (*workers, scheduler):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        process.stderr.close()


@pytest.fixture
def sweep(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(SWEEP)
    (tmp_path / "base.toml").write_text(JOB)
    return load_sweep(path)


def test_a_worker_that_is_killed_in_the_middle_loses_nothing(here, cluster, sweep, tmp_path):
    address, _, workers = cluster
    run_sweep(sweep, tmp_path / "here")
    settings = ClusterSettings(kind="address", address=address, workers=2)
    killed = []

    def progress(stage, done, total):
        if stage == "sweep" and done and not killed:
            os.killpg(workers[0].pid, signal.SIGKILL)
            killed.append(done)

    result = run_sweep(sweep, tmp_path / "dask", cluster=settings, progress=progress)
    assert 0 < killed[0] < 40
    assert result.statuses == {"made": 40}
    assert rows_of(tmp_path / "dask") == rows_of(tmp_path / "here")


def test_what_is_done_is_kept_when_the_scheduler_goes(here, cluster, sweep, tmp_path):
    address, scheduler, _ = cluster
    settings = ClusterSettings(kind="address", address=address, workers=2)

    def progress(stage, done, total):
        if stage == "sweep" and done and scheduler.poll() is None:
            os.killpg(scheduler.pid, signal.SIGKILL)
            scheduler.wait()

    with pytest.raises(InvalidJob, match="the cluster is gone"):
        run_sweep(sweep, tmp_path / "out", cluster=settings, progress=progress)
    begun = len(list((tmp_path / "out/parts").glob("*.parquet")))
    assert begun
    result = run_sweep(sweep, tmp_path / "out")
    assert result.begun_with >= begun
    assert result.statuses == {"made": 40}


def test_a_cluster_without_workers_is_told(sweep, tmp_path, monkeypatch):
    from fab.sweeps import cluster as module

    monkeypatch.setattr(module, "_WORKERS_S", 1)
    scheduler, address = started(
        "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
        mark=r"tcp://127\.0\.0\.1:\d+",
    )  # fmt: skip
    try:
        settings = ClusterSettings(kind="address", address=address, workers=2)
        with pytest.raises(InvalidJob, match="no worker of the cluster came within 1 s"):
            run_sweep(sweep, tmp_path / "out", cluster=settings)
    finally:
        os.killpg(scheduler.pid, signal.SIGKILL)
        scheduler.wait()
        scheduler.stderr.close()
