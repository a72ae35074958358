"""Tables that users write: jobs, materials, machines, sweeps, and jobs in the studio."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

from fuzz.table_faults import Corpus, Random
from fuzz.trials import Kind
from helpers import DOCS

from fab.catalogue import shipped
from fab.jobs.job import load_job, parse_job
from fab.printing.printers import load_print_material, load_printer
from fab.sheets.materials import load_machine, load_material
from fab.studio.tasks import opened
from fab.sweeps.search import Goals
from fab.sweeps.sweep_settings import load_sweep
from fab.sweeps.variations import variations_of

__all__ = ["TABLE_KINDS", "documents"]

_CHANGES = (
    *("panels.thickness_mm=1.2", "design.rows=3", "design.kind=miura", "x", "=", "a.b=1", "a=[[["),
    *("sheet={}", "sheet.width_mm=nan", "design=1", "name=é", ".=1", "outputs=['dxf']", "a..b=1"),
    *(
        "design.rows=" + "9" * 5000,
        "x=" + "[" * 5000,
        "x=1\ny=2",
        "perforation.bands=[{}]",
        "a=1e999",
    ),
)
_AXES = (
    *({"from": 20, "to": 60, "steps": 5}, {"random": [4, 12], "count": 3, "seed": 1}, [6, 8, 10]),
    *([], [1], [True, False], [1, "x"], ["a", "b"], {"from": 1, "to": 1e300, "steps": 10**9}),
    *({"from": 0, "to": 0, "steps": 1}, {"from": 1, "to": 2, "steps": 10**5}, [[1], [2]], {}),
    *({"random": [4, 12]}, {"random": [12, 4], "count": 3}, {"from": 1, "to": 2}, 1, "x", [1] * 9),
    *({"from": -(2**63), "to": 2**63, "steps": 3}, {"random": [0, 10**400], "count": 2}),
)
_KEYS_SWEPT = (
    *("design.rows", "design.columns", "design.fold_deg", "panels.thickness_mm", "sheet.width_mm"),
    *("name", "design", "x", "design.kind", "outputs", "perforation.mountain", "a.b.c", ""),
)
_CONDITIONS = (
    *("design.columns <= 2 * design.rows", "design.rows > 3", "x", "1", "design.rows", "((((1"),
    *("design.rows ** 9999999", "9**9**9**9 > 1", "design.rows / 0 > 1", "'a' * 10**10 > 1"),
    *("__import__('os')", "design.rows <= 2 <= 3", "(" * 300 + "1" + ")" * 300, "lambda: 1 < 2"),
    *(
        "design.rows if 1 else 2",
        "[x for x in 'a']",
        "crossings <= 0",
        "rows <",
        "\0",
        "1 << 10**9",
    ),
    *("-" * 5000 + "1 < 2", "1 < 2 and 2 < 3", "design.rows == 'x'", "design.__class__ > 1"),
)
_SWEEPS: tuple[dict[str, Any], ...] = (
    {"name": "zip", "base": "miura", "combine": "zip", "axes": {"design": {"rows": [3, 4]}}},
    {
        "name": "cube",
        "base": "lamp_shade",
        "combine": "latin_hypercube",
        "count": 20,
        "seed": 3,
        "axes": {"sheet": {"width_mm": {"from": 100.0, "to": 300.0, "steps": 5}}},
        "limits": {"seconds": 10.0, "memory_mb": 512},
        "outputs": ["dxf"],
        "pictures": True,
    },
    {
        "name": "search",
        "base": "miura",
        "measure": ["rigid", "fold", "thick", "sheets"],
        "axes": {"design": {"fold_deg": {"from": 20, "to": 60, "steps": 9}, "rows": [3, 5]}},
        "search": {
            "minimise": ["sheets.minutes"],
            "maximise": ["solids.mass_g"],
            "conditions": ["solids.clearance_min_mm >= 0.4"],
            "trials": 200,
            "seed": 1,
        },
        "cluster": {
            "kind": "slurm",
            "address": "tcp://node1:8786",
            "workers": 3,
            "queue": "short",
            "walltime": "02:00:00",
            "prologue": ["module load python"],
        },
    },
)


def _of(random: Random, values: Any) -> Any:
    return values[int(random.integers(len(values)))]


def documents(folder: Any, kind: str | None = None) -> list[dict[str, Any]]:
    """Shipped tables of a folder, and jobs of the documentation."""
    found = [
        tomllib.loads(path.read_text(encoding="utf-8")) for path in shipped(folder).values()
    ] + [table for table in _documented() if folder == "jobs" and "design" in table]
    usual = {"materials": "sheet", "machines": "cutter"}.get(folder)
    return [table for table in found if kind is None or table.get("kind", usual) == kind]


@cache
def _documented() -> tuple[dict[str, Any], ...]:
    """The TOML of all pages of the documentation."""
    found = []
    for page in sorted(DOCS.rglob("*.md")):
        for block in re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            try:
                found.append(tomllib.loads(block))
            except tomllib.TOMLDecodeError:  # a part of a file, with dots for the rest
                continue
    return tuple(found)


def _swept(random: Random, document: dict[str, Any]) -> None:
    """Other axes, constraints and conditions of a sweep."""
    kind = random.integers(5)
    if kind < 2:
        axes = document.setdefault("axes", {})
        if isinstance(axes, dict):
            axes[_of(random, _KEYS_SWEPT)] = _of(random, _AXES)
    elif kind == 2:
        document["constraints"] = [_of(random, _CONDITIONS) for _ in range(random.integers(1, 3))]
    elif kind == 3 and isinstance(document.get("search"), dict):
        document["search"]["conditions"] = [_of(random, _CONDITIONS)]
    else:
        document["base"] = _of(random, ("miura", "mura", "../x", "x.toml", "", "a" * 5000, "\0"))


def _job(path: Path, random: Random) -> str:
    changes = [_of(random, _CHANGES)] if random.integers(6) == 0 else []
    job = load_job(path, changes)
    if random.integers(16) == 0:
        assert parse_job(job.tables(), folder=path.parent) == job, "a job is that of its tables"
    return job.model_dump_json()


def _sweep(path: Path, random: Random) -> str:
    sweep = load_sweep(path)
    variations = variations_of(sweep, str(path))
    if sweep.search is not None:
        sweep.require_measured(Goals.of(sweep.search).needed)
    numbers = {0, variations.whole - 1} if variations.whole else set()
    jobs = [sweep.job(variations.values(number)).name for number in sorted(numbers)]
    for condition in variations.constraints:
        condition.excess(variations.values(0))
    first = [one.number for one in islice(variations, 3)] if variations.whole < 10**4 else []
    return f"{variations.whole} {jobs} {first}"


def _opened(path: Path, random: Random) -> str:
    data = path.read_bytes()
    return repr(opened(data.decode("utf-8", "replace"), str(path.parent), allow_code=False))


def _read(load: Callable[[Path], Any]) -> Callable[[Path, Random], str]:
    def read(path: Path, random: Random) -> str:
        return str(load(path).model_dump_json())

    return read


def _kind(
    name: str,
    documents: Callable[[], list[Mapping[str, Any]]],
    read: Callable[[Path, Random], str],
    changed: Callable[[Random, dict[str, Any]], None] | None = None,
    **more: Any,
) -> Kind:
    corpus = cache(lambda: Corpus(documents(), changed))
    return Kind(name, f"{name}.toml", lambda random: corpus().written(random), read, **more)


def _sweeps() -> list[Mapping[str, Any]]:
    return [*_SWEEPS, *(table for table in _documented() if "axes" in table)]


TABLE_KINDS = (
    _kind("job", lambda: documents("jobs"), _job, share=4.0),
    _kind("material", lambda: documents("materials", "sheet"), _read(load_material), share=4.0),
    _kind("cutter", lambda: documents("machines", "cutter"), _read(load_machine), share=4.0),
    _kind("printer", lambda: documents("machines", "printer"), _read(load_printer), share=5.0),
    _kind(
        "print-material",
        lambda: documents("materials", "print"),
        _read(load_print_material),
        share=5.0,
    ),
    _kind("sweep", _sweeps, _sweep, _swept, opens=True),
    _kind("studio-job", lambda: documents("jobs"), _opened),
)
