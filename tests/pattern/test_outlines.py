"""What is cut through: every line once, rings that touch nothing, slits joined to chains."""

import numpy as np
import pytest
import shapely
from flat_patterns import fan, grid, pattern_of, triangles
from hypothesis import given
from hypothesis import strategies as st

from fab.geometry.rings import ring_areas
from fab.pattern.outlines import outlines_of


def areas(rings):
    offsets = np.cumsum([0, *(len(ring) for ring in rings)])
    return ring_areas(np.concatenate(rings), offsets)


def all_lines(outlines):
    sides = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in outlines.rings]
    return shapely.linestrings(np.concatenate([*sides, outlines.slits]))


def assert_sound(pattern, outlines):
    """Rings are simple and hold the area of the faces, and nothing is covered twice."""
    assert all(shapely.LinearRing(ring).is_valid for ring in outlines.rings)
    face = ring_areas(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets)
    assert areas(outlines.rings).sum() == pytest.approx(face.sum(), rel=1e-12)
    lines = all_lines(outlines)
    union = shapely.length(shapely.union_all(lines))
    assert shapely.length(lines).sum() == pytest.approx(union, rel=1e-9)
    letters = pattern.edges_assignment
    cut = (pattern.edges_faces[:, 1] < 0) | np.isin(letters, ["B", "C"])
    wanted = shapely.union_all(
        shapely.linestrings(pattern.vertices_coords[pattern.edges_vertices[cut]])
    )
    assert shapely.hausdorff_distance(wanted, shapely.union_all(lines)) < 1e-6


@given(st.integers(0, 2**32 - 1), st.floats(0.3, 0.9))
def test_any_part_of_a_grid(seed, share):
    """Several pieces, holes, and borders that touch themselves in vertices."""
    random = np.random.default_rng(seed)
    places = np.argwhere(random.uniform(size=(6, 5)) > share).tolist()
    without = [tuple(place) for place in places]
    if len(without) == 30:
        return
    pattern = grid(6, 5, 10.0, without)
    pairs = pattern.edges_vertices[random.uniform(size=len(pattern.edges_vertices)) > 0.7]
    pattern = grid(6, 5, 10.0, without, pairs.tolist())
    assert_sound(pattern, outlines_of(pattern))


@pytest.mark.parametrize("seed", range(5))
def test_triangles_with_cuts(seed):
    pattern = triangles(seed)
    outlines = outlines_of(pattern)
    assert len(outlines.slits) > 0
    assert_sound(pattern, outlines)


def test_an_n_gon_and_a_fan():
    turn = np.arange(7) * 2 * np.pi / 7
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    (outline,) = outlines_of(pattern_of(ring, [list(range(7))])).rings
    assert outline == pytest.approx(ring)
    (outline,) = outlines_of(fan(9, 5.0)).rings
    assert len(outline) == 9


def test_squares_that_touch_in_a_vertex_are_two_rings():
    outlines = outlines_of(grid(2, 2, 10.0, [(0, 1), (1, 0)]))
    assert areas(outlines.rings) == pytest.approx([100.0, 100.0])


def test_a_hole_that_touches_the_outline_is_a_ring_of_its_own():
    outlines = outlines_of(grid(3, 3, 10.0, [(0, 0), (1, 1)]))
    assert areas(outlines.rings) == pytest.approx([800.0, -100.0])


def test_pieces_that_touch_along_a_seam_are_cut_once():
    coords = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [1, 0], [2, 0], [2, 1], [1, 1]]) * 10.0
    pattern = pattern_of(coords, [[0, 1, 2, 3], [4, 5, 6, 7]])
    outlines = outlines_of(pattern)
    assert areas(outlines.rings) == pytest.approx([200.0])
    assert np.sort(outlines.slits[0], axis=0) == pytest.approx(np.array([[10.0, 0], [10, 10]]))
    assert_sound(pattern, outlines)
    apart = pattern_of(
        coords + np.repeat([[0.0, 0], [1e-3, 0]], 4, axis=0), [[0, 1, 2, 3], [4, 5, 6, 7]]
    )
    assert areas(outlines_of(apart).rings) == pytest.approx([100.0, 100.0])


def test_a_seam_whose_sides_are_divided_otherwise_is_cut_once():
    coords = np.array([[0, 0], [20, 0], [20, 10], [0, 10], [0, 10], [5, 10], [20, 10], [20, 20]])
    pattern = pattern_of(np.vstack([coords, [[0, 20]]]), [[0, 1, 2, 3], [4, 5, 6, 7, 8]])
    outlines = outlines_of(pattern)
    assert areas(outlines.rings) == pytest.approx([400.0])
    assert len(outlines.slits) == 1
    assert_sound(pattern, outlines)


def test_slits_are_joined_to_chains_and_straight_runs_to_one_cut():
    # a slit along the middle line, with a branch to the right angle at its end
    cuts = [(8, 9), (9, 10), (10, 11), (11, 18)]
    outlines = outlines_of(grid(6, 3, 10.0, cuts=cuts))
    assert len(outlines.slits) == 2
    assert outlines.slits[0, 1] == pytest.approx(outlines.slits[1, 0])
    lengths = np.hypot(*(outlines.slits[:, 1] - outlines.slits[:, 0]).T)
    assert sorted(lengths) == pytest.approx([10.0, 30.0])


def test_a_closed_chain_comes_back_to_its_start():
    cuts = [(8, 9), (9, 16), (16, 15), (15, 8)]
    slits = outlines_of(grid(6, 3, 10.0, cuts=cuts)).slits
    assert len(slits) == 4
    assert slits[:, 1] == pytest.approx(np.roll(slits[:, 0], -1, axis=0))


def test_a_border_between_two_faces_is_a_cut():
    pattern = pattern_of([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]], "B")
    outlines = outlines_of(pattern)
    assert len(outlines.slits) == 1
    assert_sound(pattern, outlines)
