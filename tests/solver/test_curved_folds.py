"""Curved folds along open and closed curves: which close, how they lie flat, and which do not."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fab.pattern.development import develop
from solver import (
    ClosedCurvedFold,
    CurvedFold,
    Front,
    InvalidValue,
    Status,
    developability,
    planarity,
)
from solver.designs.closed_curved_fold import CLOSED_CURVES, closed_zigzag
from solver.transfer import Closing
from solver.vectors import norm
from solver.vertex import flap_angle_of

GROWS = [
    ClosedCurvedFold("circle", 40, 0.05, np.radians(110), 0.12, 5),
    ClosedCurvedFold("ellipse", 60, 0.05, np.radians(125), 0.1, 8),
    ClosedCurvedFold("saddle", 80, 0.05, np.radians(120), 0.1, 8),
    ClosedCurvedFold("trefoil", 90, 0.08, np.radians(125), 0.15, 8),
    ClosedCurvedFold("figure_eight", 240, 0.05, np.radians(125), 0.1, 7),
]


def residual(mesh) -> float:
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    return max(planarity(coords, faces).max(), developability(coords, faces).max())


@pytest.mark.parametrize("design", GROWS, ids=lambda d: d.curve)
def test_closed_curves_grow_exactly_fold_and_lie_flat(design):
    growth = design.grow()
    mesh = growth.mesh
    assert growth.status is Status.GROWN
    assert mesh.closed
    assert mesh.grid.shape == (design.strips + 1, design.columns)
    assert residual(mesh) < 1e-13
    rows = mesh.vertices_coords[mesh.grid]
    for below, row, above in zip(rows, rows[1:], rows[2:], strict=False):
        front = Front.between(row, below, closed=True)
        a, b = -front.edges_direction[:-1], front.edges_direction[1:]
        flaps = flap_angle_of(a, b, above - row)
        assert not front.self_intersections(flaps[:, None]).any()
        # new folds: no crease continues the one behind it
        assert np.abs(flaps - flap_angle_of(a, b, -front.back)).min() > 0.01
    development = develop(mesh.cut_open())
    assert development.isometry_max_rel < 1e-11
    assert len(development.overlaps) == 0


@pytest.mark.parametrize("design", GROWS, ids=lambda d: d.curve)
def test_with_k_of_half_a_turn_the_flat_seed_is_a_straight_line(design):
    """The seed's vertices lie on a line in the plane, as far apart as its edges are long."""
    cut = design.grow().mesh.cut_open()
    front = develop(cut).vertices_coords[cut.grid[0]]
    loop = cut.vertices_coords[cut.grid[0]]
    along = (front - front[0]) @ (front[-1] - front[0]) / norm(front[-1] - front[0])
    lengths = np.concatenate([[0.0], np.cumsum(norm(np.diff(loop, axis=0)))])
    assert np.abs(along - lengths).max() < 1e-11 * lengths[-1]


@settings(max_examples=40)
@given(st.integers(0, 10**9), st.integers(6, 40))
def test_curves_turned_onto_themselves_close_for_every_flap_angle_and_others_for_none(seed, half):
    random = np.random.default_rng(seed)
    amplitudes = random.normal(size=(3, 3)) / np.arange(1, 4)[:, None] ** 2
    loop = closed_zigzag(amplitudes, 2 * half, 0.02)
    front = Front.on_curve(loop, np.pi, closed=True)
    assume(np.abs(np.sin(front.beta)).min() > 1e-2)
    assert front.closings().case is Closing.FAMILY
    for flap_angle in random.uniform(0, 2 * np.pi, 5):
        assert front.rays(flap_angle).closing_error < 1e-9
    moved = loop + 0.01 * random.normal(size=loop.shape)
    front = Front.on_curve(moved, np.pi, closed=True)
    assert front.closings().case is Closing.NONE
    assert front.rays(1.0).closing_error > 1e-9


def test_a_plane_zigzag_closes_lying_flat_alone_for_any_other_k():
    loop = closed_zigzag(CLOSED_CURVES["ellipse"], 60, 0.05)
    front = Front.on_curve(loop, np.radians(182), closed=True)
    closings = front.closings()
    assert closings.case is Closing.PAIR
    for at, flap_angle in closings.start:
        rays = front.rays(flap_angle, at=at + 1)
        assert np.abs(np.sin(rays.flap_angles)).max() < 1e-10


def test_a_half_twisted_zigzag_of_odd_count_lies_flat_somewhere():
    """Like a Moebius strip: the zigzag changes sides once around, and the sheet cannot.

    Flap angles lie above and below 180 degrees in turns; with an odd count they must pass 0 or
    180 somewhere, where the faces beside a crease fold onto each other.
    """
    around = 2 * np.pi * np.arange(241) / 241
    swing = 0.02 * (-1.0) ** np.arange(241)
    radius = 1 + swing * np.cos(around / 2)
    loop = np.column_stack(
        [radius * np.cos(around), radius * np.sin(around), swing * np.sin(around / 2)]
    )
    front = Front.on_curve(loop, np.pi, closed=True)
    closings = front.closings()
    assert closings.case is Closing.PAIR
    for at, flap_angle in closings.start:
        rays = front.rays(flap_angle, at=at + 1)
        assert rays.closing_error < 1e-12
        level = np.sin(rays.flap_angles)
        assert np.abs(level).min() < 0.1
        assert (level * np.roll(level, 1) > 0).sum() == 1


def test_a_closed_fold_that_would_cross_itself_stops_with_advice():
    growth = ClosedCurvedFold("saddle", 60, 0.06, np.radians(90), 0.1, 8).grow()
    assert growth.status is Status.FACES_CROSS
    assert 1 <= growth.strips < 8
    assert "flap angle" in growth.advice
    assert residual(growth.mesh) < 1e-13


@pytest.mark.parametrize("curve", ["arc", "parabola", "wave"])
def test_open_curves_grow_exactly_and_unroll_to_a_band(curve):
    growth = CurvedFold(curve, columns=60, k=np.radians(181), flap_angle=2.4, strips=6).grow()
    assert growth.status is Status.GROWN
    assert residual(growth.mesh) < 1e-13
    development = develop(growth.mesh)
    assert development.isometry_max_rel < 1e-11
    assert len(development.overlaps) == 0


@pytest.mark.parametrize(
    ("curve", "exact"),
    [
        ("parabola", lambda x, y: y - x**2),
        ("wave", lambda x, y: y - np.sin(np.pi * x) / 3),
        ("arc", lambda x, y: 0.75 - np.hypot(x, y - 0.75)),
    ],
)
def test_seeds_zigzag_about_their_curves(curve, exact):
    mesh = CurvedFold(curve, columns=20, step=0.1, zigzag=0.03, strips=1).grow().mesh
    x, y, z = mesh.vertices_coords[mesh.grid[0]].T
    assert exact(x, y) == pytest.approx(0.03 * (-1.0) ** np.arange(21), abs=1e-15)
    assert (z == 0).all()


@pytest.mark.parametrize(
    ("design", "name"),
    [
        (CurvedFold(curve="line"), "curve = line .* arc, parabola, wave"),
        (ClosedCurvedFold(curve="parabola"), "curve = parabola .* circle"),
        (ClosedCurvedFold(columns=2), "columns"),
        (ClosedCurvedFold(columns=61), "columns = 61 .* be even"),
        (ClosedCurvedFold(zigzag=0.0), "zigzag"),
        (ClosedCurvedFold(crease_length=np.nan), "crease_length"),
        (ClosedCurvedFold(crease_length=10.0), "length"),
    ],
)
def test_parameters_out_of_bounds_are_named(design, name):
    with pytest.raises(InvalidValue, match=name):
        design.grow()
