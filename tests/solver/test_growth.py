"""Growth: published models replayed, all sides, and how it stops."""

from itertools import permutations

import numpy as np
import pytest
from helpers import angle_at, published
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from strategies import curves, sheets

from solver import (
    CurvedFold,
    Front,
    InvalidValue,
    Miura,
    QuadMesh,
    Side,
    Status,
    Stop,
    Strip,
    developability,
    grow,
    planarity,
    seeds,
)
from solver.vectors import angle_between, norm
from solver.vertex import flap_angle_of


def choices(x, y, z, at):
    """Flap angle, boundary angles and lengths of a published strip from front x to row z."""
    u = Front.between(x, y).edges_direction
    r = z - x
    boundary = float(angle_between(r[0], u[0])), float(angle_between(r[-1], -u[-1]))
    return Strip(float(flap_angle_of(-u[at - 1], u[at], r[at])), norm(r), at, boundary)


@pytest.mark.parametrize("name", ["F4D", "F4E", "peaks_coarse"])
@pytest.mark.parametrize("place", ["first", "middle", "last"])
def test_published_strips_are_regrown_from_their_previous_rows(name, place):
    rows = published(name, "fold")
    last = rows.shape[1] - 2
    at = {"first": 1, "middle": last // 2, "last": last}[place]
    worst = 0.0
    for y, x, z in zip(rows[:-2], rows[1:-1], rows[2:], strict=True):
        # one published length is at its bound to the last digit, which `grow` refuses
        choice = choices(x, y, z, at)
        rays = Front.between(x, y).rays(
            choice.flap_angle, at=choice.at, boundary_angles=choice.boundary_angles
        )
        worst = max(worst, np.abs(rays.row(choice.lengths) - z).max())
    assert worst < 1e-11


def test_f4d_is_regrown_from_its_first_two_rows_alone():
    rows = published("F4D", "fold")
    seed = QuadMesh.from_rows(rows[:2])
    growth = grow(seed, 9, lambda front, strip: Strip(7 * np.pi / 8, 0.1))
    assert np.abs(growth.mesh.vertices_coords - rows.reshape(-1, 3)).max() < 1e-12


def room_to_fold(mesh: QuadMesh) -> float:
    """How far the fronts of all sides stay away from straight and from locked, radians."""
    try:
        fronts = [Front.of(mesh, side) for side in Side]
    except InvalidValue:
        return 0.0
    return min(
        min(np.sin(f.beta).min(), (f.k - f.beta).min(), (2 * np.pi - f.k - f.beta).min())
        for f in fronts
    )


def grown_with_most_room(mesh: QuadMesh, side: Side, boundary_angles) -> QuadMesh:
    front = Front.of(mesh, side)
    sheets = []
    for flap in np.linspace(0, 2 * np.pi, 31)[1:-1].tolist():
        bound = front.rays(flap, boundary_angles=boundary_angles).length_bounds.min()
        strip = Strip(flap, min(0.5, 0.4 * bound), boundary_angles=boundary_angles)
        sheets.append(grow(mesh, 1, lambda _front, _strip, strip=strip: strip, side=side).mesh)
    return max(sheets, key=room_to_fold)


@settings(max_examples=25)
@given(
    st.permutations([Side.TOP, Side.RIGHT, Side.BOTTOM, Side.LEFT]),
    st.floats(1.2, 1.5),
    st.floats(1.6, 1.9),
)
def test_a_patch_grows_on_all_sides_in_any_order(sides, left, right):
    mesh = Miura(columns=4, rows=3, fold=np.radians(40)).grow().mesh
    for side in sides:
        grown = grown_with_most_room(mesh, side, (left, right))
        assume(room_to_fold(grown) > 0.02)  # otherwise digits are lost
        assert (grown.vertices_coords[: len(mesh.vertices_coords)] == mesh.vertices_coords).all()
        mesh = grown
    assert mesh.grid.shape == (6, 7)
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-11
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-11


@pytest.mark.parametrize("sides", list(permutations(Side)), ids="-".join)
def test_every_order_of_the_four_sides_stays_exact(sides):
    seed = Miura(columns=3, rows=3, fold=np.radians(40)).grow().mesh
    mesh = seed
    for side in sides:
        mesh = grown_with_most_room(mesh, side, (1.35, 1.75))
        assert room_to_fold(mesh) > 0.01
    assert mesh.grid.shape == (6, 6)
    assert sorted(mesh.grid.ravel().tolist()) == list(range(36))
    assert (mesh.vertices_coords[:16] == seed.vertices_coords).all()
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12


def test_mirrored_input_and_flap_angles_give_the_mirrored_sheet():
    mirror = np.array([1.0, 1.0, -1.0])
    rows = CurvedFold(columns=12, strips=3).grow().mesh
    seed = rows.vertices_coords[rows.grid[:2]]

    def sheet(points, flap):
        growth = grow(QuadMesh.from_rows(points), 2, lambda front, strip: Strip(flap, 0.1))
        return growth.mesh.vertices_coords

    flap = 7 * np.pi / 8
    assert np.abs(sheet(seed * mirror, -flap) * mirror - sheet(seed, flap)).max() < 1e-13
    assert np.abs(sheet(seed * mirror, flap) * mirror - sheet(seed, flap)).max() > 1e-3


@given(curves(), st.floats(0.1, 6.18), st.integers(0, 2**32 - 1))
def test_growth_moves_turns_grows_and_mirrors_with_its_seed(curve, flap, seed):
    points, k = curve
    motion, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    handed = np.sign(np.linalg.det(motion))

    def sheet(points, flap, size):
        # the middle vertex leads, so that errors have few vertices to grow on
        at = 1 + len(k) // 2
        strip = Strip(flap, lambda rays: 0.3 * rays.length_bounds.clip(max=size), at)
        return grow(seeds.curve(points), 2, lambda front, j: strip, k=k).mesh

    original = sheet(points, flap, 1.0)
    transformed = sheet(4 * points @ motion + 7.0, handed * flap, 4.0)
    assert original.grid.shape == transformed.grid.shape
    moved = 4 * original.vertices_coords @ motion + 7.0
    assert np.abs(transformed.vertices_coords - moved).max() < 1e-9


@given(sheets())
def test_sectors_around_every_interior_vertex_add_up_to_a_full_turn(mesh):
    total = np.zeros(len(mesh.vertices_coords))
    for face in mesh.faces_vertices.tolist():
        corners = mesh.vertices_coords[face]
        sectors = np.array([angle_at(*corners[[i - 1, i, (i + 1) % 4]].tolist()) for i in range(4)])
        # the sectors of a plane quad add up to 2 pi: what is missing marks the reflex one
        missing = 2 * np.pi - sectors.sum()
        i = int(np.argmin(np.abs(2 * (np.pi - sectors) - missing)))
        sectors[i] += missing if missing > 1e-3 else 0.0
        total[face] += sectors
    assert total[mesh.grid[1:-1, 1:-1]] == pytest.approx(2 * np.pi, abs=1e-6)


def miura_flap(front: Front, strip: int) -> float:
    u = front.edges_direction
    lean = np.sqrt(1 - np.sin(np.radians(45)) ** 2 * np.sin(np.radians(60)) ** 2)
    height = np.sin(np.radians(45)) * np.sin(np.radians(60))
    crease = np.array([0.0, lean, height if strip % 2 else -height])
    return float(flap_angle_of(-u[0], u[1], crease))


def test_growth_that_stops_keeps_what_it_has_and_says_why():
    wanted = 200
    seed = seeds.miura(20, np.radians(60), np.radians(45), 1.0, 1.0)
    # a Miura sheet with lengths given as numbers: rounding errors grow until rows collide
    growth = grow(seed, wanted, lambda front, strip: Strip(miura_flap(front, strip), 1.0))
    assert growth.status in (Status.LENGTH_OVER_BOUND, Status.FRONT_NOT_FOLDABLE)
    assert 20 <= growth.strips < wanted
    assert len(growth.mesh.faces_vertices) == 20 * (growth.strips + 1)
    assert f"of {wanted}" in growth.advice
    assert developability(growth.mesh.vertices_coords, growth.mesh.faces_vertices).max() < 1e-9


def test_a_seed_that_cannot_grow_says_why():
    with pytest.raises(InvalidValue, match=r"k\[0\]"):
        CurvedFold(k=0.01).grow()
    seed = seeds.miura(4, np.radians(60), np.radians(45), 1.0, 1.0)
    closing = Strip(2.5, 1000.0, boundary_angles=(1.0, 1.0))
    with pytest.raises(InvalidValue, match=r"length\[\d+\].*be below"):
        grow(seed, 1, lambda front, strip: closing)


@pytest.mark.parametrize("lengths", [0.0, -1.0, np.nan, np.inf, 1e-30, 1e300])
def test_bad_lengths_are_refused(lengths):
    seed = seeds.miura(4, 1.0, 0.7, 1.0, 1.0)
    with pytest.raises(InvalidValue, match=r"length\[0\]"):
        grow(seed, 1, lambda front, strip: Strip(1.0, lengths))


@pytest.mark.parametrize(
    "choice",
    [
        None,
        (1.0, 0.1),
        Strip("1", 0.1),
        Strip(1.0, "0.1"),
        Strip(1.0, None),
        Strip(1.0, np.full(4, 0.1)),
        Strip(1.0, lambda rays: None),
        Strip(1.0, lambda rays: rays.directions),
        Strip(1.0, 0.1, at=0),
        Strip(1.0, 0.1, at=2.0),
        Strip(1.0, 0.1, boundary_angles=None),
    ],
)
@pytest.mark.parametrize("good", [0, 1])
def test_choices_of_other_kinds_are_refused(choice, good):
    seed = seeds.miura(4, 1.0, 0.7, 1.0, 1.0)
    strips = [Strip(1.0, 0.1)] * good + [choice]
    with pytest.raises(InvalidValue):
        grow(seed, 2, lambda front, strip: strips[strip])


@pytest.mark.parametrize("strips", [0, -1, 1.5, 2.0, "2", None, True, np.nan, 10**9])
def test_strips_are_counted_in_whole_numbers(strips):
    seed = seeds.miura(4, 1.0, 0.7, 1.0, 1.0)
    with pytest.raises(InvalidValue, match=r"strips|quads"):
        grow(seed, strips, lambda front, strip: Strip(1.0, 0.1))


def test_a_choice_to_stop_keeps_the_strips_before_it():
    seed = seeds.miura(4, 1.0, 0.7, 1.0, 1.0)
    choices = [Strip(1.0, 0.1), Strip(1.0, 0.1), Stop(Status.COVERED, "enough")]
    growth = grow(seed, 9, lambda front, strip: choices[strip])
    assert (growth.status, growth.strips, growth.advice) == (Status.COVERED, 2, "enough")
    assert growth.mesh.grid.shape == (4, 5)
    assert len(growth.mesh.vertices_coords) == 20


@pytest.mark.parametrize("scale", [1e-40, 1e-12, 1e12, 1e40])
def test_sheets_of_any_size_are_the_same_sheet(scale):
    seed = seeds.miura(4, 1.0, 0.7, 1.0, 1.0).vertices_coords.reshape(2, 5, 3)
    one, other = (
        grow(QuadMesh.from_rows(s * seed), 3, lambda f, j, s=s: Strip(1.0, 0.1 * s)).mesh
        for s in (1.0, scale)
    )
    assert other.vertices_coords / scale == pytest.approx(one.vertices_coords, abs=1e-12)
    assert developability(other.vertices_coords, other.faces_vertices).max() < 1e-13


def test_progress_is_reported_after_every_strip():
    reported = []
    Miura(columns=4, rows=5).grow(lambda done, total: reported.append((done, total)))
    assert reported == [(1, 4), (2, 4), (3, 4), (4, 4)]
