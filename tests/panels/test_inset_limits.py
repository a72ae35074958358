"""Bounds of thickness, size and fold angle, proved by stepping just inside and just outside."""

import re
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import pattern_of, triangles
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import Polygon, maximum_inscribed_circle

from fab.panels.bevelled_panels import LEAST_RADIUS_MM, PanelSettings, make_panels
from fab.panels.feasibility import Feasibility
from fab.panels.feasible_window import feasible_window
from fab.panels.hinges import HingeSettings, heights_and_setbacks
from fab.panels.inset_limits import (
    inradii,
    largest_where,
    least_scales,
    rounded_down,
    rounded_up,
    scale_bounds,
)
from fab.panels.setbacks import sides_of
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import scaled

STEP = 1e-6
HINGE = HingeSettings(kind="none")


def framed(ring, angles_deg):
    """A polygon, face 0, with a quad beyond each side, all as wide as the polygon is."""
    n, middle = len(ring), np.mean(ring, axis=0)
    coords = np.concatenate([ring, middle + 4 * (ring - middle)])
    frame = [[(i + 1) % n, i, n + i, n + (i + 1) % n] for i in range(n)]
    pattern = pattern_of(coords, [list(range(n)), *frame])
    own = (pattern.edges_faces == 0).any(axis=1)
    first = np.array([ring_side(n, pair) for pair in pattern.edges_vertices[own].tolist()])
    angle = np.zeros(len(own))
    angle[own] = np.asarray(angles_deg)[first]
    return replace(pattern, edges_foldAngle=angle)


def ring_side(n: int, pair: list[int]) -> int:
    low, high = sorted(pair)
    return low if high - low == 1 else high


@st.composite
def rings(draw, most=8):
    """Convex polygons with corners on an ellipse."""
    n = draw(st.integers(3, most))
    steps = np.array(draw(st.lists(st.floats(1.0, 4.0), min_size=n, max_size=n)))
    turn = np.cumsum(steps) * 2 * np.pi / steps.sum() + draw(st.floats(0, 6.0))
    long, wide = draw(st.floats(4.0, 40.0)), draw(st.floats(0.2, 1.0))
    return long * np.column_stack([np.cos(turn), wide * np.sin(turn)])


@st.composite
def jobs(draw, most=8):
    """A framed polygon with fold angles, and settings of all axes."""
    ring = draw(rings(most))
    size = len(ring)
    angles = draw(st.lists(st.floats(-165.0, 165.0), min_size=size, max_size=size))
    axis = draw(st.sampled_from(["bottom", "middle", "offset"]))
    thickness = draw(st.floats(0.2, 3.0))
    panel = PanelSettings(
        thickness_mm=thickness,
        axis=axis,
        axis_mm=draw(st.floats(-1.0, 0.2)) if axis == "offset" else None,
        gap_mm=draw(st.floats(0.05, 1.0)),
        clearance_mm=draw(st.floats(0.0, 0.3)),
    )
    assume(panel.heights_mm[0] != -panel.heights_mm[1] or axis == "middle")
    return framed(ring, angles), panel


def feasible(pattern, panel, scale=1.0) -> bool:
    pattern = scaled(pattern, factor=scale)
    panels, _ = make_panels(pattern, *heights_and_setbacks(pattern, panel, HINGE))
    return 0 in panels.faces


def thick(panel, thickness_mm) -> PanelSettings:
    return panel.model_copy(update={"thickness_mm": thickness_mm})


def test_a_square_by_hand():
    ring = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    pattern = framed(ring, [90.0, 90.0, 90.0, -90.0])
    panel = PanelSettings(thickness_mm=1.0, gap_mm=1.0, clearance_mm=0.0)
    heights, back = heights_and_setbacks(pattern, panel, HINGE)
    sides = sides_of(pattern)
    # tops: 9 - 2 t wide between two valleys, 9 - t between a valley and the mountain
    assert inradii(sides, back.at(0.0))[0] == pytest.approx(4.5)
    assert inradii(sides, back.at(1.0))[0] == pytest.approx(3.5)
    assert scale_bounds(sides, back, heights, 0.5)[0] == pytest.approx(0.4)
    least, face = LEAST_RADIUS_MM, np.array([0])
    most = Feasibility(pattern, panel, HINGE).largest_thickness_mm(face)
    assert most == pytest.approx((9 - 2 * least) / 2)
    # the axis in the middle: its bottom is set back at the mountain, its top at the valleys
    middle = Feasibility(pattern, panel.model_copy(update={"axis": "middle"}), HINGE)
    assert middle.largest_thickness_mm(face) == pytest.approx(9 - 2 * least)
    # knuckles set panels back by their radius and the play as well: half the height over cos 22.5
    knuckles = HingeSettings(kind="knuckle", pin_mm=0.1, play_mm=0.1, wall_mm=0.1)
    axis = PanelSettings(thickness_mm=1.0, gap_mm=0.1, clearance_mm=0.0, axis="middle")
    ratio = 1 + 1 / np.cos(np.pi / 8)
    most = Feasibility(pattern, axis, knuckles).largest_thickness_mm(face)
    assert most == pytest.approx(2 * (5 - least - 0.1) / ratio)


@settings(max_examples=60)
@given(rings(16), st.lists(st.floats(0.0, 0.5), min_size=16, max_size=16))
def test_inradius_is_that_of_the_polygon(ring, setbacks):
    pattern = framed(ring, np.zeros(len(ring)))
    sides = sides_of(pattern)
    even = inradii(sides, np.full(len(pattern.edges_vertices), 0.3))[0]
    circle = maximum_inscribed_circle(Polygon(ring), tolerance=1e-9)
    assert even == pytest.approx(circle.length - 0.3, abs=1e-6)
    # each side moved on its own: a circle fits where its centre is far enough from all
    back = np.zeros(len(pattern.edges_vertices))
    rows = slice(sides.offsets[0], sides.offsets[1])
    back[sides.edges[rows]] = setbacks[: len(ring)]
    radius = inradii(sides, back)[0]
    assert even + 0.3 - 0.5 - 1e-9 <= radius <= even + 0.3 + 1e-9


@settings(max_examples=120)
@given(jobs())
def test_panels_are_feasible_up_to_the_thickness_and_no_further(job):
    pattern, panel = job
    most = Feasibility(pattern, panel, HINGE).largest_thickness_mm(np.array([0]))
    least = max(0.01, panel.axis_mm or 0.0)
    if most is None:
        assert not feasible(pattern, thick(panel, least))
    elif most < 1000.0:
        assert feasible(pattern, thick(panel, max(most * (1 - STEP), least)))
        assert not feasible(pattern, thick(panel, most * (1 + STEP)))
    else:
        assert feasible(pattern, thick(panel, 1000.0))


def test_the_largest_value_at_which_something_holds():
    assert largest_where(lambda x: x <= 7.3, 1e-3, 1e6) == pytest.approx(7.3, rel=1e-9)
    assert largest_where(lambda x: x <= 7.3, 1e-3, 5.0) == 5.0
    assert largest_where(lambda x: x <= 7.3, 8.0, 9.0) is None


@settings(max_examples=120)
@given(jobs())
def test_panels_are_feasible_down_to_the_scale_and_no_further(job):
    pattern, panel = job
    sides = sides_of(pattern)
    heights, back = heights_and_setbacks(pattern, panel, HINGE)
    least = float(scale_bounds(sides, back, heights, LEAST_RADIUS_MM)[0])
    assert feasible(pattern, panel, least * (1 + STEP))
    assert not feasible(pattern, panel, least * (1 - STEP))


def test_faces_with_many_sides_agree_with_their_halves():
    """Sixteen sides go to the solver, and the same polygon without straight corners does not."""
    turn = np.arange(8) * np.pi / 4
    ring = 10 * np.column_stack([np.cos(turn), np.sin(turn)])
    double = np.stack([ring, (ring + np.roll(ring, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    angles = np.array([120.0, -100, 90, 60, 150, -30, 80, 0])
    found = []
    for corners, rho in ((ring, angles), (double, np.repeat(angles, 2))):
        pattern = framed(corners, rho)
        sides = sides_of(pattern)
        heights, back = heights_and_setbacks(pattern, PanelSettings(), HINGE)
        most = Feasibility(pattern, PanelSettings(), HingeSettings())
        found.append(
            [
                scale_bounds(sides, back, heights, LEAST_RADIUS_MM)[0],
                most.largest_thickness_mm(np.array([0])),
            ]
        )
    assert found[0] == pytest.approx(found[1], rel=1e-7)


def test_no_size_and_no_thickness_help_a_crease_of_180_degrees():
    ring = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    pattern = framed(ring, [180.0, 10, 10, 10])
    panel = PanelSettings()
    bounds = sides_of(pattern), *heights_and_setbacks(pattern, panel, HingeSettings())[::-1]
    assert np.isinf(scale_bounds(*bounds, LEAST_RADIUS_MM)[0])
    assert np.isinf(least_scales(bounds[0], bounds[1].axis_mm, 1.0)[0])
    _, findings = thicken(pattern, panel, HingeSettings())
    (finding,) = findings
    assert finding.code == "fold-too-far"
    assert 0 in finding.panels
    assert [pattern.edges_foldAngle[crease] for crease in finding.creases] == [180.0]
    limit = float(re.search(r"fold_limit_deg to at most ([\d.]+\d)", finding.text)[1])

    def count(limit_deg):
        limited = panel.model_copy(update={"fold_limit_deg": limit_deg})
        return len(thicken(pattern, limited, HingeSettings())[0].panels.bodies)

    assert count(limit) == 5
    assert count(limit + 0.1) < 5


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("axis", ["bottom", "middle"])
def test_what_the_finding_says_saves_all_panels_and_less_does_not(seed, axis):
    pattern = triangles(seed, count=20, size=60.0)
    panel = PanelSettings(thickness_mm=5.0, gap_mm=0.2, axis=axis, fold_limit_deg=120.0)
    hinge = HingeSettings(web_mm=0.1)

    def vanishing(pattern, panel):
        _, findings = thicken(pattern, panel, hinge)
        return [each for each in findings if each.code == "panel-vanishes"]

    (finding,) = vanishing(pattern, panel)
    most = float(re.search(r"thickness_mm at most ([\d.]+)", finding.text)[1])
    scale = float(re.search(r"at least ([\d.]+) times", finding.text)[1])
    assert not vanishing(pattern, thick(panel, most))
    assert vanishing(pattern, thick(panel, most * 1.002))
    assert not vanishing(scaled(pattern, factor=scale), panel)
    assert vanishing(scaled(pattern, factor=scale / 1.002), panel)


@pytest.mark.parametrize("seed", range(3))
def test_the_window_of_a_sheet(seed):
    pattern = triangles(seed, count=20, size=60.0)
    panel = PanelSettings(thickness_mm=1.0, gap_mm=0.2, fold_limit_deg=150.0)
    hinge = HingeSettings(web_mm=0.02)
    window = feasible_window(pattern, panel, hinge)

    def count(thickness_mm=1.0, scale=1.0, **changes):
        given = panel.model_copy(update={"thickness_mm": thickness_mm, **changes})
        sheet, _ = thicken(scaled(pattern, factor=scale), given, hinge)
        return len(sheet.panels.bodies)

    every = pattern.face_count
    assert (window.faces, window.panels) == (every, count())
    assert count(window.thickness_max_mm) == every > count(window.thickness_max_mm + STEP)
    assert count(scale=window.scale_min + STEP) == every > count(scale=window.scale_min - STEP)
    limit = window.fold_max_deg
    assert count(fold_limit_deg=limit) == every > count(fold_limit_deg=limit + 1e-4)
    assert [row.panels for row in window.rows] == [count(row.thickness_mm) for row in window.rows]
    for row in window.rows:
        assert count(row.thickness_mm, row.scale + STEP) == every
        assert count(row.thickness_mm, row.scale - STEP) < every
    # panels that collide at the target bound the thickness as well
    at = window.thickness_max_mm / 3
    lower = feasible_window(pattern, panel, hinge, lambda thickness: min(thickness, at))
    assert lower.clear_max_mm == at
    assert f"thickness_mm at most {rounded_down(at)}, at this" in "\n".join(lower.lines())
    assert replace(lower, clear_max_mm=None) == window


def test_the_window_of_faces_that_are_not_convex():
    dart = np.array([[0.0, 0], [6, 6], [0, 2], [-6, 6]])
    pattern = framed(dart, [80.0, -60.0, 100.0, 40.0])
    panel, hinge = PanelSettings(thickness_mm=0.5, gap_mm=0.2), HINGE
    window = feasible_window(pattern, panel, hinge)
    assert window.panels == pattern.face_count
    assert window.thickness_max_mm is not None
    assert window.scale_min is not None
    assert feasible(pattern, thick(panel, window.thickness_max_mm))
    whole, _ = thicken(pattern, thick(panel, window.thickness_max_mm + STEP), hinge)
    assert len(whole.panels.bodies) < pattern.face_count
    small, _ = thicken(scaled(pattern, factor=window.scale_min - STEP), panel, hinge)
    assert len(small.panels.bodies) < pattern.face_count


@given(st.floats(1e-3, 1e5))
def test_rounded_bounds_stay_on_the_safe_side(bound):
    low, high = float(rounded_down(bound)), float(rounded_up(bound))
    assert low <= bound <= high
    assert high - low <= 2e-3 * bound
    assert "e" not in rounded_down(bound).lower()
