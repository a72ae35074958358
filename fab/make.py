"""How does a job become files?

The flow, and the only place where its branches join:

    design -> mesh -> development -> crease pattern -+-> perforation -> DXF, SVG
                                                     +-> FOLD, PNG
                                                     +-> thick sheet -> STEP, STL, 3MF, PNG
"""

from __future__ import annotations

import dataclasses
import errno
import hashlib
import json
import math
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from fab.clock import Clock, Progress, silent
from fab.crease import CreasePattern, crease_pattern
from fab.crossing import crossing_faces
from fab.development import Development, develop
from fab.errors import Finding, InvalidJob, Severity
from fab.fold_file import fold_bytes
from fab.inspection import inspect_accuracy, inspect_crossings, measure_pattern
from fab.job import Job, design_key
from fab.perforation import perforate
from solver import DESIGNS, Growth, InvalidValue, Status
from solver.vectors import FloatArray

__all__ = [
    "Format",
    "Made",
    "Progress",
    "box_mm",
    "file_names",
    "grown_pattern",
    "left_over",
    "make",
    "require_folder",
    "with_report",
    "write",
]

# A sheet that covers less of its surface is told of.
_COVERED = 0.95

# What helps where files cannot be written.
_CURES = {
    errno.ENAMETOOLONG: "Give the file that they are made from, or --out, a shorter name.",
    errno.ENOSPC: "Free some space, or choose another --out.",
    errno.EDQUOT: "Free some space, or choose another --out.",
}


class Format(StrEnum):
    """The kinds of files that a job makes, named by their endings."""

    FOLD = "fold"
    DXF = "dxf"
    SVG = "svg"
    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"
    ZIP = "zip"


@dataclass(frozen=True)
class Made:
    """What a job made: files by name, and the report that goes with them."""

    files: Mapping[str, bytes]
    report: Mapping[str, Any]
    findings: tuple[Finding, ...]

    @property
    def within_tolerance(self) -> bool:
        """Whether no finding is an error."""
        return all(finding.severity != Severity.ERROR for finding in self.findings)


def make(job: Job, formats: Sequence[Format] | None = None, progress: Progress = silent) -> Made:
    """Run a job in memory: grow, develop, and write each of `formats` as bytes.

    formats : those of the job where none are given.

    progress : called with (stage, steps done, steps in the stage).

    Raises `InvalidJob` where the design's parameters leave nothing to grow, or a sheet without
    area. Growth that stops early, overlaps and the like are findings in the report.
    """
    formats = [Format(name) for name in job.outputs] if formats is None else formats
    wanted = set(formats)
    clock = Clock(progress)
    findings: list[Finding] = []
    growth, development, pattern = _grown(job, clock)
    findings += [*_growth_findings(growth), *_overlap_findings(development)]
    with clock.stage("measure"):
        accuracy = measure_pattern(pattern)
        findings += inspect_accuracy(accuracy, job.tolerance)
    with clock.stage("cross"):
        folded = growth.mesh.cut_open().vertices_coords
        crossings = crossing_faces(folded, pattern.faces_vertices, pattern.faces_offsets)
        findings += inspect_crossings(crossings)

    files: dict[str, bytes] = {}
    assert pattern.folded_coords is not None  # what was grown has its folded form
    boxes = {
        "flat": box_mm(pattern.vertices_coords),
        "folded": box_mm(pattern.folded_coords),
    }
    if Format.FOLD in wanted:
        with clock.stage("fold"):
            files[f"{job.name}.fold"] = fold_bytes(pattern, job.name)
    findings += _flat_files(job, pattern, wanted, files, clock)
    solids: dict[str, Any] | None = None
    if wanted & {Format.STEP, Format.STL, Format.THREEMF, Format.ZIP}:
        solids = _solid_files(job, pattern, wanted, files, findings, boxes, clock)
    simulation: dict[str, Any] | None = None
    if job.simulation is not None:
        from fab.simulation import simulated

        _, verdict, told = simulated(pattern, job.simulation, progress=clock.progress)
        findings += told
        simulation = verdict.report()
    if Format.PNG in wanted:
        from fab.picture import png_bytes

        with clock.stage("png"):
            files[f"{job.name}.png"] = png_bytes(pattern, job.name)
    report = {
        "quadfold": _version(),
        "job": job.model_dump(mode="json"),
        "growth": {
            "status": growth.status,
            "strips": growth.strips,
            "advice": growth.advice,
            "coverage": growth.coverage,
            "chosen": dict(growth.chosen),
        },
        "counts": {
            "vertices": len(pattern.vertices_coords),
            "faces": pattern.face_count,
            "creases": pattern.counts(),
        },
        **{key: _number(value) for key, value in dataclasses.asdict(accuracy).items()},
        "crossings": len(crossings),
        "bounding_box_mm": boxes,
        "solids": solids,
        "simulation": simulation,
        "seconds": clock.seconds,
    }
    return with_report(files, "report.json", report, findings)


def with_report(
    files: Mapping[str, bytes], name: str, report: Mapping[str, Any], findings: Sequence[Finding]
) -> Made:
    """Files and their report, the last of them: what is told, then all files and findings."""
    listed = [
        {"file": file, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
        for file, data in files.items()
    ]
    told = [dataclasses.asdict(finding) for finding in findings]
    report = {**report, "outputs": listed, "findings": told}
    data = (json.dumps(report, indent=2, allow_nan=False) + "\n").encode()
    return Made({**files, name: data}, report, tuple(findings))


def grown_pattern(
    job: Job, progress: Progress = silent
) -> tuple[CreasePattern, tuple[Finding, ...]]:
    """The crease pattern of a job, and what is to be told of its growth. Raises as `make`."""
    growth, _, pattern = _grown(job, Clock(progress))
    return pattern, tuple(_growth_findings(growth))


def _grown(job: Job, clock: Clock) -> tuple[Growth, Development, CreasePattern]:
    with clock.stage("grow") as step, _named(job):
        growth = job.design.design(job.folder).grow(step)
    with clock.stage("develop"), _named(job):
        mesh = growth.mesh.cut_open()  # rings and tubes lie flat along a cut
        development = develop(mesh)
        return growth, development, crease_pattern(mesh, development, job.sheet.scale(development))


@contextmanager
def _named(job: Job) -> Iterator[None]:
    """Name the job's own key where the solver refuses a value."""
    try:
        yield
    except InvalidValue as error:
        design = DESIGNS[job.design.kind]
        keys = {field.name: design_key(field) for field in dataclasses.fields(design)}
        key = keys.get(error.name.partition("[")[0])
        place = f"design.{key}" if key else "design"
        raise InvalidJob(f"{place}: {error}") from error


def _flat_files(
    job: Job,
    pattern: CreasePattern,
    wanted: set[Format],
    files: dict[str, bytes],
    clock: Clock,
) -> list[Finding]:
    if not wanted & {Format.DXF, Format.SVG}:
        return []
    from fab.drawings import SheetFormat, drawing_files

    with clock.stage("perforate"):
        paths, findings = perforate(pattern, job.perforation)
    for kind in (Format.DXF, Format.SVG):
        if kind in wanted:
            with clock.stage(kind):
                files |= drawing_files(paths, job.name, [SheetFormat(kind.value)])
    return findings


def _solid_files(
    job: Job,
    pattern: CreasePattern,
    wanted: set[Format],
    files: dict[str, bytes],
    findings: list[Finding],
    boxes: dict[str, list[float]],
    clock: Clock,
) -> dict[str, Any] | None:
    from fab.thick_files import ThickFormat, thick_files

    formats = {kind for kind in ThickFormat if kind.value in set(wanted)}
    made = thick_files(pattern, job.name, job, formats, clock, job.print_with(job.folder))
    findings += made.findings
    if made.figures is None or made.print_mm is None:
        return None
    boxes["print"] = made.print_mm
    for end, data in made.data.items():
        files[job.name + ("_thick.png" if end == ".png" else end)] = data
    return {**dataclasses.asdict(made.figures), "plates": made.plates}


def _growth_findings(growth: Growth) -> list[Finding]:
    findings = []
    if growth.status != Status.GROWN:
        text = f"growth stopped after {growth.strips} strips ({growth.status}). {growth.advice}"
        findings.append(Finding("growth-stopped", Severity.ERROR, text))
    if growth.coverage is not None and growth.coverage < _COVERED:
        text = (
            f"{growth.coverage:.1%} of the surface lies under the sheet. trim = true begins with a "
            "longer seed; another zigzag, row_step or turn_deg may help."
        )
        findings.append(Finding("surface-not-covered", Severity.WARNING, text))
    return findings


def _overlap_findings(development: Development) -> list[Finding]:
    pairs = development.overlaps
    if not len(pairs):
        return []
    return [
        Finding(
            "development-overlaps",
            Severity.ERROR,
            f"the flat sheet overlaps itself: {len(pairs)} pairs of faces share area, the first "
            f"are {pairs[0][0]} and {pairs[0][1]}. It cannot be cut or printed as one sheet: "
            "`quadfold fabricate` cuts its FOLD file into pieces for a laser cutter; for panels, "
            "grow fewer columns or strips, or change the angles.",
            panels=tuple(sorted({int(face) for face in pairs[:10].ravel()})),
        )
    ]


def box_mm(coords: FloatArray) -> list[float]:
    """Sides of the box around points, rounded to 1e-6 mm."""
    return [round(float(side), 6) for side in coords.max(axis=0) - coords.min(axis=0)]


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _version() -> str:
    try:
        return version("quadfold")
    except PackageNotFoundError:
        return "not installed"


def file_names(name: str, formats: Iterable[str]) -> re.Pattern[str]:
    """What files of some formats are called, with plates or without."""
    return re.compile(rf"{re.escape(name)}(_plate_\d+|_bodies)?\.({'|'.join(formats)})")


def left_over(files: Iterable[str], kind: re.Pattern[str], folder: Path) -> list[Path]:
    """What a folder has of a kind that is not among `files`: that of an earlier run."""
    present = sorted(folder.iterdir()) if folder.is_dir() else []
    made = set(files)
    return [path for path in present if kind.fullmatch(path.name) and path.name not in made]


def require_folder(folder: Path) -> None:
    """Raise `InvalidJob` unless `folder` is a writable folder, or can become one."""
    try:
        existing = next(p for p in [folder, *folder.absolute().parents] if p.exists())
    except OSError as error:
        raise _unwritten(folder, error) from error
    if not existing.is_dir():
        raise InvalidJob(f"{folder}: {existing} is a file, not a folder. Choose another --out.")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InvalidJob(f"{folder}: no permission to write in {existing}. Choose another --out.")


def _unwritten(folder: Path, error: OSError) -> InvalidJob:
    cure = _CURES.get(error.errno or 0, "Choose another --out.")
    why = error.strerror or error
    return InvalidJob(f"{folder}: cannot be written: {why}. No half file was left. {cure}")


def write(made: Made, folder: Path) -> None:
    """Write all files of a job into `folder`, made if need be.

    Every file is written in full beside its place before any is renamed, so an interrupted run
    leaves no half file under a final name. Raises `InvalidJob` where the folder cannot take them.
    """
    require_folder(folder)
    fresh = [p for p in [folder, *folder.absolute().parents] if not p.exists()]
    beside: Path | None = None
    try:
        for name in made.files:
            if (folder / name).is_dir():
                raise InvalidJob(f"{folder / name} is a folder. Move it, or choose another --out.")
        folder.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(prefix=".quadfold-", dir=folder))
        for name, data in made.files.items():
            (beside / name).write_bytes(data)
        for name in made.files:
            (beside / name).replace(folder / name)
        fresh = []
    except OSError as error:
        raise _unwritten(folder, error) from error
    finally:
        if beside is not None:
            shutil.rmtree(beside, ignore_errors=True)
        for made_folder in fresh:
            if made_folder.is_dir() and not any(made_folder.iterdir()):
                made_folder.rmdir()
