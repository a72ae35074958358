"""Growth of a job's sheet, its unfolding to a crease pattern, and the findings of both."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import Any

from fab.errors import Finding, InvalidJob, Severity, counted, first_few
from fab.jobs.goals import design_goals, design_unit
from fab.jobs.job import Job, SheetSize
from fab.pattern.crease_pattern import CreasePattern, crease_pattern
from fab.pattern.development import develop
from fab.progress import Clock, Progress, silent
from solver import Growth, InvalidValue, QuadMesh, Status
from solver.designs.surface_fit import SURFACES
from solver.targets.base import Target
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import IntArray

__all__ = [
    "Grown",
    "grown",
    "grown_pattern",
    "growth_findings",
    "overlap_findings",
    "target_of",
    "unfolded",
]

# A sheet that covers less of its surface gets a finding.
_COVERED = 0.95
# So does one with a vertex farther off its offset, in steps.
_FAR_OFF = 0.15


def grown_pattern(
    job: Job, progress: Progress = silent
) -> tuple[CreasePattern, tuple[Finding, ...]]:
    """The crease pattern of a job, and the findings of its growth. Raises as `make`."""
    found = grown(job, Clock(progress))
    return found.pattern, (*found.findings, *growth_findings(found.growth))


@dataclass(frozen=True)
class Grown:
    """The growth of a job, what `unfolded` makes of its mesh, and findings of files it reads.

    target : the surface that it follows, in the units of the mesh.
    """

    growth: Growth
    mesh: QuadMesh
    pattern: CreasePattern
    overlaps: IntArray
    findings: tuple[Finding, ...]
    target: Target | SurfaceMesh | None


def grown(job: Job, clock: Clock) -> Grown:
    """Grow a job's sheet and unfold it."""
    with clock.stage("grow") as step, _named(job):
        design, findings = job.design.design(job.folder, design_goals(job), design_unit(job.sheet))
        growth = design.grow(step)
        if not isinstance(growth, Growth):
            raise InvalidJob(f"design: `grow` must return a Growth, not {type(growth).__name__}.")
    with clock.stage("develop"), _named(job):
        return Grown(growth, *unfolded(growth.mesh, job.sheet), findings, target_of(design))


def target_of(design: Any) -> Target | SurfaceMesh | None:
    """The surface that a design follows: the value of its field that is a target, if it has one."""
    for field in dataclasses.fields(design):
        if field.metadata.get("target"):
            value = getattr(design, field.name)
            found: Target | SurfaceMesh | None = (
                SURFACES.get(value) if isinstance(value, str) else value
            )
            return found
    return None


def unfolded(mesh: QuadMesh, size: SheetSize) -> tuple[QuadMesh, CreasePattern, IntArray]:
    """A folded mesh cut open, its crease pattern in mm, and the faces that overlap when flat.

    The overlaps are pairs of faces, shape (n, 2). Raises as `develop`.
    """
    opened = mesh.cut_open()  # rings and tubes are cut along a seam to be flat
    development = develop(opened)
    pattern = crease_pattern(opened, development, size.scale(development, opened.vertices_coords))
    return opened, pattern, development.overlaps


@contextmanager
def _named(job: Job) -> Iterator[None]:
    """Name the job's own key where the solver refuses a value, and the file of a user's design."""
    code = job.design.code
    if code is not None:
        from fab.jobs.own_designs import code_at
    try:
        with nullcontext() if code is None else code_at(code):
            yield
    except InvalidValue as error:
        key = job.design.key_of(error.name.partition("[")[0])
        place = f"design.{key}" if key else "design"
        raise InvalidJob(f"{place}: {error}") from error


def growth_findings(growth: Growth) -> list[Finding]:
    """Growth that stopped early, and surfaces that are not covered."""
    findings = []
    if growth.status is Status.NOT_FITTED:
        findings.append(Finding("surface-not-followed", Severity.ERROR, growth.advice))
    elif growth.status != Status.GROWN:
        strips = counted(growth.strips, "strip")
        text = f"growth stopped after {strips} ({growth.status}). {growth.advice}"
        findings.append(Finding("growth-stopped", Severity.ERROR, text))
    if growth.coverage is not None and growth.coverage < _COVERED:
        cure = (
            "trim = true begins with a longer seed; another zigzag, row_step or turn_deg may help."
            if growth.deviations is None
            else "More columns, or another zigzag, row_step or turn_deg may help."
        )
        text = f"{growth.coverage:.1%} of the surface is under the sheet. {cure}"
        findings.append(Finding("surface-not-covered", Severity.WARNING, text))
    return findings + _far_off(growth)


def _far_off(growth: Growth) -> list[Finding]:
    """That a sheet, though it can be made, is far off its surface: one that folds rigidly."""
    if growth.status is not Status.GROWN or growth.deviations is None:
        return []
    off = growth.chosen["off_steps"]
    if off <= _FAR_OFF:
        return []
    text = (
        f"vertices are up to {off:.3g} steps off their offsets of the surface; {_FAR_OFF:g} would "
        "be near. A sheet that folds rigidly can only follow gentle surfaces: fewer columns, a "
        "larger thickness or a flatter surface bring it nearer; so does rigid = false, for "
        "material that bends."
    )
    return [Finding("far-from-surface", Severity.WARNING, text)]


def overlap_findings(overlaps: IntArray, *, in_pieces: bool = False) -> list[Finding]:
    """Faces that share area when the sheet is flat.

    overlaps : pairs of them, shape (n, 2). in_pieces : whether all that is made of it is cut into
    pieces that do not overlap, so that it is no error.
    """
    if not len(overlaps):
        return []
    first, second = overlaps[0]
    which = f"is face {first} with itself" if first == second else f"are {first} and {second}"
    text = (
        f"the flat sheet overlaps itself: {counted(len(overlaps), 'pair')} of faces share area, "
        f"the first {which}. "
    )
    text += (
        "It is cut into pieces that do not."
        if in_pieces
        else "It cannot be cut or printed as one sheet: `quadfold fabricate` cuts its FOLD file "
        "into pieces for a laser cutter; for panels, grow fewer columns or strips, or change the "
        "angles."
    )
    return [
        Finding(
            "development-overlaps",
            Severity.NOTE if in_pieces else Severity.ERROR,
            text,
            panels=first_few(sorted({int(face) for face in overlaps[:10].ravel()})),
        )
    ]
