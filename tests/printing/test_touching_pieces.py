"""Pieces that touch or come too near never fuse in a print without an error or a repair."""

import io

import numpy as np
import pytest
import trimesh
from flat_patterns import grid, pattern_of
from shared_cases import shared_case

from fab import read_pattern
from fab.jobs.print_files import ThickFormat, make_thick
from fab.printing.thick_settings import thick_settings


def pieces(*corners):
    unit = np.array([[0, 0], [40, 0], [40, 40], [0, 40]])
    coords = np.concatenate([unit + corner for corner in corners])
    return pattern_of(coords, np.arange(len(coords)).reshape(-1, 4).tolist())


def printed(pattern, *changes, printer="prusa_mk4s"):
    settings = thick_settings(changes, printer, None)
    made = make_thick(
        pattern,
        "sheets",
        settings,
        print_with=settings.print_with(),
        formats=[ThickFormat.STL],
    )
    mesh = trimesh.load_mesh(io.BytesIO(made.files["sheets_thick.stl"]), file_type="stl")
    return made, mesh.body_count


def of_code(made, code):
    return [finding for finding in made.findings if finding.code == code]


KINDS = {
    "edge": pieces((0, 0), (40, 0)),
    "near": pieces((0, 0), (40.1, 0)),
    "corner": pieces((0, 0), (40, 40)),
    "overlap": pieces((0, 0), (30, 30)),
    "three": pieces((0, 0), (40, 0), (20, 40)),
    "common vertex": grid(2, 2, 40.0, without=[(0, 1), (1, 0)]),
}


@pytest.mark.parametrize("hinges", ["web", "film"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_printer_sets_pieces_apart(kind, hinges):
    pattern = KINDS[kind]
    made, bodies = printed(pattern, f"hinges.kind={hinges}")
    assert made.within_tolerance
    assert bodies == pattern.face_count
    (moved,) = of_code(made, "pieces-moved")
    assert "least_gap_mm = 0.3" in moved.text
    assert {finding.code for finding in made.findings} <= {
        "pieces-moved",
        "one-material",
        "first-layer-relief",
    }


@pytest.mark.parametrize("kind", ["edge", "corner", "three", "common vertex"])
def test_without_a_printer_pieces_that_touch_are_an_error(kind):
    made, _ = printed(KINDS[kind], printer=None)
    assert not made.within_tolerance
    assert "touch without a common crease" in of_code(made, "panels-touch")[0].text


def test_without_a_printer_pieces_that_are_near_are_a_warning():
    made, _ = printed(KINDS["near"], printer=None)
    assert made.within_tolerance
    assert "0.1 mm apart" in of_code(made, "panels-close")[0].text


def test_pieces_that_are_apart_stay_in_place():
    made, bodies = printed(pieces((0, 0), (40.3, 0)))
    assert {finding.code for finding in made.findings} <= {"first-layer-relief"}
    assert bodies == 2


def test_panels_of_one_piece_that_touch_in_a_corner_are_an_error():
    """Squares in a ring that is open where the first and the last touch in a corner."""
    ring = {(1, 1), (0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (2, 2)}
    every = {(column, row) for column in range(3) for row in range(4)}
    made, _ = printed(grid(3, 4, 40.0, without=every - ring), printer=None)
    assert "panels-touch" in {finding.code for finding in made.findings}
    assert not made.within_tolerance


def test_the_case_of_two_sheets_that_touch():
    made, bodies = printed(read_pattern(shared_case("touch2.fold"))[0])
    assert bodies == 2
    assert made.report["bounding_box_mm"]["print"] == pytest.approx([80.3, 40, 1.6])
