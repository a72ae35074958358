"""Triangles over points, with given edges among their sides."""

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fab.geometry.arrangement import arrangement
from fab.geometry.constrained_triangles import triangle_sides


def pairs(sides):
    return {tuple(sorted(side)) for side in sides.tolist()}


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.booleans())
def test_all_edges_are_sides_and_no_sides_cross(seed, count, whole):
    lines = np.random.default_rng(seed).uniform(0, 6, (count, 2, 2))
    graph = arrangement(np.round(lines) if whole else lines, 1e-9)
    points, edges = graph.vertices_coords, graph.edges_vertices
    if not len(edges):
        return
    sides = triangle_sides(points, edges)
    assert pairs(edges) <= pairs(sides)
    assert len(pairs(sides)) == len(sides)
    shapes = shapely.linestrings(points[sides])
    first, second = shapely.STRtree(shapes).query(shapes, "crosses")
    common = (sides[first][:, :, None] == sides[second][:, None, :]).any(axis=(1, 2))
    assert common.all()


@given(st.integers(0, 2**32 - 1), st.integers(3, 200))
def test_a_polygon_of_n_corners_has_n_minus_3_diagonals_within(seed, count):
    """A comb of narrow teeth, which Delaunay triangles do not keep to."""
    random = np.random.default_rng(seed)
    turn = np.sort(random.choice(1000, count, replace=False)) * 2 * np.pi / 1000
    reach = np.where(np.arange(count) % 2, 1.0, random.uniform(0.02, 1.0, count))
    points = reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    area = shapely.Polygon(points)
    if not area.is_valid:
        return
    edges = np.column_stack([np.arange(count), np.roll(np.arange(count), -1)])
    sides = triangle_sides(points, edges)
    assert pairs(edges) <= pairs(sides)
    inner = np.array(sorted(pairs(sides) - pairs(edges))).reshape(-1, 2)
    middles = shapely.points(points[inner].mean(axis=1)) if len(inner) else []
    assert int(np.sum(shapely.contains_properly(area, middles))) == count - 3


def test_edges_that_pass_points_are_sides_from_point_to_point():
    points = np.array([[0, 0], [4, 0], [1, 0], [3, 0], [2, 2], [2, -2.0]])
    sides = pairs(triangle_sides(points, np.array([[0, 1], [4, 2]])))
    assert {(0, 2), (2, 3), (1, 3), (2, 4)} <= sides
    assert (0, 1) not in sides


def test_an_edge_across_a_whole_lattice():
    """It crosses triangles with corners on circles of four, and is the only way to the far side."""
    x = np.arange(20.0)
    points = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    edge = np.array([[0, 19 * 20 + 18]])  # from (0, 0) to (18, 19)
    sides = triangle_sides(points, edge)
    assert (0, 398) in pairs(sides)
    # Euler: 3 n - 3 less the sides of the hull, all of which are there
    assert len(sides) == 3 * 400 - 3 - 76


def test_points_on_a_line_or_none():
    assert triangle_sides(np.empty((0, 2)), np.empty((0, 2), int)).shape == (0, 2)
    points = np.array([[0, 0], [2, 0], [1, 0.0]])
    assert triangle_sides(points, np.array([[0, 2], [2, 1]])).tolist() == [[0, 2], [1, 2]]
