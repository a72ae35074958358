"""Paths that name no readable file are refused everywhere, in a line that fits on a screen."""

import importlib
import os
import shutil
import tempfile
from pathlib import Path

import pytest
from click.testing import CliRunner
from helpers import TEMPLATES

from fab import read_pattern
from fab.catalogue import load_described
from fab.cli.group import main
from fab.errors import InvalidFile, InvalidJob
from fab.files import require_file
from fab.formats.meshes.surface import read_surface
from fab.formats.reading import read_pattern_file
from fab.jobs.job import load_job
from fab.outputs import require_folder
from fab.printing.printers import Printer

LONG = "a" * 5000
# The user that owns nothing, on all POSIX systems that matter.
NOBODY = 65534
# What is imported when a file is read: it may be closed to that user as well.
LATE = ("encodings.utf_8_sig", "fab.jobs.own_designs", "fab.surfaces.reading")
CASES = {
    "long": (LONG, "File name too long"),
    "NUL": ("a\0b", "null"),
    "missing": ("nothing", "No such file"),
    "folder": ("folder", "a folder, not a file"),
    "through a file": ("file/inner", "Not a directory"),
    "locked": ("locked", "Permission denied"),
    "device": ("pipe", "a device, not a file"),
}
READERS = {
    ".toml": load_job,
    ".step": read_surface,
    ".stl": read_surface,
    ".fold": read_pattern,
    ".svg": read_pattern_file,
    ".dxf": read_pattern_file,
    ".cp": read_pattern_file,
    "": read_pattern_file,
    ".printer.toml": lambda path: load_described(Printer, "machines", path),
}


@pytest.fixture
def locked():
    """Makes a file that may not be read, not even by root: who runs the test is nobody then."""
    folder = Path(tempfile.mkdtemp())  # pytest's own folders are closed to others
    left = []

    def made(name):
        path = folder / name
        path.write_text("x")
        path.chmod(0)
        if hasattr(os, "seteuid") and os.geteuid() == 0:
            for module in LATE:
                importlib.import_module(module)
            folder.chmod(0o755)
            left.append(os.geteuid())
            os.seteuid(NOBODY)
        elif os.access(path, os.R_OK):
            pytest.skip("files cannot be closed to their owner on this system")
        return path

    yield made
    if left:
        os.seteuid(left[0])
    shutil.rmtree(folder)


@pytest.fixture
def place(tmp_path, locked):
    """Makes a path of a kind with an ending."""

    def of(kind, ending):
        name, why = CASES[kind]
        path = tmp_path / f"{name}{ending}"
        if kind == "folder":
            path.mkdir()
        elif kind == "through a file":
            (tmp_path / "file").write_text("")
        elif kind == "locked":
            path = locked(path.name)
        elif kind == "device":
            if not hasattr(os, "mkfifo"):
                pytest.skip("no named pipes on this system")
            os.mkfifo(path)
        return path, why

    return of


@pytest.mark.parametrize("ending", READERS)
@pytest.mark.parametrize("kind", CASES)
def test_readers_refuse_what_is_no_file(place, kind, ending):
    path, why = place(kind, ending)
    with pytest.raises((InvalidFile, InvalidJob), match=why) as caught:
        READERS[ending](path)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(("key", "ending"), [("surface", ".step"), ("kind", ".py")])
@pytest.mark.parametrize("kind", CASES)
def test_jobs_refuse_surfaces_and_code_that_are_no_files(place, kind, key, ending):
    path, why = place(kind, ending)
    text = str(path).replace("\0", "\\u0000") + (":Sheet" if key == "kind" else "")

    def grown():
        changes = [f'design.{key}="{text}"']
        job = load_job(TEMPLATES / "surface_fit.toml", changes, allow_code=True)
        return job.design.design(job.folder)

    with pytest.raises((InvalidFile, InvalidJob), match=why) as caught:
        grown()
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", LONG],
        ["run", str(TEMPLATES / "surface_fit.toml"), "--set", f"design.surface={LONG}"],
        ["run", str(TEMPLATES / "surface_fit.toml"), "--set", f"design.surface={LONG}.step"],
        ["run", str(TEMPLATES / "miura.toml"), "--out", LONG],
        ["run", str(TEMPLATES / "miura.toml"), "--set", f"printer.machine={LONG}"],
        ["new", LONG],
        ["new", "miura", "--out", LONG],
        ["check", LONG],
        ["convert", LONG, "b.svg"],
        ["simulate", LONG],
        ["thicken", LONG],
        ["thicken", "x.fold", "--printer", f"{LONG}.toml"],
        ["fabricate", "x.fold", "--material", LONG, "--machine", LONG],
    ],
    ids=lambda arguments: " ".join(word[:20] for word in arguments[:3]),
)
def test_commands_refuse_names_of_5000_letters_in_a_line(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 2, done.output
    assert done.output.startswith("quadfold: ")
    assert len(done.output) < 1000
    assert list(tmp_path.iterdir()) == []


def test_a_folder_for_files_with_a_nul_character_is_refused():
    with pytest.raises(InvalidJob, match="NUL character"):
        require_folder(Path("a\0b"))


def test_the_size_of_a_file_is_its_bytes(tmp_path):
    (tmp_path / "ä.toml").write_bytes(b"12345")
    assert require_file(tmp_path / "ä.toml", InvalidJob, "") == 5
