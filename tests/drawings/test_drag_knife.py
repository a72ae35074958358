"""Drag knives: a simulated blade trails behind its axis, and its tip is on the drawn line."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from flat_patterns import stars
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.drawings.closed_cuts import led_in
from fab.drawings.cut_paths import CutPaths, Layer, Operation, polylines
from fab.drawings.drag_knife import blade_led

SIZE = (200.0, 200.0)


def tips(lines, offset):
    """Where the tip of a blade goes that is dragged along lines; lifted, it keeps its direction.

    Each step pulls the tip straight towards the axis, to the offset behind it.
    """
    heading = None
    out = []
    for line in lines:
        steps = [
            np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / (offset / 60))))
            for a, b in pairwise(line)
        ]
        axis = np.concatenate(steps)
        if heading is None:
            heading = (line[1] - line[0]) / np.hypot(*(line[1] - line[0]))
        tip = line[0] - offset * heading
        trace = [tip]
        for point in axis:
            arm = point - tip
            far = np.hypot(*arm)
            if far > offset:
                tip = tip + arm * (1 - offset / far)
                heading = arm / far
            trace.append(tip)
        heading = (axis[-1] - tip) / np.hypot(*(axis[-1] - tip))
        out.append(np.array(trace))
    return out


def farthest(traces, lines):
    """How far tips are from the lines, and points of the lines from the tips."""
    drawn = shapely.union_all([shapely.LineString(line) for line in lines])
    worst = 0.0
    for trace, line in zip(traces, lines, strict=True):
        points = shapely.points(trace)
        worst = max(worst, float(shapely.distance(points, shapely.LineString(line)).max()))
    cut = shapely.union_all([shapely.LineString(trace) for trace in traces])
    return worst, shapely.hausdorff_distance(drawn, cut)


@given(st.integers(0, 10**6), st.sampled_from([0.25, 0.5, 1.0]))
@settings(max_examples=8)
def test_the_tip_follows_sharp_corners_with_compensation_and_not_without(seed, offset):
    outline = stars(1, seed, 80.0)[0] + 100.0
    dashes = np.array([[[20.0, 20], [23, 20]], [[24, 20], [24, 27]], [[30.0, 30], [27, 33]]])
    paths = CutPaths(
        (Layer(Operation.VALLEY, dashes), Layer(Operation.CUT, outlines=(outline,))), SIZE
    )
    drawn = [line for layer in paths.layers for line in polylines(layer)]
    led = [line for layer in blade_led(paths, offset, 5.0).layers for line in polylines(layer)]
    assert len(led) == len(drawn)
    off, apart = farthest(tips(led, offset), drawn)
    assert off <= 0.02 * offset
    assert apart <= 0.03 * offset
    off, apart = farthest(tips(drawn, offset), drawn)
    assert max(off, apart) > 0.3 * offset


def test_gentle_bends_have_no_arcs_and_stay_within_their_error():
    angle = np.linspace(0, 2 * np.pi, 37)[:-1]
    circle = 20 * np.column_stack([np.cos(angle), np.sin(angle)]) + 100
    paths = CutPaths((Layer(Operation.CUT, outlines=(circle,)),), SIZE)
    (line,) = polylines(blade_led(paths, 0.5, 20.0).layers[0])
    assert len(line) == 2 * 36
    off, _ = farthest(tips([line], 0.5), [np.concatenate([circle, circle[:1]])])
    assert off <= 0.5 * (1 - np.cos(np.radians(10.0)))


def test_without_an_offset_nothing_changes_and_marks_never_do():
    layer = Layer(Operation.ENGRAVE, np.array([[[1.0, 1], [2, 5]]]))
    paths = CutPaths((layer,), SIZE)
    assert blade_led(paths, 0.0, 20.0) is paths
    assert blade_led(paths, 0.3, 20.0).layers == (layer,)
    assert led_in(paths, 0.0, 0.0) == (paths, ())


def square(low, high):
    return np.array([[low, low], [high, low], [high, high], [low, high]], float)


@pytest.mark.parametrize("reverse", [False, True])
def test_closed_cuts_begin_in_the_waste_and_go_on_beyond_their_start(reverse):
    rings = [square(20, 100), square(40, 80)[::-1], square(50, 60), square(103, 150)]
    rings = [ring[::-1] if reverse else ring for ring in rings]
    outer = Layer(Operation.CUT, outlines=(rings[2], rings[0], rings[3]))
    paths = CutPaths((Layer(Operation.HOLE, outlines=(rings[1],)), outer), SIZE)
    led, bare = led_in(paths, 4.0, 1.5, turned_over=reverse)
    assert not bare
    lines = [line for layer in led.layers for line in polylines(layer)]
    before = [ring for layer in paths.layers for ring in layer.outlines]
    material = shapely.union_all([shapely.Polygon(ring) for ring in rings])
    material = material.difference(shapely.Polygon(rings[1])).union(shapely.Polygon(rings[2]))
    for line, ring in zip(lines, before, strict=True):
        lead = shapely.LineString(line[:2])
        assert lead.length == pytest.approx(4.0)
        assert lead.intersection(material).length < 1e-9
        closed = shapely.LinearRing(ring)
        assert shapely.LineString(line).length == pytest.approx(closed.length + 4.0 + 1.5)
        rest = shapely.LineString(line[1:])
        assert rest.difference(closed.buffer(1e-9)).length < 1e-9
        assert closed.difference(rest.buffer(1e-9)).length < 1e-9


def test_lead_ins_without_room_are_shorter_or_left_out_with_their_outline():
    slot = np.array([[50.0, 50], [50, 50.8], [90, 50.8], [90, 50]])
    pierce = square(20, 20.3)[::-1]
    around = square(10, 100)
    layers = (
        Layer(Operation.HOLE, outlines=(slot, pierce)),
        Layer(Operation.CUT, outlines=(around,)),
    )
    led, bare = led_in(CutPaths(layers, SIZE), 2.0, 0.0)
    hole = led.layers[0].chains
    assert [ring.tolist() for ring in bare] == [pierce.tolist()]
    assert 0.49 < shapely.LineString(hole[0][:2]).length <= 2.0
    assert np.array_equal(hole[1], np.concatenate([pierce, pierce[:1]]))
