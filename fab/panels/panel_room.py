"""Room that panels need in the faces of a sheet that is yet to be found."""

from __future__ import annotations

import numpy as np

from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings, heights_over_axes_mm, setback_of_kinds
from fab.panels.setbacks import setbacks_of_folds
from solver.goals import PanelRoom
from solver.vectors import FloatArray

__all__ = ["panel_room"]

# A panel is to hold a circle of this radius at its bottom and its top: what printers can make.
_RADIUS_MM = 0.5
# Setbacks of further folds go to infinity; they count as those of this one.
_MOST_DEG = 172.0


def panel_room(panel: PanelSettings, hinge: HingeSettings) -> PanelRoom:
    """The room that panels need, in mm, with hinges of valleys and of mountains.

    >>> room = panel_room(PanelSettings(thickness_mm=2.0), HingeSettings(kind="none"))
    >>> room.at(np.radians([90.0, -90.0])).round(9).tolist()  # at the bottom, and at the top
    [[0.5, 0.5], [2.5, 0.5]]
    """
    heights = heights_over_axes_mm(panel, hinge)
    mountain, valley, _ = hinge.kinds
    most = min(panel.fold_limit_deg, _MOST_DEG)

    def setbacks(angles: FloatArray) -> FloatArray:
        degrees = np.clip(np.degrees(angles), -most, most)
        kinds = np.where(degrees < 0, mountain, valley)
        back = setbacks_of_folds(
            degrees,
            heights,
            gap_mm=panel.gap_mm,
            clearance_mm=panel.clearance_mm,
            hinge_mm=setback_of_kinds(kinds, degrees, panel, hinge),
        )
        return np.stack([back.at(z) for z in heights])

    return PanelRoom(setbacks, _RADIUS_MM)
