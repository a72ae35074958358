"""Planar graphs of lines: exact ones against shapely, repairs, and what must not change them."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fab.geometry.arrangement import arrangement
from solver.errors import InvalidState

SQUARE = [[[0, 0], [100, 0]], [[100, 0], [100, 100]], [[100, 100], [0, 100]], [[0, 100], [0, 0]]]


def graph_of(lines, tolerance=0.0):
    found = arrangement(np.array(lines, float), tolerance)
    assert found.settled
    require_planar(found)
    return found


def require_planar(found):
    """No two edges meet but in a common vertex, by shapely's own test."""
    pairs = np.sort(found.edges_vertices, axis=1)
    assert (pairs[:, 0] != pairs[:, 1]).all()
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    assert len(np.unique(found.vertices_coords, axis=0)) == len(found.vertices_coords)
    shapes = shapely.linestrings(found.vertices_coords[found.edges_vertices])
    first, second = shapely.STRtree(shapes).query(shapes, predicate="crosses")
    assert not len(first), (found.edges_vertices[first], found.edges_vertices[second])


def parts(found):
    """Edges by their places, each with the lines that it is a part of."""
    places = [tuple(point) for point in np.round(found.vertices_coords, 9).tolist()]
    return {
        frozenset((places[a], places[b])): frozenset(
            found.edges_lines[found.edges_offsets[e] : found.edges_offsets[e + 1]].tolist()
        )
        for e, (a, b) in enumerate(found.edges_vertices.tolist())
    }


# Lines along the axes and diagonals of a lattice with even coordinates cross at whole numbers.
STEPS = np.array([[1, 0], [0, 1], [1, 1], [1, -1]])


@st.composite
def lattice_lines(draw):
    count = draw(st.integers(1, 14))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    start = 2 * random.integers(-6, 7, (count, 2))
    step = STEPS[random.integers(0, 4, count)] * random.choice([-1, 1], (count, 1))
    return np.stack([start, start + 2 * step * random.integers(0, 7, (count, 1))], 1).astype(float)


@given(lattice_lines())
def test_exact_lines_give_the_graph_that_shapely_gives(lines):
    found = graph_of(lines)
    real = lines[(lines[:, 0] != lines[:, 1]).any(axis=1)]
    noded = shapely.node(shapely.multilinestrings(shapely.linestrings(real))) if len(real) else None
    expected = set()
    for part in [] if noded is None else shapely.get_parts(noded):
        corners = [tuple(point) for point in shapely.get_coordinates(part).tolist()]
        expected |= {frozenset(pair) for pair in pairwise(corners)}
    assert set(parts(found)) == expected
    assert (found.ends_moved == 0).all()
    for line, (start, end) in enumerate(lines.tolist()):
        own = [edge for edge, of in parts(found).items() if line in of]
        length = sum(float(np.hypot(*np.subtract(*edge))) for edge in own)
        assert length == pytest.approx(float(np.hypot(*np.subtract(start, end))))


@given(st.integers(0, 2**32 - 1), st.integers(1, 25))
def test_random_lines_cover_what_their_union_covers(seed, count):
    lines = np.random.default_rng(seed).uniform(0, 1, (count, 2, 2))
    found = graph_of(lines)
    union = shapely.unary_union(shapely.linestrings(lines))
    edges = found.vertices_coords[found.edges_vertices]
    length = np.hypot(*(edges[:, 0] - edges[:, 1]).T).sum()
    assert length == pytest.approx(union.length, rel=1e-9)
    crossings = sum(
        shapely.crosses(*shapely.linestrings(lines[[i, j]])) for i in range(count) for j in range(i)
    )
    assert [len(of) for of in found.crossings()] == [crossings, 0]
    assert len(found.edges_vertices) == count + 2 * crossings


def loose_lines(seed, count):
    """Lines that miss each other by up to 0.05 on a sheet of 100 mm, their ends on a lattice."""
    random = np.random.default_rng(seed)
    lines = random.integers(0, 6, (count, 2, 2)) * 20.0
    return lines + random.uniform(-0.02, 0.02, lines.shape)


@given(st.integers(0, 2**32 - 1), st.integers(2, 12))
def test_order_direction_and_place_of_lines_do_not_matter(seed, count):
    lines = loose_lines(seed, count)
    lines = lines[np.hypot(*(lines[:, 0] - lines[:, 1]).T) > 1]
    if not len(lines):
        return
    found = graph_of(lines, 0.08)
    random = np.random.default_rng(seed)
    order = random.permutation(len(lines))
    mixed = lines[order]
    turned = random.random(len(lines)) < 0.5
    mixed[turned] = mixed[turned, ::-1]
    again = graph_of(mixed, 0.08)
    renamed = {
        edge: frozenset(int(order[line]) for line in of) for edge, of in parts(again).items()
    }
    assert renamed == parts(found)
    assert again.vertices_coords[again.ends_vertex[turned, 0]] == pytest.approx(
        found.vertices_coords[found.ends_vertex[order[turned], 1]]
    )
    shift = np.array([512.0, -256.0])
    moved = graph_of(lines + shift, 0.08)
    assert np.array_equal(moved.edges_vertices, found.edges_vertices)
    assert np.array_equal(moved.edges_lines, found.edges_lines)
    assert moved.vertices_coords - shift == pytest.approx(found.vertices_coords, abs=1e-9)


@given(st.integers(0, 2**32 - 1), st.integers(2, 12))
def test_edges_stay_near_their_lines_and_a_second_pass_changes_nothing(seed, count):
    lines = loose_lines(seed, count)
    found = graph_of(lines, 0.08)
    shapes = shapely.linestrings(lines)
    edges = shapely.linestrings(found.vertices_coords[found.edges_vertices])
    line, edge = found.line_pairs
    assert (
        shapely.hausdorff_distance(
            edges[edge], shapely.intersection(shapely.buffer(shapes[line], 0.5), edges[edge])
        )
        < 1e-9
    ).all()
    again = graph_of(found.vertices_coords[found.edges_vertices], 0.0)
    assert set(parts(again)) == set(parts(found))
    assert (again.ends_moved == 0).all()


@pytest.mark.parametrize("off", [-0.05, -1e-9, 0.0, 1e-9, 0.05])
@pytest.mark.parametrize("lean", [0.0, 20.0])
def test_ends_that_miss_a_line_are_moved_onto_it_along_their_own(off, lean):
    """A crease across a square, too short or too long by `off`: it keeps its direction."""
    lines = np.array([*SQUARE, [[30, 50], [30, 50]]], float)
    along = np.array([lean, 50.0]) / np.hypot(lean, 50)
    lines[4, 0] = [40, 0] + off * along
    lines[4, 1] = [40 + lean, 50]
    found = graph_of(lines, 0.1)
    joint = found.vertices_coords[found.ends_vertex[4, 0]]
    assert joint == pytest.approx([40, 0], abs=1e-9)
    assert len(found.edges_vertices) == 6
    assert found.ends_moved[4] == pytest.approx([abs(off) if abs(off) > 1e-4 else 0, 0], abs=2e-9)
    crossing, joints = found.crossings()
    assert not len(crossing)
    assert joints.tolist() == [found.ends_vertex[4, 0]]


def test_ends_out_of_reach_stay_where_they_are():
    beyond = [[50, -0.5], [50, 50]]
    found = graph_of([*SQUARE, beyond], 0.1)
    assert (found.ends_moved == 0).all()
    assert len(found.edges_vertices) == 4 + 1 + 2
    short = graph_of([*SQUARE, [[50, 0.5], [50, 50]]], 0.1)
    assert len(short.edges_vertices) == 5


def test_ends_become_the_place_that_most_lines_name():
    lines = [*SQUARE, [[0.03, 0.04], [50, 50]], [[0, 0], [50, 50.001]]]
    found = graph_of(lines, 0.1)
    assert found.vertices_coords.tolist()[:2] == [[0, 0], [100, 0]]
    assert found.ends_moved[4] == pytest.approx([0.05, 0])
    assert len(found.edges_vertices) == 5
    assert found.repeated().tolist() == [False] * 5 + [True]


def test_lines_on_each_other_share_their_edges():
    lines = [[[0, 0], [10, 0]], [[2, 0], [5, 0]], [[12, 0], [4, 0]], [[0, 0], [10, 0]]]
    found = graph_of(lines)
    assert parts(found) == {
        frozenset({(0, 0), (2, 0)}): {0, 3},
        frozenset({(2, 0), (4, 0)}): {0, 1, 3},
        frozenset({(4, 0), (5, 0)}): {0, 1, 2, 3},
        frozenset({(5, 0), (10, 0)}): {0, 2, 3},
        frozenset({(10, 0), (12, 0)}): {2},
    }
    assert found.repeated().tolist() == [False, True, False, True]


def test_lines_through_nearly_one_point_meet_in_it():
    turn = np.arange(7) * np.pi / 7
    along = 50 * np.column_stack([np.cos(turn), np.sin(turn)])
    middle = np.random.default_rng(1).uniform(-1e-3, 1e-3, (7, 2))
    found = graph_of(np.stack([middle - along, middle + along], 1), 0.05)
    degree = np.bincount(found.edges_vertices.ravel())
    assert sorted(degree.tolist()) == [1] * 14 + [14]


def test_needles_are_kept_and_double_lines_are_one():
    """Height 0.05 over a base of 3 at a tolerance of 0.1: the corner is near to the other side."""
    needle = [[[0, 0], [30, 0]], [[30, 0], [3, 0.5]], [[3, 0.5], [0, 0]]]
    assert len(graph_of(needle, 0.6).edges_vertices) == 3
    double = [[[0, 0], [30, 0]], [[0, 0], [15, 0.01]]]
    assert len(graph_of(double, 0.05).edges_vertices) == 2


def test_lines_without_length_are_no_edges():
    found = graph_of([[[5, 5], [5, 5]], [[0, 0], [9, 0]], [[3, 0], [3, 0]], [[0, 0], [0, 0]]])
    assert len(found.edges_vertices) == 1
    assert found.ends_vertex[0].tolist() == [-1, -1]
    assert found.ends_vertex[3, 0] == found.ends_vertex[1, 0]
    assert len(arrangement(np.empty((0, 2, 2)), 1.0).edges_vertices) == 0


@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-6, 1.0, 1e6]), st.sampled_from([0.0, 1e5]))
def test_size_and_place_are_free(seed, size, shift):
    lines = loose_lines(seed, 8)
    found = graph_of(lines, 0.08)
    other = arrangement(lines * size + shift * size, 0.08 * size)
    assert np.array_equal(found.edges_vertices, other.edges_vertices)


def test_reach_may_differ_from_end_to_end():
    """Close joints of a curve are kept apart, a line that ends near one of them is joined to it."""
    turn = np.linspace(0, np.pi, 200)
    arc = 20 * np.column_stack([np.cos(turn), np.sin(turn)])
    curve = np.stack([arc[:-1], arc[1:]], axis=1)
    line = np.array([[[-20.0, 0.0], [0.05, 20.1]]])
    reach = np.full((200, 2), 0.05)
    reach[-1] = 0.2
    found = graph_of(np.concatenate([curve, line]), reach)
    assert len(found.vertices_coords) in (200, 201)
    assert found.ends_moved[:-1].max() < 1e-9
    assert np.bincount(found.edges_vertices.ravel())[found.ends_vertex[-1, 1]] == 3


def test_ends_of_a_narrow_triangle_are_not_put_onto_each_others_sides_in_turn():
    """Too far apart to be one, and each within reach of the other's side."""
    turn = 1e-2
    lines = np.array([[[0, 0], [1, 0]], [[0, 0], [np.cos(turn), np.sin(turn)]], [[0, 1], [1e4, 1]]])
    reach = turn - turn**3 / 12  # between the height and the base of the triangle
    assert np.sin(turn) < reach < 2 * np.sin(turn / 2)
    found = arrangement(lines, reach)
    assert found.settled
    assert len(found.edges_vertices) in (2, 3)


def test_many_lines_on_each_other_are_refused():
    ends = np.random.default_rng(0).uniform(0, 100, (3000, 2))
    lines = np.stack([ends, np.full((3000, 2), 5.0)], axis=2)
    with pytest.raises(InvalidState, match=r"on other lines more than .* times"):
        arrangement(lines, 1e-9)
