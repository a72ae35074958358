"""Findings about exactness: what is right passes, what is wrong is caught."""

from dataclasses import replace

import numpy as np
import pytest

from fab.errors import Severity
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.pattern.inspection import (
    Accuracy,
    inspect_accuracy,
    inspect_angles,
    inspect_crossings,
    measure_pattern,
)
from solver import Miura


@pytest.fixture
def pattern():
    mesh = Miura(columns=4, rows=4).grow().mesh
    return crease_pattern(mesh, develop(mesh), 10.0)


def codes(findings):
    return [finding.code for finding in findings]


def test_an_exact_sheet_passes(pattern):
    accuracy = measure_pattern(pattern)
    assert inspect_accuracy(accuracy, 1e-12) == []
    assert inspect_angles(pattern) == []


def test_a_vertex_out_of_place_is_caught_by_all_three(pattern):
    folded = pattern.folded_coords.copy()
    folded[12] += [0.01, 0.02, 0.03]
    found = inspect_accuracy(measure_pattern(replace(pattern, folded_coords=folded)), 1e-6)
    assert codes(found) == ["not-planar", "not-developable", "not-isometric"]


def test_a_face_off_the_plane_but_right_elsewhere_is_caught(pattern):
    flat = pattern.vertices_coords.copy()
    flat[0] += [0.01, 0.0]
    found = inspect_accuracy(measure_pattern(replace(pattern, vertices_coords=flat)), 1e-6)
    assert codes(found) == ["not-isometric"]


def test_a_face_without_area_is_caught(pattern):
    folded = pattern.folded_coords.copy()
    folded[pattern.faces_vertices[:4]] = folded[0] * 1.0
    folded[pattern.faces_vertices[1]] = folded[pattern.faces_vertices[2]]
    found = inspect_accuracy(measure_pattern(replace(pattern, folded_coords=folded)), 1e-6)
    assert "not-planar" in codes(found)


@pytest.mark.parametrize("change", [5.0, -0.01])
def test_a_wrong_fold_angle_is_caught_and_named(pattern, change):
    angle = pattern.edges_foldAngle.copy()
    crease = int(np.flatnonzero(angle)[3])
    angle[crease] += change
    (finding,) = inspect_angles(replace(pattern, edges_foldAngle=angle))
    assert finding.creases == (crease,)


def test_a_flipped_crease_is_caught_and_named(pattern):
    angle = pattern.edges_foldAngle.copy()
    crease = int(np.flatnonzero(angle)[5])
    angle[crease] *= -1
    (finding,) = inspect_angles(replace(pattern, edges_foldAngle=angle))
    assert finding.creases == (crease,)


def test_what_is_not_a_number_is_an_error():
    found = inspect_accuracy(Accuracy(float("nan"), 0.0, float("inf")), 1.0)
    assert codes(found) == ["not-planar", "not-isometric"]


def test_crossings_are_one_warning_that_counts_all_and_names_the_first():
    assert inspect_crossings(np.empty((0, 2), np.int64)) == []
    pairs = np.column_stack([np.arange(12), np.arange(12) + 20])
    (finding,) = inspect_crossings(pairs)
    assert (finding.code, finding.severity) == ("sheet-crosses-itself", Severity.WARNING)
    assert "12 crossing pairs" in finding.text
    assert "0 and 20" in finding.text
    assert finding.panels == (*range(10), *range(20, 30))
