"""Layers of sheets that are folded flat are apart in pictures, in their order."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import shapely
from folded_strips import lettered, strip

from fab.layers.layer_orders import layer_orders
from fab.pattern.kinematics import fold_by_angles
from fab.viewing.layered_scene import layered
from fab.viewing.scene_builders import pattern_scene


def pinwheel(turned, straight, inner):
    """A square with a square in its middle, whose flaps turn around it; letters of three kinds."""
    inside = [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)]
    outside = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)]
    rim = [(0.0, 2.0), (1.0, 0.0), (3.0, 1.0), (2.0, 3.0)]
    coords = 20.0 * np.array([*inside, *outside, *rim])
    faces = [[0, 1, 2, 3]]
    for k in range(4):
        after = (k + 1) % 4
        faces += [[k, 4 + k, 8 + after, after], [after, 8 + after, 4 + after]]
    letters = {}
    for k in range(4):
        letters[k, (k + 1) % 4] = inner
        letters[k, 4 + k] = straight
        letters[k, 8 + k] = turned
    ends = sorted(tuple(sorted(pair)) for pair in letters)
    found = {tuple(sorted(pair)): letter for pair, letter in letters.items()}
    return lettered(coords, faces, [found[pair] for pair in ends])


def heights_at(pattern, values, face, point):
    """The height of a face at a point of the folded form, by the plane through its corners."""
    own = slice(*pattern.faces_offsets[face : face + 2])
    folded = fold_by_angles(pattern).folded_coords[:, :2]
    corners = folded[pattern.faces_vertices[own]]
    plane, off, *_ = np.linalg.lstsq(
        np.column_stack([np.ones(len(corners)), corners]), values[own], rcond=None
    )
    assert off.max(initial=0.0) < 1e-9
    return plane @ [1.0, *point]


def require_order(pattern):
    """Every two faces that overlap are apart in the order of the layers."""
    layers = layer_orders(pattern)
    folded = fold_by_angles(pattern).folded_coords[:, :2]
    areas = [
        shapely.Polygon(folded[pattern.faces_vertices[slice(*pattern.faces_offsets[f : f + 2])]])
        for f in range(pattern.face_count)
    ]
    assert len(layers.orders)
    for first, second, side in layers.orders.tolist():
        point = areas[first].intersection(areas[second]).centroid.coords[0]
        above, below = (
            heights_at(pattern, layers.heights, each, point) for each in (first, second)
        )
        up = -side if layers.faces_turned[second] else side
        assert (above - below) * up > 0.1


@pytest.mark.parametrize("sizes", [[2, 2, 2, 2], [3, 1, 1, 3, 2], [1, 2, 3]])
def test_layers_of_strips_are_apart(sizes):
    require_order(strip(sizes, ["V", "M", "M", "V"][: len(sizes) - 1]))


def test_flaps_in_a_circle_are_tilted():
    circles = 0
    for letters in product("MV", repeat=3):
        pattern = pinwheel(*letters)
        layers = layer_orders(pattern)
        if layers.folds_flat == "yes":
            require_order(pattern)
            circles += bool((layers.heights % 1 > 1e-6).any())
    assert circles


def test_faces_of_the_last_state_are_lifted_and_keep_their_numbers():
    pattern = strip([20, 20, 20], "VM")
    pattern = replace(pattern, folded_coords=fold_by_angles(pattern).folded_coords)
    plain = pattern_scene(pattern, "pleats")
    scene = layered(plain, layer_orders(pattern))
    assert scene.pattern.face_count == pattern.face_count
    assert scene.pattern.edges_assignment.tolist() == pattern.edges_assignment.tolist()
    assert len(scene.pattern.vertices_coords) == len(pattern.faces_vertices)
    assert np.ptp(plain.states_coords[-1], axis=0)[2] == pytest.approx(0, abs=1e-9)
    thick = np.ptp(scene.states_coords[-1], axis=0)[2]
    assert thick == pytest.approx(2 * scene.layer_mm)
    assert 0 < scene.layer_mm < 0.1
    # each face in one plane, and without its lift where it was
    z = scene.states_coords[-1][:, 2].reshape(3, 4)
    assert np.ptp(z, axis=1) == pytest.approx(0, abs=1e-9)
    source = pattern.faces_vertices
    unlifted = scene.states_coords[-1] - scene.lift_mm
    assert unlifted == pytest.approx(plain.states_coords[-1][source])
    assert scene.states_coords[0] == pytest.approx(plain.states_coords[0][source])
    ends = scene.pattern.vertices_coords[scene.pattern.edges_vertices]
    assert ends == pytest.approx(pattern.vertices_coords[pattern.edges_vertices])


def test_scenes_without_an_order_stay_as_they_are():
    pattern = strip([3, 1, 3], "VV")
    pattern = replace(pattern, folded_coords=fold_by_angles(pattern).folded_coords)
    scene = pattern_scene(pattern, "flaps")
    assert layered(scene, layer_orders(pattern)) is scene
    assert layered(scene, None) is scene
