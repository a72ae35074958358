"""Pieces set apart: never nearer than the gap, moved as they are, and only where they must."""

import numpy as np
import pytest
import shapely
from flat_patterns import grid, pattern_of, stars
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from fab.layout.piece_gaps import set_apart, shifts_apart
from fab.pattern.crease_pattern import CreasePattern


def squares(*corners, size=40.0) -> CreasePattern:
    """Squares with vertices of their own, by their lower left corners."""
    unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size
    coords = np.concatenate([unit + corner for corner in corners])
    return pattern_of(coords, np.arange(len(coords)).reshape(-1, 4).tolist())


def regions(pattern):
    return [
        shapely.Polygon(pattern.vertices_coords[pattern.faces_vertices[first:end]])
        for first, end in zip(pattern.faces_offsets[:-1], pattern.faces_offsets[1:], strict=True)
    ]


def least_distance(shapes):
    return min(a.distance(b) for k, a in enumerate(shapes) for b in shapes[:k])


@pytest.mark.parametrize(
    ("second", "shift"),
    [
        ((40, 0), (0.3, 0)),  # along an edge
        ((40.1, 0), (0.2, 0)),
        ((0, 40), (0, 0.3)),
        ((-40, 15), (-0.3, 0)),
        ((40, 40), (0.3, 0)),  # in a corner
        ((10, 30), (0, 10.3)),  # over each other
        ((0, 0), (40.3, 0)),
        ((40.3, 0), None),
        ((90, 0), None),
    ],
)
def test_a_piece_that_is_too_near_moves_to_the_nearest_place(second, shift):
    pattern = squares((0, 0), second)
    moved, faces, shifts = set_apart(pattern, 0.3)
    if shift is None:
        assert moved is pattern
        return
    assert faces.tolist() == [1]
    assert shifts == pytest.approx(np.array([shift]))
    by = moved.vertices_coords - pattern.vertices_coords
    assert by == pytest.approx(np.repeat([[0, 0], shift], 4, axis=0))
    assert least_distance(regions(moved)) >= 0.3 * (1 - 1e-6)


def test_a_row_of_touching_squares_and_a_field_of_them():
    moved, _, shifts = set_apart(squares(*((40 * k, 0) for k in range(6))), 0.5)
    assert shifts == pytest.approx(np.column_stack([np.arange(1, 6) * 0.5, np.zeros(5)]))
    moved, faces, _ = set_apart(squares(*((40 * i, 40 * k) for k in range(7) for i in range(7))), 1)
    assert least_distance(regions(moved)) >= 1 - 1e-6
    assert len(faces) == 48
    assert np.ptp(moved.vertices_coords, axis=0) == pytest.approx([286, 286], abs=1e-6)


@given(
    st.lists(
        st.tuples(st.integers(0, 9), st.integers(0, 9), st.floats(0, 1e-3)), min_size=2, max_size=14
    ),
    st.integers(0, 100),
    st.floats(0.05, 5),
)
@settings(max_examples=60, deadline=None)
def test_pieces_of_any_shape_end_up_apart(places, seed, gap):
    shapes = [
        shapely.Polygon(star + np.array([x, y]) * 20 + off)
        for star, (x, y, off) in zip(stars(len(places), seed), places, strict=True)
    ]
    before = np.array(shapes)
    shifts = shifts_apart(before, gap)
    moved = [shapely.transform(s, lambda xy, by=by: xy + by) for s, by in zip(shapes, shifts)]  # noqa: B905
    assert least_distance(moved) >= gap - 1e-6
    assert (shifts[0] == 0).all()
    assert (shifts_apart(before, gap) == shifts).all()
    for i in range(1, len(shapes)):  # nothing moves without need
        if min(shapes[i].distance(other) for other in moved[:i]) >= gap:
            assert (shifts[i] == 0).all()


def test_many_pieces_in_one_place_end_up_apart():
    shapes = np.array([shapely.box(0, 0, 10, 10)] * 120)
    shifts = shifts_apart(shapes, 1.0)
    assert pdist(shifts, "chebyshev").min() >= 11 - 1e-6


def test_pieces_that_share_vertices_get_their_own():
    """Squares on the diagonal of a grid, which share a corner, and a slit in the second."""
    pattern = grid(2, 2, 40.0, without=[(0, 1), (1, 0)])
    coords = np.vstack([pattern.vertices_coords, [[60.0, 60.0], [70.0, 60.0]]])
    count = len(pattern.vertices_coords)
    with_slit = CreasePattern(
        coords,
        np.vstack([pattern.edges_vertices, [count, count + 1]]),
        np.vstack([pattern.edges_faces, [1, 1]]),
        np.append(pattern.edges_assignment, "C"),
        np.append(pattern.edges_foldAngle, 0.0),
        pattern.faces_vertices.copy(),
        pattern.faces_offsets.copy(),
        np.column_stack([coords, np.arange(count + 2)]),
    )
    moved, faces, shifts = set_apart(with_slit, 0.4)
    assert faces.tolist() == [1]
    assert len(moved.vertices_coords) == count + 3
    assert least_distance(regions(moved)) == pytest.approx(0.4)
    slit = moved.vertices_coords[moved.edges_vertices[-1]]
    assert slit == pytest.approx(np.array([[60, 60], [70, 60]]) + shifts[0])
    ends = with_slit.vertices_coords[with_slit.edges_vertices]
    by = np.where(with_slit.edges_faces[:, :1] == 1, shifts[0], 0.0)
    assert moved.vertices_coords[moved.edges_vertices] == pytest.approx(ends + by[:, None])
    shared = (
        moved.folded_coords[moved.edges_vertices]
        == with_slit.folded_coords[with_slit.edges_vertices]
    )
    assert shared.all()


def test_pieces_held_together_by_a_cut_stay_in_place():
    pattern = grid(2, 1, 40.0, cuts=[(1, 4)])
    assert set_apart(pattern, 0.4)[0] is pattern


def test_a_piece_within_the_hole_of_another_stays_where_it_has_room():
    frame = grid(3, 3, 20.0, without=[(1, 1)])
    ring = shapely.union_all(regions(frame))
    roomy = np.array([ring, shapely.box(21, 21, 39, 39)])
    assert (shifts_apart(roomy, 0.9) == 0).all()
    tight = np.array([ring, shapely.box(20, 20, 40, 40)])
    assert shifts_apart(tight, 0.9)[1].any()
