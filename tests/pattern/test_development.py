"""Unfolding: published shapes, isometry, orientation, overlap."""

from itertools import combinations

import numpy as np
import pytest
import shapely
from helpers import published, turned_onto
from hypothesis import given
from hypothesis import strategies as st
from strategies import patches, sheets

from fab.geometry.rings import ring_areas
from fab.pattern.development import develop
from fab.pattern.overlap import overlapping_faces
from solver import CurvedFold, InvalidValue, Miura, QuadMesh
from solver.mesh import edges_of
from solver.relaxed_fit import joined


def test_f4d_unfolds_to_the_published_flat_shape():
    flat = develop(CurvedFold().grow().mesh).vertices_coords
    expected = published("F4D", "flat").reshape(-1, 3)[:, :2]
    assert np.abs(turned_onto(flat, expected) - expected).max() < 1e-10


@pytest.mark.parametrize("name", ["F4D", "F4E", "peaks_coarse"])
def test_published_models_unfold_to_their_own_flat_shapes(name):
    development = develop(QuadMesh.from_rows(published(name, "fold")))
    expected = published(name, "flat").reshape(-1, 3)[:, :2]
    if name == "peaks_coarse":
        expected = expected * [1, -1]  # this one was published seen from its lower side
    diagonal = np.linalg.norm(np.ptp(expected, axis=0))
    moved = turned_onto(development.vertices_coords, expected)
    assert np.abs(moved - expected).max() < 1e-9 * diagonal


@given(patches())
def test_lengths_survive_and_faces_stay_counterclockwise(mesh):
    development = develop(mesh)
    assert development.isometry_max_rel < 1e-10
    assert development.closure_max < 1e-11
    assert (
        ring_areas(
            development.vertices_coords[mesh.faces_vertices].reshape(-1, 2),
            np.arange(len(mesh.faces_vertices) + 1) * 4,
        ).min()
        > 0
    )


@given(sheets())
def test_sides_and_diagonals_of_every_face_survive(mesh):
    flat = develop(mesh).vertices_coords
    for i, j in combinations(range(4), 2):
        ends = mesh.faces_vertices[:, [i, j]]
        folded, unfolded = (
            np.linalg.norm(x[ends[:, 0]] - x[ends[:, 1]], axis=1)
            for x in (mesh.vertices_coords, flat)
        )
        assert unfolded == pytest.approx(folded, rel=1e-9)


@given(patches())
def test_the_box_stands_on_the_origin_with_its_longer_side_along_x(mesh):
    flat = develop(mesh).vertices_coords
    assert flat.min(axis=0) == pytest.approx([0, 0], abs=1e-12)
    width, height = flat.max(axis=0)
    assert width >= height * (1 - 1e-9)
    box = shapely.minimum_rotated_rectangle(shapely.multipoints(flat))
    assert width * height == pytest.approx(box.area, rel=1e-6)


@given(patches())
def test_overlaps_agree_with_brute_force(mesh):
    development = develop(mesh)
    shapes = shapely.polygons(development.vertices_coords[mesh.faces_vertices])
    expected = {
        (i, j)
        for i, j in combinations(range(len(shapes)), 2)
        if shapes[i].intersection(shapes[j]).area > 1e-9 * min(shapes[i].area, shapes[j].area)
    }
    assert {tuple(pair) for pair in development.overlaps.tolist()} == expected


# Quads whose corners differ in their last digits; their common area was once built as 0.
NEARLY_ALIKE = [
    (
        [
            [0.01749300125033586, 0.12623715655015433],
            [1.1635454324189718, 0.34563661157502557],
            [1.3810009895736624, 1.1085015537874856],
            [0.7333583067370528, 0.4919130529163689],
        ],
        [
            [0.017493001250336593, 0.12623715655015472],
            [1.1635454324189713, 0.34563661157502573],
            [1.381000989573662, 1.1085015537874852],
            [0.7333583067370529, 0.4919130529163689],
        ],
    ),
    (
        [
            [0.3200678393079566, 0.10502161439569223],
            [1.045130287916972, 0.32078226763855117],
            [1.0874835313158697, 1.0888497640887347],
            [0.3033433236635886, 1.3907404858476884],
        ],
        [
            [0.32006783930795674, 0.10502161439569246],
            [1.045130287916972, 0.3207822676385513],
            [1.0874835313158697, 1.0888497640887347],
            [0.30334332366358874, 1.3907404858476882],
        ],
    ),
]


def overlaps_of(first, second):
    corners, offsets = np.arange(8), np.array([0, 4, 8])
    edges = edges_of(corners, offsets)
    return overlapping_faces(np.concatenate([first, second]), corners, offsets, edges).tolist()


@pytest.mark.parametrize(("first", "second"), NEARLY_ALIKE)
def test_faces_alike_but_for_their_last_digits_overlap(first, second):
    assert overlaps_of(first, second) == overlaps_of(second, first) == [[0, 1]]


@given(st.integers(0, 2**32 - 1), st.floats(-16, -8))
def test_a_face_within_another_overlaps_it_however_close_they_are(seed, closeness):
    rng = np.random.default_rng(seed)
    outer = rng.random((4, 2)) * 0.4 + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    middle = outer.mean(axis=0)
    inner = middle + (outer - middle) * (1 - 10**closeness)
    assert overlaps_of(outer, inner) == [[0, 1]]


@pytest.mark.parametrize(("depth", "count"), [(1e-11, 0), (1e-8, 1), (0.5, 1), (-0.1, 0)])
def test_faces_that_overlap_by_less_than_rounding_are_in_contact(depth, count):
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert len(overlaps_of(square, square + np.array([1 - depth, 0.3]))) == count


def test_the_published_curved_fold_overlaps_itself_in_faces_that_are_named():
    overlaps = develop(CurvedFold().grow().mesh).overlaps
    assert len(overlaps) > 1000
    flat = develop(CurvedFold().grow().mesh).vertices_coords
    mesh = CurvedFold().grow().mesh
    first, second = shapely.polygons(flat[mesh.faces_vertices[overlaps[0]]])
    assert first.intersection(second).area > 0


def test_a_sheet_that_does_not_close_is_measured():
    rows = Miura(columns=4, rows=4).grow().mesh
    bent = rows.vertices_coords.copy()
    bent[12] += [0.0, 0.0, 0.05]
    development = develop(QuadMesh.from_rows(bent[rows.grid]))
    assert development.closure_max > 1e-3
    assert development.isometry_max_rel > 1e-3


def test_large_patches_unfold_as_exactly_as_small_ones():
    errors = [
        develop(Miura(columns=n, rows=n, fold=np.radians(30)).grow().mesh).isometry_max_rel
        for n in (10, 40, 160)
    ]
    assert errors[0] < 1e-13
    assert errors[2] < 1e-10


def test_a_crossed_quad_is_an_overlap_with_itself():
    flat = np.array([[0.0, 0], [1, 0], [0.2, 1], [0.9, 1], [-1, 0], [-1, 1]])
    mesh = QuadMesh.from_rows(
        np.array([[[-1.0, 0, 0], [0, 0, 0], [1, 0, 0]], [[-1, 1, 0], [0, 1, 0], [1, 1, 0]]])
    )
    crossed = flat[[4, 0, 1, 5, 3, 2]]  # the right face's upper corners are swapped
    assert [1, 1] in overlapping_faces(crossed, *mesh.polygons, mesh.edges).tolist()


def test_a_curve_and_a_face_without_area_are_refused():
    line = np.array([[0.0, 0, 0], [1, 1, 0], [2, 0, 0]])
    with pytest.raises(InvalidValue, match="faces"):
        develop(QuadMesh.from_rows(line[None]))
    with pytest.raises(InvalidValue, match="area of face 0"):
        develop(QuadMesh.from_rows(np.stack([line * [1, 0, 0], line * [2, 0, 0]])))


def test_pieces_are_laid_side_by_side():
    """Each is unfolded as alone, in boxes that are apart; overlaps keep their own faces."""
    parts = [Miura(columns=n, rows=m).grow().mesh for n, m in ((4, 3), (6, 2), (3, 3))]
    both = joined(parts)
    development = develop(both)
    assert development.isometry_max_rel < 1e-12
    assert development.closure_max < 1e-12
    assert len(development.overlaps) == 0
    flat = development.vertices_coords
    assert flat.min(axis=0) == pytest.approx([0, 0], abs=1e-12)
    hulls, start = [], 0
    for part in parts:
        stop = start + len(part.vertices_coords)
        alone = develop(part).vertices_coords
        assert turned_onto(alone, flat[start:stop]) == pytest.approx(flat[start:stop], abs=1e-9)
        hulls.append(shapely.minimum_rotated_rectangle(shapely.multipoints(flat[start:stop])))
        start = stop
    size = max(float(np.ptp(develop(part).vertices_coords, axis=0).max()) for part in parts)
    for first, second in combinations(hulls, 2):
        assert first.distance(second) > 0.029 * size
    areas = ring_areas(
        flat[both.faces_vertices].reshape(-1, 2), np.arange(len(both.faces_vertices) + 1) * 4
    )
    assert areas.min() > 0


def test_overlaps_of_a_piece_are_named_in_the_whole():
    first, second = Miura(columns=4, rows=3).grow().mesh, CurvedFold().grow().mesh
    both = develop(joined([first, second])).overlaps
    np.testing.assert_array_equal(both, develop(second).overlaps + len(first.faces_vertices))
    assert len(both) > 0
