"""What must hold of every file that is read, whatever is in it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from fab.formats import reading
from fab.formats.fold.writer import fold_bytes
from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file

__all__ = ["options_of", "require_all_drawn", "require_repeats", "require_sound"]

# Over the drawing.
_ROUNDING = 1e-9
# Findings of lines that are not in the pattern.
_LEFT_OUT = {"page-frame", "line-outside", "zero-length-line", "zero-length-edge"}


def options_of(random: np.random.Generator) -> ReadOptions:
    """How a file is read, most often by default."""
    options = ReadOptions()
    if random.integers(3) == 0:
        options = replace(
            options,
            strict=bool(random.integers(8) == 0),
            mm_per_unit=[None, 1.0, 25.4][random.integers(3)],
            merge_mm=[None, None, 0.5, 5.0][random.integers(4)],
            border=["drawn", "hull"][random.integers(2)],
            inner_border=["refuse", "cut"][random.integers(2)],
            fold_deg=[None, 90.0][random.integers(2)],
            frame=[None, None, None, 1, 2][random.integers(5)],
        )
    elif random.integers(2):
        options = replace(options, inner_border="cut", border="hull")
    return options


def require_sound(read: PatternFile, *, planar: bool) -> None:
    """Raise `AssertionError` where a pattern is none."""
    pattern = read.pattern
    coords, pairs, faces = pattern.vertices_coords, pattern.edges_vertices, pattern.edges_faces
    letters, angles, offsets = (
        pattern.edges_assignment,
        pattern.edges_foldAngle,
        pattern.faces_offsets,
    )
    assert np.isfinite(coords).all(), "coordinates are finite"
    assert np.abs(coords.min(axis=0)).max() == 0.0, "the lower left corner is the origin"
    assert len(np.unique(pairs)) == len(coords), "vertices are those of edges"
    assert pairs.min() >= 0, "edges join vertices"
    assert (pairs[:, 0] != pairs[:, 1]).all(), "edges join two vertices"
    assert len(np.unique(np.sort(pairs, axis=1), axis=0)) == len(pairs), "edges are unique"
    assert np.isin(letters, list("BMVFUCJ")).all(), "letters are those of FOLD"
    assert ((letters == "B") == (faces[:, 1] < 0)).all(), "borders have one face"
    assert np.isfinite(angles).all(), "fold angles are finite"
    assert (np.abs(angles) <= 180.0).all(), "fold angles are up to 180 degrees"
    assert (angles[letters == "M"] <= 0).all(), "mountains are negative"
    assert (angles[letters == "V"] >= 0).all(), "valleys are positive"
    assert (angles[np.isin(letters, list("BFCJ"))] == 0).all(), "others are flat"
    assert pattern.face_count >= 1, "there is a face"
    assert (np.diff(offsets) >= 3).all(), "faces have three corners"
    assert offsets[-1] == len(pattern.faces_vertices), "faces are complete"
    assert faces.max() < pattern.face_count, "faces of edges are faces"
    if planar:
        _require_planar(pattern)
    for title, coords in read.states:
        assert coords.shape == (len(pattern.vertices_coords), 3), title


def _require_planar(pattern) -> None:
    ends = pattern.vertices_coords[pattern.edges_vertices]
    size = float(np.hypot(*np.ptp(ends.reshape(-1, 2), axis=0)))
    shapes = shapely.linestrings(ends)
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    pairs = pattern.edges_vertices
    keep = first < second
    keep &= (pairs[first][:, :, None] != pairs[second][:, None, :]).all(axis=(1, 2))
    for a, b in zip(first[keep].tolist(), second[keep].tolist(), strict=True):
        common = shapely.intersection(shapes[a], shapes[b])
        near = [shapely.distance(common, shapely.points(point)) for point in (*ends[a], *ends[b])]
        assert min(near) <= _ROUNDING * size, f"edges {a} and {b} cross"
        assert shapely.length(common) <= _ROUNDING * size, f"edges {a} and {b} overlap"


def require_all_drawn(path: Path, read: PatternFile, options: ReadOptions) -> None:
    """Every line of a drawing is in the pattern, or a finding names why it is not."""
    codes = {finding.code for finding in read.findings}
    if path.suffix[1:] in ("fold", "obj") or codes & _LEFT_OUT:
        return
    import importlib

    module, function = reading._DRAWINGS[path.suffix]
    soup = getattr(importlib.import_module(f"fab.formats.{module}"), function)(path, options)
    scale = soup.mm_per_unit or options.mm_per_unit or 1.0
    drawn = soup.lines_coords * scale
    drawn = drawn - drawn.reshape(-1, 2).min(axis=0)
    ends = read.pattern.vertices_coords[read.pattern.edges_vertices]
    size = float(np.hypot(*np.ptp(drawn.reshape(-1, 2), axis=0)))
    near = 4 * (options.merge_mm or 1e-3 * size) + _ROUNDING * size
    tree = shapely.STRtree(shapely.linestrings(ends))
    share = np.array([0.1, 0.5, 0.9])[:, None, None]
    points = (drawn[None, :, 0] + share * (drawn[:, 1] - drawn[:, 0])).reshape(-1, 2)
    _, distance = tree.query_nearest(shapely.points(points), return_distance=True)
    assert distance.max(initial=0) <= near, f"a line is lost: {distance.max():g} mm away, {near:g}"
    if "border-hull" not in codes and "island-joined" not in codes:
        tree = shapely.STRtree(shapely.linestrings(drawn))
        _, distance = tree.query_nearest(shapely.points(ends.mean(axis=1)), return_distance=True)
        assert distance.max(initial=0) <= near, f"a line is new: {distance.max():g} mm away"


def require_repeats(path: Path, read: PatternFile, options: ReadOptions) -> None:
    """Read again it is the same; and what is written of it is read as it is."""
    data = fold_bytes(read.pattern, read.title, read.states)
    again = read_pattern_file(path, options)
    assert fold_bytes(again.pattern, again.title, again.states) == data, "read twice it differs"
    assert again.findings == read.findings, "read twice its findings differ"
    written = path.with_name("written.fold")
    written.write_bytes(data)
    back = read_pattern_file(written, replace(options, frame=None, strict=False))
    first, second = read.pattern, back.pattern
    assert first.counts() == second.counts(), f"written {first.counts()}, read {second.counts()}"
    for name in ("vertices_coords", "edges_vertices", "faces_vertices", "faces_offsets"):
        assert np.array_equal(getattr(first, name), getattr(second, name)), f"written: {name}"
    for name in ("edges_faces", "edges_assignment", "edges_foldAngle"):
        assert np.array_equal(getattr(first, name), getattr(second, name)), f"written: {name}"
