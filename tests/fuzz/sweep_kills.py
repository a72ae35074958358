"""Kill a sweep at random moments, let it go on, and compare its table with that of a whole run.

    python tests/fuzz/sweep_kills.py --kills 10 --variations 300 --seed 1

Exits 1 where a row is lost, doubled or different, or a file is left beside its place. Alternates
between killing all processes of the sweep and one worker of it alone.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pyarrow.parquet as pq

SWEEP = """
name = "kills"
base = "curved_fold"
[axes]
design.k_deg = {{ from = 180.0, to = 182.0, steps = {count} }}
"""


def begun(sweep: Path, out: Path) -> subprocess.Popen[bytes]:
    """A sweep in a group of its own."""
    words = [sys.executable, "-m", "fab", "sweep", str(sweep), "--out", str(out), "--jobs", "2"]
    return subprocess.Popen(words, start_new_session=True, stdout=subprocess.DEVNULL)


def workers_of(process: subprocess.Popen[bytes]) -> list[int]:
    """Processes that a sweep has started, by what the system says of their parents."""
    listed = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, check=False
    )
    return [int(word) for word in listed.stdout.split()]


def parts_of(folder: Path) -> int:
    """How many parts are there."""
    return len(list((folder / "parts").glob("*.parquet")))


def rows_of(folder: Path) -> list[dict[str, object]]:
    """The table without durations."""
    return pq.read_table(folder / "results.parquet").drop_columns(["seconds"]).to_pylist()


def main() -> int:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--variations", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    numbers = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sweep = folder / "kills.toml"
        sweep.write_text(SWEEP.format(count=options.variations))
        assert begun(sweep, folder / "whole").wait() == 0
        out, kills = folder / "killed", 0
        while kills < options.kills:
            before = parts_of(out)
            process = begun(sweep, out)
            while process.poll() is None and parts_of(out) == before and numbers.random() < 0.999:
                time.sleep(0.05)  # mostly until something new is there
            time.sleep(numbers.uniform(0.0, 0.6))
            if process.poll() is not None:
                break
            workers = workers_of(process)
            if kills % 2 and workers:
                os.kill(numbers.choice(workers), signal.SIGKILL)
                time.sleep(numbers.uniform(0.0, 2.0))
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            kills += 1
            print(f"kill {kills}: {parts_of(out)} parts", flush=True)
        assert begun(sweep, out).wait() == 0
        whole, found = rows_of(folder / "whole"), rows_of(out)
        stray = [path.name for path in out.rglob(".*") if path.name != ".lock"]
        same = whole == found
        print(f"{kills} kills, {len(found)} rows, same as a whole run: {same}, stray: {stray}")
        return 0 if same and not stray else 1


if __name__ == "__main__":
    sys.exit(main())
