"""Commands with any words, run as from a terminal in a folder with small files.

Words are drawn by what the options of a command take, and with faults. Whatever they are, a command
ends with an exit code of the documented ones and a sentence for what it refuses; it writes nothing
where it refuses or is asked for a dry run, and leaves what was there as it was but for the files
that it names.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import io
import json
import shutil
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest import mock

import click
import numpy as np
from fuzz.kept_faults import option_faults
from fuzz.kept_kinds import sweep_files
from fuzz.seeds import patterns
from fuzz.table_faults import toml_text
from fuzz.trials import Kind

from fab import preferences
from fab.cli.answering import exit_code
from fab.cli.group import main
from fab.errors import InvalidJob
from fab.formats.fold.writer import fold_bytes
from fab.interrupts import Interrupts

__all__ = ["COMMAND_KINDS"]

Random = np.random.Generator
# Commands that end by themselves, and how often each is drawn. `sweep` has workers of its own, so
# that it is only asked what it would do.
_COMMANDS = {
    **{"fabricate": 6, "convert": 6, "simulate": 6, "check": 3, "run": 4, "thicken": 2},
    **{"animate": 1, "coupon": 1, "shipped": 1, "templates": 1, "new": 2, "figure": 1},
    **{"findings": 1, "settings": 2, "sweep": 2, "table": 2, "": 1},
}
_DELIVERED = ("run", "fabricate", "thicken", "simulate", "animate")
_JOB: dict[str, Any] = {
    "name": "small",
    "design": {"kind": "miura", "columns": 4, "rows": 3, "fold_deg": 40.0},
    "sheet": {"width_mm": 120.0},
    "outputs": ["fold", "dxf"],
}
_SWEEP = {"name": "few", "base": "small.toml", "axes": {"design": {"rows": [3, 4]}}}
_LARGEST = 40
_WHOLE = ("0", "1", "2", "3", "-1", "7", "1e3", "2.5", "10000000", "9" * 30, "0x2", "", "two", "٣")
_REAL = (
    *("1", "0.5", "90", "120", "200.0", "0", "-0", "-1", "nan", "inf", "-inf", "1e300", "1e-300"),
    *("1e400", "3,5", "", "1_0", "0x1p3", "ten", "\uff11\uff12", "1" * 400, "--out", " 2 ", "5mm"),
)
_NAMES = (
    *("", "x", "é", ".", "..", "-", "--", "=", ",", ",,", "a" * 300, "a b", "\udcff", "\x1b[31mx"),
    *("../x", "/dev/null", "/proc/x/y", "CON", "*", "~", "$HOME", "%s", "{}", "a\nb", "\u202ex"),
)
_SETS = (
    *("design.rows=4", "sheet.width_mm=90.0", "outputs=['svg']", "panels.thickness_mm=0.8"),
    *("cutter.sheets=2", "cutter.material='card_300gsm'", "hinges.web_mm=0.3", "name='other'"),
    *("perforation.mountain.cut_mm=2.0", "cutter.kerf_mm=0.1", "simulation.steps=2", "panels={}"),
)
# What options of a name take, apart from numbers and choices.
_TAKEN: dict[str, tuple[str, ...]] = {
    "--only": ("fold", "dxf", "svg", "dxf,svg", "DXF", "pdf", "json", "fold,fold", "png", "x,y"),
    "--set": _SETS,
    "--colours": ("#ff0000=mountain", "red=valley,blue=cut", "a=b", "#f00=M", "=mountain", "x="),
    "--copies": ("2", "1,2", "2,1,1", "0", "1.5", "1,,2", "100000", "9" * 20, "-1,2"),
    "--fix": (
        *("left edge", "lowest", "corners", "border", "0", "3", "99", "0,0,50,50", "0,0,1"),
        *("50,50,0,0", "nan,0,0,0", "middle", "Left Edge", "-1", "1e400,0,0,0", "٣", "²"),
    ),
    "--pull": (
        *("0=0,0,-0.5", "right edge=0,0,1", "5=1,2", "=1,2,3", "a=b=0,0,1", "0=nan,0,0", "0"),
        *("corners=1e300,0,0", "0,0,9,9=0,0,0.1", "highest=0,0,0"),
    ),
    "--down": ("0,0,-1", "0,0,0", "1,0", "nan,0,0", "1e-300,0,0", "1e300,1e300,0", "a,b,c"),
    "--material": ("card_300gsm", "copy_80gsm", "pp_filament", "pla", "mine.toml", "small.toml"),
    "--machine": ("co2_60w_600x400", "knife_a4", "prusa_mk4s", "mine.toml"),
    "--printer": ("prusa_mk4s", "bambu_a1", "knife_a4", "mine.toml"),
    "--cluster": ("local", "tcp://x:1", "slurm", "4"),
    "--best": ("flat.x_mm", "-crossings", "x", "status"),
    "--where": ("crossings = 0", "status = 'made'", "x", "1; 2", "'", "number / 0 > 1"),
    "--show": ("status", "flat.x_mm,status", "x", "*"),
}
_WORDS = {
    "job": ("small.toml", "miura", "mura", "missing.toml", "small.fold", "twist.svg", "sub"),
    "sweep": ("few.toml", "small.toml", "missing.toml", "sub"),
    "folder": ("swept", "sub", "missing", "small.toml", "swept/results.parquet"),
    "template": ("miura", "lamp_shade", "mura", "../miura", "miura.toml"),
    "word": ("card", "dome", "laser", "(", "[", "miura"),
    "names": ("1a", "2", "fig3", "s99", "3b"),  # none of them, as some take minutes
    "code": ("fold-blocked", "fold-bloked", "crease-dangling", "all"),
    "key": ("material", "printer", "machine", "mterial", "print_material"),
    "name": ("card_300gsm", "prusa_mk4s", "pp_filament", "mine.toml"),
    "kind": ("materials", "machines", "printers"),
}
# What commands are mostly given, without which they do little or take long.
_USUAL = {
    "fabricate": {"--material": "card_300gsm", "--machine": "co2_60w_600x400"},
    "coupon": {"--material": "card_300gsm", "--machine": "co2_60w_600x400"},
    "simulate": {"--only": "fold"},
    "animate": {"--only": "html"},
    "thicken": {"--only": "stl"},
}
_OUT = ("made", "sub", "sub/deep/er", "small.toml", "made/", "../beside", "small.toml/x")


def _of(random: Random, values: Sequence[Any]) -> Any:
    return values[int(random.integers(len(values)))]


@cache
def _files() -> dict[str, bytes]:
    """Small files of all sorts, by their path in the folder."""
    small = [one for one in patterns() if len(one.edges_vertices) <= _LARGEST]
    files = {f"small{i or ''}.fold": fold_bytes(one, "small") for i, one in enumerate(small[:6])}
    lines = "".join(
        f'<line x1="{x}" y1="{y}" x2="{u}" y2="{v}" stroke="{colour}"/>'
        for x, y, u, v, colour in (
            *((0, 0, 80, 0, "black"), (80, 0, 80, 60, "black"), (80, 60, 0, 60, "black")),
            *((0, 60, 0, 0, "black"), (40, 0, 40, 60, "red"), (0, 30, 80, 30, "blue")),
        )
    )
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 80 60">{lines}</svg>'
    return files | {
        "twist.svg": svg.encode(),
        "small.toml": toml_text(_JOB).encode(),
        "few.toml": toml_text(_SWEEP).encode(),
        "mine.toml": b'kind = "sheet"\nthickness_mm = 0.3\n',
        "empty.fold": b"",
        "sub/crease.cp": b"1 0 0 9 0\n1 9 0 9 9\n1 9 9 0 9\n1 0 9 0 0\n2 0 0 9 9\n",
        "swept/results.parquet": sweep_files()[-1],
    }


def _pattern(random: Random) -> str:
    folds = [name for name in _files() if name.endswith((".fold", ".svg", ".cp"))]
    return str(_of(random, folds)) if random.integers(8) else str(_of(random, ("x.fold", "sub")))


def _value(random: Random, option: click.Parameter) -> str:
    """What an option or argument takes, or a fault."""
    name = option.opts[0]
    if random.integers(12) == 0:
        return str(_of(random, _NAMES))
    if name in ("file", "files"):
        return _pattern(random)
    taken = _TAKEN.get(name) or _WORDS.get(name)
    if name == "--out":
        return str(_of(random, _OUT))
    if taken is not None:
        word = option_faults(random, taken)[0] if random.integers(4) == 0 else _of(random, taken)
        return str(word).replace("\0", "")
    if isinstance(option.type, click.Choice):
        return str(_of(random, [*option.type.choices, "x"]))
    whole = isinstance(option.type, (click.types.IntParamType, click.IntRange))
    return str(_of(random, _WHOLE if whole else _REAL))


def _one(random: Random, option: click.Option) -> list[str]:
    name = _of(random, [*option.opts, *option.secondary_opts])
    if option.is_flag:
        return [name]
    value = _value(random, option)
    return [f"{name}={value}"] if random.integers(4) == 0 else [name, value]


def _words(random: Random, name: str, command: click.Command) -> list[str]:
    """The words of a command; most of them without a fault."""
    if isinstance(command, click.Group):
        names = sorted(command.commands)
        if name == "settings" and random.integers(3) == 0:
            return []
        chosen = _of(random, [*names, "x"])
        more = command.commands.get(chosen)
        return [chosen, *(_words(random, chosen, more) if more else [])]
    arguments: list[str] = []
    options: list[list[str]] = []
    every = _of(random, (4, 12, 12, 30))
    for one in command.params:
        if isinstance(one, click.Argument):
            count = _of(random, (1, 1, 1, 2, 3)) if one.nargs != 1 else 1
            arguments += [_value(random, one) for _ in range(count)]
        elif isinstance(one, click.Option) and random.integers(every) == 0:
            options += [_one(random, one) for _ in range(_of(random, (1, 1, 2)))]
    if name == "convert":
        arguments.append(_of(random, ("out.svg", "out.dxf", ".cp", "made/out.png", "x.y", "sub")))
    if random.integers(4):
        options += [[key, value] for key, value in _USUAL.get(name, {}).items()]
    if name in ("sweep", "figure") or (name in _DELIVERED and random.integers(3) == 0):
        options.append(["--dry-run"])
    kind = random.integers(40)
    if kind == 0:
        options.append([_of(random, ("--x", "-x", "--", "-", "--json=1", "--out", "--help"))])
    elif kind == 1:
        arguments = arguments[1:]
    elif kind == 2:
        arguments.append(_of(random, _NAMES))
    order = [options[i] for i in random.permutation(len(options))]
    return [*arguments, *(word for words in order for word in words)]


@cache
def _loaded() -> None:
    """Load libraries whose room is not that of a command."""
    for name in ("build123d", "matplotlib.pyplot", "duckdb", "optuna"):
        importlib.import_module(name)


def _written(random: Random) -> bytes:
    _loaded()
    names = [name for name, count in _COMMANDS.items() for _ in range(count)]
    name = _of(random, names)
    if name:
        words = [name, *_words(random, name, main.commands[name])]
    else:
        words = [_of(random, ("", "mke", "--version", "--help", "-h", "fabricat", "--x"))]
    return json.dumps(words).encode()


def _listed(folder: Path) -> dict[str, str]:
    """All that is in a folder: hashes of files, nothing of folders."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        if path.is_file()
        else ""
        for path in sorted(folder.rglob("*"))
    }


@contextlib.contextmanager
def _in_folder(there: Path) -> Iterator[None]:
    """In a folder with the small files, with no settings of a user."""
    shutil.rmtree(there, ignore_errors=True)
    for name, data in _files().items():
        path = there / "here" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    own = there / "home" / "settings.toml"
    with (
        contextlib.chdir(there / "here"),
        mock.patch.object(preferences, "preferences_file", return_value=own),
    ):
        yield


def _run(words: list[str]) -> tuple[int, str, str]:
    """A command run in this process: its exit code and what it prints."""
    streams = [io.BytesIO(), io.BytesIO()]
    out, err = (
        io.TextIOWrapper(stream, "utf-8", errors=errors, write_through=True)
        for stream, errors in zip(streams, ("strict", "backslashreplace"), strict=True)
    )
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = exit_code(words, Interrupts())
    return code, *(stream.getvalue().decode() for stream in streams)


@cache
def _valued() -> frozenset[str]:
    """Options that take the word after them."""
    options = [one for command in main.commands.values() for one in command.params]
    return frozenset(
        name
        for one in options
        if isinstance(one, click.Option) and not one.is_flag
        for name in one.opts
    )


def _flags(words: Sequence[str]) -> set[str]:
    """Words that are asked for, and are not the value of the option before them."""
    return {word for before, word in pairwise(["", *words]) if before not in _valued()}


def _command(path: Path, random: Random) -> str:
    words = json.loads(path.read_bytes())
    flags = _flags(words)
    there = path.with_name("there")
    with _in_folder(there):
        before = _listed(there)
        code, out, err = _run(words)
        after = _listed(there)
    dry = "--dry-run" in flags
    assert code in (0, 1, 2), f"exit code {code}"
    for text in (out, err):
        assert "Traceback" not in text, "no traceback is shown"
        assert not any(c != "\n" and (ord(c) < 32 or ord(c) == 127) for c in text), repr(text)
    changed = {name for name in {*before, *after} if before.get(name) != after.get(name)}
    strayed = {name for name in changed if "quadfold-" in name or not after.get(name, "x")}
    folders = {name for name in strayed if not after.get(name)} - {"here/sub"}
    assert not any("quadfold-" in name for name in strayed), f"strays {strayed}"
    assert not before.keys() - after.keys(), f"lost {before.keys() - after.keys()}"
    if code == 2 or dry:
        assert not changed, f"writes {sorted(changed)}"
    assert all(any(name.startswith(f"{one}/") for name in after) for one in folders), folders
    if code == 2:
        last = [row for row in err.split("\n") if row.startswith(("quadfold: ", "Error: "))]
        assert last, f"a refusal without a sentence: {err!r}"
        if last[-1].startswith("quadfold: "):
            raise InvalidJob(err.partition("quadfold: ")[2])
    elif words and words[0] in _DELIVERED and "--help" not in flags:
        said = any(row.startswith("error: ") for row in err.split("\n"))
        if "--json" in flags:
            findings = json.loads(out, parse_constant=_no_number)["findings"]
            said = any(finding["severity"] == "error" for finding in findings)
        assert said == (code == 1), f"exit code {code} with {err!r}"
        if "--quiet" in flags:
            assert not out, "quiet commands print nothing"
    kept = {name for name in changed if not name.endswith("_report.json")}  # they have seconds
    hashes = {name: after[name] for name in sorted(kept)}
    return f"{code} {hashes}"


def _no_number(name: str) -> float:
    raise AssertionError(f"{name} in JSON")


COMMAND_KINDS = (
    Kind(
        "command", "command.json", _written, _command, seconds=120.0, memory_mb=1200.0, opens=True
    ),
)
