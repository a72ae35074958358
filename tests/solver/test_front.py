"""Fronts: angles, rays and length bounds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import patches

from solver import Front, InvalidValue, QuadMesh, Side
from solver.vectors import angle_between, dot

ZIGZAG = np.array([[0.0, 0, 0], [1, 1, 0], [2, 0, 0], [3, 1, 0], [4, 0, 0]])
# as the row behind the zigzag: the quad at its first edge is reflex there
DARTS = np.array([[4.0, -1, 0], [2, 3, 0], [2, 0, 1], [3, 1, 1], [4, 0, 1]])
LIFTED = ZIGZAG + np.array([0.0, 1.0, 1.0])


def test_beta_and_k_of_a_zigzag_on_a_curve():
    front = Front.on_curve(ZIGZAG, np.radians(200))
    assert front.beta == pytest.approx(np.full(3, np.pi / 2), abs=1e-15)
    assert front.k == pytest.approx(np.full(3, np.radians(200)))
    # neighbouring beta planes are the same plane with opposite normals
    assert np.abs(front.deltas) == pytest.approx(np.full(2, np.pi), abs=1e-15)


def test_k_between_rows_is_what_the_old_sectors_leave():
    # old creases at 60 degrees to both sides of the peaks and at 120 degrees to those of the valley
    front = Front.between(ZIGZAG, ZIGZAG - [0.0, 1.0, 1.0])
    assert np.degrees(front.k) == pytest.approx([240.0, 120.0, 240.0], abs=1e-13)


@given(patches(), st.floats(0.1, 6.2))
def test_neighbouring_rays_are_coplanar_with_their_edge(mesh, flap):
    front = Front.of(mesh, Side.TOP)
    rays = front.rays(flap)
    r, e = rays.directions, front.edges_direction
    volume = dot(np.cross(r[:-1], r[1:]), e)
    assert np.abs(volume).max() < 1e-10


@given(patches(), st.floats(0.1, 6.2), st.floats(0.3, 2.8), st.floats(0.3, 2.8))
def test_boundary_angles_are_met_in_the_plane_of_the_first_and_last_quad(mesh, flap, left, right):
    front = Front.of(mesh, Side.TOP)
    rays = front.rays(flap, boundary_angles=(left, right))
    r, e = rays.directions, front.edges_direction
    assert angle_between(r[0], e[0]) == pytest.approx(left, abs=1e-10)
    assert angle_between(r[-1], -e[-1]) == pytest.approx(right, abs=1e-10)
    assert abs(np.cross(r[0], e[0]) @ r[1]) < 1e-10
    assert abs(np.cross(r[-1], e[-1]) @ r[-2]) < 1e-10
    # on the same side of the front as the neighbour
    assert np.cross(e[0], r[0]) @ np.cross(e[0], r[1]) > 0


@given(patches(), st.floats(0.1, 6.2))
def test_free_boundary_rays_are_parallel_to_their_neighbours(mesh, flap):
    rays = Front.of(mesh, Side.TOP).rays(flap)
    assert (rays.directions[0] == rays.directions[1]).all()
    assert (rays.directions[-1] == rays.directions[-2]).all()


@given(patches(), st.floats(0.1, 6.2))
def test_rays_meet_at_their_length_bounds(mesh, flap):
    """Brute force: where two coplanar rays meet, by least squares."""
    front = Front.of(mesh, Side.TOP)
    rays = front.rays(flap)
    x, r = front.vertices_coords, rays.directions
    expected = np.full(len(x), np.inf)
    for i in range(len(x) - 1):
        (s, t), *_ = np.linalg.lstsq(
            np.column_stack([r[i], -r[i + 1]]), x[i + 1] - x[i], rcond=None
        )
        gap = np.linalg.norm(x[i] + s * r[i] - x[i + 1] - t * r[i + 1])
        if s > 0 and t > 0 and gap < 1e-6:
            expected[i] = min(expected[i], s)
            expected[i + 1] = min(expected[i + 1], t)
    near = (expected < 1e3) | (rays.length_bounds < 1e3)
    assert rays.length_bounds[near] == pytest.approx(expected[near], rel=1e-5)


def test_a_front_of_three_vertices_has_one_flap_angle():
    front = Front.on_curve(ZIGZAG[:3], np.pi)
    rays = front.rays(np.pi / 2)
    assert rays.flap_angles == pytest.approx([np.pi / 2])
    # beta = 90, k = 180 degrees: the crease stands across the plane
    assert rays.directions[1] == pytest.approx([0, 0, -1]) or rays.directions[1] == pytest.approx(
        [0, 0, 1]
    )


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: Front.on_curve(ZIGZAG[:2], 3.0), "shape"),
        (lambda: Front.on_curve(ZIGZAG, np.full(2, 3.0)), r"shape \(3,\)"),
        (lambda: Front.on_curve(ZIGZAG, 1.0), r"k\[0\]"),
        (lambda: Front.on_curve(ZIGZAG * [1, 0, 0], 3.0), r"beta\[0\]"),
        (lambda: Front.on_curve(ZIGZAG[[0, 1, 1, 2]], 3.0), "front edge 1"),
        (lambda: Front.on_curve(ZIGZAG * np.nan, 3.0), "front: .* NaN"),
        (lambda: Front.between(ZIGZAG, ZIGZAG), "crease behind front vertex 1"),
        (lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, at=0), "1 to 3"),
        (lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, at=4), "1 to 3"),
        (lambda: Front.on_curve(ZIGZAG, 3.0).rays(np.inf), "finite"),
        (lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, boundary_angles=(0.0, None)), "left"),
        (lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, boundary_angles=(None, 4.0)), "right"),
        (lambda: Front.of(QuadMesh.from_rows(ZIGZAG[None]), Side.TOP), "be given for a curve"),
        (
            lambda: Front.of(
                QuadMesh.from_rows(np.stack([ZIGZAG, LIFTED])),
                Side.TOP,
                3.0,
            ),
            "left out",
        ),
        (lambda: Front.of(QuadMesh.from_rows(np.stack([DARTS, ZIGZAG])), Side.TOP), "reflex"),
    ],
)
def test_misuse_is_refused(call, match):
    with pytest.raises(InvalidValue, match=match):
        call()


@pytest.mark.parametrize(
    "call",
    [
        lambda: Front.on_curve("zigzag", 3.0),
        lambda: Front.on_curve(None, 3.0),
        lambda: Front.on_curve(ZIGZAG + 1j, 3.0),
        lambda: Front.on_curve(ZIGZAG[:, :2], 3.0),
        lambda: Front.on_curve([[0, 0, 0], [1, 1]], 3.0),
        lambda: Front.on_curve(ZIGZAG[:0], 3.0, closed=True),
        lambda: Front.on_curve(ZIGZAG[[0, 1, 2, 0]], 3.0, closed=True),
        lambda: Front.on_curve(ZIGZAG * 1e-150, 3.0),
        lambda: Front.on_curve(ZIGZAG * 1e150, 3.0),
        lambda: Front.on_curve(np.where(ZIGZAG == 4, np.inf, ZIGZAG), 3.0),
        lambda: Front.on_curve(ZIGZAG, "3"),
        lambda: Front.on_curve(ZIGZAG, np.nan),
        lambda: Front.on_curve(ZIGZAG, np.inf),
        lambda: Front.on_curve(ZIGZAG, -np.pi / 2),
        lambda: Front.on_curve(ZIGZAG, 3 + 0j),
        lambda: Front.between(ZIGZAG, ZIGZAG[:4]),
        lambda: Front.between(ZIGZAG, None),
        lambda: Front.between(ZIGZAG, LIFTED * 1e200),
        lambda: Front.between(
            ZIGZAG, np.where(LIFTED == 5, np.nan, LIFTED) * [[1], [1], [1], [1], [np.nan]]
        ),
        lambda: Front.of(QuadMesh.from_rows(np.stack([ZIGZAG, LIFTED])), "up"),
        lambda: Front.of(QuadMesh.from_rows(np.stack([ZIGZAG, LIFTED]) * 1e-60), Side.TOP),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays("1"),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(None),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(np.array([1.0])),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, at=1.5),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, at="1"),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, boundary_angles=None),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, boundary_angles=(1.0,)),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0, boundary_angles=("a", None)),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0).row([1.0, 2.0]),
        lambda: Front.on_curve(ZIGZAG, 3.0).rays(1.0).row("1"),
        lambda: Front.on_curve(ZIGZAG, 3.0).self_intersections(np.ones(3)),
        lambda: Front.on_curve(ZIGZAG, 3.0).away_from_back(np.ones((2, 3))),
    ],
)
def test_arguments_of_other_kinds_are_refused(call):
    with pytest.raises(InvalidValue):
        call()


@pytest.mark.parametrize("seed", range(20))
def test_fronts_without_room_up_to_rounding_are_refused(seed):
    """A flat sheet leaves k = beta or 2 pi - beta, a straight front beta = pi, but for rounding."""
    random = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    arc = np.linspace(0.3, 2.5, 3) + random.uniform(-0.3, 0.3, 3)
    arc = np.column_stack([np.cos(arc), np.sin(arc), 0 * arc])
    for size in (0.5, 2.0):
        with pytest.raises(InvalidValue, match=r"k\[\d\]"):
            Front.between(arc @ turn, size * arc @ turn)
    line = ZIGZAG[:3] * [random.uniform(0.5, 2), 0, 0]
    with pytest.raises(InvalidValue, match=r"beta\[\d\]"):
        Front.between(line @ turn, (line - [0.0, 1.0, 1.0]) @ turn)
    with pytest.raises(InvalidValue, match=r"beta\[\d\]"):
        Front.on_curve(line @ turn, np.pi)


def test_a_sheet_too_small_for_its_digits_is_refused_for_its_size():
    mesh = QuadMesh.from_rows(np.stack([ZIGZAG - [0.0, 1.0, 1.0], ZIGZAG]) * 1e-100)
    with pytest.raises(InvalidValue, match="length of front edge 0"):
        Front.of(mesh, Side.TOP)


def test_lists_integers_and_single_precision_are_the_same_front():
    known = Front.between(ZIGZAG, ZIGZAG - [0.0, 1.0, 1.0]).rays(1.0)
    for kind in (np.ndarray.tolist, lambda x: x.astype(int), lambda x: x.astype(np.float32)):
        rays = Front.between(kind(ZIGZAG), kind(ZIGZAG - [0.0, 1.0, 1.0])).rays(np.float64(1.0))
        assert (rays.row([0.1] * 5) == known.row(0.1)).all()


def test_fronts_and_rays_are_read_only_and_the_callers_array_is_left_alone():
    points = ZIGZAG.copy()
    front = Front.on_curve(points, 3.0)
    points[0] = 7  # the caller may go on
    for array in (front.vertices_coords, front.beta, front.rays(1.0).directions):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
