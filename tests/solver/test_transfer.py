"""The chain of flap angles along a strip."""

from math import atan2, cos, dist, pi, sin

import numpy as np
import pytest
from helpers import angle_at
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import curves, fronts, vertices

from solver import CurvedFold, Front, Side
from solver.transfer import (
    coupling,
    half_angles,
    inverse_matrices,
    loop_miss,
    transfer_derivative,
    transfer_each,
    transfer_flap_angles,
    transfer_matrices,
)
from solver.vertex import flap_angle_of


def circle_distance(x, y):
    return np.abs(np.angle(np.exp(1j * (np.asarray(x) - np.asarray(y)))))


def flap_angles(front: Front, first: float) -> np.ndarray:
    s, c = half_angles(front.couplings, front.deltas, first)
    return np.mod(2 * np.arctan2(s, c), 2 * np.pi)


@given(vertices())
def test_the_two_flap_angles_of_a_vertex_have_half_tangents_with_product_c(vertex):
    beta, k, flap = vertex
    if min(flap, abs(flap - np.pi), 2 * np.pi - flap) < 1e-3:
        return
    a = np.array([[1.0, 0.0, 0.0]])
    b = np.array([[np.cos(beta), np.sin(beta), 0.0]])
    front = Front.on_curve(np.concatenate([a, 0 * a, b]), k)
    r = front.rays(flap).directions[1]
    n = np.array([0.0, 0.0, 1.0])
    right = np.arctan2(r @ n, r @ np.cross(b[0], n))
    product = np.tan(flap / 2) * np.tan(right / 2)
    assert product == pytest.approx(coupling(np.array([beta]), np.array([k]))[0], rel=1e-8)


@given(fronts(), st.floats(0.0, 6.28))
def test_the_chain_is_what_the_grown_creases_measure(front, first):
    rays = front.rays(first)
    u = front.edges_direction
    measured = flap_angle_of(-u[:-1], u[1:], rays.directions[1:-1])
    assert circle_distance(rays.flap_angles, measured).max() < 1e-9


@given(fronts(), st.floats(0.0, 6.28))
def test_transfer_matrices_map_the_first_flap_angle_to_all_others(front, first):
    matrices = transfer_matrices(front.couplings, front.deltas)
    image = transfer_flap_angles(matrices, np.array([first, 1.0]))
    assert circle_distance(image[:, 0], flap_angles(front, first)).max() < 1e-9
    assert image[0] == pytest.approx([first, 1.0], abs=1e-12)


@given(fronts(), st.floats(0.0, 6.28))
def test_inverses_take_every_flap_angle_back_to_the_first(front, first):
    matrices = transfer_matrices(front.couplings, front.deltas)
    images = transfer_flap_angles(matrices, np.array([first]))
    back = transfer_each(inverse_matrices(matrices), images)[:, 0]
    slope = np.abs(transfer_derivative(matrices, np.array([first]))[:, 0])
    assert (circle_distance(back, first) < 1e-13 * (1 + 1 / slope)).all()


@given(fronts(), st.floats(0.0, 6.28))
def test_the_derivative_is_that_of_the_map(front, first):
    matrices = transfer_matrices(front.couplings, front.deltas)
    exact = transfer_derivative(matrices, np.array([first]))[:, 0]
    h = 1e-5 / np.abs(exact).max()
    low, high = transfer_flap_angles(matrices, np.array([first - h, first + h])).T
    difference = np.angle(np.exp(1j * (high - low))) / (2 * h)
    assert difference == pytest.approx(exact, rel=1e-4, abs=1e-6 * np.abs(exact).max())


@given(fronts(), st.floats(0.0, 6.28), st.data())
def test_a_flap_angle_given_anywhere_fixes_the_same_strip(front, first, data):
    every = flap_angles(front, first)
    at = data.draw(st.integers(0, len(every) - 1))
    s, c = half_angles(front.couplings, front.deltas, float(every[at]), at)
    assert circle_distance(2 * np.arctan2(s, c), every).max() < 1e-7


def torsion(p, q, r, s) -> float:
    """Angle about qr from the plane p, q, r to the plane q, r, s."""
    u, v, w = q - p, r - q, s - r
    m, n = np.cross(u, v), np.cross(v, w)
    return atan2(np.cross(m, n) @ v / dist(q, r), m @ n)


def by_trigonometry(x, k, first: float) -> tuple[list[float], float]:
    """Flap angles of a strip on the points x as equations S44 to S49 have them, and the least
    |sin theta2| met: digits are lost where it is small.
    """
    flap_angles, least = [first], 1.0
    for i in range(1, len(x) - 2):
        beta, alpha = angle_at(x[i - 1], x[i], x[i + 1]), flap_angles[-1]
        theta1 = atan2(cos(k[i - 1]) - cos(beta), sin(beta) * cos(alpha) - sin(k[i - 1])) % pi
        theta2 = k[i - 1] - theta1
        # the spherical triangle of a, b and the new crease: sides beta, theta1 and theta2
        sine = sin(theta1) * sin(alpha) / sin(theta2)
        cosine = (cos(theta1) * sin(beta) - sin(theta1) * cos(beta) * cos(alpha)) / sin(theta2)
        # flap angles are counted from planes that turn by the torsion of the front
        flap_angles.append(atan2(sine, cosine) + torsion(*x[i - 1 : i + 3]))
        least = min(least, abs(sin(theta2)))
    return flap_angles, least


@given(curves(), st.floats(0.01, 6.27))
def test_the_chain_is_the_trigonometric_recursion_of_the_paper(curve, first):
    front = Front.on_curve(*curve)
    expected, least = by_trigonometry(*curve, first)
    assume(least > 1e-3)
    # an error made at vertex j shows at vertex i stretched by the slopes of the steps between
    slopes = transfer_derivative(
        transfer_matrices(front.couplings, front.deltas), np.array([first])
    )[:, 0]
    stretch = np.cumsum(1 / np.abs(slopes)) * np.abs(slopes)
    off = circle_distance(flap_angles(front, first), expected)
    assert (off < 1e-13 * stretch / least).all()


@given(curves(), st.floats(0.01, 6.27))
def test_a_mirrored_front_turns_the_other_way(curve, first):
    points, k = curve
    straight = Front.on_curve(points, k)
    image = Front.on_curve(points * [1.0, 1.0, -1.0], k)
    # n = unit(a x b) turns over in a mirror, and so does the sense of the flap angle
    assert np.abs(image.deltas + straight.deltas).max(initial=0.0) < 1e-12
    back = -flap_angles(image, -first)
    assert circle_distance(flap_angles(straight, first), back).max() < 1e-9


def test_long_chains_stay_normalised():
    front = Front.of(
        CurvedFold(columns=2000, step=0.001, zigzag=0.002, strips=1, crease_length=0.001)
        .grow()
        .mesh,
        Side.TOP,
    )
    s, c = half_angles(front.couplings, front.deltas, 2.5)
    assert np.abs(np.hypot(s, c) - 1).max() < 1e-15 * 4
    assert np.isfinite(transfer_matrices(front.couplings, front.deltas)).all()


def test_chains_that_stretch_beyond_the_range_of_floats_are_followed():
    random = np.random.default_rng(0)
    couplings, deltas = np.full(4000, 1e6), random.uniform(0, 6, 3999)
    s, c = half_angles(couplings, deltas, 1.0)
    image = transfer_flap_angles(transfer_matrices(couplings, deltas), np.array([1.0]))[:, 0]
    assert np.isfinite(s).all()
    assert np.isfinite(c).all()
    assert circle_distance(2 * np.arctan2(s, c), image).max() < 1e-9


@given(curves(), st.floats(0.1, 6.18))
def test_a_loop_that_misses_itself_a_little_is_closed_by_its_spread(curve, first):
    front = Front.on_curve(*curve)
    assume(len(front.deltas) > 0)
    s, c = half_angles(front.couplings, front.deltas, first)
    # the closing delta for which this chain misses itself by one part in ten million
    miss, _ = loop_miss(front.couplings, 0.0, s, c)
    closing = 1e-7 - miss
    miss, spread = loop_miss(front.couplings, closing, s, c)
    assert miss == pytest.approx(1e-7, rel=1e-6)
    s, c = half_angles(front.couplings, front.deltas + spread, first)
    closed, _ = loop_miss(front.couplings, closing, s, c)
    # every delta changes by the same amount, and the closing one keeps its share
    share = abs(spread[0])
    assert np.ptp(np.abs(spread)) == 0
    assert 0 < share < 1e-7
    assert abs(abs(closed) - share) < 1e-10 * (1 + np.abs(s / c).max())
