"""Order of cutting: nothing lost, nothing freed too early, never longer, time exact."""

from itertools import permutations, product

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.sheets.cutting_order import tour
from fab.sheets.materials import Speeds
from fab.sheets.tours import Tour, nearest_neighbours, travel_mm
from fab.sheets.work_estimate import Estimate, estimate

SPEEDS = Speeds(cut_mm_s=10, perforate_mm_s=20, engrave_mm_s=50, travel_mm_s=100, pierce_s=0.5)
ORIGIN = np.zeros(2)


def random_segments(count, seed, size=100.0):
    rng = np.random.default_rng(seed)
    begin = rng.uniform(0, size, (count, 2))
    return np.stack([begin, begin + rng.normal(0, 2, (count, 2))], axis=1)


def ring(x, y, radius, corners=7):
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.array([x, y]) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def sheet(*layers):
    return CutPaths(layers, (100.0, 100.0))


def undirected(segments):
    return sorted(tuple(sorted(map(tuple, line))) for line in segments.tolist())


def from_least(outline):
    """The outline from its least vertex on, in its own sense of rotation."""
    first = min(range(len(outline)), key=lambda i: tuple(outline[i]))
    return tuple(map(tuple, np.roll(outline, -first, axis=0).tolist()))


def stops(layer):
    """Begin and end of each of a layer's lines, as the head passes them."""
    loops = np.array([o[[0, 0]] for o in layer.outlines]).reshape(-1, 2, 2)
    return np.concatenate([layer.segments, loops])


segment_counts = st.integers(0, 60)
seeds = st.integers(0, 2**32 - 1)


@given(segment_counts, segment_counts, seeds)
def test_lines_are_kept_and_no_tour_is_longer(dashes, rings, seed):
    rng = np.random.default_rng(seed)
    outlines = tuple(ring(*rng.uniform(0, 100, 2), 0.5, rng.integers(3, 9)) for _ in range(rings))
    paths = sheet(Layer(Operation.VALLEY, random_segments(dashes, seed), outlines))
    toured = tour(paths)
    before, after = paths.layers[0], toured.layers[0]
    assert toured.size_mm == paths.size_mm
    assert undirected(after.segments) == undirected(before.segments)
    assert sorted(map(from_least, after.outlines)) == sorted(map(from_least, outlines))
    assert travel_mm(after.segments, ORIGIN) <= travel_mm(before.segments, ORIGIN) + 1e-9
    if dashes:
        ends, number = before.segments.reshape(-1, 2), np.arange(2 * dashes)
        entries = nearest_neighbours(ends, number // 2, number ^ 1, ORIGIN)
        alone = np.stack([ends[entries], ends[entries ^ 1]], axis=1)
        assert travel_mm(after.segments, ORIGIN) <= travel_mm(alone, ORIGIN) + 1e-9
    if rings and not dashes:
        assert travel_mm(stops(after), ORIGIN) <= travel_mm(stops(before), ORIGIN) + 1e-9


@given(st.integers(2, 80), seeds)
def test_nearest_neighbours_are_the_nearest(count, seed):
    segments = random_segments(count, seed)
    ends, number = segments.reshape(-1, 2), np.arange(2 * count)
    entries = nearest_neighbours(ends, number // 2, number ^ 1, ORIGIN)
    head, left = ORIGIN, set(range(count))
    for entry in entries.tolist():
        far = {end: np.hypot(*(ends[end] - head)) for end in number.tolist() if end // 2 in left}
        assert far[entry] <= min(far.values()) + 1e-12
        left.remove(entry // 2)
        head = ends[entry ^ 1]


@given(st.integers(2, 40), seeds)
def test_every_move_shortens_the_tour_and_keeps_its_lines(count, seed):
    ends = random_segments(count, seed, size=20.0).reshape(-1, 2)
    at = Tour(ends, 2 * np.random.default_rng(seed).permutation(count), ORIGIN)

    def length():
        return travel_mm(np.stack([ends[at.entries], ends[at.entries ^ 1]], axis=1), ORIGIN)

    before = length()
    for end in range(2 * count):
        moved = at.move(end)
        assert length() < before - 5e-10 if moved else length() == before
        before = length()
        assert sorted(at.entries >> 1) == list(range(count))
        assert (at.places[at.entries >> 1] == np.arange(count)).all()


def test_the_shortest_tour_of_a_row_of_dashes_is_found():
    row = np.array([[[4.0 * i, 0.0], [4.0 * i + 3, 0.0]] for i in range(300)])
    mixed = row[np.random.default_rng(1).permutation(300)]
    mixed[::3] = mixed[::3, ::-1]
    toured = tour(sheet(Layer(Operation.MOUNTAIN, mixed))).layers[0].segments
    np.testing.assert_array_equal(toured, row)


def test_outlines_start_where_the_tour_is_shortest():
    square = np.array([[9.0, 1], [9, 9], [1, 9], [1, 1]])
    squares = tuple(square + shift for shift in ([40.0, 0], [0.0, 0], [20.0, 0]))
    toured = tour(sheet(Layer(Operation.RELIEF, outlines=squares)))
    lengths = [
        np.hypot(*np.diff([ORIGIN, *corners], axis=0).T).sum()
        for order in permutations(squares)
        for corners in product(*order)
    ]
    assert estimate(toured, SPEEDS).travel_mm == pytest.approx(min(lengths), rel=1e-12)


@st.composite
def nested_rings(draw):
    """Concentric rings around several centres, some of them within a frame, in any order."""
    centres = draw(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), unique=True))
    rings = [
        ring(10.0 * x, 10.0 * y, radius, draw(st.integers(3, 9)))
        for x, y in centres
        for radius in np.cumprod(np.full(draw(st.integers(1, 4)), 0.45)) * 10
    ]
    if draw(st.booleans()):
        rings.append(ring(45.0, 45.0, 500.0, 12))
    return draw(st.permutations(rings))


@given(nested_rings(), st.integers(0, 5))
def test_cuts_go_inside_out(rings, dashes):
    paths = sheet(Layer(Operation.CUT, random_segments(dashes, 1), tuple(rings)))
    toured = tour(paths).layers[0]
    shapes = [shapely.Polygon(outline) for outline in toured.outlines]
    for i, first in enumerate(shapes):
        assert not any(first.contains(later) for later in shapes[i + 1 :])
    depth = [
        sum(other.contains(shape) for other in shapes if other is not shape) for shape in shapes
    ]
    assert depth == sorted(depth, reverse=True)
    assert sorted(map(from_least, toured.outlines)) == sorted(map(from_least, rings))


def test_rings_are_cut_inside_out_even_where_the_tour_is_longer():
    around, inner = ring(50.0, 50.0, 49.0, 30), ring(50.0, 50.0, 1.0)
    toured = tour(sheet(Layer(Operation.CUT, outlines=(around, inner)))).layers[0]
    assert [len(outline) for outline in toured.outlines] == [7, 30]
    free = tour(sheet(Layer(Operation.RELIEF, outlines=(around, inner)))).layers[0]
    assert [len(outline) for outline in free.outlines] == [30, 7]


def test_a_hole_that_touches_its_outline_is_cut_first():
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    wedge = np.array([[0.0, 0], [4, 2], [2, 4]])
    toured = tour(sheet(Layer(Operation.CUT, outlines=(square, wedge)))).layers[0]
    assert [len(outline) for outline in toured.outlines] == [3, 4]


def test_operations_are_in_the_order_of_the_work():
    segments = random_segments(5, 3)
    layers = [Layer(operation, segments) for operation in reversed(Operation)]
    assert [layer.operation for layer in tour(sheet(*layers)).layers] == list(Operation)


def test_empty_layers_stay():
    paths = sheet(Layer(Operation.MOUNTAIN), Layer(Operation.CUT))
    toured = tour(paths)
    assert [layer.operation for layer in toured.layers] == [Operation.MOUNTAIN, Operation.CUT]
    assert estimate(toured, SPEEDS) == Estimate(0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert estimate(tour(sheet()), SPEEDS) == Estimate(0, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_estimate_is_exact():
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    paths = sheet(
        Layer(Operation.ENGRAVE, np.array([[[3.0, 4], [3, 9]]])),  # travel 5, 5 long
        Layer(Operation.MOUNTAIN, np.array([[[3.0, 9], [6, 13]]])),  # travel 0, 5 long
        Layer(Operation.VALLEY, np.array([[[6.0, 13], [6, 23]]])),  # travel 0, 10 long
        Layer(Operation.RELIEF, outlines=(square + np.array([6.0, 23.0]),)),  # travel 0, 40 long
        Layer(Operation.CUT, np.array([[[6.0, 20], [6, 0]]]), (square,)),  # travel 3 and 6
    )
    assert estimate(paths, SPEEDS) == Estimate(
        pierces=5,
        cut_mm=100.0,
        perforate_mm=15.0,
        engrave_mm=5.0,
        travel_mm=14.0,
        minutes=pytest.approx((100 / 10 + 15 / 20 + 5 / 50 + 14 / 100 + 5 * 0.5) / 60, rel=1e-15),
    )


def test_the_same_sheet_gives_the_same_tour():
    outlines = tuple(
        ring(*center, 1.0) for center in np.random.default_rng(2).uniform(0, 99, (40, 2))
    )
    paths = sheet(Layer(Operation.CUT, random_segments(500, 7), outlines))
    first, second = tour(paths).layers[0], tour(paths).layers[0]
    assert first.segments.tobytes() == second.segments.tobytes()
    assert np.concatenate(first.outlines).tobytes() == np.concatenate(second.outlines).tobytes()


def test_lines_that_lie_on_each_other_are_all_kept():
    same = np.repeat(random_segments(1, 0), 200, axis=0)
    point = np.zeros((50, 2, 2)) + 3.0
    segments = np.concatenate([same, point])
    toured = tour(sheet(Layer(Operation.VALLEY, segments))).layers[0].segments
    assert undirected(toured) == undirected(segments)


def test_speeds_must_be_positive():
    with pytest.raises(ValueError, match="travel_mm_s"):
        Speeds(cut_mm_s=1.0, perforate_mm_s=1.0, engrave_mm_s=1.0, travel_mm_s=0.0)


def test_holes_are_cut_before_outlines_but_after_a_piece_in_them():
    def ring(a, b):
        return np.array([[a, a], [b, a], [b, b], [a, b]], float)

    empty, full = ring(10, 20)[::-1], ring(50, 80)[::-1]
    layers = (
        Layer(Operation.HOLE, outlines=(empty, full)),
        Layer(Operation.CUT, outlines=(ring(0, 100), ring(60, 70))),
    )
    hole, cut = tour(sheet(*layers)).layers
    assert hole.operation is Operation.HOLE
    assert [np.ptp(outline[:, 0]) for outline in hole.outlines] == [10]
    assert [np.ptp(outline[:, 0]) for outline in cut.outlines] == [10, 30, 100]
    only = tour(sheet(Layer(Operation.HOLE, outlines=(full,)), layers[1]))
    assert [layer.operation for layer in only.layers] == [Operation.CUT]


def test_chains_are_followed_whole_from_their_nearer_end():
    bend = np.array([[40.0, 0], [40, 30], [10, 30]])
    other = np.array([[5.0, 5], [20, 5], [39, 2]])
    layer = Layer(Operation.CUT, np.array([[[4.0, 0], [1, 0]]]), chains=(bend, other))
    (toured,) = tour(sheet(layer)).layers
    assert [chain.tolist() for chain in toured.chains] == [other.tolist(), bend.tolist()]
    work = estimate(sheet(toured), SPEEDS)
    assert work.pierces == 3
    length = 3 + 60 + sum(np.hypot(*np.diff(other, axis=0).T))
    assert work.cut_mm == pytest.approx(length)
