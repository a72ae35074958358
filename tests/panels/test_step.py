"""STEP files of bodies, read back by another reader."""

import re

import numpy as np
import pytest
from thick_sheets import in_pose, miura_pattern, thick

from fab.panels.step import step_bytes


@pytest.fixture(scope="module")
def sheet():
    return thick(miura_pattern())


def test_step_holds_named_coloured_valid_solids(sheet, tmp_path):
    from build123d import import_step

    (tmp_path / "miura.step").write_bytes(step_bytes(sheet, "miura"))
    back = import_step(tmp_path / "miura.step")
    assert [child.label for child in back.children] == list(sheet.names)
    volumes = [solid.volume for solid in back.solids()]
    assert volumes == pytest.approx(sheet.bodies.volumes_mm3(), rel=1e-9)
    assert all(solid.is_valid for solid in back.solids())
    colours = {child.label: tuple(child.color)[:3] for child in back.children}
    letters = sheet.pattern.edges_assignment[sheet.creases[sheet.flexible]]
    hinges = np.array(sheet.names)[sheet.flexible]
    red, blue = (colours[hinges[letters == letter][0]] for letter in "MV")
    assert red[0] > red[2]
    assert blue[2] > blue[0]


def test_step_of_a_folded_state_has_the_panels_where_they_are(sheet, tmp_path):
    from build123d import import_step

    folded = sheet.pattern.folded_coords
    data = step_bytes(sheet, "folded", folded)
    assert data == step_bytes(sheet, "folded", folded)
    (tmp_path / "folded.step").write_bytes(data)
    back = import_step(tmp_path / "folded.step")
    assert [child.label for child in back.children] == [sheet.names[i] for i in sheet.rigid]
    posed = in_pose(sheet, folded)
    low, high = posed.boxes()
    for i, child in enumerate(back.children):
        corners = np.array([tuple(v) for v in child.vertices()])
        assert corners.min(axis=0) == pytest.approx(low[i], abs=1e-6)
        assert corners.max(axis=0) == pytest.approx(high[i], abs=1e-6)


def test_step_bytes_repeat_within_a_process(sheet):
    first, second = (step_bytes(sheet, "miura") for _ in range(2))
    assert first == second
    assert re.search(rb"FILE_NAME\('miura','1980-01-01T00:00:00'", first)
