"""The verdict in words: which kind of fold it is, how far it bends, and what is at fault."""

from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import fan, fan_of, grid
from helpers import PATTERNS
from load_references import quads

from fab import read_pattern
from fab.errors import Finding, Severity
from fab.folding.bar_hinge_model import framework
from fab.folding.bending import curvature_max_per_mm
from fab.folding.fold_settings import FoldSettings
from fab.folding.misplaced_vertices import misplaced_vertices
from fab.folding.rigid_motion import rigid_motion
from fab.folding.simulation import fold_and_judge
from fab.folding.tolerance import Tolerance
from fab.folding.verdict_words import Bearer, VerdictKind, in_words
from fab.jobs.bearing_sheets import bearing_sheets
from fab.layers.layer_orders import layer_orders
from fab.pattern.crease_pattern import scaled
from fab.pattern.kinematics import vertices_closure_rad

CARD = Bearer("card", 0.36, 0.02)


def pattern_of(name):
    return read_pattern(PATTERNS / f"{name}.fold")[0]


def worded(pattern, sheets=(CARD,)):
    folding, verdict, findings = fold_and_judge(pattern, FoldSettings(steps=5))
    motion = rigid_motion(pattern, folding.frame)
    return in_words(folding, verdict, motion, findings, sheets)


def test_a_miura_folds_rigidly_though_its_creases_are_driven_at_one_rate():
    words = worded(pattern_of("miura"))
    assert words.kind is VerdictKind.RIGID
    assert words.text.startswith("folds rigidly, 1 degree of freedom")


def test_a_square_twist_snaps_and_paper_bears_it():
    """Silverberg and others 2015: without bent faces it does not fold, with them it is bistable."""
    thick, brittle = Bearer("board", 5.0, 0.02), Bearer("glass", 0.1, 1e-4)
    words = worded(pattern_of("square_twist"), (CARD, thick, brittle))
    assert words.kind is VerdictKind.SNAPS
    assert words.barrier.height_rel > 0.01
    assert 0 < words.barrier.load < 1
    assert words.barrier.end_rel < 1e-9
    assert words.text.startswith("snaps: on its way its energy rises to ")
    assert words.bears == (True, False, False)
    assert words.text.endswith(": card bears that")
    report = words.report()
    assert [row["bears"] for row in report["materials"]] == [True, False, False]
    assert report["kind"] == "snaps"


def test_how_far_faces_bend_does_not_depend_on_the_size_of_the_sheet():
    pattern = pattern_of("box")
    small, large = worded(pattern), worded(scaled(pattern, factor=8.0))
    assert small.kind is large.kind is VerdictKind.SNAPS
    assert large.bend.distance_mm == pytest.approx(8 * small.bend.distance_mm, rel=1e-3)
    assert large.bend.curvature_per_mm == pytest.approx(small.bend.curvature_per_mm / 8, rel=1e-3)
    assert large.bend.strain == pytest.approx(small.bend.strain, rel=1e-3)
    assert large.strains[0] < small.strains[0]
    assert small.text.endswith(
        f"card bears that ({100 * small.strains[0]:.2g} % of 2 % in its outer fibre)"
    )
    (sheet,) = worded(pattern, (Bearer("glass", 0.1, 1e-4),)).sheets
    assert worded(pattern, (sheet, sheet)).text.endswith("no shipped sheet bears that")


def test_sheets_that_do_not_get_there_say_why_and_flat_ones_that_nothing_folds():
    pattern = pattern_of("miura")
    angle = pattern.edges_foldAngle.copy()
    angle[np.abs(angle).argmax()] *= 0.7
    words = worded(replace(pattern, edges_foldAngle=angle))
    assert words.kind is VerdictKind.MISSES
    assert words.text.startswith("does not reach its target: ")
    assert words.text.endswith("see angles-do-not-close")
    flat = worded(replace(pattern, edges_foldAngle=np.zeros(len(angle))))
    assert flat.kind is VerdictKind.NOTHING


def test_what_contact_and_layers_found_comes_first():
    pattern = pattern_of("miura")
    folding, verdict, findings = fold_and_judge(pattern, FoldSettings(steps=2))
    motion = rigid_motion(pattern, folding.frame)

    def words(code, text, severity=Severity.ERROR):
        return in_words(folding, verdict, motion, [*findings, Finding(code, severity, text)])

    unordered = words("cannot-lie-flat", "the sheet cannot lie flat: faces 1 and 2. Change them.")
    assert unordered.kind is VerdictKind.UNORDERED
    assert unordered.text == "cannot lie flat: faces 1 and 2"
    maybe = words("cannot-lie-flat", "the sheet cannot lie flat: as it is.", Severity.WARNING)
    assert maybe.kind is VerdictKind.RIGID
    stopped = words("stopped-by-contact", "faces 3 and 4 press on each other.", Severity.WARNING)
    assert stopped.kind is VerdictKind.STOPPED
    assert stopped.text == (
        "reaches its target only by passing through itself, in every order tried: faces 3 and 4 "
        "press on each other"
    )
    short = replace(verdict, reached=False)
    told = [Finding("stopped-by-contact", Severity.ERROR, "faces 3 and 4 press on each other.")]
    held = in_words(folding, short, motion, told)
    assert held.kind is VerdictKind.STOPPED
    assert held.text == "is stopped on its way: faces 3 and 4 press on each other"


def folded_vertex(sectors_deg, angles_deg):
    """A vertex with these sectors and fold angles."""
    letters = ["V" if angle > 0 else "M" if angle < 0 else "F" for angle in angles_deg]
    pattern, spokes = fan_of(np.radians(sectors_deg), letters)
    angle = np.zeros(len(pattern.edges_vertices))
    angle[spokes] = angles_deg
    return replace(pattern, edges_foldAngle=angle)


@pytest.mark.parametrize(
    ("sectors", "angles", "said"),
    [
        ([120, 120, 120], [90, 90, 90], "Only 3 creases fold at vertex 0"),
        ([120, 120, 120], [180, 180, -180], "Only 3 creases fold at vertex 0"),
        ([72] * 5, [180, 180, -180, 180, 180], "5 creases fold by 180 degrees at vertex 0"),
        ([60, 95, 115, 90], [-180, 180, 180, 180], "Kawasaki's condition by 10 degrees"),
        ([60, 90, 120, 90], [-60, 90, 60, 90], "A crease of vertex 0 has a wrong angle"),
    ],
)
def test_why_a_vertex_does_not_close_is_said_and_no_contact_is_blamed(sectors, angles, said):
    _, verdict, findings = fold_and_judge(folded_vertex(sectors, angles), FoldSettings(steps=5))
    assert verdict.open_vertices == (0,)
    (told,) = [each for each in findings if each.code == "angles-do-not-close"]
    assert said in told.text
    assert "stopped-by-contact" not in {each.code for each in findings}
    pattern = folded_vertex(sectors, angles)
    _, _, findings = fold_and_judge(pattern, FoldSettings(steps=5, contact=True))
    for each in findings:
        assert "keep it from its target" not in each.text
    assert worded(pattern).kind is VerdictKind.MISSES


def map_off_by(off_mm):
    """A map of 2 x 2 squares of 20 mm, of which the end of a line is off."""
    pattern = grid(2, 2, 20.0)
    letters = pattern.edges_assignment.copy()
    (mountain,) = np.flatnonzero((np.sort(pattern.edges_vertices, axis=1) == [4, 5]).all(axis=1))
    letters[mountain] = "M"
    angle = np.where(letters == "V", 180.0, np.where(letters == "M", -180.0, 0.0))
    coords = pattern.vertices_coords.copy()
    coords[5, 1] += off_mm
    return replace(pattern, edges_assignment=letters, edges_foldAngle=angle, vertices_coords=coords)


def test_a_map_drawn_with_few_digits_is_off_by_what_its_sectors_miss():
    """Where straight lines cross no move of the vertex helps: an end of a line is off."""
    drawn = map_off_by(0.02)
    (found,) = misplaced_vertices(drawn, np.array([4]))
    assert found.distance_mm == pytest.approx(0.02, rel=1e-3)
    assert found.kawasaki_deg == pytest.approx(2 * np.degrees(0.02 / 20), rel=1e-3)
    words = worded(drawn)
    assert words.kind is VerdictKind.VERTICES_OFF
    assert "up to about 0.02 mm (vertex 4): --tolerance-deg 0.2 accepts that" in words.text
    assert misplaced_vertices(map_off_by(5.0), np.array([4])) == []


def test_the_room_of_layers_does_not_make_up_for_angles_that_do_not_close():
    plain = grid(3, 3, 33.3)
    (x, y), across = plain.vertices_coords.T, plain.edges_vertices
    upright = x[across[:, 0]] == x[across[:, 1]]
    column, row = (each[across].min(axis=1).round(1) // 33.3 for each in (x, y))
    valley = np.where(upright, column == 1, (column + row) % 2 == 1)
    letters = np.where(plain.edges_assignment == "B", "B", np.where(valley, "V", "M"))
    angle = np.select([letters == "V", letters == "M"], [180.0, -180.0])
    turn = np.array([[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]])
    drawn = replace(
        plain,
        vertices_coords=(plain.vertices_coords @ turn).round(1),
        edges_assignment=letters,
        edges_foldAngle=angle,
    )
    for tolerance in (Tolerance(), Tolerance(1.0)):
        _, verdict, findings = fold_and_judge(drawn, FoldSettings(), tolerance=tolerance)
        assert verdict.reached == (verdict.closure_max_rad <= tolerance.closure_rad)
        assert verdict.reached == ("angles-do-not-close" not in {each.code for each in findings})


def test_patterns_of_unassigned_creases_say_that_letters_are_missing():
    pattern = grid(2, 2, 20.0)
    letters = np.where(pattern.edges_assignment == "V", "U", "B")
    free = replace(pattern, edges_assignment=letters, edges_foldAngle=np.zeros(len(letters)))
    _, _, findings = fold_and_judge(free, FoldSettings(steps=1))
    (told,) = [each for each in findings if each.code == "nothing-to-fold"]
    assert "4 creases turn freely" in told.text
    assert "give letters M and V" in told.text
    assert rigid_motion(free).sentence() == (
        "no crease folds: 4 are unassigned (U), give letters M and V"
    )
    assert layer_orders(free).text() == (
        "folds flat: yes, its layers have 8 orders, with 4 unassigned creases folded to either side"
    )
    flat = replace(free, edges_assignment=np.where(letters == "U", "F", "B"))
    assert rigid_motion(flat).sentence() == "no crease folds"


@pytest.mark.parametrize("radius", [50.0, 200.0])
def test_a_strip_on_a_cylinder_has_its_curvature(radius):
    frame = framework(quads(20, 2, 100.0, 20.0))
    x, y = (frame.vertices_coords[:, :2] * frame.size_mm).T
    coords = np.stack([radius * np.sin(x / radius), y, radius * (1 - np.cos(x / radius))], axis=1)
    found = curvature_max_per_mm(frame, coords / frame.size_mm)
    assert found == pytest.approx(1 / radius, rel=1e-3)


@pytest.mark.parametrize(("name", "vertex"), [("miura", 15), ("square_twist", 6), ("crane", 23)])
def test_the_vertex_that_is_off_its_place_is_found_with_its_distance(name, vertex):
    pattern = pattern_of(name)
    size = float(np.hypot(*np.ptp(pattern.vertices_coords, axis=0)))
    coords = pattern.vertices_coords.copy()
    coords[vertex] += 1e-3 * size * np.array([0.6, 0.8])
    moved = replace(pattern, vertices_coords=coords)
    open_vertices = np.flatnonzero(vertices_closure_rad(moved) > 1e-3)
    assert vertex in open_vertices
    assert len(open_vertices) > 1  # its neighbours do not close either
    found = misplaced_vertices(moved, open_vertices)
    assert [each.vertex for each in found] == open_vertices.tolist()
    worst = max(found, key=lambda each: each.distance_mm)
    assert worst.vertex == vertex
    # the nearest move: along a crease that runs on straight a vertex may be anywhere
    assert 0.4e-3 * size < worst.distance_mm < 1.2e-3 * size


def test_a_fold_that_misses_by_a_vertex_says_so():
    pattern = pattern_of("miura")
    coords = pattern.vertices_coords.copy()
    coords[15] += [0.06, 0.08]
    words = worded(replace(pattern, vertices_coords=coords))
    assert words.kind is VerdictKind.VERTICES_OFF
    assert words.text.startswith("folds but for vertices off their places, by up to about 0.1 mm")
    assert "(vertex 15): --tolerance-deg " in words.text


def test_angles_that_are_wrong_are_no_vertices_off_their_places():
    pattern = pattern_of("miura")
    inner = np.isfinite(vertices_closure_rad(pattern))
    crease = np.flatnonzero(
        (np.abs(pattern.edges_foldAngle) > 1) & inner[pattern.edges_vertices].all(axis=1)
    )[0]
    angle = pattern.edges_foldAngle.copy()
    angle[crease] *= 0.8
    wrong = replace(pattern, edges_foldAngle=angle)
    open_vertices = np.flatnonzero(vertices_closure_rad(wrong) > 1e-3)
    assert misplaced_vertices(wrong, open_vertices) == []
    # and beside a vertex that is off elsewhere
    coords = pattern.vertices_coords.copy()
    ends = pattern.edges_vertices[crease]
    far = np.flatnonzero(inner)[np.argmax(np.hypot(*(coords[inner] - coords[ends[0]]).T))]
    coords[far] += 0.02
    both = replace(wrong, vertices_coords=coords)
    open_vertices = np.flatnonzero(vertices_closure_rad(both) > 1e-4)
    found = {each.vertex: each.distance_mm for each in misplaced_vertices(both, open_vertices)}
    if not set(ends.tolist()) & set(found):
        assert found[int(far)] == pytest.approx(0.02 * np.sqrt(2), rel=0.3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda form: form * [1.0, 1.0, -1.0], "mirror image"),
        (lambda form: 25.4 * form, "25.4 times as large"),
        (
            lambda form: form + np.where(np.arange(len(form)) == 3, 0.5, 0.0)[:, None],
            "up to 0.781 mm",
        ),
        (None, "the flat sheet"),
    ],
)
def test_a_folded_form_that_contradicts_the_angles_is_blamed_and_the_fold_is_not(change, said):
    pattern = pattern_of("miura")
    form = framework(pattern).kinematics.folded_coords
    flat = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    given = flat if change is None else change(form)
    _, verdict, findings = fold_and_judge(
        replace(pattern, folded_coords=given), FoldSettings(steps=3)
    )
    assert verdict.reached
    (blamed,) = [finding for finding in findings if finding.code == "folded-form-differs"]
    assert said in blamed.text
    assert blamed.text.endswith("the angles are the target.")
    # moved and turned it is the same form
    turned = (form + 7.0)[:, [1, 2, 0]]
    _, _, findings = fold_and_judge(replace(pattern, folded_coords=turned), FoldSettings(steps=3))
    assert "folded-form-differs" not in {finding.code for finding in findings}


def test_shipped_sheets_say_what_they_bear_thin_ones_first():
    names = [each.name for each in bearing_sheets()]
    assert names[:2] == ["copy_paper_80gsm", "pet_film_0.19mm"]
    assert "plywood_3mm" not in names  # no source gives a figure
    assert [each.name for each in bearing_sheets("card_300gsm")] == ["card_300gsm"]
    dotted = "polypropylene_0.5mm"
    assert [each.name for each in bearing_sheets(dotted)] == [dotted]


@pytest.mark.parametrize("angle_deg", [0.0, 1e-200])
def test_vertices_whose_creases_do_not_fold_say_nothing_of_their_places(angle_deg):
    flat = fan(3, 50.0)
    angles = np.where(flat.edges_assignment == "M", -angle_deg, 0.0)
    assert misplaced_vertices(replace(flat, edges_foldAngle=angles), np.array([0])) == []
