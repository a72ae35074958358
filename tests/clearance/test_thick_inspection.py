"""Bodies stay apart in all states: exact distances, known overlaps, and what must be refused."""

import re
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import pattern_of
from helpers import ROOT
from hypothesis import given, settings
from hypothesis import strategies as st
from relaxed_surfaces import bump
from thick_sheets import SIDE_MM, book, creased, folded, in_pose, solid

from fab import read_pattern
from fab.clearance.promised_distances import promised_mm
from fab.clearance.soundness import inspect_joined, parts_of
from fab.clearance.thick_inspection import inspect_thick
from fab.errors import Severity
from fab.folding.folded_states import Stage, flat_panels, folded_states, panels_at
from fab.geometry.bodies import bodies_of
from fab.geometry.booleans import joined_mesh, manifolds
from fab.panels.bevelled_panels import PanelSettings, make_panels
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import CreasePattern, crease_pattern, scaled
from fab.pattern.development import develop
from fab.printing.printability import bed_area_mm2
from solver import Miura, RigidMiura
from solver.relaxation import Wishes, pleated_patch, relaxed_sheet


def inspected(sheet, states, **options):
    return inspect_thick(sheet, joined_mesh(sheet.joining), states, **options)


def target(pattern):
    return panels_at(pattern, pattern.folded_coords, Stage.TARGET, 1.0)


def bare(sheet, back):
    """The panels of a sheet with other setbacks, without hinges."""
    panels, _ = make_panels(sheet.pattern, sheet.panels.heights_mm, back)
    count = len(panels.bodies)
    return replace(
        sheet,
        panels=panels,
        bodies=panels.bodies,
        names=sheet.names[:count],
        faces=sheet.faces[:count],
        creases=sheet.creases[:count],
        flexible=sheet.flexible[:count],
        held=np.empty(0, np.int64),
        joining=panels.bodies,
    )


def codes(findings):
    return [finding.code for finding in findings]


@pytest.fixture(scope="module")
def miura():
    mesh = Miura(columns=5, rows=4).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    sheet = solid(pattern, thickness_mm=0.8, gap_mm=0.4)
    return sheet, folded_states(pattern)[0]


def test_a_sheet_keeps_its_promise_flat_folded_and_between(miura):
    sheet, states = miura
    figures, findings = inspected(sheet, states)
    assert findings == []
    assert [state.state for state in figures.clearance.states][::9] == ["flat", "at the target"]
    assert len(figures.clearance.states) == 10
    flat, *between, last = [state.clearance_min_mm for state in figures.clearance.states]
    steepest = np.radians(np.abs(sheet.pattern.edges_foldAngle).max())
    assert flat == pytest.approx(0.4, abs=1e-9)
    assert last == pytest.approx(0.4 * np.cos(steepest / 2), abs=1e-9)
    assert all(last < gap < flat for gap in between)
    assert figures.clearance.clearance_min_mm == last
    assert figures.clearance.overlap_max_mm3 <= 1e-9
    assert figures.solids.volume_mm3 == pytest.approx(sheet.bodies.volumes_mm3().sum())
    webs = sheet.bodies.volumes_mm3()[len(sheet.panels.bodies) :].sum()
    assert figures.solids.flexible_mm3 == pytest.approx(webs)
    bottoms = sheet.panels.bodies.volumes_mm3().sum() / 0.8
    area = bed_area_mm2(joined_mesh(sheet.joining))
    assert bottoms < area < np.prod(np.ptp(sheet.pattern.vertices_coords, axis=0))


@pytest.mark.parametrize("name", ["marched", "relaxed"])
def test_panels_of_sheets_that_fold_rigidly_do_not_jam(name):
    """In the states of their motion, where rigid panels are exactly where the sheet is."""
    if name == "marched":
        mesh = RigidMiura(columns=6, rows=6).grow().mesh
    else:
        surface = bump(0.2)
        fitted = pleated_patch(surface, 8, zigzag=1.5, spacing=1.2, thickness=1.2)
        mesh = relaxed_sheet(surface, fitted, Wishes(rigid=True)).mesh
    pattern = scaled(crease_pattern(mesh, develop(mesh), 1.0), width_mm=200.0)
    states, found = folded_states(pattern)
    assert found == []
    assert len(states) == 10
    assert max(state.bend_mm for state in states) <= 1e-9
    sheet = solid(pattern, thickness_mm=0.8, gap_mm=0.8)
    figures, findings = inspected(sheet, states)
    assert codes(findings) == []
    assert figures.clearance.overlap_max_mm3 <= 1e-9


@given(
    st.floats(-150, 150),
    st.floats(0, 1),
    st.floats(0.3, 3),
    st.floats(0.05, 0.8),
    st.sampled_from([0.0, 0.3, 1.0, -0.7]),
)
@settings(max_examples=60, deadline=None)
def test_what_is_promised_is_the_exact_distance(angle, share, thickness, gap, axis):
    pattern = book(angle)
    low = -axis * thickness
    panel = PanelSettings(thickness_mm=thickness, gap_mm=gap, axis="offset", axis_mm=-low)
    sheet, _ = thicken(pattern, panel, HingeSettings(kind="none"))
    if len(sheet.panels.bodies) < 2:
        return
    pattern = replace(pattern, folded_coords=folded(pattern.vertices_coords, share * angle))
    state = replace(target(pattern), stage=Stage.BETWEEN)
    back, heights = sheet.panels.setbacks, sheet.panels.heights_mm
    crease = int(np.flatnonzero(pattern.edges_faces[:, 1] >= 0)[0])
    promised = promised_mm(back, heights, state.angles_deg)[crease]
    first, second = manifolds(sheet.panels.bodies.moved(state.turns, state.shifts))
    assert first.min_gap(second, 10 * SIDE_MM) == pytest.approx(promised, abs=1e-7)
    at_target = promised_mm(back, heights, pattern.edges_foldAngle)[crease]
    assert at_target == pytest.approx(back.clearance_mm[crease], abs=1e-9)


@pytest.mark.parametrize(("axis", "reach"), [("bottom", 3.0), ("middle", 1.5)])
@pytest.mark.parametrize("wrong_side", [False, True])
def test_straight_cuts_and_bevels_on_the_wrong_side_overlap_as_computed(axis, reach, wrong_side):
    """Past the plane halfway between both reaches a triangle of each, all of it in the other."""
    pattern = book(60.0)
    sheet = solid(pattern, thickness_mm=3.0, gap_mm=0.4, axis=axis)
    assert inspected(sheet, [flat_panels(pattern), target(pattern)])[1] == []
    back = sheet.panels.setbacks
    below = back.above if wrong_side else 0 * back.above
    naive = bare(sheet, replace(back, above=0 * back.above, below=below))
    figures, findings = inspected(naive, [target(pattern)])
    slope, s0 = np.tan(np.radians(30)), 0.2
    expected = SIDE_MM * (reach - s0 / slope) * (reach * slope - s0)
    assert figures.clearance.overlap_max_mm3 == pytest.approx(expected, rel=1e-9)
    (overlap,) = [f for f in findings if f.code == "solids-overlap"]
    crease = int(np.flatnonzero(pattern.edges_faces[:, 1] >= 0)[0])
    assert (overlap.panels, overlap.creases) == ((0, 1), (crease,))
    assert overlap.severity == Severity.ERROR
    assert overlap.text.startswith("at the target: panel 0 and panel 1 across crease")


def test_a_panel_that_is_too_large_is_caught_and_named(miura):
    sheet, states = miura
    meshes = [sheet.bodies.mesh(i) for i in range(len(sheet.bodies))]
    grown = meshes[7].vertices_coords.copy()
    middle = grown.mean(axis=0)
    grown[:, :2] += 0.1 * np.sign(grown - middle)[:, :2]
    meshes[7] = replace(meshes[7], vertices_coords=grown)
    wrong = replace(sheet, bodies=bodies_of(meshes), joining=bodies_of(meshes))
    _, findings = inspected(wrong, states)
    near = [f for f in findings if f.code == "clearance-too-small"]
    assert near
    assert all(7 in f.panels and f.creases for f in near)
    assert "flat" in near[0].text
    assert "clearance-between" in codes(findings)


def test_a_panel_in_a_wrong_pose_is_caught_and_named(miura):
    sheet, states = miura
    last = states[-1]
    angle = np.radians(5.0)
    tilt = np.array(
        [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]
    )
    turns, shifts = last.turns.copy(), last.shifts.copy()
    corners = sheet.pattern.vertices_coords[sheet.pattern.faces_vertices[36:40]]
    middle = turns[9, :, :2] @ corners.mean(axis=0) + shifts[9]
    turns[9] = tilt @ turns[9]
    shifts[9] = middle + tilt @ (shifts[9] - middle)
    _, findings = inspected(sheet, [replace(last, turns=turns, shifts=shifts)])
    named = [f for f in findings if f.code in ("clearance-too-small", "solids-overlap")]
    assert named
    assert all(9 in f.panels for f in named)
    # between flat and the target it is a warning
    between = replace(last, turns=turns, shifts=shifts, stage=Stage.BETWEEN, share=0.5)
    _, findings = inspected(sheet, [between])
    assert set(codes(findings)) <= {"panels-jam", "clearance-between"}
    assert findings
    assert all(f.severity == Severity.WARNING and "at 50 % of the fold" in f.text for f in findings)


def test_panels_with_two_creases_in_common_are_checked_at_both():
    flat = np.array([[0, 0], [0, 0.5], [0, 1], [1, 0], [1, 1], [-1, 0], [-1, 1]]) * SIDE_MM
    pattern = creased(flat, [[0, 3, 4, 2, 1], [0, 1, 2, 6, 5]], 60.0)
    sheet = solid(pattern, thickness_mm=2.0, gap_mm=0.5)
    figures, findings = inspected(sheet, [target(pattern)])
    assert findings == []
    assert figures.clearance.states[0].pairs_checked == 2
    assert figures.clearance.clearance_min_mm == pytest.approx(0.5 * np.cos(np.radians(30)))


def test_knuckles_keep_their_play_and_are_caught_where_they_do_not():
    pattern = book(60.0)
    hinge = HingeSettings(kind="knuckle", play_mm=0.3)
    sheet, findings = thicken(pattern, PanelSettings(thickness_mm=4.0, axis="middle"), hinge)
    assert findings == []
    assert len(sheet.held) == 1
    states = [flat_panels(pattern), target(pattern)]
    figures, findings = inspected(sheet, states)
    assert findings == []
    assert figures.solids.bodies == 1
    # polygons of a barrel come a little nearer to the pin than their circles
    assert all(0.2 < state.clearance_min_mm <= 0.3 + 1e-9 for state in figures.clearance.states)
    halfway = replace(pattern, folded_coords=folded(pattern.vertices_coords, 30.0))
    states.append(replace(target(halfway), stage=Stage.BETWEEN, share=0.5))
    assert inspected(sheet, states)[1] == []
    shifts = states[1].shifts.copy()
    shifts[0, 1] += 0.5
    _, findings = inspected(sheet, [replace(states[1], shifts=shifts)])
    assert codes(findings) == ["solids-overlap"]


@given(st.floats(-130, 130), st.floats(0, 1), st.floats(0, 0.05), st.integers(0, 99))
@settings(max_examples=25, deadline=None)
def test_knuckles_whose_axis_slips_are_not_reported_farther_apart_than_they_are(
    angle, share, slip, seed
):
    pattern = book(angle)
    hinge = HingeSettings(kind="knuckle", knuckle_mm=3.0)
    sheet, _ = thicken(pattern, PanelSettings(thickness_mm=3.2, axis="middle"), hinge)
    if not len(sheet.held):
        return
    direction = np.random.default_rng(seed).normal(size=3)
    partly = replace(pattern, folded_coords=folded(pattern.vertices_coords, share * angle))
    state = replace(target(partly), stage=Stage.BETWEEN, share=share)
    shifts = state.shifts.copy()
    shifts[1] += slip * direction / np.linalg.norm(direction)
    state = replace(state, shifts=shifts)
    first, second = manifolds(in_pose(sheet, partly.folded_coords))
    exact = first.min_gap(second.translate(shifts[1] - target(partly).shifts[1]), 1.0)
    reported = inspected(sheet, [state])[0].clearance.states[0].clearance_min_mm
    assert reported <= exact + 1e-9
    # and the bound is of use: it loses no more than what a slip could cost
    assert reported >= 0.25 - 1.6 * slip - 1e-9


def test_overlap_of_knuckles_between_faces_that_bend_is_a_warning():
    pattern = book(60.0)
    hinge = HingeSettings(kind="knuckle", knuckle_mm=3.0)
    sheet, _ = thicken(pattern, PanelSettings(thickness_mm=4.0, axis="middle"), hinge)
    state = target(pattern)
    shifts = state.shifts.copy()
    shifts[0, 1] += 0.4
    for bend, severity in ((0.0, Severity.ERROR), (0.2, Severity.WARNING)):
        slipped = replace(state, shifts=shifts, bend_mm=bend)
        (finding,) = inspected(sheet, [slipped])[1]
        assert (finding.code, finding.severity) == ("solids-overlap", severity)
        assert "up to 0.15 mm deep" in finding.text  # 0.4 less the play of 0.25
        assert ("0.2 mm off the bent faces" in finding.text) is (bend > 0)


def test_panels_without_a_common_crease_must_not_touch(miura):
    sheet, states = miura
    shifts = states[0].shifts.copy()
    shifts[:10] += [0.0, 0.0, 0.5]  # two rows lifted, then laid over the others
    shifts[:10, 1] += 15.0
    lifted = replace(states[0], stage=Stage.BETWEEN, share=0.3, shifts=shifts)
    for bend, said in ((0.0, "where no face bends: they do not pass"), (0.2, "up to 0.2 mm off")):
        _, findings = inspected(sheet, [replace(lifted, bend_mm=bend)])
        (jam,) = [found for found in findings if found.code == "panels-jam"]
        assert said in jam.text
        assert ("bend by as much" in jam.text) is (bend > 0)
    _, findings = inspected(sheet, [replace(lifted, stage=Stage.TARGET)])
    strangers = [f for f in findings if f.code == "solids-overlap" and not f.creases]
    assert strangers
    assert "0.3 mm deep" in strangers[0].text
    shifts[:10, 2] = 0.9
    _, findings = inspected(sheet, [replace(lifted, stage=Stage.TARGET, shifts=shifts)])
    assert "solids-overlap" not in codes(findings)
    assert "panels-close" in codes(findings)


def test_creases_over_the_limit_end_the_check_there():
    pattern, _ = read_pattern(ROOT / "tests" / "patterns" / "popup.fold")
    states, findings = folded_states(pattern, 8)
    assert findings == []
    sheet = solid(pattern, thickness_mm=0.8, gap_mm=0.4, fold_limit_deg=40.0)
    figures, findings = inspected(sheet, states, limit_deg=40.0)
    (blocked,) = findings
    assert blocked.code == "fold-blocked"
    assert "fold to 44.44 % of the target" in blocked.text
    assert len(blocked.creases) == (np.abs(pattern.edges_foldAngle) > 0).sum()
    assert [state.state for state in figures.clearance.states][-1] == "at 44 % of the fold"
    assert len(inspected(sheet, states, limit_deg=39.99)[0].clearance.states) == 4
    # panels made for 40 degrees do not reach 90
    _, findings = inspected(sheet, states)
    assert {"solids-overlap", "panels-jam"} <= set(codes(findings))
    made_for = {
        angle for found in findings for angle in re.findall(r"made for (\S+)\)", found.text)
    }
    assert made_for
    assert made_for <= {"40", "-40"}


def test_unsound_bodies_are_caught(miura):
    sheet, states = miura
    mesh = sheet.bodies.mesh(3)
    others = [sheet.bodies.mesh(i) for i in range(len(sheet.bodies))]

    def found(changed):
        bodies = bodies_of([*others[:3], changed, *others[4:]])
        wrong = replace(sheet, bodies=bodies)
        return [
            f
            for f in inspect_thick(wrong, joined_mesh(sheet.joining), states[:1])[1]
            if f.code == "solid-invalid"
        ]

    assert found(mesh) == []
    opened = replace(mesh, triangles=mesh.triangles[1:], triangles_plane=mesh.triangles_plane[1:])
    (finding,) = found(opened)
    assert finding.panels == (3,)
    (finding,) = found(replace(mesh, triangles=mesh.triangles[:, ::-1]))
    assert "panel 3 is not a valid solid" in finding.text
    count = len(mesh.vertices_coords)
    twice = replace(
        mesh,
        vertices_coords=np.concatenate(
            [mesh.vertices_coords, mesh.vertices_coords + np.array([0, 0, 9])]
        ),
        triangles=np.concatenate([mesh.triangles, mesh.triangles + count]),
        triangles_plane=np.concatenate([mesh.triangles_plane, mesh.triangles_plane + 99]),
    )
    (finding,) = found(twice)
    assert "2 parts" in finding.text
    assert parts_of(bodies_of([mesh, twice])).tolist() == [1, 2]


def test_loose_panels_and_a_wrong_joined_body_are_caught(miura):
    sheet, states = miura
    loose = bare(sheet, sheet.panels.setbacks)
    figures, findings = inspect_thick(loose, joined_mesh(sheet.joining), states[:1])
    assert figures.solids.bodies == 20
    assert codes(findings) == ["joined-invalid", "panels-loose"]
    # the webs of the whole sheet are between the panels alone
    assert "mm3 is too much in one place, near panel" in findings[0].text


def test_a_wrong_joined_body_is_named_with_its_place(miura):
    sheet, _ = miura
    joined = joined_mesh(sheet.joining)
    assert inspect_joined(sheet, joined) == []
    opened = replace(joined, triangles=joined.triangles[1:])
    (finding,) = inspect_joined(sheet, opened)
    assert "NotManifold, volume 0 of" in finding.text
    assert "it is open at 3 edges, near " in finding.text
    assert len(finding.panels) + len(finding.creases) == 1
    missing = int(np.flatnonzero(sheet.creases < 0)[7])
    others = np.delete(np.arange(len(sheet.joining)), missing)
    (finding,) = inspect_joined(sheet, joined_mesh(sheet.joining.chosen(others)))
    volume = sheet.bodies.volumes_mm3()[missing]
    assert finding.panels == (int(sheet.faces[missing]),)
    assert "--only zip" in finding.text
    found = float(re.search(r"; ([\d.]+) mm3 is missing", finding.text)[1])
    assert found == pytest.approx(volume, rel=0.1)


def two_pieces(apart_mm: float) -> CreasePattern:
    """Two books beside each other."""
    single = book(90.0)
    beside = single.vertices_coords + np.array([0, SIDE_MM + apart_mm])
    faces = [[0, 2, 3, 1], [4, 0, 1, 5], [6, 8, 9, 7], [10, 6, 7, 11]]
    pattern = pattern_of(np.concatenate([single.vertices_coords, beside]), faces, "V")
    # both pieces in one place, as nobody folds them
    return replace(pattern, folded_coords=np.concatenate([single.folded_coords] * 2))


def test_pieces_of_a_sheet_are_not_loose_and_meet_only_when_flat():
    pattern = two_pieces(3.0)
    assert pattern.faces_piece.tolist() == [0, 0, 1, 1]
    target = panels_at(pattern, pattern.folded_coords, Stage.TARGET, 1.0)
    sheet, _ = thicken(pattern, PanelSettings(), HingeSettings())
    joined = joined_mesh(sheet.joining)
    figures, findings = inspect_thick(sheet, joined, [flat_panels(pattern), target])
    assert figures.solids.bodies == 2
    assert findings == []
    near = two_pieces(-0.5)  # over each other
    sheet, _ = thicken(near, PanelSettings(), HingeSettings())
    _, findings = inspect_thick(sheet, joined_mesh(sheet.joining), [flat_panels(near)])
    assert "solids-overlap" in codes(findings)
