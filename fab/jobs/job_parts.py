"""Parts of what a job makes that are measured or checked: growth, exactness, goals, seams, folding.

Each is a `Part`: files, findings, and keys of the report.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from fab.errors import Finding, Severity, counted
from fab.jobs.alike_panels import alike_panels
from fab.jobs.folded_sheet import FoldedSheet
from fab.jobs.goals import check_goals
from fab.jobs.grow import growth_findings, overlap_findings
from fab.jobs.job_formats import OF_SCENES, Format
from fab.jobs.seam_report import seam_findings
from fab.jobs.surface_report import growth_report
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_accuracy, inspect_crossings, measure_pattern
from fab.pattern.meeting_rims import meeting_rims
from fab.progress import Clock
from solver.errors import InvalidState
from solver.graphs import labels
from solver.self_intersection import crossing_faces
from solver.vectors import IntArray

if TYPE_CHECKING:
    from fab.drawings.cut_paths import CutPaths
    from fab.drawings.layer_colours import Colours
    from fab.folding.quasi_static import Checkpoint
    from fab.viewing.leaflet import Leaflet
    from fab.viewing.scene import Scene

__all__ = [
    "Part",
    "by_pieces",
    "goals_part",
    "growth_part",
    "measures_part",
    "rigidity_part",
    "seams_part",
    "simulation_part",
]

# Larger sheets take long to be found rigid or not; `check` says so of any.
_RIGIDITY_FACES = 2000


@dataclass(frozen=True)
class Part:
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


def growth_part(sheet: FoldedSheet, *, in_pieces: bool) -> Part:
    """How the sheet grew. in_pieces : whether what overlaps is cut apart."""
    overlaps = overlap_findings(sheet.overlaps, in_pieces=in_pieces)
    growth = sheet.growth
    if growth is None:
        return Part(findings=overlaps, report={"growth": None})
    report = growth_report(growth, sheet.mm_per_unit)
    findings = [*sheet.findings, *growth_findings(growth), *overlaps]
    return Part(findings=findings, report={"growth": report})


def measures_part(sheet: FoldedSheet, clock: Clock) -> Part:
    """How exact it is, what it is made up of, and faces that pass through each other."""
    pattern = sheet.pattern
    with clock.stage("measure"):
        accuracy = measure_pattern(pattern)
        findings = inspect_accuracy(accuracy, sheet.settings.tolerance)
    with clock.stage("cross"):
        crossings = crossing_faces(
            sheet.mesh.vertices_coords, pattern.faces_vertices, pattern.faces_offsets
        )
        crossings, between = by_pieces(pattern, crossings)
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
    return Part(
        findings=findings, report={"counts": counts, **measures, "crossings": len(crossings)}
    )


def by_pieces(pattern: CreasePattern, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of faces of the same piece of a sheet, and pairs of different ones."""
    beside = pattern.edges_faces
    piece = labels(beside[beside[:, 1] >= 0], pattern.face_count)
    same = piece[pairs[:, 0]] == piece[pairs[:, 1]]
    return pairs[same], pairs[~same]


def goals_part(sheet: FoldedSheet) -> Part:
    """Whether it meets the goals that were set, and how many different faces it has."""
    check = check_goals(sheet.pattern, sheet.settings, sheet.growth)
    goals = sheet.settings.goals
    alike = alike_panels(sheet.pattern, goals.alike_mm, goals.different_panels).report()
    if check is None:
        return Part(report={"goals": None, "alike_panels": alike})
    return Part(findings=check.findings, report={"goals": check.report, "alike_panels": alike})


def seams_part(sheet: FoldedSheet) -> Part:
    """Where rims of several sheets are joined."""
    meeting = meeting_rims(sheet.pattern)
    if meeting is None:
        return Part()
    return Part(findings=seam_findings(meeting), report={"seams": meeting.report()})


def simulation_part(
    sheet: FoldedSheet, wanted: set[Format], clock: Clock, checkpoint: Checkpoint | None = None
) -> Part:
    """The verdict of its simulation, where the settings ask for one, and whether it is rigid."""
    settings = sheet.settings.simulation
    if settings is None:
        return Part(report={"simulation": None})
    from fab.jobs.simulated_sheet import simulated_sheet

    cutter = sheet.settings.cutter
    material = None if cutter is None else cutter.material
    made = simulated_sheet(
        sheet.pattern, settings, material=material, progress=clock.progress, checkpoint=checkpoint
    )
    findings: Sequence[Finding] = made.findings
    scene: Scene | None = None
    if wanted & OF_SCENES:
        scene = made.scene(sheet.settings.name, upright=sheet.upright)
    found = made.report()
    report = {"simulation": found["verdict"], "rigid": found["rigid"]}
    if found["layers"] is not None:
        report["layers"] = found["layers"]
    files: dict[str, bytes] = {}
    if settings.loads is not None:
        from fab.jobs.sheet_loads import carried_loads

        name = sheet.settings.name
        carried = carried_loads(
            made.folding,
            settings.loads,
            material,
            name,
            upright=sheet.upright,
            progress=clock.progress,
        )
        findings = [*findings, *carried.findings()]
        report["loads"] = carried.report()
        if Format.PNG in wanted:
            files[f"{name}_loads.png"] = carried.png_bytes()
    return Part(files=files, findings=findings, report=report, scene=scene)


def rigidity_part(sheet: FoldedSheet, clock: Clock) -> Part:
    """Whether the sheet folds with flat faces, where that is found in a tenth of a second.

    It is not asked of a sheet of which a face is inside out or has no area: such a sheet has an
    error from its growth.
    """
    pattern = sheet.pattern
    if pattern.face_count > _RIGIDITY_FACES:
        return Part()
    from fab.folding.rigid_motion import rigid_motion

    with clock.stage("rigid"):
        try:
            return Part(report={"rigid": rigid_motion(pattern).report()})
        except InvalidState:
            return Part()


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
