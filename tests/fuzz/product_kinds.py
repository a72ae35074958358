"""Whole products of inputs with faults.

Sheets, panels, folds and files of other programs of patterns, and the files of jobs.
"""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from fuzz.oracle import options_of
from fuzz.seeds import fuzzed
from fuzz.table_faults import Corpus
from fuzz.trials import Kind

from fab.drawings.drawing_files import SheetFormat
from fab.folding.fold_settings import FoldSettings
from fab.folding.simulation import Solver
from fab.formats.reading import read_pattern_file
from fab.jobs.conversion import WRITTEN, convert
from fab.jobs.folding_files import SimulationFormat, simulate
from fab.jobs.job import Job, load_job
from fab.jobs.job_files import make
from fab.jobs.job_formats import Format
from fab.jobs.pattern_check import check_pattern
from fab.jobs.print_files import make_thick
from fab.jobs.reading import read_sheet
from fab.jobs.sheet_files import fabricate
from fab.jobs.thick_products import ThickFormat
from fab.pattern.crease_pattern import CreasePattern
from fab.printing.thick_settings import ThickSettings
from fab.sheets.materials import load_machine, load_material
from fab.sheets.sheet_request import SheetRequest

__all__ = ["PRODUCT_KINDS"]

Random = np.random.Generator
# Larger patterns, and jobs of more quads, are left to other runs.
_MOST_EDGES, _MOST_FACES, _MOST_QUADS = 200, 30, 1500
# Simulations of more steps, and fits of more columns or of a cell of their own, too.
_MOST_STEPS, _MOST_COLUMNS = 3, 8
_FIT = {"kind": "surface_fit", "surface": "bowl", "columns": 6}
_JOBS: tuple[dict[str, Any], ...] = tuple(
    {
        "name": "a",
        "design": design,
        "sheet": {"width_mm": 120.0},
        "perforation": {
            "margin_mm": 0.5,
            "mountain": {"cut_mm": 3.0, "gap_mm": 1.0},
            "valley": {"cut_mm": 1.0, "gap_mm": 1.0},
            "bands": [{"from_deg": 0.0, "to_deg": 30.0, "valley": {"kind": "score"}}],
            "relief": {"radius_mm": 1.0, "web_mm": 1.0},
        },
        "panels": {"thickness_mm": 0.8, "gap_mm": 0.4},
        "hinges": {"web_mm": 0.2, "relief_mm": 0.1},
    }
    for design in (
        {"kind": "miura", "columns": 4, "rows": 3, "fold_deg": 40.0},
        {"kind": "rigid_miura", "columns": 4, "rows": 4, "fold_deg": 90.0},
        {"kind": "cornered_miura", "columns": 6, "rows": 6, "corner_column": 2, "corner_row": 2},
        {"kind": "random_tube", "sides": 5, "strips": 2, "random_seed": 3},
        {"kind": "curved_fold"},
        {"kind": "strip_by_strip"},
        {"kind": "shaped_ribbon"},
        {**_FIT, "method": "relax"},
        {**_FIT, "surface": "waves", "thickness": 1.0, "trim": False},
    )
)
# What is added to some of them.
_MORE: tuple[dict[str, Any], ...] = (
    *({}, {}, {"simulation": {"steps": 2}}),
    {"simulation": {"steps": 2, "contact": True, "thickness_mm": 0.3, "axial": 30.0}},
    {"simulation": {"steps": 1, "loads": {"fixed": ["left edge"], "pressure_pa": 10.0}}},
    {"cutter": {"material": "card_300gsm", "machine": "co2_60w_600x400", "tabs": "both sides"}},
    {"cutter": {"material": "plywood_3mm", "machine": "diode_10w_400x400", "copies": 2}},
)


@cache
def _usual() -> SheetRequest:
    material, machine = load_material("card_300gsm"), load_machine("co2_60w_600x400")
    return SheetRequest(material, machine, formats=[SheetFormat.DXF], page=False)


def _read(path: Path, random: Random) -> CreasePattern | None:
    width = None if random.integers(3) == 0 else float(random.uniform(20, 300))
    pattern = read_sheet(path, options_of(random), width_mm=width).pattern
    return pattern if len(pattern.edges_vertices) <= _MOST_EDGES else None


def _sheet(path: Path, random: Random) -> str:
    pattern = _read(path, random)
    return "" if pattern is None else str(len(fabricate(pattern, "a", _usual()).files))


def _panels(path: Path, random: Random) -> str:
    pattern = _read(path, random)
    if pattern is None or pattern.face_count > _MOST_FACES:
        return ""
    return str(len(make_thick(pattern, "a", ThickSettings(), formats=[ThickFormat.STL]).files))


def _converted(path: Path, random: Random) -> str:
    """A pattern is checked, and written for another program."""
    read = read_pattern_file(path, options_of(random))
    if len(read.pattern.edges_vertices) > _MOST_EDGES:
        return ""
    check = check_pattern(read.pattern, 1e-6)
    target = path.with_name(f"written{_of(random, WRITTEN)}")
    made = convert(read, target)
    for name, data in made.files.items():
        (path.parent / name).write_bytes(data)
    if target.suffix == ".fold":
        counts = read_pattern_file(target).pattern.counts()
        assert counts == read.pattern.counts(), f"{counts}, not {read.pattern.counts()}"
    sizes = {name: len(data) for name, data in sorted(made.files.items())}
    return f"{check is not None and check.crossings} {sizes} {made.findings}"


def _folded(path: Path, random: Random) -> str:
    pattern = _read(path, random)
    if pattern is None or pattern.face_count > _MOST_FACES:
        return ""
    solver = _of(random, (Solver.QUASI_STATIC, Solver.RIGID))
    settings, formats = FoldSettings(steps=2), [SimulationFormat.FOLD]
    return str(len(simulate(pattern, "a", settings, solver=solver, formats=formats).files))


def _of(random: Random, values: Any) -> Any:
    return values[int(random.integers(len(values)))]


@cache
def _corpus() -> Corpus:
    return Corpus([job | more for job in _JOBS for more in _MORE])


def _made(path: Path, random: Random) -> str:
    job = load_job(path)
    steps = 0 if job.simulation is None else job.simulation.steps
    if _quads(job) > _MOST_QUADS or steps > _MOST_STEPS:
        return ""
    return str(len(make(job, [Format.FOLD, Format.DXF]).files))


def _quads(job: Job) -> float:
    """About how many quads a job grows, by the products of its whole numbers."""
    design = job.design.model_dump()
    if design["kind"] in ("crumpled", "brownian_ribbon"):
        return float("inf")
    if design["kind"] == "surface_fit":
        own = [key for key in ("cell_mm", "deviation_mm", "row_step", "rows") if design.get(key)]
        few = not own and (design["columns"] or 0) <= _MOST_COLUMNS
        return float(_MOST_COLUMNS**2 if few else "inf")
    keys = ("columns", "rows", "strips", "sides", "quads", "steps", "turns")
    return float(np.prod([max(float(design[key]), 1.0) for key in keys if design.get(key)]))


_SLOW: dict[str, Any] = {"seconds": 120.0, "memory_mb": 600.0, "opens": True}
PRODUCT_KINDS = (
    Kind("sheet", "fuzzed.fold", partial(fuzzed, "fold"), _sheet, **_SLOW),
    Kind("panels", "fuzzed.fold", partial(fuzzed, "fold"), _panels, **_SLOW),
    Kind("converted", "fuzzed.fold", partial(fuzzed, "fold"), _converted, **_SLOW),
    Kind("folded", "fuzzed.fold", partial(fuzzed, "fold"), _folded, **_SLOW),
    Kind("made-job", "job.toml", lambda random: _corpus().written(random), _made, **_SLOW),
)
