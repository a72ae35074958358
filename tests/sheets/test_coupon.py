"""The test card: on every machine, in every material."""

from io import StringIO

import ezdxf
import numpy as np
import pytest
import shapely

from fab.catalogue import known_of
from fab.drawings.cut_paths import Operation
from fab.drawings.drawing_files import USUAL, DrawingStyle, drawing_files
from fab.drawings.dxf import DxfVersion, dxf_bytes
from fab.drawings.layer_colours import Colour, Colours
from fab.geometry.rings import is_hole
from fab.sheets.coupon import coupon
from fab.sheets.crease_styles import DotStyle
from fab.sheets.materials import load_machine, load_material
from fab.sheets.stroke_letters import letter_strokes
from solver.errors import InvalidValue

CASES = [(k, m) for k in known_of("cutter") for m in known_of("sheet")]


def lines(layer):
    rings = [np.concatenate([outline, outline[:1]]) for outline in layer.outlines]
    sides = [np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings]
    sides += [np.stack([chain[:-1], chain[1:]], axis=1) for chain in layer.chains]
    return np.concatenate([layer.segments, *sides])


@pytest.mark.parametrize(("machine", "material"), CASES)
def test_the_card_fits_the_bed_and_cuts_nothing_twice(machine, material):
    machine, material = load_machine(machine), load_material(material)
    paths = coupon(machine, material)
    assert paths.size_mm == machine.bed_mm
    assert [layer.operation for layer in paths.layers] == sorted(
        {layer.operation for layer in paths.layers}, key=list(Operation).index
    )
    every = np.concatenate([lines(layer) for layer in paths.layers])
    assert every.min() == pytest.approx(machine.margin_mm)  # in the margins' corner
    free = np.array(paths.size_mm) - machine.margin_mm
    assert (every.reshape(-1, 2).max(axis=0) <= free + 1e-9).all()
    cut = np.concatenate([lines(la) for la in paths.layers if la.operation != Operation.ENGRAVE])
    length = np.hypot(*(cut[:, 1] - cut[:, 0]).T)
    assert length.min() > 0
    assert shapely.union_all(shapely.linestrings(cut)).length == pytest.approx(length.sum())


def test_a_table_of_cuts_and_gaps_around_the_starting_values():
    material = load_material("card_300gsm")
    paths = coupon(load_machine("co2_60w_600x400"), material)
    mountain = next(la for la in paths.layers if la.operation is Operation.MOUNTAIN).segments
    heights = np.unique(mountain[:, 0, 1].round(6))
    assert len(heights) == 5  # one row of tongues for each gap
    shares = np.array([0.5, 0.7, 1, 1.4, 2])
    for gap, y in zip(1.0 * shares, heights, strict=True):
        row = mountain[np.abs(mountain[:, 0, 1] - y) < 1e-6][..., 0]
        cuts, gaps = np.ptp(row, axis=1), row[1:, 0] - row[:-1, 1]
        assert set(cuts.round(6)) == set((3.0 * shares).round(6))
        assert (cuts[:-1] <= cuts[1:] + 1e-9).all()  # growing to the right
        between = gaps > 3  # tongues
        assert between.sum() == 4
        assert gaps[~between] == pytest.approx(gap)


def test_creases_keep_their_margin_from_the_cuts_around_the_tongue():
    material = load_material("card_300gsm")
    paths = coupon(load_machine("co2_60w_600x400"), material)
    by = {layer.operation: layer for layer in paths.layers}
    creases = np.concatenate([by[Operation.MOUNTAIN].segments, by[Operation.VALLEY].segments])
    tree = shapely.STRtree(shapely.linestrings(lines(by[Operation.CUT])))
    _, near = tree.query_nearest(shapely.linestrings(creases), return_distance=True)
    assert near.min() == pytest.approx(material.perforation.margin_mm)


def test_the_tab_fits_the_slot_that_is_labelled_with_the_kerf():
    machine, material = load_machine("co2_60w_600x400"), load_material("plywood_3mm")
    by = {layer.operation: layer for layer in coupon(machine, material).layers}
    cut, slots = by[Operation.CUT], by[Operation.HOLE].outlines
    assert len(slots) == 9
    (tab,) = [outline for outline in cut.outlines if len(outline) == 8]
    width = np.ptp(tab[tab[:, 1] == tab[:, 1].max(), 0])
    lengths = np.array([np.ptp(slot[:, 1]) for slot in slots])
    assert np.ptp(slots[0][:, 0]) == pytest.approx(material.thickness_mm)
    kerfs = (width - lengths) / 2
    assert kerfs == pytest.approx(np.arange(9) * 0.04)
    assert kerfs.min() <= machine.kerf_mm <= kerfs.max()


def test_whole_line_machines_get_one_line_of_each_letter():
    paths = coupon(load_machine("diode_10w_400x400"), load_material("card_300gsm"))
    for letter in (Operation.MOUNTAIN, Operation.VALLEY):
        (layer,) = [layer for layer in paths.layers if layer.operation is letter]
        assert len(layer.segments) == 1


def test_the_same_card_is_written_alike_and_small_beds_are_refused():
    machine, material = load_machine("co2_40w_300x200"), load_material("card_300gsm")
    assert dxf_bytes(coupon(machine, material)) == dxf_bytes(coupon(machine, material))
    with pytest.raises(InvalidValue, match="bed = 50 x 40 mm"):
        coupon(machine.model_copy(update={"bed_mm": (60.0, 50.0)}), material)


def test_dots_that_would_join_are_left_out():
    machine, material = load_machine("co2_60w_600x400"), load_material("card_300gsm")
    style = DotStyle(dot_mm=0.8, pitch_mm=1.0)
    perforation = material.perforation.model_copy(update={"mountain": style})
    paths = coupon(machine, material.model_copy(update={"perforation": perforation}))
    dots = next(la for la in paths.layers if la.operation is Operation.MOUNTAIN).segments
    lengths = np.unique(np.ptp(dots[..., 0], axis=1).round(6))
    assert lengths == pytest.approx([0.4, 0.56, 0.8, 1.12, 1.6])
    rows = {
        y: np.unique(np.ptp(dots[dots[:, 0, 1].round(6) == y][..., 0], axis=1).round(6)).max()
        for y in np.unique(dots[:, 0, 1].round(6))
    }
    pitches = (0.5, 0.7, 1.0, 1.4, 2.0)
    longest = [max(length for length in lengths if length < pitch) for pitch in pitches]
    assert list(rows.values()) == pytest.approx(longest)


@pytest.mark.parametrize("letter", [Operation.MOUNTAIN, Operation.VALLEY])
def test_tongues_of_rigid_sheet_bend_on_the_lattice_of_the_pieces(letter):
    machine, material = load_machine("fibre_1kw_1500x1000"), load_material("plywood_3mm")
    style = material.perforation.mountain
    slits = next(la for la in coupon(machine, material).layers if la.operation is letter).segments
    rows = np.unique(slits[:, 0, 1].round(6))
    assert len(rows) == 5 * style.rows
    assert np.diff(rows).min() == pytest.approx(style.pitch_mm)
    longest = np.ptp(slits[..., 0], axis=1).max()
    assert longest == pytest.approx(2 * style.cut_mm)
    assert (slits[..., 1] == slits[:, :1, 1]).all()


def test_colours_are_those_of_the_machine():
    colours = Colours(engrave=Colour(hex="#123456", aci=42))
    machine = load_machine("co2_60w_600x400").model_copy(update={"colours": colours})
    card = coupon(machine, load_material("card_300gsm"))
    files = drawing_files(card, "card", USUAL, DrawingStyle(machine.colours, DxfVersion.R12))
    assert b'stroke="#123456"' in files["card.svg"]
    assert b"AC1009" in files["card.dxf"]
    assert ezdxf.read(StringIO(files["card.dxf"].decode())).layers.get("ENGRAVE").color == 42
    assert list(files) == ["card.dxf", "card.svg", "card.pdf"]


def test_the_card_says_what_it_is_and_tongues_are_one_cut_each():
    machine, material = load_machine("co2_60w_600x400"), load_material("card_300gsm")
    card = coupon(machine, material, ("card_300gsm", "co2_60w_600x400"))
    by = {layer.operation: layer for layer in card.layers}
    first = letter_strokes("card_300gsm on co2_60w_600x400.")
    drawn = [chain - chain[0] for chain in by[Operation.ENGRAVE].chains]
    size = 2.5
    wanted = [size * (stroke - stroke[0]) for stroke in first]
    starts = range(len(drawn) - len(wanted))
    assert any(
        all(
            len(a) == len(b) and np.allclose(a, b)
            for a, b in zip(drawn[i : i + len(wanted)], wanted, strict=True)
        )
        for i in starts
    )
    assert [len(chain) for chain in by[Operation.CUT].chains] == [4] * 50
    letters = shapely.union_all([shapely.LineString(line) for line in by[Operation.ENGRAVE].chains])
    rest = [lines(layer) for layer in card.layers if layer.operation is not Operation.ENGRAVE]
    assert letters.distance(shapely.union_all(shapely.linestrings(np.concatenate(rest)))) > 0.2


def test_a_beam_wider_along_an_axis_has_a_comb_for_each():
    machine = load_machine("co2_60w_600x400").model_copy(update={"kerf_mm": (0.16, 0.32)})
    by = {layer.operation: layer for layer in coupon(machine, load_material("plywood_3mm")).layers}
    slots, tabs = by[Operation.HOLE].outlines, by[Operation.CUT].outlines[:2]
    assert len(slots) == 18
    for axis, kerf in ((0, 0.16), (1, 0.32)):
        # the tongue of a tab is what sticks out from its handle, 10 mm wide along the axis
        own = [slot for slot in slots if np.ptp(slot, axis=0)[axis] > 5]
        tab = next(tab for tab in tabs if np.ptp(tab, axis=0)[axis] > np.ptp(tab, axis=0)[1 - axis])
        far = tab[:, 1 - axis] == tab[:, 1 - axis].max()
        width = np.ptp(tab[far, axis])
        kerfs = (width - np.array([np.ptp(slot[:, axis]) for slot in own])) / 2
        assert len(own) == 9
        assert kerfs == pytest.approx(np.arange(9) * kerf / 4)
        assert all(is_hole(slot) for slot in own)
