"""Pieces side to side: which lie together, how far apart the others are, and what is cut once."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from flat_patterns import pattern_of, stars
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.drawings.cut_paths import CutPaths, Layer, Operation, polylines
from fab.drawings.drawing_files import SheetFormat
from fab.drawings.shared_lines import cut_once
from fab.jobs.sheet_files import fabricate_together
from fab.layout.block_places import straight_sides
from fab.sheets.cut_pieces import PatternCopies
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.shared_cuts import placed_side_to_side
from solver.errors import InvalidState

STOCK = {"material": "card_300gsm", "machine": "co2_60w_600x400"}
KERF, GAP = 0.15, 2.0
HEXAGON = 30 * np.column_stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)])
SHAPES = [
    [(0, 0), (40, 0), (40, 60), (0, 60)],
    [(0, 0), (40, 0), (20, 20 * 3**0.5)],
    [(0, 0), (50, 0), (20, 35)],
    [(0, 0), (60, 0), (60, 20), (20, 20), (20, 60), (0, 60)],
    HEXAGON,
    [(0, 0), (31, 2), (37, 29), (3, 23)],
]


def piece(corners):
    return pattern_of(np.array(corners, float), [list(range(len(corners)))])


def requested(**keys):
    request = CutterSettings(**{**STOCK, "shared_cuts": True, **keys})
    return request.request([SheetFormat.SVG], page=False)


def made(*wanted, **keys):
    """The report on patterns, each given by its corners and copies."""
    patterns = [
        PatternCopies(f"p{number}", piece(corners), copies)
        for number, (corners, copies) in enumerate(wanted)
    ]
    return fabricate_together(patterns, "m", requested(**keys)).report


def test_rectangles_make_a_grid_whose_lines_are_cut_once():
    """Twelve of 40 x 60 mm in 4 columns and 3 rows: 5 lines up and 4 across, kerf included."""
    (sheet,) = made((SHAPES[0], 12))["sheets"]
    width, height = 40 + KERF, 60 + KERF
    assert sheet["cut_mm"] == pytest.approx(5 * 3 * height + 4 * 4 * width, abs=1e-4)
    assert sheet["pieces"] == ["A"] * 12
    (apart,) = fabricate_together(
        [PatternCopies("m", piece(SHAPES[0]), 12)],
        "m",
        CutterSettings(**STOCK).request([SheetFormat.SVG], page=False),
    ).report["sheets"]
    assert apart["cut_mm"] == pytest.approx(12 * 2 * (width + height), abs=1e-4)


def test_a_knife_that_takes_nothing_away_cuts_the_same_line():
    report = made((SHAPES[0], 2), machine="knife_a3_roll")
    (sheet,) = report["sheets"]
    assert report["machine"]["kerf_mm"] == 0
    assert sheet["cut_mm"] == pytest.approx(2 * 2 * 100 - 60, abs=1e-4)


def test_hexagons_are_a_comb():
    """Seven have 12 sides in common of 42."""
    (sheet,) = made((HEXAGON, 7))["sheets"]
    side = 30 + KERF / 3**0.5
    assert sheet["cut_mm"] == pytest.approx((42 - 12) * side, abs=1e-3)


def test_what_has_no_equal_side_stays_apart():
    shapes = [(SHAPES[0], 1), ([(0, 0), (40.01, 0), (40.01, 61), (0, 61)], 1), (SHAPES[5], 1)]
    (sheet,) = made(*shapes)["sheets"]
    single = [made(shape)["sheets"][0]["cut_mm"] for shape in shapes]
    assert sheet["cut_mm"] == pytest.approx(sum(single), abs=1e-3)


def lying(request, shapes, copies):
    """Outlines of pieces where they lie, as they are cut, and their turns, sheet by sheet."""
    outlines = [shapely.Polygon(corners).buffer(KERF / 2, join_style="mitre") for corners in shapes]
    placed = placed_side_to_side(
        [piece(corners) for corners in shapes],
        outlines,
        copies,
        [False] * len(shapes),
        request,
        lambda *_: None,
    )
    counts = np.bincount([item.piece for item in placed.items], minlength=len(shapes))
    assert counts.tolist() == copies
    for sheet in range(len(placed.used)):
        items = [item for item in placed.items if item.sheet == sheet]
        moved = [
            shapely.transform(outlines[i.piece], lambda p, i=i: p @ i.turn.T + i.shift)
            for i in items
        ]
        assert placed.used[sheet] == pytest.approx(shapely.area(moved).sum() / 600 / 400)
        yield np.array(moved), [item.turn for item in items]


@settings(max_examples=30)
@given(
    st.lists(st.sampled_from(range(len(SHAPES))), min_size=1, max_size=3, unique=True),
    st.integers(1, 9),
    st.sampled_from([None, 0.0, 30.0]),
    st.integers(0, 2**32 - 1),
)
def test_pieces_share_lines_or_are_apart_and_every_line_is_cut_once(chosen, most, grain, seed):
    copies = np.random.default_rng(seed).integers(1, most + 1, len(chosen)).tolist()
    request = requested(grain_deg=grain)
    for outlines, turns in lying(request, [SHAPES[number] for number in chosen], copies):
        bed = shapely.box(5, 5, 595, 395).buffer(1e-5)
        assert bed.contains(outlines).all()
        first, second = np.triu_indices(len(outlines), 1)
        distance = shapely.distance(outlines[first], outlines[second])
        common = shapely.area(shapely.intersection(outlines[first], outlines[second]))
        assert ((distance >= GAP - 1e-4) | (distance <= 1e-4)).all()
        assert common.max(initial=0) < 0.01
        if grain is not None:
            grains = [
                turn @ [np.cos(np.radians(grain)), np.sin(np.radians(grain))] for turn in turns
            ]
            np.testing.assert_allclose(np.array(grains)[:, 1], 0, atol=1e-9)
        rings = [shapely.get_coordinates(each.exterior)[:-1] for each in outlines]
        whole = CutPaths((Layer(Operation.CUT, outlines=tuple(rings)),), (600.0, 400.0))
        (layer,) = cut_once(whole).layers
        lines = [shapely.LineString(line) for line in polylines(layer)]
        every = shapely.union_all([shapely.LinearRing(ring) for ring in rings], grid_size=1e-3)
        once = shapely.union_all(lines, grid_size=1e-3)
        total = sum(line.length for line in lines)
        assert once.length == pytest.approx(total, abs=0.02)  # nothing twice
        assert once.length == pytest.approx(every.length, abs=0.02)  # and all of it


def test_sides_of_half_a_length_are_cut_once_where_they_lie():
    """A line across three squares: the lower edge of a wide one lies along two, and beyond."""
    boxes = [shapely.box(0, 0, 10, 10), shapely.box(10, 0, 20, 10), shapely.box(5, 10, 30, 20)]
    rings = tuple(shapely.get_coordinates(box.exterior)[:-1] for box in boxes)
    (layer,) = cut_once(CutPaths((Layer(Operation.CUT, outlines=rings),), (30.0, 20.0))).layers
    length = sum(shapely.LineString(line).length for line in polylines(layer))
    assert length == pytest.approx(40 + 30 + (70 - 15))
    assert len(layer.outlines) == 1
    assert len(layer.chains) == 2


def test_drawings_without_shared_lines_stay_as_they_are():
    rings = tuple(ring + np.array([70.0 * number, 0.0]) for number, ring in enumerate(stars(5, 1)))
    paths = CutPaths((Layer(Operation.CUT, outlines=rings),), (400.0, 70.0))
    (layer,) = cut_once(paths).layers
    assert [ring.tolist() for ring in layer.outlines] == [ring.tolist() for ring in rings]
    assert not layer.chains


def test_chords_of_curves_are_no_sides():
    circle = np.column_stack([np.cos(np.arange(60) / 60 * 2 * np.pi), np.sin(np.arange(60) / 9.55)])
    assert len(straight_sides(circle)) == 0
    assert len(straight_sides(np.array(HEXAGON))) == 6


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ({"bridges": 2}, "bridges would leave open what two pieces share"),
        ({"closed_slots": True}, "closed_slots wants no open cuts"),
    ],
)
def test_what_shared_lines_contradict_is_refused(keys, text):
    with pytest.raises(InvalidState, match=f"shared_cuts = true: {text}"):
        requested(**keys)


@pytest.mark.parametrize("keys", [{"two_sided": True}, {"mirror": True}, {"title": True}])
def test_other_wishes_go_with_shared_lines(keys):
    (sheet,) = made((SHAPES[0], 4), **keys)["sheets"]
    (plain,) = made((SHAPES[0], 4))["sheets"]
    if "two_sided" not in keys:
        assert sheet["cut_mm"] == plain["cut_mm"]
    else:
        assert sheet["sides"][1]["cut_mm"] == plain["cut_mm"]


def test_what_matches_a_later_piece_alone_is_laid_against_it():
    """Squares of 50 mm take a strip of 50 x 20 mm, which takes a square of 20 mm at its end."""
    square, strip, small = (
        [(0, 0), (x, 0), (x, y), (0, y)] for x, y in ((50, 50), (50, 20), (20, 20))
    )
    (sheet,) = made((square, 1), (strip, 1), (small, 1))["sheets"]
    edges = sum(4 * KERF + 2 * (x + y) for x, y in ((50, 50), (50, 20), (20, 20)))
    assert sheet["cut_mm"] == pytest.approx(edges - (50 + KERF) - (20 + KERF), abs=1e-3)
