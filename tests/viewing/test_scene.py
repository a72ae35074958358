"""Scenes of patterns, simulations and thick sheets: what they show is what was made."""

from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import grid
from thick_sheets import WEBS, book, miura_pattern, thick

from fab.errors import Finding, Severity
from fab.folding.fold_settings import FoldSettings
from fab.folding.folded_states import Stage, flat_panels, folded_states, panels_at
from fab.folding.simulation import fold_and_judge
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.thick_sheet import thicken
from fab.viewing.scales import STRAIN, Scale, ScaleKind, distance_scale
from fab.viewing.scene import Scene, marks
from fab.viewing.scene_builders import (
    folding_scene,
    laid_flat,
    over_surface,
    pattern_scene,
    thick_scene,
)
from solver.errors import InvalidValue
from solver.targets.surface_mesh import SurfaceMesh


def distances(coords, pairs):
    return np.linalg.norm(coords[pairs[:, 0]] - coords[pairs[:, 1]], axis=1)


def random_pairs(count):
    return np.random.default_rng(1).integers(0, count, (300, 2))


def test_a_pattern_has_its_flat_sheet_and_its_folded_form_congruent_to_them():
    pattern = miura_pattern()
    scene = pattern_scene(pattern, "miura")
    assert scene.shares.tolist() == [0.0, 1.0]
    pairs = random_pairs(len(pattern.vertices_coords))
    flat, folded = scene.states_coords
    assert distances(flat, pairs) == pytest.approx(distances(pattern.vertices_coords, pairs))
    assert distances(folded, pairs) == pytest.approx(distances(pattern.folded_coords, pairs))
    # the longest directions lie flat, the sheet is not mirrored and its upper side is up
    assert np.all(np.diff(np.ptp(folded, axis=0)) < 0)
    for coords in (flat, folded):
        a, b, c = coords[pattern.faces_vertices[:3]]
        assert np.cross(b - a, c - b)[2] > 0


def test_an_upright_form_keeps_its_pose():
    pattern = miura_pattern()
    scene = pattern_scene(pattern, "miura", upright=True)
    assert np.array_equal(scene.folded_coords, pattern.folded_coords)


def test_a_pattern_without_a_folded_form_is_flat_alone():
    scene = pattern_scene(grid(2, 2, 10.0), "grid")
    assert scene.state_count == 1
    assert scene.folded_coords is None
    assert np.ptp(scene.states_coords[0, :, 2]) == 0


def test_a_form_that_is_turned_over_is_laid_with_its_upper_side_up():
    pattern = grid(3, 2, 10.0)
    over = np.pad(pattern.vertices_coords, ((0, 0), (0, 1))) * [1.0, -1.0, -1.0]
    turn, shift = laid_flat(pattern, over)
    assert np.linalg.det(turn) == pytest.approx(1)
    coords = over @ turn.T + shift
    a, b, c = coords[pattern.faces_vertices[:3]]
    assert np.cross(b - a, c - b)[2] > 0
    assert coords.mean(axis=0) == pytest.approx(0)


def test_a_simulation_has_all_its_states_with_strain_in_percent():
    pattern = miura_pattern(3, 2)
    folding, _, _ = fold_and_judge(pattern, FoldSettings(steps=4))
    scene = folding_scene(folding, "miura")
    assert scene.shares == pytest.approx([state.load for state in folding.states])
    pairs = random_pairs(len(pattern.vertices_coords))
    for coords, state in zip(scene.states_coords, folding.states, strict=True):
        simulated = distances(state.coords, pairs) * folding.frame.size_mm
        assert distances(coords, pairs) == pytest.approx(simulated)
    largest = [100 * state.strain_max for state in folding.states]
    assert scene.values.values.max(axis=1) == pytest.approx(largest)
    assert scene.values.scale is STRAIN


def test_an_upright_simulation_ends_in_the_pose_of_the_folded_form():
    pattern = miura_pattern(3, 2)
    folding, verdict, _ = fold_and_judge(pattern, FoldSettings(steps=4))
    assert verdict.reached
    scene = folding_scene(folding, "miura", upright=True)
    assert scene.folded_coords == pytest.approx(pattern.folded_coords, abs=1e-3)


def test_findings_of_a_simulation_have_the_numbers_of_the_sheet_with_open_cuts():
    pattern = grid(3, 2, 10.0, cuts=[(1, 5)])
    between = pattern.edges_vertices.tolist().index([1, 5])
    other = pattern.edges_vertices.tolist().index([2, 6])
    folding, _, _ = fold_and_judge(pattern, FoldSettings(steps=2))
    finding = Finding("x", Severity.NOTE, "", creases=(between, other), panels=(0,))
    scene = folding_scene(folding, "grid", findings=[finding])
    found = scene.findings[0]
    ends = marks(scene.pattern, found).creases
    # the cut has two sides, the crease stays one; both where they were
    expected = sorted([[[10.0, 0.0], [10.0, 10.0]]] * 2 + [[[20.0, 0.0], [20.0, 10.0]]])
    assert sorted(np.sort(each, axis=0).tolist() for each in ends) == expected
    assert found.panels == (0,)


@pytest.mark.parametrize("upright", [False, True])
def test_thick_bodies_move_with_their_faces_in_every_state(upright):
    pattern = miura_pattern()
    sheet = thick(pattern)
    states, _ = folded_states(pattern, count=2)
    scene = thick_scene(sheet, states, "miura", upright=upright)
    assert scene.state_count == len(states) == len(scene.bodies.state_names)
    assert scene.shares == pytest.approx([state.share for state in states])
    face = np.repeat(np.arange(pattern.face_count), np.diff(pattern.faces_offsets))
    corners = np.pad(pattern.vertices_coords[pattern.faces_vertices], ((0, 0), (0, 1)))
    for number in range(scene.state_count):
        # axes are at z = 0, so rigid faces have their corners where the sheet has its vertices
        turns, shifts = scene.bodies.turns[number][face], scene.bodies.shifts[number][face]
        moved = np.einsum("nij,nj->ni", turns, corners) + shifts
        assert moved == pytest.approx(scene.states_coords[number][pattern.faces_vertices], abs=1e-6)
    folded = scene.bodies.coords_in(scene.state_count - 1)
    assert np.isfinite(folded).all()
    first = sheet.bodies.vertices_body == 0
    pairs = random_pairs(int(first.sum()))
    flat = sheet.bodies.vertices_coords[first]
    assert distances(folded[first], pairs) == pytest.approx(distances(flat, pairs))


def test_upright_thick_sheets_have_the_pose_of_their_target():
    pattern = book(60.0)
    target = panels_at(pattern, pattern.folded_coords, Stage.TARGET, 1.0)
    scene = thick_scene(thick(pattern), [flat_panels(pattern), target], "book", upright=True)
    assert scene.folded_coords == pytest.approx(pattern.folded_coords)


def test_halves_of_webs_move_with_the_panels_on_their_sides():
    pattern = book(60.0)
    sheet, _ = thicken(pattern, PanelSettings(thickness_mm=0.8, gap_mm=0.4), WEBS)
    bodies = thick_scene(sheet, [flat_panels(pattern)], "book").bodies
    web = bodies.creases[sheet.bodies.vertices_body] >= 0
    assert web.any()
    left = sheet.bodies.vertices_coords[:, 0] < 0
    assert (bodies.vertices_face[web] == np.where(left[web], 1, 0)).all()


def test_films_are_shown_flat_alone():
    pattern = book(60.0)
    film = WEBS.model_copy(update={"kind": "film"})
    sheet, _ = thicken(pattern, PanelSettings(thickness_mm=0.8, gap_mm=0.4), film)
    target = panels_at(pattern, pattern.folded_coords, Stage.TARGET, 1.0)
    bodies = thick_scene(sheet, [flat_panels(pattern), target], "book").bodies
    owner = np.array(["film" in name for name in bodies.names])[sheet.bodies.vertices_body]
    assert owner.any()
    assert np.isfinite(bodies.coords_in(0)).all()
    assert np.isnan(bodies.coords_in(1)[owner]).all()
    assert np.isfinite(bodies.coords_in(1)[~owner]).all()


def test_faces_have_their_signed_distance_from_a_surface():
    pattern = grid(4, 3, 10.0)
    lifted = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)), constant_values=0.7)
    scene = pattern_scene(replace(pattern, folded_coords=lifted), "grid", upright=True)
    corners = np.array([[-50.0, -50, 0], [90, -50, 0], [90, 90, 0], [-50, 90, 0]])
    up = SurfaceMesh.of(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    down = SurfaceMesh.of(corners, np.array([[0, 2, 1], [0, 3, 2]]))
    for surface, sign in ((up, 1.0), (down, -1.0)):
        values = over_surface(scene, surface).values
        assert values.in_state(1) == pytest.approx(np.full(12, sign * 0.7))
        assert (values.scale.low, values.scale.high) == (-1.0, 1.0)


def test_marks_are_in_the_flat_sheet_and_leave_out_what_is_not_in_it():
    pattern = grid(2, 1, 10.0)
    crease = pattern.edges_vertices.tolist().index([1, 4])
    finding = Finding("x", Severity.NOTE, "", (crease, 99), (1, -1), ((3.0, 4.0),))
    found = marks(pattern, finding)
    assert found.creases.tolist() == [[[10.0, 0.0], [10.0, 10.0]]]
    assert found.panels.tolist() == [[15.0, 5.0]]
    assert found.places.tolist() == [[3.0, 4.0]]
    nothing = marks(pattern, Finding("x", Severity.NOTE, ""))
    assert nothing.creases.shape == (0, 2, 2)
    assert nothing.panels.shape == nothing.places.shape == (0, 2)


def test_scales_are_absolute():
    """The strain of one sheet has the same colour whatever that of others is."""
    assert STRAIN.shares(np.array([0.02])) == STRAIN.shares(np.array([0.02, 3.0]))[:1]
    assert STRAIN.shares(np.array([0.02]))[0] < 0.15
    assert [STRAIN.shares(np.array([STRAIN.value_at(s)]))[0] for s in (0.25, 0.9)] == pytest.approx(
        [0.25, 0.9]
    )
    for largest, end in ((0.0, 0.1), (0.11, 0.2), (0.2, 0.2), (3.0, 5.0), (5.1, 10.0), (99, 100)):
        assert distance_scale(np.array([-largest])).high == pytest.approx(end)


def test_arrays_that_do_not_fit_are_refused():
    pattern = grid(2, 1, 10.0)
    flat = np.zeros((1, len(pattern.vertices_coords), 3))
    with pytest.raises(InvalidValue, match="states_coords"):
        Scene("x", pattern, np.zeros(2), flat)
    with pytest.raises(InvalidValue, match="states_coords"):
        Scene("x", pattern, np.zeros(0), flat[:0])
    with pytest.raises(InvalidValue, match="scale"):
        Scale("x", "mm", 0.0, 1.0, ScaleKind.LOGARITHMIC)
