"""Webs of another material hold in their panels by dovetails, which change nothing else."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from thick_sheets import book, miura_pattern, scaled_to

from fab.clearance.soundness import inspect_solids
from fab.errors import Severity
from fab.geometry.booleans import joined_mesh, manifolds, section
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.printing.print_objects import sheet_parts
from fab.printing.thick_settings import thick_settings

WEB = HingeSettings(web_mm=0.6, anchor_mm=2.0)
TWO = ("printer.panel_material=pla_filament", "printer.hinge_material=tpu_95a_filament")


def made(pattern, hinge=WEB, **panel):
    sheet, findings = thicken(pattern, PanelSettings(**panel), hinge)
    butted, _ = thicken(
        pattern, PanelSettings(**panel), hinge.model_copy(update={"anchor_mm": 0.0})
    )
    return sheet, butted, findings


def require_complementary(sheet, butted):
    """Bodies fill the same space without overlaps, and are sound."""
    solids = manifolds(sheet.bodies)
    assert inspect_solids(sheet, solids, joined_mesh(sheet.joining))[1] == []
    total = butted.bodies.volumes_mm3().sum()
    assert sheet.bodies.volumes_mm3().sum() == pytest.approx(total, rel=1e-9)
    (web,) = np.flatnonzero(sheet.flexible).tolist()
    for panel in range(web):
        assert (solids[web] ^ solids[panel]).volume() < 1e-6
    assert (sheet.joining.vertices_coords == butted.joining.vertices_coords).all()
    return solids, web


@pytest.mark.parametrize("axis", ["bottom", "middle"])
@pytest.mark.parametrize("angle_deg", [-70.0, 90.0])
def test_a_web_cannot_be_pulled_out_of_its_panels(axis, angle_deg):
    sheet, butted, findings = made(book(angle_deg), axis=axis)
    assert findings == []
    solids, web = require_complementary(sheet, butted)
    grown = sheet.bodies.volumes_mm3()[web] - butted.bodies.volumes_mm3()[web]
    teeth = 2 * 4  # every 5 mm of 19.4 mm, on both sides
    assert grown == pytest.approx(teeth * 0.6 * 2.0 * 2.5, rel=0.15)
    for panel, pull in ((0, -1.0), (1, 1.0)):
        for away in (0.2, 1.0):
            moved = solids[web].translate((pull * away, 0.0, 0.0))
            assert (moved ^ solids[panel]).volume() > 0.05 * away
        if axis == "middle":  # with the panel above and below
            for up in (-0.3, 0.3):
                assert (solids[web].translate((0.0, 0.0, up)) ^ solids[panel]).volume() > 1.0
    low = sheet.bodies.mesh(web).vertices_coords[:, 2].min()
    ceiling = section(sheet.bodies.mesh(0), low + 0.6 + 0.01).area
    assert ceiling == pytest.approx(section(butted.bodies.mesh(0), low + 0.6 + 0.01).area)


def test_teeth_keep_walls_to_each_other_and_to_the_rim_of_their_panel():
    pattern = scaled_to(miura_pattern(), 100.0)
    sheet, butted, findings = made(pattern)
    assert findings == []
    assert inspect_solids(sheet, manifolds(sheet.bodies), joined_mesh(sheet.joining))[1] == []
    for panel in range(len(sheet.panels.faces)):
        whole = section(butted.bodies.mesh(panel), 0.3)
        left = section(sheet.bodies.mesh(panel), 0.3)
        assert isinstance(left, shapely.Polygon)
        pockets = shapely.get_parts(whole - left)
        pockets = [pocket for pocket in pockets if pocket.area > 0.1]
        assert pockets
        # shrunk by half a wall the panel is still in one piece
        assert isinstance(left.buffer(-0.29), shapely.Polygon)


@settings(max_examples=12, deadline=None)
@given(st.floats(0.5, 6.0), st.floats(0.2, 1.2), st.floats(-120, 120))
def test_bodies_stay_complementary_for_any_tooth(anchor, web, angle):
    hinge = WEB.model_copy(update={"anchor_mm": anchor, "web_mm": web})
    sheet, butted, _ = made(book(round(angle, 3)), hinge)
    require_complementary(sheet, butted)


def test_webs_without_room_for_a_tooth_are_named():
    sheet, butted, findings = made(book(30.0), WEB.model_copy(update={"anchor_mm": 25.0}))
    (found,) = findings
    assert (found.code, found.severity) == ("web-not-anchored", Severity.WARNING)
    assert "no room for anchor_mm = 25" in found.text
    (crease,) = np.flatnonzero(sheet.pattern.edges_joining).tolist()
    assert found.creases == (crease,)
    assert (sheet.bodies.vertices_coords == butted.bodies.vertices_coords).all()


def test_two_materials_are_anchored_and_one_is_not():
    def anchor(*changes, machine="bambu_x1c", material=None):
        chosen = thick_settings(changes, machine, material)
        return chosen.printed(chosen.print_with()).hinges.anchor_mm

    assert anchor(*TWO) == 2.0
    assert anchor(*TWO, machine="large_format_fdm") == 4.0
    assert anchor(*TWO, machine=None) == 2.0
    assert anchor(material="pp_filament") == 0
    assert anchor(*TWO, "hinges.anchor_mm=0.0") == 0


def test_printed_parts_have_the_dovetails():
    sheet, butted, _ = made(book(60.0))
    parts, plain = sheet_parts(sheet), sheet_parts(butted)
    assert [part.name for part in parts] == ["panels", "hinges"]
    assert len(parts[1].mesh.triangles) > len(plain[1].mesh.triangles)
    reach = np.ptp(parts[1].mesh.vertices_coords[:, 0])
    assert reach == pytest.approx(np.ptp(plain[1].mesh.vertices_coords[:, 0]) + 4.0, abs=0.2)
