"""The largest fold at which thick panels of a sheet can be made."""

import numpy as np
import pytest
from flat_patterns import pattern_of
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from solid_patterns import folded_pair
from thick_sheets import shipped_pattern

from fab.errors import Severity
from fab.panels.bevelled_panels import LEAST_RADIUS_MM, PanelSettings
from fab.panels.feasibility import Feasibility
from fab.panels.fold_limit import panels_within_reach
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken

LOOSE = HingeSettings(kind="none")


def columns(widths, angle_deg=180.0, length=60.0):
    """Rectangles side by side, their creases folded to and fro."""
    x = np.concatenate([[0.0], np.cumsum(widths)])
    count = len(x)
    coords = np.concatenate([[(a, 0.0) for a in x], [(a, length) for a in x]])
    faces = [[i, i + 1, count + i + 1, count + i] for i in range(count - 1)]
    return pattern_of(coords, faces, "V", angle=angle_deg)


@given(
    st.floats(0.4, 6.0), st.floats(10.0, 60.0), st.floats(0.05, 0.5), st.sampled_from([0.0, 0.4])
)
@settings(max_examples=25, deadline=None)
def test_two_panels_fold_as_far_as_their_top_is_wide_enough_or_their_gap_stays(
    thickness, width, clearance, wall
):
    """s(top) = max(gap, clearance / cos(rho / 2)) / 2 + t tan(rho / 2) of a valley."""
    panel = PanelSettings(thickness_mm=thickness, clearance_mm=clearance)
    made, (found,) = panels_within_reach(folded_pair(180.0, 200.0, width), panel, LOOSE, wall)
    least = max(2 * LEAST_RADIUS_MM, wall)

    def left(half):
        back = max(panel.gap_mm, clearance / np.cos(half)) / 2 + thickness * np.tan(half)
        return width - back - least

    room = 2 * np.degrees(brentq(left, 1e-6, np.pi / 2 - 1e-9))
    gap = 2 * np.degrees(np.arccos(clearance / max(panel.gap_mm, 10 * clearance)))
    exact = min(room, gap)
    assert exact * (1 - 1.1e-3) <= made.fold_limit_deg <= exact * (1 + 1e-5)
    assert (found.code, found.severity) == ("fold-limited", Severity.WARNING)
    assert f"fold_limit_deg = {made.fold_limit_deg:g}" in found.text


@pytest.mark.parametrize("name", ["bird_base", "crane", "waterbomb", "resch"])
@pytest.mark.parametrize(("kind", "axis"), [("web", "bottom"), ("knuckle", "middle")])
def test_the_limit_leaves_every_panel_and_no_fold_much_further_does(name, kind, axis):
    pattern = shipped_pattern(name, 300.0)
    panel = PanelSettings(thickness_mm=3.0, axis=axis)
    hinge = HingeSettings(kind=kind)
    made, found = panels_within_reach(pattern, panel, hinge, 0.4)
    assert [f.code for f in found] == ["fold-limited"]
    feasibility = Feasibility(pattern, made, hinge, 0.4)
    assert feasibility.faces_feasible().all()
    sheet, _ = thicken(pattern, made, hinge, 0.4)
    assert len(sheet.panels.faces) == pattern.face_count
    more = 1.002 * made.fold_limit_deg
    whole = feasibility.faces_feasible(limit_deg=more).all()
    wide = not feasibility.gaps_kept(more, max(panel.gap_mm, 10 * panel.clearance_mm))
    short = len(feasibility.hingeless(limit_deg=more)) > 0
    loose = feasibility.parts(more) > feasibility.parts(made.fold_limit_deg)
    assert not whole or wide or short or loose


def test_a_limit_that_is_given_is_kept_and_small_folds_need_none():
    for panel in (PanelSettings(fold_limit_deg=180.0), PanelSettings(fold_limit_deg=90.0)):
        assert panels_within_reach(folded_pair(180.0), panel, LOOSE) == (panel, [])
    panel = PanelSettings()
    assert panels_within_reach(folded_pair(150.0), panel, LOOSE) == (panel, [])
    # too small for their thickness at any fold: no limit helps, and the error says so
    thick = PanelSettings(thickness_mm=3.0, gap_mm=80.0)
    assert panels_within_reach(folded_pair(180.0), thick, LOOSE) == (thick, [])
    # or only by a few degrees: 30 mm less half a gap and the least width over tan(15 / 2 degrees)
    most = (30.0 - 0.5 - 2 * LEAST_RADIUS_MM) / np.tan(np.radians(7.5))
    for thickness, made_for in ((1.001 * most, []), (0.998 * most, ["fold-limited"])):
        thick = PanelSettings(thickness_mm=thickness)
        found = panels_within_reach(folded_pair(180.0), thick, LOOSE)[1]
        assert [each.code for each in found] == made_for


@given(st.floats(0.3, 1.0), st.booleans())
@settings(max_examples=8, deadline=None)
def test_a_sliver_at_the_rim_does_not_set_the_limit_for_the_sheet(sliver, last):
    panel, hinge = PanelSettings(), HingeSettings()
    widths = [60.0, 60.0, sliver] if last else [sliver, 60.0, 60.0]
    assume(sliver / sum(widths) < 0.01)
    pattern = columns(widths)
    made, (limited,) = panels_within_reach(pattern, panel, hinge)
    assert made.fold_limit_deg > 150
    assert "all but slivers" in limited.text
    sheet, findings = thicken(pattern, made, hinge)
    assert len(sheet.panels.faces) == 2
    (open_face,) = (f for f in findings if f.code == "panel-vanishes")
    assert open_face.severity == Severity.WARNING
    assert open_face.panels == ((2,) if last else (0,))


def test_a_sliver_that_holds_the_sheet_together_is_not_given_up():
    pattern = columns([210.0, 4.0, 210.0])
    made, (limited,) = panels_within_reach(pattern, PanelSettings(), HingeSettings())
    sheet, _ = thicken(pattern, made, HingeSettings())
    assert len(sheet.panels.faces) == 3
    assert len(sheet.held) == 2
    assert "all of them" in limited.text
    assert 60 < made.fold_limit_deg < 90


def test_what_is_named_without_slivers_holds():
    """Faces of 3 % of the area have none as given; without the narrowest the sheet may be less."""
    pattern = columns([60.0, 60.0, 1.0, 3.0], angle_deg=120.0)
    panel, hinge = PanelSettings(thickness_mm=2.0), HingeSettings(web_mm=0.2)
    (found,) = (f for f in thicken(pattern, panel, hinge)[1] if f.code == "panel-vanishes")
    assert found.severity == Severity.ERROR
    assert "Without face 2 (0.81 % of the sheet's area) the others have one with" in found.text
    thickness = float(
        found.text.split("Without")[1].split("thickness_mm at most ")[1].split(",")[0]
    )
    thinner = panel.model_copy(update={"thickness_mm": thickness})
    sheet, findings = thicken(pattern, thinner, hinge)
    assert 2 not in sheet.panels.faces
    assert len(sheet.panels.faces) == 3
    assert all(f.severity == Severity.WARNING for f in findings if f.code == "panel-vanishes")
