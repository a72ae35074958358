"""Files of a thick sheet for printers and CAD programs, and the report that goes with them.

crease pattern -> pieces apart -> panels, hinges -> joined body -> checks -> plates -> STEP, STL,
3MF, PNG, GLB -> result page
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from fab.clearance.thick_inspection import inspect_thick
from fab.errors import Finding, InvalidJob, Severity, counted, first_few
from fab.folding.folded_states import FoldedState, folded_states, with_free_angles
from fab.folding.last_states import with_state_at_limit
from fab.geometry.bodies import TriangleMesh, bodies_of
from fab.jobs.file_names import THICK
from fab.layout.piece_gaps import set_apart
from fab.outputs import Made, box_mm, with_report
from fab.panels.fold_limit import panels_within_reach
from fab.panels.thick_sheet import ThickSheet, thicken
from fab.pattern.crease_pattern import CreasePattern
from fab.printing.bed_place import UNMOVED, place_on_bed
from fab.printing.pauses import Pause, film_pause, inspect_pause
from fab.printing.plates import Plates, make_plates
from fab.printing.print_objects import PrintObject, body_parts, sheet_parts
from fab.printing.printability import inspect_print, inspect_webs, print_figures
from fab.printing.printers import Printer
from fab.printing.stl import body_stls, inspect_stl, stl_bytes
from fab.printing.thick_settings import UNKNOWN, PrintWith, ThickSettings
from fab.printing.threemf import threemf_bytes
from fab.progress import Clock, Progress, silent

if TYPE_CHECKING:
    from fab.viewing.leaflet import Leaflet
    from fab.viewing.scene import Scene

__all__ = ["ORDINARY", "ThickFiles", "ThickFormat", "make_thick", "thick_files"]


class ThickFormat(StrEnum):
    """The kinds of files of a thick sheet, named by their endings; zip has an STL of each body."""

    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"
    ZIP = "zip"
    GLB = "glb"
    HTML = "html"
    ASSEMBLY = "assembly"


# What is made by default: zips of all bodies and GLB are for other programs.
ORDINARY = (
    ThickFormat.STEP,
    ThickFormat.STL,
    ThickFormat.THREEMF,
    ThickFormat.PNG,
    ThickFormat.HTML,
    ThickFormat.ASSEMBLY,
)


@dataclass(frozen=True)
class ThickFiles:
    """What a thick sheet became.

    Attributes
    ----------
    data : bytes of each file, by what follows the name: ".step", "_plate_1.stl"; empty where there
        is no panel. A result page is not among them: it shows the whole report.
    plates : which part is printed on which plate, and how they are joined
        (`fab.printing.plates`); None where the sheet is printed in one.
    figures : what was measured of bodies, print and clearance, by the keys of a report; None where
        there is no panel.
    print_mm : sides of the joined body's box, flat; None where there is none.
    findings : of panels, hinges and checks.
    scene : the sheet and its bodies in all folded states, for models and result pages; None where
        there is no panel, or neither is asked for.
    panels_state : number of the state up to which the panels fold.
    guide : how the panels are printed, joined and folded, where that was asked for.
    """

    data: Mapping[str, bytes]
    plates: dict[str, Any] | None
    figures: dict[str, Any] | None
    print_mm: list[float] | None
    findings: tuple[Finding, ...]
    scene: Scene | None = None
    panels_state: int = 0
    guide: Leaflet | None = None


@dataclass(frozen=True)
class _Checked:
    """A thick sheet that was checked.

    Attributes
    ----------
    joined : the surface of all its bodies. figures : as in `ThickFiles`.
    states : the folded states that it was checked in, the flat one first, and those beyond in
        which panels would overlap.
    checked : number of those that it was checked in.
    """

    sheet: ThickSheet
    joined: TriangleMesh
    figures: dict[str, Any]
    states: tuple[FoldedState, ...]
    checked: int


def thick_files(
    pattern: CreasePattern,
    name: str,
    settings: ThickSettings,
    formats: Collection[ThickFormat],
    clock: Clock,
    print_with: PrintWith,
    *,
    upright: bool = False,
    made_by: str = "quadfold thicken",
    guided: bool = False,
) -> ThickFiles:
    """The thick sheet of a crease pattern in each of `formats`, checked.

    name : what files and pictures call it; settings : `printed` with `print_with`. upright :
    whether z is up in the folded form of the pattern, and in pictures. made_by : the command.
    guided : whether a guide is made though no file of it is asked for.

    Raises `InvalidJob` for sheets so large that single precision does not resolve the thickness of
    their panels.
    """
    findings: list[Finding] = []
    if print_with.printer is not None:
        pattern, findings = _set_apart(pattern, print_with.printer)
    with clock.stage("states"):
        states, found = folded_states(pattern, progress=clock.progress)
    findings += found
    with clock.stage("panels"):
        free = with_free_angles(pattern, states)
        nozzle = 0.0 if print_with.printer is None else print_with.printer.nozzle_mm
        panels, found = panels_within_reach(free, settings.panels, settings.hinges, nozzle)
        limited = bool(found)
        findings += found
        sheet, found = thicken(free, panels, settings.hinges, nozzle)
        states = with_state_at_limit(free, sheet.panels.faces, states, panels.fold_limit_deg)
    findings += found
    if not len(sheet.bodies):
        return ThickFiles({}, None, None, None, tuple(findings))
    checked, found = _checked(sheet, states, settings, print_with, clock, limit_given=not limited)
    findings += found
    plates: Plates | None = None
    if print_with.printer is not None and _divisible(settings, findings):
        with clock.stage("plates") as step:
            if settings.hinges.anchor_mm > 0:  # joints have the place of dovetails
                butted = settings.hinges.model_copy(update={"anchor_mm": 0.0})
                sheet, _ = thicken(free, panels, butted, nozzle)
                findings.append(_butted())
            plates, found = make_plates(sheet, print_with.printer.bed_mm, settings.plates, step)
        findings = [finding for finding in findings if finding.code != "print-too-large"]
        findings += [_divided(plates), *found]
    data, found = _files(checked, plates, name, formats, clock, print_with, upright=upright)
    findings += found
    scene: Scene | None = None
    guide: Leaflet | None = None
    guided |= ThickFormat.ASSEMBLY in formats
    if guided or {ThickFormat.GLB, ThickFormat.HTML} & set(formats):
        from fab.viewing.scene_builders import thick_scene

        scene = thick_scene(sheet, checked.states, name, findings=findings, upright=upright)
    if scene is not None and guided:
        from fab.jobs.panel_guides import panel_guide_of

        with clock.stage("assembly"):
            guide = panel_guide_of(
                sheet,
                plates,
                scene,
                checked.checked - 1,
                name,
                print_with,
                checked.figures,
                made_by=made_by,
                findings=findings,
            )
            if ThickFormat.ASSEMBLY in formats:
                from fab.viewing.leaflet_pdf import leaflet_pdf_bytes

                data["_assembly.pdf"] = leaflet_pdf_bytes(guide)
    return ThickFiles(
        data,
        None if plates is None else plates.guide(),
        checked.figures,
        box_mm(checked.joined.vertices_coords),
        tuple(findings),
        scene,
        checked.checked - 1,
        guide,
    )


def _set_apart(pattern: CreasePattern, printer: Printer) -> tuple[CreasePattern, list[Finding]]:
    """The pattern with its pieces as far apart as a printer keeps them, and what has moved."""
    pattern, faces, shifts = set_apart(pattern, printer.least_gap_mm)
    if not len(faces):
        return pattern, []
    far = np.hypot(*shifts.T)
    text = (
        f"{counted(len(faces), 'piece')} moved by up to {far.max():.4g} mm: pieces that are nearer "
        f"than the printer's least_gap_mm = {printer.least_gap_mm:g} fuse in the print. The first "
        f"is that of face {faces[0]}, by ({shifts[0, 0]:.4g}, {shifts[0, 1]:.4g}) mm."
    )
    return pattern, [Finding("pieces-moved", Severity.NOTE, text, panels=first_few(faces))]


def _checked(
    sheet: ThickSheet,
    states: Sequence[FoldedState],
    settings: ThickSettings,
    print_with: PrintWith,
    clock: Clock,
    *,
    limit_given: bool,
) -> tuple[_Checked, list[Finding]]:
    """The sheet with its joined surface, checked for clearance and for its printer."""
    from fab.geometry.booleans import joined_mesh

    _require_resolved(sheet)
    limit_deg = sheet.panel.fold_limit_deg
    printer = print_with.printer
    pause: Pause | None = None
    with clock.stage("join"):
        joined = joined_mesh(sheet.joining)
    with clock.stage("inspect"):
        measured, findings = inspect_thick(
            sheet,
            joined,
            states,
            limit_deg=limit_deg,
            limit_given=limit_given,
            least_gap_mm=None if printer is None else printer.least_gap_mm,
            progress=clock.progress,
        )
        if set(settings.hinges.kinds) == {"none"}:  # loose by intent
            findings = [finding for finding in findings if finding.code != "panels-loose"]
        if printer is not None:
            findings += inspect_print(sheet, joined, printer, print_with.material_count)
            pause = film_pause(sheet, printer.layer_mm)
            findings += [] if pause is None else inspect_pause(sheet, pause)
        if print_with.hinges is not None:
            findings += inspect_webs(sheet, print_with.hinges, limit_deg)
        prints = print_figures(measured.solids, joined, print_with.panels, print_with.hinges)
    figures: dict[str, Any] = {
        "fold_limit_deg": limit_deg,
        **dataclasses.asdict(measured.solids),
        **dataclasses.asdict(prints),
        **dataclasses.asdict(measured.clearance),
        "pause": None if pause is None else dataclasses.asdict(pause),
    }
    reached = len(measured.clearance.states)  # as far as the panels are made for
    return _Checked(sheet, joined, figures, tuple(states), max(1, reached)), findings


def _require_resolved(sheet: ThickSheet) -> None:
    """Raise `InvalidJob` where files in single precision do not resolve the panels' thickness."""
    from fab.geometry.booleans import resolution_mm

    thickness, nearest = sheet.panel.thickness_mm, resolution_mm(sheet.bodies)
    if thickness <= nearest:
        width = float(np.ptp(sheet.pattern.vertices_coords, axis=0).max())
        raise InvalidJob(
            f"a flat sheet of {width:.4g} mm with panels.thickness_mm = {thickness:g}: STL and 3MF "
            f"files do not resolve distances up to {nearest:.4g} mm there, and the thickness must "
            "be larger. Make the sheet smaller, or raise the thickness"
        )


def _files(
    checked: _Checked,
    plates: Plates | None,
    name: str,
    formats: Collection[ThickFormat],
    clock: Clock,
    print_with: PrintWith,
    *,
    upright: bool,
) -> tuple[dict[str, bytes], list[Finding]]:
    """The files of a sheet, in one or on plates, by what follows the name; findings about them."""
    from fab.panels.step import step_bytes

    sheet = checked.sheet if plates is None else plates.sheet
    surfaces: dict[str, TriangleMesh] = {}
    if ThickFormat.STL in formats:
        surfaces = {".stl": checked.joined} if plates is None else _plate_surfaces(plates)

    def objects() -> dict[str, bytes]:
        if plates is None:
            prints = {".3mf": [_whole_object(checked.sheet, name, print_with)]}
        else:
            prints = _plate_objects(plates, print_with)
        slicer, printer = print_with.slicer, print_with.printer
        pause = None if printer is None else film_pause(checked.sheet, printer.layer_mm)
        pauses = () if pause is None else (pause.next_mm,)
        return {end: threemf_bytes(each, name, slicer, pauses) for end, each in prints.items()}

    def picture() -> dict[str, bytes]:
        from fab.viewing.scene_builders import thick_scene
        from fab.viewing.thick_picture import thick_png_bytes

        states = checked.states[: checked.checked]
        scene = thick_scene(sheet, states, name, upright=upright)
        return {".png": thick_png_bytes(scene, plates)}

    def model() -> dict[str, bytes]:
        from fab.viewing.glb import bodies_glb_bytes
        from fab.viewing.scene_builders import thick_scene

        states = checked.states[: checked.checked]
        return {".glb": bodies_glb_bytes(thick_scene(checked.sheet, states, name, upright=upright))}

    writers: dict[ThickFormat, tuple[str, Callable[[], dict[str, bytes]]]] = {
        ThickFormat.STEP: ("step", lambda: {".step": step_bytes(sheet, name)}),
        ThickFormat.STL: (
            "stl",
            lambda: {end: stl_bytes(surface) for end, surface in surfaces.items()},
        ),
        ThickFormat.THREEMF: ("3mf", objects),
        ThickFormat.ZIP: ("zip", lambda: {"_bodies.zip": body_stls(sheet)}),
        ThickFormat.PNG: ("thick png", picture),
        ThickFormat.GLB: ("thick glb", model),
    }
    data: dict[str, bytes] = {}
    for kind, (stage, write) in writers.items():
        if kind in formats:
            with clock.stage(stage):
                data |= write()
    return data, [finding for surface in surfaces.values() for finding in inspect_stl(surface)]


def _divisible(settings: ThickSettings, findings: Sequence[Finding]) -> bool:
    """Whether a sheet is too large for its bed; around an embedded film no parts are joined."""
    large = any(finding.code == "print-too-large" for finding in findings)
    return large and not settings.hinges.embedded


def _butted() -> Finding:
    text = (
        "webs of a sheet that is printed in parts have no dovetails in their panels: panels and "
        "hinges hold by adhesion alone. Print both of one material."
    )
    return Finding("web-not-anchored", Severity.WARNING, text)


def _divided(plates: Plates) -> Finding:
    kinds = Counter(joint.kind for joint in plates.joints)
    joints = ", ".join(f"{count} by {kind}" for kind, count in sorted(kinds.items()))
    text = (
        f"larger than the bed: printed in {counted(len(plates.parts), 'part')} on "
        f"{counted(plates.count, 'plate')}, joined at {counted(len(plates.joints), 'crease')} "
        f"({joints or 'none'}). The key plates of the report has the place of each part."
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


def _whole_object(sheet: ThickSheet, name: str, print_with: PrintWith) -> PrintObject:
    """The sheet in one, in the middle of the bed of its printer, where that is known."""
    place, printer = UNMOVED, print_with.printer
    if printer is not None:
        points = sheet.bodies.vertices_coords[:, :2]
        place = place_on_bed(points, printer.bed_mm, printer.room_mm)
    return PrintObject(name, tuple(sheet_parts(sheet, *_material_names(print_with))), place)


def _material_names(print_with: PrintWith) -> tuple[str | None, str | None]:
    panels, hinges = print_with.panels, print_with.hinges
    return (
        None if panels is None else panels.description,
        None if hinges is None else hinges.description,
    )


def _plate_objects(plates: Plates, print_with: PrintWith) -> dict[str, list[PrintObject]]:
    """All parts of each plate, each an object of its own."""
    sheet = plates.sheet
    out: dict[str, list[PrintObject]] = {}
    for part in sorted(plates.parts, key=lambda part: part.plate):
        flexible, creases = sheet.flexible[part.numbers], sheet.creases[part.numbers]
        named = _material_names(print_with)
        parts = tuple(body_parts(plates.bodies(part), flexible, creases, *named))
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
    """Files of any crease pattern as a thick sheet: NAME_thick.step, .stl, .3mf, .png, .html and so
    on, and a report.

    A sheet that is larger than its printer's bed gets an .stl and a .3mf for each
    plate, NAME_thick_plate_1.stl and so on.

    pattern : in millimetres; findings : of its reader, listed first in the report, which is the
    file NAME_thick_report.json. progress : called with (stage, steps done, steps in the stage).
    """
    clock = Clock(progress)
    settings = settings.printed(print_with)
    paged = ThickFormat.HTML in formats
    made = thick_files(pattern, name, settings, formats, clock, print_with, guided=paged)
    printer, panels, hinges = print_with.printer, print_with.panels, print_with.hinges
    files = {f"{name}_thick{end}": data for end, data in made.data.items()}
    every = (*findings, *made.findings)
    report: dict[str, Any] = {
        "name": name,
        "settings": settings.model_dump(mode="json"),
        "printer": None if printer is None else printer.model_dump(mode="json"),
        "material": None if panels is None else panels.model_dump(mode="json"),
        "hinge_material": None if hinges is None else hinges.model_dump(mode="json"),
        "counts": {"faces": pattern.face_count, "creases": pattern.counts()},
        "bounding_box_mm": {"flat": box_mm(pattern.vertices_coords), "print": made.print_mm},
        "solids": made.figures,
        "plates": made.plates,
        "seconds": clock.seconds,
    }
    if made.scene is not None and ThickFormat.HTML in formats:
        from fab.viewing.page import ResultPage, page_bytes
        from fab.viewing.scene_builders import with_open_cuts

        with clock.stage("html"):
            page = ResultPage(
                name,
                "quadfold thicken",
                made.scene,
                report,
                with_open_cuts(every, pattern),
                files,
                pictures={f"{name}_thick.png": "flat and folded"},
                assembly=made.guide,
                panels_state=made.panels_state,
            )
            files[f"{name}_thick.html"] = page_bytes(page)
    return with_report(files, THICK.report_name(name), report, every)
