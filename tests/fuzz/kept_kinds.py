"""Files that the program keeps for users and for itself, and the words of their options.

Settings, materials in the studio's folder, changes of `--set`, checkpoints of folds, and the parts,
tables and journals of sweeps.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import flat_patterns
import numpy as np
from fuzz.kept_faults import archive_faults, journal_faults, option_faults, table_faults
from fuzz.table_faults import Corpus, toml_text
from fuzz.table_kinds import documents
from fuzz.trials import Kind

from fab import preferences
from fab.cli.load_options import with_loads
from fab.errors import Finding
from fab.folding.bar_hinge_model import Framework, framework
from fab.folding.checkpoints import FoldCheckpoints
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import fold
from fab.printing.thick_settings import thick_settings
from fab.sheets.cutter_settings import cutter_tables
from fab.studio.stock import KINDS as STOCK_KINDS
from fab.studio.stock import names_of, stock
from fab.sweeps.columns import FIGURES, OUTCOME
from fab.sweeps.parts import Parts
from fab.sweeps.search import Search
from fab.sweeps.sweep_folder import SweepFolder
from fab.sweeps.sweep_settings import load_sweep
from fab.sweeps.sweep_table import choose
from fab.sweeps.variations import Variations, variations_of
from solver.vectors import FloatArray

__all__ = ["KEPT_KINDS", "sweep_files"]

Random = np.random.Generator
_SETTINGS: tuple[dict[str, Any], ...] = (
    {"material": "card_300gsm", "machine": "co2_60w_600x400"},
    {"printer": "prusa_mk4s", "print_material": "pp_filament"},
    {"material": "../mine.toml"},
    {},
)
_SWEEP = """
name = "kept"
base = "miura"
axes = {{ design.columns = [4, 6, 8], sheet.width_mm = {{ from = 50.0, to = 200.0, steps = 2 }} }}
{more}
"""
_SEARCH = 'search = { minimise = ["flat.x_mm"], conditions = ["crossings <= 0"], trials = 9 }'
_BEST = (None, "flat.x_mm", "-crossings", "x", "number", "-", "job_hash", "columns", 'a"b', "é")
_WHERE = (
    *(None, "crossings = 0", "status = 'made' and flat.x_mm < 90", "x", "1; 2", "'", '"', "(", ""),
    *(
        "number / 0 > 1",
        "status > 3",
        "number < 9e999",
        "read_text('/etc/passwd') = ''",
        "1 = 1)--",
    ),
    *(
        "repeat('a', 9) = 'a'",
        "error('x')",
        "number in (SELECT 1)",
        "columns[1]",
        "\x00",
        "a.b.c=1",
    ),
)
_STEPS = 2


def _of(random: Random, values: Any) -> Any:
    return values[int(random.integers(len(values)))]


@cache
def _settings() -> Corpus:
    return Corpus(_SETTINGS)


def _preferences(path: Path, random: Random) -> str:
    """The settings are read, and one of them is set or removed."""
    own = path.with_name("own.toml")
    shutil.copy(path, own)
    with mock.patch.object(preferences, "preferences_file", return_value=own):
        found = preferences.preferences()
        key = _of(random, ("material", "printer"))
        value = _of(random, (None, "card_300gsm", 'a"\n\\', "é\x7f"))
        preferences.set_preference(key, value)
        assert preferences.preferences() == found.model_copy(update={key: value}), "it is set"
    return found.model_dump_json()


@cache
def _stock() -> Corpus:
    kinds = [*documents("materials"), *documents("machines")]
    return Corpus([*kinds, {"kind": "sheet", "description": "mine"}])


def _of_folder(path: Path, random: Random) -> str:
    """The stock of a folder with such a file."""
    found = stock(path.parent)
    names = names_of(_of(random, STOCK_KINDS), path.parent)[-1:]
    return f"{ {kind: len(rows) for kind, rows in found.items()} } {names}"


@cache
def _words() -> tuple[str, ...]:
    """Changes that give what shipped and documented jobs have."""
    found = []
    for document in documents("jobs"):
        for name, table in document.items():
            if name in ("panels", "hinges", "printer", "plates", "cutter", "perforation"):
                rows = toml_text(table).split("\n")
                found += [f"{name}.{row}" for row in rows if re.match(r"\w+ = ", row)]
    return tuple(dict.fromkeys(found))


def _changes(random: Random) -> bytes:
    return "\n".join(option_faults(random, _words())).encode("utf-8", "surrogatepass")


def _changed(path: Path, random: Random) -> str:
    """Settings of panels or sheets with such changes; loads, where a line is one."""
    changes = path.read_bytes().decode("utf-8", "surrogatepass").split("\n")
    kind = random.integers(7)
    if kind < 3:
        return thick_settings(changes, _of(random, (None, "prusa_mk4s"))).model_dump_json()
    if kind < 6:
        stock = {"material": "card_300gsm", "machine": "knife_a4"}
        given = stock if random.integers(4) else {}
        return cutter_tables(changes, given).model_dump_json()
    words = [re.split(r"[=.]", change)[-1] for change in changes]
    loads = {"fixed": words, "down": [float(len(word)) for word in words]}
    return with_loads(FoldSettings(), loads).model_dump_json()


@cache
def _sheet() -> Framework:
    return framework(flat_patterns.fan(4, 30.0))


@cache
def _folded() -> tuple[FloatArray, ...]:
    return tuple(state.coords for state in fold(_sheet(), _STEPS).states)


class _Kept(FoldCheckpoints):
    """Checkpoints that are all remembered."""

    def keep(self, reached: Any) -> None:
        super().keep(reached)
        self.__dict__.setdefault("found", []).append(self._file.read_bytes())


def checkpoints() -> tuple[str, list[bytes]]:
    """The name of the checkpoints of a fold, and all of them."""
    with tempfile.TemporaryDirectory() as folder:
        kept = _Kept(Path(folder), "x", every_s=0.0)
        fold(_sheet(), _STEPS, checkpoint=kept)
        return kept._file.name, kept.__dict__["found"]


@cache
def _checkpoints() -> tuple[str, list[bytes]]:
    """Those of another process: one that has solved has threads, which its forks have not."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(checkpoints)


def _checkpoint(random: Random) -> bytes:
    return archive_faults(random, _of(random, _checkpoints()[1]))


def _goes_on(path: Path, random: Random) -> str:
    """The fold goes on or begins; it ends as in one go."""
    name = _checkpoints()[0]
    told: list[str | Finding] = []
    shutil.copy(path, path.with_name(name))
    folding = fold(_sheet(), _STEPS, checkpoint=FoldCheckpoints(path.parent, "x", told.append))
    path.with_name(name).unlink()
    (line,) = told
    assert isinstance(line, str) or line.code == "checkpoint-unusable", line
    pairs = zip(folding.states, _folded(), strict=True)
    assert all(np.array_equal(state.coords, coords) for state, coords in pairs), "the same fold"
    return type(line).__name__


@cache
def _sweeps() -> Path:
    """A folder with a sweep and a search, for as long as this process lasts."""
    folder = Path(tempfile.mkdtemp(prefix="fuzzed-sweep-"))
    for name, more in (("sweep", ""), ("search", _SEARCH)):
        (folder / f"{name}.toml").write_text(_SWEEP.format(more=more))
    return folder


@cache
def _variations(name: str) -> Variations:
    return variations_of(load_sweep(_sweeps() / f"{name}.toml"), "sweep")


def _folder(path: Path, name: str = "sweep") -> SweepFolder:
    return SweepFolder(path, load_sweep(_sweeps() / f"{name}.toml"), _variations(name))


def _rows(there: SweepFolder) -> list[dict[str, Any]]:
    values = {"text": "made", "whole": 3, "number": 1.5, "truth": True}
    columns = [*OUTCOME, *FIGURES]
    return [
        {column.name: values[column.kind] for column in columns}
        | {"job_hash": there.hash_of(one), "status": _STATUSES[one.number % 3], "message": None}
        for one in there.variations
    ]


_STATUSES = ("made", "refused", "crashed")


@cache
def sweep_files() -> tuple[bytes, ...]:
    """Parts of a sweep, and its whole table at the end."""
    with tempfile.TemporaryDirectory() as folder:
        there = _folder(Path(folder))
        there.require_parts()
        rows = _rows(there)
        there.keep(rows[:2])
        there.keep(rows[2:])
        parts = [path.read_bytes() for path in there.parts.paths()]
        there.begin()
        there.write_results()
        return (*parts, (Path(folder) / "results.parquet").read_bytes())


def _part(random: Random) -> bytes:
    return table_faults(random, _of(random, sweep_files()[:-1]))


@contextlib.contextmanager
def _emptied(folder: Path) -> Iterator[Path]:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _resumed(path: Path, random: Random) -> str:
    """A sweep goes on in a folder with such a part, up to what it would run, and ends."""
    with _emptied(path.with_name("sweep")) as folder:
        there = _folder(folder)
        there.require_parts()
        (folder / "parts" / "a.parquet").write_bytes(path.read_bytes())
        known = Parts(folder / "parts").rows(["status", "flat.x_mm"])
        dropped, plan = there.drop_unsettled(), there.begin()
        there.keep([row for row in _rows(there) if row["job_hash"] in plan.hashes])
        statuses = there.write_results()
        assert sum(statuses.values()) == plan.variations, "every variation has a row"
        there.write_page()
    return f"{len(known)} {dropped} {plan.damaged} {sorted(map(str, statuses))}"


def _table(random: Random) -> bytes:
    return table_faults(random, sweep_files()[-1])


def _chosen(path: Path, random: Random) -> str:
    best, where = _of(random, _BEST), _of(random, _WHERE)
    show = [_of(random, ("status", "flat.x_mm", "x", ""))] if random.integers(3) == 0 else []
    chosen = choose(
        path,
        best=best,
        where=where,
        top=_of(random, (None, 0, 2)),
        show=show,
        whole=bool(random.integers(2)),
    )
    return f"{chosen.columns} {len(chosen.rows)} {chosen.matching}"


def _searched(folder: Path) -> Search:
    there = _folder(folder, "search")
    return Search(there.sweep, there.variations.axes, folder)


@cache
def _journals() -> tuple[bytes, ...]:
    """Journals of a search after some trials, the last of which is not done."""
    with tempfile.TemporaryDirectory() as folder:
        search = _searched(Path(folder))
        for number in range(5):
            trial = search._asked()
            row = {"status": "made", "flat.x_mm": 1.0 * number, "crossings": number % 2}
            if number < 4:
                search._tell(trial, row if number else None)
        data = (Path(folder) / "search.journal").read_bytes()
    for pattern, new in (
        (rb'"\d{4}-\d\d-\d\dT[\d:.]+"', b'"2020-01-01T00:00:00.000000"'),
        (rb'"worker_id": "[^"]*"', b'"worker_id": "a"'),
    ):
        data = re.sub(pattern, new, data)
    lines = data.splitlines(keepends=True)
    return data, b"".join(lines[: len(lines) // 2])


def _journal(random: Random) -> bytes:
    return journal_faults(random, _of(random, _journals()))


def _gone_on(path: Path, random: Random) -> str:
    """A search takes up the trials of such a journal, and asks for one more."""
    with _emptied(path.with_name("search")) as folder:
        shutil.copy(path, folder / "search.journal")
        search = _searched(folder)
        count = search._count()
        before = [one.values for one in search.variations()]
        search._tell(search._asked(), {"status": "made", "flat.x_mm": 3.0, "crossings": 0})
        assert search._count() >= count, "trials are counted"
    return f"{count} {before}"


def _kinds() -> Iterator[Kind]:
    own: Mapping[str, Any] = {"opens": True}
    yield Kind("settings", "settings.toml", lambda r: _settings().written(r), _preferences, **own)
    yield Kind("stock", "mine.toml", lambda r: _stock().written(r), _of_folder, **own)
    yield Kind("changes", "changes.txt", _changes, _changed)
    yield Kind("checkpoint", "kept.npz", _checkpoint, _goes_on, **own)
    yield Kind("sweep-part", "part.parquet", _part, _resumed, **own)
    yield Kind("sweep-table", "results.parquet", _table, _chosen, **own)
    yield Kind("journal", "search.journal", _journal, _gone_on, **own)


KEPT_KINDS = tuple(_kinds())
