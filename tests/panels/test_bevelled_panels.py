"""Panels against areas, half-spaces and folded pairs that are computed in other ways."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from flat_patterns import pattern_of
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from manifold3d import Error
from pydantic import ValidationError
from scipy.spatial import ConvexHull, HalfspaceIntersection
from solid_patterns import creased, folded_pair, ringed

from fab.errors import Severity
from fab.geometry.bodies import bodies_of
from fab.geometry.booleans import manifold_of, manifolds
from fab.panels.bevelled_panels import LEAST_RADIUS_MM, PanelSettings, _cut, make_panels
from fab.panels.inset_limits import inradii
from fab.panels.inset_sides import SHORTEST_SIDE_MM, inset, spans
from fab.panels.setbacks import Setbacks, setbacks, sides_of
from fab.pattern.face_poses import face_poses

AXES = st.sampled_from(
    [(0.0, 1.6), (-0.8, 0.8), (-0.4, 1.2), (0.3, 1.9), (-1.6, 0.0), (-2.0, -0.4)]
)


def backs(pattern, heights=(0.0, 1.6), gap=1.0, clearance=0.1) -> Setbacks:
    none = np.zeros(len(pattern.edges_vertices))
    return setbacks(pattern, heights, gap_mm=gap, clearance_mm=clearance, hinge_mm=none)


@st.composite
def polygons(draw):
    """Convex rings of 3 to 8 corners on an ellipse, no two of them close."""
    n = draw(st.integers(3, 8))
    steps = np.array(draw(st.lists(st.floats(1.0, 4.0), min_size=n, max_size=n)))
    angle = draw(st.floats(0, 6.28)) + np.cumsum(steps) * 2 * np.pi / steps.sum()
    size = draw(st.floats(8.0, 40.0))
    return size * np.column_stack([np.cos(angle), draw(st.floats(0.4, 1.0)) * np.sin(angle)])


folds = st.floats(-150.0, 150.0)


def halfspaces(pattern, back, heights, face):
    """a . x + b <= 0 of one panel, straight from the definition of the setbacks."""
    sides = sides_of(pattern)
    rows = np.arange(*sides.offsets[face : face + 2])
    out = [[0, 0, -1, heights[0]], [0, 0, 1, -heights[1]]]
    for n, start, edge in zip(
        sides.inward[rows], sides.start[rows], sides.edges[rows], strict=True
    ):
        b = n @ start + back.axis_mm[edge]
        out += [[-n[0], -n[1], -back.below[edge], b], [-n[0], -n[1], back.above[edge], b]]
    return np.array(out)


# Its panel loses a side just below its upper end.
SHORT_SIDE = np.array(
    [
        [4.98791841, 2.50430397],
        [-7.20775094, 1.38978385],
        [-7.20775094, -1.38978385],
        [-1.78016747, -3.12281597],
        [8.0, 0.0],
    ]
)


def test_inset_of_a_square_with_its_own_setbacks():
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    moved, kept = inset(square, np.array([0, 4]), np.array([1.0, 2.0, 0.0, 0.5]))
    assert moved == pytest.approx(np.array([[0.5, 1], [8, 1], [8, 10], [0.5, 10]]))
    assert kept.tolist() == [True]
    _, kept = inset(square, np.array([0, 4]), np.array([1.0, 5.0, 0.0, 5.0]))
    assert kept.tolist() == [False]


def test_inset_at_reflex_and_straight_corners():
    dart = np.array([[0.0, 0], [4, 4], [0, 1], [-4, 4]]) * 5
    moved, kept = inset(dart, np.array([0, 4]), np.full(4, 0.2))
    assert kept.all()
    sides = np.roll(dart, -1, axis=0) - dart
    normal = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    assert ((moved - dart) * normal).sum(axis=1) == pytest.approx(np.full(4, 0.2))
    straight = np.array([[0.0, 0], [5, 0], [10, 0], [10, 10], [0, 10]])
    moved, kept = inset(straight, np.array([0, 5]), np.full(5, 1.0))
    assert moved[1] == pytest.approx([5, 1])
    assert kept.all()


@settings(max_examples=25)
@given(polygons(), st.floats(-120.0, 120.0), AXES, st.floats(0.1, 1.0))
@example(np.array([[0.0, 3.5], [-8.0, 0.0], [8.0, 0.0]]), 72.0, (0.0, 1.6), 1.0)  # nearly vanishes
@example(SHORT_SIDE, 74.0, (0.0, 1.6), 1.0)
def test_volume_is_that_of_sections_with_mitred_corners(ring, angle, heights, gap):
    pattern = ringed(ring, angle)
    back = backs(pattern, heights, gap)
    panels, findings = make_panels(pattern, heights, back)
    assume(not findings)
    edge = int(np.flatnonzero(back.above + back.below)[0]) if angle else 0

    def section(z, further=0.0):
        setback = float(back.at(z)[edge]) + further
        return shapely.Polygon(ring).buffer(-setback, join_style="mitre", mitre_limit=1e6)

    levels = sorted({heights[0], heights[1], *([0.0] if heights[0] < 0 < heights[1] else [])})
    # what vanishes on the way, or nearly so, is tested below
    assume(all(len(shapely.get_coordinates(section(z, 0.05))) == len(ring) + 1 for z in levels))
    exact = 0.0
    for low, high in pairwise(levels):
        areas = [section(z).area for z in (low, (low + high) / 2, high)]
        exact += (high - low) * (areas[0] + 4 * areas[1] + areas[2]) / 6  # exact for parabolas
    assert panels.faces[0] == 0
    assert panels.bodies.volumes_mm3()[0] == pytest.approx(exact, rel=1e-6)  # of the buffer


@settings(max_examples=30)
@given(polygons(), st.lists(folds, min_size=8, max_size=8), AXES, st.floats(0.1, 3.0))
def test_panels_are_what_all_setback_planes_leave(ring, angles, heights, gap):
    """With sides that vanish and without: against an intersection of half-spaces."""
    pattern = ringed(ring, angles[: len(ring)])
    back = backs(pattern, heights, gap)
    panels, _ = make_panels(pattern, heights, back)
    bodies = dict(zip(panels.faces.tolist(), range(len(panels.bodies)), strict=True))
    sides = sides_of(pattern)
    for face in range(pattern.face_count):
        if face not in bodies:
            assert min(inradii(sides, back.at(z))[face] for z in heights) < LEAST_RADIUS_MM
            continue
        mesh = panels.bodies.mesh(bodies[face])
        assert manifold_of(mesh).status() == Error.NoError
        planes = halfspaces(pattern, back, heights, face)
        off = mesh.vertices_coords @ planes[:, :3].T + planes[:, 3]
        assert (off < 1e-9).all()  # nothing lies beyond a setback
        hull = HalfspaceIntersection(planes, mesh.vertices_coords.mean(axis=0))
        exact = ConvexHull(hull.intersections).volume
        volume = panels.bodies.volumes_mm3()[bodies[face]]
        assert volume == pytest.approx(exact, rel=1e-9)
        assert manifold_of(mesh).volume() == pytest.approx(exact, rel=1e-9)
        # triangles of one planar side lie in one plane
        for plane in np.unique(mesh.triangles_plane):
            corners = mesh.triangles[mesh.triangles_plane == plane].ravel()
            assert (np.abs(off[corners]).max(axis=0) < 1e-7).any()
    assert sides.offsets[-1] == len(sides.start)


def whole(pattern, back, heights):
    """Which faces keep all their sides, seen at each height alone."""
    sides = sides_of(pattern)
    levels = [*heights, 0.0] if heights[0] < 0 < heights[1] else heights
    kept = [inset(sides.start, sides.offsets, back.at(z)[sides.edges])[1] for z in levels]
    return np.logical_and.reduce(kept)


@settings(max_examples=25)
@given(polygons(), st.lists(folds, min_size=8, max_size=8), AXES)
def test_stacked_and_cut_panels_are_the_same_where_no_side_vanishes(ring, angles, heights):
    pattern = ringed(ring, angles[: len(ring)])
    back = backs(pattern, heights, 0.3)
    assume(whole(pattern, back, heights).all())
    panels, findings = make_panels(pattern, heights, back)
    assert findings == []
    for face in range(pattern.face_count):
        cut = _cut(panels.sides, back, heights, face)
        first, second = panels.bodies.mesh(face).vertices_coords, cut.vertices_coords
        assert bodies_of([cut]).volumes_mm3()[0] == pytest.approx(
            panels.bodies.volumes_mm3()[face], rel=1e-9
        )
        # both may have idle vertices within their walls
        ends = first[np.isin(first[:, 2], heights)]
        assert np.linalg.norm(second[:, None] - ends, axis=2).min(axis=0).max() < 1e-8


@settings(max_examples=25)
@given(polygons(), st.lists(folds, min_size=8, max_size=8), AXES, st.floats(0.1, 2.0))
def test_no_side_of_a_whole_panel_is_short(ring, angles, heights, gap):
    pattern = ringed(ring, angles[: len(ring)])
    back = backs(pattern, heights, gap)
    assume(whole(pattern, back, heights).all())
    panels, findings = make_panels(pattern, heights, back)
    assert findings == []
    lengths = panels.sides.length_mm
    for z in {*heights, 0.0} if heights[0] < 0 < heights[1] else heights:
        low, high = spans(panels.sides, back, z, np.arange(len(lengths)))
        assert (high - low >= np.minimum(SHORTEST_SIDE_MM, lengths / 2) - 1e-9).all()


@given(st.floats(-170.0, 170.0), AXES, st.floats(0.05, 2.0), st.floats(0.0, 1.0))
def test_a_folded_pair_is_as_far_apart_as_predicted(angle, heights, gap, clearance):
    """2 (s0 cos(rho / 2) + off sin(rho / 2)), off the height of the corner next to the axis."""
    pattern = folded_pair(angle)
    back = backs(pattern, heights, gap, clearance)
    assume(back.at(heights[1]).max() < 25 and back.at(heights[0]).max() < 25)
    panels, findings = make_panels(pattern, heights, back)
    assert findings == []
    (crease,) = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)
    half = np.radians(abs(angle)) / 2
    off = max(0.0, -heights[1]) if angle > 0 else max(0.0, heights[0])
    exact = 2 * (back.axis_mm[crease] * np.cos(half) + off * np.sin(half))
    assert back.clearance_mm[crease] == pytest.approx(exact, rel=1e-12)
    assert exact >= clearance - 1e-12
    first, second = manifolds(panels.bodies.moved(*face_poses(pattern, pattern.folded_coords)))
    assert (first ^ second).volume() < 1e-9
    assert first.min_gap(second, exact + 1) == pytest.approx(exact, abs=1e-9)


def overlap_mm3(pattern, heights, back) -> float:
    panels, _ = make_panels(pattern, heights, back)
    first, second = manifolds(panels.bodies.moved(*face_poses(pattern, pattern.folded_coords)))
    return float((first ^ second).volume())


@pytest.mark.parametrize(("angle", "heights"), [(100.0, (0.0, 1.6)), (-70.0, (-2.0, 0.5))])
def test_a_naive_vertical_cut_is_caught_with_its_overlap(angle, heights):
    """Negative control: two corners beyond the bisecting plane, (t tan h - s)^2 / tan h."""
    pattern = folded_pair(angle)
    back = backs(pattern, heights)
    assert overlap_mm3(pattern, heights, back) < 1e-9
    level = np.zeros(len(back.above))
    naive = Setbacks(back.axis_mm, level, level, back.clearance_mm)
    slope = np.tan(np.radians(abs(angle)) / 2)
    depth = heights[1] if angle > 0 else -heights[0]
    exact = (depth * slope - 0.5) ** 2 / slope * 20.0
    assert overlap_mm3(pattern, heights, naive) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("angle", [100.0, -100.0])
def test_a_bevel_on_the_wrong_side_is_caught_with_its_overlap(angle):
    """Negative control: the side that closes has corners as a vertical cut has them."""
    pattern, heights = folded_pair(angle), (-1.0, 1.0)
    back = backs(pattern, heights)
    wrong = Setbacks(back.axis_mm, back.below, back.above, back.clearance_mm)
    slope = np.tan(np.radians(50.0))
    exact = (slope - 0.5) ** 2 / slope * 20.0
    assert overlap_mm3(pattern, heights, wrong) == pytest.approx(exact, rel=1e-9)


def test_a_short_side_vanishes_with_a_finding_and_an_exact_volume():
    """A square of 20 with a corner cut off by a side of 0.5 sqrt 2, at setbacks of 1."""
    ring = np.array([[0, 0], [20, 0], [20, 19.5], [19.5, 20], [0, 20]])
    pattern = ringed(ring, 0.0)
    panels, findings = make_panels(pattern, (0.0, 2.0), backs(pattern, gap=2.0))
    (short,) = np.flatnonzero(
        (np.sort(pattern.edges_vertices, axis=1) == [2, 3]).all(axis=1)
    ).tolist()
    assert [(f.code, f.severity, f.creases) for f in findings] == [
        ("panel-side-vanishes", Severity.WARNING, (short,))
    ]
    assert panels.bodies.volumes_mm3()[0] == pytest.approx(18 * 18 * 2, rel=1e-12)
    assert len(panels.bodies.mesh(0).vertices_coords) == 8
    assert len(np.unique(panels.bodies.mesh(0).triangles_plane)) == 6


def test_a_square_has_a_panel_up_to_half_its_side_and_no_further():
    """20 wide, axis at the bottom, valleys: setbacks of 1 + t tan 45 must stay below 10."""
    pattern = ringed(np.array([[0.0, 0], [20, 0], [20, 20], [0, 20]]), 90.0)
    for thickness, feasible in ((8.9, True), (8.99, False), (9.1, False)):
        heights = (0.0, thickness)
        panels, _ = make_panels(pattern, heights, backs(pattern, heights, gap=2.0))
        assert (0 in panels.faces.tolist()) is feasible
        if feasible:
            exact = (18**3 - (18 - 2 * thickness) ** 3) / 6  # a frustum
            assert panels.bodies.volumes_mm3()[0] == pytest.approx(exact, rel=1e-12)


def test_creases_that_fold_flat_leave_no_panel_and_a_limit_saves_them():
    pattern = folded_pair(180.0)
    assert len(make_panels(pattern, (0.0, 1.6), backs(pattern))[0].faces) == 0
    none = np.zeros(len(pattern.edges_vertices))
    back = setbacks(pattern, (0.0, 1.6), gap_mm=1, clearance_mm=0.1, hinge_mm=none, limit_deg=150.0)
    panels, findings = make_panels(pattern, (0.0, 1.6), back)
    assert (len(panels.faces), findings) == (2, [])
    # panels above a sheet that folds them apart need no bevel at all
    mountain = folded_pair(180.0)
    mountain = creased(mountain, -mountain.edges_foldAngle)
    assert len(make_panels(mountain, (0.3, 1.9), backs(mountain, (0.3, 1.9)))[0].faces) == 2


def test_polygons_of_more_than_four_sides_that_are_not_convex_keep_all_sides_or_are_named():
    ell = np.array([[0.0, 0], [30, 0], [30, 10], [10, 10], [10, 30], [0, 30]])
    faces = [[0, 1, 2, 3, 4, 5], [6, 7, 1, 0]]
    coords = np.concatenate([ell, [[0, -20], [30, -20]]])
    pattern = pattern_of(coords, faces, "V")
    panels, findings = make_panels(pattern, (0.0, 1.6), backs(pattern))
    assert findings == []
    section = shapely.Polygon(ell) & shapely.box(0, 0.5, 30, 30)
    wedge = (1.6**2 / 2) * 30  # bevel of 45 degrees along the crease
    assert panels.bodies.volumes_mm3()[0] == pytest.approx(section.area * 1.6 - wedge, rel=1e-12)
    panels, findings = make_panels(pattern, (0.0, 9.6), backs(pattern, (0.0, 9.6)))
    assert [f.code for f in findings] == ["panel-not-convex"]
    assert findings[0].panels == (0,)
    assert panels.faces.tolist() == [1]


def test_a_dart_has_a_panel_of_its_exact_volume():
    dart = np.array([[0.0, 0], [40, 40], [0, 10], [-40, 40]])
    pattern = ringed(dart, 0.0)
    panels, findings = make_panels(pattern, (0.0, 2.0), backs(pattern))
    assert not [f for f in findings if 0 in f.panels]
    exact = shapely.Polygon(dart).buffer(-0.5, join_style="mitre", mitre_limit=100).area * 2
    assert panels.bodies.volumes_mm3()[0] == pytest.approx(exact, rel=1e-12)


def test_a_face_with_an_edge_that_ends_within_it_is_named():
    """An edge from the border to the middle of a square: its face runs along it and back."""
    coords = np.array([[0.0, 0], [20, 0], [40, 0], [40, 40], [0, 40], [20, 20]])
    pattern = pattern_of(coords, [[0, 1, 5, 1, 2, 3, 4]])
    panels, findings = make_panels(pattern, (0.0, 1.6), backs(pattern))
    assert len(panels.faces) == 0
    assert [(f.code, f.panels) for f in findings] == [("panel-not-convex", (0,))]


def test_heights_of_the_axis():
    assert PanelSettings(thickness_mm=2.0).heights_mm == (0.0, 2.0)
    assert PanelSettings(thickness_mm=2.0, axis="middle").heights_mm == (-1.0, 1.0)
    offset = PanelSettings(thickness_mm=2.0, axis="offset", axis_mm=-0.5)
    assert offset.heights_mm == (0.5, 2.5)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"axis": "offset"}, "give axis_mm with axis = offset"),
        ({"axis_mm": 0.1}, "and only then"),
        ({"axis": "offset", "axis_mm": 1.7}, r"axis_mm = 1.7 must be at most thickness_mm = 1.6"),
        ({"gap_mm": -0.1}, "greater than or equal to 0.01"),
        ({"clearance_mm": -0.1}, "greater than or equal to 0"),
    ],
)
def test_settings_out_of_bounds_are_refused(wrong, words):
    with pytest.raises(ValidationError, match=words):
        PanelSettings(**wrong)


@pytest.mark.parametrize("letter", ["V", "M"])
@pytest.mark.parametrize("sides", [4, 6])
@pytest.mark.parametrize("heights", [(0.0, 1.6), (-0.8, 0.8)])
def test_a_cut_ring_is_set_back_where_it_closes_as_at_its_creases(sides, letter, heights):
    """A strip of squares that folds to a prism: its first and last edge are one crease."""
    across = 20.0 * np.arange(sides + 1)
    flat = np.array([[x, y] for x in across for y in (0.0, 20.0)])
    faces = [[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(sides)]
    turn = 360.0 / sides
    strip = pattern_of(flat, faces, letter, angle=turn)
    heading = np.radians(turn) * np.arange(sides) * (1 if letter == "V" else -1)
    steps = 20.0 * np.column_stack([np.cos(heading), 0 * heading, np.sin(heading)])
    walked = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    folded = np.repeat(walked, 2, axis=0)
    folded[1::2, 1] = 20.0
    ring = replace(strip, folded_coords=folded)
    back, by_angles = backs(ring, heights), backs(strip, heights)
    ajar = replace(strip, edges_foldAngle=0.99 * strip.edges_foldAngle)
    open_back = backs(ajar, heights)
    creases = strip.edges_faces[:, 1] >= 0
    ends = np.ptp(flat[strip.edges_vertices][:, :, 0], axis=1) == 0
    assert (ends & ~creases).sum() == 2
    for name in ("axis_mm", "above", "below", "clearance_mm"):
        (own,) = np.unique(np.round(getattr(back, name)[creases], 12))
        assert getattr(back, name)[ends] == pytest.approx(own)
        assert getattr(by_angles, name)[ends] == pytest.approx(own)
    assert (back.axis_mm[~ends] == 0).all()
    assert (open_back.axis_mm[~creases] == 0).all()
    gaps = []
    for tube in (ring, ajar):
        panels, _ = make_panels(tube, heights, backs(tube, heights))
        turns, shifts = face_poses(tube, folded)
        first, last = manifolds(panels.bodies.moved(turns, shifts).chosen(np.array([0, sides - 1])))
        gaps.append(first.min_gap(last, 20.0))
    assert gaps == pytest.approx([np.cos(np.radians(turn / 2)), 0.0], abs=1e-9)
