"""Costs of flap angles: S30 against the published models and against its own definition."""

import numpy as np
import pytest
from helpers import published

from solver import Front, InvalidValue, Miura, Side, Status, SurfaceFit, developability, planarity
from solver.arcs import at_share, contain
from solver.flap_costs import DesignAngleCost
from solver.vectors import angle_between
from solver.vertex import flap_angle_of, flat_foldable_flap_angles


def published_fronts() -> list[tuple[Front, float]]:
    """The fronts of a published surface fit, grown either way, and the flap angles taken there."""
    fronts = []
    for rows in (published("peaks_coarse", "fold"), published("peaks_coarse", "fold")[::-1, ::-1]):
        for below, row, above in zip(rows, rows[1:], rows[2:], strict=False):
            front = Front.between(row, below)
            u = front.edges_direction
            fronts.append((front, float(flap_angle_of(-u[:1], u[1:2], (above - row)[1:2])[0])))
    return fronts


def test_every_strip_of_the_published_peaks_has_the_least_s30_of_all_free_flap_angles():
    fronts = published_fronts()
    assert len(fronts) == 64
    for front, flap_angle in fronts:
        best = DesignAngleCost.of(front).best_of(front.free_flap_angles())
        assert best == pytest.approx(flap_angle, abs=3e-6)


@pytest.mark.parametrize("seed", range(10))
def test_s30_is_its_definition_and_its_slope_the_derivative(seed):
    rng = np.random.default_rng(seed)
    mesh = Miura(columns=12, rows=2).grow().mesh
    rows = mesh.vertices_coords[mesh.grid]
    rows = rows + rng.normal(0, 0.05, rows.shape)
    front = Front.between(rows[1], rows[0])
    cost = DesignAngleCost.of(front)
    trials = rng.uniform(0, 2 * np.pi, 5)
    a, b = -front.edges_direction[:-1], front.edges_direction[1:]
    theta4, theta3 = angle_between(a, front.back), angle_between(b, front.back)
    for trial, value in zip(trials.tolist(), cost.cost(trials).tolist(), strict=True):
        inner = front.rays(trial).directions[1:-1]
        theta1, theta2 = angle_between(a, inner), angle_between(b, inner)
        assert value == pytest.approx(((theta1 - theta4) ** 2 + (theta2 - theta3) ** 2).sum())
        h = 1e-6
        below, above = cost.cost(np.array([trial - h, trial + h]))
        assert cost.slope(trial) == pytest.approx((above - below) / (2 * h), rel=1e-5, abs=1e-5)


def test_s30_folds_each_vertex_flat_where_one_flap_angle_does_it_for_all():
    rows = np.zeros((2, 8, 3))
    rows[:, :, 0] = np.arange(8)
    rows[:, :, 1] = 0.6 * (np.arange(8) % 2) + np.array([[0.0], [1.0]])
    rows[1, :, 2] = 0.4
    front = Front.between(rows[1], rows[0])
    best = DesignAngleCost.of(front).best_of(front.free_flap_angles())
    a, b = -front.edges_direction[:-1], front.edges_direction[1:]
    wanted = np.array(flat_foldable_flap_angles(a, b, front.back))
    off = np.abs(np.angle(np.exp(1j * (wanted - front.rays(best).flap_angles))))
    assert off.min(axis=0).max() < 1e-7


def test_sheets_grown_with_s30_are_exact_and_cover_the_surface():
    growth = SurfaceFit(zigzag=3.0, row_step=1.0, turn=0.0, cost="design_angles").grow()
    assert growth.status is Status.GROWN
    assert growth.coverage > 0.99
    coords, faces = growth.mesh.vertices_coords, growth.mesh.faces_vertices
    assert planarity(coords, faces).max() < 1e-12
    assert developability(coords, faces).max() < 1e-12
    front = Front.of(growth.mesh, Side.TOP)
    assert front.k.size == 39
    with pytest.raises(InvalidValue, match=r"cost = even .* mirror, design_angles"):
        SurfaceFit(cost="even").grow()


def test_shares_of_arcs_are_lengths_along_them():
    arcs = np.array([[6.0, 1.0], [2.0, 3.5], [4.0, 4.25]])
    sizes = np.array([1.0 + 2 * np.pi - 6.0, 1.5, 0.25])
    shares = (np.arange(4000) + 0.5) / 4000
    angles = np.array([at_share(arcs, share) for share in shares.tolist()])
    assert contain(arcs, angles).all()
    counts = [contain(arc[None], angles).sum() / 4000 for arc in arcs]
    assert counts == pytest.approx(sizes / sizes.sum(), abs=3e-4)
    assert at_share(np.array([[0.0, 2 * np.pi]]), 0.25) == pytest.approx(np.pi / 2)
