"""Bridges to islands, between all of which the region is simple polygons."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fab.geometry.arrangement import arrangement
from fab.geometry.bridges import bridges
from fab.geometry.planar_regions import regions_of

NONE = np.empty((0, 2), np.int64)
SQUARE = np.array([[0, 0], [100, 0], [100, 100], [0, 100.0]])


def ring(first, count):
    number = first + np.arange(count)
    return np.column_stack([number, np.roll(number, -1)])


def framed(lines):
    """A square and lines within it: vertices, edges, and on which sides of these is the region."""
    count = len(lines)
    points = np.concatenate([SQUARE, lines.reshape(-1, 2)])
    edges = np.concatenate([ring(0, 4), 4 + np.arange(2 * count).reshape(-1, 2)])
    within = np.column_stack([np.ones(4 + count, bool), np.arange(4 + count) >= 4])
    return points, edges, within


def require_simple(points, edges, found, area):
    """All lines meet in their ends alone, and divide the square into simple polygons."""
    regions = regions_of(points, np.concatenate([edges, found]))
    assert not len(regions.broken())
    own = np.repeat(np.arange(regions.count), np.diff(regions.offsets))
    shapes = shapely.polygons(shapely.linearrings(points[regions.corners], indices=own))
    assert shapely.is_valid(shapes).all()
    assert shapely.area(shapes).sum() == pytest.approx(area)
    assert shapely.area(shapely.union_all(shapes)) == pytest.approx(area)


def scratches(count, arm, seed=0):
    """Lines that do not cross, as long as the arm over the side of the cell that each is in."""
    random = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(count)))
    middles = np.column_stack(np.divmod(np.arange(count), side)) + random.uniform(
        0.45, 0.55, (count, 2)
    )
    turn = random.uniform(0, np.pi, count)
    half = arm / 2 * np.column_stack([np.cos(turn), np.sin(turn)])
    return 100 / side * np.stack([middles - half, middles + half], axis=1)


@pytest.mark.parametrize("count", [1, 30, 3000])
@pytest.mark.parametrize("arm", [0.1, 0.85])
def test_loose_lines_become_sides_of_simple_polygons(count, arm):
    points, edges, within = framed(scratches(count, arm))
    found = bridges(points, edges, within, NONE)
    require_simple(points, edges, found, 1e4)
    # Euler: a region more for each bridge but those that connect the parts
    regions = regions_of(points, np.concatenate([edges, found]))
    assert regions.count == 1 + len(found) - count


@pytest.mark.parametrize("count", [60, 600])
def test_long_lines_beside_each_other_hide_what_is_near(count):
    """Between far ends there are but narrow ways, and near corners do not see each other."""
    y = np.linspace(1, 99, count)
    low, high = (
        np.where(np.arange(count) % 2, 1.0, 30.0),
        np.where(np.arange(count) % 2, 70.0, 99.0),
    )
    lines = np.stack([np.column_stack([low, y]), np.column_stack([high, y])], axis=1)
    points, edges, within = framed(lines)
    require_simple(points, edges, bridges(points, edges, within, NONE), 1e4)


@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.floats(1, 40))
def test_the_face_around_any_lines_is_divided(seed, count, length):
    random = np.random.default_rng(seed)
    middles, turn = random.uniform(2, 98, (count, 2)), random.uniform(0, np.pi, count)
    arm = length * np.column_stack([np.cos(turn), np.sin(turn)])
    lines = np.clip(np.stack([middles - arm, middles + arm], axis=1), 1, 99)
    graph = arrangement(np.concatenate([SQUARE[ring(0, 4)], lines]), 0.05)
    points, edges = graph.vertices_coords, graph.edges_vertices
    # all edges are sides, with the sheet on both, but for the square
    rim = ((points[edges] == 0) | (points[edges] == 100)).all(axis=1).any(axis=1)
    left = regions_of(points, edges[rim]).sides[:, 0] == 0
    within = np.ones((len(edges), 2), bool)
    within[rim] = np.column_stack([left, ~left])
    face = regions_of(points, edges)
    outer = face.sides[rim].max()
    own = face.sides == outer
    around = own.any(axis=1)
    found = bridges(points, edges[around], own[around], NONE)
    assert found is not None
    all_lines = np.concatenate([edges, found])
    sides = regions_of(points, all_lines)
    assert not set(sides.broken().tolist()) & set(sides.sides[len(edges) :].ravel().tolist())


def test_bridges_keep_off_obstacles():
    """Among many loose lines there is a way for one bridge alone: straight from the left."""
    inner = np.array([[40, 40], [60, 40], [60, 60], [40, 60.0]])
    fence = np.array([[[30, 50 - 28], [70, 22]], [[78, 20], [78, 80]], [[70, 78], [30, 78]]], float)
    points = np.concatenate([SQUARE, inner, fence.reshape(-1, 2)])
    edges = np.concatenate([ring(0, 4), ring(4, 4)])
    within = np.column_stack([np.ones(8, bool), np.arange(8) < 0])
    within[4:] = [False, True]
    obstacles = 8 + np.arange(6).reshape(-1, 2)
    found = bridges(points, edges, within, obstacles)
    require_simple(points, edges, found, 1e4)
    ways = shapely.linestrings(points[found])
    assert not shapely.intersects(ways[:, None], shapely.linestrings(points[obstacles])).any()
    assert {tuple(pair) for pair in np.sort(found, axis=1).tolist()} == {(0, 4), (3, 7)}
