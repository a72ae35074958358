"""Makers' goals of a job: what its design is told of them, and what was reached."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.errors import Finding, Severity, counted, first_few
from fab.jobs.alike_panels import alike_panels, needed_mm
from fab.jobs.job import SheetSettings, SheetSize
from fab.panels.feasibility import Feasibility
from fab.panels.inset_limits import inradii, rounded_down, rounded_up
from fab.panels.panel_room import panel_room
from fab.panels.setbacks import Sides, sides_of
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.development import develop
from solver import Growth
from solver.goals import Bounds, Goals
from solver.mesh import QuadMesh
from solver.panel_shapes import PanelCount
from solver.polygons import next_corner
from solver.vectors import FloatArray

__all__ = ["GoalsCheck", "check_goals", "design_goals", "design_unit"]

# Bounds count as met within rounding.
_MET = 1e-9
_CELL = "Another zigzag, row_step, thickness or turn_deg of the design may help"


def design_goals(settings: SheetSettings) -> Goals | None:
    """What the design of a job is told; None where there is no goal.

    Where a job has a table of panels or of hinges, faces are to have room for them.
    """
    goals = settings.goals
    room = None
    if _has_panels(settings):
        thick = settings.printed(settings.print_with(settings.folder))
        room = panel_room(thick.panels, thick.hinges)
    bounds = Bounds(
        least_side=goals.least_side_mm or 0.0,
        least_inradius=goals.least_inradius_mm or 0.0,
        least_sector=math.radians(goals.least_sector_deg or 0.0),
        most_fold=math.radians(goals.most_fold_deg or 180.0),
        panels=room,
        alike=(
            None
            if goals.different_panels is None
            else PanelCount(goals.different_panels, goals.alike_mm)
        ),
    )
    if bounds == Bounds():
        return None

    return Goals(bounds, lambda sheet, folded: _mm(settings.sheet, sheet, folded))


def design_unit(size: SheetSize) -> Callable[[QuadMesh], float]:
    """The length of a mm in units of a sheet, asked of the sheet."""
    return lambda sheet: _mm(size, sheet, sheet.vertices_coords)


def _mm(size: SheetSize, sheet: QuadMesh, folded: FloatArray) -> float:
    return 1 / size.scale(develop(sheet.cut_open()), folded)


@dataclass(frozen=True)
class GoalsCheck:
    """Each goal of a job with its bound and what was reached, and findings of those missed."""

    report: dict[str, Any]
    findings: tuple[Finding, ...]


def check_goals(
    pattern: CreasePattern, settings: SheetSettings, growth: Growth | None
) -> GoalsCheck | None:
    """Judge a sheet by the goals of its job; None where it has none.

    Room for panels is a goal of sheets that were relaxed; others are told when panels are made.
    """
    goals, sides = settings.goals, sides_of(pattern)
    columns = None if growth is None else growth.chosen.get("columns")
    report: dict[str, Any] = {}
    findings: list[Finding] = []
    for key, measure in (
        ("least_side_mm", _side),
        ("least_inradius_mm", _inradius),
        ("least_sector_deg", _sector),
        ("most_fold_deg", _fold),
    ):
        bound = getattr(goals, key)
        if bound is None:
            continue
        found = measure(pattern, sides)
        short = bound - found.reached if key.startswith("least") else found.reached - bound
        met = short <= _MET * bound
        report[key] = {"bound": bound, "reached": found.reached, "met": met}
        if not met:
            cure = f"{_CELL}; {found.rounded} is within reach."
            if key.endswith("_mm"):
                cure = _larger(bound, found.reached, columns)
            text = f"goals.{key} = {bound:g} is missed: {found.text}. {cure}"
            places = found.creases, found.panels
            findings.append(Finding("goal-missed", Severity.WARNING, text, *places))
    if goals.different_panels is not None:
        alike = _alike(pattern, goals.different_panels, goals.alike_mm)
        report["different_panels"] = alike.report
        findings += alike.findings
    if _has_panels(settings) and growth is not None and growth.deviations is not None:
        room = _panels(pattern, settings)
        report["panels"] = room.report
        findings += room.findings
    return GoalsCheck(report, tuple(findings)) if report else None


def _has_panels(settings: SheetSettings) -> bool:
    return bool({"panels", "hinges"} & settings.model_fields_set)


def _panels(pattern: CreasePattern, settings: SheetSettings) -> GoalsCheck:
    """Faces that have a panel, by the window of thickness and size in which all of them have."""
    thick = settings.printed(settings.print_with(settings.folder))
    feasibility = Feasibility(pattern, thick.panels, thick.hinges)
    lost = np.flatnonzero(~feasibility.faces_feasible())
    met = not len(lost)
    report = {"bound": pattern.face_count, "reached": pattern.face_count - len(lost), "met": met}
    if met:
        return GoalsCheck(report, ())
    thickness, scale = feasibility.largest_thickness_mm(), feasibility.least_scale()
    cures = []
    if thickness is not None:
        cures.append(f"panels.thickness_mm at most {rounded_down(thickness)}")
    if scale is not None:
        cures.append(f"a sheet {rounded_up(scale)} times as large")
    cures.append("a lower panels.fold_limit_deg" if not cures else "fewer columns")
    text = (
        f"the table of panels asks for room in all {counted(pattern.face_count, 'face')}: "
        f"{counted(len(lost), 'face has', 'faces have')} no panel of "
        f"{thick.panels.thickness_mm:g} mm. All have one with {', or '.join(cures)}."
    )
    return GoalsCheck(
        report, (Finding("goal-missed", Severity.WARNING, text, panels=first_few(lost)),)
    )


def _alike(pattern: CreasePattern, bound: int, within_mm: float) -> GoalsCheck:
    """How many templates all panels are cut by, and which one each panel."""
    found = alike_panels(pattern, within_mm, bound)
    met = found.different <= bound
    report = {"bound": bound, "reached": found.different, "met": met, "within_mm": within_mm}
    report["faces_template"] = found.faces_template.tolist()
    if met:
        return GoalsCheck(report, ())
    needed = needed_mm(pattern, bound)
    looser = "" if needed is None else f", and so is alike_mm = {rounded_up(needed)}"
    text = (
        f"goals.different_panels = {bound} is missed: panels are of {found.different} shapes that "
        f"differ by more than alike_mm = {within_mm:g}. different_panels = {found.different} is "
        f"within reach{looser}. Relaxed sheets have few shapes where their surface is alike all "
        "around or all along, and on other gentle ones."
    )
    return GoalsCheck(report, (Finding("goal-missed", Severity.WARNING, text),))


@dataclass(frozen=True)
class _Measured:
    """What a goal bounds, where it is least or most, and that number rounded to the safe side."""

    reached: float
    rounded: str
    text: str
    creases: tuple[int, ...] = ()
    panels: tuple[int, ...] = ()


def _side(_: CreasePattern, sides: Sides) -> _Measured:
    k = int(sides.length_mm.argmin())
    edge, rounded = int(sides.edges[k]), rounded_down(sides.length_mm[k])
    text = f"edge {edge} is {rounded} mm long"
    return _Measured(float(sides.length_mm[k]), rounded, text, creases=(edge,))


def _inradius(pattern: CreasePattern, sides: Sides) -> _Measured:
    radii = np.maximum(inradii(sides, np.zeros(len(pattern.edges_vertices))), 0.0)
    face = int(radii.argmin())
    rounded = rounded_down(radii[face])
    text = f"the widest circle in face {face} has a radius of {rounded} mm"
    return _Measured(float(radii[face]), rounded, text, panels=(face,))


def _sector(_: CreasePattern, sides: Sides) -> _Measured:
    after = next_corner(sides.offsets)
    u, v = sides.along, sides.along[after]
    turn = np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))
    angles = np.degrees(np.pi - turn)
    k = int(angles.argmin())
    face, rounded = int(sides.faces[k]), rounded_down(angles[k])
    text = f"face {face} has a corner of {rounded} degrees"
    return _Measured(float(angles[k]), rounded, text, panels=(face,))


def _fold(pattern: CreasePattern, _: Sides) -> _Measured:
    size = np.abs(pattern.edges_foldAngle)
    edge = int(size.argmax())
    rounded = rounded_up(size[edge])
    return _Measured(float(size[edge]), rounded, f"crease {edge} folds by {rounded}", (edge,))


def _larger(bound: float, reached: float, columns: float | None) -> str:
    if reached <= 0:
        return "Give fewer columns."
    text = f"A sheet {rounded_up(bound / reached)} times as large reaches it"
    if columns is not None and columns * reached / bound >= 4:
        text += f", and perhaps one with {int(columns * reached / bound)} columns"
    return f"{text}."
