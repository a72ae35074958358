"""Growth whose rows may end: fronts that narrow, and the sheets that come of it."""

from dataclasses import replace

import numpy as np
import pytest

from fab.pattern.development import develop
from solver import (
    Front,
    InvalidValue,
    ParametricSurface,
    QuadMesh,
    RandomTube,
    Side,
    Status,
    Stop,
    Strip,
    SurfaceFit,
    developability,
    explicit_surface,
    fit_surface,
    grow,
    planarity,
    seeds,
)
from solver.coverage import one_piece
from solver.ending_rows import grow_ending, longest_run
from solver.mesh import boundary_loops


def cap(degrees: float) -> ParametricSurface:
    """A cap of the unit sphere over a round domain, of this half angle."""
    half = np.radians(degrees)

    def position(u, v):
        r = np.hypot(u, v)
        spread = half * np.sinc(half * r / np.pi)
        return np.column_stack([spread * u, spread * v, np.cos(half * r)])

    return ParametricSurface(position, None, lambda u, v: u**2 + v**2 <= 1)


class Refusing:
    """Grows a Miura seed with one length, but for vertices of given columns from given strips on.

    refused : for each strip the columns that have no length there.
    """

    def __init__(self, refused: dict[int, list[int]], columns: int) -> None:
        self.refused = refused
        self.columns = np.arange(columns)
        self.narrowed: list[tuple[int, int, int]] = []

    def choose(self, front: Front, strip: int) -> Strip | Stop:
        assert len(front.vertices_coords) == len(self.columns)
        lengths = np.where(np.isin(self.columns, self.refused.get(strip, [])), np.nan, 0.3)
        return Strip(2.0, lengths)

    def narrow(self, strip: int, first: int, last: int) -> None:
        self.narrowed.append((strip, first, last))
        self.columns = self.columns[first:last]


def seed() -> QuadMesh:
    return seeds.miura(9, 1.0, 0.5, 1.0, 1.0)


def held(mesh: QuadMesh) -> list[tuple[int, int]]:
    """First and last column of each row of the grid that has a vertex."""
    return [(int(np.flatnonzero(row)[0]), int(np.flatnonzero(row)[-1])) for row in mesh.grid >= 0]


def test_whole_rows_are_those_of_plain_growth_to_the_last_bit():
    ended = grow_ending(seed(), 4, Refusing({}, 10))
    plain = grow(seed(), 4, lambda front, strip: Strip(2.0, 0.3))
    assert np.array_equal(ended.growth.mesh.vertices_coords, plain.mesh.vertices_coords)
    assert np.array_equal(ended.growth.mesh.faces_vertices, plain.mesh.faces_vertices)
    assert (ended.growth.status, ended.growth.strips) == (Status.GROWN, 4)
    assert ended.firsts == (0, 0, 0, 0)
    assert ended.ended is None


@pytest.mark.parametrize("side", [Side.TOP, Side.BOTTOM])
def test_rows_end_where_vertices_are_refused_and_the_others_stay_exact(side):
    chooser = Refusing({1: [0, 1], 2: [9], 3: [4]}, 10)
    ended = grow_ending(seed(), 4, chooser, side=side)
    assert chooser.narrowed == [(1, 2, 10), (2, 0, 7), (3, 3, 7)]
    assert ended.firsts == (0, 2, 2, 5)
    assert ended.ended is not None
    assert ended.ended.status is Status.LENGTH_NOT_POSITIVE
    assert "Strip 2 of 4: at front vertex 0" in ended.ended.advice
    mesh = ended.growth.mesh
    rows = [(0, 9), (0, 9), (0, 9), (2, 9), (2, 8), (5, 8)]
    if side is Side.BOTTOM:  # its front runs the other way
        rows = [(9 - last, 9 - first) for first, last in reversed(rows)]
    assert held(mesh) == rows
    assert len(mesh.faces_vertices) == 9 + 9 + 7 + 6 + 3
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-14
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-14
    assert len(boundary_loops(mesh.edges)) == 1
    assert develop(mesh).isometry_max_rel < 1e-12


def test_a_front_of_three_vertices_is_the_end():
    ended = grow_ending(seed(), 4, Refusing({1: [3, 7]}, 10))
    assert (ended.growth.status, ended.growth.strips) == (Status.LENGTH_NOT_POSITIVE, 1)
    assert ended.ended is None
    assert held(ended.growth.mesh) == [(0, 9)] * 3


def test_what_the_chooser_stops_is_no_reason_to_narrow():
    class Done(Refusing):
        def choose(self, front, strip):
            return Stop(Status.COVERED, "done") if strip else super().choose(front, strip)

    ended = grow_ending(seed(), 4, Done({}, 10))
    assert (ended.growth.status, ended.growth.strips, ended.growth.advice) == ("covered", 1, "done")
    assert ended.ended is None


@pytest.mark.parametrize("trim", [False, True])
def test_a_cap_whose_fronts_stop_is_covered_where_rows_may_end(trim):
    """Every vertex is on its offset: at one of two distances from the middle of the sphere."""
    given = {"zigzag": 5.0, "row_step": 1.4, "turn": 0.0, "trim": trim}
    stopped = fit_surface(cap(50), 16, **given)
    assert stopped.status is Status.LENGTH_NOT_POSITIVE
    assert stopped.coverage < 0.8
    growth = fit_surface(cap(50), 16, **given, rows_may_end=True)
    assert growth.status is Status.GROWN
    assert growth.coverage > 0.975
    mesh = growth.mesh
    there = mesh.grid >= 0
    assert not there.all()
    assert np.array_equal(np.sort(mesh.grid[there]), np.arange(len(mesh.vertices_coords)))
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-13
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-13
    assert len(boundary_loops(mesh.edges)) == 1
    assert develop(mesh).isometry_max_rel < 1e-11
    radius = np.linalg.norm(mesh.vertices_coords, axis=1) - 1
    rows = [radius[row[row >= 0]] for row in mesh.grid]
    side = np.sign(rows[0][0]) * (-1.0) ** np.arange(len(rows))
    level = np.concatenate([row * s for row, s in zip(rows, side, strict=True)])
    assert np.ptp(level) < 1e-10
    assert level.min() > 0.01


def test_a_sheet_whose_rows_ended_short_of_its_surface_says_so():
    growth = fit_surface(cap(60), 16, zigzag=5.0, row_step=1.0, turn=0.0, rows_may_end=True)
    stopped = fit_surface(cap(60), 16, zigzag=5.0, row_step=1.0, turn=0.0)
    assert growth.status is stopped.status is Status.LENGTH_NOT_POSITIVE
    assert growth.coverage > stopped.coverage + 0.2
    assert "the length must be" in growth.advice


def test_lookahead_grows_a_bump_whose_first_strip_has_no_length():
    bump = explicit_surface(lambda x, y: 0.45 * np.exp(-(x**2 + y**2) / 0.6))
    given = {"zigzag": 5.0, "row_step": 1.4, "turn": 0.0}
    with pytest.raises(InvalidValue, match=r"length\[8\] = nan"):
        fit_surface(bump, 16, **given)
    growth = fit_surface(bump, 16, **given, lookahead=True)
    assert growth.status is Status.GROWN
    assert growth.coverage > 0.99
    assert (growth.mesh.grid >= 0).all()
    assert planarity(growth.mesh.vertices_coords, growth.mesh.faces_vertices).max() < 1e-13
    assert developability(growth.mesh.vertices_coords, growth.mesh.faces_vertices).max() < 1e-13


def test_sheets_that_grow_whole_are_the_same_with_both_options():
    design = SurfaceFit("paraboloid", columns=20, zigzag=3.0, row_step=1.0, turn=0.0, trim=True)
    plain = design.grow()
    assert plain.status is Status.GROWN
    other = replace(design, rows_may_end=True, lookahead=True).grow()
    assert np.array_equal(plain.mesh.vertices_coords, other.mesh.vertices_coords)
    assert np.array_equal(plain.mesh.grid, other.mesh.grid)
    assert (plain.status, plain.coverage, plain.chosen) == (
        other.status,
        other.coverage,
        other.chosen,
    )


def test_rows_of_rings_and_curves_do_not_end():
    ring = RandomTube(strips=1).grow().mesh
    curve = QuadMesh.from_rows(np.random.default_rng(0).normal(size=(1, 6, 3)))
    for mesh in (ring, curve):
        with pytest.raises(InvalidValue, match="rows may end on open patches with faces alone"):
            grow_ending(mesh, 1, Refusing({}, 10))


def test_the_longest_run():
    assert longest_run(np.array([True, True, False, True, True, True])) == (3, 6)
    assert longest_run(np.zeros(4, bool)) == (0, 0)
    assert longest_run(np.ones(4, bool)) == (0, 4)


def test_a_corner_is_filled_by_the_cell_that_exists():
    kept = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 0]], bool)
    assert one_piece(kept).astype(int).tolist() == [[1, 1, 1], [1, 1, 1], [1, 1, 0]]
    cells = np.ones((3, 3), bool)
    cells[1, 1] = False
    assert one_piece(kept, cells).astype(int).tolist() == [[1, 1, 1], [1, 0, 1], [1, 1, 1]]
    assert one_piece(kept[:, ::-1], cells).astype(int).tolist() == [[1, 1, 1], [1, 0, 1], [1, 1, 1]]
