"""States between those that are known: where a fold ends, exactly."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from thick_sheets import book, miura_pattern, shipped_pattern

from fab.folding.folded_states import Stage, folded_states, states_within
from fab.folding.last_states import states_between, with_state_at_limit


@given(st.floats(20.0, 170.0), st.floats(0.02, 0.98))
@settings(max_examples=8, deadline=None)
def test_a_book_ends_at_the_share_of_its_limit(angle, share):
    pattern = book(angle)
    states, _ = folded_states(pattern)
    limited = with_state_at_limit(pattern, np.arange(2), states, share * angle)
    reached, beyond = states_within(pattern, np.arange(2), limited, share * angle)
    assert len(beyond) == 1
    assert share - 2e-5 <= reached[-1].share <= share + 1e-7
    assert reached[-1].stage in (Stage.TARGET, Stage.FLAT)
    assert max(np.abs(reached[-1].angles_deg)) == pytest.approx(share * angle, rel=2e-3)


def test_a_sheet_with_one_motion_ends_in_a_state_with_flat_faces():
    pattern = miura_pattern()
    states, _ = folded_states(pattern)
    faces = np.arange(pattern.face_count)
    most = np.abs(states[-1].angles_deg).max()
    limited = with_state_at_limit(pattern, faces, states, 0.63 * most)
    assert len(limited) == len(states) + 1
    (sought,) = (state for state in limited if state.sought)
    assert np.abs(sought.angles_deg).max() == pytest.approx(0.63 * most, rel=1e-3)
    assert sought.bend_mm < 1e-9
    assert sought.name == f"at {100 * sought.share:.4g} % of the fold"
    shares = [state.share for state in limited]
    assert shares == sorted(shares)


def test_a_sheet_that_bends_is_at_rest_between():
    """The state between two of a square twist bends its faces no more than these do."""
    pattern = shipped_pattern("square_twist", 200.0)
    states, _ = folded_states(pattern)
    between = states_between(pattern)
    for first, second in pairwise(states[3:7]):
        middle = between.at(first, second, 0.5)
        assert middle.bend_mm <= 1.5 * max(first.bend_mm, second.bend_mm) + 0.1
        angles = (first.angles_deg + second.angles_deg) / 2
        assert np.abs(middle.angles_deg - angles).max() < 12.0


def test_the_end_of_a_sheet_that_bends_is_no_target():
    pattern = shipped_pattern("square_twist", 200.0)
    faces = np.arange(pattern.face_count)
    states = with_state_at_limit(pattern, faces, folded_states(pattern)[0], 120.0)
    reached, beyond = states_within(pattern, faces, states, 120.0)
    assert len(beyond)
    assert reached[-1].sought
    assert reached[-1].bend_mm > 0.1
    assert [state.stage for state in reached[-2:]] == [Stage.TARGET, Stage.BETWEEN]


def test_limits_that_no_state_meets_or_all_do_change_nothing():
    pattern = book(90.0)
    states, _ = folded_states(pattern)
    assert with_state_at_limit(pattern, np.arange(2), states, 120.0) == states
    # only faces that have a panel count
    assert with_state_at_limit(pattern, np.arange(1), states, 20.0) == states
