"""Every line of a pattern is in the drawing, on its layer and with its whole length, once."""

from collections import defaultdict
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from line_soups import SQUARE, lengths, soup_of

from fab.drawings.cut_paths import Operation
from fab.errors import InvalidFile
from fab.formats.drawn.importer import pattern_of_lines
from fab.sheets.crease_styles import DashStyle, ScoreStyle
from fab.sheets.labels import text_lines
from fab.sheets.perforation import cut_piece
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.pieces import SheetSplit, split

SCORED = PerforationSettings(
    mountain=ScoreStyle(),
    valley=ScoreStyle(),
    flat=ScoreStyle(),
    unassigned=ScoreStyle(),
    margin_mm=1e-9,
)
BED = (600.0, 400.0)
# Rooms of creases up to this length are not cut.
SHORTEST = 0.0101


@st.composite
def sheets(draw):
    """A square with lines of any letter: through it, within it, and chains that end in it."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rows = list(SQUARE)
    for letter in random.choice(list("MVFUC"), draw(st.integers(1, 9))):
        chain = random.uniform(3, 97, (random.integers(2, 5), 2))
        if random.uniform() < 0.4:  # from the border
            chain[0, random.integers(2)] = random.choice([0.0, 100.0])
        rows += [(letter, *a, *b) for a, b in pairwise(chain)]
    try:
        return pattern_of_lines(soup_of(rows)).pattern
    except InvalidFile:  # mountains on valleys
        return None


def drawn(layers):
    """Lines of each operation, as shapes."""
    out = defaultdict(list)
    for layer in layers:
        out[layer.operation] += list(shapely.linestrings(layer.segments))
        out[layer.operation] += [shapely.LineString(chain) for chain in layer.chains]
        out[layer.operation] += [shapely.LinearRing(ring) for ring in layer.outlines]
    return out


@given(sheets())
def test_lengths_by_letter_are_those_by_operation(pattern):
    if pattern is None:
        return
    made, _ = split(pattern, SheetSplit(tabs="none"), BED)
    wanted = lengths(pattern)
    first, second = pattern.edges_faces.T
    apart = (second >= 0) & (pattern.faces_piece[first] != pattern.faces_piece[second])
    ends = pattern.vertices_coords[pattern.edges_vertices]
    twice = np.hypot(*(ends[:, 1] - ends[:, 0]).T)[apart].sum()
    found = defaultdict(float)
    for piece in made.pieces:
        lines = drawn(cut_piece(piece.pattern, SCORED).layers)
        for operation, shapes in lines.items():
            found[operation] += sum(shape.length for shape in shapes)
            union = shapely.union_all(shapes).length
            assert union == pytest.approx(sum(shape.length for shape in shapes), abs=1e-6)
    slack = SHORTEST * len(pattern.edges_vertices)
    pairs = {
        Operation.MOUNTAIN: wanted.get("M", 0.0),
        Operation.VALLEY: sum(wanted.get(letter, 0.0) for letter in "VFU"),
    }
    for operation, length in pairs.items():
        assert length - slack <= found[operation] <= length + 1e-6
    through = found[Operation.CUT] + found[Operation.HOLE]
    assert through == pytest.approx(wanted["B"] + wanted.get("C", 0.0) + twice)
    edges = np.concatenate([piece.edges for piece in made.pieces])
    assert set(np.arange(len(ends))) <= set(edges.tolist())


def test_slits_are_as_long_as_drawn_whatever_the_kerf_and_creases_have_their_style():
    rows = [*SQUARE, ("M", 50, 0, 50, 100), ("C", 70, 20, 70, 40), ("V", 0, 60, 30, 60)]
    pattern = pattern_of_lines(soup_of(rows)).pattern
    style = SCORED.model_copy(update={"valley": DashStyle(cut_mm=3.0, gap_mm=1.0)})
    made, _ = split(pattern, SheetSplit(), BED)
    (piece,) = made.pieces
    for kerf in (0.0, 0.15, 0.5):
        lines = drawn(cut_piece(piece.pattern, style, kerf).layers)
        cut = [line for line in lines[Operation.CUT] if line.geom_type == "LineString"]
        assert [line.length for line in cut] == pytest.approx([20.0])
        assert len(lines[Operation.VALLEY]) > 5
        low_x, low_y, high_x, high_y = shapely.union_all(lines[Operation.VALLEY]).bounds
        assert np.hypot(high_x - low_x, high_y - low_y) == pytest.approx(30.0 - kerf)


def test_labels_keep_clear_of_lines_that_end_in_their_face():
    """Two squares side by side, each with a slit through the place of its letter."""
    rows = []
    for x in (0, 120):
        rows += [(letter, a + x, b, c + x, d) for letter, a, b, c, d in SQUARE]
        rows += [("C", x + 5, 50, x + 95, 50), ("M", x + 20, 5, x + 20, 45)]
    pattern = pattern_of_lines(soup_of(rows)).pattern
    made, _ = split(pattern, SheetSplit(), BED)
    assert len(made.pieces) == 2
    for piece in made.pieces:
        (label,) = piece.labels
        letters = shapely.union_all(
            [
                shapely.LineString(ring)
                for ring in text_lines(label.text, label.height_mm, label.at, label.angle_deg)
            ]
        )
        edges = piece.pattern.vertices_coords[piece.pattern.edges_vertices]
        assert shapely.distance(letters, shapely.linestrings(edges)).min() > 0.05
