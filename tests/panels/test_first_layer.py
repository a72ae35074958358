"""Bottoms are cut back where the first layer would bridge a gap, and nowhere else."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from flat_patterns import pattern_of
from hypothesis import given, settings
from hypothesis import strategies as st
from thick_sheets import book, miura_pattern, scaled_to

from fab.clearance.soundness import inspect_solids
from fab.errors import InvalidJob
from fab.geometry.bodies import Bodies
from fab.geometry.booleans import joined_mesh, manifolds, section
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.first_layer import bed_edges
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.printing.printers import load_printer
from fab.printing.thick_settings import PrintWith, thick_settings

KNUCKLES = HingeSettings(kind="knuckle", play_mm=0.3, knuckle_mm=2.0, pin_mm=1.2)


def made(pattern, spread_mm, hinge=KNUCKLES, **panel):
    panel = {"thickness_mm": 3.2, "axis": "middle", **panel}
    sheet, findings = thicken(pattern, PanelSettings(first_layer_mm=spread_mm, **panel), hinge)
    joined = joined_mesh(sheet.joining)
    assert inspect_solids(sheet, manifolds(sheet.bodies), joined)[1] == []
    return sheet, [finding.code for finding in findings]


def least_gap_mm(bodies: Bodies, above_mm: float) -> float:
    z = bodies.vertices_coords[:, 2].min() + above_mm
    figures = [section(bodies.mesh(i), z) for i in range(len(bodies))]
    return min(one.distance(other) for one, other in combinations(figures, 2))


@pytest.mark.parametrize("angle_deg", [-90.0, -20.0, 35.0, 120.0])
def test_barrels_keep_their_play_on_the_bed_however_the_first_layer_spreads(angle_deg):
    plain, codes = made(book(angle_deg), 0.0)
    assert codes == []
    assert least_gap_mm(plain.bodies, 0.05) == pytest.approx(0.3)
    sheet, codes = made(book(angle_deg), 0.15)
    assert codes == ["first-layer-relief"]
    for above in (0.01, 0.1, 0.149):
        assert least_gap_mm(sheet.bodies, above) >= 0.6 - 1e-6
    for above in (0.61, 1.6, 2.5):
        z = sheet.bodies.vertices_coords[:, 2].min() + above
        for body in range(2):
            uncut = section(plain.bodies.mesh(body), z).area
            assert section(sheet.bodies.mesh(body), z).area == pytest.approx(uncut, abs=1e-6)


def test_around_vertices_no_panel_comes_too_near_either():
    sheet, _ = made(scaled_to(miura_pattern(), 120.0), 0.15)
    assert least_gap_mm(sheet.bodies, 0.1) >= 0.6 - 1e-6


@settings(max_examples=15, deadline=None)
@given(st.floats(0.02, 0.4), st.floats(0.1, 0.5), st.floats(-100, 100))
def test_the_first_layer_keeps_the_gap_for_any_spread_and_play(spread, play, angle):
    hinge = KNUCKLES.model_copy(update={"play_mm": play})
    sheet, _ = made(book(round(angle, 3)), spread, hinge, thickness_mm=4.0)
    assert least_gap_mm(sheet.bodies, spread / 2) >= play + 2 * spread - 1e-6


def test_webs_stay_joined_to_their_panels():
    web = HingeSettings(web_mm=0.2, relief_mm=0.5, play_mm=0.3)
    panel = {"thickness_mm": 1.0, "axis": "bottom", "gap_mm": 0.4}
    plain, _ = made(book(30.0), 0.0, web, **panel)
    sheet, codes = made(book(30.0), 0.15, web, **panel)
    assert codes == ["first-layer-relief"]
    (soft,) = np.flatnonzero(sheet.flexible).tolist()
    assert (
        sheet.bodies.mesh(soft).vertices_coords == plain.bodies.mesh(soft).vertices_coords
    ).all()
    rims = [section(sheet.bodies.mesh(i), 0.1) for i in range(3)]
    run = np.ptp(sheet.bodies.mesh(soft).vertices_coords[:, 1])
    for panel_rim in rims[:2]:
        assert panel_rim.intersection(rims[2].buffer(1e-6)).length > 2 * run
    assert rims[0].distance(rims[1]) == pytest.approx(
        least_gap_mm(plain.bodies.chosen([0, 1]), 0.1)
    )
    # beyond the web both panels are cut back, upright up to c and at 45 degrees above, where their
    # bevels lean back by t
    c, t = 0.15, np.tan(np.radians(15))
    area = c**2 * (1 - t / 2) + (c * (1 - t)) ** 2 / (2 * (1 + t))
    lost = plain.bodies.volumes_mm3().sum() - sheet.bodies.volumes_mm3().sum()
    assert lost == pytest.approx(2 * (20.0 - run) * area, rel=0.01)


def test_wide_gaps_keep_their_bytes():
    web = HingeSettings(play_mm=0.3)
    for gap, kind in ((0.8, "web"), (0.8, "none"), (0.4, "film")):
        hinge = web.model_copy(update={"kind": kind})
        panel = {"thickness_mm": 1.6, "axis": "bottom", "gap_mm": gap}
        plain, _ = thicken(book(30.0), PanelSettings(**panel), hinge)
        sheet, findings = thicken(book(30.0), PanelSettings(first_layer_mm=0.2, **panel), hinge)
        assert findings == []
        assert sheet.bodies.vertices_coords.tobytes() == plain.bodies.vertices_coords.tobytes()


def test_pieces_beside_each_other_are_cut_back_too():
    square = np.array([[0, 0], [20, 0], [20, 20], [0, 20]], float)
    flat = np.concatenate([square, square + np.array([20.3, 5.0])])
    pattern = pattern_of(flat, [[0, 1, 2, 3], [4, 5, 6, 7]])
    sheet, codes = made(pattern, 0.1, thickness_mm=3.2)
    assert codes == ["first-layer-relief"]
    assert least_gap_mm(sheet.bodies, 0.05) == pytest.approx(0.5)
    assert least_gap_mm(sheet.bodies, 0.5) == pytest.approx(0.3)


def test_edges_around_a_bottom_run_straight_from_corner_to_corner():
    sheet, _ = thicken(book(0.0), PanelSettings(thickness_mm=1.0, gap_mm=0.5), HingeSettings())
    edges = bed_edges(sheet.bodies.chosen(np.array([0])), 0.0)
    assert len(edges.bodies) == 4
    assert (edges.beyond == edges.beyond[0, 0]).all()
    assert edges.upright.all()
    middle = edges.ends.mean(axis=(0, 1))
    away = edges.ends.mean(axis=1) - middle
    assert ((away * edges.outward).sum(axis=1) > 0).all()


def test_the_spread_is_that_of_the_printer_unless_it_is_given():
    printer = load_printer("prusa_mk4s")
    with_printer = PrintWith(printer)
    assert thick_settings().printed(with_printer).panels.first_layer_mm == printer.first_layer_mm
    own = thick_settings(("panels.first_layer_mm=0.0",)).printed(with_printer)
    assert own.panels.first_layer_mm == 0
    thin = thick_settings(("panels.thickness_mm=0.41", "hinges.web_mm=0.2")).printed(with_printer)
    assert thin.panels.first_layer_mm == pytest.approx(0.41 / 4)
    powder = replace(with_printer, printer=load_printer("sls_nylon"))
    assert thick_settings().printed(powder).panels.first_layer_mm == 0
    with pytest.raises(InvalidJob, match=r"first_layer_mm = 0\.5 must be at most a quarter"):
        thick_settings(("panels.first_layer_mm=0.5",))
