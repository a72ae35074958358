"""Contact: exact distances and steps, stops that are known, stacks and rolls, nothing crosses."""

import numpy as np
import pytest
from flat_patterns import pattern_of, turned_strip
from folded_strips import folded_strip, pattern_like
from helpers import PATTERNS
from hypothesis import given, settings
from hypothesis import strategies as st

from fab import read_pattern
from fab.errors import Severity
from fab.folding.bar_hinge_model import framework
from fab.folding.bending import largest_bend
from fab.folding.contact import contact_fold, past_contact
from fab.folding.contact.barrier import barrier, barrier_curvature, barrier_slope
from fab.folding.contact.closest_points import segment_weights, separations, triangle_weights
from fab.folding.contact.contact import Contact
from fab.folding.contact.contact_fold import REACH_LAST, fold_in_contact
from fab.folding.contact.fold_orders import fold_orders
from fab.folding.contact.surface import surface_of
from fab.folding.fold_settings import FoldSettings, Stiffness
from fab.folding.quasi_static import fold
from fab.folding.simulation import Solver, fold_and_judge
from fab.folding.tolerance import Tolerance
from fab.folding.verdict import judge
from fab.pattern.crease_pattern import CreasePattern
from solver.self_intersection import crossing_faces
from solver.vectors import norm

SEEDS = st.integers(0, 2**31)


def flat_miura(columns, rows, side=20.0, acute_deg=60.0) -> CreasePattern:
    """Parallelograms, all creases folded by 180 degrees."""
    turn = np.radians(acute_deg)
    i, j = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    coords = np.column_stack(
        [
            (i * side + np.where(j % 2, side * np.cos(turn), 0)).ravel(),
            (j * side * np.sin(turn)).ravel(),
        ]
    )
    across = columns + 1
    faces = [
        [r * across + c, r * across + c + 1, (r + 1) * across + c + 1, (r + 1) * across + c]
        for r in range(rows)
        for c in range(columns)
    ]
    plain = pattern_of(coords, faces, "V")
    (row, other), (column, beside) = (x.T for x in np.divmod(plain.edges_vertices, across))
    straight = row == other
    sign = np.where(
        straight,
        np.where((row + np.minimum(column, beside)) % 2, -1.0, 1.0),
        np.where(column % 2, 1.0, -1.0),
    )
    inner = plain.edges_assignment != "B"
    angle = np.where(inner, 180.0 * sign, 0.0)
    return pattern_like(plain, np.where(inner, np.where(sign > 0, "V", "M"), "B"), angle)


def crossings(frame, coords):
    triangles = frame.triangles_vertices
    return crossing_faces(coords, triangles.ravel(), 3 * np.arange(len(triangles) + 1))


def assert_nothing_crosses(folding):
    for state in folding.states:
        assert len(crossings(folding.frame, state.coords)) == 0, state.load
        assert all(a >= b for a, b in zip(state.accepted, state.accepted[1:], strict=False))


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.booleans(), st.sampled_from([0.0, 1e-9, 1e-3, 1.0]))
def test_closest_points_are_the_closest(seed, of_triangle, spread):
    random = np.random.default_rng(seed)
    points = random.normal(size=(1, 4, 3))
    # nearly flat triangles and nearly parallel segments too
    points[0, 3] = points[0, 2] + random.normal() * (points[0, 1] - points[0, 0])
    points[0, 3] += spread * random.normal(size=3)
    if of_triangle:
        weights, parts = triangle_weights(points), [[0], [1, 2, 3]]
    else:
        weights, parts = segment_weights(points), [[0, 1], [2, 3]]
    assert abs(weights.sum()) < 1e-9
    for part, sign in zip(parts, (1, -1), strict=True):
        assert (sign * weights[0, part] > -1e-9).all()
    found, _ = separations(points, weights)
    shares = [random.dirichlet(np.full(len(part), 0.5), 2000) for part in parts]
    first, second = (s @ points[0, part] for s, part in zip(shares, parts, strict=True))
    assert np.linalg.norm(first - second, axis=1).min() >= found[0] - 1e-9
    if not of_triangle:  # and the ends, of which samples have few
        for end in points[0, :2]:
            t = np.clip(
                (end - points[0, 2]) @ (d := points[0, 3] - points[0, 2]) / max(d @ d, 1e-300), 0, 1
            )
            assert np.linalg.norm(end - points[0, 2] - t * d) >= found[0] - 1e-9


def test_the_barrier_has_the_slopes_that_it_gives():
    share = np.linspace(0.01, 0.99, 50)
    step = 1e-6
    slope = (barrier(share + step) - barrier(share - step)) / (2 * step)
    np.testing.assert_allclose(barrier_slope(share), slope, rtol=1e-6, atol=1e-8)
    bend = (barrier_slope(share + step) - barrier_slope(share - step)) / (2 * step)
    np.testing.assert_allclose(barrier_curvature(share), bend, rtol=1e-6, atol=1e-7)


def crumpled(seed):
    """A frame, and coordinates at which many of its parts are near each other."""
    frame = framework(folded_strip([30.0] * 6, [170, -170] * 2 + [170]))
    folding = fold(frame)
    random = np.random.default_rng(seed)
    return frame, folding.states[-1].coords + random.normal(0, 2e-3, frame.vertices_coords.shape)


@pytest.mark.parametrize("thickness_mm", [0.0, 0.5])
def test_the_gradient_is_that_of_the_energy(thickness_mm):
    frame, coords = crumpled(3)
    contact = Contact(surface_of(frame, thickness_mm), 0.05, 1.0)
    found = contact.touching(coords)
    assert (found.parallel < 1).any()
    assert (found.parallel == 1).any()
    random = np.random.default_rng(0)
    gradient, blocks = contact.linearised(coords)
    for _ in range(5):
        way = random.normal(size=coords.shape)
        step = 1e-8
        slope = (contact.energy(coords + step * way) - contact.energy(coords - step * way)) / 2
        assert np.sum(gradient * way) == pytest.approx(slope / step, rel=1e-4)
    for matrix in blocks[0].matrices[:20]:
        assert np.linalg.eigvalsh(matrix).min() > -1e-9 * np.abs(matrix).max()


@settings(max_examples=8, deadline=None)
@given(SEEDS)
def test_a_free_step_crosses_nothing_and_leaves_room(seed):
    frame, coords = crumpled(seed % 5)
    contact = Contact(surface_of(frame), 1e-2, 1.0)
    if len(crossings(frame, coords)):
        return
    step = np.random.default_rng(seed).normal(0, 0.05, coords.shape)
    share = contact.longest_step(coords, step)
    assert 0 <= share <= 1
    for part in np.linspace(0, share, 7):
        assert len(crossings(frame, coords + part * step)) == 0
        assert np.isfinite(contact.energy(coords + part * step))


def test_parts_that_slide_along_each_other_are_free():
    frame, coords = crumpled(0)
    contact = Contact(surface_of(frame), 1e-2, 1.0)
    turned = coords @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    assert contact.longest_step(coords, np.full_like(coords, 3.0)) == 1.0
    assert contact.energy(turned) == pytest.approx(contact.energy(coords), rel=1e-9)


@pytest.mark.parametrize(
    ("base", "flap", "target_deg"), [(30.0, 30.0, 150.0), (30.0 * np.sqrt(2), 30.0, 150.0)]
)
def test_two_flaps_stop_where_their_tips_meet(base, flap, target_deg):
    # the second pair meets at 90 degrees
    pattern = folded_strip([flap, base, flap], [target_deg] * 2)
    folding = fold_in_contact(framework(pattern))
    meet_deg = 180 - np.degrees(np.arccos(base / 2 / flap))
    assert folding.stopped is not None
    assert folding.stopped.faces == (0, 2)
    # a thousandth of the size is what the barrier reaches
    assert folding.stopped.share == pytest.approx(meet_deg / target_deg, abs=3e-3)
    ends = [place[0] for place in folding.stopped.flat_mm]
    np.testing.assert_allclose(ends, [0.0, base + 2 * flap], atol=0.2)
    assert not judge(folding).reached
    assert_nothing_crosses(folding)


def square_roll(turns, pitch):
    lengths = [10 + pitch * (number // 2) for number in range(4 * turns)]
    return folded_strip(lengths, [90.0] * (len(lengths) - 1))


def spiral(turns, pitch, panels=20):
    """A ribbon that rolls up to a spiral, mm, of so many panels a turn."""
    turned = np.linspace(0, 2 * np.pi * turns, panels * turns + 1)
    ends = (6 + pitch * turned / (2 * np.pi)) * np.exp(1j * turned)
    sides = np.diff(ends)
    angles = np.degrees(np.angle(sides[1:] / sides[:-1]))
    return folded_strip(np.abs(sides), angles, width=3.0)


def test_a_strip_rolls_up_where_its_turns_have_room():
    frame = framework(square_roll(turns=3, pitch=2.0))
    through = fold(frame)
    assert any(len(crossings(frame, state.coords)) for state in through.states)
    rolled = fold_in_contact(frame)
    assert judge(rolled).reached
    assert rolled.stopped is None
    assert_nothing_crosses(rolled)
    thick = fold_in_contact(frame, thickness_mm=1.0)
    assert judge(thick).reached
    assert_nothing_crosses(thick)


def test_a_strip_thicker_than_its_pitch_does_not_roll_up():
    thick = fold_in_contact(framework(square_roll(turns=2, pitch=2.0)), thickness_mm=4.0)
    assert not judge(thick).reached
    assert_nothing_crosses(thick)


def test_pleats_close_to_the_height_of_their_stack():
    frame = framework(folded_strip([30.0] * 6, [180, -180] * 2 + [180]))
    thickness = 1.0
    folding = fold_in_contact(frame, thickness_mm=thickness)
    # from each crease to the next panel but one it is the thickness: L sin(opening) = t
    opening = np.degrees(np.arcsin(thickness / 30.0))
    hinges = frame.hinges_edge >= 0
    angles = np.abs(np.degrees(frame.angles_near(folding.states[-1].coords, frame.hinges_target)))
    np.testing.assert_allclose(angles[hinges], 180 - opening, atol=0.1)
    assert judge(folding).reached
    assert_nothing_crosses(folding)


def test_a_miura_without_thickness_closes():
    folding = fold_in_contact(framework(flat_miura(4, 3)))
    verdict = judge(folding)
    assert verdict.reached
    assert verdict.angle_error_max_deg < 0.1
    assert_nothing_crosses(folding)
    contact = Contact(surface_of(folding.frame), 1e-3, 1.0)
    assert len(contact.touching(folding.states[-1].coords).room) > 0


def closed_miura(side, acute_deg, thickness):
    """Openings of its zigzag and straight creases, radians, and its height by row.

    Its one degree of freedom ties the openings z and s by tan(s / 2) = tan(z / 2) / cos(acute).
    Across a zigzag crease, the far corner of a face is side sin(acute) sin(z) above the next face,
    if its foot lies on it, which is so up to 2 cos(acute) = 1; across a straight crease it is
    side sin(acute) sin(s), which is less where its foot does not. At the thickness it is closed.
    """
    acute = np.radians(acute_deg)
    opening = np.arcsin(thickness / side / np.sin(acute))
    if 2 * np.cos(acute) <= 1 + 1e-12:
        zigzag = opening
        straight = 2 * np.arctan(np.tan(zigzag / 2) / np.cos(acute))
    else:
        straight = opening
        zigzag = 2 * np.arctan(np.tan(straight / 2) * np.cos(acute))
    return zigzag, straight, miura_steps(side, acute, zigzag)[0]


def miura_steps(side, acute, zigzag):
    """Along its rows and across them, of the sides (Schenk and Guest 2013)."""
    lean = np.sin(zigzag / 2) * np.tan(acute)
    row, across = side * np.array([lean, 1.0]) / np.hypot(1.0, lean)
    rise = side * np.cos(zigzag / 2) * np.sin(acute)
    return row, across, np.sqrt(side**2 - rise**2), rise


@pytest.mark.parametrize("acute_deg", [50.0, 60.0, 70.0])
@pytest.mark.parametrize("thickness", [0.3, 1.5])
def test_a_closed_miura_is_where_its_faces_come_within_its_thickness(acute_deg, thickness):
    frame = framework(flat_miura(4, 4, acute_deg=acute_deg))
    zigzag, _, _ = closed_miura(20.0, acute_deg, thickness)
    i, j = (each.ravel() for each in np.meshgrid(np.arange(5), np.arange(5)))
    vertices, triangles = np.indices((25, len(frame.triangles_vertices))).reshape(2, -1)
    corners = frame.triangles_vertices[triangles]
    members = np.column_stack([vertices, corners])[(corners != vertices[:, None]).all(axis=1)]
    nearest = []
    for opening in (zigzag, 1.01 * zigzag):
        row, across, column, rise = miura_steps(20.0, np.radians(acute_deg), opening)
        points = np.column_stack([j * row, i * column + j % 2 * across, i % 2 * rise])
        stretched = frame.strains(points / frame.size_mm)
        assert np.abs(stretched).max() < 1e-12
        pairs = points[members]
        nearest.append(separations(pairs, triangle_weights(pairs))[0].min())
    assert nearest[0] == pytest.approx(thickness, rel=1e-9)
    assert nearest[1] > thickness


@pytest.mark.parametrize("acute_deg", [50.0, 60.0, 70.0])
@pytest.mark.parametrize("thickness", [0.3, 1.5])
def test_a_miura_closes_to_the_height_of_its_stack(acute_deg, thickness):
    # stiff, so that neither bars nor faces give way to what closes the creases
    frame = framework(flat_miura(4, 4, acute_deg=acute_deg), Stiffness(axial=2e4, facet=1e3))
    folding = fold_in_contact(frame, thickness_mm=thickness)
    assert judge(folding).reached
    assert_nothing_crosses(folding)
    points = folding.states[-1].coords * frame.size_mm
    # rows after next are parallel: two of them are twice the height of one apart
    heights = norm(points[10:] - points[:-10]) / 2
    least, most = (
        closed_miura(20.0, acute_deg, thickness + room * frame.size_mm)[2]
        for room in (0.0, REACH_LAST)
    )
    assert heights.min() > least * (1 - 1e-4)
    assert heights.max() < most * (1 + 1e-4)


def test_a_base_that_crosses_today_folds_in_contact():
    pattern = read_pattern(PATTERNS / "bird_base.fold")[0]
    through = fold(framework(pattern))
    assert any(len(crossings(through.frame, state.coords)) for state in through.states)
    folding, verdict, findings = fold_and_judge(pattern, FoldSettings())
    assert verdict.reached
    assert_nothing_crosses(folding)
    codes = [finding.code for finding in findings]
    assert "folded-in-contact" in codes
    assert "crosses-on-the-way" not in codes


def test_where_contact_stops_a_sheet_is_told_by_default_and_shown_on_request():
    pattern = folded_strip([30.0] * 3, [150.0] * 2)
    shown, verdict, findings = fold_and_judge(pattern, FoldSettings())
    assert verdict.reached
    assert verdict.stopped is not None
    assert verdict.stopped.orders > 1
    assert any(len(crossings(shown.frame, state.coords)) for state in shown.states)
    told = next(each for each in findings if each.code == "stopped-by-contact")
    assert told.panels == (0, 2)
    assert "faces 0 and 2" in told.text
    assert told.severity is Severity.WARNING
    assert "Another order may get there" in told.text
    shown, verdict, findings = fold_and_judge(pattern, FoldSettings(contact=True))
    assert not verdict.reached
    assert_nothing_crosses(shown)
    missed = next(each for each in findings if each.code == "target-not-reached")
    assert missed.text.endswith("its faces keep it from them: see stopped-by-contact.")
    _, verdict, findings = fold_and_judge(pattern, FoldSettings(contact=False))
    assert verdict.stopped is None
    assert "stopped-by-contact" not in [each.code for each in findings]


def test_a_thickness_of_the_order_of_the_panels_stops_a_sheet():
    pattern = folded_strip([10.0] * 3, [-180.0, 180.0], width=10.0)
    for thickness_mm, closes in ((0.1, True), (1.0, True), (3.0, False), (25.0, False)):
        given = FoldSettings(contact=True, thickness_mm=thickness_mm)
        folding, verdict, findings = fold_and_judge(pattern, given)
        assert verdict.reached == closes
        assert (verdict.stopped is None) == closes
        assert len(verdict.off_creases) == (0 if closes else 2)
        assert_nothing_crosses(folding)
        stops = [each.text for each in findings if each.code == "stopped-by-contact"]
        assert len(stops) == (not closes)
        for text in stops:
            assert f"The sheet is {thickness_mm:g} mm thick" in text
            assert "lower thickness_mm" in text
    # what is pressed is strained, and no sheet is said to bear less
    assert largest_bend(folding).strain == pytest.approx(verdict.strain_max)
    assert verdict.strain_max > 0.01


def test_layers_that_settle_off_their_target_are_said_to_take_the_room():
    pattern = folded_strip([20.0] * 5, [-180.0, 180.0, -180.0, 180.0], width=30.0)
    _, verdict, findings = fold_and_judge(pattern, FoldSettings(thickness_mm=5.0))
    assert not verdict.reached
    assert verdict.stopped is None
    (missed,) = [each for each in findings if each.code == "target-not-reached"]
    assert missed.text.endswith("its layers take too much room: try a lower thickness_mm.")


def test_four_equal_panels_roll_up_with_ends_in_their_creases(monkeypatch):
    pattern = folded_strip([10.0] * 4, [-180.0] * 3, width=10.0)
    folding, verdict, findings = fold_and_judge(pattern, FoldSettings())
    assert verdict.reached
    assert verdict.stopped is None
    assert_nothing_crosses(folding)
    assert [f.code for f in findings if "contact" in f.code] == ["folded-in-contact"]
    # off by the root of what layers are apart: without thickness by nothing
    path = next(fold_orders(folding.frame))
    for reaches in ((1e-4,), (1e-4, 1e-5), (1e-4, 1e-5, 1e-6)):
        monkeypatch.setattr(contact_fold, "_REACHES_LAST", reaches)
        verdict = judge(fold_in_contact(folding.frame, path=path))
        root = np.sqrt(reaches[-1])
        assert np.radians(verdict.angle_error_max_deg) / root == pytest.approx(6.0, rel=0.02)
        assert verdict.rmsd_rel / root == pytest.approx(1.37, rel=0.02)


def test_a_thickness_switches_contact_on_unless_it_is_left_out():
    pattern = folded_strip([10.0] * 3, [-180.0, 180.0], width=10.0)
    given = FoldSettings(thickness_mm=1.0)
    folding, verdict, findings = fold_and_judge(pattern, given)
    held, _, _ = fold_and_judge(pattern, given.model_copy(update={"contact": True}))
    assert folding.states[-1].coords.tobytes() == held.states[-1].coords.tobytes()
    assert verdict.reached
    assert verdict.layers_rel > 0.03
    assert "thickness-not-used" not in [each.code for each in findings]
    _, verdict, findings = fold_and_judge(pattern, FoldSettings(thickness_mm=25.0))
    assert not verdict.reached
    assert ("stopped-by-contact", Severity.ERROR) in [(f.code, f.severity) for f in findings]
    without = given.model_copy(update={"contact": False})
    for solver in (Solver.QUASI_STATIC, Solver.DYNAMIC):
        _, verdict, findings = fold_and_judge(pattern, without, solver)
        assert verdict.layers_rel == 0
        told = next(each for each in findings if each.code == "thickness-not-used")
        assert told.severity is Severity.NOTE
        assert "thickness_mm = 1 is not used" in told.text
    _, _, findings = fold_and_judge(pattern, FoldSettings(contact=False))
    assert "thickness-not-used" not in [each.code for each in findings]


def test_layers_make_room_for_creases_that_are_nearly_flat_folded_alone():
    thick = Tolerance().with_layers(0.5)
    target = np.array([180.0, -170.0, 90.0, 0.0])
    np.testing.assert_allclose(thick.creases_deg(target)[:2], 15.1)
    assert thick.creases_deg(target)[2:].max() < 4
    assert thick.strain < 0.02
    assert thick.shape_rel < 0.11
    assert (Tolerance().creases_deg(target) == 0.1).all()


def test_flaps_that_are_in_each_others_way_fold_one_after_the_other():
    # the long flap lies under the short one, which is before it where both fold at one rate
    pattern = folded_strip([34.0, 40.0, 20.0], [178.0, 160.0])
    together = fold_in_contact(framework(pattern))
    assert not judge(together).reached
    assert together.stopped is not None
    assert together.stopped.faces == (0, 2)
    folding, verdict, findings = fold_and_judge(pattern, FoldSettings())
    assert verdict.reached
    assert verdict.stopped is None
    assert folding.in_turn
    assert_nothing_crosses(folding)
    noted = next(each for each in findings if each.code == "folded-in-contact")
    assert "in turn" in noted.text
    assert "stopped-by-contact" not in [each.code for each in findings]


def test_a_fold_in_contact_that_takes_too_long_is_given_up(monkeypatch):
    monkeypatch.setattr(past_contact, "_MOST_PAIRS", 0.0)
    shown, verdict, findings = fold_and_judge(square_roll(3, 2.0), FoldSettings(contact=True))
    told = next(each for each in findings if each.code == "contact-not-finished")
    assert "given up" in told.text
    assert verdict.reached
    assert verdict.stopped is None
    assert any(len(crossings(shown.frame, state.coords)) for state in shown.states)


def test_a_ribbon_of_many_turns_rolls_up():
    frame = framework(spiral(turns=4, pitch=0.6))
    rolled = fold_in_contact(frame)
    assert judge(rolled).reached
    assert_nothing_crosses(rolled)


def test_the_same_fold_has_the_same_bits():
    frame = framework(square_roll(turns=2, pitch=2.0))
    first, second = (fold_in_contact(frame, thickness_mm=0.2) for _ in range(2))
    for one, two in zip(first.states, second.states, strict=True):
        assert one.coords.tobytes() == two.coords.tobytes()


def test_a_flat_sheet_that_overlaps_itself_is_folded_without_contact():
    _, verdict, findings = fold_and_judge(turned_strip(30, 1.2), FoldSettings(contact=True))
    told = next(each for each in findings if each.code == "contact-not-possible")
    assert "lie on each other in the flat sheet" in told.text
    assert verdict.stopped is None


def test_the_flat_sheet_feels_no_contact():
    for pattern in (flat_miura(4, 3), folded_strip([0.01, 30.0, 0.02], [90, 90])):
        frame = framework(pattern, Stiffness())
        contact = Contact(surface_of(frame, 5.0), 1e-3, 1.0)
        assert contact.energy(frame.vertices_coords) == 0
        assert len(contact.touching(frame.vertices_coords).room) == 0


@pytest.mark.parametrize(("name", "off"), [("bird_base", 2.69), ("maze", 4.9)])
def test_angles_are_off_by_the_root_of_what_layers_are_apart(name, off, monkeypatch):
    """In radians and relative to the sheet: what the tolerance of folds in contact rests on."""
    frame = framework(read_pattern(PATTERNS / f"{name}.fold")[0])
    for reaches in ((1e-4,), (1e-4, 1e-5), (1e-4, 1e-5, 1e-6)):
        monkeypatch.setattr(contact_fold, "_REACHES_LAST", reaches)
        verdict = judge(fold_in_contact(frame))
        share = np.radians(verdict.angle_error_max_deg) / np.sqrt(reaches[-1])
        assert share == pytest.approx(off, rel=0.02)
