"""Bounds at which panels begin to overlap when folded, proved by the inspection of all bodies."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from flat_patterns import grid
from helpers import ROOT
from solid_patterns import creased
from thick_sheets import shipped_pattern

from fab.clearance.thick_inspection import inspect_thick
from fab.clearance.thickness_limit import clear_up_to, collisions
from fab.errors import Severity
from fab.folding.folded_states import Stage, folded_states, known_target, panels_at, states_within
from fab.folding.last_states import with_state_at_limit
from fab.geometry.booleans import joined_mesh
from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.feasible_window import feasible_window
from fab.panels.hinges import HingeSettings
from fab.panels.setbacks import setbacks
from fab.panels.thick_sheet import thicken
from fab.pattern.closing_edges import closing_edges
from fab.pattern.crease_pattern import scaled
from fab.pattern.kinematics import fold_by_angles

STEP = 1e-6


@cache
def target(name, width_mm, limit_deg):
    pattern = shipped_pattern(name, width_mm)
    states = with_state_at_limit(
        pattern, np.arange(pattern.face_count), folded_states(pattern)[0], limit_deg
    )
    return states_within(pattern, np.arange(pattern.face_count), states, limit_deg)[0][-1]


def with_thickness(panel, thickness_mm):
    return panel.model_copy(update={"thickness_mm": thickness_mm})


def overlaps(pattern, panel, hinge, state):
    """Overlaps that the inspection of the whole sheet finds in one state."""
    sheet, _ = thicken(pattern, panel, hinge)
    found = inspect_thick(sheet, joined_mesh(sheet.joining), [state])[1]
    return [f for f in found if f.code == "solids-overlap" and f.severity == Severity.ERROR]


@pytest.mark.parametrize(
    ("name", "width_mm", "limit_deg", "axis", "kind", "thickness_mm"),
    [
        ("miura", 100.0, 180.0, "bottom", "none", 3.0),
        ("miura", 100.0, 180.0, "middle", "web", 3.0),
        ("resch", 200.0, 60.0, "bottom", "none", 3.0),
        ("resch", 200.0, 60.0, "middle", "web", 6.0),
    ],
)
def test_the_named_thickness_is_where_panels_begin_to_overlap(
    name, width_mm, limit_deg, axis, kind, thickness_mm
):
    pattern = shipped_pattern(name, width_mm)
    hinge = HingeSettings(kind=kind)
    panel = PanelSettings(
        thickness_mm=thickness_mm, gap_mm=0.5, axis=axis, fold_limit_deg=limit_deg
    )
    state = target(name, width_mm, limit_deg)
    found = overlaps(pattern, panel, hinge, state)
    named = {re.search(r"thickness_mm at most ([\d.]+\d)", finding.text)[1] for finding in found}
    (named,) = [float(bound) for bound in named]
    assert not overlaps(pattern, with_thickness(panel, named), hinge, state)
    assert overlaps(pattern, with_thickness(panel, named * 1.002), hinge, state)
    bound = clear_up_to(pattern, panel, hinge, state)
    assert named <= bound < named * 1.002
    assert not overlaps(pattern, with_thickness(panel, bound * (1 - STEP)), hinge, state)
    assert overlaps(pattern, with_thickness(panel, bound * (1 + STEP)), hinge, state)
    # the window begins with thicker panels, and ends at the same
    window = feasible_window(pattern, panel, hinge, collisions(pattern, panel, hinge))
    assert window.clear_max_mm == pytest.approx(bound, rel=STEP)
    assert "without overlap of panels" in "\n".join(window.lines())


@pytest.mark.parametrize("axis", ["bottom", "middle"])
def test_panels_of_a_waterbomb_stay_apart_as_long_as_they_are_feasible(axis):
    pattern, hinge = shipped_pattern("waterbomb", 100.0), HingeSettings(kind="none")
    panel = PanelSettings(gap_mm=0.1, axis=axis, fold_limit_deg=120.0)
    window = feasible_window(pattern, panel, hinge, collisions(pattern, panel, hinge))
    assert window.clear_max_mm == window.thickness_max_mm > 4.0
    assert not any("overlap" in line for line in window.lines())
    most = with_thickness(panel, window.thickness_max_mm)
    assert not overlaps(pattern, most, hinge, target("waterbomb", 100.0, 120.0))


def test_a_sheet_that_passes_through_itself_has_no_thickness():
    """Two flaps of one square each, folded over the middle of a row of three, past each other."""
    pattern = grid(3, 1, 20.0)
    shared = pattern.edges_faces[:, 1] >= 0
    pattern = creased(pattern, np.where(shared, 150.0, 0.0))
    state = known_target(pattern)
    panel, hinge = PanelSettings(thickness_mm=0.5), HingeSettings(kind="none")
    assert clear_up_to(pattern, panel, hinge, state) is None
    (found,) = overlaps(pattern, panel, hinge, state)
    assert "at every thickness that these hinges allow: fold less" in found.text
    window = feasible_window(pattern, panel, hinge, collisions(pattern, panel, hinge))
    assert window.clear_max_mm == 0.0
    assert "overlap at the target at every thickness: lower fold_limit_deg" in "\n".join(
        window.lines()
    )


def test_a_limit_that_stops_the_sheet_makes_that_state_the_target():
    pattern = grid(3, 1, 20.0)
    shared = pattern.edges_faces[:, 1] >= 0
    pattern = creased(pattern, np.where(shared, 150.0, 0.0))
    hinge = HingeSettings(kind="none")
    stopped = PanelSettings(thickness_mm=0.5, fold_limit_deg=60.0)
    assert collisions(pattern, stopped, hinge)(0.5) == 0.5
    # also where panels are too thick as given
    assert collisions(pattern, with_thickness(stopped, 50.0), hinge)(0.5) == 0.5
    assert collisions(pattern, with_thickness(stopped, 0.5), hinge)(0.5) == 0.5


@cache
def twisted_squares():
    return scaled(grown_pattern(load_job(ROOT / "templates" / "twisted_squares.toml"))[0], factor=3)


@pytest.mark.parametrize(
    ("kind", "axis", "thickness_mm"),
    [("web", "bottom", 0.8), ("none", "middle", 1.6), ("film", "bottom", 1.6)],
)
def test_rings_that_close_when_folded_do_not_overlap_at_their_seam(kind, axis, thickness_mm):
    pattern, hinge = twisted_squares(), HingeSettings(kind=kind)
    panel = PanelSettings(thickness_mm=thickness_mm, gap_mm=0.5, axis=axis)
    state = panels_at(pattern, pattern.folded_coords, Stage.TARGET, 1.0)
    assert overlaps(pattern, panel, hinge, state) == []
    # without their setback they do, in the same state
    angles = 0.999 * pattern.edges_foldAngle  # which do not close
    ajar = replace(pattern, folded_coords=None, edges_foldAngle=angles)
    assert overlaps(ajar, panel, hinge, state)


def test_borders_that_close_have_the_angle_and_the_setback_of_a_crease():
    """Three squares of a triangular tube, cut open along one side."""
    pattern = grid(3, 1, 20.0)
    shared = pattern.edges_faces[:, 1] >= 0
    pattern = creased(pattern, np.where(shared, 120.0, 0.0))
    tube = replace(pattern, folded_coords=fold_by_angles(pattern).folded_coords)
    (ends,), angles = closing_edges(tube)
    assert angles == pytest.approx([120.0])
    assert len(closing_edges(pattern)[0]) == 0
    back = setbacks(tube, (0.0, 1.0), gap_mm=1.0, clearance_mm=0.1, hinge_mm=np.zeros(len(shared)))
    for name in ("axis_mm", "above", "clearance_mm"):
        values = getattr(back, name)
        assert values[ends] == pytest.approx(values[shared][0], rel=1e-9)
    mirrored = replace(tube, edges_foldAngle=-tube.edges_foldAngle)
    flipped = replace(mirrored, folded_coords=tube.folded_coords * [1.0, 1.0, -1.0])
    assert closing_edges(flipped)[1] == pytest.approx([-120.0])
