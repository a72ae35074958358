"""Hinges of every kind: exact sizes and volumes, and no contact however they are folded."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from flat_patterns import fan, grid, pattern_of
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import Error, Manifold, OpType
from pydantic import ValidationError
from solid_patterns import creased, folded_pair, ringed
from strategies import patches
from thick_sheets import in_pose

from fab.clearance.soundness import parts_of
from fab.errors import InvalidJob
from fab.geometry.booleans import joined_mesh, manifold_of, manifolds
from fab.jobs.job import parse_job
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.feasible_window import feasible_window
from fab.panels.hinge_room import vertex_distances
from fab.panels.hinges import (
    HingeSettings,
    heights_over_axes_mm,
    hinges_fit,
    least_thickness_mm,
    require_fitting_hinges,
)
from fab.panels.knuckles import make_knuckles
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.pattern.face_poses import face_poses
from solver import Miura

KINDS = ["web", "knuckle", "film", "none"]
THICK = PanelSettings(thickness_mm=4.0, axis="middle", gap_mm=0.4)


def miura_of(width_mm, columns=4, rows=4):
    mesh = Miura(columns=columns, rows=rows).grow().mesh
    development = develop(mesh)
    return crease_pattern(mesh, development, width_mm / development.vertices_coords.max())


def codes(findings):
    return [finding.code for finding in findings]


def panels_for(kind, thickness_mm=4.0):
    return PanelSettings(
        thickness_mm=thickness_mm, gap_mm=0.4, axis="middle" if kind == "knuckle" else "bottom"
    )


def flat_coords(pattern):
    return np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])


def common_mm3(bodies) -> float:
    """The largest volume that two bodies share, of all pairs whose boxes meet."""
    solids, (low, high) = manifolds(bodies), bodies.boxes()
    largest = 0.0
    for i in range(len(bodies)):
        near = np.flatnonzero((low <= high[i]).all(axis=1) & (high >= low[i]).all(axis=1))
        for j in near[near > i].tolist():
            largest = max(largest, (solids[i] ^ solids[j]).volume())
    return largest


def test_webs_of_a_square_grid_have_exact_lengths():
    """Gap 1: corners are 0.5 sqrt 2 from inner vertices, and relief begins beyond them."""
    pattern = replace(grid(3, 3, 20.0), edges_foldAngle=np.zeros(24))
    sheet, findings = thicken(
        pattern,
        PanelSettings(thickness_mm=2.0, gap_mm=1.0),
        HingeSettings(web_mm=0.5, relief_mm=0.25),
    )
    assert findings == []
    volumes = sheet.bodies.volumes_mm3()
    assert volumes[4] == pytest.approx(19 * 19 * 2, rel=1e-14)
    assert volumes[0] == pytest.approx(19.5 * 19.5 * 2, rel=1e-14)
    lengths = np.sort(volumes[9:]) / 0.5
    hole = np.sqrt(0.5) + 0.25
    assert lengths == pytest.approx([20 - 2 * hole] * 4 + [20 - 0.25 - hole] * 8, rel=1e-12)


@given(
    st.lists(st.floats(1.0, 3.0), min_size=4, max_size=7),
    st.lists(st.floats(-90, 90), min_size=7, max_size=7),
    st.floats(0.1, 1.5),
)
def test_corner_distances_are_those_of_the_formula(steps, angles, z):
    """sqrt(s1^2 + s2^2 + 2 s1 s2 cos a) / sin a in each sector around a vertex."""
    sectors = np.array(steps) * 2 * np.pi / sum(steps)
    turn, count = np.cumsum(sectors), len(steps)
    rim = 200 * np.column_stack([np.cos(turn), np.sin(turn)])
    faces = [[0, 1 + i, 1 + (i + 1) % count] for i in range(count)]
    pattern = pattern_of(np.vstack([[0.0, 0.0], rim]), faces)
    far = pattern.edges_vertices.max(axis=1) - 1
    spoke = pattern.edges_vertices.min(axis=1) == 0
    pattern = creased(pattern, np.where(spoke, np.array(angles)[far], 0.0))
    sheet, findings = thicken(pattern, PanelSettings(), HingeSettings(kind="none"))
    assert findings == []
    s1 = 0.5 + z * np.tan(np.radians(np.maximum(angles[:count], 0)) / 2)
    s2, a = np.roll(s1, -1), np.roll(sectors, -1)
    exact = np.sqrt(s1**2 + s2**2 + 2 * s1 * s2 * np.cos(a)) / np.sin(a)
    least, largest = vertex_distances(pattern, sheet.panels, np.array([z]))
    assert least[0] == pytest.approx(exact.min(), rel=1e-9)
    assert largest[0] == pytest.approx(exact.max(), rel=1e-9)


def test_a_web_is_as_long_as_its_strain_needs():
    """Thickness 0.4 bent by 90 degrees at strain 0.1: 0.4 (pi / 2) / (2 x 0.1) = pi."""
    pattern = folded_pair(90.0)
    hinge = HingeSettings(strain_max=0.1)
    sheet, _ = thicken(pattern, PanelSettings(gap_mm=1.0), hinge)
    low, high = sheet.bodies.chosen(np.array([2])).boxes()
    assert high[0, 0] - low[0, 0] == pytest.approx(np.pi + 2 * 0.4, rel=1e-12)  # wider at its top
    (crease,) = sheet.held.tolist()
    assert 2 * sheet.panels.setbacks.axis_mm[crease] == pytest.approx(np.pi, rel=1e-12)


def test_webs_stay_between_the_ends_of_their_crease():
    """Two faces along a slit that opens by 6 degrees: panels reach beyond the crease."""
    a = np.radians(3)
    coords = [
        (0, 0), (20, 0), (20, 10), (0, 10), (-20 * np.cos(a), 20 * np.sin(a)),
        (20, -10), (0, -10), (-20 * np.cos(a), -20 * np.sin(a)),
    ]  # fmt: skip
    pattern = pattern_of(coords, [[0, 1, 2, 3, 4], [0, 7, 6, 5, 1]], "M", angle=60.0)
    sheet, findings = thicken(pattern, PanelSettings(), HingeSettings(relief_mm=0.3))
    assert findings == []
    x = sheet.bodies.mesh(2).vertices_coords[:, 0]
    assert (x.min(), x.max()) == pytest.approx((0.3, 19.7))


def test_creases_without_room_for_a_web_are_named():
    sheet, findings = thicken(miura_of(100.0), PanelSettings(), HingeSettings(relief_mm=12.0))
    assert codes(findings) == ["hinge-missing"]
    assert len(sheet.bodies) == 16
    assert len(sheet.held) == 0


@settings(max_examples=20)
@given(patches(), st.floats(0.2, 1.0), st.floats(0.5, 3.0), st.sampled_from(["web", "film"]))
def test_what_is_joined_is_closed_and_has_the_volume_of_its_parts(mesh, gap, thickness, kind):
    development = develop(mesh)
    pattern = crease_pattern(mesh, development, 400.0 / development.vertices_coords.max())
    sheet, _ = thicken(
        pattern,
        PanelSettings(thickness_mm=thickness, gap_mm=gap),
        HingeSettings(kind=kind, web_mm=0.3, relief_mm=0.2),
    )
    volumes = sheet.bodies.volumes_mm3()
    for solid, volume in zip(manifolds(sheet.bodies), volumes, strict=True):
        assert solid.status() == Error.NoError
        assert solid.volume() == pytest.approx(volume, rel=1e-9)
        assert volume > 0
    if len(development.overlaps) == 0 and len(volumes):
        body = manifold_of(joined_mesh(sheet.joining))
        assert body.status() == Error.NoError
        # corners within 1e-4 mm become one
        assert body.volume() == pytest.approx(volumes.sum(), rel=1e-7)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("thickness", [3.0, 4.0, 5.0])
def test_nothing_touches_flat_or_folded(kind, thickness):
    pattern = miura_of(140.0)
    panel = panels_for(kind, thickness)
    sheet, findings = thicken(pattern, panel, HingeSettings(kind=kind, play_mm=0.2))
    assert findings == []
    for coords in (flat_coords(pattern), pattern.folded_coords):
        assert common_mm3(in_pose(sheet, coords)) < 1e-9
    turns, shifts = face_poses(pattern, pattern.folded_coords)
    faces = sheet.panels.faces
    bare = manifolds(sheet.panels.bodies.moved(turns[faces], shifts[faces]))
    rigid = manifolds(in_pose(sheet, pattern.folded_coords))
    for crease in np.flatnonzero(pattern.edges_faces[:, 1] >= 0).tolist():
        first, second = pattern.edges_faces[crease].tolist()
        exact = sheet.panels.setbacks.clearance_mm[crease]
        assert bare[first].min_gap(bare[second], 9.0) == pytest.approx(exact, rel=1e-6)
        # arms keep half of that from the other panel, barrels their play
        least = exact if kind != "knuckle" else min(exact / 2, 0.2)
        assert rigid[first].min_gap(rigid[second], 9.0) >= 0.999 * least


@pytest.mark.parametrize("angle", [0.0, 70.0, -70.0, 130.0, -130.0])
def test_knuckles_turn_freely_all_the_way(angle):
    """At ten states from flat to the target: no contact, and barrels keep their play."""
    hinge = HingeSettings(kind="knuckle", knuckle_mm=3.0)
    sheet, findings = thicken(folded_pair(angle), THICK, hinge)
    assert findings == []
    assert len(sheet.bodies) == 2
    assert len(sheet.held) == 1
    for share in np.linspace(0, 1, 11):
        state = folded_pair(share * angle).folded_coords
        first, second = manifolds(in_pose(sheet, state))
        assert (first ^ second).volume() == 0.0
        gap = first.min_gap(second, 1.0)
        assert gap >= 0.25 - 1e-9
        if abs(angle) < 100:
            assert gap == pytest.approx(0.25, abs=1e-9)  # between barrels


@pytest.mark.parametrize("angle", [0.0, 90.0, -90.0])
def test_knuckles_have_the_analytic_volume(angle):
    """Panels, barrels with their arms beside the panels, pins in the gaps."""
    hinge = HingeSettings(kind="knuckle", knuckle_mm=3.0, relief_mm=0.4)
    sheet, _ = thicken(folded_pair(angle, length=24.0), THICK, hinge)
    play, count = 0.25, 7  # 7 (3 + 0.25) - 0.25 <= 23.2 < 9 (3 + 0.25) - 0.25
    width = (23.2 - (count - 1) * play) / count
    slope = np.tan(np.radians(abs(angle)) / 2)
    off = 2 / np.cos(np.pi / 8) + play
    barrel = shapely.Polygon(
        [2 / np.cos(np.pi / 8) * np.array([np.cos(a), np.sin(a)])
         for a in (np.arange(8) + 0.5) * np.pi / 4]
    )  # fmt: skip
    arm = shapely.Polygon(
        [(0, -2), (off, -2), (off, 0), (off + 2 * slope, 2), (2 * slope, 2), (0, 0)]
    )
    full = (barrel | arm).area
    radius = (0.6 + play) / np.cos(np.pi / 24)
    bore = 12 * radius**2 * np.sin(np.pi / 12)
    pin = 12 * 0.6**2 * np.sin(np.pi / 12)
    panel = 24.0 * (4 * (30 - off) - 2 * (2 * slope) / 2)
    exact = [
        panel + 3 * width * (full - bore),
        panel + 4 * width * full + (3 * width + 6 * play) * pin,
    ]
    # the arm reaches into its panel by nothing that counts
    assert np.sort(sheet.bodies.volumes_mm3()) == pytest.approx(np.sort(exact), rel=1e-9)
    # each gap between the barrels of the first panel is a window, closed by its pin; each barrel of
    # the second panel has a hole
    assert [solid.genus() for solid in manifolds(sheet.bodies)] == [3, 3]


@pytest.mark.parametrize("hole", [0.0, 2.0])
@pytest.mark.parametrize("angle", [0.0, 30.0, 45.0, 100.0, 140.0])
@pytest.mark.parametrize("corners", [3, 6])
def test_stitched_panels_are_the_union_of_panels_and_barrels(corners, angle, hole):
    """Panels around a polygon, drilled or not, folded both ways: notches of every shape."""
    turn = np.arange(corners) * 2 * np.pi / corners
    ring = 60 * np.column_stack([np.cos(turn), np.sin(turn)])
    pattern = ringed(ring, angle * (-1) ** np.arange(corners))
    panel = PanelSettings(thickness_mm=3.0, axis="middle", fold_limit_deg=150.0)
    hinge = HingeSettings(kind="knuckle", hole_mm=hole)
    sheet, findings = thicken(pattern, panel, hinge)
    assert findings == []
    bare, _ = thicken(pattern, panel, hinge.model_copy(update={"knuckle_mm": 1000.0}))
    assert len(bare.held) == 0
    knuckles, _ = make_knuckles(pattern, sheet.panels, hinge)
    added = np.zeros(len(bare.bodies))
    back = sheet.panels.setbacks
    lengths = np.diff(knuckles.ends, axis=1).ravel() - (knuckles.counts - 1) * knuckles.play_mm
    widths = lengths / knuckles.counts
    for crease, count, width in zip(knuckles.creases, knuckles.counts, widths, strict=True):
        half = np.arctan(max(back.above[crease], back.below[crease]))
        first, second = pattern.edges_faces[crease]
        full, pin, bore = knuckle_sections(1.5, back.axis_mm[crease], half)
        added[first] += (count + 1) / 2 * width * full
        added[first] += ((count - 1) / 2 * width + (count - 1) * 0.25) * pin
        added[second] += (count - 1) / 2 * width * (full - bore)
    assert sheet.bodies.volumes_mm3() == pytest.approx(bare.bodies.volumes_mm3() + added, rel=1e-12)
    assert parts_of(sheet.bodies).tolist() == [1] * len(sheet.bodies)
    for made, plain in zip(manifolds(sheet.bodies), manifolds(bare.bodies), strict=True):
        assert made.status() == Error.NoError
        assert (plain - made).volume() < 1e-9


def knuckle_sections(radius, off, half):
    """Areas of barrel and arm, of the pin, and of the hole."""
    barrel = shapely.Polygon(
        [radius / np.cos(np.pi / 8) * np.array([np.cos(a), np.sin(a)])
         for a in (np.arange(8) + 0.5) * np.pi / 4]
    )  # fmt: skip
    lean = radius * np.tan(half)
    arm = shapely.Polygon(
        [(0, -radius), (off, -radius), (off, 0), (off + lean, radius), (lean, radius), (0, 0)]
    )
    bore = 12 * ((0.6 + 0.25) / np.cos(np.pi / 24)) ** 2 * np.sin(np.pi / 12)
    return (barrel | arm).area, 12 * 0.6**2 * np.sin(np.pi / 12), bore


def test_planar_sides_of_knuckles_are_planar_and_whole():
    sheet, _ = thicken(folded_pair(80.0), THICK, HingeSettings(kind="knuckle", hole_mm=3.0))
    for i in range(2):
        mesh = sheet.bodies.mesh(i)
        for plane in np.unique(mesh.triangles_plane):
            corners = mesh.vertices_coords[mesh.triangles[mesh.triangles_plane == plane]]
            points = corners.reshape(-1, 3) - corners[0, 0]
            flatness = np.linalg.svd(points, compute_uv=False)[2]
            assert flatness < 1e-9
        solid = manifold_of(mesh)
        assert solid.status() == Error.NoError
        assert len(solid.decompose()) == 1


def test_knuckles_are_refused_just_beyond_what_the_length_allows():
    """Three barrels of 4, two gaps of 0.25 and two reliefs of 0.3: 13.1."""
    for length, fits in ((13.1 + 1e-6, True), (13.1 - 1e-6, False)):
        sheet, findings = thicken(
            folded_pair(60.0, length=length), THICK, HingeSettings(kind="knuckle")
        )
        assert (len(sheet.held) == 1) is fits
        assert codes(findings) == ([] if fits else ["hinge-missing"])
        if not fits:
            assert findings[0].creases
            assert "need 12.5 mm" in findings[0].text
            assert "12.5: knuckle_mm = 3.99 fits into the longest" in findings[0].text
            hinge = HingeSettings(kind="knuckle", knuckle_mm=3.99)
            sheet, findings = thicken(folded_pair(60.0, length=length), THICK, hinge)
            assert findings == []
            assert len(sheet.held) == 1
    _, findings = thicken(folded_pair(60.0, length=4.0), THICK, HingeSettings(kind="knuckle"))
    assert "too short for barrels of 1 mm" in findings[0].text


def test_knuckles_are_refused_just_beyond_the_largest_fold_angle():
    """Arms come nearer than the play where (R + play) cos(rho / 2) < play."""
    off = 2 / np.cos(np.pi / 8) + 0.25
    bound = 2 * np.degrees(np.arccos(0.25 / off))
    for angle, fits in ((bound - 1e-3, True), (bound + 1e-3, False), (-bound - 1e-3, False)):
        pattern = folded_pair(angle, width=80.0)
        panel = PanelSettings(thickness_mm=4.0, axis="middle", clearance_mm=0.0)
        sheet, findings = thicken(pattern, panel, HingeSettings(kind="knuckle"))
        assert (len(sheet.held) == 1) is fits
        if not fits:
            assert codes(findings) == ["hinge-missing"]
            assert f"may fold by {bound:.4g}" in findings[0].text


def test_hinges_by_class_of_crease():
    pattern = miura_of(140.0)
    hinge = HingeSettings(kind="none", valley="knuckle", mountain="web")
    sheet, findings = thicken(pattern, THICK, hinge)
    assert findings == []
    letters = pattern.edges_assignment
    webs = sheet.creases[sheet.creases >= 0]
    assert set(letters[webs]) == {"M"}
    assert sheet.held.tolist() == np.flatnonzero(np.isin(letters, ["M", "V"])).tolist()
    assert common_mm3(in_pose(sheet, pattern.folded_coords)) < 1e-9
    joined = Manifold.batch_boolean(manifolds(sheet.joining), OpType.Add)
    assert joined.volume() == pytest.approx(sheet.bodies.volumes_mm3().sum(), rel=1e-9)


def test_a_film_has_the_area_of_the_sheet_less_its_holes():
    """Squares of 20, gap 1: corners 0.5 sqrt 2 from the vertex, holes end 0.3 before them."""
    pattern = replace(grid(3, 3, 20.0), edges_foldAngle=np.zeros(24))
    hinge = HingeSettings(kind="film", film_mm=0.5)
    sheet, findings = thicken(pattern, PanelSettings(thickness_mm=2.0), hinge)
    assert findings == []
    assert sheet.names[-1] == "film_0"
    assert sheet.flexible.tolist() == [False] * 9 + [True]
    hole = 12 * (np.sqrt(0.5) - 0.3) ** 2 * np.sin(np.pi / 12)
    assert sheet.bodies.volumes_mm3()[-1] == pytest.approx(0.5 * (3600 - 4 * hole), rel=1e-12)
    low, high = sheet.bodies.boxes()
    assert (low[-1, 2], high[-1, 2]) == (-0.25, 0.25)
    assert set(low[:-1, 2]) == {0.25}
    # a fabric without holes
    sheet, _ = thicken(pattern, PanelSettings(), HingeSettings(kind="film", relief_mm=5.0))
    assert sheet.bodies.volumes_mm3()[-1] == pytest.approx(0.2 * 3600, rel=1e-12)


def test_a_film_is_cut_where_the_sheet_is_and_comes_in_its_pieces():
    pattern = grid(3, 2, 20.0, without=[(1, 0), (1, 1)])
    sheet, _ = thicken(pattern, PanelSettings(), HingeSettings(kind="film"))
    assert [name for name in sheet.names if "film" in name] == ["film_0", "film_1"]
    # vertices of row 1 are 4 to 7: a cut from the left border to the first inner vertex
    pattern = grid(3, 2, 20.0, cuts=[(4, 5)])
    sheet, _ = thicken(
        pattern, PanelSettings(gap_mm=1.0), HingeSettings(kind="film", relief_mm=5.0)
    )
    assert sheet.bodies.volumes_mm3()[-1] == pytest.approx(0.2 * (2400 - 20), rel=1e-12)


def test_holes_lie_farthest_from_the_sides_and_have_their_volume():
    pattern = replace(grid(2, 1, 20.0), edges_foldAngle=np.zeros(7))
    hinge = HingeSettings(kind="none", hole_mm=3.0)
    sheet, findings = thicken(pattern, PanelSettings(thickness_mm=2.0, gap_mm=1.0), hinge)
    assert findings == []
    radius = 1.5 / np.cos(np.pi / 24)  # around the circle: a peg of 3 mm fits
    hole = 12 * radius**2 * np.sin(np.pi / 12)
    assert sheet.bodies.volumes_mm3() == pytest.approx([2 * (390 - hole)] * 2, rel=1e-12)
    assert [solid.genus() for solid in manifolds(sheet.bodies)] == [1, 1]
    assert common_mm3(sheet.bodies) == 0.0


def test_holes_that_leave_too_thin_a_wall_are_refused_at_the_bound():
    """Faces of 20 by 20, gap 1: half of 19.5 wide, so hole and walls must fit in 19.5."""
    pattern = replace(grid(2, 1, 20.0), edges_foldAngle=np.zeros(7))
    bound = 2 * (19.5 / 2 - 0.6) * np.cos(np.pi / 24)
    for hole, fits in ((bound - 0.05, True), (bound + 0.05, False)):
        hinge = HingeSettings(kind="none", hole_mm=hole)
        sheet, findings = thicken(pattern, PanelSettings(gap_mm=1.0), hinge)
        assert codes(findings) == ([] if fits else ["hole-missing"])
        assert {solid.genus() for solid in manifolds(sheet.bodies)} == {int(fits)}


def test_panels_whose_top_is_not_over_their_bottom_have_no_hole():
    """A strip of 10 between a valley and a mountain of 140 degrees leans by more than its width."""
    x, y = [0.0, 30.0, 40.0, 70.0], [0.0, 20.0]
    coords = np.array([[u, v] for v in y for u in x])
    pattern = pattern_of(coords, [[i, i + 1, i + 5, i + 4] for i in range(3)])
    inner = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)
    angles = np.zeros(len(pattern.edges_vertices))
    angles[inner] = [140.0, -140.0]
    panel = PanelSettings(thickness_mm=6.4, axis="middle", gap_mm=0.4)
    hinge = HingeSettings(kind="none", hole_mm=2.0)
    sheet, findings = thicken(creased(pattern, angles), panel, hinge)
    assert len(sheet.bodies) == 3
    assert codes(findings) == ["hole-missing"]
    assert findings[0].panels == (1,)
    assert [solid.genus() for solid in manifolds(sheet.bodies)] == [1, 0, 1]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_may_be_drilled(kind):
    pattern = miura_of(140.0)
    hinge = HingeSettings(kind=kind, hole_mm=2.0)
    plain, _ = thicken(pattern, panels_for(kind), HingeSettings(kind=kind))
    sheet, findings = thicken(pattern, panels_for(kind), hinge)
    assert findings == []
    assert len(sheet.bodies) == len(plain.bodies)
    hole = 12 * (1 / np.cos(np.pi / 24)) ** 2 * np.sin(np.pi / 12) * 4.0
    assert plain.bodies.volumes_mm3()[:16] - sheet.bodies.volumes_mm3()[:16] == pytest.approx(
        hole, rel=1e-9
    )


@pytest.mark.parametrize(
    ("panels", "hinges", "words"),
    [
        ({}, {"kind": "film", "valley": "web"}, "a film lies under all of them. Give film to all"),
        ({"axis": "middle"}, {"kind": "film"}, "panels.axis = middle with hinges.kind = film"),
        ({}, {"web_mm": 1.6}, "hinges.web_mm = 1.6 must be below panels.thickness_mm = 1.6"),
        ({"axis": "offset", "axis_mm": -0.1}, {}, "panels.axis_mm = -0.1 must be 0 to"),
        ({}, {"flat": "knuckle"}, "Set panels.axis = middle"),
        ({"axis": "middle"}, {"kind": "knuckle"}, "panels.thickness_mm = 1.6 must be at least 2.9"),
        (
            {},
            {"kind": "glue"},
            "hinges.kind = 'glue' is out of bounds: it must be 'web', 'knuckle'",
        ),
        ({}, {"play_mm": 0.0}, "hinges.play_mm = 0.0 is out of bounds: it must be at least 0.01"),
    ],
)
def test_hinges_that_panels_cannot_have_are_refused(panels, hinges, words):
    job = {
        "name": "small",
        "design": {"kind": "miura"},
        "sheet": {"width_mm": 100.0},
        "panels": panels,
        "hinges": hinges,
    }
    with pytest.raises(InvalidJob, match=words):
        parse_job(job)


def test_knuckles_are_as_thick_as_their_pin_needs():
    hinge = HingeSettings(kind="knuckle")
    least = 2 * ((0.6 + 0.25) / np.cos(np.pi / 24) + 0.6)
    fits = PanelSettings(thickness_mm=least + 1e-9, axis="middle")
    require_fitting_hinges(fits, hinge)
    assert heights_over_axes_mm(fits, hinge)[1] == pytest.approx(least / 2)
    with pytest.raises(InvalidJob):
        require_fitting_hinges(PanelSettings(thickness_mm=least - 1e-9, axis="middle"), hinge)


@given(
    kinds=st.sampled_from([("web", "bottom"), ("web", "offset"), ("none", "offset")])
    | st.sampled_from([("knuckle", "middle"), ("film", "bottom"), ("none", "bottom")]),
    web=st.floats(0.01, 2.0),
    pin=st.floats(0.1, 3.0),
    axis_mm=st.floats(0.0, 2.0),
)
def test_hinges_fit_down_to_the_least_thickness_and_no_further(kinds, web, pin, axis_mm):
    kind, axis = kinds
    offset = {"axis_mm": axis_mm} if axis == "offset" else {}
    panel = PanelSettings(thickness_mm=50.0, axis=axis, **offset)
    hinge = HingeSettings(kind=kind, web_mm=web, pin_mm=pin)
    least = least_thickness_mm(panel, hinge)
    assert 0.01 <= least < 50.0

    def allowed(thickness_mm):
        changes = {**panel.model_dump(), "thickness_mm": thickness_mm}
        try:
            return hinges_fit(PanelSettings(**changes), hinge)
        except ValidationError:
            return False

    assert allowed(least)
    assert not allowed(least * (1 - 1e-9))


def test_knuckles_with_an_axis_at_half_the_thickness_have_that_thickness_alone():
    panel = PanelSettings(thickness_mm=4.0, axis="offset", axis_mm=2.0)
    hinge = HingeSettings(kind="knuckle")
    assert hinges_fit(panel, hinge)
    assert least_thickness_mm(panel, hinge) == 4.0
    window = feasible_window(folded_pair(60.0), panel, hinge)
    assert window.thickness_max_mm == pytest.approx(4.0, rel=1e-8)
    assert [row.thickness_mm for row in window.rows] == [4.0]


def test_triangles_and_hexagons_take_every_hinge():
    angle = np.arange(6) * np.pi / 3
    hexagon = 40 * np.column_stack([np.cos(angle), np.sin(angle)])
    sheets = [creased(ringed(hexagon, 50.0), ringed(hexagon, 50.0).edges_foldAngle), fan(6, 60.0)]
    for pattern in sheets:
        for kind in KINDS:
            sheet, findings = thicken(pattern, panels_for(kind, 3.0), HingeSettings(kind=kind))
            assert findings == []
            assert len(sheet.panels.faces) == pattern.face_count
            assert common_mm3(sheet.bodies.chosen(sheet.rigid)) < 1e-9
            inner = int((pattern.edges_faces[:, 1] >= 0).sum())
            assert len(sheet.held) == (0 if kind == "none" else inner)


def test_barrels_keep_behind_the_other_creases_up_to_their_axis():
    """Corners of 120 degrees: on the axis, (R + play) / sin 120 from the vertex is the nearest."""
    angle = np.arange(6) * np.pi / 3
    pattern = ringed(40 * np.column_stack([np.cos(angle), np.sin(angle)]), 0.0)
    hinge = HingeSettings(kind="knuckle")
    sheet, _ = thicken(pattern, THICK, hinge)
    knuckles, findings = make_knuckles(pattern, sheet.panels, hinge)
    assert findings == []
    sides = (pattern.edges_vertices[knuckles.creases] < 6).all(axis=1)
    nearest = (2 / np.cos(np.pi / 8) + 0.25) / np.sin(2 * np.pi / 3) + 0.3
    assert knuckles.ends[sides] == pytest.approx(np.tile([nearest, 40 - nearest], (6, 1)))
