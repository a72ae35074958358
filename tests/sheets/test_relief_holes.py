"""Relief holes: as wide as their webs ask, on no line that is not theirs, apart from each other."""

import numpy as np
import pytest
import shapely
from flat_patterns import fan, grid, triangles
from hypothesis import given
from hypothesis import strategies as st

from fab.drawings.cut_paths import Operation
from fab.sheets.crease_styles import ScoreStyle
from fab.sheets.perforation import cut_layers
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.relief_holes import ReliefSettings


def layers_of(pattern, relief, kerf=0.0, margin=0.5):
    settings = PerforationSettings(
        mountain=ScoreStyle(), valley=ScoreStyle(), margin_mm=margin, relief=relief
    )
    layers, findings = cut_layers(pattern, settings, kerf)
    return {layer.operation: layer for layer in layers}, findings


@given(st.integers(3, 20), st.floats(0.2, 2.0))
def test_a_fan_has_the_hole_that_its_web_asks_for(sides, web):
    radius = web / (2 * np.sin(np.pi / sides))
    layers, findings = layers_of(fan(sides, 60.0), ReliefSettings(web_mm=web))
    assert findings == []
    (ring,) = layers[Operation.RELIEF].outlines
    assert np.hypot(*ring.T) == pytest.approx(radius)
    x, y = ring.T
    area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2
    assert area < 0  # a hole runs clockwise
    assert shapely.distance(shapely.LinearRing(ring), shapely.Point(0, 0)) > radius - 0.00501 or (
        len(ring) == 16
    )
    begins = np.hypot(*layers[Operation.MOUNTAIN].segments.min(axis=1).T)
    segments = layers[Operation.MOUNTAIN].segments
    begins = np.hypot(segments[..., 0], segments[..., 1]).min(axis=1)
    assert begins == pytest.approx(radius + 0.5)
    (polygon,) = layers_of(fan(sides, 60.0), ReliefSettings(web_mm=web, shape="polygon"))[0][
        Operation.RELIEF
    ].outlines
    assert len(polygon) == sides
    side = np.hypot(*(polygon - np.roll(polygon, 1, axis=0)).T)
    assert side == pytest.approx(web)
    turn = np.arctan2(polygon[:, 1], polygon[:, 0]) * sides / (2 * np.pi)
    assert turn == pytest.approx(np.round(turn), abs=1e-6)  # its corners lie on the creases


def test_kerf_makes_the_drawn_hole_smaller():
    relief = ReliefSettings(web_mm=1.0, radius_mm=2.0)
    layers, _ = layers_of(fan(6, 60.0), relief, 0.2)
    (ring,) = layers[Operation.RELIEF].outlines
    assert np.hypot(*ring.T).max() == pytest.approx(1.9, abs=0.01)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("shape", ["round", "polygon"])
def test_holes_keep_their_distance_from_everything_else(seed, shape):
    pattern = triangles(seed, 80)
    web = 1.2
    layers, findings = layers_of(pattern, ReliefSettings(web_mm=web, shape=shape))
    holes = np.array([shapely.Polygon(ring) for ring in layers[Operation.RELIEF].outlines])
    assert len(holes) > 3
    assert {f.code for f in findings} <= {"relief-left-out", "crease-too-short"}
    first, second = shapely.STRtree(holes).query(holes, predicate="dwithin", distance=web - 1e-6)
    assert (first == second).all()
    walls = [shapely.LinearRing(ring) for ring in layers[Operation.CUT].outlines]
    walls += list(shapely.linestrings(layers[Operation.CUT].segments))
    assert shapely.distance(shapely.union_all(holes), shapely.union_all(walls)) >= web - 1e-9
    for operation in (Operation.MOUNTAIN, Operation.VALLEY):
        cuts = shapely.linestrings(layers[operation].segments)
        assert shapely.distance(shapely.union_all(holes), cuts).min() >= 0.5 - 1e-9


def test_holes_that_would_meet_are_left_out_and_named():
    pattern = grid(5, 5, 6.0)
    layers, (finding,) = layers_of(pattern, ReliefSettings(web_mm=1.0, radius_mm=2.6))
    holes = layers[Operation.RELIEF].outlines
    assert finding.code == "relief-left-out"
    assert f"{16 - len(holes)} relief holes" in finding.text
    # every other vertex keeps its hole, as the squares of one colour on a chessboard
    assert len(holes) == 8
    layers, findings = layers_of(pattern, ReliefSettings(web_mm=1.0, radius_mm=2.4))
    assert findings == []
    assert len(layers[Operation.RELIEF].outlines) == 16


def test_a_hole_larger_than_the_sheet_is_left_out():
    layers, findings = layers_of(fan(5, 10.0), ReliefSettings(web_mm=1.0, radius_mm=9.0))
    assert Operation.RELIEF not in layers
    assert [f.code for f in findings] == ["relief-left-out"]
    assert "at vertex 0)" in findings[0].text
    assert len(findings[0].creases) == 5


def test_a_radius_too_small_for_its_webs_is_named():
    _, (finding,) = layers_of(fan(12, 60.0), ReliefSettings(web_mm=1.0, radius_mm=1.0))
    assert finding.code == "relief-web-thin"


def test_no_hole_without_three_cut_creases_or_at_a_cut():
    settings = PerforationSettings(valley=ScoreStyle(), relief=ReliefSettings(web_mm=1.0))
    slit = grid(2, 2, 30.0, cuts=[(4, 5)])
    assert [layer.operation for layer in cut_layers(slit, settings)[0]] == [
        Operation.MOUNTAIN,
        Operation.VALLEY,
        Operation.CUT,
    ]
    flat = fan(6, 30.0, "F")
    assert len(cut_layers(flat, settings)[0]) == 3
