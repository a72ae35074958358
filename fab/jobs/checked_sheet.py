"""Thick sheets, checked: sound solids, apart in every state, fit for their printer."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.clearance.thick_inspection import inspect_thick
from fab.errors import Finding, InvalidJob, Severity, counted, first_few
from fab.folding.folded_states import FoldedState
from fab.geometry.bodies import TriangleMesh
from fab.layout.piece_gaps import set_apart
from fab.panels.thick_sheet import ThickSheet
from fab.pattern.crease_pattern import CreasePattern
from fab.printing.pauses import Pause, film_pause, inspect_pause
from fab.printing.printability import inspect_print, inspect_webs, print_figures
from fab.printing.printers import Printer
from fab.printing.thick_settings import PrintWith, ThickSettings
from fab.progress import Clock

__all__ = ["CheckedSheet", "apart_on_bed", "checked_sheet"]


@dataclass(frozen=True)
class CheckedSheet:
    """A thick sheet that was checked.

    Attributes
    ----------
    joined : the surface of all its bodies. figures : what was measured, by the keys of a report.
    states : the folded states that it was checked in, the flat one first, and those beyond in
        which panels would overlap.
    checked : number of those that it was checked in.
    """

    sheet: ThickSheet
    joined: TriangleMesh
    figures: dict[str, Any]
    states: tuple[FoldedState, ...]
    checked: int


def apart_on_bed(pattern: CreasePattern, printer: Printer) -> tuple[CreasePattern, list[Finding]]:
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


def checked_sheet(
    sheet: ThickSheet,
    states: Sequence[FoldedState],
    settings: ThickSettings,
    print_with: PrintWith,
    clock: Clock,
    *,
    limit_given: bool,
) -> tuple[CheckedSheet, list[Finding]]:
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
    return CheckedSheet(sheet, joined, figures, tuple(states), max(1, reached)), findings


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
