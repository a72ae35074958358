"""Designs of one's own: treated like the shipped ones, and never run without leave."""

import inspect
import json
import os
import signal
import subprocess
import sys
import time
from importlib.metadata import EntryPoint

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from fab.cli.group import main
from fab.errors import InvalidJob
from fab.jobs import own_designs
from fab.jobs.job import load_job, parse_job
from fab.jobs.job_files import make
from fab.jobs.own_designs import CodeNotAllowed
from solver.designs import miura

MIURA = inspect.getsource(miura)
JOB = """
name = "mine"
[design]
kind = "mine.py:Miura"
columns = 3
rows = 2
fold_deg = 50.0
[sheet]
width_mm = 60.0
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a job beside a copy of the shipped Miura design."""
    (tmp_path / "mine.py").write_text(MIURA)
    (tmp_path / "job.toml").write_text(JOB)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments, answer=None):
    return CliRunner().invoke(main, [str(a) for a in arguments], input=answer)


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    path = tmp_path_factory.mktemp("copied")
    (path / "mine.py").write_text(MIURA)
    return path


@given(st.integers(2, 5), st.integers(2, 4), st.floats(5.0, 80.0), st.floats(35.0, 80.0))
def test_a_copy_of_a_shipped_design_gives_the_same_bytes(copied, columns, rows, fold, sector):
    made = []
    for kind in ("miura", "mine.py:Miura"):
        design = {"kind": kind, "columns": columns, "rows": rows}
        design |= {"fold_deg": fold, "sector_angle_deg": sector}
        job = {"name": "sheet", "design": design, "sheet": {"width_mm": 200.0}}
        made.append(make(parse_job(job, folder=copied, allow_code=True), ["fold", "dxf", "svg"]))
    shipped, own = (dict(each.files) for each in made)
    reports = [json.loads(files.pop("sheet_report.json")) for files in (shipped, own)]
    assert shipped == own
    kinds = [report["job"]["design"].pop("kind") for report in reports]
    assert kinds == ["miura", "mine.py:Miura"]
    assert len({json.dumps({**report, "seconds": None}) for report in reports}) == 1


def test_code_runs_only_with_leave(folder):
    (folder / "mine.py").write_text(f"{MIURA}\nopen('ran', 'w').close()\n")
    for words in (["run", "job.toml", "--only", "fold"], ["simulate", "job.toml"]):
        refused = run(*words, "--out", "out")
        assert refused.exit_code == 2
        assert "runs the code of mine.py" in refused.output
        assert "--allow-code" in refused.output
    with pytest.raises(CodeNotAllowed) as caught:
        load_job("job.toml")
    assert caught.value.path.name == "mine.py"
    assert sorted(path.name for path in folder.iterdir()) == ["job.toml", "mine.py"]
    for words in (
        ["run", "job.toml", "--only", "fold"],
        ["simulate", "job.toml", "--only", "fold"],
    ):
        allowed = run(*words, "--allow-code")
        assert allowed.exit_code == 0, allowed.output
    assert (folder / "ran").is_file()
    assert (folder / "mine.fold").is_file()
    assert (folder / "mine_folding.fold").is_file()


@pytest.mark.skipif(sys.platform == "win32", reason="terminals of POSIX")
@pytest.mark.parametrize(("answer", "code"), [("y\n", 0), ("n\n", 2), ("\x04", 2), ("\x03", 130)])
def test_at_a_terminal_the_user_is_asked(folder, answer, code):
    """Yes, no, the end of the input, and an interrupt."""
    import pty

    own, theirs = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-m", "fab", "run", "job.toml", "--only", "fold"],
        stdin=theirs,
        stdout=subprocess.PIPE,
        stderr=theirs,
        start_new_session=True,
        preexec_fn=_take_terminal,
    ) as process:
        os.close(theirs)
        try:
            shown = b""
            while b"Allow that?" not in shown:
                shown += os.read(own, 1000)
            assert b"job.toml runs the code of mine.py" in shown
            time.sleep(0.5)  # the question is shown a moment before the answer is read
            os.write(own, answer.encode())
            # a signal just before the read is noticed after it: users press Ctrl-C again
            for _ in range(3 if answer == "\x03" else 0):
                if _still_asks(process, 5):
                    os.write(own, answer.encode())
            process.communicate(timeout=60)
        finally:
            process.kill()
            os.close(own)
    assert process.returncode == code
    assert (folder / "mine.fold").is_file() == (code == 0)


def _still_asks(process, seconds):
    """Whether a process does not end within this time."""
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        return True
    return False


def _take_terminal():
    """Make the pseudo terminal that of the session, so that Ctrl-C interrupts.

    Also where the suite was started in the background by a shell, which ignores interrupts.
    """
    import fcntl
    import termios

    signal.signal(signal.SIGINT, signal.SIG_DFL)
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def test_keys_are_those_of_the_class(folder):
    changed = load_job("job.toml", ["design.rows=4"], allow_code=True)
    assert (changed.design.rows, changed.design.fold_deg) == (4, 50.0)
    with pytest.raises(InvalidJob, match=r"design.colums is not .* Did you mean design.columns\?"):
        load_job("job.toml", ["design.colums=4"], allow_code=True)
    with pytest.raises(InvalidJob, match=r"design.rows = 1.5 is out of bounds: .* whole number"):
        load_job("job.toml", ["design.rows=1.5"], allow_code=True)
    with pytest.raises(InvalidJob, match=r"^design.fold_deg: fold = .* is out of bounds"):
        make(load_job("job.toml", ["design.fold_deg=95"], allow_code=True), ["fold"])
    refused = run("run", "job.toml", "--allow-code", "--set", "design.fold_deg=95")
    assert refused.exit_code == 2


def test_fields_may_be_required_or_tuples_or_made_by_a_factory(folder):
    (folder / "mine.py").write_text(
        "from dataclasses import dataclass, field\n"
        "from enum import StrEnum\n"
        "from solver import Miura\n"
        "class Way(StrEnum):\n    LONG = 'long'\n"
        "@dataclass(frozen=True)\n"
        "class Mine:\n"
        "    rows: int\n"
        "    size: tuple[int, int] = (3, 3)\n"
        "    way: Way = Way.LONG\n"
        "    heights: list[float] = field(default_factory=lambda: [1.0])\n"
        "    hidden: int = field(default=0, init=False)\n"
        "    def grow(self, progress=None):\n"
        "        assert isinstance(self.size, tuple) and isinstance(self.way, Way)\n"
        "        return Miura(columns=self.size[0], rows=self.rows).grow(progress)\n"
    )
    design = {"kind": "mine.py:Mine", "size": [4, 4], "way": "long"}
    document = {"name": "mine", "design": design, "sheet": {"width_mm": 60.0}}
    with pytest.raises(InvalidJob, match=r"design\.rows is missing"):
        parse_job(document, allow_code=True)
    job = parse_job({**document, "design": {**design, "rows": 2}}, allow_code=True)
    assert make(job, ["fold"]).report["counts"]["faces"] == 8


@pytest.mark.parametrize(
    ("code", "kind", "match"),
    [
        ("", "other.py:Miura", "other.py: cannot be read: No such file .* Put the file beside"),
        ("", "mine.py", "must name a file and a class"),
        ("", "mine.py:", "must name a file and a class"),
        ("", "mine.py:a b", "must name a file and a class"),
        ("class Helix: ...", "mine.py:Helx", r"mine.py: no class Helx. Did you mean Helix\?"),
        ("class Helix: ...", "mine.py:Helix", "mine.py: Helix is not a dataclass. It must be"),
        ("x = 3", "mine.py:x", "mine.py: x is not a dataclass"),
        ("\n\nimport nothing_here", "mine.py:A", "mine.py, line 3: ModuleNotFoundError: No module"),
        ("\nx = 1 +", "mine.py:A", "mine.py, line 2: SyntaxError"),
        ("def f():\n  1 / 0\nf()", "mine.py:A", "mine.py, line 2: ZeroDivisionError: division"),
        ("import sys; sys.exit(3)", "mine.py:A", "mine.py, line 1: SystemExit: 3"),
        ("{}\nclass A: x: int = 3", "mine.py:A", "A has no method `grow`"),
        ("{}\nclass A:\n  keys: int = 3\n  {}", "mine.py:A", "A.keys cannot be a key. Rename"),
        ("{}\nclass A:\n  _x: int = 3\n  {}", "mine.py:A", "A._x cannot be a key. Rename"),
        ("{}\nclass A:\n  x: 'Missing' = 3\n  {}", "mine.py:A", "field of A cannot be a key: Name"),
        ("{}\nclass A:\n  x: type(f) = 3\n  {}", "mine.py:A", "field of A cannot be a key: "),
        ("{}\nclass A:\n  x: int = 3\n  {}", "mine.py:A", "mine.py, line 7: RuntimeError: stop"),
        ("{}\nclass A:\n  grow = lambda *_: 3", "mine.py:A", "must return a Growth, not int"),
    ],
)
def test_files_at_fault_are_named(folder, code, kind, match):
    head = "from dataclasses import dataclass\nf = open\n@dataclass(frozen=True)"
    grow = "def grow(self, progress=None):\n    raise RuntimeError('stop')"
    filled = code.replace("{}", head, 1).replace("{}", grow, 1) if "{}" in code else code
    (folder / "mine.py").write_text(filled)
    changes = [f"design={{kind = '{kind}'}}"]
    with pytest.raises(InvalidJob, match=match) as caught:
        make(load_job("job.toml", changes, allow_code=True), ["fold"])
    assert len(str(caught.value).splitlines()) == 1
    assert str(caught.value).endswith((".", "?"))


def test_an_edited_file_is_read_anew(folder):
    for limit in (3, 4):
        (folder / "mine.py").write_text(
            MIURA.replace("columns: int = 10", f"columns: int = {limit}")
        )
        job = load_job("job.toml", ["design={kind = 'mine.py:Miura'}"], allow_code=True)
        assert job.design.columns == limit


def test_designs_of_installed_packages_need_no_leave(monkeypatch):
    points = {
        "folded": [EntryPoint("folded", "solver.designs.miura:Miura", own_designs.GROUP)],
        "broken": [EntryPoint("broken", "nothing_here:Miura", own_designs.GROUP)],
        "double": [EntryPoint("double", f"{m}:A", own_designs.GROUP) for m in ("first", "second")],
    }

    def entry_points(group, name):
        assert group == "quadfold.designs"
        return points.get(name, ())

    monkeypatch.setattr(own_designs, "entry_points", entry_points)
    job = {"name": "a", "design": {"kind": "folded", "rows": 3}, "sheet": {"width_mm": 60.0}}
    assert parse_job(job).design.rows == 3
    with pytest.raises(InvalidJob, match=r"broken = nothing_here:Miura: ModuleNotFoundError: No"):
        parse_job({**job, "design": {"kind": "broken"}})
    with pytest.raises(InvalidJob, match="the name of several: first:A, second:A"):
        parse_job({**job, "design": {"kind": "double"}})
    with pytest.raises(InvalidJob, match=r"tilted_rings .or a class in a Python file beside"):
        parse_job({**job, "design": {"kind": "unknown"}})
