"""Folders of runs: whole files or none, and what killed runs left is cleared by the next."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import pytest
from helpers import ROOT

from fab.errors import InvalidJob
from fab.outputs import Made, write
from fab.scratch import beside, locked, replaced, temporary_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="locks of POSIX")


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """A folder for temporary files of this test alone."""
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(place))
    return place


def begun(code, *arguments):
    """A Python process that prints a line when it is where the test wants it."""
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code), *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
    )
    with process.stdout as lines:
        assert lines.readline().strip() == "ready"
    return process


WORKS = """
import sys, time
from pathlib import Path
from fab.scratch import beside
with beside(Path(sys.argv[1])) as own:
    (own / "half").write_text("half")
    print("ready", flush=True)
    time.sleep(60)
"""


def test_folders_are_there_for_the_block_alone(tmp_path, temporary):
    with beside(tmp_path) as own, temporary_folder() as folder:
        assert own.parent == tmp_path
        assert folder.parent == temporary
        (own / "a").write_bytes(b"a")
    assert [path.name for path in tmp_path.iterdir()] == ["temporary"]
    assert not list(temporary.iterdir())


def test_what_a_killed_run_left_is_cleared_by_the_next_and_what_one_at_work_has_is_not(tmp_path):
    first, second = begun(WORKS, tmp_path), begun(WORKS, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2
    first.kill()
    first.wait()
    assert len(list(tmp_path.iterdir())) == 2
    write(Made({"x": b"x"}, {}, ()), tmp_path)
    (left,) = (path for path in tmp_path.iterdir() if path.name != "x")
    assert (left / "half").read_text() == "half"
    second.kill()
    second.wait()
    write(Made({"x": b"x"}, {}, ()), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["x"]


def test_only_folders_of_runs_are_cleared(tmp_path):
    kept = tmp_path / "kept"
    kept.mkdir()
    (kept / "file").write_bytes(b"")
    names = (".quadfold-notes", ".quadfold-", "quadfold-a1b2c3d4")
    for name in names:
        (tmp_path / name).mkdir()
    (tmp_path / ".quadfold-a1b2c3d4").symlink_to(kept)  # a link is no folder of a run
    (tmp_path / ".quadfold-e5f6a7b8").write_bytes(b"")
    before = sorted(tmp_path.rglob("*"))
    with beside(tmp_path):
        pass
    assert sorted(tmp_path.rglob("*")) == before


def test_a_file_is_replaced_whole_or_stays(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"older")
    with pytest.raises(ZeroDivisionError), replaced(path) as written:
        written.write_bytes(b"half") / 0
    assert path.read_bytes() == b"older"
    with replaced(path) as written:
        written.write_bytes(b"newer")
        assert path.read_bytes() == b"older"
    assert path.read_bytes() == b"newer"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("kind", ["file", "link to nothing"])
def test_a_fresh_file_takes_no_place_of_another(tmp_path, kind):
    path = tmp_path / "file"
    if kind == "file":
        path.write_bytes(b"older")
    else:
        path.symlink_to(tmp_path / "nothing")
    with pytest.raises(FileExistsError), replaced(path, fresh=True) as written:
        written.write_bytes(b"newer")
    assert list(tmp_path.iterdir()) == [path]


def test_where_names_cannot_be_linked_a_fresh_file_is_renamed(tmp_path, monkeypatch):
    def link(*_, **__):
        raise PermissionError

    monkeypatch.setattr(os, "link", link)
    with replaced(tmp_path / "file", fresh=True) as written:
        written.write_bytes(b"newer")
    assert (tmp_path / "file").read_bytes() == b"newer"
    with pytest.raises(FileExistsError), replaced(tmp_path / "file", fresh=True) as written:
        written.write_bytes(b"newest")


def test_runs_wait_for_each_other(tmp_path):
    within, most = [], []

    def work():
        with locked(tmp_path):
            within.append(1)
            most.append(len(within))
            time.sleep(0.05)
            within.pop()

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1, 1, 1, 1]
    with locked(tmp_path / "missing"):  # where nothing can be locked nothing waits
        pass


def test_files_of_two_runs_at_once_do_not_mix(tmp_path):
    names = [f"{k}.txt" for k in range(40)]

    def run(text):
        for _ in range(10):
            write(Made(dict.fromkeys(names, text), {}, ()), tmp_path)

    threads = [threading.Thread(target=run, args=(text,)) for text in (b"first", b"second")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    assert len({(tmp_path / name).read_bytes() for name in names}) == 1


def test_where_there_is_no_place_for_temporary_files_the_message_says_so(monkeypatch):
    def none():
        raise FileNotFoundError(2, "No usable temporary directory found in ['/tmp']")

    monkeypatch.setattr("tempfile.gettempdir", none)
    with (
        pytest.raises(InvalidJob, match=r"No usable temporary directory.*set TMPDIR"),
        temporary_folder(),
    ):
        pass


INTERRUPTED = """
import os, signal, sys
from pathlib import Path
from fab.interrupts import Interrupts
from fab.scratch import temporary_folder
signal.signal(signal.SIGTERM, signal.SIG_DFL)
interrupts = Interrupts()
print("ready", flush=True)
count = 0
try:
    with interrupts:
        while True:
            with temporary_folder() as folder:
                (folder / "a").write_bytes(b"a" * 1000)
                count += 1
except KeyboardInterrupt:
    sys.exit(interrupts.exit_code)
"""


@pytest.mark.parametrize("delay", [0.05, 0.1, 0.17, 0.23])
def test_an_interrupt_leaves_no_folder_wherever_it_comes(tmp_path, monkeypatch, delay):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    process = begun(INTERRUPTED)
    time.sleep(delay)
    process.send_signal(signal.SIGTERM)
    assert process.wait(60) == 143
    assert not list(Path(tmp_path).iterdir())
