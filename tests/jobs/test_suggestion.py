"""Suggestions for patterns that fold further than thick panels of any size can."""

import numpy as np
import pytest
from flat_patterns import fan, grid, pattern_of
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.jobs.suggestion import suggested_window
from fab.panels.feasibility import Feasibility
from fab.panels.thick_sheet import thicken
from fab.printing.thick_settings import thick_settings


def book(width: float, angle: float = 180.0, letter: str = "V"):
    """Two triangles of a square, across its diagonal."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * width
    return pattern_of(corners, [[0, 1, 2], [0, 2, 3]], letter, angle=angle)


@given(
    st.floats(10, 500),
    st.sampled_from(["M", "V"]),
    st.sampled_from([["panels.axis=middle"], ["hinges.kind=film"], ["hinges.kind=none"]]),
)
@settings(max_examples=15, deadline=None)
def test_the_limit_is_the_largest_that_works_and_its_numbers_hold(width, letter, changes):
    pattern = book(width, letter=letter)
    tables = thick_settings(changes)
    window = suggested_window(pattern, tables)
    panel, hinge = tables.panels, tables.hinges
    if window.given is None:  # a panel that lies on the side that opens folds flat
        assert window.thickness_max_mm is not None
        return
    assert window.given.panels == 0
    assert window.limit_deg < 180
    here = panel.model_copy(update={"fold_limit_deg": window.limit_deg})
    size = 1.0 if window.panels == 2 else window.scale_min * (1 + 1e-6)
    feasible = Feasibility(book(width * size, letter=letter), here, hinge)
    assert feasible.faces_feasible().all()
    beyond = Feasibility(pattern, here, hinge).largest_limit_deg()
    if beyond is not None:
        assert window.limit_deg == pytest.approx(beyond, abs=0.1)
        assert not feasible.faces_feasible(limit_deg=beyond + 0.1).all()
    thinner = here.model_copy(update={"thickness_mm": 0.999 * window.thickness_max_mm})
    assert len(thicken(pattern, thinner, hinge)[0].panels.faces) == 2 or window.panels < 2


@pytest.mark.parametrize(
    "pattern", [book(200.0), fan(6, 100.0), grid(3, 3, 30.0)], ids=["book", "fan", "grid"]
)
def test_folds_that_no_panel_follows_get_useful_numbers(pattern):
    angles = np.where(pattern.edges_foldAngle != 0, np.sign(pattern.edges_foldAngle) * 180.0, 0.0)
    flat = pattern_of(
        pattern.vertices_coords,
        np.split(pattern.faces_vertices, pattern.faces_offsets[1:-1]),
        pattern.edges_assignment,
        angle=np.abs(angles),
    )
    window = suggested_window(flat, thick_settings(["panels.axis=middle"]))
    text = "\n".join(window.lines())
    assert window.given is not None
    assert f"fold_limit_deg = {window.limit_deg:g}, the largest that works" in text
    assert "no size" not in text.split("applies:")[1]
    assert window.thickness_max_mm
    assert window.panels == window.faces


def test_a_fold_within_reach_is_suggested_as_before():
    window = suggested_window(book(200.0, 90.0), thick_settings())
    assert window.given is None
    assert window.lines()[0].startswith("2 of 2 faces have a panel")
