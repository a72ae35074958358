"""Folded states of a sheet with rigid faces: their angles, their names, and what they miss."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import PATTERNS
from thick_sheets import book

from fab import read_pattern
from fab.errors import Severity
from fab.folding.folded_states import Stage, folded_states
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from solver import Miura
from solver.errors import InvalidValue


def test_states_of_patterns_that_fold_flat_and_of_those_that_do_not_fold():
    states, findings = folded_states(book(0.0))
    assert [state.name for state in states] == ["flat"]
    assert findings == []
    pattern = book(90.0)
    states, findings = folded_states(pattern, 2)
    assert [s.name for s in states] == [
        "flat",
        "at 33 % of the fold",
        "at 67 % of the fold",
        "at the target",
    ]
    crease = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)[0]
    assert [s.angles_deg[crease] for s in states] == pytest.approx([0, 30, 60, 90])
    assert max(s.bend_mm for s in states) < 1e-9
    assert [s.name for s in folded_states(pattern, 0)[0]] == ["flat", "at the target"]
    with pytest.raises(InvalidValue, match="count"):
        folded_states(pattern, -1)


def test_states_have_the_share_of_angles_that_they_reach():
    """A square twist does not fold rigidly: pulled at its creases it lies still, and then snaps."""
    pattern, _ = read_pattern(PATTERNS / "square_twist.fold")
    states, _ = folded_states(pattern, 4)
    inner = pattern.edges_faces[:, 1] >= 0
    for state in states[1:-1]:
        # bent into a bowl, mountains are on the wrong side
        right = state.angles_deg[inner] * pattern.edges_foldAngle[inner] > 0
        angles = np.abs(state.angles_deg[inner][right])
        assert 0 < len(angles) < inner.sum()
        assert state.share == pytest.approx(angles.sum() / (180 * inner.sum()))
        assert 0 < state.share < 0.03
        assert state.name == f"at {100 * state.share:.2g} % of the fold"
    assert len({state.name for state in states}) == len(states)
    assert states[-1].name == "at the target"


def test_a_fold_that_misses_its_target_is_reported():
    pattern, _ = read_pattern(PATTERNS / "resch.fold")
    states, (finding,) = folded_states(pattern, 3)
    assert (finding.code, finding.severity) == ("target-not-reached", Severity.NOTE)
    assert states[-1].stage == Stage.TARGET
    mesh = Miura(columns=3, rows=3).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    angle = pattern.edges_foldAngle.copy()
    inner = np.flatnonzero(angle)
    angle[inner[0]] *= -0.5
    states, findings = folded_states(replace(pattern, edges_foldAngle=angle, folded_coords=None), 3)
    assert [f.severity for f in findings] == [Severity.WARNING]
    assert states[-1].stage == Stage.BETWEEN
