"""Patterns that go from FOLD through drawings and back keep every crease, letter and fold angle."""

from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import triangles
from helpers import PATTERNS
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import sheets

from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions
from fab.jobs.conversion import convert
from fab.jobs.reading import read_any
from fab.outputs import write
from fab.pattern.crease_pattern import crease_pattern, scaled
from fab.pattern.development import develop
from fab.pattern.overlap import overlapping_faces

# What a format says instead of a letter.
SAYS = {".svg": {}, ".dxf": {}, ".cp": {"U": "F", "J": "F"}}
# A file of ours has nine digits or more: ends that are one are nearer than this.
EXACT = ReadOptions(merge_mm=1e-6, inner_border="cut")


@st.composite
def lettered(draw):
    """Triangles with all letters, and fold angles of any size."""
    pattern = triangles(draw(st.integers(0, 10_000)), draw(st.integers(4, 40)))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    inner = pattern.edges_faces[:, 1] >= 0
    count = len(inner)
    letters = np.where(inner, random.choice(list("MVFUCJ"), count), "B")
    sign = np.select([letters == "M", letters == "V"], [-1.0, 1.0], 0.0)
    size = np.where(random.random(count) < 0.3, 180.0, random.uniform(1, 180, count))
    return replace(pattern, edges_assignment=letters, edges_foldAngle=sign * size)


@st.composite
def grown(draw):
    """Sheets that were grown, 200 mm long, whose faces lie beside each other."""
    mesh = draw(sheets())
    pattern = scaled(crease_pattern(mesh, develop(mesh), 1.0), width_mm=200.0)
    found = overlapping_faces(
        pattern.vertices_coords, pattern.faces_vertices, pattern.faces_offsets, pattern.edges
    )
    assume(not len(found))
    return replace(pattern, folded_coords=None)


def through(pattern, endings, folder, options):
    """The pattern after files of these endings in turn, each read again."""
    read = PatternFile("sheet", pattern, (), ())
    for ending in endings:
        path = folder / f"sheet{ending}"
        write(convert(read, path), folder)
        read = read_any([path], options)
    return read.pattern


def rows(pattern, letters=None):
    """Lines, each with its lower end first, letters and fold angles in an order of their own."""
    ends = pattern.vertices_coords[pattern.edges_vertices]
    ends = np.round(ends - ends.min(axis=(0, 1)), 5) + 0.0
    swap = (ends[:, 0] - ends[:, 1]) @ [1.0, 1e-3] > 0
    ends[swap] = ends[swap, ::-1]
    order = np.lexsort(ends.reshape(-1, 4).T)
    letters = pattern.edges_assignment if letters is None else letters
    return ends[order], letters[order].tolist(), pattern.edges_foldAngle[order]


def assert_same(back, pattern, ending):
    letters = pattern.edges_assignment
    for letter, other in SAYS[ending].items():
        letters = np.where(letters == letter, other, letters)
    ends, found, angles = rows(back)
    wanted, expected, folds = rows(pattern, letters)
    assert found == expected
    assert ends == pytest.approx(wanted, abs=1e-4)
    assert back.face_count == pattern.face_count
    if ending == ".svg":
        assert angles == pytest.approx(folds, abs=1e-6)
    else:
        assert set(np.abs(angles)) <= {0.0, 180.0}
    assert (np.sign(angles) == np.sign(folds)).all()


@pytest.mark.parametrize("ending", SAYS)
@given(data=st.data())
def test_random_triangles_come_back(tmp_path_factory, ending, data):
    pattern = data.draw(lettered())
    if ending == ".cp":  # cuts are borders there: those around a face make a hole of it
        letters = pattern.edges_assignment
        pattern = replace(pattern, edges_assignment=np.where(letters == "C", "F", letters))
    folder = tmp_path_factory.mktemp("round")
    assert_same(through(pattern, [".fold", ending, ".fold"], folder, EXACT), pattern, ending)


@pytest.mark.parametrize("ending", SAYS)
@given(data=st.data())
def test_grown_sheets_come_back(tmp_path_factory, ending, data):
    pattern = data.draw(grown())
    folder = tmp_path_factory.mktemp("round")
    assert_same(through(pattern, [".fold", ending, ".fold"], folder, EXACT), pattern, ending)


@pytest.mark.parametrize("ending", SAYS)
@pytest.mark.parametrize("name", sorted(path.stem for path in PATTERNS.glob("*.fold")))
def test_published_patterns_come_back_without_options(name, ending, tmp_path):
    """As users convert them; straight runs of one letter and angle become single creases."""
    whole = read_any([PATTERNS / f"{name}.fold"]).pattern
    first = through(whole, [ending], tmp_path, ReadOptions(inner_border="cut"))
    again = through(first, [".fold", ending, ".fold"], tmp_path, ReadOptions(inner_border="cut"))
    assert_same(again, first, ending)
    for letter in "MVB":
        assert length(first, letter) == pytest.approx(length(whole, letter), rel=1e-6)


def length(pattern, letter) -> float:
    ends = pattern.vertices_coords[pattern.edges_vertices]
    own = pattern.edges_assignment == letter
    return float(np.hypot(*(ends[own, 1] - ends[own, 0]).T).sum())
