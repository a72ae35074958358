"""Centre lines of narrow regions: in their middle, from border to border, with their branches."""

import numpy as np
import pytest
import shapely
from hypothesis import example, given
from hypothesis import strategies as st

from fab.geometry.centre_lines import centre_lines


def length(lines):
    return sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in lines)


def band_of(seed, width, count):
    """A zigzag with bends of up to 80 degrees, and its band."""
    random = np.random.default_rng(seed)
    turn = np.cumsum(random.uniform(-0.7, 0.7, count))
    steps = random.uniform(4, 8, len(turn))[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    line = shapely.LineString(np.cumsum(np.vstack([[0.0, 0.0], steps]), axis=0))
    return line, line.buffer(width / 2, cap_style="flat", join_style="mitre"), width


@given(st.builds(band_of, st.integers(0, 2**32 - 1), st.floats(0.02, 1.0), st.integers(1, 6)))
@example(band_of(35, 0.02001225948333744, 6))  # so thin that it has no medial axis of its own
def test_the_centre_line_of_a_band_is_the_line_that_it_is_around(band):
    line, region, width = band
    lines = centre_lines(region, 2 * width)
    assert len(lines) == 1
    found = shapely.LineString(lines[0])
    assert shapely.hausdorff_distance(found, line) < 0.35 * width
    assert found.length == pytest.approx(line.length, abs=width * len(line.coords))
    assert region.buffer(1e-9).covers(found)


@pytest.mark.parametrize("thickness", [1e-5, 0.01, 0.1, 0.5])
def test_a_straight_slot_has_one_segment_from_end_to_end(thickness):
    (line,) = centre_lines(shapely.box(0, 0, 40, thickness), 0.2)
    assert np.sort(line, axis=0) == pytest.approx(
        np.array([[0, thickness / 2], [40, thickness / 2]]), abs=1e-9
    )


def test_branches_meet_and_short_ones_are_left_out():
    bar = shapely.box(0, 0, 20, 0.2)
    tee = bar.union(shapely.box(9.9, 0, 10.1, 8))
    lines = centre_lines(tee, 0.4)
    assert len(lines) == 3
    assert length(lines) == pytest.approx(20 + 8 - 0.1, abs=0.1)
    nick = bar.union(shapely.box(9.9, 0, 10.1, 0.35))
    assert len(centre_lines(nick, 1.0)) == 1


def test_a_ring_is_closed():
    ring = shapely.Point(0, 0).buffer(5, quad_segs=64) - shapely.Point(0, 0).buffer(4.8, 64)
    (line,) = centre_lines(ring, 0.4)
    assert line[0] == pytest.approx(line[-1])
    assert length([line]) == pytest.approx(2 * np.pi * 4.9, rel=0.02)


@given(st.integers(0, 2**32 - 1), st.integers(3, 9), st.floats(1e-4, 1e3))
def test_there_is_always_a_line(seed, count, size):
    random = np.random.default_rng(seed)
    turn = np.sort(random.uniform(0, 2 * np.pi, count))
    hull = shapely.MultiPoint(np.column_stack([np.cos(turn), np.sin(turn)]) * size).convex_hull
    if hull.geom_type == "Polygon" and hull.area > 1e-6 * size**2:
        lines = centre_lines(hull, 0.1 * size)
        assert lines
        assert 0 < length(lines) < 10 * size


def test_points_of_the_axis_in_one_place_are_one():
    """Around four points of a circle the diagram has two vertices: a line between them has none."""
    corners = [
        (58.768774264835145, 39.486054608815905),
        (58.79094762903463, 39.52659520496174),
        (58.814970133081744, 39.48712221020469),
    ]
    generator = np.random.default_rng(1)
    for points in (corners, *generator.uniform(0, 0.05, (60, 3, 2))):
        region = shapely.Polygon(points)
        lines = centre_lines(region, 0.15)
        assert lines
        for line in lines:
            assert np.isfinite(line).all()
            assert np.hypot(*np.diff(line, axis=0).T).sum() > 0
