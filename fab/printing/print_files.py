"""Which files does a thick sheet become, for printers and CAD programs, and what is told of them?

crease pattern -> panels, hinges -> joined body -> checks -> STEP, STL, 3MF, PNG
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from fab.clearance.thick_inspection import SolidFigures, inspect_thick
from fab.errors import Finding, InvalidJob, Severity
from fab.folding.folded_states import folded_states, with_free_angles
from fab.geometry.bodies import TriangleMesh, bodies_of
from fab.outputs import Made, box_mm, with_report
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import CreasePattern
from fab.printing.plates import Plates, make_plates
from fab.printing.stl import body_stls, inspect_stl, stl_bytes
from fab.printing.thick_settings import UNKNOWN, PrintWith, ThickSettings
from fab.printing.threemf import PrintObject, body_parts, sheet_parts, threemf_bytes
from fab.progress import Clock, Progress, silent

__all__ = ["ORDINARY", "ThickFiles", "ThickFormat", "make_thick", "thick_files"]


class ThickFormat(StrEnum):
    """The kinds of files of a thick sheet, named by their endings; zip has an STL of each body."""

    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"
    ZIP = "zip"


# What is made where nobody says what: a zip of all bodies is for other programs.
ORDINARY = (ThickFormat.STEP, ThickFormat.STL, ThickFormat.THREEMF, ThickFormat.PNG)


@dataclass(frozen=True)
class ThickFiles:
    """What a thick sheet became.

    Attributes
    ----------
    data : bytes of each file, by what follows the name: ".step", "_plate_1.stl"; empty where there
        is no panel.
    plates : which part is printed on which plate, and how they are joined (`fab.plates`); None
        where the sheet is printed in one.
    figures : what the check of the bodies measured; None where there is no panel.
    print_mm : sides of the joined body's box, flat; None where there is none.
    findings : of panels, hinges and checks.
    """

    data: Mapping[str, bytes]
    plates: dict[str, Any] | None
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

    name : what files and pictures call it; settings : `printed` with `print_with`.

    Raises `InvalidJob` for sheets so large that single precision does not tell their bottom from
    their top.
    """
    from fab.geometry.booleans import joined_mesh, resolution_mm
    from fab.panels.step import step_bytes

    printer = print_with.printer
    with clock.stage("states"):
        states, findings = folded_states(pattern, progress=clock.progress)
    with clock.stage("panels"):
        free = with_free_angles(pattern, states)
        sheet, found = thicken(free, settings.panels, settings.hinges)
    findings += found
    if not len(sheet.bodies):
        return ThickFiles({}, None, None, None, tuple(findings))
    thickness, nearest = settings.panels.thickness_mm, resolution_mm(sheet.bodies)
    if thickness <= nearest:
        width = float(np.ptp(pattern.vertices_coords, axis=0).max())
        raise InvalidJob(
            f"a flat sheet of {width:.4g} mm with panels.thickness_mm = {thickness:g}: STL and 3MF "
            f"tell nothing apart that is nearer than {nearest:.4g} mm there, and the thickness "
            "must be more. Make the sheet smaller, or raise the thickness"
        )
    with clock.stage("join"):
        joined = joined_mesh(sheet.joining)
    with clock.stage("inspect"):
        figures, found = inspect_thick(
            sheet,
            joined,
            states,
            limit_deg=settings.panels.fold_limit_deg,
            printer=printer,
            material=print_with.material,
            progress=clock.progress,
        )
        # what has no hinges is loose by intent
        apart = set(settings.hinges.kinds) == {"none"}
        told = [finding for finding in found if not (apart and finding.code == "panels-loose")]
        findings += told
    plates: Plates | None = None
    if printer is not None and _divisible(settings, findings):
        with clock.stage("plates") as step:
            plates, found = make_plates(sheet, printer.bed_mm, settings.plates, step)
        findings = [f for f in findings if f.code != "print-too-large"]
        findings += [_divided(plates), *found]
    data: dict[str, bytes] = {}
    if ThickFormat.STEP in formats:
        with clock.stage("step"):
            data[".step"] = step_bytes(sheet if plates is None else plates.sheet, name)
    if ThickFormat.STL in formats:
        with clock.stage("stl"):
            surfaces = {".stl": joined} if plates is None else _plate_surfaces(plates)
            data |= {end: stl_bytes(surface) for end, surface in surfaces.items()}
            for surface in surfaces.values():
                findings += inspect_stl(surface)
    if ThickFormat.THREEMF in formats:
        with clock.stage("3mf"):
            whole = {".3mf": [PrintObject(name, tuple(sheet_parts(sheet)))]}
            prints = whole if plates is None else _plate_objects(plates)
            data |= {end: threemf_bytes(objects, name) for end, objects in prints.items()}
    if ThickFormat.ZIP in formats:
        with clock.stage("zip"):
            data["_bodies.zip"] = body_stls(sheet if plates is None else plates.sheet)
    if ThickFormat.PNG in formats:
        from fab.printing.thick_picture import thick_png_bytes

        with clock.stage("thick png"):
            reached = states[len(figures.states) - 1]  # as far as the panels are made for
            folded = reached if len(figures.states) > 1 else None
            data[".png"] = thick_png_bytes(sheet, name, folded)
    guide = None if plates is None else plates.guide()
    return ThickFiles(data, guide, figures, box_mm(joined.vertices_coords), tuple(findings))


def _divisible(settings: ThickSettings, findings: Sequence[Finding]) -> bool:
    """Whether a sheet is too large for its bed, and has hinges that parts can be joined by."""
    large = any(finding.code == "print-too-large" for finding in findings)
    return large and set(settings.hinges.kinds) <= {"web", "none"}


def _divided(plates: Plates) -> Finding:
    kinds = Counter(joint.kind for joint in plates.joints)
    joints = ", ".join(f"{count} by {kind}" for kind, count in sorted(kinds.items()))
    text = (
        f"larger than the bed: printed in {len(plates.parts)} parts on {plates.count} plates, "
        f"joined at {len(plates.joints)} creases ({joints or 'none'}). plates in the report says "
        "which goes where."
    )
    return Finding("sheet-divided", Severity.NOTE, text)


def _plate_surfaces(plates: Plates) -> dict[str, TriangleMesh]:
    """All parts of each plate as one surface."""
    out = {}
    for plate in range(plates.count):
        parts = [part.mesh for part in plates.parts if part.plate == plate]
        every = bodies_of(parts)
        out[f"_plate_{plate + 1}.stl"] = TriangleMesh(
            every.vertices_coords, every.triangles, every.triangles_plane
        )
    return out


def _plate_objects(plates: Plates) -> dict[str, list[PrintObject]]:
    """All parts of each plate, each an object of its own."""
    sheet = plates.sheet
    out: dict[str, list[PrintObject]] = {}
    for part in sorted(plates.parts, key=lambda part: part.plate):
        flexible, creases = sheet.flexible[part.numbers], sheet.creases[part.numbers]
        parts = tuple(body_parts(plates.bodies(part), flexible, creases))
        out.setdefault(f"_plate_{part.plate + 1}.3mf", []).append(PrintObject(part.name, parts))
    return out


def make_thick(
    pattern: CreasePattern,
    name: str,
    settings: ThickSettings,
    *,
    print_with: PrintWith = UNKNOWN,
    formats: Sequence[ThickFormat] = ORDINARY,
    findings: Sequence[Finding] = (),
    progress: Progress = silent,
) -> Made:
    """Files of any crease pattern as a thick sheet: NAME_thick.step, .stl, .3mf, .png and a report.

    A sheet of web hinges that is larger than its printer's bed gets an .stl and a .3mf for each
    plate, NAME_thick_plate_1.stl and so on.

    pattern : in millimetres; findings : of its reader, told again in the report, which is the file
    `name`_thick_report.json. progress : called with (stage, steps done, steps in the stage).
    """
    clock = Clock(progress)
    settings = settings.printed(print_with)
    made = thick_files(pattern, name, settings, formats, clock, print_with)
    told = (*findings, *made.findings)
    printer, material = print_with.printer, print_with.material
    files = {f"{name}_thick{end}": data for end, data in made.data.items()}
    report: dict[str, Any] = {
        "name": name,
        "settings": settings.model_dump(mode="json"),
        "printer": None if printer is None else printer.model_dump(mode="json"),
        "material": None if material is None else material.model_dump(mode="json"),
        "counts": {"faces": pattern.face_count, "creases": pattern.counts()},
        "bounding_box_mm": {"flat": box_mm(pattern.vertices_coords), "print": made.print_mm},
        "solids": None if made.figures is None else dataclasses.asdict(made.figures),
        "plates": made.plates,
        "seconds": clock.seconds,
    }
    return with_report(files, f"{name}_thick_report.json", report, told)
