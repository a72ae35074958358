"""Small commands of every kind, each run in a world of its own, and what is wrong afterwards.

A world has inputs, a home, a folder for temporary files, a working folder, and one to write into;
what is found anywhere else in it afterwards is a fault.
"""

from __future__ import annotations

import csv
import fnmatch
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
from helpers import PATTERNS, ROOT

from fab.outputs import zip_bytes

__all__ = [
    "COMMANDS",
    "OLD",
    "STOPS",
    "Command",
    "Ended",
    "Run",
    "Whole",
    "World",
    "faults_of",
    "normal",
    "run_to_end",
    "tree",
    "whole_of",
]

OLD = b"of an earlier run\n"
# Signals that ask a process to end, and the exit code that says so.
STOPS = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
# What may take long on a busy machine; longer is a hang.
LONGEST_S = 300.0
# How long processes that a run has started may outlive it.
ORPHANS_S = 15.0

JOB = """
name = "small"
outputs = ["fold", "dxf", "svg"]
[design]
kind = "miura"
rows = 3
columns = 4
[sheet]
width_mm = 80.0
"""
LOADED = JOB.replace('"fold", "dxf", "svg"', '"fold", "png", "html", "glb"') + "[simulation]\n"
SWEEP = """
name = "tried"
base = "small.toml"
outputs = ["svg"]
pictures = true
[axes]
sheet.width_mm = [80.0, 90.0, 100.0]
"""
SCAN = """
name = "scan"
outputs = ["fold"]
[design]
kind = "surface_fit"
surface = "bump.3mf"
columns = 4
[sheet]
width_mm = 80.0
"""


@dataclass(frozen=True)
class Command:
    """A command: its words, where it writes, and what it may leave there when it is cut short.

    out : relative to the world. kept : patterns of files from which it goes on.
    again : exit codes of a run after one that was cut short, where they are not that of
    any. serves : whether it is the studio. needs : words of a command that is run first.
    """

    name: str
    words: tuple[str, ...]
    out: str = "here/out"
    kept: tuple[str, ...] = ()
    again: tuple[int, ...] = ()
    serves: bool = False
    needs: tuple[str, ...] = ()


_STOCK = ("--material", "card_300gsm", "--machine", "co2_60w_600x400")
_PRINT = ("--printer", "prusa_mk4s", "--material", "pp_filament")
_FOLD = ("*_checkpoint_*.npz",)
_TABLE = (".lock", "parts", "parts/*.parquet", "variations.parquet", "pictures", "pictures/*.png")
_TABLE = (*_TABLE, "files", "files/*")
COMMANDS = (
    Command("run", ("run", "{in}/small.toml", "--out", "out")),
    Command("run loaded", ("run", "{in}/loaded.toml", "--out", "out"), kept=_FOLD),
    Command("run scan", ("run", "{in}/scan.toml", "--out", "out")),
    Command("fabricate", ("fabricate", "{in}/x.fold", "--out", "out", "--width-mm", "90", *_STOCK)),
    Command(
        "thicken",
        (
            *("thicken", "{in}/x.fold", "--out", "out", "--width-mm", "120"),
            *("--only", "stl,3mf,step", "--set", "panels.fold_limit_deg=90.0", *_PRINT),
        ),
    ),
    Command(
        "simulate", ("simulate", "{in}/m.fold", "--out", "out", "--only", "fold,glb"), kept=_FOLD
    ),
    Command(
        "animate", ("animate", "{in}/x.fold", "--out", "out", "--states", "4", "--only", "gif,mp4")
    ),
    Command("coupon", ("coupon", "--out", "out", *_STOCK)),
    Command("figure", ("figure", "S1", "--out", "out")),
    Command("sweep", ("sweep", "{in}/tried.toml", "--out", "out", "--jobs", "2"), kept=_TABLE),
    Command(
        "table",
        ("table", "out", "--best", "sheet.width_mm"),
        needs=("sweep", "{in}/tried.toml", "--out", "out", "--jobs", "1"),
    ),
    Command("new", ("new", "miura", "--out", "out/mine.toml"), again=(0, 2)),
    Command("convert", ("convert", "{in}/x.fold", "out/x.svg")),
    Command(
        "check",
        ("check", "out/small.fold"),
        needs=("run", "{in}/small.toml", "--out", "out", "--only", "fold"),
    ),
    Command("findings", ("findings", "overlap")),
    Command("shipped", ("shipped", "materials")),
    Command("templates", ("templates",)),
    Command("settings", ("settings", "set", "material", "card_300gsm"), "home/.config/quadfold"),
    Command("studio", ("studio", "--no-browser", "small.toml"), "here", serves=True),
)


@dataclass(frozen=True)
class World:
    """The folders of a run."""

    path: Path

    @classmethod
    def of(cls, path: Path, warm: Path | None = None) -> World:
        """A new one; warm : a home to begin with, in which libraries have their caches."""
        for name in ("in", "tmp", "here/out"):
            (path / name).mkdir(parents=True)
        if warm is None:
            (path / "home").mkdir()
        else:
            shutil.copytree(warm, path / "home")
        for folder in ("in", "here"):
            (path / folder / "small.toml").write_text(JOB)
        for name, text in (("loaded", LOADED), ("tried", SWEEP), ("scan", SCAN)):
            (path / "in" / f"{name}.toml").write_text(text)
        for name, pattern in (("x", "square_twist"), ("m", "miura")):
            shutil.copy(PATTERNS / f"{pattern}.fold", path / "in" / f"{name}.fold")
        (path / "in" / "bump.3mf").write_bytes(_bump())
        return cls(path)

    def environment(self) -> dict[str, str]:
        """Variables of a run, and none of those that would lead it out of the world."""
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("XDG_", "MPL", "LC_"))}
        return {
            **kept,
            "HOME": str(self.path / "home"),
            "TMPDIR": str(self.path / "tmp"),
            "PYTHONPATH": str(ROOT),
            "PYTHONDONTWRITEBYTECODE": "1",
            "OMP_NUM_THREADS": "1",
        }

    def words(self, command: Command) -> list[str]:
        return [word.replace("{in}", str(self.path / "in")) for word in command.words]


def _bump() -> bytes:
    """A smooth mesh as 3MF, which is read in a process of its own, by way of a temporary file."""
    import numpy as np

    side = np.linspace(0.0, 60.0, 9)
    x, y = (each.ravel() for each in np.meshgrid(side, side, indexing="ij"))
    z = 6 * np.sin(x / 20) * np.cos(y / 25)
    number = np.arange(len(x)).reshape(9, 9)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], 2), np.stack([a, c, d], 2)]).reshape(-1, 3)
    points = "".join(f'<vertex x="{p}" y="{q}" z="{r}"/>' for p, q, r in zip(x, y, z, strict=True))
    sides = "".join(f'<triangle v1="{i}" v2="{j}" v3="{k}"/>' for i, j, k in faces.tolist())
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    relation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    package = "http://schemas.openxmlformats.org/package/2006"
    kinds = (
        ("rels", "application/vnd.openxmlformats-package.relationships+xml"),
        ("model", "application/vnd.ms-package.3dmanufacturing-3dmodel+xml"),
    )
    content = f"{package}/content-types"
    types = "".join(f'<Default Extension="{end}" ContentType="{kind}"/>' for end, kind in kinds)
    return zip_bytes(
        {
            "[Content_Types].xml": f'<Types xmlns="{content}">{types}</Types>'.encode(),
            "_rels/.rels": (
                f'<Relationships xmlns="{package}/relationships"><Relationship Id="r" '
                f'Target="/3D/3dmodel.model" Type="{relation}"/></Relationships>'
            ).encode(),
            "3D/3dmodel.model": (
                f'<model unit="millimeter" xmlns="{core}"><resources><object id="1" type="surface">'
                f"<mesh><vertices>{points}</vertices><triangles>{sides}</triangles></mesh></object>"
                '</resources><build><item objectid="1"/></build></model>'
            ).encode(),
        }
    )


@dataclass
class Ended:
    """How a run ended: its exit code, what it printed, and processes that it left running."""

    code: int
    told: str
    errors: str
    seconds: float
    orphans: list[int] = field(default_factory=list)
    before: bool = False  # whether it was interrupted before the program's first line
    sent: bool = False


class Run:
    """A process of a command, in a session of its own, with the signals that a terminal gives."""

    def __init__(
        self,
        world: World,
        command: Command,
        *,
        environment: Mapping[str, str] | None = None,
        before: Callable[[], None] | None = None,
        prefix: Sequence[str] = (),
        **streams: Any,
    ) -> None:
        self.command, self._begin = command, time.monotonic()
        self._out, self._err = io.BytesIO(), io.BytesIO()

        def begin() -> None:
            for number in (*STOPS, signal.SIGPIPE):
                signal.signal(number, signal.SIG_DFL)  # a shell's background ignores some
            if before is not None:
                before()

        self.process = subprocess.Popen(
            [*prefix, sys.executable, "-m", "fab", *world.words(command)],
            cwd=world.path / "here",
            env=world.environment() if environment is None else environment,
            start_new_session=True,
            preexec_fn=begin,
            **{
                "stdin": subprocess.DEVNULL,
                "stdout": subprocess.PIPE,
                "stderr": subprocess.PIPE,
                **streams,
            },
        )
        self._readers = [
            threading.Thread(target=self._read, args=pair, daemon=True)
            for pair in ((self.process.stdout, self._out), (self.process.stderr, self._err))
            if pair[0] is not None
        ]
        for reader in self._readers:
            reader.start()
        self.answered = threading.Event()
        if command.serves:
            threading.Thread(target=self._ask, daemon=True).start()

    def _read(self, stream: Any, into: io.BytesIO) -> None:
        with suppress(OSError, ValueError):
            while data := os.read(stream.fileno(), 65536):
                into.write(data)

    def _ask(self) -> None:
        """Have the studio make the files of a job, and keep them in its folder."""
        while self.process.poll() is None:
            found = re.search(rb"http://127\.0\.0\.1:\d+/[\w-]{32}/", self._out.getvalue())
            if found:
                break
            time.sleep(0.05)
        else:
            return
        address = found.group().decode()
        with suppress(OSError, urllib.error.URLError, ValueError, KeyError):
            made = _posted(address + "make", {"command": "run", "text": JOB, "tab": "1"})
            _posted(address + "keep", {"key": made["key"], "into": "out", "tab": "1"})
            self.answered.set()

    @property
    def heeds(self) -> bool:
        """Whether the program's own handler of signals is there yet, or has gone (Linux)."""
        with suppress(OSError):
            status = Path(f"/proc/{self.process.pid}/status").read_text()
            masks = dict(line.split(":\t", 1) for line in status.splitlines() if ":\t" in line)
            return bool((int(masks["SigCgt"], 16) | int(masks["SigIgn"], 16)) >> 14 & 1)
        return True

    def stop(self, number: int, *, group: bool) -> tuple[bool, bool]:
        """Send a signal. Whether it was sent, and whether it came before the program's handler."""
        if self.process.poll() is not None:
            return False, False
        early = not self.heeds
        with suppress(ProcessLookupError):
            (os.killpg if group else os.kill)(self.process.pid, number)
        return True, early

    def ended(self) -> Ended:
        """Wait for it, and for what it has started."""
        try:
            code = self.process.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            code = -99
        end = time.monotonic() + ORPHANS_S
        while (orphans := _session(self.process.pid)) and time.monotonic() < end and code != -99:
            time.sleep(0.1)
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        for reader in self._readers:
            reader.join(10)
        for stream in (self.process.stdout, self.process.stderr):
            if stream is not None:
                stream.close()
        told, errors = (each.getvalue().decode(errors="replace") for each in (self._out, self._err))
        return Ended(code, told, errors, time.monotonic() - self._begin, orphans)


def _posted(address: str, message: Mapping[str, Any]) -> dict[str, Any]:
    origin = "/".join(address.split("/")[:3])
    request = urllib.request.Request(
        address, json.dumps(message).encode(), {"Content-Type": "application/json"}
    )
    request.add_header("Origin", origin)
    with urllib.request.urlopen(request, timeout=LONGEST_S) as response:
        data = response.read()
    return json.loads(data[4 : 4 + int.from_bytes(data[:4], "little")])


def _session(leader: int) -> list[int]:
    """Processes of a session that are neither dead nor done with."""
    out = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with suppress(OSError, ValueError, IndexError):
                parts = (entry / "stat").read_text().rpartition(")")[2].split()
                if int(parts[3]) == leader and parts[0] not in "ZX":
                    out.append(int(entry.name))
    return out


def run_to_end(world: World, command: Command, **how: Any) -> Ended:
    """A run that nothing disturbs; the studio is ended by Ctrl-C when it has answered."""
    run = Run(world, command, **how)
    if command.serves:
        end = time.monotonic() + LONGEST_S
        while not run.answered.wait(0.1) and run.process.poll() is None and time.monotonic() < end:
            pass
        run.stop(signal.SIGINT, group=False)
    return run.ended()


Tree = dict[str, bytes]


def tree(folder: Path) -> Tree:
    """Everything under a folder by its relative path: bytes of files, and what else there is."""
    out: Tree = {}
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(place, name)
            key = str(path.relative_to(folder))
            with suppress(FileNotFoundError):
                if path.is_symlink():
                    out[key] = b"link to " + os.fsencode(path.readlink())
                elif path.is_dir():
                    out[key] = b"folder"
                else:
                    out[key] = path.read_bytes()
    return out


def normal(name: str, data: bytes) -> bytes:
    """A file without how long things took, which no two runs share."""
    if name.endswith(".json"):
        return json.dumps(_timeless(json.loads(data))).encode()
    if name.endswith(".parquet"):
        table = pq.read_table(io.BytesIO(data))
        kept = [column for column in table.column_names if column != "seconds"]
        return json.dumps(table.select(kept).to_pylist(), default=str).encode()
    if name.endswith("results.csv"):
        rows = [dict(row) for row in csv.DictReader(io.StringIO(data.decode()))]
        return json.dumps(
            [{k: v for k, v in row.items() if k != "seconds"} for row in rows]
        ).encode()
    if name.endswith(".html"):
        return re.sub(rb'"seconds": ?(\{[^}]*\}|[\d.e-]+)|\d+(\.\d+)? s\b', b"", data)
    return data


def _timeless(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _timeless(v) for k, v in value.items() if k not in ("seconds", "sha256")}
    if isinstance(value, list):
        return [_timeless(each) for each in value]
    return value


@dataclass(frozen=True)
class Whole:
    """What a run makes that nothing disturbs, its exit code, and how long it takes."""

    command: Command
    files: Mapping[str, bytes]
    raw: Mapping[str, bytes]
    code: int
    seconds: float
    told: str


def prepared(command: Command, world: World) -> None:
    """Run what the command needs."""
    if command.needs:
        run_to_end(world, Command("needs", command.needs))


def whole_of(command: Command, folder: Path, warm: Path | None) -> Whole:
    """Of two runs, which must make the same. Raises `AssertionError` where they do not."""
    made = []
    for number in range(2):
        world = World.of(folder / f"{command.name} {number}".replace(" ", "_"), warm)
        prepared(command, world)
        ended = run_to_end(world, command)
        assert ended.code in (0, 1), (command.name, ended)
        assert "Traceback" not in ended.errors, ended.errors
        assert not ended.orphans, (command.name, ended)
        found = tree(world.path / command.out)
        files = {name: normal(name, data) for name, data in found.items()}
        made.append(Whole(command, files, found, ended.code, ended.seconds, ended.told))
        assert not tree(world.path / "tmp"), (command.name, tree(world.path / "tmp"))
    first, second = made
    assert first.files.keys() == second.files.keys(), set(first.files) ^ set(second.files)
    differ = [name for name, data in first.files.items() if second.files[name] != data]
    differ = [name for name in differ if not _is_kept(command, name)]
    assert not differ, (command.name, differ)
    return second


def _is_kept(command: Command, name: str) -> bool:
    return any(fnmatch.fnmatch(name, pattern) for pattern in command.kept)


def faults_of(
    world: World,
    whole: Whole,
    before: Tree,
    ended: Ended,
    *,
    codes: Sequence[int],
    is_complete: bool,
    killed: bool = False,
    any_files: bool = False,
) -> list[str]:
    """What is wrong after a run.

    before : the tree of the world as it was. codes : exit codes that are right. is_complete :
    whether every file must be that of the whole run. killed : whether its folders may be left.
    any_files : whether what is made is another thing than the whole run's.
    """
    found = []
    if ended.code not in codes:
        found.append(f"exit code {ended.code}, not one of {list(codes)}: {ended.errors[-2000:]}")
    for word in ("Traceback", "Exception ignored", "Error in"):
        if word in ended.errors and not ended.before:
            found.append(f"{word}: {ended.errors[-2500:]}")
    if ended.orphans and not killed:
        found.append(f"processes left: {ended.orphans}")
    out = whole.command.out + "/"
    after = tree(world.path)
    for path, data in after.items():
        if before.get(path) == data:
            continue
        name = path.removeprefix(out)
        if any_files and path.startswith(out) and not name.startswith("."):
            continue
        if path + "/" == out or (path + "/" in out and data == b"folder"):
            continue
        if not path.startswith(out) or (path not in before and name not in whole.files):
            stray = ".quadfold-" in path or path.startswith("tmp/")
            if killed and stray:
                continue
            if path.startswith(out) and _is_kept(whole.command, name) and not is_complete:
                continue
            if path.startswith("home/.cache") or path in ("home/.config", "home/.cache"):
                continue  # of libraries
            found.append(f"stray: {path} ({len(data)} bytes)")
        elif name in whole.files and not _is_kept(whole.command, name):
            try:
                same = normal(name, data) == whole.files[name]
            except Exception as error:  # a file that is cut short is no JSON, or anything
                same = False
                found.append(f"unreadable: {path}: {error}")
            if not same:
                found.append(f"neither whole nor the older one: {path} ({len(data)} bytes)")
    for path, data in before.items():
        if path not in after and not (killed and path.startswith("tmp/")):
            found.append(f"lost: {path}")
        elif after.get(path) != data and not path.startswith((out, "home/.cache")):
            found.append(f"changed: {path}")
    if is_complete:
        for name, data in whole.files.items():
            if _is_kept(whole.command, name):
                continue
            if name not in {path.removeprefix(out) for path in after if path.startswith(out)}:
                found.append(f"not made: {name} ({len(data)} bytes)")
            elif after[out + name] == OLD:
                found.append(f"not made again: {name}")
    return found
