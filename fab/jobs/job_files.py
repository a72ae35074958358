"""Files of a job, or of any folded quad mesh.

The flow, and the only place where its branches join:

    design -> mesh -> development -> crease pattern -+-> sheets, or perforation alone -> DXF, SVG
                                                     +-> FOLD, PNG
                                                     +-> thick sheet -> STEP, STL, 3MF, PNG
                                                     +-> scene -> GLB, result page of it all
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fab import __version__
from fab.jobs.file_names import JOB
from fab.jobs.folded_sheet import FoldedSheet
from fab.jobs.grow import grown, unfolded
from fab.jobs.job import Job, SheetSettings
from fab.jobs.job_drawings import drawings_part, makes_sheets
from fab.jobs.job_formats import OF_SCENES, SOLID, Format
from fab.jobs.job_parts import (
    Part,
    goals_part,
    growth_part,
    measures_part,
    rigidity_part,
    seams_part,
    simulation_part,
)
from fab.jobs.job_products import fold_part, picture_part, scene_files, solids_part
from fab.outputs import Made, formats_among, with_report, write
from fab.progress import Clock, Progress, silent
from fab.settings import checked
from solver import QuadMesh
from solver.vectors import FloatArray

if TYPE_CHECKING:
    from fab.folding.quasi_static import Checkpoint

__all__ = ["Format", "Sheet", "from_mesh", "grown_sheet", "make"]


@dataclass(frozen=True)
class Sheet(FoldedSheet):
    """A folded sheet, its crease pattern, and how it is made."""

    def make(
        self,
        formats: Iterable[str] | None = None,
        progress: Progress = silent,
        *,
        rigidity: bool = True,
    ) -> Made:
        """The sheet in each of `formats` as bytes, with the report of `make`.

        formats : such as ["dxf", "fold"]; the `outputs` of the settings where none are given.
        rigidity : as in `make`.
        """
        return _made(self, formats, Clock(progress), rigidity=rigidity)

    def write(
        self,
        folder: str | Path,
        formats: Iterable[str] | None = None,
        progress: Progress = silent,
    ) -> Made:
        """Make the sheet's files and write them into `folder`, which is made where it is missing.

        What was made is returned: its report and findings say whether it may be used. Raises
        `InvalidJob` where the folder cannot take the files.
        """
        made = self.make(formats, progress)
        write(made, folder)
        return made


def make(
    job: Job,
    formats: Iterable[str] | None = None,
    progress: Progress = silent,
    *,
    rigidity: bool = True,
    checkpoint: Checkpoint | None = None,
) -> Made:
    """Run a job in memory: grow, develop, and write each of `formats` as bytes.

    formats : those of the job where none are given.

    progress : called with (stage, steps done, steps in the stage).

    rigidity : whether sheets of up to 2,000 faces are looked at for rigid folding, which takes a
    tenth of a second.

    checkpoint : what keeps its simulation where that is cut short.

    Raises `InvalidJob` where the design's parameters leave nothing to grow, or a sheet without
    area. Growth that stops early, overlaps and the like are findings in the report.
    """
    clock = Clock(progress)
    return _made(_grown_sheet(job, clock), formats, clock, rigidity=rigidity, checkpoint=checkpoint)


def grown_sheet(job: Job, progress: Progress = silent) -> Sheet:
    """The sheet of a job, of which nothing is made yet. Raises as `make`."""
    return _grown_sheet(job, Clock(progress))


def _grown_sheet(job: Job, clock: Clock) -> Sheet:
    found = grown(job, clock)
    return Sheet(
        found.mesh,
        found.pattern,
        job,
        found.overlaps,
        found.growth,
        found.findings,
        found.target,
    )


def from_mesh(
    mesh: QuadMesh | FloatArray | Sequence[FloatArray],
    *,
    width_mm: float | None = None,
    scale_mm_per_unit: float | None = None,
    folded_width_mm: float | None = None,
    folded_height_mm: float | None = None,
    name: str = "sheet",
    closed: bool = False,
    settings: Mapping[str, Any] | None = None,
    folder: str | Path = Path(),
) -> Sheet:
    """The sheet of a folded quad mesh: unfolded, its creases measured, ready to be made.

    mesh : a `QuadMesh`, or the rows of its vertices, shape (rows, columns, 3).

    width_mm, scale_mm_per_unit, folded_width_mm, folded_height_mm : the longer side of the flat
    sheet, the size of a unit, the longest side of the folded sheet, or its extent along z; one of
    them.

    closed : whether rows are loops, whose first vertex is not repeated.

    settings : the tables and keys of a job besides `name`, `design` and `sheet`, such as
    {"panels": {"thickness_mm": 1.2}}; folder : where files that they name are looked for.

    Raises `InvalidJob` for settings at fault, `InvalidValue` for a mesh without area or in several
    pieces. A mesh that cannot be folded from a flat sheet gets findings in the report of what is
    made.

    >>> rows = [[[x, y, (x % 2) / 2] for x in range(5)] for y in range(3)]  # pleats
    >>> sheet = from_mesh(rows, width_mm=100.0)
    >>> sheet.pattern.counts()
    {'M': 4, 'V': 2, 'F': 4, 'B': 12}
    >>> sorted(sheet.make(["fold"]).files)
    ['sheet.fold', 'sheet_report.json']
    """
    size = {
        "width_mm": width_mm,
        "scale_mm_per_unit": scale_mm_per_unit,
        "folded_width_mm": folded_width_mm,
        "folded_height_mm": folded_height_mm,
    }
    document = {**(settings or {}), "name": name, "sheet": size}
    tables = checked(SheetSettings, document, "settings", "Give it as in a job.")
    tables._folder = Path(folder)
    whole = mesh if isinstance(mesh, QuadMesh) else QuadMesh.from_rows(mesh, closed=closed)
    opened, pattern, overlaps = unfolded(whole, tables.sheet)
    return Sheet(opened, pattern, tables, overlaps)


def _made(
    sheet: FoldedSheet,
    formats: Iterable[str] | None,
    clock: Clock,
    *,
    rigidity: bool = True,
    checkpoint: Checkpoint | None = None,
) -> Made:
    names = sheet.settings.wanted if formats is None else formats
    wanted = set(formats_among(names, Format, "format"))
    in_pieces = makes_sheets(sheet, wanted) and not wanted & SOLID
    parts = [
        growth_part(sheet, in_pieces=in_pieces),
        measures_part(sheet, clock),
        goals_part(sheet),
        seams_part(sheet),
        fold_part(sheet, wanted, clock),
        drawings_part(sheet, wanted, clock),
        solids_part(sheet, wanted, clock),
        simulation_part(sheet, wanted, clock, checkpoint),
        # a simulation has found it already
        rigidity_part(sheet, clock) if rigidity and sheet.settings.simulation is None else Part(),
        picture_part(sheet, wanted, clock),
    ]
    report: dict[str, Any] = {
        "quadfold": __version__,
        "job": sheet.settings.model_dump(mode="json"),
        "rigid": None,
    }
    files: dict[str, bytes] = {}
    for part in parts:
        report |= part.report
        files |= part.files
    findings = [finding for part in parts for finding in part.findings]
    if wanted & OF_SCENES:
        files |= scene_files(sheet, wanted, parts, files, findings, report, clock)
    report["seconds"] = clock.seconds
    return with_report(files, JOB.report_name(sheet.settings.name), report, findings)
