"""Folds that are cut short and go on: the same bytes, damaged and foreign files, full disks."""

import subprocess
import sys

import numpy as np
import pytest
from folded_strips import folded_strip
from helpers import PATTERNS, ROOT

from fab import read_pattern
from fab.errors import Finding
from fab.folding.bar_hinge_model import framework
from fab.folding.checkpoints import FoldCheckpoints
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import fold
from fab.formats.fold.writer import fold_bytes
from fab.jobs.folding_files import simulate

STEPS = 3


@pytest.fixture(scope="module")
def miura():
    return read_pattern(PATTERNS / "miura.fold")[0]


@pytest.fixture(scope="module")
def crane():
    """It gets stuck, and is folded again along a path."""
    return read_pattern(PATTERNS / "crane.fold")[0]


class CutShort(Exception):
    """Stands for whatever ends a process."""


def made(pattern, checkpoint=None, most=None):
    """All but the pictures, which take longer, without contact; cut short after so many loads."""
    begun = set()

    def progress(stage, done, total):
        if stage == "fold":
            begun.add((int(done), total))
        if most is not None and len(begun) > most:
            raise CutShort

    settings = FoldSettings(steps=STEPS, contact=False)
    return simulate(
        pattern, "x", settings, formats=["fold"], progress=progress, checkpoint=checkpoint
    ).files


def test_a_fold_that_is_cut_short_again_and_again_ends_with_the_same_bytes(crane, tmp_path):
    whole = made(crane)
    told, cuts = [], 0
    while True:
        kept = FoldCheckpoints(tmp_path, "x", told.append, every_s=0.0)
        try:
            files = made(crane, kept, most=7)
            break
        except CutShort:
            cuts += 1
            assert cuts < 20
            kept.cut_short()
    assert cuts > 1
    assert files == whole
    assert len(list(tmp_path.glob("x_checkpoint_*.npz"))) == 2  # at once, and along the path
    assert sum("goes on at" in text for text in told) >= cuts
    assert sum("kept in" in text for text in told) >= cuts
    kept.remove()
    assert not list(tmp_path.iterdir())


def test_a_short_fold_leaves_nothing_and_other_settings_take_nothing_up(miura, tmp_path):
    folder = tmp_path / "out"
    fold(framework(miura), STEPS, checkpoint=FoldCheckpoints(folder, "x"))
    assert not folder.exists()
    fold(framework(miura), STEPS, checkpoint=FoldCheckpoints(folder, "x", every_s=0.0))
    (file,) = folder.iterdir()
    for other in (FoldSettings(crease=0.5), FoldSettings(steps=4)):
        told = []
        again = FoldCheckpoints(folder, "x", told.append)
        fold(framework(miura, other), other.steps, checkpoint=again)
        assert not told
        again.remove()
        assert file.exists()  # it is of another fold


def test_damaged_and_foreign_files_are_not_used(miura, tmp_path):
    frame = framework(miura)
    whole = fold(frame, STEPS)
    fold(frame, STEPS, checkpoint=FoldCheckpoints(tmp_path, "x", every_s=0.0))
    (file,) = tmp_path.iterdir()
    data = file.read_bytes()
    with np.load(file) as archive:
        arrays = dict(archive)
    flipped = bytearray(data)
    flipped[data.index(b"coords.npy") + 200] ^= 1
    np.savez(tmp_path / "foreign.npz", **{**arrays, "key": np.array("0" * 64)})
    foreign = (tmp_path / "foreign.npz").read_bytes()
    np.savez(tmp_path / "foreign.npz", key=arrays["key"])
    bare = (tmp_path / "foreign.npz").read_bytes()
    np.savez(tmp_path / "foreign.npz", **{**arrays, "coords": arrays["coords"][:1]})
    other = (tmp_path / "foreign.npz").read_bytes()
    methods = bytearray(data)  # an archive may be squeezed in ways that are not known, or locked
    methods[8], locked = 77, bytearray(data)
    for place in range(len(data) - 4):
        if data[place : place + 4] == b"PK\1\2":
            methods[place + 10] = 77
            locked[place + 8] |= 1
    wrongs = (b"", b"quadfold", data[:100], data[:-1], bytes(flipped), foreign, bare, other)
    for wrong in (*wrongs, bytes(methods), bytes(locked)):
        file.write_bytes(wrong)
        told = []
        again = fold(frame, STEPS, checkpoint=FoldCheckpoints(tmp_path, "x", told.append))
        (finding,) = told
        assert isinstance(finding, Finding)
        assert finding.code == "checkpoint-unusable"
        assert file.name in finding.text
        for one, other in zip(again.states, whole.states, strict=True):
            assert (one.coords == other.coords).all()


def test_a_folder_that_takes_no_files_costs_one_line(miura, tmp_path):
    (tmp_path / "file").touch()
    told = []
    kept = FoldCheckpoints(tmp_path / "file" / "out", "x", told.append, every_s=0.0)
    folding = fold(framework(miura), STEPS, checkpoint=kept)
    assert folding.states[-1].settled
    (finding,) = told
    assert finding.code == "checkpoint-unusable"


KILLED = """
import os, signal, sys
from pathlib import Path
from fab import read_pattern
from fab.folding.checkpoints import FoldCheckpoints
from fab.folding.fold_settings import FoldSettings
from fab.jobs.folding_files import simulate

folder, killed, most = Path(sys.argv[2]), sys.argv[3], int(sys.argv[4])
kept = FoldCheckpoints(folder, "x", print, every_s=0.0)
steps = iter(range(10**9))

def progress(stage, done, total):
    if stage == killed and next(steps) == most:
        os.kill(os.getpid(), signal.SIGKILL)

made = simulate(
    read_pattern(sys.argv[1])[0], "x", FoldSettings(contact=None if killed == "contact" else False),
    formats=["fold"], progress=progress, checkpoint=kept,
)
for name, data in made.files.items():
    (folder / name).write_bytes(data)
kept.remove()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
@pytest.mark.parametrize("stage", ["fold", "contact"])
def test_a_process_that_is_killed_goes_on_in_the_next_one(stage, tmp_path):
    """In contact while the flaps fold in turn, the long one under the short one."""
    file, out = tmp_path / "flaps.fold", tmp_path / "out"
    file.write_bytes(fold_bytes(folded_strip([34.0, 40.0, 20.0], [178.0, 160.0]), "flaps"))
    steps = []
    whole = simulate(
        read_pattern(file)[0],
        "x",
        FoldSettings(contact=None if stage == "contact" else False),
        formats=["fold"],
        progress=lambda of, *_: steps.append(of),
    ).files

    def run(most):
        words = [sys.executable, "-c", KILLED, str(file), str(out), stage, str(most)]
        return subprocess.run(words, capture_output=True, text=True, cwd=ROOT, check=False)

    killed = run(round(0.9 * steps.count(stage)))
    assert killed.returncode == -9
    assert list(out.iterdir())
    done = run(-1)
    assert done.returncode == 0, done.stderr
    assert "goes on at" in done.stdout
    assert {path.name: path.read_bytes() for path in out.iterdir()} == whole


def test_what_a_killed_run_was_writing_is_taken_away(miura, tmp_path):
    killed = tmp_path / ".quadfold-a1b2c3d4"
    killed.mkdir()
    (killed / "x_checkpoint.npz").write_bytes(b"half")
    kept = FoldCheckpoints(tmp_path, "x", every_s=0.0)
    fold(framework(miura), STEPS, checkpoint=kept)
    kept.remove()
    assert not list(tmp_path.iterdir())
