"""Closed fronts: fixed points of the loop, rings on planes, tubes and ribbons."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import published
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import frames, vertices

from fab.pattern.development import develop
from solver import (
    BrownianRibbon,
    Front,
    InvalidValue,
    QuadMesh,
    RandomTube,
    Side,
    Status,
    Strip,
    TiltedRings,
    developability,
    grow,
    planarity,
    seeds,
)
from solver.designs.brownian_ribbon import ribbon
from solver.transfer import (
    Closing,
    _fixed_direction,
    half_angles,
    loop_closings,
    loop_miss,
    loop_misses,
)
from solver.vectors import angle_between
from solver.vertex import design_angles, even_flap_angles, flap_angle_of, growth_direction


def random_loop(random: np.random.Generator, size: int) -> np.ndarray:
    around = 2 * np.pi * np.arange(size) / size
    loop = np.column_stack([np.cos(around), np.sin(around), 0 * around])
    return loop * (1 + 0.3 * random.random((size, 1))) + random.normal(0, 0.1, loop.shape)


def residual(mesh) -> float:
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    return max(planarity(coords, faces).max(), developability(coords, faces).max())


@given(st.integers(0, 10**9), st.integers(1, 30))
def test_odd_loops_close_for_exactly_two_flap_angles(seed, half):
    random = np.random.default_rng(seed)
    loop = random_loop(random, 2 * half + 1)
    front = Front.on_curve(loop, np.pi, closed=True)
    closings = front.closings()
    assert closings.case is Closing.PAIR
    assert closings.flap_angles[0] < closings.flap_angles[1]
    assume(closings.separation > 1e-3)
    for at, flap_angle in closings.start:
        assert front.rays(flap_angle, at=at + 1).closing_error < 1e-10
    # anywhere between the two roots the loop misses itself
    middle = float(closings.flap_angles.mean())
    assert front.rays(middle).closing_error > 1e-6


def test_the_roots_of_a_loop_of_two_vertices_in_one_plane():
    """Its half-angle matrix is diagonal, and each root the zero of one half-angle's function."""
    for continuation, other in ((np.pi, 0.0), (0.0, np.pi)):
        closings = loop_closings(np.array([2.0, 3.0]), np.zeros(2), continuation)
        assert closings.case is Closing.PAIR
        assert closings.flap_angles == pytest.approx([continuation, other], abs=1e-15)
        assert closings.separation == pytest.approx(np.pi)


def test_loops_that_stretch_beyond_the_range_of_floats_close():
    random = np.random.default_rng(0)
    couplings, deltas = np.full(2001, 1e6), random.uniform(0, 6, 2001)
    closings = loop_closings(couplings, deltas)
    for at, flap_angle in closings.start:
        s, c = half_angles(couplings, deltas[:-1], flap_angle, at)
        # one step stretches rounding by up to the coupling
        assert abs(loop_miss(couplings, deltas[-1], s, c)[0]) < 1e-15 * 1e6


@given(st.lists(st.integers(-12, 12), min_size=4, max_size=4))
def test_fixed_directions_are_eigenvectors(entries):
    loop = np.array(entries, float).reshape(2, 2) / 4
    vector = _fixed_direction(loop)
    if vector is None:
        assert np.abs(np.linalg.eigvals(loop).imag).min() > 0
    else:
        image = loop @ vector
        assert abs(image[0] * vector[1] - image[1] * vector[0]) < 1e-7 * (1 + np.abs(loop).max())


def hard_loop(random: np.random.Generator, shape: int, size: int) -> Front:
    """A wild, needle-like, nearly flat, smooth or knotted loop; k in 96 % of its interval."""
    around = 2 * np.pi * np.arange(size) / size
    circle = np.column_stack([np.cos(around), np.sin(around), 0 * around])
    loop = [
        lambda: random_loop(random, size),
        lambda: circle * [1, 10.0 ** random.uniform(-4, -1), 1] + random.normal(0, 1e-4, (size, 3)),
        lambda: circle + random.normal(0, 10.0 ** random.uniform(-9, -3), (size, 3)) * [0, 0, 1],
        lambda: circle + np.outer(0.3 * np.sin(3 * around + random.uniform(0, 6)), [0, 0, 1]),
        lambda: random.normal(size=(size, 3)),
    ][shape]()
    beta = Front.on_curve(loop, np.pi, closed=True).beta
    share = random.uniform(0.02, 0.98, size)
    return Front.on_curve(loop, beta + share * 2 * (np.pi - beta), closed=True)


@pytest.mark.parametrize("shape", range(5))
def test_a_thousand_random_odd_loops_close(shape):
    random = np.random.default_rng(shape)
    sizes = random.permutation(np.repeat([3, 5, 9, 21, 51, 201, 301], [50, 50, 40, 30, 20, 5, 5]))
    worst = 0.0
    for size in sizes.tolist():
        front = hard_loop(random, shape, size)
        closings = front.closings()
        assert closings.case is Closing.PAIR
        for (at, flap_angle), angle in zip(closings.start, closings.flap_angles, strict=True):
            rays = front.rays(flap_angle, at=at + 1)
            worst = max(worst, rays.closing_error)
            # the chain is that of this root, and not of the other one
            off = abs(np.angle(np.exp(1j * (rays.flap_angles[0] - angle))))
            assert off < max(1e-6, closings.separation / 2)
    assert worst < 1e-12


def test_the_continuation_is_a_root_and_the_other_follows_from_it():
    mesh = RandomTube(random_seed=3, strips=2).grow().mesh
    front = Front.of(mesh, Side.TOP)
    known = front.closings()
    deltas = np.append(front.deltas, front.closing_delta)
    solved = loop_closings(front.couplings, deltas)
    assert sorted(solved.flap_angles) == pytest.approx(sorted(known.flap_angles), abs=1e-8)
    at, flap_angle = known.start[0]
    rays = front.rays(flap_angle, at=at + 1)
    assert rays.directions == pytest.approx(-front.back, abs=1e-8)


def test_even_rings_on_planes_close_for_every_flap_angle():
    mesh = TiltedRings(strips=3).grow().mesh
    front = Front.of(mesh, Side.TOP)
    assert front.closings().case is Closing.FAMILY
    errors = [front.rays(flap).closing_error for flap in np.linspace(0.1, 6.2, 50)]
    assert max(errors) < 1e-12


def test_even_rings_off_planes_have_the_continuation_alone():
    """Over an unfolded cone, its upper edge cut slantwise so that it is no plane curve."""
    around = 2 * np.pi * np.arange(6) / 6
    slant = np.column_stack([np.cos(around), np.sin(around), 2 + 0 * around])
    reach = np.array([1.0, 1.3, 1.0, 1.2, 1.1, 1.4])[:, None]
    front = Front.between(slant * reach, slant * 0.5, closed=True)
    closings = front.closings()
    assert closings.case is Closing.CONTINUATION
    assert closings.separation < 1e-6


def test_a_flap_angle_that_does_not_close_stops_growth_with_advice():
    seed = QuadMesh.from_rows(random_loop(np.random.default_rng(0), 7)[None], closed=True)
    growth = grow(seed, 2, lambda front, strip: Strip(1.0, 0.1), k=np.pi)
    assert growth.status is Status.LOOP_NOT_CLOSED
    assert growth.strips == 0
    assert "loop_closings" in growth.advice


@given(vertices(), frames())
def test_even_flap_angles_give_even_sectors(vertex, frame):
    beta, k, _ = vertex
    for flap in even_flap_angles(np.array([beta]), np.array([k])):
        theta1, theta2 = design_angles(flap, np.array([beta]), np.array([k]))
        assert theta1 == pytest.approx(theta2, abs=1e-9)
        a, b = frame(beta)
        r = growth_direction(a, b, flap, np.array([k]))
        assert (r @ a.T).item() == pytest.approx((r @ b.T).item(), abs=1e-9)


@pytest.mark.parametrize(
    "design",
    [
        TiltedRings(strips=40),
        TiltedRings(sides=100, strips=17, height=1.0, height_growth=0.3, tilt=np.pi / 18),
        TiltedRings(sides=5, strips=20),
        TiltedRings(sides=30, strips=10, opening=0.3, tilt=0.0),
    ],
)
def test_rings_close_and_stay_planar(design):
    growth = design.grow()
    assert growth.status is Status.GROWN
    assert residual(growth.mesh) < 1e-12
    rings = growth.mesh.vertices_coords[growth.mesh.grid]
    for j, ring in enumerate(rings[2:], 1):
        turn = j * design.tilt
        distance = (-1) ** j * design.height * (1 + (j - 1) * design.height_growth) / 2
        off = ring @ [-np.sin(turn), 0, np.cos(turn)] - distance
        assert np.abs(off).max() < 1e-13 * np.abs(ring).max()


def test_the_first_ring_of_the_twisted_squares_is_the_published_one():
    """Published to the accuracy of its search: four vertices of F4B's third row."""
    rings = TiltedRings(strips=1).grow().mesh
    expected = [
        [0.08204556088392037, 0.0, -0.04857550581846807],
        [0.0, 0.08263876052418597, -0.05000761643519203],
        [-0.08324060042047269, 0.0, -0.05146058647518478],
        [0.0, -0.08263876049491072, -0.05000761636451540],
    ]
    assert rings.vertices_coords[rings.grid[2]] == pytest.approx(np.array(expected), abs=1e-8)


def test_the_second_ring_of_the_twisted_squares_is_the_published_one_with_its_cost():
    """Four vertices of F4B's fourth row; the cost of even sectors is 3e-4 off them."""
    expected = [
        [0.12048602911035844, -0.00032461722880544006, 0.054237948029182956],
        [-0.003806680894659934, 0.12405074899606, 0.04989754364478741],
        [-0.12746433164603407, 0.0003108542693798077, 0.045579316372823545],
        [-0.0031715965047444034, -0.12405074905226007, 0.049919721390085714],
    ]
    mesh = TiltedRings(strips=2, cost="neighbours").grow().mesh
    assert mesh.vertices_coords[mesh.grid[3]] == pytest.approx(np.array(expected), abs=2e-8)
    even = TiltedRings(strips=2).grow().mesh
    off = np.abs(even.vertices_coords[even.grid[3]] - np.array(expected)).max()
    assert 1e-4 < off < 1e-3


@pytest.mark.parametrize("sides", [4, 6, 20])
def test_rings_of_both_costs_have_their_least_cost_among_flap_angles_nearby(sides):
    """Each ring's flap angle against many others around it, by the definition of its cost."""
    for cost in ("even", "neighbours"):
        mesh = TiltedRings(sides=sides, strips=4, height=0.5, opening=0.2, cost=cost).grow().mesh
        rings = mesh.vertices_coords[mesh.grid]
        assert residual(mesh) < 1e-12
        for below, ring, above in zip(rings, rings[1:], rings[2:], strict=False):
            front = Front.between(ring, below, closed=True)
            a, b = -front.edges_direction[:-1], front.edges_direction[1:]

            def value(angle, front=front, a=a, b=b, cost=cost):
                directions = front.rays(angle).directions
                theta1, theta2 = angle_between(a, directions), angle_between(b, directions)
                if cost == "even":
                    return ((theta1 - theta2) ** 2).sum()
                return sum((np.diff(np.roll(t, -1)) ** 2).sum() for t in (theta1, theta2))

            flap_angle = float(flap_angle_of(a[:1], b[:1], above[:1] - ring[:1])[0])
            around = flap_angle + np.linspace(-1e-3, 1e-3, 101)
            least = min(value(angle) for angle in around)
            assert value(flap_angle) <= least + 1e-12 * (1 + least)


def test_a_closed_patch_is_cut_open_to_lie_flat():
    mesh = TiltedRings(strips=4).grow().mesh
    cut = mesh.cut_open()
    assert cut.grid.shape == (6, 5)
    assert len(cut.faces_vertices) == len(mesh.faces_vertices) == 20
    assert (cut.vertices_coords[cut.grid[:, 0]] == cut.vertices_coords[cut.grid[:, -1]]).all()
    assert (cut.edges.edges_faces[:, 1] < 0).sum() == (mesh.edges.edges_faces[:, 1] < 0).sum() + 10
    development = develop(cut)
    assert development.isometry_max_rel < 1e-10
    assert len(development.overlaps) == 0
    assert cut.cut_open() is cut
    with pytest.raises(InvalidValue, match="top or bottom"):
        mesh.front_vertices(Side.LEFT)


@pytest.mark.parametrize("random_seed", range(20))
def test_random_tubes_close_with_free_lengths(random_seed):
    growth = RandomTube(random_seed=random_seed).grow()
    assert growth.status is Status.GROWN
    assert residual(growth.mesh) < 1e-11
    assert growth.mesh.closed


def test_tubes_of_even_length_are_refused_with_the_cure():
    with pytest.raises(InvalidValue, match=r"sides = 8 .* be odd.*tilted_rings"):
        RandomTube(sides=8).grow()


@pytest.mark.parametrize("steps", [10, 400, 1000, 10000])
def test_brownian_ribbons_lie_flat_between_two_circles(steps):
    growth = BrownianRibbon(steps=steps, turn=np.radians(350)).grow()
    mesh = growth.mesh
    assert len(mesh.faces_vertices) == steps
    assert residual(mesh) < 1e-12
    development = develop(mesh)
    # rounding of coordinates over the ribbon's width, which is below their ten-millionth at last
    assert development.isometry_max_rel < (1e-10 if steps <= 1000 else 1e-9)
    flat = development.vertices_coords
    # the centre of the circle through three vertices of the walk
    p = flat[mesh.grid[0, [0, steps // 3, (2 * steps) // 3]]]
    system = 2 * (p[1:] - p[0]), (p[1:] ** 2).sum(axis=1) - (p[0] ** 2).sum()
    centre = np.linalg.solve(*system)
    for row in mesh.grid:
        radius = np.hypot(*(flat[row] - centre).T)
        assert np.ptp(radius) < 1e-9 * radius.mean()


def test_a_ribbon_of_given_radii_lies_flat_between_two_circles_of_their_ratio():
    design = BrownianRibbon(steps=400, turn=np.radians(340), random_seed=8, radius_ratio=0.99948)
    mesh = design.grow().mesh
    flat = develop(mesh).vertices_coords
    p = flat[mesh.grid[0, [0, 133, 266]]]
    system = 2 * (p[1:] - p[0]), (p[1:] ** 2).sum(axis=1) - (p[0] ** 2).sum()
    centre = np.linalg.solve(*system)
    outer, inner = (np.hypot(*(flat[row] - centre).T) for row in mesh.grid)
    assert inner / outer == pytest.approx(0.99948, abs=1e-9)
    shared = ribbon(
        mesh.vertices_coords[mesh.grid[0]], np.pi / 4, design.turn, radius_ratio=0.99948
    )
    assert np.array_equal(shared.mesh.vertices_coords, mesh.vertices_coords)
    with pytest.raises(InvalidValue, match=r"radius_ratio = 0.9 .* be above 0\.99\d+, below which"):
        replace(design, radius_ratio=0.9).grow()


def test_f4f_is_the_ribbon_along_its_own_walk():
    walk, other = published("F4F", "fold")
    flat = published("F4F", "flat")[..., :2]
    fit = np.column_stack([2 * flat[0], np.ones(401)])
    solved = np.linalg.lstsq(fit, (flat[0] ** 2).sum(axis=1), rcond=None)[0]
    ratio = np.hypot(*(flat[1] - solved[:2]).T).mean() / np.hypot(*(flat[0] - solved[:2]).T).mean()
    assert ratio == pytest.approx(0.99948, abs=5e-6)
    mesh = ribbon(walk, np.pi / 4, 2 * np.pi, radius_ratio=ratio).mesh
    assert np.abs(mesh.vertices_coords[mesh.grid[1]] - other).max() < 1e-8


@pytest.mark.parametrize(
    ("design", "name"),
    [
        (TiltedRings(sides=2), "sides"),
        (TiltedRings(height=0.0), "height"),
        (TiltedRings(cone_angle=4.0), "cone_angle"),
        (TiltedRings(tilt=7.0), "tilt"),
        (TiltedRings(opening=1.0), "opening"),
        (TiltedRings(height_growth=-2.0), "height_growth"),
        (TiltedRings(height_growth=None), "height_growth"),
        (TiltedRings(cost="odd"), "cost = odd .* even, neighbours"),
        (BrownianRibbon(radius_ratio=1.0), "radius_ratio"),
        (RandomTube(random_seed=None), "random_seed"),
        (BrownianRibbon(random_seed=1.5), "random_seed"),
        (BrownianRibbon(steps=10, flap_angle="1"), "flap_angle"),
        (RandomTube(jitter=0.9), "jitter"),
        (RandomTube(random_seed=-1), "random_seed"),
        (RandomTube(k=6.0), r"k\[0\]"),
        (BrownianRibbon(steps=2), "steps"),
        (BrownianRibbon(turn=7.0), "turn"),
        (BrownianRibbon(width_share=1.0), "width_share"),
    ],
)
def test_parameters_out_of_bounds_are_named(design, name):
    with pytest.raises(InvalidValue, match=name):
        design.grow()


def test_open_fronts_have_no_closings():
    mesh = seeds.miura(4, 1.0, 0.5, 1.0, 1.0)
    with pytest.raises(InvalidValue, match="the front is open"):
        Front.of(mesh, Side.TOP).closings()


def test_half_angles_begin_at_the_vertex_given():
    mesh = RandomTube(random_seed=1, strips=1).grow().mesh
    front = Front.of(mesh, Side.TOP)
    s, c = half_angles(front.couplings, front.deltas, 1.0, len(front.couplings) - 1)
    assert 2 * np.arctan2(s[-1], c[-1]) == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(20))
def test_misses_of_a_loop_are_those_of_its_chain_and_vanish_where_it_closes(seed):
    random = np.random.default_rng(seed)
    size = 5 + 2 * (seed % 4)
    couplings, deltas = random.uniform(0.3, 3.0, size), random.uniform(-1, 1, size)
    closings = loop_closings(couplings, deltas)
    np.testing.assert_allclose(loop_misses(couplings, deltas, closings.flap_angles), 0, atol=1e-9)
    trials = random.uniform(0, 2 * np.pi, 5)
    for trial, miss in zip(trials, loop_misses(couplings, deltas, trials), strict=True):
        s, c = half_angles(couplings, deltas[:-1], trial)
        assert miss == pytest.approx(loop_miss(couplings, deltas[-1], s, c)[0], abs=1e-9)
