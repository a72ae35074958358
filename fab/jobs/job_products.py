"""Products of a job besides its drawings: FOLD, solids, pictures, the model, the result page."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from fab.errors import Finding
from fab.formats.fold.writer import fold_bytes
from fab.jobs.folded_sheet import FoldedSheet
from fab.jobs.job_formats import SOLID, Format
from fab.jobs.job_parts import Part
from fab.outputs import box_mm
from fab.progress import Clock

__all__ = ["fold_part", "picture_part", "scene_files", "solids_part"]

# Ends of files that are of the thick sheet, or of the sheet itself.
_ALSO_OF_SHEETS = {".png", ".glb", "_assembly.pdf"}


def fold_part(sheet: FoldedSheet, wanted: Collection[Format], clock: Clock) -> Part:
    """The FOLD file."""
    if Format.FOLD not in wanted:
        return Part()
    name = sheet.settings.name
    with clock.stage("fold"):
        return Part({f"{name}.fold": fold_bytes(sheet.pattern, name)})


def solids_part(sheet: FoldedSheet, wanted: set[Format], clock: Clock) -> Part:
    """Panels and hinges; the boxes around the sheet in any case."""
    pattern, settings = sheet.pattern, sheet.settings
    assert pattern.folded_coords is not None  # the mesh is the folded form
    boxes = {"flat": box_mm(pattern.vertices_coords), "folded": box_mm(pattern.folded_coords)}
    if not wanted & SOLID:
        return Part(report={"bounding_box_mm": boxes, "solids": None})
    from fab.jobs.print_files import ThickFormat, thick_files

    print_with = settings.print_with(settings.folder)
    made = thick_files(
        pattern,
        settings.name,
        settings.printed(print_with),
        {kind for kind in ThickFormat if kind.value in set(wanted)},
        clock,
        print_with,
        upright=sheet.upright,
        made_by="quadfold run",
    )
    solids: dict[str, Any] | None = None
    if made.figures is not None and made.print_mm is not None:
        boxes["print"] = made.print_mm
        solids = {**made.figures, "plates": made.plates}
    files = {
        settings.name + ("_thick" + end if end in _ALSO_OF_SHEETS else end): data
        for end, data in made.data.items()
    }
    return Part(
        files,
        made.findings,
        {"bounding_box_mm": boxes, "solids": solids},
        made.scene,
        made.panels_state,
    )


def picture_part(sheet: FoldedSheet, wanted: Collection[Format], clock: Clock) -> Part:
    """The picture of the folded form and the crease pattern."""
    if Format.PNG not in wanted:
        return Part()
    from fab.viewing.sheet_picture import sheet_png_bytes

    name = sheet.settings.name
    with clock.stage("png"):
        return Part({f"{name}.png": sheet_png_bytes(sheet.scene())})


def scene_files(
    sheet: FoldedSheet,
    wanted: set[Format],
    parts: Sequence[Part],
    files: Mapping[str, bytes],
    findings: Sequence[Finding],
    report: Mapping[str, Any],
    clock: Clock,
) -> dict[str, bytes]:
    """The model of the folded form, and the page of all that the run made."""
    name = sheet.settings.name
    scene, reached = next(
        ((part.scene, part.panels_state) for part in parts if part.scene is not None), (None, 0)
    )
    made: dict[str, bytes] = {}
    with clock.stage("scene"):
        if scene is None:
            from fab.viewing.predicted_fold import predicted_scene

            scene = predicted_scene(sheet.pattern, name, upright=sheet.upright)
    if Format.GLB in wanted:
        from fab.viewing.glb import sheet_glb_bytes

        with clock.stage("glb"):
            made[f"{name}.glb"] = sheet_glb_bytes(scene)
    if Format.HTML in wanted:
        from fab.viewing.page import ResultPage, page_bytes

        drawn = next((part for part in parts if part.paths), Part())
        pictures = {
            f"{name}.png": "folded form and crease pattern",
            f"{name}_thick.png": "panels and hinges, flat and folded",
        }
        with clock.stage("html"):
            page = ResultPage(
                name,
                "quadfold run",
                scene,
                report,
                findings,
                {**files, **made},
                drawn.paths,
                drawn.colours,
                pictures=pictures,
                assembly=drawn.guide,
                panels_state=reached,
            )
            made[f"{name}.html"] = page_bytes(page)
    return made
