"""A fold that is killed at random moments and goes on, against one in one go: the same files.

    python tests/fuzz/fold_kills.py --kills 10 --columns 80 --seed 1
    python tests/fuzz/fold_kills.py --kills 10 --pattern tests/patterns/crane.fold --contact

On a sheet that takes some times as long to fold as a checkpoint is apart from the next: one that is
made for it, or a pattern.
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

JOB = """
name = "kills"
outputs = ["fold"]
[design]
kind = "surface_fit"
columns = {columns}
trim = false
[sheet]
width_mm = 600.0
"""


def begun(pattern: Path, out: Path, rest: list[str]) -> subprocess.Popen[str]:
    """A fold in a group of its own, with the rest of the options."""
    words = [sys.executable, "-m", "fab", "simulate", str(pattern), "--out", str(out)]
    return subprocess.Popen(
        [*words, "--only", "fold,glb", *rest],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def made(folder: Path, columns: int) -> Path:
    """A pattern of so many columns of quads."""
    job = folder / "kills.toml"
    job.write_text(JOB.format(columns=columns))
    run = [sys.executable, "-m", "fab", "run", str(job), "--out", str(folder)]
    subprocess.run(run, check=True, stdout=subprocess.DEVNULL)
    return folder / "kills.fold"


def files_of(folder: Path) -> dict[str, bytes]:
    """All files by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def main() -> int:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--columns", type=int, default=80)
    parser.add_argument("--pattern", type=Path)
    parser.add_argument("--contact", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rest = ["--contact"] if options.contact else []
    numbers = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pattern = options.pattern or made(folder, options.columns)
        begin = time.monotonic()
        whole = begun(pattern, folder / "whole", rest)
        told = whole.communicate()[1]
        assert whole.returncode in (0, 1), told  # 1: the target is not reached
        taken, kills, resumed = time.monotonic() - begin, 0, 0
        out = folder / "killed"
        while kills < options.kills:
            process = begun(pattern, out, rest)
            time.sleep(numbers.uniform(0.0, taken))
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            told = process.communicate()[1]
            resumed += "goes on at" in told
            kills += 1
            print(f"kill {kills}: {told.strip()}", flush=True)
        last = begun(pattern, out, rest)
        told = last.communicate()[1]
        assert last.returncode == whole.returncode, told
        same = files_of(folder / "whole") == files_of(out)
        print(f"{kills} kills, {resumed} folds went on, same files as in one go: {same}")
        return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
