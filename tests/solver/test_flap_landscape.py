"""Landscapes of the flap angle, and what growth chose in them."""

import numpy as np
import pytest

from solver import (
    BrownianRibbon,
    Crumpled,
    CurvedFold,
    Front,
    InvalidState,
    Miura,
    Side,
    SurfaceFit,
    TiltedRings,
    seeds,
)
from solver.flap_landscape import flap_angle_landscape
from solver.growth_order import faces_strip, grown_strips


@pytest.fixture(scope="module")
def fit():
    """Figure 4A with the paper's cost S30."""
    design = SurfaceFit("waves", zigzag=3.0, row_step=1.0, turn=0.0, cost="design_angles")
    return design.grow().mesh


def test_the_least_cost_is_what_growth_chose_in_every_strip(fit):
    strips = grown_strips(fit, seed_rows=3)
    assert len(strips) == len(fit.grid) - 3
    for strip in strips:
        landscape = flap_angle_landscape(strip.front, flap_angles=90)
        miss = landscape.best - strip.flap_angle
        assert abs(np.remainder(miss + np.pi, 2 * np.pi) - np.pi) < 1e-9
        free = landscape.crossings == 0
        assert landscape.best_cost <= landscape.cost[free].min()


def test_constraints_are_kept_where_growth_went_and_broken_where_faces_cross(fit):
    strip = grown_strips(fit, seed_rows=3)[0]
    landscape = flap_angle_landscape(
        strip.front, lengths=strip.lengths, flap_angles=np.array([strip.flap_angle, 0.6, 3.5])
    )
    assert landscape.constraint.tolist()[0] == 0
    assert (landscape.constraint == landscape.crossings + landscape.unreached).all()
    flaps = [strip.front.rays(trial).flap_angles for trial in landscape.flap_angles]
    crossing = strip.front.self_intersections(np.column_stack(flaps)).sum(axis=0)
    np.testing.assert_array_equal(landscape.crossings, crossing)
    assert crossing.tolist() == [0, 0, 21]


def test_creases_that_reach_nothing_break_a_constraint(fit):
    front = grown_strips(fit, seed_rows=3)[0].front
    landscape = flap_angle_landscape(front, lengths=lambda rays: np.full(41, np.nan), flap_angles=4)
    assert landscape.unreached.tolist() == [41] * 4


def test_fronts_without_faces_behind_them_are_refused():
    zigzag = np.array([[0.0, 0, 0], [1, 1, 0], [2, 0, 0], [3, 1, 0]])
    with pytest.raises(InvalidState, match="the front is a curve"):
        flap_angle_landscape(Front.of(seeds.curve(zigzag), Side.TOP, np.radians(200)))


@pytest.mark.parametrize(
    ("design", "seed_rows"),
    [
        (Miura(columns=6, rows=5), 2),
        (Crumpled(columns=6, strips=5, random_seed=7), 2),
        (CurvedFold(columns=8, step=0.2, strips=4), 1),
        (BrownianRibbon(steps=10, turn=6.0), 1),
        (TiltedRings(sides=4, strips=5, opening=0.5), 2),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_sheet_is_replayed_strip_by_strip(design, seed_rows):
    mesh = design.grow().mesh
    strips = grown_strips(mesh, seed_rows)
    assert len(strips) == len(mesh.grid) - seed_rows
    for strip, row in zip(strips, mesh.grid[seed_rows:], strict=True):
        np.testing.assert_array_equal(strip.row, mesh.vertices_coords[row])
        np.testing.assert_allclose(strip.rays.row(strip.lengths), strip.row, atol=1e-9)
        assert (strip.lengths < strip.rays.length_bounds).all()


def test_strips_are_numbered_in_the_order_of_growth(fit):
    steps = faces_strip(fit)
    assert steps.tolist() == np.repeat(np.arange(44), 40).tolist()
    kept = np.ones((44, 40), bool)
    kept[:, :15] = False  # faces are numbered anew, from the bottom to the top
    middles = fit.with_faces(kept)
    assert np.bincount(faces_strip(middles)).tolist() == [25] * 44
    bottom = int(fit.grid[:, 0].argmin())
    assert faces_strip(middles)[25 * bottom] == 0
    ribbon = BrownianRibbon(steps=10, turn=6.0).grow().mesh
    assert faces_strip(ribbon).tolist() == list(range(10))


def test_sheets_with_ends_within_them_are_not_replayed(fit):
    kept = np.ones((44, 40), bool)
    kept[-1, -1] = False
    with pytest.raises(InvalidState, match="end within it"):
        grown_strips(fit.with_faces(kept))
