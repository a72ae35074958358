"""Edges that end within a face: slits go through the panel, creases are reported."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.clearance.thick_inspection import inspect_thick
from fab.errors import Severity
from fab.folding.folded_states import flat_panels
from fab.geometry.booleans import joined_mesh, section
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.step import step_bytes
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import CreasePattern

GAP, THICK = 0.8, 2.0


def sheet_with(lines, letter, width=100.0, height=60.0) -> CreasePattern:
    """A rectangle with a crease along y in its middle, and lines within its second face."""
    rim = [[0, 0], [50, 0], [width, 0], [width, height], [50, height], [0, height]]
    inner = np.asarray(lines, float).reshape(-1, 2)
    ends = 6 + np.arange(len(inner)).reshape(-1, 2)
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]]
    faces = [[0, -1], [1, -1], [1, -1], [1, -1], [0, -1], [0, -1], [0, 1]]
    count = len(ends)
    angle = {"M": -90.0, "V": 90.0}.get(letter, 0.0)
    return CreasePattern(
        np.vstack([rim, inner]).astype(float),
        np.concatenate([edges, ends]),
        np.concatenate([faces, np.ones((count, 2), int)]),
        np.array(["B"] * 6 + ["V"] + [letter] * count),
        np.array([0.0] * 6 + [60.0] + [angle] * count),
        np.array([0, 1, 4, 5, 1, 2, 3, 4]),
        np.array([0, 4, 8]),
    )


def made(pattern, **hinge):
    axis = "middle" if hinge.get("kind") == "knuckle" else "bottom"
    panel = PanelSettings(thickness_mm=THICK, gap_mm=GAP, axis=axis)
    return thicken(pattern, panel, HingeSettings(web_mm=0.2, **hinge))


def volume(pattern, **hinge):
    return made(pattern, **hinge)[0].bodies.volumes_mm3()


@given(
    st.lists(
        st.tuples(st.floats(60, 90), st.floats(10, 50), st.floats(60, 90), st.floats(10, 50)),
        min_size=1,
        max_size=3,
    ),
    st.sampled_from(["C", "B"]),
)
@settings(max_examples=30, deadline=None)
def test_a_slot_is_as_wide_as_the_gap_and_half_of_it_longer_at_both_ends(lines, letter):
    lines = [line for line in lines if np.hypot(line[0] - line[2], line[1] - line[3]) > 1]
    if not lines:
        return
    bands = [
        shapely.LineString([line[:2], line[2:]]).buffer(GAP / 2, cap_style="square")
        for line in lines
    ]
    slots = shapely.union_all(bands)
    if len(slots.interiors if slots.geom_type == "Polygon" else []):
        return  # lines that enclose something: faces of their own, where a pattern is read
    sheet, findings = made(sheet_with(lines, letter))
    assert findings == []
    assert len(sheet.bodies) == 3
    whole = volume(sheet_with([], letter))
    assert (whole - sheet.bodies.volumes_mm3()) / THICK == pytest.approx(
        [0, slots.area, 0], abs=1e-6
    )
    cut = section(sheet.bodies.mesh(1), THICK / 2)
    assert cut.intersection(slots).area == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize(
    "hinge",
    [
        {},
        {"hole_mm": 2.0},
        {"kind": "film"},
        {"kind": "knuckle", "pin_mm": 0.6, "play_mm": 0.2, "wall_mm": 0.4},
    ],
)
def test_slit_sheets_are_sound_with_all_hinges(hinge):
    pattern = sheet_with([70, 20, 70, 40], "C")
    sheet, _ = made(pattern, **hinge)
    _, findings = inspect_thick(sheet, joined_mesh(sheet.joining), [flat_panels(pattern)])
    assert findings == []
    whole = volume(sheet_with([], "C"), **hinge)
    lost = (whole - sheet.bodies.volumes_mm3())[:2]
    assert lost == pytest.approx([0, (20 + GAP) * GAP * THICK], abs=1e-6)


def test_the_slit_is_in_the_step_file(tmp_path):
    from build123d import import_step

    sheet, _ = made(sheet_with([70, 20, 70, 40], "C"))
    (tmp_path / "slit.step").write_bytes(step_bytes(sheet, "slit"))
    read = import_step(tmp_path / "slit.step")
    assert read.volume == pytest.approx(sheet.bodies.volumes_mm3().sum(), rel=1e-9)
    assert all(each.is_valid for each in read.solids())


def test_a_slit_from_the_border_reaches_through_it():
    lost = volume(sheet_with([], "C")) - volume(sheet_with([70, 0, 70, 20], "C"))
    assert lost == pytest.approx([0, (20 + GAP / 2) * GAP * THICK, 0], abs=1e-6)


def test_a_slit_that_would_part_its_panel_is_reported():
    pattern = sheet_with([50.2, 30, 99.8, 30], "C")
    sheet, findings = made(pattern)
    (finding,) = findings
    assert (finding.code, finding.severity) == ("slit-not-cut", Severity.ERROR)
    assert (finding.creases, finding.panels) == ((7,), (1,))
    assert sheet.bodies.volumes_mm3() == pytest.approx(volume(sheet_with([], "C")))


@pytest.mark.parametrize("letter", ["M", "V", "U"])
def test_a_crease_within_a_face_is_no_hinge_and_is_reported(letter):
    sheet, findings = made(sheet_with([70, 20, 70, 40, 80, 20, 80, 40], letter))
    (finding,) = findings
    assert (finding.code, finding.creases) == ("crease-within-panel", (7, 8))
    assert finding.text.startswith("2 creases end within a face")
    assert sheet.held.tolist() == [6]
    assert sheet.bodies.volumes_mm3() == pytest.approx(volume(sheet_with([], letter)))
