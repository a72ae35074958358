"""Files of the sheets that a machine cuts crease patterns from: drawings, result page, report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from fab.drawings.cut_paths import CutPaths
from fab.errors import Finding
from fab.jobs.file_names import SHEETS
from fab.jobs.seam_report import seam_findings
from fab.outputs import Made, with_report
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.side_by_side import SideBySide, side_by_side
from fab.progress import Progress, silent
from fab.sheets.cut_pieces import PatternCopies
from fab.sheets.sheet_drawings import sheet_drawings
from fab.sheets.sheet_request import SheetRequest
from solver.errors import InvalidValue

if TYPE_CHECKING:
    from fab.viewing.leaflet import Leaflet

__all__ = ["FabricatedFormat", "assembly_file", "fabricate", "fabricate_together"]


class FabricatedFormat(StrEnum):
    """The kinds of files of `fabricate`: drawings, the result page, the assembly guide."""

    DXF = "dxf"
    SVG = "svg"
    PDF = "pdf"
    LBRN2 = "lbrn2"
    PLT = "plt"
    GCODE = "gcode"
    HTML = "html"
    ASSEMBLY = "assembly"


def fabricate(
    pattern: CreasePattern,
    name: str,
    request: SheetRequest,
    *,
    findings: Sequence[Finding] = (),
    progress: Progress = silent,
) -> Made:
    """Files of all sheets that the copies of a pattern take, and a report.

    Parameters
    ----------
    pattern : in millimetres.
    name : what the files are named after.
    findings : of the pattern's reader, which go into the report as well.
    progress : called with (stage, steps done, steps in the stage).

    The report is the file `name`_sheets_report.json, which may be beside that of the job that
    made the pattern. It lists sheets (file names, pierces, lengths in mm, minutes, share of the bed
    in use; of two-sided ones each side, and how to turn them), pieces, and the seams in the order
    in which they are glued. A seam has its number, length and fold angle, both pieces, which of
    them (0 or 1) carries the tab, and of each the sheet and the middle of the edge on it: of the
    first copy, on the front.

    Raises `InvalidValue` where a face is larger than the bed, a style does not suit the kerf, or
    all copies of all pieces have more than 5 million dashes; `InvalidState` where G-code has an
    operation whose power the machine does not have.
    """
    wanted = PatternCopies(name, pattern, findings=tuple(findings))
    return fabricate_together([wanted], name, request, progress=progress)


def fabricate_together(
    patterns: Sequence[PatternCopies],
    name: str,
    request: SheetRequest,
    *,
    progress: Progress = silent,
) -> Made:
    """As `fabricate`, of several patterns whose pieces lie on the same sheets.

    The pieces of all are named one after another, and so are the seams; findings begin with the
    name of their pattern. Raises `InvalidValue` for two patterns of one name.
    """
    names = [wanted.name for wanted in patterns]
    for number, each in enumerate(names):
        if each in names[:number]:
            raise InvalidValue("name", repr(each), "be of one pattern", "Name the others anew.")
    made = sheet_drawings(patterns, name, request, progress)
    files, report = dict(made.files), made.report
    all_rims = {
        wanted.name: cut.meeting
        for wanted, cut in zip(patterns, made.cut, strict=True)
        if cut.meeting is not None
    }
    if all_rims:
        rims = {each: meeting.report() for each, meeting in all_rims.items()}
        report = {**report, "seams": rims if len(patterns) > 1 else rims[name]}
    together = side_by_side([wanted.pattern for wanted in patterns])
    every = [
        _numbered_in(found, wanted.name, together, number)
        for number, (wanted, cut) in enumerate(zip(patterns, made.cut, strict=True))
        for found in (
            *wanted.findings,
            *(seam_findings(cut.meeting) if cut.meeting is not None else ()),
            *cut.findings,
        )
    ]
    every += made.findings
    guide = None
    if request.page or request.guide:
        progress("assembly", 0, 1)
        from fab.jobs.assembly_files import guide_of

        guide = guide_of(
            patterns, name, request, made, made_by="quadfold fabricate", findings=every
        )
    if request.guide and guide is not None:
        files |= assembly_file(guide, name)
    if request.page:
        pattern = together.pattern if len(patterns) > 1 else patterns[0].pattern
        files[f"{name}_sheets.html"] = _page(
            pattern, name, request, report, every, files, made.paths, guide
        )
    progress("write", 1, 1)
    return with_report(files, SHEETS.report_name(name), report, every)


def assembly_file(guide: Leaflet, name: str) -> dict[str, bytes]:
    """The pages for print that say how sheets are put together, by the name of their file."""
    from fab.viewing.leaflet_pdf import leaflet_pdf_bytes

    return {f"{name}_assembly.pdf": leaflet_pdf_bytes(guide)}


def _numbered_in(finding: Finding, name: str, together: SideBySide, pattern: int) -> Finding:
    """A finding of one of several patterns, which is named, with numbers in all of them."""
    if len(together.first_faces) == 1:
        return finding
    edge, face = together.first_edges[pattern], together.first_faces[pattern]
    return replace(
        finding,
        text=f"{name}: {finding.text}",
        creases=tuple(int(edge) + crease for crease in finding.creases),
        panels=tuple(int(face) + panel for panel in finding.panels),
    )


def _page(
    pattern: CreasePattern,
    name: str,
    request: SheetRequest,
    report: Mapping[str, Any],
    findings: Sequence[Finding],
    files: Mapping[str, bytes],
    drawings: Mapping[str, CutPaths],
    guide: Leaflet | None,
) -> bytes:
    """The result page of the sheets."""
    from fab.viewing.page import ResultPage, page_bytes
    from fab.viewing.predicted_fold import predicted_scene

    scene = predicted_scene(pattern, name, findings=findings)
    colours = request.machine.colours
    page = ResultPage(
        name,
        "quadfold fabricate",
        scene,
        report,
        scene.findings,
        files,
        drawings,
        colours,
        assembly=guide,
    )
    return page_bytes(page)
