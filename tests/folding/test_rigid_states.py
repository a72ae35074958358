"""Folded states with all faces flat, near to those of a simulation that bends them."""

import numpy as np
import pytest
from helpers import PATTERNS, TEMPLATES

from fab import read_pattern
from fab.folding.bar_hinge_model import framework
from fab.folding.fold_settings import FoldSettings
from fab.folding.folded_states import Stage, folded_states, panels_at
from fab.folding.folding_path import hinges_around
from fab.folding.quasi_static import aligned, fold
from fab.folding.rigid_states import rigid_coords
from fab.folding.rotation_predictor import rotation_predictor
from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.pattern.crease_pattern import fold_angles_deg


def halfway(pattern):
    frame = framework(pattern, FoldSettings(crease=0.01))
    return frame, fold(frame, 4).states[2].coords


def rigid(frame, coords):
    return rigid_coords(frame, hinges_around(frame), rotation_predictor(frame), coords)


def bend_mm(pattern, frame, coords):
    size = frame.size_mm
    return panels_at(pattern, coords * size, Stage.BETWEEN, 1.0, frame.sheet.pattern).bend_mm


@pytest.mark.parametrize("name", ["waterbomb", "resch", "miura"])
def test_rigid_patterns_have_a_state_without_bending_nearby(name):
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    frame, bent = halfway(pattern)
    assert bend_mm(pattern, frame, bent) > 1e-5 * frame.size_mm
    flat = rigid(frame, bent)
    assert bend_mm(pattern, frame, flat) < 1e-12 * frame.size_mm
    assert np.abs(frame.strains(flat)).max() < 1e-11
    assert np.abs(aligned(flat, bent) - bent).max() < 0.02


def test_a_rigid_state_stays_where_it_is():
    """The exact folded form, from coordinates that are off it by a little."""
    pattern, _ = grown_pattern(load_job(TEMPLATES / "miura.toml"))
    frame = framework(pattern, FoldSettings())
    exact = pattern.folded_coords / frame.size_mm
    noise = 1e-4 * np.random.default_rng(1).standard_normal(exact.shape)
    found = rigid(frame, exact + noise)
    assert bend_mm(pattern, frame, found) < 1e-12 * frame.size_mm
    angles = fold_angles_deg(found, pattern.edges, pattern.faces_vertices, pattern.faces_offsets)
    # one freedom is left: by how much it is folded
    assert angles == pytest.approx(pattern.edges_foldAngle, abs=0.5)


def test_patterns_that_must_bend_have_none():
    pattern, _ = grown_pattern(load_job(TEMPLATES / "twisted_squares.toml"))
    frame, bent = halfway(pattern)
    assert rigid(frame, bent) is None


def test_states_of_panels_are_rigid_where_the_pattern_is():
    pattern, _ = read_pattern(PATTERNS / "waterbomb.fold")
    states, _ = folded_states(pattern)
    size = np.ptp(pattern.vertices_coords, axis=0).max()
    assert [state.stage for state in states] == [Stage.FLAT, *8 * [Stage.BETWEEN], Stage.TARGET]
    assert max(state.bend_mm for state in states) < 1e-9 * size
    shares = [state.share for state in states]
    assert shares == sorted(shares)
    assert shares[4] > 0.1
