"""Barrels that snap onto pins: open by less than the pin, on one side, and sound."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from thick_sheets import book

from fab.clearance.soundness import inspect_solids
from fab.errors import InvalidJob
from fab.geometry.booleans import joined_mesh, manifolds, prism
from fab.jobs.print_files import ThickFormat, make_thick
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.snap_slots import slot_mm
from fab.panels.thick_sheet import thicken
from fab.printing.thick_settings import thick_settings

KNUCKLES = HingeSettings(kind="knuckle", play_mm=0.3, knuckle_mm=3.0)


def solids(angle_deg, hinge):
    panel = PanelSettings(thickness_mm=4.0, axis="middle")
    sheet, findings = thicken(book(angle_deg), panel, hinge)
    assert findings == []
    out = manifolds(sheet.bodies)
    assert inspect_solids(sheet, out, joined_mesh(sheet.joining))[1] == []
    assert len(sheet.knuckles.creases) == 1
    return out


def caught_mm3(pinned, turning, shift):
    """Common volume when the panel without the pin is moved."""
    return (pinned ^ turning.translate(shift)).volume()


@pytest.mark.parametrize("angle_deg", [-90.0, -30.0, 40.0, 110.0])
def test_a_panel_comes_off_downwards_past_its_slots_alone(angle_deg):
    pinned, turning = solids(angle_deg, KNUCKLES.model_copy(update={"snap": True}))
    closed_pin, closed = solids(angle_deg, KNUCKLES)
    down = [caught_mm3(pinned, turning, (0, 0, -z)) for z in np.linspace(0.1, 5.0, 50)]
    shut = [caught_mm3(closed_pin, closed, (0, 0, -z)) for z in np.linspace(0.1, 5.0, 50)]
    assert 0 < max(down) < 0.2 * max(shut)
    assert down[-1] == pytest.approx(0, abs=1e-9)
    for shift in ((0, 0, 1.0), (1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0)):
        assert caught_mm3(pinned, turning, shift) > 0.5
    assert pinned.volume() == pytest.approx(closed_pin.volume())
    assert turning.volume() < closed.volume()


@settings(max_examples=12, deadline=None)
@given(st.floats(0.8, 2.0), st.floats(0.1, 0.4), st.floats(-100, 100))
def test_slots_are_narrower_than_pins_by_half_of_the_play(pin, play, angle):
    hinge = KNUCKLES.model_copy(
        update={"snap": True, "pin_mm": pin, "play_mm": play, "wall_mm": 0.4}
    )
    _, turning = solids(round(angle, 3), hinge)
    assert slot_mm(hinge) == pytest.approx(pin - play / 2)
    # a plate in the slot, up into its narrow part, as wide as that but for rounding
    for width, free in ((slot_mm(hinge) - 1e-3, True), (slot_mm(hinge) + 1e-2, False)):
        ring = np.array([[-width / 2, 0], [width / 2, 0], [width / 2, 20], [-width / 2, 20]])
        plate = prism(ring, 0.0, pin / 2 + 1.5 * play)
        common = (plate ^ turning).volume()
        assert (common < 1e-9) is free


def test_prints_with_snap_slots_are_checked_and_within_tolerance():
    changes = (
        "panels.axis=middle",
        "panels.thickness_mm=3.2",
        "hinges.kind=knuckle",
        "hinges.snap=true",
    )
    chosen = thick_settings(changes, "prusa_mk4s", "pp_filament")
    with_printer = chosen.print_with()
    formats = [ThickFormat.THREEMF]
    made = make_thick(book(90.0), "book", chosen, print_with=with_printer, formats=formats)
    assert made.within_tolerance
    assert {finding.code for finding in made.findings} == {"first-layer-relief"}
    assert made.report["solids"]["hinges"] == 1


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        (("hinges.snap=true",), "snap = true without knuckles"),
        (
            ("hinges.kind=knuckle", "hinges.snap=true", "hinges.play_mm=0.7", "panels.axis=middle"),
            "at most half of hinges.pin_mm",
        ),
    ],
)
def test_what_does_not_snap_is_refused(changes, text):
    with pytest.raises(InvalidJob, match=text):
        thick_settings((*changes, "panels.thickness_mm=5.0"))
