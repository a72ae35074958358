"""GLB files of sheets and thick bodies: states, sides, motion and animation, read back."""

import io
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import trimesh
from flat_patterns import grid, triangles
from glb_reading import channels, chunks, read_glb, rows, states_of, validated
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from thick_sheets import miura_pattern, shipped_pattern, thick

from fab.folding.fold_settings import FoldSettings
from fab.folding.folded_states import folded_states
from fab.folding.simulation import fold_and_judge
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.viewing.glb import bodies_glb_bytes, sheet_glb_bytes
from fab.viewing.scene_builders import folding_scene, pattern_scene, thick_scene
from solver.errors import InvalidState
from solver.polygons import face_normals

TRIANGLES, LINES = 4, 1
FLOAT32 = np.finfo(np.float32).eps


def in_metres(coords):
    """y upwards, as glTF has it."""
    x, y, z = np.moveaxis(np.asarray(coords), -1, 0)
    return np.stack([x, z, -y], axis=-1) / 1000


def near(found, expected):
    """Equal to the rounding of a few float32 operations."""
    assert np.abs(found - expected).max() <= 4 * FLOAT32 * np.abs(expected).max()


@cache
def scene_of(kind):
    pattern = miura_pattern(4, 3)
    if kind == "two states":
        return pattern_scene(pattern, "miura")
    if kind == "flat":
        return pattern_scene(grid(2, 2, 10.0), "grid")
    if kind == "polygons":
        return pattern_scene(shipped_pattern("square_twist", 100.0), "square twist")
    cut = grid(3, 2, 10.0, cuts=[(1, 5)])
    source = triangles(3) if kind == "triangles" else cut if kind == "cuts" else pattern
    folding, _, _ = fold_and_judge(source, FoldSettings(steps=3))
    return folding_scene(folding, kind)


@cache
def thick_scene_of(kind="web"):
    pattern = miura_pattern(3, 3)
    states, _ = folded_states(pattern, count=3)
    if kind == "web":
        return thick_scene(thick(pattern), states, "miura")
    hinges = {
        "film": HingeSettings(kind="film", film_mm=0.2),
        "knuckle": HingeSettings(
            kind="knuckle", knuckle_mm=1.5, pin_mm=0.8, wall_mm=0.5, play_mm=0.1
        ),
    }[kind]
    axis = "middle" if kind == "knuckle" else "bottom"
    panels = PanelSettings(thickness_mm=2.2, gap_mm=0.4, axis=axis)
    return thick_scene(thicken(pattern, panels, hinges)[0], states, "miura")


SCENES = ["two states", "flat", "polygons", "triangles", "cuts", "simulated"]


@pytest.mark.parametrize("kind", SCENES)
def test_every_state_is_where_the_scene_has_it(kind):
    scene = scene_of(kind)
    document = read_glb(sheet_glb_bytes(scene))
    states = in_metres(scene.states_coords)
    upper, lower, *lines = document.meshes[0].primitives
    corners = scene.pattern.faces_vertices
    near(states_of(document, upper, "POSITION"), states[:, corners])
    apart = states_of(document, lower, "POSITION") - states[:, corners]
    under = np.hypot(*np.ptp(scene.pattern.vertices_coords, axis=0)) / 5000 / 1000
    expected = under * states_of(document, lower, "NORMAL")
    assert np.abs(apart - expected).max() <= 8 * FLOAT32 * np.abs(states).max()
    drawn = 0
    for each in lines:
        assert each.mode == LINES
        near(states_of(document, each, "POSITION"), states)
        edges = rows(document, each.indices).reshape(-1, 2)
        letter = document.materials[each.material].name.removeprefix("edges ")
        own = scene.pattern.edges_vertices[scene.pattern.edges_assignment == letter]
        assert edges.tolist() == own.tolist()
        drawn += len(edges)
    assert drawn == len(scene.pattern.edges_vertices)


@pytest.mark.parametrize("kind", SCENES)
def test_sides_look_away_from_each_other_with_the_normals_of_their_faces(kind):
    scene = scene_of(kind)
    pattern = scene.pattern
    document = read_glb(sheet_glb_bytes(scene))
    upper, lower, *_ = document.meshes[0].primitives
    above, below = (rows(document, side.indices).reshape(-1, 3) for side in (upper, lower))
    assert above[:, ::-1].tolist() == below.tolist()
    sizes = np.diff(pattern.faces_offsets)
    assert len(above) == (sizes - 2).sum()
    for number, coords in enumerate(scene.states_coords):
        normals = face_normals(coords, pattern.faces_vertices, pattern.faces_offsets)
        expected = in_metres(1000 * np.repeat(normals, sizes, axis=0))
        near(states_of(document, upper, "NORMAL")[number], expected)
        near(states_of(document, lower, "NORMAL")[number], -expected)
    flat = states_of(document, upper, "POSITION")[0]
    a, b, c = flat[above].swapaxes(0, 1)
    areas = np.cross(b - a, c - a) @ states_of(document, upper, "NORMAL")[0][0]
    assert (areas > 0).all()  # counterclockwise seen from above
    total = 0.5 * areas.sum() * 1e6
    x, y = pattern.vertices_coords[pattern.faces_vertices].T
    following = np.arange(1, len(x) + 1)
    following[pattern.faces_offsets[1:] - 1] = pattern.faces_offsets[:-1]
    assert total == pytest.approx(0.5 * (x * y[following] - x[following] * y).sum(), rel=1e-5)


def test_the_fold_goes_from_state_to_state_and_ends_where_still_viewers_show_it():
    scene = scene_of("simulated")
    document = read_glb(sheet_glb_bytes(scene))
    count = scene.state_count
    ((key, (times, weights)),) = channels(document).items()
    assert key == ("simulated", "weights")
    assert times == pytest.approx(np.linspace(0, 4, count))
    assert weights.reshape(count, count - 1).tolist() == np.eye(count)[:, 1:].tolist()
    assert document.meshes[0].weights == [0.0] * (count - 2) + [1.0]
    names = document.meshes[0].extras["targetNames"]
    assert [float(name) for name in names] == pytest.approx(scene.shares[1:], abs=1e-3)


def test_a_sheet_that_is_known_flat_alone_has_no_animation():
    document = read_glb(sheet_glb_bytes(scene_of("flat")))
    assert document.animations == []
    assert document.meshes[0].primitives[0].targets == []


@pytest.mark.parametrize("kind", ["web", "knuckle", "film"])
def test_bodies_are_where_the_scene_has_them_at_all_times(kind):
    scene = thick_scene_of(kind)
    bodies = scene.bodies
    document = read_glb(bodies_glb_bytes(scene))
    moving = channels(document)
    by_name = {node.name: node for node in document.nodes}
    shown = []
    for body in np.flatnonzero(bodies.faces >= 0).tolist():
        name = bodies.names[body]
        node = by_name[name]
        (primitive,) = document.meshes[node.mesh].primitives
        local = rows(document, primitive.attributes.POSITION)
        times, turns = moving[name, "rotation"]
        _, shifts = moving[name, "translation"]
        assert times == pytest.approx(np.linspace(0, 4, scene.state_count))
        assert node.rotation == pytest.approx(turns[-1])
        assert node.translation == pytest.approx(shifts[-1])
        assert (np.sum(turns[1:] * turns[:-1], axis=1) > 0).all()  # the short way around
        own = bodies.bodies.vertices_body == body
        for state in range(scene.state_count):
            found = Rotation.from_quat(turns[state]).apply(local) + shifts[state]
            expected = in_metres(bodies.coords_in(state)[own])
            at_the_same_places(found, expected)
        shown.append(name)
    if kind == "web":
        bent = document.meshes[by_name["hinges"].mesh].primitives
        web = bodies.creases[bodies.bodies.vertices_body] >= 0
        for state in range(scene.state_count):
            found = np.concatenate([states_of(document, each, "POSITION")[state] for each in bent])
            expected = in_metres(bodies.coords_in(state)[web])
            at_the_same_places(found, expected)
        shown.append("hinges")
    assert sorted(by_name) == sorted(shown)  # films are left out


def test_panels_that_are_alike_share_a_mesh_and_hinges_take_a_number_a_corner():
    pattern = miura_pattern(6, 6)
    states, _ = folded_states(pattern, count=3)
    scene = thick_scene(thick(pattern), states, "miura")
    document = read_glb(bodies_glb_bytes(scene))
    panels = [node.mesh for node in document.nodes if node.name.startswith("panel")]
    assert len(panels) == 36
    # corners, two kinds along each side, and four within, as parallelograms lie in four ways
    assert len(set(panels)) == 4 + 4 * 2 + 4
    (hinges,) = [node.mesh for node in document.nodes if node.name == "hinges"]
    webs = np.flatnonzero(scene.bodies.creases >= 0)
    corners = np.isin(scene.bodies.bodies.vertices_body, webs).sum()
    drawn = document.meshes[hinges].primitives
    assert sum(len(rows(document, each.attributes.POSITION)) for each in drawn) == corners
    assert all(each.attributes.NORMAL is None for each in drawn)


def at_the_same_places(found, expected):
    """Vertices that are repeated for every side, to the rounding of float32."""
    bound = 16 * FLOAT32 * np.abs(expected).max()
    assert KDTree(expected).query(found)[0].max() <= bound
    assert KDTree(found).query(expected)[0].max() <= bound


def test_another_reader_finds_closed_panels_of_their_volume_at_the_target():
    scene = thick_scene_of()
    loaded = trimesh.load(io.BytesIO(bodies_glb_bytes(scene)), file_type="glb")
    volumes = dict(zip(scene.bodies.names, scene.bodies.bodies.volumes_mm3(), strict=True))
    found = 0
    for name in loaded.graph.nodes_geometry:
        turn, geometry = loaded.graph[name]
        mesh = loaded.geometry[geometry].copy()
        mesh.apply_transform(turn)
        mesh.merge_vertices(merge_norm=True, merge_tex=True)
        if name.startswith("hinges"):
            continue
        assert mesh.is_watertight
        assert mesh.volume * 1e9 == pytest.approx(volumes[name], rel=1e-4)
        body = scene.bodies.names.index(name)
        own = scene.bodies.bodies.vertices_body == body
        expected = in_metres(scene.bodies.coords_in(scene.state_count - 1)[own])
        assert mesh.bounds == pytest.approx(
            np.stack([expected.min(axis=0), expected.max(axis=0)]), abs=1e-8
        )
        found += 1
    assert found == (scene.bodies.faces >= 0).sum()


@pytest.mark.parametrize("kind", [*SCENES, "web", "knuckle", "film"])
def test_the_khronos_validator_finds_nothing(kind, tmp_path):
    if kind in SCENES:
        data = sheet_glb_bytes(scene_of(kind))
    else:
        data = bodies_glb_bytes(thick_scene_of(kind))
    assert chunks(data) == [b"JSON", b"BIN\0"]
    found = validated(data, tmp_path)["issues"]
    assert found["messages"] == []


def test_the_validator_finds_what_is_wrong(tmp_path):
    data = sheet_glb_bytes(scene_of("flat")).replace(b'"VEC3"', b'"VEC9"')
    assert validated(data, tmp_path)["issues"]["numErrors"] > 0


def test_the_same_scene_gives_the_same_bytes():
    scene = thick_scene_of()
    assert bodies_glb_bytes(scene) == bodies_glb_bytes(replace(scene))
    assert sheet_glb_bytes(scene) == sheet_glb_bytes(replace(scene))


def test_a_scene_without_bodies_has_none_to_write():
    with pytest.raises(InvalidState, match="no thick bodies"):
        bodies_glb_bytes(scene_of("flat"))
