"""Drawings of a job: the sheets for its cutter, or one of the whole pattern without kerf."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from fab.drawings.drawing_files import DrawingStyle, SheetFormat, drawing_files
from fab.errors import Finding, InvalidJob, Severity
from fab.jobs.folded_sheet import FoldedSheet
from fab.jobs.job_formats import SOLID, Format
from fab.jobs.job_parts import Part
from fab.jobs.sheet_files import assembly_file
from fab.pattern.meeting_rims import meeting_rims
from fab.progress import Clock
from fab.sheets.cut_pieces import PatternCopies
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.perforation import perforate
from fab.sheets.rim_points import rim_marks
from fab.sheets.sheet_drawings import sheet_drawings

__all__ = ["drawings_part", "makes_sheets"]

# What is made of a drawing that no machine is known for.
_DRAWN = (Format.DXF, Format.SVG, Format.PDF)
_NO_KERF = "lines are drawn without kerf, for no machine"
_NO_KERF_CURE = (
    "Add a table [cutter] with material and machine to the job, or use `quadfold fabricate` with "
    "its FOLD file, to have sheets for them"
)


def drawings_part(sheet: FoldedSheet, wanted: Collection[Format], clock: Clock) -> Part:
    """The sheets for the job's cutter, or else one drawing of the whole pattern.

    Raises `InvalidJob` for formats that only a known machine follows, where none is named.
    """
    kinds = [kind for kind in SheetFormat if Format(kind) in wanted]
    cutter = sheet.settings.cutter
    if cutter is None:
        guide_of_sheets = Format.ASSEMBLY in wanted and not SOLID & set(wanted)
        _require_drawn([Format(kind) for kind in kinds] + [Format.ASSEMBLY] * guide_of_sheets)
        return _without_kerf(sheet, kinds, clock) if kinds else Part()
    return (
        _for_cutter(sheet, cutter, kinds, wanted, clock) if makes_sheets(sheet, wanted) else Part()
    )


def _for_cutter(
    sheet: FoldedSheet,
    cutter: CutterSettings,
    kinds: Sequence[SheetFormat],
    wanted: Collection[Format],
    clock: Clock,
) -> Part:
    """The sheets that a machine cuts, and how their pieces are put together."""
    settings = sheet.settings
    request = cutter.request(
        kinds, perforation=settings.perforation, page=False, folder=settings.folder
    )
    with clock.stage("sheets"):
        patterns = [PatternCopies(settings.name, sheet.pattern)]
        made = sheet_drawings(patterns, settings.name, request, clock.progress)
    files = dict(made.files)
    found = [*(each for cut in made.cut for each in cut.findings), *made.findings]
    guide = None
    if Format.ASSEMBLY in wanted or Format.HTML in wanted:
        from fab.jobs.assembly_files import guide_of

        with clock.stage("assembly"):
            guide = guide_of(
                patterns,
                settings.name,
                request,
                made,
                made_by="quadfold run",
                findings=found,
                upright=sheet.upright,
            )
            if Format.ASSEMBLY in wanted:
                files |= assembly_file(guide, settings.name)
    return Part(
        files,
        found,
        {key: value for key, value in made.report.items() if key != "name"},
        paths=made.paths,
        colours=request.machine.colours,
        guide=guide,
    )


def _without_kerf(sheet: FoldedSheet, kinds: Sequence[SheetFormat], clock: Clock) -> Part:
    """One drawing of the pattern, which says that it is for no machine."""
    settings = sheet.settings
    with clock.stage("perforate"):
        meeting = meeting_rims(sheet.pattern)
        marks = [] if meeting is None else rim_marks(sheet.pattern, meeting)
        paths, findings = perforate(sheet.pattern, settings.perforation, marks=marks)
    drawn: dict[str, bytes] = {}
    style = DrawingStyle(remark=_NO_KERF)
    for kind in kinds:
        with clock.stage(kind):
            drawn |= drawing_files(paths, settings.name, [kind], style)
    note = Finding("no-kerf", Severity.NOTE, f"{_NO_KERF}. {_NO_KERF_CURE}")
    return Part(drawn, [*findings, note], paths={"As it is cut": paths})


def makes_sheets(sheet: FoldedSheet, wanted: Collection[Format]) -> bool:
    """Whether sheets are made for the job's cutter: for their files, their guide or the page."""
    kinds = {*(Format(kind) for kind in SheetFormat), Format.ASSEMBLY, Format.HTML}
    return sheet.settings.cutter is not None and any(kind in wanted for kind in kinds)


def _require_drawn(kinds: Sequence[Format]) -> None:
    """Raise `InvalidJob` for formats that only a known machine follows."""
    programs = [kind for kind in kinds if kind not in _DRAWN]
    if programs:
        raise InvalidJob(
            f"{' and '.join(programs)}: the job names no machine to make it for. Add a table "
            "[cutter], such as `--set cutter.material=card_300gsm --set "
            "cutter.machine=co2_60w_600x400`."
        )
