"""Folding paths: a crane from flat to its form, closure against the kinematics, straight paths."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from flat_patterns import grid
from helpers import PATTERNS

from fab import read_pattern
from fab.folding import bar_hinge_model
from fab.folding.bar_hinge_model import framework, wrapped
from fab.folding.fold_settings import FoldSettings
from fab.folding.folding_path import closing_path, hinges_around
from fab.folding.quasi_static import fold, largest_turns, path_at
from fab.folding.simulation import fold_and_judge
from fab.folding.verdict import findings_of, judge
from fab.jobs.folding_files import simulate
from fab.pattern.kinematics import fold_by_angles, vertices_closure_rad
from solver.hinge_angles import hinge_angles

STEP = np.radians(20.0)


def frame_of(name):
    return framework(read_pattern(PATTERNS / f"{name}.fold")[0])


@pytest.fixture(scope="module")
def crane():
    frame = frame_of("crane")
    return frame, closing_path(frame).angles


def worst_closure(frame, angles):
    missed, _ = hinges_around(frame).errors(angles)
    return np.linalg.norm(missed, axis=2).max()


def test_a_crane_gets_stuck_all_at_once_and_folds_along_a_path():
    pattern, _ = read_pattern(PATTERNS / "crane.fold")
    together = fold(framework(pattern))
    verdict = judge(together)
    assert verdict.in_local_minimum
    assert not verdict.reached
    assert not verdict.in_turn
    assert "take more steps" in findings_of(verdict)[0].text
    stages = []
    _, verdict, findings = fold_and_judge(
        pattern, FoldSettings(contact=False), progress=lambda *at: stages.append(at)
    )
    assert verdict.reached
    assert verdict.in_turn
    assert not verdict.in_local_minimum
    assert verdict.rmsd_rel < 1e-12
    assert all(point.settled for point in verdict.path)
    assert 0.01 < verdict.peak_strain < 0.1
    assert together.iterations < verdict.iterations < 600
    assert "folds-in-turn" in {finding.code for finding in findings}
    steps = [at[1:] for at in stages if at[0] == "order"]
    assert steps == [(number, steps[0][1]) for number in range(steps[0][1] + 1)]


@pytest.mark.parametrize(
    "settings",
    [
        FoldSettings(axial=200.0, contact=False),
        FoldSettings(steps=1, facet=0.07, crease=0.2, contact=False),
    ],
)
def test_cranes_of_any_stiffness_and_either_side_fold_along_a_path(settings):
    pattern, _ = read_pattern(PATTERNS / "crane.fold")
    letters = pattern.edges_assignment
    other = np.select([letters == "M", letters == "V"], ["V", "M"], letters)
    turned = replace(pattern, edges_foldAngle=-pattern.edges_foldAngle, edges_assignment=other)
    for sheet in (pattern, turned):
        _, verdict, _ = fold_and_judge(sheet, settings)
        assert verdict.reached
        assert verdict.in_turn
        assert verdict.rmsd_rel < 1e-12


def test_no_hinge_of_a_crane_turns_by_over_20_degrees_between_two_states_at_rest(crane):
    frame, path = crane
    folding = fold(frame, 60, path=path)
    assert folding.in_turn
    assert all(state.settled for state in folding.states)
    angles = [hinge_angles(state.coords, frame.hinges_vertices) for state in folding.states]
    turns = [np.abs(wrapped(b - a)).max() for a, b in pairwise(angles)]
    assert max(turns) < STEP
    assert folding.states[-1].energy.total < 1e-20
    few = fold(frame, 1, path=path).states[-1]
    assert few.energy.total < 1e-20
    assert few.strain_peak > 0.01 > 1e-12 > few.strain_max


def test_the_path_of_a_crane_starts_flat_ends_folded_and_nearly_closes(crane):
    frame, path = crane
    assert not path[0].any()
    assert (path[-1] == frame.hinges_target).all()
    turns = largest_turns(path)
    assert turns.max() <= STEP + 1e-12
    straight = np.linspace(0.0, 1.0, len(path))[:, None] * frame.hinges_target
    assert worst_closure(frame, straight) > np.radians(90.0)
    assert worst_closure(frame, path) < np.radians(25.0)
    assert np.abs(path).max() < np.radians(195.0)
    assert (closing_path(frame).angles == path).all()


def test_closure_of_triangles_is_that_of_the_kinematics():
    pattern = read_pattern(PATTERNS / "waterbomb.fold")[0]
    frame = framework(pattern)
    random = np.random.default_rng(3)
    angles = random.uniform(-1.0, 1.0, len(frame.hinges_edge)) * (frame.hinges_edge >= 0)
    folded = np.zeros(len(pattern.edges_foldAngle))
    creases = frame.hinges_edge >= 0
    folded[frame.hinges_edge[creases]] = np.degrees(angles[creases])
    sheet = replace(frame.sheet.pattern, edges_foldAngle=folded)
    expected = vertices_closure_rad(sheet)
    missed, _ = hinges_around(frame).errors(angles[None])
    found = np.sort(np.linalg.norm(missed[0], axis=1))
    assert found[-1] > 0.5
    assert found == pytest.approx(np.sort(expected[np.isfinite(expected)]), abs=1e-12)


def test_slopes_are_derivatives_where_vertices_close():
    frame = frame_of("miura")
    closure = hinges_around(frame)
    at = frame.hinges_target
    missed, slopes = closure.errors(at[None])
    assert np.abs(missed).max() < 1e-9
    step = 1e-6
    for hinge in range(0, len(at), 7):
        moved = at + step * (np.arange(len(at)) == hinge)
        difference = (closure.errors(moved[None])[0] - missed)[0] / step
        places = closure.hinges == hinge
        expected = (slopes[0] * places[:, :, None]).sum(axis=1)
        assert difference == pytest.approx(expected, abs=1e-5)
    assert closure.errors(np.zeros((2, len(at))))[0] == pytest.approx(0.0, abs=1e-15)


def test_where_nothing_must_close_the_path_is_straight():
    strip = grid(4, 1, 10.0)
    frame = framework(strip)
    assert frame.hinges_target.max() == np.pi / 2
    path = closing_path(frame).angles
    assert path == pytest.approx(np.linspace(0.0, 1.0, len(path))[:, None] * frame.hinges_target)
    still = framework(replace(strip, edges_foldAngle=0.0 * strip.edges_foldAngle))
    assert not closing_path(still).angles.any()


def test_shares_of_a_path_are_even_over_the_largest_turn():
    path = np.radians([[0.0, 0.0], [30.0, 0.0], [30.0, 10.0], [20.0, -50.0]])
    for share, angles, rate in (
        (0.15, [15.0, 0.0], [100.0, 0.0]),
        (0.35, [30.0, 5.0], [0.0, 100.0]),
        (0.7, [25.0, -20.0], [-100 / 6, -100.0]),
        (1.0, [20.0, -50.0], [-100 / 6, -100.0]),
    ):
        found = path_at(path, share)
        assert np.degrees(found[0]) == pytest.approx(angles)
        assert np.degrees(found[1]) == pytest.approx(rate)
    straight = np.array([[0.0, 0.0, 0.0], [0.1, -3.1, 0.7]])
    assert all((path_at(straight, n / 7)[0] == n / 7 * straight[1]).all() for n in range(1, 8))


def test_the_kinematics_of_a_sheet_are_computed_once(monkeypatch):
    """Also for one that is folded twice, judged twice, and written with its folded form."""
    calls = []

    def counted(pattern):
        calls.append(pattern)
        return fold_by_angles(pattern)

    monkeypatch.setattr(bar_hinge_model, "fold_by_angles", counted)
    made = simulate(read_pattern(PATTERNS / "crane.fold")[0], "crane", formats=["fold"])
    assert made.report["verdict"]["in_turn"]
    assert len(calls) == 1


def test_findings_agree_in_number():
    pattern, _ = read_pattern(PATTERNS / "resch.fold")
    _, verdict, findings = fold_and_judge(pattern, FoldSettings(steps=1))
    assert f"{verdict.free} creases turn freely" in findings[0].text
    single = replace(verdict, wrong_creases=(4,), off_creases=(4,), free=1)
    (finding,) = [f for f in findings_of(single) if f.code == "target-not-reached"]
    assert "1 crease on the wrong side, 1 off by" in finding.text
    assert "1 crease turns freely" in finding.text
    for vertices, text in (
        ((7,), "around vertex 7: by up to"),
        ((7, 2), "around 2 vertices (7, 2): by up to"),
        ((7, 2, 3, 4, 5, 6), "around 6 vertices (first 7, 2, 3, 4, 5): by up to"),
    ):
        found = findings_of(replace(verdict, open_vertices=vertices))
        (finding,) = [f for f in found if f.code == "angles-do-not-close"]
        assert text in finding.text
        assert "give --rigid" in finding.text


def test_only_sheets_that_get_stuck_are_folded_again():
    pattern, _ = read_pattern(PATTERNS / "crane.fold")
    angles = pattern.edges_foldAngle.copy()
    angles[np.flatnonzero(pattern.edges_assignment == "M")[0]] += 40.0
    open_angles = replace(pattern, edges_foldAngle=angles)
    free, _ = read_pattern(PATTERNS / "resch.fold")
    miura, _ = read_pattern(PATTERNS / "miura.fold")
    settings = FoldSettings(steps=2)
    for other in (open_angles, free, miura):
        stages = []
        _, verdict, _ = fold_and_judge(
            other, settings, progress=lambda *at, to=stages: to.append(at[0])
        )
        assert "order" not in stages
        assert not verdict.in_turn
