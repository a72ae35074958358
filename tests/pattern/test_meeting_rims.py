"""Rims of several sheets: which vertices meet, in which order, and how far apart they are."""

import json

import numpy as np
import pytest
import shapely
from flat_patterns import strips

import fab
from fab.drawings.cut_paths import Operation
from fab.formats.fold.writer import fold_bytes
from fab.jobs.grow import unfolded
from fab.jobs.job import SheetSize
from fab.jobs.seam_report import seam_findings
from fab.pattern.meeting_rims import meeting_rims
from fab.sheets.perforation import perforate
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.rim_points import rim_marks
from solver import QuadMesh
from solver.relaxed_fit import joined


def test_a_sheet_meets_itself_nowhere():
    assert meeting_rims(strips(0.0, 4)) is None
    assert meeting_rims(strips(50.0, 2, 2)) is None  # far apart


@pytest.mark.parametrize("gap", [0.0, 0.05])
def test_vertices_of_two_rims_are_numbered_one_after_another(gap):
    pattern = strips(gap, 2, 3)
    found = meeting_rims(pattern)
    assert len(found.vertices) == 7
    np.testing.assert_allclose(found.gaps_mm, 20 * gap, atol=1e-9)
    assert found.touching.all() == (gap == 0)
    assert found.sheets.tolist() == [[0, 1]] * 7
    folded = pattern.folded_coords[found.vertices]
    # along the rim, from one end to the other
    steps = np.linalg.norm(np.diff(folded[:, 0], axis=0), axis=1)
    assert steps.max() < 1.5 * np.linalg.norm(folded[1, 0] - folded[0, 0])
    # edges that face each other begin and end at the vertices that meet
    first, second = pattern.edges_vertices[found.edges].swapaxes(0, 1)
    assert (first[:, 0] == found.vertices[:, 0]).all()
    assert (second[:, 1] == found.vertices[:, 1]).all()
    seam = found.vertices_seam(len(pattern.vertices_coords))
    assert sorted(seam[seam > 0].tolist()) == sorted([*range(1, 8)] * 2)


def test_sheets_are_glued_to_those_before_them():
    found = meeting_rims(strips(0.0, 2, 2, 2))
    assert found.sheets.tolist() == [[0, 1]] * 7 + [[1, 2]] * 7
    report = found.report()
    assert [row["number"] for row in report["numbers"]] == list(range(1, 15))
    assert report["numbers"][7]["sheets"] == [2, 3]
    assert (report["points"], report["points_touching"]) == (14, 14)
    assert report["points_gap_max_mm"] == 0


def test_findings_say_how_far_rims_are_apart():
    (finding,) = seam_findings(meeting_rims(strips(0.05, 2, 3)))
    assert "together at 7 numbered points" in finding.text
    assert "0 of them touch, others are up to 1 mm apart. All along the seam" in finding.text
    (finding,) = seam_findings(meeting_rims(strips(0.0, 1, 1)))
    assert "7 of them touch" in finding.text


def test_distances_along_a_seam_are_those_from_the_other_rim():
    """A flat sheet's rim of 5 vertices, and another's of 3, half a unit beside it and below."""
    first = [[[x, y, 0.0] for x in (0, 1, 2, 3, 4)] for y in (9, 0)]
    second = [[[x, y, -0.3] for x in (0, 2, 4)] for y in (-0.4, -9)]
    meshes = [QuadMesh.from_rows(rows) for rows in (first, second)]
    pattern = unfolded(joined(meshes), SheetSize(scale_mm_per_unit=10.0))[1]
    found = meeting_rims(pattern)
    assert len(found.vertices) == 3
    np.testing.assert_allclose(found.gaps_mm, 5.0)
    np.testing.assert_allclose(found.rim_gaps_mm, 5.0)  # of those between too
    assert len(found.rim_gaps_mm) == 8
    report = found.report()
    assert report["rim_gap_mean_mm"] == pytest.approx(5.0)
    assert report["rim_vertices"] == 8


def test_numbers_are_in_the_file_and_on_both_sheets(tmp_path):
    pattern = strips(0.0, 2, 3)
    document = json.loads(fold_bytes(pattern, "strips"))
    found = meeting_rims(pattern)
    assert (
        document["quadfold:vertices_seam"]
        == found.vertices_seam(len(document["vertices_coords"])).tolist()
    )
    assert "quadfold:vertices_seam" not in json.loads(fold_bytes(strips(0.0, 4), "one"))
    (tmp_path / "strips.fold").write_bytes(fold_bytes(pattern, "strips"))
    again, findings = fab.read_pattern(tmp_path / "strips.fold")
    assert not findings
    assert meeting_rims(again).vertices.tolist() == found.vertices.tolist()
    marks = rim_marks(pattern, found)
    plain, _ = perforate(pattern, PerforationSettings())
    paths, _ = perforate(pattern, PerforationSettings(), marks=marks)
    engraved, *rest = paths.layers
    assert engraved.operation is Operation.ENGRAVE
    for one, other in zip(rest, plain.layers, strict=True):
        np.testing.assert_array_equal(one.segments, other.segments)
    assert len(engraved.chains) >= 14  # each number on either sheet, and on no crease
    low = np.concatenate([ring for layer in rest for ring in layer.outlines]).min(axis=0)
    assert low == pytest.approx([0, 0])
    creases = shapely.multilinestrings(np.concatenate([layer.segments for layer in rest[:2]]))
    assert not any(shapely.intersects(creases, shapely.linestrings(r)) for r in engraved.chains)
