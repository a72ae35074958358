"""Walks around the faces of planar graphs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.geometry.arrangement import arrangement
from fab.geometry.planar_graph import walks_of
from fab.geometry.rings import ring_areas
from solver.polygons import next_corner


def plain_walks(points, edges):
    """By the definition, step by step: at the end of a side on by the next edge clockwise."""
    sides = [*map(tuple, edges.tolist()), *((b, a) for a, b in edges.tolist())]
    about = {}
    for a, b in sides:
        angle = np.arctan2(*(points[b] - points[a])[::-1])
        about.setdefault(a, []).append((angle, b))
    about = {vertex: [b for _, b in sorted(ends)] for vertex, ends in about.items()}
    walks, walk_of = [], {}
    for begin in sides:
        side, corners = begin, []
        while side not in walk_of:
            walk_of[side] = len(walks)
            corners.append(side[0])
            ends = about[side[1]]
            side = (side[1], ends[ends.index(side[0]) - 1])
        if corners:
            walks.append(corners)
    return walks, [walk_of[side] for side in sides]


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.booleans())
def test_walks_are_those_of_the_definition_in_the_order_of_their_first_edges(seed, count, whole):
    random = np.random.default_rng(seed)
    lines = random.uniform(0, 6, (count, 2, 2))
    graph = arrangement(np.round(lines) if whole else lines, 1e-9)
    points, edges = graph.vertices_coords, graph.edges_vertices
    edges = random.permutation(
        np.where(random.random((len(edges), 1)) < 0.5, edges, edges[:, ::-1])
    )
    walks, of = plain_walks(points, edges)
    corners, offsets, walk = walks_of(points, edges)
    assert corners.tolist() == [vertex for each in walks for vertex in each]
    assert np.diff(offsets).tolist() == list(map(len, walks))
    assert walk.tolist() == of


def test_a_long_walk_goes_around_a_path_and_back():
    count = 50_000
    points = np.column_stack([np.arange(count), np.arange(count) % 2]).astype(float)
    edges = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    corners, offsets, walk = walks_of(points, edges)
    there = np.arange(count)
    assert corners.tolist() == [*there.tolist(), *there[-2:0:-1].tolist()]
    assert offsets.tolist() == [0, 2 * (count - 1)]
    assert not walk.any()


@pytest.mark.parametrize("side", [1, 30])
def test_faces_of_a_lattice_and_the_walk_around_it(side):
    number = np.arange((side + 1) ** 2).reshape(side + 1, side + 1)
    across = np.stack([number[:, :-1], number[:, 1:]], axis=-1).reshape(-1, 2)
    edges = np.concatenate([across, np.stack([number[:-1], number[1:]], axis=-1).reshape(-1, 2)])
    points = np.column_stack(np.divmod(number.ravel(), side + 1)[::-1]).astype(float)
    corners, offsets, walk = walks_of(points, edges)
    areas = ring_areas(points[corners], offsets)
    assert sorted(areas.tolist()) == [-(side**2), *[1.0] * side**2]
    assert np.bincount(walk).tolist() == np.diff(offsets).tolist()
    steps = np.column_stack([corners, corners[next_corner(offsets)]])
    both = np.concatenate([edges, edges[:, ::-1]])
    assert sorted(map(tuple, steps.tolist())) == sorted(map(tuple, both.tolist()))
