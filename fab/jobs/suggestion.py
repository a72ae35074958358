"""Suggested thicknesses and sizes of a thick sheet."""

from __future__ import annotations

from dataclasses import replace

from fab.clearance.thickness_limit import collisions
from fab.folding.folded_states import folded_states, with_free_angles
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.feasible_window import Least, Window, feasible_window, workable_limit_deg
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.kinematics import unknown_angles
from fab.printing.printers import Printer
from fab.printing.thick_settings import ThickSettings
from fab.progress import Progress, silent

__all__ = ["suggested_window"]


def suggested_window(
    pattern: CreasePattern,
    settings: ThickSettings,
    progress: Progress = silent,
    printer: Printer | None = None,
) -> Window:
    """The feasible window of scale and thickness of a sheet: panels, hinges, walls and overlaps.

    Where creases fold too far for panels of any thickness and size, it is that of the largest fold
    limit that works.

    settings : `printed`. printer : whose nozzle panels are as wide as, at their bottom and top.
    Creases of unknown angle take those of the folded sheet.
    """
    panels, hinges = settings.panels, settings.hinges
    width = 0.0 if printer is None else printer.nozzle_mm
    states = None
    if unknown_angles(pattern).any():
        states, _ = folded_states(pattern, progress=progress)
        pattern = with_free_angles(pattern, states)

    def window(panel: PanelSettings) -> Window:
        clear = collisions(pattern, panel, hinges, progress, states)
        return feasible_window(pattern, panel, hinges, clear, Least(width, True, clear.free))

    given = window(panels)
    limit = workable_limit_deg(pattern, panels, hinges, width) if given.hopeless else None
    if limit is None or limit >= panels.fold_limit_deg:
        return given
    return replace(window(panels.model_copy(update={"fold_limit_deg": limit})), given=given)
