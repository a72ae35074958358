"""Seven models as thick sheets: bodies stay apart by what was computed, up to the named bound."""

from functools import cache

import numpy as np
import pytest
from helpers import TEMPLATES
from thick_sheets import shipped_pattern

from fab.clearance.thick_inspection import inspect_thick
from fab.folding.folded_states import FoldedState, Stage, flat_panels, folded_states, panels_at
from fab.geometry.booleans import joined_mesh, manifolds
from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.feasible_window import feasible_window
from fab.panels.hinges import HingeSettings
from fab.panels.inset_limits import rounded_down
from fab.panels.thick_sheet import ThickSheet, thicken
from fab.pattern.crease_pattern import CreasePattern, scaled

# changes of the shipped job, and the width at which its panels can be printed
GROWN = {
    "curved_fold": ((), 1140.0),
    "surface_fit": ((), 600.0),
    "miura": ((), 200.0),
    "twisted_squares": (("design.strips=12",), 600.0),
}
# of others; their creases fold by 180 degrees: how far panels are made to fold, in how many steps
FOUND = {
    "waterbomb": (160.0, 120.0, 8),
    "resch": (240.0, 60.0, 8),
    "square_twist": (120.0, 120.0, 8),
}
# thickness, hinge, axis; panels, hinges, and those of the checked states that are reached
CASES = {
    "curved_fold": (0.4, "web", "bottom", 1000, 1890, 2),
    "surface_fit": (0.8, "none", "bottom", 1760, 0, 2),
    "miura": (3.0, "web", "middle", 80, 142, 2),
    "twisted_squares": (0.6, "film", "bottom", 52, 87, 2),
    "waterbomb": (3.0, "web", "middle", 96, 130, 4),
    "resch": (0.8, "film", "bottom", 128, 176, 2),
    "square_twist": (3.0, "knuckle", "middle", 9, 4, 9),
}


@cache
def pattern_of_model(name: str) -> CreasePattern:
    if name in FOUND:
        return shipped_pattern(name, FOUND[name][0])
    changes, width = GROWN[name]
    pattern, _ = grown_pattern(load_job(TEMPLATES / f"{name}.toml", changes))
    return scaled(pattern, width_mm=width)


def limit_of(name: str) -> float:
    return FOUND[name][1] if name in FOUND else 180.0


def states_of(name: str) -> list[FoldedState]:
    pattern = pattern_of_model(name)
    if name in FOUND:
        return folded_states(pattern, FOUND[name][2])[0]
    return [flat_panels(pattern), panels_at(pattern, pattern.folded_coords, Stage.TARGET, 1.0)]


def settings_of(name: str) -> tuple[PanelSettings, HingeSettings]:
    thickness, kind, axis, *_ = CASES[name]
    limit = limit_of(name)
    panel = PanelSettings(thickness_mm=thickness, gap_mm=0.4, axis=axis, fold_limit_deg=limit)
    return panel, HingeSettings(kind=kind, web_mm=0.15, relief_mm=0.1, knuckle_mm=12.0)


def distances(sheet: ThickSheet, state: FoldedState) -> tuple[np.ndarray, np.ndarray]:
    """Measured and promised, 2 s0 cos(rho / 2) and more for mountains off their axis, in mm: of all
    creases without knuckles, except those that the simulation turns to a side not asked for.
    """
    pattern, panels = sheet.pattern, sheet.panels
    place = np.full(pattern.face_count, -1)
    place[panels.faces] = np.arange(len(panels.faces))
    knuckled = np.isin(np.arange(len(pattern.edges_vertices)), sheet.held)
    knuckled &= not sheet.flexible.any()
    right = state.angles_deg * np.sign(pattern.edges_foldAngle)
    wrong = right < np.abs(state.angles_deg) - 1e-6
    edges = np.flatnonzero((pattern.edges_faces[:, 1] >= 0) & ~knuckled & ~wrong)
    edges = edges[(place[pattern.edges_faces[edges]] >= 0).all(axis=1)]
    half = np.radians(state.angles_deg[edges]) / 2
    off = max(panels.heights_mm[0], 0.0)  # of panels on a film
    promised = 2 * panels.setbacks.axis_mm[edges] * np.cos(half)
    promised += 2 * off * np.maximum(-np.sin(half), 0.0)
    solids = manifolds(sheet.bodies.chosen(np.arange(len(panels.faces))))
    moved = [
        solid.transform(np.column_stack([state.turns[face], state.shifts[face]]))
        for solid, face in zip(solids, panels.faces.tolist(), strict=True)
    ]
    pairs = place[pattern.edges_faces[edges]].tolist()
    found = [moved[i].min_gap(moved[j], 50.0) for i, j in pairs]
    return np.array(found), promised


@pytest.mark.parametrize("name", CASES)
def test_panels_stay_apart_flat_and_folded(name):
    states = states_of(name)
    sheet, _ = thicken(pattern_of_model(name), *settings_of(name))
    figures, findings = inspect_thick(
        sheet, joined_mesh(sheet.joining), states, limit_deg=limit_of(name)
    )
    panels, hinges, reached = CASES[name][3:]
    assert (figures.solids.panels, figures.solids.hinges, len(figures.clearance.states)) == (
        panels,
        hinges,
        reached,
    )
    codes = {finding.code for finding in findings}
    assert codes <= {"fold-blocked", "panels-loose"}
    assert ("fold-blocked" in codes) == (name in FOUND)
    for state, figure in (
        (states[0], figures.clearance.states[0]),
        (states[reached - 1], figures.clearance.states[-1]),
    ):
        assert figure.overlap_max_mm3 <= 1e-6
        measured, promised = distances(sheet, state)
        assert (measured >= 0.97 * promised - 2 * state.bend_mm).all()
        if state.bend_mm < 1e-9 and len(measured):
            assert (measured / promised).min() == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_the_bound_of_the_thickness_is_named_and_holds(name):
    pattern = pattern_of_model(name)
    panel, hinge = settings_of(name)
    bound = feasible_window(pattern, panel, hinge).thickness_max_mm
    inside, outside = (
        thicken(pattern, panel.model_copy(update={"thickness_mm": bound * share}), hinge)
        for share in (1 - 1e-6, 1 + 1e-6)
    )
    assert len(inside[0].panels.bodies) == pattern.face_count
    assert "panel-vanishes" not in {finding.code for finding in inside[1]}
    assert len(outside[0].panels.bodies) < pattern.face_count
    (vanished,) = [f for f in outside[1] if f.code == "panel-vanishes"]
    assert f"thickness_mm at most {rounded_down(bound)}" in vanished.text
