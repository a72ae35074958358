"""Kerf: exact areas, forth and back, no ring that crosses itself."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from fab.errors import Severity
from fab.sheets.kerf import compensated
from solver import InvalidValue


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
    (back,), _ = compensated([moved[::-1]], kerf)
    assert shapely.hausdorff_distance(shapely.LinearRing(back), shapely.LinearRing(ring)) < 0.1 * d


@given(stars(), st.floats(0.0, 10.0))
def test_no_ring_crosses_itself_whatever_the_kerf(ring, kerf):
    for step in (1, -1):
        rings, findings = compensated([ring[::step]], kerf)
        assert rings or [f.code for f in findings] == ["hole-narrower-than-kerf"]
        assert all(shapely.LinearRing(r).is_simple for r in rings)
        assert all((area(r) > 0) == (step > 0) for r in rings) or findings


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
    rings, (finding,) = compensated([square(10.0), square(0.3, 4, 4)[::-1]], 0.3)
    assert len(rings) == 1
    assert finding.code == "hole-narrower-than-kerf"
    assert finding.text == (
        "1 of 2 outlines (around x = 4.150, y = 4.150 mm) is a hole nowhere wider than the kerf "
        "(0.3 mm) and is left out. Enlarge it."
    )
    holes = [square(0.3, x, 4)[::-1] for x in (4, 6)]
    _, (finding,) = compensated([square(10.0), *holes], 0.3)
    assert finding.text == (
        "2 of 3 outlines (the first around x = 4.150, y = 4.150 mm) are holes nowhere wider than "
        "the kerf (0.3 mm) and are left out. Enlarge them."
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
    rings, (finding,) = compensated([mouth], 0.3)
    assert finding.code == "gap-narrower-than-kerf"
    assert [area(ring) > 0 for ring in rings] == [True, False]
    # a hole of two rooms whose passage is narrower than the beam
    rooms = np.array([[0, 0], [3, 0], [3, 1.9], [6, 1.9], [6, 0], [9, 0], [9, 4.0]])
    rooms = np.vstack([rooms, [[6, 4], [6, 2.1], [3, 2.1], [3, 4], [0, 4]]])
    rings, (finding,) = compensated([rooms[::-1]], 0.3)
    assert finding.code == "gap-narrower-than-kerf"
    assert [area(ring) for ring in rings] == pytest.approx([-2.7 * 3.7] * 2)
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
