"""Planarity, developability and isometry against exact answers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import patches

from solver import InvalidValue
from solver.measure import angle_excess, developability, isometry, planarity, sector_angles

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
QUAD = np.array([[0, 1, 2, 3]])


@given(st.floats(1e-9, 1.0))
def test_planarity_of_a_twisted_square_is_the_distance_of_its_diagonals(height):
    twisted = SQUARE.copy()
    twisted[[1, 3], 2] = height
    assert planarity(twisted, QUAD)[0] == pytest.approx(height / np.sqrt(2), rel=1e-12)


def test_planarity_is_dimensionless_and_zero_for_flat_polygons():
    angle = np.arange(6) * np.pi / 3
    hexagon = np.column_stack([np.cos(angle), np.sin(angle), 0.3 * np.cos(angle)])
    assert planarity(hexagon, np.arange(6)[None])[0] < 1e-15
    crown = hexagon * [1, 1, 0] + np.outer(np.where(np.arange(6) % 2, 0.05, -0.05), [0, 0, 1])
    # diagonals join the neighbours of a corner
    assert planarity(crown, np.arange(6)[None])[0] == pytest.approx(0.1 / np.sqrt(3), rel=1e-12)
    hexagon[::2, 2] += 0.1
    small = planarity(hexagon * 1e-3, np.arange(6)[None])
    assert small == pytest.approx(planarity(hexagon, np.arange(6)[None]), rel=1e-12)
    assert planarity(SQUARE, np.array([[0, 1, 2]]))[0] == 0


def test_planarity_of_polygons_and_of_quads_is_one_definition():
    random = np.random.default_rng(1)
    quad = random.normal(size=(4, 3))
    pentagon = np.insert(quad, 1, (quad[0] + quad[1]) / 2, axis=0)
    as_quad = planarity(quad, QUAD)[0]
    assert planarity(pentagon, np.arange(5)[None])[0] > 0.1 * as_quad
    tilted = SQUARE @ np.linalg.qr(random.normal(size=(3, 3)))[0].T
    assert planarity(tilted, QUAD)[0] < 1e-15


def test_a_face_without_area_is_not_a_number():
    assert np.isnan(planarity(SQUARE * [1, 0, 0], QUAD)[0])


def test_the_corner_of_a_cube_misses_a_right_angle():
    cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1.0]])
    faces = np.array([[0, 1, 2, 3], [0, 4, 5, 1], [0, 3, 6, 4]])
    assert developability(cube, faces)[0] == pytest.approx(np.pi / 2, abs=1e-15)
    assert (developability(cube, faces)[1:] == 0).all()
    assert angle_excess(cube, faces, np.ones(7, bool))[0] == pytest.approx(-np.pi / 2, abs=1e-15)


@given(patches())
def test_the_sectors_of_a_planar_quad_add_up_to_a_full_turn(mesh):
    angles = sector_angles(mesh.vertices_coords, mesh.faces_vertices)
    assert angles.sum(axis=1) == pytest.approx(2 * np.pi, abs=1e-9)


def test_reflex_corners_count_as_such():
    dart = np.array([[0.0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]])
    angles = np.degrees(sector_angles(dart, QUAD)[0])
    assert angles.sum() == pytest.approx(360.0, abs=1e-12)
    assert angles[2] == pytest.approx(360 - 90 - 2 * np.degrees(np.arctan2(1, 3)), abs=1e-12)
    # a flat sheet of two quads, one of them a dart around an inner vertex
    flat = np.array([[0.0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0], [3, 2, 0], [8, 9, 0]])
    faces = np.array([[0, 1, 4, 3], [1, 2, 3, 4]])
    assert angle_excess(flat, faces, np.arange(6) == 4)[4] == pytest.approx(0, abs=1e-14)


@given(patches())
def test_grown_patches_are_planar_and_developable(mesh):
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-10
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-10


def test_isometry_is_the_largest_relative_change_of_a_side_or_diagonal():
    sheared = SQUARE[:, :2] @ np.array([[1, 0], [0.1, 1]])
    # diagonals of the sheared square: hypot(1.1, 1) and hypot(0.9, 1)
    expected = np.abs(np.array([np.hypot(1.1, 1), np.hypot(0.9, 1)]) / np.sqrt(2) - 1).max()
    assert isometry(SQUARE, sheared, QUAD)[0] == pytest.approx(expected, rel=1e-12)
    assert isometry(SQUARE, SQUARE[:, :2] @ np.array([[0.6, 0.8], [-0.8, 0.6]]), QUAD)[0] < 1e-15
    assert isometry(SQUARE, 3 * SQUARE, QUAD)[0] == pytest.approx(2)


@pytest.mark.parametrize(
    ("coords", "faces"),
    [
        (SQUARE * np.nan, QUAD),
        (SQUARE * 1e80, QUAD),
        (SQUARE * 1e-80, QUAD),
        (SQUARE[:, :2], QUAD),
        (None, QUAD),
        (SQUARE, QUAD + 1),
        (SQUARE, QUAD - 1),
        (SQUARE, QUAD[0]),
        (SQUARE, QUAD[:, :2]),
        (SQUARE, QUAD.astype(float)),
    ],
)
def test_arguments_of_other_kinds_are_refused(coords, faces):
    for measure in (planarity, developability, lambda x, f: isometry(x, SQUARE, f)):
        with pytest.raises(InvalidValue):
            measure(coords, faces)


def test_isometry_wants_a_flat_point_for_each_vertex():
    for flat in (SQUARE[:3], SQUARE[:, :1], "flat"):
        with pytest.raises(InvalidValue, match="flat_coords"):
            isometry(SQUARE, flat, QUAD)


def test_lists_and_no_faces_are_measured():
    assert planarity(SQUARE.tolist(), QUAD.tolist())[0] == 0
    assert planarity(SQUARE, QUAD[:0]).shape == (0,)
    assert (developability(SQUARE, QUAD[:0]) == 0).all()


def test_planarity_is_relative_to_the_longer_diagonal_and_has_no_sign():
    kite = np.array([[0.0, 0, 0], [4, 0, 0], [5, 1, 0], [0, 4, 0]])
    up, down = kite.copy(), kite.copy()
    up[2, 2], down[2, 2] = 0.3, -0.3
    first, second = up[2] - up[0], up[3] - up[1]
    normal = np.cross(first, second)
    gap = abs(normal @ (up[1] - up[0])) / np.linalg.norm(normal)
    longer = max(np.linalg.norm(first), np.linalg.norm(second))
    assert planarity(up, QUAD)[0] == pytest.approx(gap / longer, rel=1e-12)
    assert planarity(down, QUAD)[0] == pytest.approx(gap / longer, rel=1e-12)
