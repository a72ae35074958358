"""Kerf: exact areas, forth and back, no ring that crosses itself."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from fab.drawings.beam import Beam
from fab.errors import Severity
from fab.sheets.crease_cuts import cuts_along
from fab.sheets.crease_styles import DashStyle
from fab.sheets.kerf import compensated as moved_by
from solver import InvalidValue


def compensated(outlines, kerf):
    """Rings and findings where no gap is cut."""
    moved = moved_by(outlines, kerf)
    assert len(moved.gaps) == 0
    return moved.rings, list(moved.findings)


def square(a, x=0.0, y=0.0):
    return np.array([[x, y], [x + a, y], [x + a, y + a], [x, y + a]])


def area(ring):
    x, y = ring.T
    return np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2


@given(st.floats(1.0, 500.0), st.floats(0.001, 0.9))
def test_a_square_grows_by_the_kerf_and_a_hole_shrinks_by_it(a, kerf):
    (ring,), findings = compensated([square(a)], kerf)
    assert findings == []
    assert area(ring) == pytest.approx((a + kerf) ** 2, rel=1e-12)
    assert len(ring) == 4
    (hole,), findings = compensated([square(a)[::-1]], kerf)
    assert findings == []
    assert area(hole) == pytest.approx(-((a - kerf) ** 2), rel=1e-9)


@st.composite
def stars(draw):
    """Polygons around a point with corners of random distance, sides of at least about 5 mm."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(3, 12))
    turn = (np.arange(count) + random.uniform(-0.3, 0.3, count)) * 2 * np.pi / count
    radius = random.uniform(20, 60, count)
    return radius[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])


def turns(ring):
    """Signed turn at each corner, positive to the left."""
    before = ring - np.roll(ring, 1, axis=0)
    after = np.roll(ring, -1, axis=0) - ring
    return np.arctan2(
        before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1)
    )


@given(stars(), st.floats(0.01, 0.5))
def test_area_grows_by_the_perimeter_and_its_corners(ring, kerf):
    turn = turns(ring)
    assume(np.abs(turn).max() < 2.7)  # mitres within their limit: 1 / cos(turn / 2) < 5
    (moved,), findings = compensated([ring], kerf)
    assert findings == []
    d = kerf / 2
    perimeter = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T).sum()
    wanted = area(ring) + perimeter * d + d * d * np.tan(turn / 2).sum()
    # what shapely simplifies away: 1 % of the distance at a corner
    assert area(moved) == pytest.approx(wanted, abs=0.02 * d * perimeter)
    assert shapely.LinearRing(moved).is_simple
    assert shapely.Polygon(moved).contains(shapely.Polygon(ring))
    (back,) = moved_by([moved[::-1]], kerf).rings
    assert shapely.hausdorff_distance(shapely.LinearRing(back), shapely.LinearRing(ring)) < 0.1 * d


@given(stars(), st.floats(0.0, 10.0))
def test_no_ring_crosses_itself_whatever_the_kerf(ring, kerf):
    for step in (1, -1):
        moved = moved_by([ring[::step]], kerf)
        rings, codes = moved.rings, [finding.code for finding in moved.findings]
        assert rings or codes == ["hole-narrower-than-kerf"]
        assert rings or len(moved.gaps)
        assert all(shapely.LinearRing(r).is_simple for r in rings)
        assert all((area(r) > 0) == (step > 0) for r in rings) or codes


@given(stars(), st.floats(0.05, 60.0))
def test_a_hole_is_cut_into_every_corner_that_is_deeper_than_the_kerf(ring, kerf):
    """Wherever the ring of the beam does not come near, a centre line or a pierce does."""
    if kerf > 10:  # a hole of a millimetre or so
        ring, kerf = ring * 0.01, 0.5
    hole = shapely.Polygon(ring)
    moved = moved_by([ring[::-1]], kerf)
    lines = [shapely.LinearRing(r) for r in moved.rings] + list(shapely.linestrings(moved.gaps))
    assert shapely.distance(shapely.points(ring), shapely.union_all(lines)).max() < 2 * kerf
    assert hole.buffer(1e-9).covers(shapely.union_all(lines))


@example(1e-4, 100.0, 0.7, 0.15)
@given(st.floats(0.1, 0.95), st.floats(2.0, 30.0), st.floats(0, 6.28), st.floats(0.05, 2.0))
def test_a_slot_narrower_than_the_kerf_is_one_line_as_long_as_the_slot(share, depth, turn, kerf):
    """In an outline it begins at the outline, as a hole it is as long as the hole."""
    half = share * kerf / 2
    c, s = np.cos(turn), np.sin(turn)
    place = np.array([[c, s], [-s, c]])
    assume(depth > 3 * kerf)
    slot = np.array([[half, 0], [half, depth], [-half, depth], [-half, 0]])
    edge = 20 * kerf
    around = np.array([[edge, 0], [edge, depth + edge], [-edge, depth + edge], [-edge, 0]])
    outline = np.vstack([around, slot[[3, 2, 1, 0]]])
    for rings, code in (
        ([outline], "gap-narrower-than-kerf"),
        ([square(3 * depth, -depth, -depth), slot[::-1]], "hole-narrower-than-kerf"),
    ):
        moved = moved_by([ring @ place for ring in rings], kerf)
        assert [finding.code for finding in moved.findings] == [code]
        assert len(moved.rings) == 1
        (line,) = moved.gaps @ place.T
        line = line[np.argsort(line[:, 1])]
        assert line == pytest.approx(np.array([[0, 0], [0, depth]]), abs=1e-3 * kerf)


@given(st.floats(5.0, 28.0), st.floats(0.05, 0.5))
def test_a_wedge_is_cut_as_deep_as_the_kerf_lets_it_and_then_once(angle_deg, kerf):
    half = 20 * np.tan(np.radians(angle_deg / 2))
    assume(half > 2 * kerf)
    wedge = np.array([[-30, 0], [30, 0], [30, 40], [half, 40], [0, 20], [-half, 40], [-30, 40.0]])
    moved = moved_by([wedge], kerf)
    (line,) = moved.gaps
    line = line[np.argsort(line[:, 1])]
    inner = 20 + kerf / 2 / np.sin(np.radians(angle_deg / 2))  # where the moved sides meet
    assert min(abs(moved.rings[0][:, 1] - inner)) < 1e-9
    assert line == pytest.approx(np.array([[0, 20], [0, inner - kerf / 2]]), abs=0.05 * kerf)
    assert [finding.code for finding in moved.findings] == ["gap-narrower-than-kerf"]


@given(st.floats(60.0, 170.0), st.floats(0.05, 0.5))
def test_a_plain_corner_is_not_cut_twice(angle_deg, kerf):
    half = 10 * np.tan(np.radians(angle_deg / 2))
    wedge = np.array([[-half, 0], [half, 0], [half, 40], [0, 30], [-half, 40.0]])
    assert compensated([wedge], kerf)[1] == []


def test_mitres_are_limited():
    needle = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 0.5]])
    (ring,), _ = compensated([needle], 0.2)
    assert ring[:, 0].max() < 100 + 0.1 * 5.01
    assert ring[:, 0].max() > 100


def test_no_kerf_changes_nothing():
    rings, findings = compensated([square(10.0)], 0.0)
    assert findings == []
    assert (rings[0] == square(10.0)).all()


def test_what_a_beam_cannot_cut_is_named():
    moved = moved_by([square(10.0), square(0.3, 4, 4)[::-1]], 0.3)
    (finding,) = moved.findings
    assert len(moved.rings) == 1
    assert moved.gaps == pytest.approx(np.array([[[4.145, 4.15], [4.155, 4.15]]]))
    assert finding.code == "hole-narrower-than-kerf"
    assert finding.text == (
        "1 of 2 outlines (around x = 4.150, y = 4.150 mm) is a hole nowhere wider than the kerf "
        "(0.3 mm) and is cut as 1 pierce. Enlarge it, or take a finer beam."
    )
    slot = np.array([[6, 4], [6, 4.2], [9, 4.2], [9, 4.0]])
    (finding,) = moved_by([square(10.0), square(0.3, 4, 4)[::-1], slot], 0.3).findings
    assert finding.text == (
        "2 of 3 outlines (the first around x = 4.150, y = 4.150 mm) are holes nowhere wider than "
        "the kerf (0.3 mm) and are cut as 1 centre line of 3 mm and 1 pierce. Enlarge them, or "
        "take a finer beam."
    )
    # a C whose mouth is narrower than the beam
    mouth = np.array(
        [
            [0, 0],
            [9, 0],
            [9, 4.4],
            [5, 4.4],
            [5, 3],
            [3, 3],
            [3, 6],
            [5, 6],
            [5, 4.6],
            [9, 4.6],
            [9, 9],
            [0, 9.0],
        ]
    )
    moved = moved_by([mouth], 0.3)
    (finding,) = moved.findings
    assert finding.code == "gap-narrower-than-kerf"
    assert finding.text == (
        "1 of 1 outline (around x = 5.167, y = 4.500 mm) has a notch or a waist narrower than the "
        "kerf (0.3 mm), cut as 1 centre line of 4 mm. Enlarge the sheet, or take a finer beam."
    )
    assert [area(ring) > 0 for ring in moved.rings] == [True, False]
    (line,) = moved.gaps
    assert line[np.argsort(line[:, 0])] == pytest.approx(np.array([[5, 4.5], [9, 4.5]]), abs=1e-3)
    # a hole of two rooms whose passage is narrower than the beam
    rooms = np.array([[0, 0], [3, 0], [3, 1.9], [6, 1.9], [6, 0], [9, 0], [9, 4.0]])
    rooms = np.vstack([rooms, [[6, 4], [6, 2.1], [3, 2.1], [3, 4], [0, 4]]])
    moved = moved_by([rooms[::-1]], 0.3)
    assert [finding.code for finding in moved.findings] == ["gap-narrower-than-kerf"]
    assert [area(ring) for ring in moved.rings] == pytest.approx([-2.7 * 3.7] * 2)
    (line,) = moved.gaps
    assert line[np.argsort(line[:, 0])] == pytest.approx(np.array([[3, 2], [6, 2]]), abs=1e-3)
    # neighbours nearer than the beam
    rings, (finding,) = compensated([square(10.0), square(10.0, 10.2, 0)], 0.3)
    assert len(rings) == 2
    assert finding.code == "outlines-nearer-than-kerf"
    assert finding.text.startswith("1 pair of outlines is nearer to each other than the kerf")
    _, findings = compensated([square(10.0), square(10.0, 10.4, 0)], 0.3)
    assert findings == []


def test_an_outline_that_crosses_itself_stays_and_is_an_error():
    bow = np.array([[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 12.0]])
    rings, (finding,) = compensated([bow], 0.2)
    assert (rings[0] == bow).all()
    assert finding.code == "outline-crosses-itself"
    assert finding.severity == Severity.ERROR


@pytest.mark.parametrize("kerf", [-0.1, float("nan")])
def test_bad_kerfs_are_refused(kerf):
    with pytest.raises(InvalidValue, match=r"kerf_mm"):
        compensated([square(1.0)], kerf)


def turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


@given(stars(), st.floats(0.05, 0.5), st.floats(0.05, 0.5), st.floats(0, 7))
@settings(max_examples=25)
def test_a_beam_wider_along_an_axis_leaves_what_was_asked_for(star, x, y, angle):
    """The ellipse swept along the moved ring touches the outline, and takes nothing of it."""
    beam = Beam(x, y).turned(angle)
    moved = moved_by([star], beam)
    assume(len(moved.rings) == 1 and not moved.findings)
    (ring,) = moved.rings
    turn = np.arange(180) * np.pi / 90
    ellipse = turned(np.column_stack([x / 2 * np.cos(turn), y / 2 * np.sin(turn)]), angle)
    sides = np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)
    swept = shapely.union_all(
        [
            shapely.MultiPoint(np.concatenate([a + ellipse, b + ellipse])).convex_hull
            for a, b in sides
        ]
    )
    left = shapely.Polygon(ring).difference(swept)
    wanted = shapely.Polygon(star)
    chords = 1e-4 * max(x, y) * wanted.length  # of the ellipse, over its arcs
    assert wanted.difference(left).area < chords  # nothing of it is taken
    # what is left beside it is in concave corners, where the beam is round
    concave = star[turns(star) < 0]
    corners = shapely.MultiPoint(concave).buffer(6 * max(x, y)) if len(concave) else shapely.Point()
    assert left.difference(wanted).difference(corners).area < chords


def test_kerfs_of_a_square_are_those_of_the_axes_however_it_is_turned():
    for quarter, size in ((0.0, [9.1, 9.3]), (np.pi / 2, [9.3, 9.1])):
        moved = moved_by([square(9.0)], Beam(0.1, 0.3).turned(quarter))
        assert np.ptp(moved.rings[0], axis=0) == pytest.approx(size)
        hole = moved_by([square(9.0)[::-1]], Beam(0.1, 0.3).turned(quarter))
        assert np.ptp(hole.rings[0], axis=0) == pytest.approx(18 - np.array(size))


def test_gaps_narrower_than_one_of_the_kerfs_are_cut_once_where_they_are():
    notch = [[0, 0], [90, 0], [90, 60], [45.1, 60], [45.1, 20], [44.9, 20], [44.9, 60], [0, 60]]
    flat = np.array(notch, float)
    moved = moved_by([flat], Beam(0.3, 0.1))
    assert len(moved.gaps)
    assert [f.code for f in moved.findings] == ["gap-narrower-than-kerf"]
    assert moved.gaps[..., 0] == pytest.approx(45.0, abs=1e-6)
    length = np.hypot(*(moved.gaps[:, 1] - moved.gaps[:, 0]).T).sum()
    assert length == pytest.approx(40.0, abs=0.2)
    assert "0.3 x 0.1 mm" in moved.findings[0].text
    assert len(moved_by([flat], Beam(0.1, 0.3)).gaps) == 0  # wide enough along x
    hole = square(0.2)[::-1] + 4.0
    pierced = moved_by([hole], Beam(0.3, 0.6))
    assert pierced.gaps.mean(axis=1) == pytest.approx(np.array([[4.1, 4.1]]), abs=0.051)
    assert np.hypot(*(pierced.gaps[0, 1] - pierced.gaps[0, 0])) == pytest.approx(0.01)


def test_dashes_are_shorter_by_the_kerf_along_them():
    ends = np.array([[[0.0, 0.0], [23, 0]], [[0, 0.0], [0, 23]], [[0, 0], [17.0, 17.0]]])
    style = DashStyle(cut_mm=3.0, gap_mm=1.0)
    whole, cut = cuts_along(ends, style, 0.0), cuts_along(ends, style, 0.0, Beam(0.1, 0.3))
    less = np.hypot(*np.diff(whole.segments, axis=1)[:, 0].T)
    less -= np.hypot(*np.diff(cut.segments, axis=1)[:, 0].T)
    diagonal = 2 / np.hypot(np.sqrt(0.5) / 0.05, np.sqrt(0.5) / 0.15)
    for line, kerf in enumerate((0.1, 0.3, diagonal / 1.0)):
        assert less[cut.owner == line] == pytest.approx(kerf)
    with pytest.raises(InvalidValue, match="kerf_mm"):
        cuts_along(ends[:1], style, 0.0, Beam(0.0, 0.3))
