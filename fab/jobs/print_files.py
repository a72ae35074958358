"""Files of a thick sheet for printers and CAD programs, and the report that goes with them.

crease pattern -> pieces apart -> panels, hinges -> joined body -> checks -> plates -> STEP, STL,
3MF, PNG, GLB -> result page
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fab.errors import Finding, Severity, counted
from fab.folding.folded_states import folded_states, with_free_angles
from fab.folding.last_states import with_state_at_limit
from fab.jobs.checked_sheet import apart_on_bed, checked_sheet
from fab.jobs.file_names import THICK
from fab.jobs.thick_products import ORDINARY, ThickFormat, product_files
from fab.outputs import Made, box_mm, with_report
from fab.panels.fold_limit import panels_within_reach
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import CreasePattern
from fab.printing.plates import Plates, make_plates
from fab.printing.thick_settings import UNKNOWN, PrintWith, ThickSettings
from fab.progress import Clock, Progress, silent

if TYPE_CHECKING:
    from fab.viewing.leaflet import Leaflet
    from fab.viewing.scene import Scene

__all__ = ["ORDINARY", "ThickFiles", "ThickFormat", "make_thick", "thick_files"]


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
        pattern, findings = apart_on_bed(pattern, print_with.printer)
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
    checked, found = checked_sheet(
        sheet, states, settings, print_with, clock, limit_given=not limited
    )
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
    data, found = product_files(checked, plates, name, formats, clock, print_with, upright=upright)
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
