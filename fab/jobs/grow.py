"""From a job to its crease pattern: growth, development, and what is reported of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager

from fab.errors import Finding, InvalidJob, Severity
from fab.jobs.job import Job, design_key
from fab.pattern.crease_pattern import CreasePattern, crease_pattern
from fab.pattern.development import Development, develop
from fab.progress import Clock, Progress, silent
from solver import DESIGNS, Growth, InvalidValue, Status

__all__ = ["grown_pattern"]


# A sheet that covers less of its surface is told of.
_COVERED = 0.95


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
