"""Holding bridges: the sheet stays in one part, each piece held as often and as wide as asked."""

import numpy as np
import pytest
import shapely
from flat_patterns import stars
from hypothesis import example, given
from hypothesis import strategies as st

from fab.drawings.beam import Beam
from fab.drawings.holding_bridges import bridged


def cleared(lines, kerf):
    """What a round beam takes away along lines."""
    return shapely.union_all([shapely.LineString(line).buffer(kerf / 2, 32) for line in lines])


def contacts(outline, made, kerf):
    """Widths of the material that is left along the outline of a piece, bridge by bridge."""
    left = shapely.LineString([*outline, outline[0]]).difference(cleared(made.chains, kerf))
    return [part.length for part in shapely.get_parts(shapely.line_merge(left))]


@given(st.integers(0, 10**6), st.integers(1, 6), st.floats(0.2, 2.0), st.floats(0.05, 0.4))
@example(257, 1, 1.0, 0.25)  # over the corner that the outline begins at
def test_a_piece_is_joined_to_the_sheet_by_the_stated_count_and_width(seed, count, width, kerf):
    (outline,) = stars(1, seed, 120.0)
    made = bridged([outline], count, width, Beam.of(kerf))
    assert made.counts == (count,)
    assert not made.outlines
    held = contacts(outline, made, kerf)
    assert held == pytest.approx([width] * count, abs=1e-6)
    sheet = shapely.Polygon(outline).buffer(20).difference(cleared(made.chains, kerf))
    assert len(shapely.get_parts(sheet)) == 1
    whole = shapely.Polygon(outline).buffer(20).difference(cleared([[*outline, outline[0]]], kerf))
    assert len(shapely.get_parts(whole)) == 2
    sides = np.roll(outline, -1, axis=0) - outline
    angle = np.unwrap(np.arctan2(*sides.T))
    bend = np.degrees(np.abs(np.diff(angle, prepend=np.arctan2(*sides[-1]))))
    corners = shapely.points(outline[(bend > 10.001) & (bend < 349.999)])
    ring = shapely.LinearRing(outline)
    for chain in made.chains:  # each begins and ends a gap: 1 mm and a gap from every corner
        for end in (chain[0], chain[-1]):
            free = shapely.distance(corners, shapely.Point(end)).min()
            assert free >= max(1.0, width + kerf) - 1e-6
    at = np.sort([ring.project(shapely.Point(chain[0])) for chain in made.chains])
    apart = np.diff(at, append=at[0] + ring.length)
    assert apart.min() >= ring.length / count / 2 - 1e-6


def test_bridges_are_on_the_long_sides_where_these_allow_it():
    strip = np.array([[0.0, 0], [100, 0], [100, 10], [0, 10]])
    made = bridged([strip], 4, 0.4, Beam.of(0.0))
    ends = np.array([chain[0] for chain in made.chains])
    assert sorted(ends[:, 1].tolist()) == [0, 0, 10, 10]
    assert sum(shapely.LineString(chain).length for chain in made.chains) == pytest.approx(218.4)


def test_small_pieces_get_fewer_and_the_smallest_none():
    def square(side):
        return side * np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])

    sizes = [3.0, 2.7, 2.3, 40.0]
    made = bridged([square(side) for side in sizes], 6, 0.5, Beam.of(0.0))
    assert made.counts == (4, 4, 0, 6)
    assert [np.ptp(outline[:, 0]) for outline in made.outlines] == [2.3]


def test_a_circle_and_an_outline_that_slits_reach_keep_their_bounds():
    angle = np.arange(240) * 2 * np.pi / 240
    circle = 20 * np.column_stack([np.cos(angle), np.sin(angle)])
    assert bridged([circle], 3, 0.4, Beam.of(0.1)).counts == (3,)
    square = np.array([[0.0, 0], [40, 0], [40, 40], [0, 40]])
    slits = np.array([[20.0, 0.0], [20, 10], [0, 20.0], [40, 20], [20, 40.05]])
    made = bridged([square], 4, 0.4, Beam.of(0.1), slits)
    assert made.counts == (4,)
    ends = [shapely.Point(p) for chain in made.chains for p in chain[[0, -1]]]
    assert min(end.distance(shapely.MultiPoint(slits[[0, 2, 3, 4]])) for end in ends) >= 1.0 - 0.06


def test_the_gap_is_that_of_the_beam_in_its_direction():
    square = np.array([[0.0, 0], [40, 0], [40, 40], [0, 40]])
    made = bridged([square], 4, 0.5, Beam(0.1, 0.3))
    for chain, after in zip(made.chains, [*made.chains[1:], made.chains[0]], strict=True):
        gap = after[0] - chain[-1]
        assert np.hypot(*gap) == pytest.approx(0.6 if abs(gap[0]) > abs(gap[1]) else 0.8)
