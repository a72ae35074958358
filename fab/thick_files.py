"""Which files does a thick sheet become, for printers and CAD programs, and what is told of them?

crease pattern -> panels, hinges -> joined body -> checks -> STEP, STL, 3MF, PNG
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from fab.clearance import SolidFigures, inspect_thick
from fab.clock import Clock, Progress, silent
from fab.crease import CreasePattern
from fab.errors import Finding
from fab.make import Made, box_mm, with_report
from fab.states import folded_states
from fab.thick import thicken
from fab.thick_settings import UNKNOWN, PrintWith, ThickSettings

__all__ = ["ThickFiles", "ThickFormat", "make_thick", "thick_files"]


class ThickFormat(StrEnum):
    """The kinds of files of a thick sheet, named by their endings."""

    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"


@dataclass(frozen=True)
class ThickFiles:
    """What a thick sheet became.

    Attributes
    ----------
    data : bytes of each format; empty where there is no panel.
    figures : what the check of the bodies measured; None where there is no panel.
    print_mm : sides of the joined body's box, flat; None where there is none.
    findings : of panels, hinges and checks.
    """

    data: Mapping[ThickFormat, bytes]
    figures: SolidFigures | None
    print_mm: list[float] | None
    findings: tuple[Finding, ...]


def thick_files(
    pattern: CreasePattern,
    name: str,
    settings: ThickSettings,
    formats: Collection[ThickFormat],
    clock: Clock,
    print_with: PrintWith,
) -> ThickFiles:
    """The thick sheet of a crease pattern in each of `formats`, checked.

    name : what files and pictures call it.
    """
    from fab.joining import joined_mesh
    from fab.step import step_bytes
    from fab.stl import inspect_stl, stl_bytes
    from fab.threemf import sheet_parts, threemf_bytes

    with clock.stage("panels"):
        sheet, found = thicken(pattern, settings.panels, settings.hinges)
    findings = list(found)
    if not len(sheet.bodies):
        return ThickFiles({}, None, None, tuple(findings))
    with clock.stage("join"):
        joined = joined_mesh(sheet.joining)
    with clock.stage("inspect"):
        states, unknown = folded_states(pattern, progress=clock.progress)
        figures, found = inspect_thick(
            sheet,
            joined,
            states,
            limit_deg=settings.panels.fold_limit_deg,
            printer=print_with.printer,
            material=print_with.material,
            progress=clock.progress,
        )
        # what has no hinges is loose by intent
        apart = set(settings.hinges.kinds) == {"none"}
        told = [finding for finding in found if not (apart and finding.code == "panels-loose")]
        findings += [*unknown, *told]
    data: dict[ThickFormat, bytes] = {}
    if ThickFormat.STEP in formats:
        with clock.stage("step"):
            data[ThickFormat.STEP] = step_bytes(sheet, name)
    if ThickFormat.STL in formats:
        with clock.stage("stl"):
            data[ThickFormat.STL] = stl_bytes(joined)
            findings += inspect_stl(joined)
    if ThickFormat.THREEMF in formats:
        with clock.stage("3mf"):
            data[ThickFormat.THREEMF] = threemf_bytes(sheet_parts(sheet), name)
    if ThickFormat.PNG in formats:
        from fab.thick_picture import thick_png_bytes

        with clock.stage("thick png"):
            reached = states[len(figures.states) - 1]  # as far as the panels are made for
            folded = reached if len(figures.states) > 1 else None
            data[ThickFormat.PNG] = thick_png_bytes(sheet, name, folded)
    return ThickFiles(data, figures, box_mm(joined.vertices_coords), tuple(findings))


def make_thick(
    pattern: CreasePattern,
    name: str,
    settings: ThickSettings,
    *,
    print_with: PrintWith = UNKNOWN,
    formats: Sequence[ThickFormat] = tuple(ThickFormat),
    findings: Sequence[Finding] = (),
    progress: Progress = silent,
) -> Made:
    """Files of any crease pattern as a thick sheet: NAME_thick.step, .stl, .3mf, .png and a report.

    pattern : in millimetres; findings : of its reader, told again in the report, which is the file
    `name`_thick_report.json. progress : called with (stage, steps done, steps in the stage).
    """
    clock = Clock(progress)
    made = thick_files(pattern, name, settings, formats, clock, print_with)
    told = (*findings, *made.findings)
    printer, material = print_with.printer, print_with.material
    files = {f"{name}_thick.{kind}": data for kind, data in made.data.items()}
    report: dict[str, Any] = {
        "name": name,
        "settings": settings.model_dump(mode="json"),
        "printer": None if printer is None else printer.model_dump(mode="json"),
        "material": None if material is None else material.model_dump(mode="json"),
        "counts": {"faces": pattern.face_count, "creases": pattern.counts()},
        "bounding_box_mm": {"flat": box_mm(pattern.vertices_coords), "print": made.print_mm},
        "solids": None if made.figures is None else dataclasses.asdict(made.figures),
        "seconds": clock.seconds,
    }
    return with_report(files, f"{name}_thick_report.json", report, told)
