"""Arcs on the circle, and the free flap angles of a front."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import patches

from solver import Front, Side
from solver.arcs import contain, free_arcs, united
from solver.transfer import transfer_flap_angles, transfer_matrices

ends = st.tuples(st.integers(0, 62), st.integers(0, 62)).filter(lambda e: e[0] != e[1])


def covers(arcs: np.ndarray, angle: float) -> bool:
    return bool(contain(arcs, np.array([angle]))[0])


@given(st.lists(ends, max_size=6))
def test_union_and_gaps_agree_with_counting(pairs):
    arcs = np.array(pairs, float).reshape(-1, 2) / 10
    union, free = united(arcs), free_arcs(arcs)
    for angle in np.arange(63) / 10 + 0.0503:
        angle %= 2 * np.pi
        assert covers(union, angle) == covers(arcs, angle)
        assert covers(free, angle) != covers(arcs, angle)
    assert len(united(union)) == len(union)


def test_angles_inside_arcs_past_zero():
    arcs = np.array([[6.0, 1.0], [2.0, 3.0]])
    angles = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.5, 6.0, 6.2])
    assert contain(arcs, angles).tolist() == [
        True,
        True,
        False,
        False,
        False,
        True,
        False,
        False,
        True,
    ]


def test_the_whole_circle_and_nothing():
    assert united(np.array([[0.0, 4.0], [3.0, 1.0]])).tolist() == [[0.0, 2 * np.pi]]
    assert free_arcs(np.array([[0.0, 4.0], [3.0, 1.0]])).shape == (0, 2)
    assert free_arcs(np.empty((0, 2))).tolist() == [[0.0, 2 * np.pi]]
    assert free_arcs(np.array([[6.0, 1.0]])).tolist() == [[1.0, 6.0]]


@given(patches())
def test_free_flap_angles_are_those_at_which_no_vertex_self_intersects(mesh):
    front = Front.of(mesh, Side.TOP)
    free = front.free_flap_angles()
    trials = np.random.default_rng(0).uniform(0, 2 * np.pi, 400)
    # and close to both sides of every end
    near = (free.ravel()[:, None] + [-1e-6, 1e-6]).ravel() % (2 * np.pi)
    trials = np.concatenate([trials, near])
    flap_angles = transfer_flap_angles(transfer_matrices(front.couplings, front.deltas), trials)
    expected = ~front.self_intersections(flap_angles).any(axis=0)
    found = np.array([covers(free, angle) for angle in trials.tolist()])
    assert (found == expected)[:400].all()
    # arcs narrower than the probe may lie between an end and its neighbour
    wide = all((e - s) % (2 * np.pi) > 1e-5 for s, e in free.tolist()) and len(free) < 2
    assert not wide or (found == expected).all()


def test_a_curve_leaves_every_flap_angle_free():
    line = np.array([[0.0, 0, 0], [1, 1, 0], [2, 0, 0]])
    free = Front.on_curve(line, np.pi).free_flap_angles()
    assert free == pytest.approx(np.array([[0, 2 * np.pi]]))
