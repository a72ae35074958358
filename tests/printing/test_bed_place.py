"""Prints lie in the middle of their bed, and are turned only where that helps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.printing.bed_place import UNMOVED, BedPlace, place_on_bed

BED = (250.0, 210.0)
ROOM = (240.0, 200.0)


def box(width, depth, turn_deg=0.0):
    corners = np.array([[0, 0], [width, 0], [width, depth], [0, depth]], float)
    return BedPlace(turn_deg, (31.0, -7.0)).moved(corners)


def test_a_turn_is_counterclockwise_and_comes_before_the_shift():
    place = BedPlace(90.0, (10.0, 20.0))
    assert place.moved(np.array([[1.0, 0.0]])) == pytest.approx(np.array([[10.0, 21.0]]))
    assert UNMOVED.moved(np.array([[3.0, 4.0]])).tolist() == [[3.0, 4.0]]


@given(st.floats(1, 240), st.floats(1, 200), st.integers(-180, 180))
def test_what_fits_lies_within_the_room_with_equal_margins(width, depth, turn_deg):
    points = box(width, depth, float(turn_deg))
    place = place_on_bed(points, BED, ROOM)
    moved = place.moved(points)
    low, high = moved.min(axis=0), moved.max(axis=0)
    assert low + high == pytest.approx(BED)
    assert (high - low <= np.array(ROOM) + 1e-5).all()
    if (np.ptp(points, axis=0) <= ROOM).all():
        assert place.turn_deg == 0


@pytest.mark.parametrize("bed", [BED, BED[::-1]])
def test_what_fits_only_the_other_way_is_turned_by_a_right_angle(bed):
    room = tuple(side - 10 for side in bed)
    place = place_on_bed(box(room[1] - 1, room[0] - 1), bed, room)
    assert abs(place.turn_deg) == 90


def test_what_is_too_large_keeps_its_direction_in_the_middle():
    points = box(300.0, 20.0)
    place = place_on_bed(points, BED, ROOM)
    assert place.turn_deg == 0
    moved = place.moved(points)
    assert moved.min(axis=0) + moved.max(axis=0) == pytest.approx(BED)
