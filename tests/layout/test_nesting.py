"""Nesting: every copy once, inside the bed, the gap kept; what does not fit is refused."""

import numpy as np
import pytest
import shapely
from flat_patterns import stars
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.drawings.cut_paths import Layer, Operation
from fab.layout import bed_filling
from fab.layout.nesting import Placements, nest
from fab.pattern.development import develop
from fab.sheets.sheet_drawings import sheets
from solver import CurvedFold, Miura
from solver.errors import InvalidValue

BED = (300.0, 200.0)
ANGLE = shapely.Polygon([(0, 0), (60, 0), (60, 20), (20, 20), (20, 80), (0, 80)])


def lying(outlines, placements):
    """The pieces of each sheet, where they lie."""
    out = [[] for _ in placements.used]
    for item in placements.items:
        piece = shapely.Polygon(outlines[item.piece])
        out[item.sheet].append(
            shapely.transform(piece, lambda p, item=item: p @ item.turn.T + item.shift)
        )
    return out


def check(outlines, placements, bed, gap, copies, margin):
    """Every promise of `nest` that holds for all pieces; returns the pieces of each sheet."""
    placed = [(item.piece, item.copy) for item in placements.items]
    assert sorted(placed) == [(i, k) for i in range(len(outlines)) for k in range(copies)]
    order = [(item.sheet, item.piece, item.copy) for item in placements.items]
    assert order == sorted(order)
    for item in placements.items:
        np.testing.assert_allclose(item.turn @ item.turn.T, np.eye(2), atol=1e-15)
        assert np.linalg.det(item.turn) == pytest.approx(1, abs=1e-15)
        assert not item.turn.flags.writeable
        assert not item.shift.flags.writeable
    on_sheets = lying(outlines, placements)
    room = shapely.box(margin, margin, bed[0] - margin, bed[1] - margin).buffer(1e-8)
    for shapes in on_sheets:
        assert shapes
        for i, shape in enumerate(shapes):
            assert room.contains(shape)
            assert all(shape.distance(other) >= gap - 1e-8 for other in shapes[i + 1 :])
        low = shapely.total_bounds(np.array(shapes))[:2]
        np.testing.assert_allclose(low, margin, atol=1e-9)
    used = [sum(shape.area for shape in shapes) / (bed[0] * bed[1]) for shapes in on_sheets]
    np.testing.assert_allclose(placements.used, used, rtol=1e-12)
    assert (np.diff(placements.used) <= 1e-12).all()
    return on_sheets


@settings(max_examples=12)
@given(
    st.integers(1, 5),
    st.integers(1, 3),
    st.floats(0.01, 10),
    st.floats(0, 20),
    st.integers(0, 2**32 - 1),
)
def test_all_copies_lie_apart_and_inside(count, copies, gap, margin, seed):
    outlines = stars(count, seed)
    placements = nest(outlines, BED, gap, copies, margin)
    check(outlines, placements, BED, gap, copies, margin)


@settings(max_examples=10)
@given(
    st.lists(st.sampled_from([0.0, 30.0, 90.0, 143.0, 180.0, 270.0]), min_size=1, max_size=3),
    st.integers(1, 4),
    st.integers(0, 2**32 - 1),
)
def test_pieces_are_turned_only_as_their_grain_allows(rotations, count, seed):
    outlines = stars(count, seed)
    placements = nest(outlines, BED, 1.0, 2, rotations_deg=rotations)
    check(outlines, placements, BED, 1.0, 2, 0.0)
    for item in placements.items:
        turn = np.degrees(np.arctan2(item.turn[1, 0], item.turn[0, 0])) % 360
        assert np.isclose(turn, rotations, atol=1e-9).any()


def test_a_piece_that_may_not_turn_must_fit_as_it_lies():
    upright = shapely.box(0, 0, 30, 190)
    with pytest.raises(InvalidValue, match=r"30 x 190 mm .* 200 x 40 mm, as it may be turned"):
        nest([upright], (200.0, 40.0), 1.0, rotations_deg=[0.0, 180.0])
    assert len(nest([upright], (200.0, 40.0), 1.0, rotations_deg=[0.0, 90.0]).items) == 1


def pieces_of(mesh, parts):
    """A development cut apart by its faces' place along x; no piece is longer than 180 mm."""
    flat = develop(mesh).vertices_coords
    faces = flat[mesh.faces_vertices]
    middle = faces.mean(axis=1)[:, 0]
    bounds = np.quantile(middle, np.linspace(0, 1, parts + 1)[1:-1])
    part = np.searchsorted(bounds, middle)
    glue = 1e-6 * np.ptp(flat[:, 0])
    joined = [
        shapely.union_all(shapely.buffer(shapely.polygons(faces[part == i]), glue))
        for i in range(parts)
    ]
    largest = [max(shapely.get_parts(shape), key=shapely.area) for shape in joined]
    reach = max(shapely.minimum_bounding_radius(shape) for shape in largest)
    return [shapely.affinity.scale(shape, *[90 / reach] * 2, origin=(0, 0)) for shape in largest]


@pytest.mark.parametrize(
    ("outlines", "copies", "at_least"),
    [
        (pieces_of(Miura(columns=20, rows=12, fold=1.0).grow().mesh, 6), 3, 0.5),
        (pieces_of(CurvedFold(columns=40, step=0.05).grow().mesh, 5), 2, 0.33),
        (stars(20, 1), 2, 0.45),
        ([ANGLE], 25, 0.45),
    ],
    ids=["miura", "curved-fold", "stars", "angles"],
)
def test_full_sheets_are_used_well(outlines, copies, at_least):
    placements = nest(outlines, BED, 2.0, copies, 5.0)
    check(outlines, placements, BED, 2.0, copies, 5.0)
    assert len(placements.used) > 1
    assert placements.used[:-1].min() > at_least


def test_angles_lie_in_each_other():
    """Two of them fit a sheet in which their boxes do not."""
    placements = nest([ANGLE], (64.0, 124.0), 1.0, copies=2)
    assert len(placements.used) == 1
    (shapes,) = check([ANGLE], placements, (64.0, 124.0), 1.0, 2, 0.0)
    assert shapely.box(*shapes[0].bounds).intersects(shapely.box(*shapes[1].bounds))


def test_a_piece_turns_where_it_fits_only_so():
    upright = shapely.box(0, 0, 30, 190)
    placements = nest([upright], (200.0, 40.0), 1.0, margin_mm=5.0)
    check([upright], placements, (200.0, 40.0), 1.0, 1, 5.0)
    assert np.abs(placements.items[0].turn).tolist() == [[0, 1], [1, 0]]
    # a slanted strip fits only along the axes, a diagonal one only without a turn
    slanted = shapely.affinity.rotate(upright, 37.0)
    check([slanted], nest([slanted], (191.0, 31.0), 1.0), (191.0, 31.0), 1.0, 1, 0.0)
    strip = shapely.affinity.rotate(shapely.box(0, 0, 4, 190), 45.0)
    check([strip], nest([strip], (140.0, 140.0), 1.0), (140.0, 140.0), 1.0, 1, 0.0)


def test_a_piece_as_large_as_the_bed_takes_a_sheet():
    outlines = [shapely.box(-7, 3, 283, 193), shapely.box(0, 0, 10, 10)]
    placements = nest(outlines, BED, 2.0, copies=2, margin_mm=5.0)
    check(outlines, placements, BED, 2.0, 2, 5.0)
    assert len(placements.used) == 3


def test_a_piece_with_many_corners_keeps_its_gap():
    angle = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    wavy = (40 + 3 * np.cos(15 * angle))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    check([wavy], nest([wavy], BED, 0.5, 5), BED, 0.5, 5, 0.0)


def test_many_pieces_are_placed_in_batches_that_can_be_interrupted(monkeypatch):
    monkeypatch.setattr(bed_filling, "_BATCH_CORNERS", 160)
    outlines = stars(90, 5, 40.0)
    seen = []
    placements = nest(outlines, BED, 2.0, margin_mm=5.0, progress=lambda *steps: seen.append(steps))
    check(outlines, placements, BED, 2.0, 1, 5.0)
    assert placements.used[:-1].min() > 0.5
    assert [placed for placed, _ in seen] == sorted({placed for placed, _ in seen})
    assert {total for _, total in seen} == {90}
    assert seen[-1] == (90, 90)
    assert len(seen) > len(placements.used)

    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nest(outlines, BED, 2.0, progress=stop)


@settings(max_examples=6)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 10), st.floats(0, 20), st.integers(40, 100))
def test_batches_lie_apart_and_inside(seed, gap, margin, corners):
    """Small batches, so that there are many."""
    outlines = [*stars(14, seed, 70.0), *stars(6, seed, 20.0)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bed_filling, "_BATCH_CORNERS", corners)
        placements = nest(outlines, BED, gap, 2, margin)
    check(outlines, placements, BED, gap, 2, margin)


def test_copies_of_full_sheets_cost_nothing(monkeypatch):
    right, calls = bed_filling._fill, []

    def counted(*arguments):
        calls.append(arguments)
        return right(*arguments)

    monkeypatch.setattr(bed_filling, "_fill", counted)
    placements = nest([ANGLE], BED, 2.0, 300)
    check([ANGLE], placements, BED, 2.0, 300, 0.0)
    assert len(placements.used) >= 25
    assert len(calls) <= 5


def test_what_is_left_lies_in_a_hole():
    frame = shapely.box(0, 0, 280, 180).difference(shapely.box(30, 30, 250, 150))
    outlines = [frame, shapely.box(0, 0, 50, 40)]
    placements = nest(outlines, BED, 2.0)
    (shapes,) = check(outlines, placements, BED, 2.0, 1, 0.0)
    assert shapely.Polygon(shapes[0].exterior).contains(shapes[1])
    # each of two frames takes one
    placements = nest(outlines, BED, 2.0, 2)
    check(outlines, placements, BED, 2.0, 2, 0.0)
    assert len(placements.used) == 2
    # a plate as large as the hole does not keep the gap in it
    plate = [frame, shapely.box(0, 0, 220, 120)]
    assert len(nest(plate, BED, 2.0).used) == 2


@settings(max_examples=12)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 5), st.floats(0, 10), st.integers(1, 4))
def test_pieces_in_holes_keep_their_gaps(seed, gap, margin, count):
    """Frames with holes of any form, stars, and frames within frames."""
    random = np.random.default_rng(seed)
    small = [shapely.Polygon(ring) for ring in stars(count, seed)]
    outer = shapely.box(0, 0, 250, 150)
    hole = shapely.Polygon(stars(1, seed)[0])
    hole = shapely.affinity.scale(hole, 1.5, 1.5, origin=hole.centroid)
    hole = shapely.affinity.translate(hole, 125 - hole.centroid.x, 75 - hole.centroid.y)
    frame = outer - hole.intersection(outer.buffer(-2))
    ring = shapely.box(0, 0, 60, 50) - shapely.box(8, 8, 8 + random.uniform(5, 44), 40)
    if frame.geom_type != "Polygon":
        return
    outlines = [frame, ring, shapely.box(0, 0, 6, 9), *small]
    placements = nest(outlines, BED, gap, 1, margin)
    check(outlines, placements, BED, gap, 1, margin)


def test_the_same_pieces_give_the_same_bytes():
    first, second = (nest(stars(12, 4), BED, 2.0, 2, 5.0) for _ in range(2))
    assert [(a.piece, a.copy, a.sheet) for a in first.items] == [
        (b.piece, b.copy, b.sheet) for b in second.items
    ]
    assert all(
        a.turn.tobytes() == b.turn.tobytes() and a.shift.tobytes() == b.shift.tobytes()
        for a, b in zip(first.items, second.items, strict=True)
    )


@pytest.mark.parametrize("answer", ["none", "overlapping", "outside"])
def test_wrong_answers_of_the_library_are_discarded(monkeypatch, answer):
    """Boxes take their place; where boxes are wrong as well, one piece alone."""
    right, calls = bed_filling._solve, []

    def wrong(wanted, offered, strategy, room, gap_mm):
        calls.append(strategy)
        found = right(wanted, offered, strategy, room, gap_mm)
        if strategy == "blf" and answer != "outside":
            return found
        if answer == "none":
            return []
        if answer == "overlapping":
            return [(n, turn, np.zeros(2)) for n, turn, _ in found]
        return [(n, turn, 10.0 * shift) for n, turn, shift in found]

    monkeypatch.setattr(bed_filling, "_solve", wrong)
    monkeypatch.setattr(bed_filling, "_between", lambda *_: [])
    outlines = stars(5, 2)
    placements = nest(outlines, BED, 2.0, 2, 5.0)
    check(outlines, placements, BED, 2.0, 2, 5.0)
    assert {"nfp", "blf"} <= set(calls)
    assert (len(placements.used) == 10) == (answer == "outside")


@pytest.mark.parametrize(
    ("outlines", "changes", "message"),
    [
        ([ANGLE, shapely.box(0, 0, 310, 10)], {}, r"size of piece 1 = 310 x 10 mm .* 300 x 200 mm"),
        ([shapely.box(0, 0, 300, 10)], {"margin_mm": 0.01}, "larger bed"),
        (
            [np.array([[0, 0], [9, 9], [9, 0], [0, 9.0]])],
            {},
            r"outline 0 has .*: Self-intersection",
        ),
        ([np.array([[0, 0], [9, 9], [0, 0.0]])], {}, "outline 0 has "),
        ([np.empty((0, 2))], {}, "outline 0 has .*: no area"),
        ([ANGLE], {"rotations_deg": []}, r"rotations_deg = \[\]"),
        ([ANGLE], {"rotations_deg": [float("nan")]}, r"rotations_deg = \[nan\]"),
        ([ANGLE], {"gap_mm": 0.0}, "gap_mm = 0.0"),
        ([ANGLE], {"gap_mm": float("nan")}, "gap_mm = nan"),
        ([ANGLE], {"copies": 0}, "copies = 0"),
        ([ANGLE], {"margin_mm": -1.0}, "margin_mm = -1.0"),
        ([ANGLE], {"margin_mm": 100.0}, "margin_mm = 100.0"),
        ([ANGLE], {"bed_mm": (300.0, 0.0)}, "bed_mm = 0.0"),
    ],
)
def test_bad_input_is_refused(outlines, changes, message):
    with pytest.raises(InvalidValue, match=message):
        nest(outlines, **({"bed_mm": BED, "gap_mm": 1.0} | changes))


def test_nothing_takes_no_sheet():
    placements = nest([], BED, 1.0)
    assert placements.items == ()
    assert len(placements.used) == 0
    assert sheets([], placements, BED) == []


def test_sheets_hold_all_layers_of_their_pieces():
    outlines = [
        np.array([[0.0, 0], [120, 0], [120, 90], [0, 90]]),
        np.array([[5.0, 5], [95, 5], [50, 80]]),
    ]
    fold = np.array([[[10.0, 10.0], [40.0, 30.0]]])
    pieces = [
        [Layer(Operation.CUT, outlines=(outlines[0],)), Layer(Operation.MOUNTAIN, fold)],
        [Layer(Operation.VALLEY, fold), Layer(Operation.CUT, outlines=(outlines[1],))],
    ]
    placements = nest(outlines, BED, 2.0, copies=4, margin_mm=5.0)
    made = sheets(pieces, placements, BED)
    assert len(made) == len(placements.used) > 1
    for number, paths in enumerate(made):
        assert paths.size_mm == BED
        items = [item for item in placements.items if item.sheet == number]
        order = [layer.operation for layer in paths.layers]
        assert order == [o for o in Operation if o in order]
        layers = {layer.operation: layer for layer in paths.layers}
        cuts = layers[Operation.CUT].outlines
        assert len(cuts) == len(items)
        assert sum(len(layer.segments) for layer in paths.layers) == len(items)
        for item, cut in zip(items, cuts, strict=True):
            np.testing.assert_allclose(cut, outlines[item.piece] @ item.turn.T + item.shift)


def test_placements_are_read_only():
    placements = nest([ANGLE], BED, 1.0)
    assert isinstance(placements, Placements)
    assert not placements.used.flags.writeable


@settings(max_examples=15)
@given(st.integers(1, 4), st.integers(1, 6), st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_first_pieces_are_on_the_first_sheets_on_as_many_as_alone(early, late, copies, seed):
    """And what comes after them lies apart and inside, as ever."""
    outlines = stars(early + late, seed, 80.0)
    first = [number < early for number in range(early + late)]
    placements = nest(outlines, BED, 2.0, copies, 5.0, first=first)
    check(outlines, placements, BED, 2.0, copies, 5.0)
    alone = nest(outlines[:early], BED, 2.0, copies, 5.0)
    with_first = {item.sheet for item in placements.items if item.piece < early}
    assert with_first == set(range(len(alone.used)))


def test_small_pieces_come_first_where_that_is_asked_for():
    """A large piece fills a bed each; the small ones then lie with the first of them or before."""
    large, small = shapely.box(0, 0, 180, 130), shapely.box(0, 0, 20, 20)
    bed = (200.0, 150.0)
    later = nest([large, small], bed, 2.0, [2, 6], 5.0)
    assert {item.sheet for item in later.items if item.piece == 1} == {2}
    early = nest([large, small], bed, 2.0, [2, 6], 5.0, first=[False, True])
    assert {item.sheet for item in early.items if item.piece == 1} == {0}
