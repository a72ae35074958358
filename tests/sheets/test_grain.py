"""Pieces keep the grain of what they are cut from."""

from __future__ import annotations

from io import StringIO

import ezdxf
import numpy as np
import pytest
import shapely
from flat_patterns import grid, pattern_of
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.drawings.drawing_files import SheetFormat
from fab.jobs.sheet_files import fabricate
from fab.layout.nesting import nest
from fab.sheets.cut_wishes import CutWishes
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.materials import Material, load_machine, load_material
from fab.sheets.sheet_request import SheetRequest
from solver.errors import InvalidState

MACHINE = load_machine("co2_40w_300x200")
CARD = load_material("card_300gsm")


def of_grain(grain_deg, rotations_deg="any"):
    keys = {"grain_deg": grain_deg, "rotations_deg": rotations_deg}
    return Material.model_validate({**CARD.model_dump(), **keys})


@pytest.mark.parametrize(
    ("rotations", "stock_deg", "pattern_deg", "expected"),
    [
        ("any", None, None, None),
        ("any", 0.0, None, None),
        ("any", 90.0, 0.0, {90.0, 270.0}),
        ("any", 0.0, 30.0, {330.0, 150.0}),
        ("half turns", None, None, {0.0, 180.0}),
        ("half turns", 90.0, None, {90.0, 270.0}),
        ("half turns", 90.0, 45.0, {45.0, 225.0}),
        ("none", None, None, {0.0}),
        ("none", 90.0, 0.0, {90.0}),
        ([0.0, 90.0], None, None, {0.0, 90.0}),
        ([0.0, 120.0], 60.0, 0.0, {60.0, 180.0}),
    ],
)
def test_turns_follow_from_both_grains(rotations, stock_deg, pattern_deg, expected):
    request = SheetRequest(of_grain(stock_deg, rotations), MACHINE, grain_deg=pattern_deg)
    turns = request.rotations_deg
    assert (turns if turns is None else set(turns)) == expected
    assert request.split.rotations_deg == turns


def test_a_grain_that_the_stock_does_not_have_is_refused():
    keys = {"machine": "co2_40w_300x200", "grain_deg": 0.0}
    with pytest.raises(InvalidState, match="0: the material has no grain to lie along"):
        CutterSettings(material="acrylic_2mm", **keys).request()
    assert CutterSettings(material="plywood_3mm", **keys).request().rotations_deg == (0.0, 180.0)


def random_pieces(rng, count):
    """Convex pieces and deep notched ones, at most 80 mm long."""
    out = []
    for _ in range(count):
        sides = int(rng.integers(3, 8))
        angle = np.sort(rng.uniform(0, 2 * np.pi, sides))
        radius = rng.uniform(8, 40, sides)
        ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        piece = shapely.Polygon(ring)
        if not piece.is_valid or piece.area < 20:
            piece = shapely.box(0, 0, *rng.uniform(5, 50, 2))
        out.append(piece)
    return out


@settings(max_examples=1000)
@given(
    st.floats(-180, 180),
    st.floats(-180, 180),
    st.integers(1, 3),
    st.integers(1, 2),
    st.floats(0.1, 8),
    st.floats(0, 12),
    st.integers(0, 2**32 - 1),
)
def test_every_placement_keeps_the_grain(stock_deg, pattern_deg, count, copies, gap, margin, seed):
    """Nothing overlaps, gaps are kept, and all is on the bed."""
    request = SheetRequest(of_grain(stock_deg), MACHINE, grain_deg=pattern_deg)
    pieces = random_pieces(np.random.default_rng(seed), count)
    bed = (150.0, 120.0)
    placements = nest(pieces, bed, gap, copies, margin, rotations_deg=request.rotations_deg)
    placed = [(item.piece, item.copy) for item in placements.items]
    assert sorted(placed) == [(i, k) for i in range(count) for k in range(copies)]
    along = np.radians([pattern_deg, stock_deg])
    grain, stock = np.column_stack([np.cos(along), np.sin(along)])
    for item in placements.items:
        turned = item.turn @ grain
        assert abs(turned[0] * stock[1] - turned[1] * stock[0]) < 1e-9  # along it, either way
        assert np.linalg.det(item.turn) == pytest.approx(1)
    lying = np.array(
        [
            shapely.transform(pieces[i.piece], lambda p, i=i: p @ i.turn.T + i.shift)
            for i in placements.items
        ]
    )
    low, high = shapely.total_bounds(lying).reshape(2, 2)
    assert (low >= margin - 1e-6).all()
    assert (high <= np.array(bed) - margin + 1e-6).all()
    sheet = np.array([item.sheet for item in placements.items])
    first, second = np.triu_indices(len(lying), 1)
    together = sheet[first] == sheet[second]
    distance = shapely.distance(lying[first[together]], lying[second[together]])
    assert (distance >= gap - 1e-6).all()


def test_margin_and_gap_are_those_of_the_run(tmp_path):
    keys = {"material": "card_300gsm", "machine": "co2_40w_300x200", "copies": 2}
    kinds = [SheetFormat.DXF]
    board = grid(2, 1, 68.0)
    near = CutterSettings(**keys, margin_mm=3.0, piece_gap_mm=20.0).request(kinds, page=False)
    assert (near.margin_mm, near.gap_mm, near.machine.margin_mm) == (3.0, 20.0, 3.0)
    assert len(fabricate(board, "board", near).report["sheets"]) == 1
    wide = CutterSettings(**keys, margin_mm=3.0, piece_gap_mm=170.0).request(kinds, page=False)
    assert len(fabricate(board, "board", wide).report["sheets"]) == 2
    with pytest.raises(ValueError, match=r"margin_mm = 100 leaves nothing of bed_mm"):
        CutterSettings(**keys, margin_mm=100.0).request()


@pytest.mark.parametrize("mirror", [False, True])
def test_creases_lie_along_the_grain_of_the_stock_on_the_bed(mirror):
    """Of a strip whose creases are all along y, on stock with a grain at 30 degrees."""
    coords = [(25.0 * x, y) for y in (0.0, 60.0) for x in range(6)]
    strip = pattern_of(coords, [[x, x + 1, x + 7, x + 6] for x in range(5)])
    request = SheetRequest(
        of_grain(30.0),
        MACHINE,
        formats=[SheetFormat.DXF],
        page=False,
        grain_deg=90.0,
        wishes=CutWishes(mirror=mirror),
    )
    made = fabricate(strip, "strip", request)
    lines = ezdxf.read(StringIO(made.files["strip_1.dxf"].decode())).modelspace()
    dashes = [each for each in lines.query("LINE") if each.dxf.layer == "MOUNTAIN"]
    assert len(dashes) > 20
    angles = [(each.dxf.end - each.dxf.start).angle_deg % 180 for each in dashes]
    np.testing.assert_allclose(angles, 30.0, atol=1e-3)
