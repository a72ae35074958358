"""The degree-4 vertex: closed form, inverse, and when faces cross."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import frames, vertices

from solver import Miura
from solver.errors import InvalidValue, OrigamiError
from solver.transfer import coupling
from solver.vectors import angle_between, cross, dot, unit
from solver.vertex import (
    continuation_flap_angles,
    design_angles,
    flap_angle_of,
    flat_foldable_flap_angles,
    growth_direction,
    locked_flap_angles,
    self_intersects,
)


def one(x: float) -> np.ndarray:
    return np.array([x])


@given(vertices(), frames())
def test_the_new_sectors_are_the_angles_of_the_direction_and_add_up_to_k(vertex, frame):
    beta, k, flap = vertex
    a, b = frame(beta)
    theta1, theta2 = design_angles(one(flap), one(beta), one(k))
    r = growth_direction(a, b, one(flap), one(k))
    assert theta1 + theta2 == pytest.approx(k, abs=1e-13)
    assert angle_between(a, r) == pytest.approx(theta1, abs=1e-12)
    # past pi the face right of the crease is reflex: its angle shows as 2 pi - theta2
    assert angle_between(b, r) == pytest.approx(min(theta2[0], 2 * np.pi - theta2[0]), abs=1e-7)
    assert 0 < theta1[0] < np.pi
    assert np.linalg.norm(r) == pytest.approx(1.0, abs=1e-14)


@given(vertices(), frames())
def test_the_flap_angle_of_the_direction_is_the_flap_angle(vertex, frame):
    beta, k, flap = vertex
    a, b = frame(beta)
    r = growth_direction(a, b, one(flap), one(k))
    back = flap_angle_of(a, b, r)[0]
    assert abs(np.angle(np.exp(1j * (back - flap)))) < 1e-10
    assert 0 <= back < 2 * np.pi


@pytest.mark.parametrize(
    ("flap_deg", "theta1_deg"),
    [
        # beta = k/2 = 90 degrees: on the great circle across, and in the plane on both sides
        (0.0, 135.0),
        (180.0, 45.0),
        (90.0, 90.0),
        (270.0, 90.0),
    ],
)
def test_design_angles_of_a_right_angled_front(flap_deg, theta1_deg):
    theta1, theta2 = design_angles(one(np.radians(flap_deg)), one(np.pi / 2), one(np.pi))
    assert np.degrees(theta1[0]) == pytest.approx(theta1_deg, abs=1e-12)
    assert np.degrees(theta2[0]) == pytest.approx(180 - theta1_deg, abs=1e-12)


@pytest.mark.parametrize(
    ("beta", "k"),
    [(0.0, 3.0), (np.pi, 3.2), (1.0, 1.0), (1.0, 0.5), (1.0, 2 * np.pi - 1.0), (np.nan, 3.0)],
)
def test_angles_outside_their_interval_are_refused_with_the_bound(beta, k):
    with pytest.raises(InvalidValue, match=r"lie strictly between .* rad \(.* deg\)") as caught:
        design_angles(one(1.0), one(beta), one(k))
    assert isinstance(caught.value, OrigamiError)
    assert isinstance(caught.value, ValueError)
    assert caught.value.name in ("beta[0]", "k[0]")
    assert caught.value.cure


def arcs_cross(p: np.ndarray, q: np.ndarray, r: np.ndarray, s: np.ndarray) -> bool:
    """Whether the great-circle arcs pq and rs cross in their interiors."""
    x = cross(cross(p, q), cross(r, s))
    for point in (unit(x), -unit(x)):
        inside = [
            dot(cross(u, point), cross(u, v)) > 0 and dot(cross(point, v), cross(u, v)) > 0
            for u, v in ((p, q), (r, s))
        ]
        if all(inside):
            return True
    return False


def test_self_intersection_agrees_with_crossing_arcs():
    random = np.random.default_rng(7)
    agreed = crossed = 0
    while agreed < 4000:
        a, b, c = unit(random.normal(size=(3, 3)))
        beta = angle_between(a, b)
        k = 2 * np.pi - angle_between(a, c) - angle_between(b, c)
        flap = random.uniform(0, 2 * np.pi)
        if not (beta + 0.02 < k < 2 * np.pi - beta - 0.02):
            continue
        r = growth_direction(a[None], b[None], one(flap), one(k))[0]
        if angle_between(a, r) + angle_between(r, b) < k - 1e-9:
            continue  # a sector over 180 degrees is no arc of its own
        left, right = locked_flap_angles(a[None], b[None], c[None], coupling(one(beta), one(k)))
        if min(abs(flap - left[0]), abs(flap - right[0]), abs(np.sin(flap))) < 1e-6:
            continue
        expected = arcs_cross(a, r, b, c) or arcs_cross(b, r, a, c)
        assert bool(self_intersects(one(flap), left, right)[0]) == expected
        agreed += 1
        crossed += expected
    assert 200 < crossed < 3800


def old_vertex(vertex, frame, lift):
    """Old creases a, b, c with their sectors theta3, theta4, and k with room to fold."""
    beta, _, flap = vertex
    a, b = frame(beta)
    c = unit(np.cos(flap) * a + np.sin(flap) * b + lift * unit(cross(a, b)))
    theta3, theta4 = angle_between(b, c), angle_between(a, c)
    k = 2 * np.pi - theta3 - theta4
    assume(beta + 0.02 < k[0] < 2 * np.pi - beta - 0.02)
    return a, b, c, theta3, theta4, k


def test_the_flat_foldable_flap_angle_of_a_miura_vertex_continues_the_sheet():
    mesh = Miura(columns=4, rows=3, fold=np.radians(50)).grow().mesh
    x, y, z = mesh.vertices_coords[mesh.grid[[1, 0, 2], 2]]
    a, b = mesh.vertices_coords[mesh.grid[1, [1, 3]]] - x
    a, b, c = (unit(w[None]) for w in (a, b, y - x))
    both = np.concatenate(flat_foldable_flap_angles(a, b, c))
    assert np.abs(both - flap_angle_of(a, b, (z - x)[None])).min() < 1e-12


@given(vertices(), frames(), st.floats(0.1, 3.0))
def test_special_flap_angles_are_what_they_say(vertex, frame, lift):
    a, b, c, theta3, theta4, k = old_vertex(vertex, frame, lift)
    n = unit(cross(a, b))
    straight, mirrored = continuation_flap_angles(a, b, c)
    assert growth_direction(a, b, straight, k) == pytest.approx(-c, abs=1e-9)
    image = -c + 2 * dot(c, n)[:, None] * n
    assert growth_direction(a, b, mirrored, k) == pytest.approx(image, abs=1e-9)
    for flat in flat_foldable_flap_angles(a, b, c):
        if np.isfinite(flat[0]) and abs(np.sin(flat[0])) > 1e-3:
            theta1, theta2 = design_angles(flat, angle_between(a, b), k)
            assert theta1 + theta3 == pytest.approx(np.pi, abs=1e-8)
            assert theta2 + theta4 == pytest.approx(np.pi, abs=1e-8)


@given(vertices(), frames(), st.floats(0.1, 3.0))
def test_locked_flap_angles_lay_a_new_face_onto_an_old_one(vertex, frame, lift):
    a, b, c, _, _, k = old_vertex(vertex, frame, lift)
    left, right = locked_flap_angles(a, b, c, coupling(angle_between(a, b), k))
    r = growth_direction(a, b, left, k)
    assert abs(dot(unit(cross(a, c)), r)[0]) < 1e-9
    r = growth_direction(a, b, right, k)
    assert abs(dot(unit(cross(b, c)), r)[0]) < 1e-7
