"""Closed slots: nothing open is left, slots are as long and wide as asked, and pieces keep area."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fab.drawings.beam import Beam
from fab.drawings.closed_slots import SLOT_REACH, closed_slots, dash_slots, slot_beside
from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.drawings.holding_bridges import bridged
from fab.geometry.rings import is_hole
from solver import InvalidValue

SQUARE = np.array([[0.0, 0], [100, 0], [100, 100], [0, 100]])
HOLE = np.array([[40.0, 40], [40, 60], [60, 60], [60, 40]])


def closed(*layers, slot=0.5, kerf=0.1):
    paths = CutPaths(closed_slots(layers, slot, Beam.of(kerf)), (100.0, 100.0))
    made = dash_slots(paths, slot, Beam.of(kerf)).layers
    assert not any(len(layer.segments) or layer.chains for layer in made)
    return {layer.operation: layer.outlines for layer in made}


def area(rings):
    return sum(shapely.Polygon(ring).area for ring in rings)


@given(st.lists(st.tuples(*[st.floats(1, 90)] * 4), min_size=1, max_size=8), st.floats(0.2, 3.0))
def test_dashes_are_rectangles_of_their_length_and_the_width_asked_for(ends, slot):
    dashes = np.array(ends).reshape(-1, 2, 2)
    dashes[:, 1] += [0.0, 100.0]
    made = closed(Layer(Operation.MOUNTAIN, dashes), slot=slot)[Operation.MOUNTAIN]
    for ring, (a, b) in zip(made, dashes, strict=True):
        length = np.hypot(*(b - a))
        assert is_hole(ring)
        assert area([ring]) == pytest.approx(length * (slot - 0.1))
        assert shapely.Polygon(ring).buffer(1e-9).covers(shapely.LineString([a, b]))


def test_slits_within_a_piece_are_holes_and_bent_ones_are_one():
    bent = np.array([[10.0, 10], [10, 30], [30, 30]])
    cross = np.array([[[70.0, 10], [70, 30]], [[60, 20], [80, 20]]])
    made = closed(Layer(Operation.CUT, cross, (SQUARE,), (bent,)))
    (around,), slots = made[Operation.CUT], made[Operation.HOLE]
    assert np.array_equal(around, SQUARE)
    assert len(slots) == 2
    assert all(map(is_hole, slots))
    assert area(slots) == pytest.approx(40 * 0.4 + 40 * 0.4 - 0.4**2)


def test_slits_that_reach_outlines_or_holes_are_part_of_them():
    lines = np.array([[[50.0, 0], [50, 20]], [[60, 50], [80, 50]]])
    made = closed(Layer(Operation.HOLE, outlines=(HOLE,)), Layer(Operation.CUT, lines, (SQUARE,)))
    (around,), (hole,) = made[Operation.CUT], made[Operation.HOLE]
    assert not is_hole(around)
    assert is_hole(hole)
    assert area([around]) == pytest.approx(100**2 - 20 * 0.4)
    assert area([hole]) == pytest.approx(20**2 + 20 * 0.4)
    through = np.array([[[60.0, 50], [100, 50]]])  # from the hole to the outline
    made = closed(Layer(Operation.HOLE, outlines=(HOLE,)), Layer(Operation.CUT, through, (SQUARE,)))
    assert set(made) == {Operation.CUT}
    assert area(made[Operation.CUT]) == pytest.approx(100**2 - 20**2 - 40 * 0.4)


def test_a_slot_beside_a_cut_takes_nothing_of_the_piece():
    arc = np.array([[20.0, 0], [100, 0], [100, 60]])  # material on the left
    ring = slot_beside(arc, SQUARE, 0.5, Beam.of(0.1))
    slot = shapely.Polygon(ring)
    assert slot.intersection(shapely.Polygon(SQUARE)).area < 1e-9
    assert slot.boundary.intersection(shapely.LineString(arc)).length == pytest.approx(140.0)
    assert slot.area == pytest.approx(140 * 0.4 + 0.4**2)
    assert is_hole(ring)


@settings(max_examples=25)
@given(
    st.lists(st.tuples(st.floats(5, 40), st.floats(0.2, 1)), min_size=3, max_size=12),
    st.floats(0.3, 6),
)
def test_slots_beside_any_outline_follow_it_and_take_nothing_of_the_piece(spokes, slot):
    """Stars: sharp notches, and some narrower than the slot."""
    radius, step = np.array(spokes).T
    angle = 2 * np.pi * np.cumsum(step) / step.sum()
    ring = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    piece = shapely.Polygon(ring)
    assume(piece.is_valid and not is_hole(ring))
    made = bridged([ring], 3, 0.4, Beam.of(0.1), clear_mm=SLOT_REACH * slot)
    assert len(made.chains) == sum(made.counts)
    for chain in made.chains:
        beside = shapely.Polygon(slot_beside(chain, ring, slot, Beam.of(0.1)))
        assert beside.intersection(piece).area < 1e-6
        line = shapely.LineString(chain)
        left_out = line.difference(beside.exterior.buffer(1e-6)).length
        assert left_out == pytest.approx(0.0, abs=1e-4)
        assert beside.hausdorff_distance(line) <= SLOT_REACH * slot


def test_bridges_lead_across_what_is_cut_away():
    """A slit of 1 mm in a plate, beside slots of 2 mm that fill it."""
    plate = np.array([[0.0, 0], [49.5, 0], [49.5, 40], [50.5, 40], [50.5, 0], [100, 0]])
    ring = np.concatenate([plate, [[100.0, 60], [0, 60]]])
    for clear in (0.0, 2.0):
        made = bridged([ring], 8, 0.4, Beam.of(0.1), clear_mm=clear)
        ends = np.concatenate([chain[[0, -1]] for chain in made.chains])
        inside = (np.abs(ends[:, 0] - 50) < 0.6) & (ends[:, 1] < 40)
        assert made.counts[0] > 3
        assert inside.any() == (clear == 0)


def test_slots_narrower_than_the_kerf_are_refused_and_marks_stay():
    mark = Layer(Operation.ENGRAVE, np.array([[[1.0, 1], [2, 5]]]))
    (kept,) = closed_slots([mark], 0.5, Beam.of(0.1))
    assert np.array_equal(kept.segments, mark.segments)
    with pytest.raises(InvalidValue, match=r"slot_mm = 0\.1 is out of bounds.*0\.1 x 0\.2 mm"):
        closed_slots([mark], 0.1, Beam(0.1, 0.2))
