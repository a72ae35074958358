"""Bars and hinges: what they join, their energy, its exact derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import fan, grid, pattern_of, triangles
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.folding.bar_hinge_model import framework, hinge_forces, wrapped
from fab.folding.fold_settings import Stiffness
from fab.pattern.crease_pattern import fold_angles_deg
from fab.pattern.open_cuts import opened
from solver import InvalidValue
from solver.hinge_angles import hinge_angles
from solver.vectors import norm


def crumpled(frame, seed, size=0.02):
    """The flat sheet with all vertices moved a little, and random targets."""
    random = np.random.default_rng(seed)
    shortest = frame.bars_length.min()
    coords = frame.vertices_coords + size * shortest * random.normal(
        size=(len(frame.vertices_coords), 3)
    )
    coords[:, 2] += 0.3 * shortest * random.normal(size=len(coords))
    return coords, random.uniform(-np.pi, np.pi, len(frame.hinges_target))


def test_a_grid_has_the_bars_and_hinges_of_its_squares():
    pattern = grid(3, 2, 10.0)
    frame = framework(pattern)
    sides = len(pattern.edges_vertices)
    assert len(frame.bars_vertices) == sides + 6  # and a diagonal for each square
    facets = frame.hinges_edge < 0
    assert facets.sum() == 6
    creases = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)
    assert sorted(frame.hinges_edge[~facets].tolist()) == creases.tolist()
    assert frame.size_mm == pytest.approx(np.hypot(30, 20))
    assert frame.bars_length.max() == pytest.approx(np.hypot(10, 10) / frame.size_mm)
    assert np.degrees(frame.hinges_target[~facets]) == pytest.approx(90)
    assert not frame.hinges_target[facets].any()
    assert frame.energy(frame.vertices_coords, 0 * frame.hinges_target).total == 0
    ends = frame.hinges_vertices[~facets][:, :2]
    assert (np.sort(ends) == np.sort(pattern.edges_vertices[frame.hinges_edge[~facets]])).all()


def test_energy_is_that_of_springs_worked_out_by_hand():
    """Two triangles on a square, folded to a right angle: the diagonal is the one crease."""
    pattern = pattern_of([[0, 0], [4, 0], [4, 4], [0, 4]], [[0, 1, 2], [0, 2, 3]], "V", angle=60.0)
    frame = framework(pattern, Stiffness(axial=3.0, crease=2.0))
    size = np.hypot(4, 4)
    assert frame.size_mm == pytest.approx(size)
    folded = frame.vertices_coords.copy()
    folded[3] = [2 / size, 2 / size, 0.5]  # half a diagonal above the middle
    assert np.degrees(hinge_angles(folded, frame.hinges_vertices)) == pytest.approx([90.0])
    energy = frame.energy(folded, frame.hinges_target)
    assert energy.bars == pytest.approx(0, abs=1e-28)
    assert energy.hinges == pytest.approx(2.0 * 1.0 / 2 * np.radians(30) ** 2)
    stretched = 1.01 * folded
    sides = 4 * (4 / size) + 1.0
    assert frame.energy(stretched, frame.hinges_target).bars == pytest.approx(
        3.0 / 2 * 0.01**2 * sides
    )
    assert frame.strains(stretched) == pytest.approx(0.01)


def test_fold_angles_are_those_of_the_crease_pattern():
    frame = framework(triangles(4))
    coords, _ = crumpled(frame, 1)
    sheet = frame.sheet.pattern
    wanted = fold_angles_deg(coords, sheet.edges, sheet.faces_vertices, sheet.faces_offsets)
    found = np.degrees(hinge_angles(coords, frame.hinges_vertices))
    assert found == pytest.approx(wanted[frame.hinges_edge], abs=1e-6)


@pytest.mark.parametrize(
    "make", [lambda s: triangles(s), lambda s: grid(3, 3, 5.0), lambda s: fan(7, 3.0)]
)
@given(seed=st.integers(0, 10_000))
@settings(max_examples=15, deadline=None)
def test_the_gradient_agrees_with_finite_differences(make, seed):
    frame = framework(make(seed % 7))
    coords, target = crumpled(frame, seed)
    # away from the jump half a turn from the target
    off = hinge_angles(coords, frame.hinges_vertices) - target
    target = np.where(np.abs(np.abs(wrapped(off)) - np.pi) < 0.1, target + 0.5, target)
    direction = np.random.default_rng(seed).normal(size=coords.shape)
    direction *= frame.bars_length.min() / norm(direction).max()
    step = 1e-5
    ahead, behind = coords + step * direction, coords - step * direction
    slope = (frame.energy(ahead, target).total - frame.energy(behind, target).total) / (2 * step)
    gradient, _ = frame.linearised(coords, target)
    scale = np.abs(gradient).max() * norm(direction).max()
    assert slope == pytest.approx(float((gradient * direction).sum()), abs=1e-6 * scale)


@pytest.mark.parametrize(
    "make", [lambda s: triangles(s), lambda s: grid(3, 3, 5.0), lambda s: fan(7, 3.0)]
)
@given(seed=st.integers(0, 10_000))
@settings(max_examples=15, deadline=None)
def test_at_rest_the_gauss_newton_matrix_is_the_hessian(make, seed):
    """By differences of the gradient; at rest in any shape, since the matrix knows no lengths."""
    frame = framework(make(seed % 7))
    coords, _ = crumpled(frame, seed)
    target = hinge_angles(coords, frame.hinges_vertices)
    start, end = coords[frame.bars_vertices.T]
    frame = replace(frame, bars_length=norm(end - start))
    gradient, entries = frame.linearised(coords, target)
    lower = frame.assembly.triangle.lower(entries)
    matrix = lower + lower.T
    matrix.setdiag(lower.diagonal())
    assert np.abs(gradient).max() <= 1e-12 * abs(matrix).max()
    direction = np.random.default_rng(seed).normal(size=coords.shape)
    direction *= frame.bars_length.min() / norm(direction).max()
    step = 1e-5
    ahead, behind = (frame.linearised(coords + s * direction, target)[0] for s in (step, -step))
    product = (matrix @ direction.ravel()).reshape(-1, 3)
    assert (ahead - behind) / (2 * step) == pytest.approx(product, abs=1e-6 * np.abs(product).max())


@given(seed=st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_forces_neither_push_nor_turn_the_sheet(seed):
    frame = framework(triangles(seed % 5))
    coords, target = crumpled(frame, seed)
    gradient, _ = frame.linearised(coords, target)
    for force in (-gradient, hinge_forces(frame, coords, target)):
        size = np.abs(force).max()
        assert np.abs(force.sum(axis=0)).max() <= 1e-9 * size
        assert np.abs(np.cross(coords, force).sum(axis=0)).max() <= 1e-9 * size


def test_folds_past_half_a_turn_are_near_to_it():
    assert wrapped(np.radians([190.0, -190.0, 360.0, 30.0])) == pytest.approx(
        np.radians([-170.0, 170.0, 0.0, 30.0])
    )
    frame = framework(pattern_of([[0, 0], [4, 0], [4, 4], [0, 4]], [[0, 1, 2], [0, 2, 3]], "V"))
    coords = frame.vertices_coords.copy()
    coords[3] = [*coords[1, :2], -1e-3]  # folded over and a little through
    (angle,) = np.degrees(frame.angles_near(coords, np.array([np.pi])))
    assert 180 < angle < 181


def test_cuts_are_opened_and_components_counted():
    pattern = grid(2, 1, 10.0, cuts=[(1, 4)])
    sheet = opened(pattern)
    assert len(sheet.pattern.vertices_coords) == 8
    assert sorted(sheet.vertices_source.tolist()) == [0, 1, 1, 2, 3, 4, 4, 5]
    assert set(sheet.pattern.edges_assignment) == {"B"}
    assert (pattern.vertices_coords[sheet.vertices_source] == sheet.pattern.vertices_coords).all()
    assert framework(pattern).component.max() == 1
    whole = opened(grid(2, 1, 10.0))
    assert whole.vertices_source.tolist() == list(range(6))


def test_a_slit_opens_and_holds_at_its_ends():
    pattern = grid(3, 2, 10.0, cuts=[(5, 6)])
    sheet = opened(pattern)  # both ends are joined around: nothing can open, nothing drives it
    assert len(sheet.pattern.vertices_coords) == 12
    assert sheet.pattern.counts()["C"] == 1
    frame = framework(pattern)
    (slit,) = np.flatnonzero(sheet.pattern.edges_assignment[frame.hinges_edge] == "C")
    assert frame.hinges_stiffness[slit] == frame.hinges_target[slit] == 0
    pattern = grid(4, 2, 10.0, cuts=[(6, 7), (7, 8)])
    sheet = opened(pattern)
    assert np.bincount(sheet.vertices_source).tolist() == [1] * 7 + [2] + [1] * 7
    assert framework(pattern).component.max() == 0


def test_unassigned_and_joined_edges_are_free_and_flat():
    letters = ["V", "U", "J"]
    coords = [[0, 0], [3, 0], [3, 2], [0, 2], [6, 0], [6, 2], [9, 0], [9, 2], [12, 0], [12, 2]]
    faces = [[0, 1, 2, 3], [1, 4, 5, 2], [4, 6, 7, 5], [6, 8, 9, 7]]
    between = pattern_of(coords, faces)
    assignment = np.full(len(between.edges_vertices), "M")
    assignment[between.edges_faces[:, 1] >= 0] = letters
    frame = framework(
        pattern_of(coords, faces, assignment), Stiffness(axial=1.0, crease=2.0, facet=3.0)
    )
    creases = frame.hinges_edge >= 0
    letters = frame.sheet.pattern.edges_assignment[frame.hinges_edge[creases]]
    stiff = dict(zip(letters, (frame.hinges_stiffness / frame.hinges_length)[creases], strict=True))
    assert stiff == pytest.approx({"V": 2.0, "U": 0.0, "J": 3.0})


@pytest.mark.parametrize(("key", "value"), [("axial", 0.0), ("crease", -1.0), ("facet", np.nan)])
def test_bad_stiffness_is_refused(key, value):
    with pytest.raises(ValueError, match=key):
        Stiffness(**{key: value})


OUTLINES = [
    [[0, 0], [2, 0], [0, 2]],
    [[0, 0], [2, 0], [2, 2], [0, 2]],
    [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]],
    [[0, 0], [3, 0], [3, 1], [2, 1], [2, 3], [1, 3], [1, 1], [0, 1]],
]


@given(
    outline=st.sampled_from(OUTLINES),
    between=st.lists(st.integers(0, 3), min_size=8, max_size=8),
    turn=st.floats(0, 7),
)
@settings(max_examples=100, deadline=None)
def test_corners_on_straight_sides_make_no_slivers(outline, between, turn):
    """Turned, so that rounding puts some of them on the wrong side of the line."""
    ring = []
    for start, end, count in zip(outline, outline[1:] + outline[:1], between, strict=False):
        share = np.arange(count + 1)[:, None] / (count + 1)
        ring.extend(np.array(start) + share * np.subtract(end, start))
    sine, cosine = np.sin(turn), np.cos(turn)
    coords = np.array(ring) @ [[cosine, sine], [-sine, cosine]]
    frame = framework(pattern_of(coords, [list(range(len(ring)))]))
    corners = frame.size_mm * frame.vertices_coords[frame.triangles_vertices]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.cross(first, second)[:, 2] / 2
    x, y = np.array(outline).T
    assert len(areas) == len(ring) - 2
    assert areas.min() > 0.01
    assert areas.sum() == pytest.approx((x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)


def test_faces_that_cross_themselves_are_refused():
    with pytest.raises(InvalidValue, match="a polygon crosses or touches itself"):
        framework(pattern_of([[0, 0], [2, 2], [2, 0], [0, 2], [-1, 1]], [[0, 1, 2, 3, 4]]))


@pytest.mark.parametrize("size", [1e-300, 1e-101, 1e101, 1e300])
def test_sheets_whose_squared_size_is_out_of_range_are_refused(size):
    with pytest.raises(InvalidValue, match="from 1e-100 to 1e\\+100 mm"):
        framework(grid(2, 1, size))


def test_triangles_without_area_are_named():
    pattern = pattern_of(
        [[0, 0], [4, 0], [8, 0], [4, 4], [4, -3]], [[0, 2, 3], [0, 4, 1], [1, 4, 2]]
    )
    assert framework(pattern)
    with pytest.raises(InvalidValue, match="face 1"):
        framework(pattern_of([[0, 0], [4, 0], [4, 4], [8, 0]], [[0, 1, 2], [0, 3, 1]]))
