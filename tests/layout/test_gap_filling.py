"""Gaps: what is placed lies in the room and apart; what fits with a little to spare is placed."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.layout.gap_filling import Gaps
from fab.layout.nesting import nest

ROOM = np.array([120.0, 80.0])
CELL = 120.0 / 512


def turned(shape):
    return [shapely.affinity.rotate(shape, 90 * turn, (0, 0)) for turn in range(4)]


def blob(random, reach):
    angle = np.sort(random.uniform(0, 2 * np.pi, 9))
    radius = reach * random.uniform(0.3, 1, 9)
    return shapely.MultiPoint(
        radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    ).convex_hull


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.floats(0.01, 20))
def test_what_is_placed_lies_apart_and_inside(seed, gap):
    random = np.random.default_rng(seed)
    first = shapely.affinity.translate(blob(random, 25), *random.uniform(25, 55, 2))
    gaps = Gaps([first], ROOM, gap)
    lying = [first]
    for _ in range(12):
        shape = blob(random, random.uniform(3, 20))
        found = gaps.place(turned(shape))
        if found is not None:
            turn, shift = found
            lying.append(shapely.affinity.translate(turned(shape)[turn], *shift))
    assert len(lying) > 1 or gap > 5
    for i, shape in enumerate(lying):
        assert shapely.box(-1e-9, -1e-9, *(ROOM + 1e-9)).covers(shape)
        assert all(shape.distance(other) >= gap for other in lying[:i])


@pytest.mark.parametrize(("spare", "fits"), [(4 * CELL, True), (-0.01, False)])
def test_a_strip_fits_into_a_slot_in_the_turn_that_it_has_there(spare, fits):
    """A slot 10 mm wide between two bars, all over the height of the room."""
    bars = [shapely.box(0, 0, 50, 80), shapely.box(60, 0, 120, 80)]
    gaps = Gaps(bars, ROOM, 2.0)
    strip = shapely.box(0, 0, 60, 6.0 - spare)
    found = gaps.place(turned(strip))
    assert (found is not None) == fits
    if fits:
        placed = shapely.affinity.translate(turned(strip)[found[0]], *found[1])
        assert found[0] in (1, 3)
        assert placed.bounds[1] == pytest.approx(0)
        assert shapely.distance(placed, bars).min() >= 2.0
        assert gaps.place(turned(shapely.box(0, 0, 30, 3))) is None


def test_small_pieces_lie_in_the_notches_of_large_ones():
    """Frames without their middle: the last sheet's small pieces lie in the notches."""
    frame = shapely.Polygon(
        [(0, 0), (190, 0), (190, 190), (130, 190), (130, 60), (60, 60), (60, 190), (0, 190)]
    )
    small = shapely.box(0, 0, 60, 60)
    placements = nest([frame, frame, small, small, small, small], (200.0, 200.0), 2.0, margin_mm=5)
    assert len(placements.used) == 2
    assert sorted(item.sheet for item in placements.items if item.piece > 1) == [0, 0, 1, 1]
