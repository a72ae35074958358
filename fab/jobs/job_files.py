"""How does a job become files?

The flow, and the only place where its branches join:

    design -> mesh -> development -> crease pattern -+-> perforation -> DXF, SVG
                                                     +-> FOLD, PNG
                                                     +-> thick sheet -> STEP, STL, 3MF, PNG
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from fab.errors import Finding
from fab.formats.fold_writer import fold_bytes
from fab.jobs.grow import _grown, _growth_findings, _overlap_findings
from fab.jobs.job import Job
from fab.outputs import Made, box_mm, with_report
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_accuracy, inspect_crossings, measure_pattern
from fab.pattern.self_intersection import crossing_faces
from fab.progress import Clock, Progress, silent
from fab.sheets.perforation import perforate

__all__ = ["Format", "make"]


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
        from fab.folding.simulation import fold_and_judge

        _, verdict, told = fold_and_judge(pattern, job.simulation, progress=clock.progress)
        findings += told
        simulation = verdict.report()
    if Format.PNG in wanted:
        from fab.pattern.picture import png_bytes

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


def _flat_files(
    job: Job,
    pattern: CreasePattern,
    wanted: set[Format],
    files: dict[str, bytes],
    clock: Clock,
) -> list[Finding]:
    if not wanted & {Format.DXF, Format.SVG}:
        return []
    from fab.drawings.drawing_files import SheetFormat, drawing_files

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
    from fab.printing.print_files import ThickFormat, thick_files

    formats = {kind for kind in ThickFormat if kind.value in set(wanted)}
    print_with = job.print_with(job.folder)
    made = thick_files(pattern, job.name, job.printed(print_with), formats, clock, print_with)
    findings += made.findings
    if made.figures is None or made.print_mm is None:
        return None
    boxes["print"] = made.print_mm
    for end, data in made.data.items():
        files[job.name + ("_thick.png" if end == ".png" else end)] = data
    return {**made.figures, "plates": made.plates}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _version() -> str:
    try:
        return version("quadfold")
    except PackageNotFoundError:
        return "not installed"
