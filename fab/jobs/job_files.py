"""Files of a job, or of any folded quad mesh.

The flow, and the only place where its branches join:

    design -> mesh -> development -> crease pattern -+-> sheets, or perforation alone -> DXF, SVG
                                                     +-> FOLD, PNG
                                                     +-> thick sheet -> STEP, STL, 3MF, PNG
                                                     +-> scene -> GLB, result page of it all
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fab import __version__
from fab.drawings.drawing_files import DrawingStyle, SheetFormat, drawing_files
from fab.errors import Finding, InvalidJob, Severity, counted
from fab.formats.fold.writer import fold_bytes
from fab.jobs.alike_panels import alike_panels
from fab.jobs.file_names import JOB
from fab.jobs.goals import check_goals
from fab.jobs.grow import grown, growth_findings, overlap_findings, unfolded
from fab.jobs.job import Job, SheetSettings
from fab.jobs.seam_report import seam_findings
from fab.jobs.sheet_files import assembly_file
from fab.jobs.surface_report import growth_report
from fab.outputs import Made, box_mm, formats_among, with_report, write
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_accuracy, inspect_crossings, measure_pattern
from fab.pattern.meeting_rims import meeting_rims
from fab.progress import Clock, Progress, silent
from fab.settings import checked
from fab.sheets.cut_pieces import PatternCopies
from fab.sheets.perforation import perforate
from fab.sheets.rim_points import rim_marks
from fab.sheets.sheet_drawings import sheet_drawings
from solver import Growth, QuadMesh
from solver.graphs import labels
from solver.self_intersection import crossing_faces
from solver.targets.base import Target
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import FloatArray, IntArray

if TYPE_CHECKING:
    from fab.drawings.cut_paths import CutPaths
    from fab.drawings.layer_colours import Colours
    from fab.viewing.leaflet import Leaflet
    from fab.viewing.scene import Scene

__all__ = ["Format", "Sheet", "from_mesh", "grown_sheet", "make"]


class Format(StrEnum):
    """The kinds of files that a job makes, named by their endings."""

    FOLD = "fold"
    DXF = "dxf"
    SVG = "svg"
    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"
    ZIP = "zip"
    GLB = "glb"
    HTML = "html"
    PDF = "pdf"
    LBRN2 = "lbrn2"
    PLT = "plt"
    GCODE = "gcode"
    ASSEMBLY = "assembly"


_SOLID = {Format.STEP, Format.STL, Format.THREEMF, Format.ZIP}
# Ends of files that are of the thick sheet, or of the sheet itself.
_ALSO_OF_SHEETS = {".png", ".glb", "_assembly.pdf"}
_OF_SCENES = {Format.GLB, Format.HTML}
# Larger sheets take long to be found rigid or not; `check` says so of any.
_RIGIDITY_FACES = 2000
# What is made of a drawing that no machine is known for.
_DRAWN = (Format.DXF, Format.SVG, Format.PDF)


_NO_KERF = "lines are drawn without kerf, for no machine"
_NO_KERF_CURE = (
    "Add a table [cutter] with material and machine to the job, or use `quadfold fabricate` with "
    "its FOLD file, to have sheets for them"
)


@dataclass(frozen=True)
class Sheet:
    """A folded sheet, its crease pattern, and how it is made.

    Attributes
    ----------
    mesh : folded, in units of its own; cut open along a seam where it was a ring or a tube.
    pattern : in millimetres.
    settings : name, outputs, tolerance and the tables of a job.
    overlaps : pairs of faces that overlap when flat, shape (n, 2).
    growth : how the mesh was grown; None for a mesh of another origin.
    findings : of files that were read for it.
    target : the surface that it follows, in the units of the mesh.
    """

    mesh: QuadMesh
    pattern: CreasePattern
    settings: SheetSettings
    overlaps: IntArray
    growth: Growth | None = None
    findings: tuple[Finding, ...] = ()
    target: Target | SurfaceMesh | None = None

    @property
    def upright(self) -> bool:
        """Whether z is up: of sheets that follow a surface."""
        return self.target is not None

    def scene(self) -> Scene:
        """What pictures show of it: flat and folded, over the surface that it follows."""
        from fab.viewing.scene_builders import over_surface, pattern_scene

        scene = pattern_scene(self.pattern, self.settings.name, upright=self.upright)
        if self.target is None:
            return scene
        from solver.relaxed_fit import sampled

        surface = self.target if isinstance(self.target, SurfaceMesh) else sampled(self.target)
        factor = _mm_per_unit(self)
        return over_surface(
            scene, SurfaceMesh(surface.vertices_coords * factor, surface.faces_vertices)
        )

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
) -> Made:
    """Run a job in memory: grow, develop, and write each of `formats` as bytes.

    formats : those of the job where none are given.

    progress : called with (stage, steps done, steps in the stage).

    rigidity : whether sheets of up to 2,000 faces are looked at for rigid folding, which takes a
    tenth of a second.

    Raises `InvalidJob` where the design's parameters leave nothing to grow, or a sheet without
    area. Growth that stops early, overlaps and the like are findings in the report.
    """
    clock = Clock(progress)
    return _made(_grown_sheet(job, clock), formats, clock, rigidity=rigidity)


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


@dataclass(frozen=True)
class _Part:
    """What one stage adds to what is made: files by name, findings, and keys of the report.

    scene : of the sheet in folded states, where the stage has them and a model or page is made.
    panels_state : number of the state up to which its panels fold.
    paths : what is cut, by title; colours : of its operations; guide : how it is put together.
    """

    files: Mapping[str, bytes] = field(default_factory=dict)
    findings: Sequence[Finding] = ()
    report: Mapping[str, Any] = field(default_factory=dict)
    scene: Scene | None = None
    panels_state: int = 0
    paths: Mapping[str, CutPaths] = field(default_factory=dict)
    colours: Colours | None = None
    guide: Leaflet | None = None


def _made(
    sheet: Sheet, formats: Iterable[str] | None, clock: Clock, *, rigidity: bool = True
) -> Made:
    names = sheet.settings.wanted if formats is None else formats
    wanted = set(formats_among(names, Format, "format"))
    parts = [
        _growth(sheet, wanted),
        _measures(sheet, clock),
        _goals(sheet),
        _seams(sheet),
        _fold_file(sheet, wanted, clock),
        _drawings(sheet, wanted, clock),
        _solids(sheet, wanted, clock),
        _simulation(sheet, wanted, clock),
        _rigidity(sheet, clock) if rigidity else _Part(report={"rigid": None}),
        _picture(sheet, wanted, clock),
    ]
    report: dict[str, Any] = {
        "quadfold": __version__,
        "job": sheet.settings.model_dump(mode="json"),
    }
    files: dict[str, bytes] = {}
    for part in parts:
        report |= part.report
        files |= part.files
    findings = [finding for part in parts for finding in part.findings]
    if wanted & _OF_SCENES:
        files |= _of_scene(sheet, wanted, parts, files, findings, report, clock)
    report["seconds"] = clock.seconds
    return with_report(files, JOB.report_name(sheet.settings.name), report, findings)


def _growth(sheet: Sheet, wanted: Collection[Format]) -> _Part:
    in_pieces = _makes_sheets(sheet, wanted) and not any(kind in wanted for kind in _SOLID)
    overlaps = overlap_findings(sheet.overlaps, in_pieces=in_pieces)
    growth = sheet.growth
    if growth is None:
        return _Part(findings=overlaps, report={"growth": None})
    report = growth_report(growth, _mm_per_unit(sheet))
    findings = [*sheet.findings, *growth_findings(growth), *overlaps]
    return _Part(findings=findings, report={"growth": report})


def _mm_per_unit(sheet: Sheet) -> float:
    folded = sheet.pattern.folded_coords
    assert folded is not None  # the mesh is the folded form
    return float(np.ptp(folded, axis=0).max() / np.ptp(sheet.mesh.vertices_coords, axis=0).max())


def _measures(sheet: Sheet, clock: Clock) -> _Part:
    pattern = sheet.pattern
    with clock.stage("measure"):
        accuracy = measure_pattern(pattern)
        findings = inspect_accuracy(accuracy, sheet.settings.tolerance)
    with clock.stage("cross"):
        crossings = crossing_faces(
            sheet.mesh.vertices_coords, pattern.faces_vertices, pattern.faces_offsets
        )
        crossings, between = _by_pieces(pattern, crossings)
        findings += inspect_crossings(crossings)
        if len(between):
            pairs, (first, second) = counted(len(between), "pair"), between[0]
            text = (
                f"sheets pass through each other: {pairs} of faces of different sheets, the first "
                f"are {first} and {second}. Along a seam pleats of both reach across it: join the "
                "sheets edge to edge there. Elsewhere more columns keep them apart."
            )
            findings.append(Finding("sheets-meet", Severity.NOTE, text))
    counts = {
        "vertices": len(pattern.vertices_coords),
        "faces": pattern.face_count,
        "creases": pattern.counts(),
    }
    measures = {key: _number(value) for key, value in dataclasses.asdict(accuracy).items()}
    return _Part(
        findings=findings, report={"counts": counts, **measures, "crossings": len(crossings)}
    )


def _by_pieces(pattern: CreasePattern, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of faces of the same piece of a sheet, and pairs of different ones."""
    beside = pattern.edges_faces
    piece = labels(beside[beside[:, 1] >= 0], pattern.face_count)
    same = piece[pairs[:, 0]] == piece[pairs[:, 1]]
    return pairs[same], pairs[~same]


def _goals(sheet: Sheet) -> _Part:
    check = check_goals(sheet.pattern, sheet.settings, sheet.growth)
    goals = sheet.settings.goals
    alike = alike_panels(sheet.pattern, goals.alike_mm, goals.different_panels).report()
    if check is None:
        return _Part(report={"goals": None, "alike_panels": alike})
    return _Part(findings=check.findings, report={"goals": check.report, "alike_panels": alike})


def _seams(sheet: Sheet) -> _Part:
    meeting = meeting_rims(sheet.pattern)
    if meeting is None:
        return _Part()
    return _Part(findings=seam_findings(meeting), report={"seams": meeting.report()})


def _fold_file(sheet: Sheet, wanted: Collection[Format], clock: Clock) -> _Part:
    if Format.FOLD not in wanted:
        return _Part()
    name = sheet.settings.name
    with clock.stage("fold"):
        return _Part({f"{name}.fold": fold_bytes(sheet.pattern, name)})


def _drawings(sheet: Sheet, wanted: Collection[Format], clock: Clock) -> _Part:
    """The sheets for the job's cutter, or else one drawing of the whole pattern."""
    kinds = [kind for kind in SheetFormat if Format(kind) in wanted]
    guided = Format.ASSEMBLY in wanted
    settings = sheet.settings
    if settings.cutter is None:
        loose = guided and not _SOLID & set(wanted)
        _require_drawn([Format(kind) for kind in kinds] + [Format.ASSEMBLY] * loose)
    if not kinds and not _makes_sheets(sheet, wanted):
        return _Part()
    if settings.cutter is not None:
        request = settings.cutter.request(
            kinds, perforation=settings.perforation, page=False, folder=settings.folder
        )
        with clock.stage("sheets"):
            patterns = [PatternCopies(settings.name, sheet.pattern)]
            made = sheet_drawings(patterns, settings.name, request, clock.progress)
        files = dict(made.files)
        found = [*(each for cut in made.cut for each in cut.findings), *made.findings]
        guide = None
        if guided or Format.HTML in wanted:
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
                if guided:
                    files |= assembly_file(guide, settings.name)
        return _Part(
            files,
            found,
            {key: value for key, value in made.report.items() if key != "name"},
            paths=made.paths,
            colours=request.machine.colours,
            guide=guide,
        )
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
    return _Part(drawn, [*findings, note], paths={"As it is cut": paths})


def _makes_sheets(sheet: Sheet, wanted: Collection[Format]) -> bool:
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


def _solids(sheet: Sheet, wanted: set[Format], clock: Clock) -> _Part:
    pattern, settings = sheet.pattern, sheet.settings
    assert pattern.folded_coords is not None  # the mesh is the folded form
    boxes = {"flat": box_mm(pattern.vertices_coords), "folded": box_mm(pattern.folded_coords)}
    if not wanted & _SOLID:
        return _Part(report={"bounding_box_mm": boxes, "solids": None})
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
    return _Part(
        files,
        made.findings,
        {"bounding_box_mm": boxes, "solids": solids},
        made.scene,
        made.panels_state,
    )


def _simulation(sheet: Sheet, wanted: set[Format], clock: Clock) -> _Part:
    settings = sheet.settings.simulation
    if settings is None:
        return _Part(report={"simulation": None})
    from fab.folding.rigid_findings import with_motion
    from fab.folding.rigid_motion import rigid_motion
    from fab.folding.simulation import fold_and_judge

    folding, verdict, findings = fold_and_judge(sheet.pattern, settings, progress=clock.progress)
    findings = with_motion(findings, verdict, rigid_motion(sheet.pattern, folding.frame))
    scene: Scene | None = None
    if wanted & _OF_SCENES:
        from fab.viewing.scene_builders import folding_scene

        scene = folding_scene(folding, sheet.settings.name, upright=sheet.upright)
    return _Part(findings=findings, report={"simulation": verdict.report()}, scene=scene)


def _rigidity(sheet: Sheet, clock: Clock) -> _Part:
    """Whether the sheet folds with flat faces, where that is found in a tenth of a second."""
    pattern = sheet.pattern
    if pattern.face_count > _RIGIDITY_FACES:
        return _Part(report={"rigid": None})
    from fab.folding.rigid_motion import rigid_motion

    with clock.stage("rigid"):
        return _Part(report={"rigid": rigid_motion(pattern).report()})


def _picture(sheet: Sheet, wanted: Collection[Format], clock: Clock) -> _Part:
    if Format.PNG not in wanted:
        return _Part()
    from fab.viewing.sheet_picture import sheet_png_bytes

    name = sheet.settings.name
    with clock.stage("png"):
        return _Part({f"{name}.png": sheet_png_bytes(sheet.scene())})


def _of_scene(
    sheet: Sheet,
    wanted: set[Format],
    parts: Sequence[_Part],
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

        drawn = next((part for part in parts if part.paths), _Part())
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


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
