"""Runs of sweeps: what crashes is a row, what is there is not done again, and all ways agree."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from helpers import TEMPLATES
from PIL import Image
from sweep_tables import rows_of

from fab.cli.group import main
from fab.errors import InvalidJob
from fab.jobs.job import load_job
from fab.jobs.job_files import make
from fab.sweeps.cluster import ClusterSettings, job_script
from fab.sweeps.columns import FIGURES, OUTCOME
from fab.sweeps.parts import Parts
from fab.sweeps.sweep_run import estimate, run_sweep, sweep
from fab.sweeps.sweep_settings import load_sweep

SMALL = """
name = "small"
base = "miura"
[axes]
design.columns = [2, 3, 4]
design.fold_deg = { from = 10.0, to = 100.0, steps = 4 }
"""
# A design that does what its key says, in the place of the growth of a Miura sheet.
UNRULY = """
import os, signal, time
from contextlib import suppress
from dataclasses import dataclass
from solver import Miura

@dataclass(frozen=True)
class Unruly:
    how: str = "well"

    def grow(self, progress=None):
        if self.how == "dies":
            os._exit(3)
        if self.how == "is killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.how == "fails":
            raise RuntimeError("no reason")
        if self.how == "sleeps":
            time.sleep(60)
        while self.how == "hangs":
            with suppress(BaseException):  # as a library that answers to nothing
                time.sleep(60)
        if self.how == "grows":
            bytearray(1 << 34)
        return Miura(columns=2, rows=2).grow()
"""

# A design of which one kills its process when it grows first, and again the second time.
ONCE = """
import os, signal
from dataclasses import dataclass
from pathlib import Path
from solver import Miura

@dataclass(frozen=True)
class Once:
    mark: str
    columns: int = 2

    def grow(self, progress=None):
        mark = Path(self.mark)
        if self.columns == 4 and (times := len(mark.read_text()) if mark.exists() else 0) < 2:
            mark.write_text("x" * (times + 1))
            os.kill(os.getpid(), signal.SIGKILL)
        return Miura(columns=self.columns, rows=2).grow()
"""


@pytest.fixture
def small(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


def test_every_variation_has_a_row_and_alike_ones_are_run_once(small, tmp_path):
    result = run_sweep(load_sweep(small), tmp_path / "out", jobs=2)
    assert (result.variations, result.jobs, result.begun_with) == (12, 12, 0)
    rows = rows_of(tmp_path / "out")
    assert [row["number"] for row in rows] == list(range(12))
    made = [row for row in rows if row["status"] == "made"]
    assert result.statuses == {"made": len(made), "refused": 3}
    for row in made:
        assert row["counts.faces"] == 8 * row["design.columns"]
        assert row["flat.x_mm"] <= 200.0 + 1e-9
    refused = [row for row in rows if row["status"] == "refused"]
    assert {row["design.fold_deg"] for row in refused} == {100.0}
    assert all("fold_deg" in row["message"] for row in refused)
    again = run_sweep(load_sweep(small), tmp_path / "out", jobs=1)
    assert (again.begun_with, again.statuses) == (12, result.statuses)


def test_values_of_several_types_are_text_in_the_table(here, small, tmp_path):
    small.write_text('name = "s"\nbase = "miura"\n[axes]\ndesign.kind = ["miura", 3, true]\n')
    run_sweep(load_sweep(small), tmp_path / "out", jobs=1)
    rows = rows_of(tmp_path / "out")
    assert [row["design.kind"] for row in rows] == ["miura", "3", "True"]
    assert [row["status"] for row in rows] == ["made", "refused", "refused"]


def test_axes_from_python_are_arrays_as_well(here, tmp_path):
    axes = {"design.columns": np.arange(2, 4), "design.fold_deg": [np.float32(30)]}
    result = sweep(load_job(TEMPLATES / "miura.toml"), axes, tmp_path / "out", jobs=1)
    assert [row["design.columns"] for row in result.rows()] == [2, 3]


def test_a_changed_sweep_takes_what_fits(here, small, tmp_path):
    run_sweep(load_sweep(small), tmp_path / "out", jobs=1)
    before = {row["job_hash"]: row for row in rows_of(tmp_path / "out")}
    small.write_text(SMALL.replace("[2, 3, 4]", "[5, 4, 2]"))
    result = run_sweep(load_sweep(small), tmp_path / "out", jobs=1)
    assert (result.jobs, result.begun_with, result.others) == (12, 8, 4)
    rows = rows_of(tmp_path / "out")
    assert [row["design.columns"] for row in rows] == [5] * 4 + [4] * 4 + [2] * 4
    for row in rows[4:]:
        assert {**row, "number": 0} == {**before[row["job_hash"]], "number": 0}


def test_what_fails_hangs_or_crashes_is_a_row_with_its_reason(tmp_path):
    (tmp_path / "unruly.py").write_text(UNRULY)
    (tmp_path / "base.toml").write_text(
        'name = "u"\nsheet = { width_mm = 100.0 }\ndesign = { kind = "unruly.py:Unruly" }\n'
    )
    hows = ["well", "dies", "is killed", "fails", "sleeps", "hangs", "grows"]
    (tmp_path / "sweep.toml").write_text(
        'name = "s"\nbase = "base.toml"\nlimits = { seconds = 3.0, memory_mb = 4000 }\n'
        f"[axes]\ndesign.how = {hows}\n"
    )
    sweep = load_sweep(tmp_path / "sweep.toml", allow_code=True)
    run_sweep(sweep, tmp_path / "out", jobs=2)
    rows = {row["design.how"]: row for row in rows_of(tmp_path / "out")}
    statuses = {how: rows[how]["status"] for how in hows}
    assert statuses == {
        "well": "made",
        "dies": "crashed",
        "is killed": "crashed",
        "fails": "refused",
        "sleeps": "too slow",
        "hangs": "too slow",
        "grows": "too large",
    }
    assert rows["dies"]["message"] == "its process ended with exit code 3"
    assert rows["is killed"]["message"] == "its process ended by SIGKILL"
    assert "could not be interrupted" in rows["hangs"]["message"]
    assert "no reason" in rows["fails"]["message"]
    with pytest.raises(InvalidJob, match=r"unruly\.py"):
        run_sweep(load_sweep(tmp_path / "sweep.toml"), tmp_path / "other", jobs=1)


def begun(sweep, out):
    code = (
        "import sys\nfrom fab.sweeps.sweep_run import run_sweep\n"
        "from fab.sweeps.sweep_settings import load_sweep\n"
        "if __name__ == '__main__':\n    run_sweep(load_sweep(sys.argv[1]), sys.argv[2], jobs=1)\n"
    )
    script = out.parent / "run.py"
    script.write_text(code)
    return subprocess.Popen(
        [sys.executable, str(script), str(sweep), str(out)], start_new_session=True
    )


def test_a_sweep_that_is_killed_goes_on_and_gives_the_same_table(small, tmp_path):
    run_sweep(load_sweep(small), tmp_path / "whole", jobs=1)
    out = tmp_path / "killed"
    parts = out / "parts"
    for wanted in (1, 3):
        process = begun(small, out)
        while process.poll() is None and len(list(parts.glob("*.parquet"))) < wanted:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    (parts / "damaged.parquet").write_bytes(b"PAR1")
    result = run_sweep(load_sweep(small), out, jobs=1)
    assert result.begun_with >= 1
    assert result.damaged == 1
    assert rows_of(out) == rows_of(tmp_path / "whole")
    assert not list(out.rglob(".*.parquet.*"))


def test_a_folder_that_takes_no_files_ends_the_sweep_and_blames_no_variation(here, small, tmp_path):
    small.write_text('outputs = ["fold"]\n' + SMALL)
    out = tmp_path / "out"
    out.mkdir()
    (out / "files").write_text("in the way")
    with pytest.raises(InvalidJob, match="is a file, not a folder"):
        run_sweep(load_sweep(small), out, jobs=1)
    assert not list((out / "parts").glob("*.parquet"))
    (out / "files").unlink()
    assert run_sweep(load_sweep(small), out, jobs=1).statuses == {"made": 9, "refused": 3}
    (out / "results.csv").unlink()
    (out / "results.csv").mkdir()
    with pytest.raises(InvalidJob, match=r"results\.csv: cannot be written"):
        run_sweep(load_sweep(small), out, jobs=1)
    (out / "results.csv").rmdir()
    (out / "sweep.html").unlink()
    (out / "sweep.html").mkdir()
    with pytest.raises(InvalidJob, match=r"sweep\.html: cannot be written"):
        run_sweep(load_sweep(small), out, jobs=1)
    assert not list(out.glob(".*.new"))


def test_two_runs_in_a_folder_are_refused(small, tmp_path):
    from fab.sweeps.sweep_folder import locked

    with (
        locked(tmp_path / "out"),
        pytest.raises(InvalidJob, match="another sweep is at work there"),
    ):
        run_sweep(load_sweep(small), tmp_path / "out", jobs=1)


def test_a_dry_run_counts_and_writes_nothing(small, tmp_path):
    found = estimate(load_sweep(small), jobs=2)
    assert (found.variations, found.workers) == (12, 2)
    result = CliRunner().invoke(
        main, ["sweep", str(small), "--dry-run", "--out", str(tmp_path / "x")]
    )
    assert result.exit_code == 0, result.output
    assert "12 variations, about " in result.output
    assert not (tmp_path / "x").exists()


def test_a_local_cluster_of_dask_gives_the_same_table(small, tmp_path):
    pytest.importorskip("distributed", reason="distributed is not installed")
    run_sweep(load_sweep(small), tmp_path / "pool", jobs=2)
    cluster = ClusterSettings(kind="local", workers=2)
    run_sweep(load_sweep(small), tmp_path / "dask", cluster=cluster)
    assert rows_of(tmp_path / "dask") == rows_of(tmp_path / "pool")


def test_job_scripts_say_what_was_asked_for():
    pytest.importorskip("dask_jobqueue", reason="dask-jobqueue is not installed")
    asked = {"queue": "cpu", "account": "lab", "walltime": "02:30:00", "memory_mb": 4000}
    slurm = job_script(ClusterSettings(kind="slurm", prologue=["module load python"], **asked))
    for line in ("#SBATCH -p cpu", "#SBATCH -A lab", "#SBATCH -t 02:30:00", "module load python"):
        assert line in slurm.splitlines()
    assert "distributed.cli.dask_worker" in slurm
    assert "#PBS -q cpu" in job_script(ClusterSettings(kind="pbs", **asked)).splitlines()
    with pytest.raises(InvalidJob, match="has no job script"):
        job_script(ClusterSettings(kind="local"))


def test_a_scheduler_that_is_not_there_is_told(small, tmp_path):
    pytest.importorskip("distributed", reason="distributed is not installed")
    words = ["sweep", str(small), "--cluster", "tcp://127.0.0.1:1", "--out", str(tmp_path / "x")]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 2
    assert "no scheduler answers there" in result.stderr


def test_the_table_is_chosen_from(here, small, tmp_path):
    out = tmp_path / "out"
    assert CliRunner().invoke(main, ["sweep", str(small), "--out", str(out)]).exit_code == 0

    def table(*words):
        return CliRunner().invoke(main, ["table", str(out), *words])

    best = table("--best", "-faces", "--where", "crossings = 0", "--show", "number,faces", "--csv")
    lines = best.stdout.splitlines()
    assert lines[0] == "number,counts.faces"
    assert [int(line.split(",")[1]) for line in lines[1:]] == [32] * 3 + [24] * 3 + [16] * 3
    assert table("--top", "2").stdout.splitlines()[-1] == "2 rows of 12"
    missing = table("--best", "facets")
    assert missing.exit_code == 2
    assert "facets is no column of the table. Did you mean" in missing.stderr
    for where in ("crossings =", "1; DROP TABLE results", "read_text('/etc/passwd') = ''"):
        refused = table("--where", where)
        assert refused.exit_code == 2, where
    results = out / "results.parquet"
    whole = pq.read_table(results)
    for data in (b"PAR1", b"", results.read_bytes()[:-9]):
        results.write_bytes(data)
        assert "is no table of a sweep: " in table().stderr
    for column in ("number", "status"):
        pq.write_table(whole.drop_columns([column]), results)
        words = f"is no table of a sweep: it has no column {column}. Make it again with"
        assert words in table().stderr


def test_figures_of_folds_panels_and_sheets_are_those_of_a_run(here, tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(
        'name = "s"\nbase = "base.toml"\nmeasure = ["rigid", "fold", "thick", "sheets"]\n'
        'outputs = ["dxf"]\npictures = true\n[axes]\ndesign.columns = [4]\n'
    )
    job = (TEMPLATES / "miura.toml").read_text()
    cutter = '[cutter]\nmaterial = "card_300gsm"\nmachine = "co2_60w_600x400"\n'
    (tmp_path / "base.toml").write_text(job + cutter)
    run_sweep(load_sweep(path), tmp_path / "out", jobs=1)
    (row,) = rows_of(tmp_path / "out")
    changes = ["design.columns=4", "simulation={}"]
    made = make(load_job(tmp_path / "base.toml", changes), ["dxf", "stl"])
    report = made.report
    assert row["sheets.minutes"] == sum(sheet["minutes"] for sheet in report["sheets"])
    assert row["sheets.count"] == row["sheets.pieces"] == 1
    assert row["solids.volume_mm3"] == report["solids"]["volume_mm3"]
    assert row["rigid.verdict"] == "folds-rigidly"
    assert row["simulation.reached"] is True
    with Image.open(tmp_path / "out/pictures" / f"{row['job_hash']}.png") as picture:
        assert picture.size == (240, 180)
        shades = picture.convert("L").getcolors()
    assert len(shades) > 3  # a form, and not white alone
    assert (tmp_path / "out/contact_sheet.png").is_file()
    kept = {file.name: file.read_bytes() for file in (tmp_path / "out/files").rglob("*.dxf")}
    assert kept == {"miura_1.dxf": made.files["miura_1.dxf"]}


@pytest.mark.skipif(os.name != "posix", reason="killing processes of a worker by signal is POSIX")
def test_a_worker_that_is_killed_loses_nothing(tmp_path):
    """A worker kills itself with SIGKILL, as the kernel does without memory; the next one too."""
    (tmp_path / "once.py").write_text(ONCE)
    (tmp_path / "base.toml").write_text(
        'name = "u"\nsheet = { width_mm = 100.0 }\ndesign = { kind = "once.py:Once" }\n'
    )
    axes = f'[axes]\ndesign.mark = ["{tmp_path / "mark"}"]\ndesign.columns = [2, 3, 4, 5, 6, 7]\n'
    (tmp_path / "sweep.toml").write_text(f'name = "s"\nbase = "base.toml"\n{axes}')
    result = run_sweep(
        load_sweep(tmp_path / "sweep.toml", allow_code=True), tmp_path / "out", jobs=2
    )
    assert result.statuses == {"made": 6}
    assert (tmp_path / "mark").read_text() == "xx"


def test_rows_that_a_lower_limit_ended_are_run_again(here, tmp_path):
    (tmp_path / "slow.py").write_text(
        "import time\nfrom dataclasses import dataclass\nfrom solver import Miura\n\n"
        "@dataclass(frozen=True)\nclass Slow:\n    columns: int = 2\n\n"
        "    def grow(self, progress=None):\n        if self.columns == 3:\n"
        "            time.sleep(1.0)\n        return Miura(columns=self.columns, rows=2).grow()\n"
    )
    (tmp_path / "base.toml").write_text(
        'name = "s"\nsheet = { width_mm = 100.0 }\ndesign = { kind = "slow.py:Slow" }\n'
    )

    def swept(seconds):
        (tmp_path / "s.toml").write_text(
            f'name = "s"\nbase = "base.toml"\nlimits = {{ seconds = {seconds} }}\n'
            "[axes]\ndesign.columns = [2, 3, 4]\n"
        )
        return run_sweep(load_sweep(tmp_path / "s.toml", allow_code=True), tmp_path / "out", jobs=1)

    assert swept(0.8).statuses == {"made": 2, "too slow": 1}
    lower = swept(0.7)
    assert (lower.statuses, lower.again) == ({"made": 2, "too slow": 1}, 0)
    higher = swept(60.0)
    assert (higher.statuses, higher.again, higher.begun_with) == ({"made": 3}, 1, 2)
    assert "1 job that had crashed, or come to a limit" in "\n".join(higher.lines())


def test_rows_are_those_of_the_files_that_a_job_names(here, tmp_path):
    """A design of one's own that is edited gives other rows, and again the first ones."""
    (tmp_path / "base.toml").write_text(
        'name = "s"\nsheet = { width_mm = 100.0 }\ndesign = { kind = "own.py:Own" }\n'
    )
    (tmp_path / "s.toml").write_text(
        'name = "s"\nbase = "base.toml"\n[axes]\ndesign.rows = [2, 3]\n'
    )

    def swept(columns):
        (tmp_path / "own.py").write_text(
            "from dataclasses import dataclass\nfrom solver import Miura\n\n"
            "@dataclass(frozen=True)\nclass Own:\n    rows: int = 2\n\n"
            "    def grow(self, progress=None):\n"
            f"        return Miura(columns={columns}, rows=self.rows).grow()\n"
        )
        sweep = load_sweep(tmp_path / "s.toml", allow_code=True)
        result = run_sweep(sweep, tmp_path / "out", jobs=1)
        return result.begun_with, [row["counts.faces"] for row in result.rows()]

    assert [swept(2), swept(3), swept(2)] == [(0, [4, 6]), (0, [6, 9]), (2, [4, 6])]


def test_parts_keep_rows_when_others_of_them_are_dropped(tmp_path):
    columns = [column.name for column in (*OUTCOME, *FIGURES)]
    limits = {"limits.seconds": 5.0, "limits.memory_mb": None}
    ways = ["made", "crashed", "made", "too slow"]
    rows = [
        {**dict.fromkeys(columns), **limits, "job_hash": f"h{number}", "status": status}
        for number, status in enumerate(ways)
    ]
    parts = Parts(tmp_path)
    parts.add(rows[:3])
    parts.add(rows[3:])
    assert parts.drop(lambda row: row["status"] != "made") == 2
    assert parts.hashes() == {"h0", "h2"}
    parts.add([rows[0], rows[1], rows[3]])  # beginning with a row that another part begins with
    assert parts.hashes() == {"h0", "h1", "h2", "h3"}


def test_parts_that_are_damaged_or_of_other_columns_are_left_aside(here, small, tmp_path):
    """Whatever value is damaged, not those alone that say which rows there are."""
    whole = run_sweep(load_sweep(small), tmp_path / "out", jobs=1)
    rows = rows_of(tmp_path / "out")
    (part, *_) = parts = Parts(tmp_path / "out" / "parts").paths()
    group, data = pq.read_metadata(part).row_group(0), bytearray(part.read_bytes())
    columns = [group.column(number) for number in range(group.num_columns)]
    column = next(each for each in columns if each.path_in_schema == "planarity_max")
    data[(column.dictionary_page_offset or 0) + column.total_compressed_size - 1] ^= 1
    part.write_bytes(data)
    for name in ("seconds", "job_hash"):
        older = pq.read_table(parts[-1]).drop_columns([name])
        pq.write_table(older, part.with_name(f"older_{name}.parquet"))
    again = run_sweep(load_sweep(small), tmp_path / "out", jobs=1)
    assert (again.damaged, again.others) == (1, 2 * len(pq.read_table(parts[-1])))
    assert again.begun_with < whole.jobs
    assert rows_of(tmp_path / "out") == rows


def test_a_process_of_a_sweep_that_begins_a_sweep_is_told_what_is_missing(
    small, tmp_path, monkeypatch
):
    sweep = load_sweep(small)
    monkeypatch.setattr(multiprocessing.current_process(), "_inheriting", True, raising=False)
    with pytest.raises(InvalidJob, match=r"keep what it runs, .* `if __name__"):
        run_sweep(sweep, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_sheets_are_not_measured_without_a_cutter(small, tmp_path):
    small.write_text('measure = ["sheets"]\n' + SMALL)
    with pytest.raises(InvalidJob, match=r"needs a table \[cutter\]"):
        run_sweep(load_sweep(small), tmp_path / "out")


@pytest.mark.parametrize("name", ["missing", "a" * 300])
def test_a_table_that_is_not_there_is_told(here, name):
    result = CliRunner().invoke(main, ["table", name])
    assert result.exit_code == 2
    assert "is not there. Make it with `quadfold sweep`" in result.stderr
