"""What the findings name saves all panels, and a little more or less does not."""

import re
from functools import cache

import numpy as np
import pytest
from helpers import ROOT
from solid_patterns import creased, folded_pair
from thick_sheets import shipped_pattern

from fab.errors import InvalidJob
from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.panels.bevelled_panels import PanelSettings, make_panels
from fab.panels.feasibility import Feasibility
from fab.panels.hinges import HingeSettings, heights_and_setbacks
from fab.panels.lost_faces import inspect_feasibility
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import scaled

# The named bounds have four digits.
MORE = 1.002
NUMBER = r"(\d+(?:\.\d+)?)"
KINDS = [("web", "bottom"), ("film", "bottom"), ("none", "middle"), ("knuckle", "middle")]


@cache
def sheet_of(name):
    if name in ("waterbomb", "resch", "square_twist"):
        return shipped_pattern(name, 150.0)
    return grown_pattern(load_job(ROOT / "templates" / f"{name}.toml"))[0]


def lost(pattern, panel, hinge):
    """Findings of faces without a panel."""
    panels, _ = make_panels(pattern, *heights_and_setbacks(pattern, panel, hinge))
    return inspect_feasibility(pattern, panel, hinge, panels.faces)


@pytest.mark.parametrize(("kind", "axis"), KINDS)
@pytest.mark.parametrize(
    "name",
    ["curved_fold", "twisted_squares", "waterbomb", "resch", "square_twist"],
)
def test_what_is_named_saves_all_panels_and_a_little_less_does_not(name, kind, axis):
    pattern, hinge = sheet_of(name), HingeSettings(kind=kind)
    named = 0
    for thickness_mm in (3.0, 6.0, 12.0):
        panel = PanelSettings(thickness_mm=thickness_mm, gap_mm=0.5, axis=axis, fold_limit_deg=150)
        for found in lost(pattern, panel, hinge):
            named += 1
            assert found.code == "panel-vanishes"
            least = float(re.search(rf"at least {NUMBER} times", found.text)[1])
            assert not lost(scaled(pattern, factor=least), panel, hinge)
            assert lost(scaled(pattern, factor=least / MORE), panel, hinge)
            for_all = found.text.partition(" Without ")[0]
            most = re.search(rf"thickness_mm at most {NUMBER}", for_all)
            if most is None:
                assert "No thickness that its hinges allow" in found.text
                thin = {"web": 0.4051, "knuckle": 2.916}[kind]
                assert lost(pattern, panel.model_copy(update={"thickness_mm": thin}), hinge)
                continue
            for factor, feasible in ((1.0, True), (MORE, False)):
                given = panel.model_copy(update={"thickness_mm": float(most[1]) * factor})
                assert (not lost(pattern, given, hinge)) is feasible
    assert named or (name, kind) == ("square_twist", "none")


@pytest.mark.parametrize(("kind", "axis"), KINDS)
@pytest.mark.parametrize("name", ["waterbomb", "square_twist", "bird_base", "crane"])
def test_folds_of_180_degrees_are_named_with_the_angle_that_panels_reach(name, kind, axis):
    pattern, hinge = shipped_pattern(name, 300.0), HingeSettings(kind=kind)
    panel = PanelSettings(thickness_mm=3.0, axis=axis)
    (found,) = (f for f in lost(pattern, panel, hinge) if f.code == "fold-too-far")
    assert (np.abs(pattern.edges_foldAngle[list(found.creases)]) == 180.0).all()
    assert "by up to 180 degrees" in found.text
    limit = re.search(rf"fold_limit_deg to at most {NUMBER}", found.text)
    limit = float(limit[1])

    def whole(limit_deg):
        limited = panel.model_copy(update={"fold_limit_deg": limit_deg})
        found = {f.code for f in lost(pattern, limited, hinge)}
        # knuckles that cannot turn as far are bounds too
        short = "fold too far for knuckles" in " ".join(
            f.text for f in thicken(pattern, limited, hinge)[1]
        )
        return not found and not short

    assert whole(limit)
    assert not whole(limit * MORE)


def test_mountains_of_180_degrees_have_panels_above_their_axes():
    pattern = folded_pair(180.0)
    mountain = creased(pattern, -pattern.edges_foldAngle)
    panel, hinge = PanelSettings(), HingeSettings()
    (found,) = lost(mountain, panel, hinge)
    assert "panels.axis_mm = -0.05 and hinges.kind = none" in found.text
    lifted = panel.model_copy(update={"axis": "offset", "axis_mm": -0.05})
    assert not lost(mountain, lifted, HingeSettings(kind="none"))
    lower = panel.model_copy(update={"axis": "offset", "axis_mm": -0.04})
    assert lost(mountain, lower, HingeSettings(kind="none"))
    # valleys close on that side
    (found,) = lost(pattern, panel, hinge)
    assert "axis_mm" not in found.text


def test_without_clearance_180_degrees_are_refused_alike():
    panel = PanelSettings(clearance_mm=0.0)
    (found,) = lost(folded_pair(180.0), panel, HingeSettings())
    assert found.code == "fold-too-far"


def test_hinges_that_do_not_fit_the_panels_are_refused():
    panel = PanelSettings(thickness_mm=1.0)
    assert Feasibility(folded_pair(90.0), panel, HingeSettings()).faces_feasible().all()
    with pytest.raises(InvalidJob, match=r"hinges.web_mm = 2 must be below"):
        thicken(folded_pair(90.0), PanelSettings(), HingeSettings(web_mm=2.0))
