"""Folds of 25,000 and 76,000 faces, beside those by SuperLU before the systems were analysed once.

`pytest tests/bench/test_fast_folding_bench.py --benchmark-only -s`: some minutes; with
QUADFOLD_LONG=1 the larger sheet too, an hour. QUADFOLD_LOADS=1 folds both only so far.

The folder QUADFOLD_BEFORE holds the project at commit 98b50b5; without it, git puts one there.
Seconds are of the processor, all threads together, so that what else runs does not count. Each fold
has a process of its own for its memory.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fab.formats.fold.writer import fold_bytes
from fab.jobs.grow import grown
from fab.jobs.job import load_job
from fab.progress import Clock, silent

ROOT = Path(__file__).parents[2]
BEFORE = "98b50b5"
LONG = pytest.mark.skipif("QUADFOLD_LONG" not in os.environ, reason="an hour: QUADFOLD_LONG=1")


@pytest.fixture(scope="module")
def before(tmp_path_factory):
    """The project as it was."""
    given = os.environ.get("QUADFOLD_BEFORE")
    if given:
        yield Path(given)
        return
    folder = tmp_path_factory.mktemp("before") / "project"
    git = ["git", "-C", str(ROOT), "worktree"]
    added = subprocess.run(
        [*git, "add", "--detach", str(folder), BEFORE], capture_output=True, check=False
    )
    if added.returncode:
        pytest.skip(f"git has no commit {BEFORE} here: give its folder as QUADFOLD_BEFORE")
    yield folder
    subprocess.run([*git, "remove", "--force", str(folder)], check=True)


def folded(project, pattern):
    script = Path(__file__).parent / "folding_before.py"
    loads = os.environ.get("QUADFOLD_LOADS", "0")
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, str(script), str(pattern), loads],
        cwd=project,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.parametrize(("columns", "least"), [(180, 3.0), pytest.param(320, 5.0, marks=LONG)])
def test_folds_of_large_sheets_against_superlu(benchmark, before, columns, least, tmp_path):
    job = load_job(ROOT / "templates" / "surface_fit_320.toml", [f"design.columns={columns}"])
    pattern = tmp_path / "sheet.fold"
    pattern.write_bytes(fold_bytes(grown(job, Clock(silent)).pattern, "sheet"))
    slow = folded(before, pattern)
    quick = benchmark.pedantic(folded, args=(ROOT, pattern), rounds=1)
    ratio = slow["cpu_s"] / quick["cpu_s"]
    benchmark.extra_info.update(ratio=round(ratio, 1), gb=quick["gb"])
    for name, each in (("before", slow), ("now", quick)):
        listed = {k: v for k, v in each.items() if k not in ("wrong", "off")}
        print(f"\n{name}: {listed}")
    print(f"ratio {ratio:.1f}")
    for key in ("reached", "wrong", "off", "crossings"):
        assert slow.get(key) == quick.get(key)
    assert quick["gb"] <= slow["gb"]
    assert ratio >= least
