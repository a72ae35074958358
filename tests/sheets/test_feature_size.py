"""Faces too narrow for the beam, and the scale that helps."""

import re
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import fan, grid, pattern_of, triangles
from hypothesis import example, given
from hypothesis import strategies as st

from fab.errors import Severity
from fab.pattern.crease_pattern import scaled
from fab.sheets.crease_styles import DashStyle, LatticeStyle
from fab.sheets.feature_size import enlargement, face_widths_mm, narrow_faces
from fab.sheets.perforation import cut_layers, perforate
from fab.sheets.perforation_settings import PerforationSettings

FACTOR = re.compile(r"([0-9.e+]+) times as large")


def test_widths_of_known_faces():
    square = grid(2, 1, 7.0)
    assert face_widths_mm(square) == pytest.approx([7, 7])
    right = pattern_of([[0, 0], [3, 0], [0, 4]], [[0, 1, 2]])
    assert face_widths_mm(right) == pytest.approx([2.4])  # over the longest side
    sheared = pattern_of([[0, 0], [9, 0], [29, 1], [20, 1]], [[0, 1, 2, 3]])
    assert face_widths_mm(sheared) == pytest.approx([9 / np.hypot(20, 1)])
    hexagon = fan(6, 10.0)
    assert face_widths_mm(hexagon) == pytest.approx([10 * np.sqrt(0.75)] * 6)


@given(st.integers(0, 1000), st.floats(1e-6, 1e3))
def test_the_factor_that_is_named_is_the_least_in_three_digits(seed, kerf_mm):
    pattern = triangles(seed)
    found = narrow_faces(pattern, kerf_mm)
    narrow = face_widths_mm(pattern) <= kerf_mm
    assert len(found) == narrow.any()
    if not found:
        return
    assert f"{narrow.sum()} of {pattern.face_count} faces" in found[0].text
    (factor,) = map(float, FACTOR.findall(found[0].text))
    assert not narrow_faces(scaled(pattern, factor=factor), kerf_mm)
    assert narrow_faces(scaled(pattern, factor=0.99 * factor), kerf_mm)


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        (1, "1 of 1 faces is not wider than the kerf (8 mm): face 0 is 7 mm across, and nothing"),
        (2, "2 of 2 faces are not wider than the kerf (8 mm), the narrowest, 0, is 7 mm across:"),
    ],
)
def test_narrow_faces_are_named_in_singular_and_plural(columns, text):
    (finding,) = narrow_faces(grid(columns, 1, 7.0), 8.0)
    assert finding.text.startswith(text)


def test_a_knife_without_kerf_cuts_any_face():
    assert narrow_faces(grid(2, 2, 1e-9), 0.0) == []


@given(st.floats(1e-9, 1e9), st.floats(1e-9, 1e9))
@example(0.01, 2.0)
def test_enlarged_lengths_exceed_what_is_needed_by_one_percent_at_most(needed, present):
    factor = float(enlargement(np.array([needed]), np.array([present])))
    assert needed < factor * present <= needed * 1.0101


@pytest.mark.parametrize("seed", range(5))
def test_creases_have_cuts_on_a_sheet_that_is_as_large_as_is_advised(seed):
    style = DashStyle(cut_mm=3.0, gap_mm=1.0)
    settings = PerforationSettings(margin_mm=9.0, mountain=style, valley=style, unassigned=style)
    pattern = triangles(seed, size=100.0)

    def uncut(factor):
        _, findings = perforate(scaled(pattern, factor=factor), settings)
        return [f for f in findings if f.code == "crease-too-short"]

    factor = max(float(FACTOR.findall(f.text)[0]) for f in uncut(1.0))
    assert uncut(0.99 * factor)
    assert not uncut(factor)


@pytest.mark.parametrize("seed", range(5))
def test_lattices_bend_on_a_sheet_that_is_as_large_as_is_advised(seed):
    style = LatticeStyle(cut_mm=6.0, gap_mm=2.0, rows=2, pitch_mm=0.01)
    settings = PerforationSettings(margin_mm=1.0, mountain=style, valley=style, unassigned=style)
    pattern = triangles(seed, size=60.0)

    def unbending(factor):
        _, findings = perforate(scaled(pattern, factor=factor), settings)
        return [f for f in findings if f.code in ("lattice-rigid", "crease-too-short")]

    assert "lattice-rigid" in {f.code for f in unbending(1.0)}
    factor = max(float(FACTOR.findall(f.text)[0]) for f in unbending(1.0))
    assert unbending(0.99 * factor)
    assert not unbending(factor)


def test_lattices_of_one_slit_are_an_error_where_nothing_bends():
    """A slit of 6 mm and the next in its row, 8 mm on, need a room of 10 mm to be fitted."""
    style = LatticeStyle(cut_mm=6.0, gap_mm=2.0, rows=3, pitch_mm=0.5)
    settings = PerforationSettings(margin_mm=1.0, valley=style)

    def found(width, height):
        pattern = grid(2, 1, 1.0)
        pattern = replace(pattern, vertices_coords=pattern.vertices_coords * [width, height])
        _, findings = cut_layers(pattern, settings)
        return [(f.code, f.severity, f.creases) for f in findings]

    (valley,) = np.flatnonzero(grid(2, 1, 1.0).edges_assignment == "V").tolist()
    assert found(30.0, 12.001) == []
    assert found(30.0, 12.0) == [("lattice-rigid", Severity.ERROR, (valley,))]
    assert found(30.0, 2.0) == [("crease-too-short", Severity.ERROR, (valley,))]
    # where others bend it is a warning
    pattern = grid(2, 2, 1.0)
    pattern = replace(pattern, vertices_coords=pattern.vertices_coords * [30.0, 10.0])
    (finding,) = cut_layers(pattern, settings)[1]
    upright = np.ptp(pattern.vertices_coords[pattern.edges_vertices][..., 1], axis=1) > 0
    assert set(finding.creases) == set(
        np.flatnonzero(upright & (pattern.edges_assignment == "V")).tolist()
    )
    assert finding.severity == Severity.WARNING
