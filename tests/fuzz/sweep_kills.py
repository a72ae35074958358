"""Kill a sweep at random moments, let it go on, and compare its table with that of a whole run.

    python tests/fuzz/sweep_kills.py --kills 10 --variations 300 --seed 1 --dask

Exits 1 where a row is lost, doubled or different, or a file is left beside its place. Alternates
between killing all processes of the sweep and one worker of it alone. With `--dask`, a scheduler
and two workers in processes of their own do the sweep as well; two workers are killed and replaced.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pyarrow.parquet as pq

SWEEP = """
name = "kills"
base = "curved_fold"
[axes]
design.k_deg = {{ from = 180.2, to = 181.5, steps = {count} }}
"""
_FIRST, _SECOND = 0.25, 0.6  # shares of the rows at which a worker of Dask is killed


def begun(sweep: Path, out: Path, *more: str) -> subprocess.Popen[bytes]:
    """A sweep in a group of its own."""
    words = ["sweep", str(sweep), "--out", str(out), *(more or ("--jobs", "2"))]
    return _started("fab", *words)


def workers_of(process: subprocess.Popen[bytes]) -> list[int]:
    """Processes that a sweep has started, by what the system says of their parents."""
    listed = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, check=False
    )
    return [int(word) for word in listed.stdout.split()]


def parts_of(folder: Path) -> int:
    """How many parts are there."""
    return len(list((folder / "parts").glob("*.parquet")))


def rows_in_parts(folder: Path) -> int:
    """How many rows they have; one that goes while it is looked at is not counted."""
    rows = 0
    for path in (folder / "parts").glob("*.parquet"):
        try:
            rows += pq.read_metadata(path).num_rows
        except OSError:
            continue
    return rows


def rows_of(folder: Path) -> list[dict[str, object]]:
    """The table without durations."""
    return pq.read_table(folder / "results.parquet").drop_columns(["seconds"]).to_pylist()


def strays_in(folder: Path) -> list[str]:
    """Files that are not in their place."""
    return [path.name for path in folder.rglob(".*") if path.name != ".lock"]


def killed_often(sweep: Path, out: Path, count: int, kills: int, numbers: random.Random) -> None:
    """A sweep that ends though it, or a worker of it, was killed so many times."""
    done = 0
    while done < kills:
        rows = rows_in_parts(out)
        rows += numbers.randint(0, max(1, 2 * (count - rows) // (kills - done + 1)))
        process = begun(sweep, out)
        while process.poll() is None and rows_in_parts(out) < rows:
            time.sleep(0.05)
        time.sleep(numbers.uniform(0.0, 0.6))
        if process.poll() is not None:
            break
        workers = workers_of(process)
        if done % 2 and workers:
            os.kill(numbers.choice(workers), signal.SIGKILL)
            time.sleep(numbers.uniform(0.0, 2.0))
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        done += 1
        print(f"kill {done}: {rows_in_parts(out)} rows in {parts_of(out)} parts", flush=True)
    assert begun(sweep, out).wait() == 0


def by_dask(sweep: Path, out: Path, count: int) -> None:
    """A sweep by a scheduler and two workers, of which two are killed and replaced."""
    with _dask() as (address, workers):
        process = begun(sweep, out, "--cluster", address)
        for share in (_FIRST, _SECOND):
            while process.poll() is None and rows_in_parts(out) < share * count:
                time.sleep(0.1)
            workers[0].kill()
            workers[0].wait()
            print(f"worker killed at {rows_in_parts(out)} rows", flush=True)
            workers[:] = [workers[1], _worker(address)]
        assert process.wait() == 0


@contextmanager
def _dask() -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """The address of a scheduler, and its workers."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    words = ["--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    scheduler = _started("distributed.cli.dask_scheduler", *words)
    workers = [_worker(address), _worker(address)]
    try:
        yield address, workers
    finally:
        for process in (*workers, scheduler):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


def _worker(address: str) -> subprocess.Popen[bytes]:
    """A worker that goes with its process, as on a machine that is lost."""
    words = [address, "--nthreads", "1", "--no-dashboard", "--no-nanny"]
    return _started("distributed.cli.dask_worker", *words)


def _started(module: str, *words: str) -> subprocess.Popen[bytes]:
    """A module that runs in a group of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", module, *words],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=None if module == "fab" else subprocess.DEVNULL,
    )


def main() -> int:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--variations", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--dask", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sweep = folder / "kills.toml"
        sweep.write_text(SWEEP.format(count=options.variations))
        assert begun(sweep, folder / "whole").wait() == 0
        print("whole run done", flush=True)
        whole, good = rows_of(folder / "whole"), True
        killed_often(
            sweep, folder / "killed", options.variations, options.kills, random.Random(options.seed)
        )
        if options.dask:
            by_dask(sweep, folder / "dask", options.variations)
        for out in ("killed", *(["dask"] if options.dask else [])):
            found, strays = rows_of(folder / out), strays_in(folder / out)
            same = found == whole and len(found) == options.variations
            print(f"{out}: {len(found)} rows of {len(found[0])} columns and seconds, ", end="")
            print(f"same as a whole run: {same}, stray: {strays}", flush=True)
            good = good and same and not strays
        return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
