"""Files of crease patterns: FOLD, SVG, DXF, CP, OPX, ORI and OBJ.

Each format has two kinds. In the one, small files are read as lines, at a high rate, and one of
some dozens is imported. In the other, as in "svg-import", drawings of all sizes get faults of lines
first and of files then; they are imported, read again, written, and what is written is read.
"""

from __future__ import annotations

import importlib
import json
import zlib
from functools import cache, partial
from pathlib import Path

import flat_patterns
import numpy as np
from formats import drawing_dialects
from formats.svg import dialects as svg_dialects
from fuzz.oracle import options_of, require_all_drawn, require_repeats, require_sound
from fuzz.seeds import KINDS as IMPORTED
from fuzz.seeds import fuzzed, undated
from fuzz.trials import Kind
from fuzz.written_faults import with_file_faults
from helpers import ROOT

from fab.formats.drawn.importer import pattern_of_lines
from fab.formats.fold.writer import fold_bytes
from fab.formats.meshes.obj import obj_bytes
from fab.formats.reading import read_pattern_file
from fab.pattern.crease_pattern import CreasePattern

__all__ = ["PATTERN_KINDS"]

Random = np.random.Generator
_READERS = {
    "svg": "svg.reader:read_svg",
    "dxf": "dxf.reader:read_dxf",
    "cp": "oripa.cp:read_cp",
    "opx": "oripa.opx:read_opx",
    "ori": "oripa.ori:read_ori",
}
# How many files that are read as lines there are to one that is imported, and of how many lines.
_IMPORTED, _MOST_LINES = 40, 100
# Larger files are left to imports.
_LARGEST_SEED = 25_000


def _small() -> list[CreasePattern]:
    return [
        flat_patterns.grid(2, 1, 20.0),
        flat_patterns.fan(3, 30.0),
        flat_patterns.grid(2, 2, 15.0, cuts=[(4, 5)]),
        flat_patterns.triangles(5, count=4),
    ]


@cache
def _seeds(kind: str) -> tuple[bytes, ...]:
    """Whole files of a kind: of all dialects, small, and those that tests hold."""
    found = [path.read_bytes() for path in sorted((ROOT / "tests").rglob(f"*.{kind}"))]
    for pattern in _small():
        coords = pattern.vertices_coords[pattern.edges_vertices]
        letters, angles = pattern.edges_assignment, pattern.edges_foldAngle
        if kind == "svg":
            lines = svg_dialects.Source(coords, letters, angles)
            found += [dialect(lines).text.encode() for dialect in svg_dialects.DIALECTS.values()]
        elif kind == "fold":
            found.append(fold_bytes(pattern, "fuzz"))
            found.append(_of_lines(pattern))
        elif kind == "obj":
            flat = np.column_stack(
                [pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))]
            )
            found.append(obj_bytes(flat, pattern.faces_vertices, pattern.faces_offsets, "fuzz"))
        else:
            source = drawing_dialects.Source("fuzz", coords, letters)
            found += [
                undated(dialect, source)
                for dialect in drawing_dialects.DIALECTS.values()
                if dialect.ending in _endings(kind)
            ]
    return tuple(data for data in found if len(data) <= _LARGEST_SEED)


def _endings(kind: str) -> tuple[str, ...]:
    return (".ori", ".orh") if kind == "ori" else (f".{kind}",)


def _of_lines(pattern: CreasePattern) -> bytes:
    """A FOLD file without faces and angles, of which each edge has vertices of its own."""
    ends = pattern.vertices_coords[pattern.edges_vertices].reshape(-1, 2)
    document = {
        "file_spec": 1.2,
        "frame_classes": ["creasePattern"],
        "vertices_coords": ends.round(6).tolist(),
        "edges_vertices": np.arange(len(ends)).reshape(-1, 2).tolist(),
        "edges_assignment": pattern.edges_assignment.tolist(),
    }
    return json.dumps(document).encode()


def _faulty(kind: str, random: Random) -> bytes:
    seeds = _seeds(kind)
    return with_file_faults(random, kind, seeds[int(random.integers(len(seeds)))])


def _lines(kind: str, path: Path, random: Random) -> str:
    """Read a drawing as lines, and import some of those of few lines."""
    options = options_of(random)
    module, _, function = _READERS[kind].partition(":")
    read = getattr(importlib.import_module(f"fab.formats.{module}"), function)
    soup = read(path, options)
    lines = soup.lines_coords
    assert lines.shape[1:] == (2, 2), "lines have two ends"
    assert np.isfinite(lines).all(), "lines are finite"
    assert len(soup.lines_assignment) == len(soup.lines_foldAngle) == len(lines), "rows agree"
    assert len(soup.lines_element) == len(lines), "rows agree"
    if len(lines):
        numbers = soup.lines_element
        assert 0 <= numbers.min() <= numbers.max() < len(soup.elements), "lines are of elements"
    if random.integers(_IMPORTED) == 0 and len(lines) <= _MOST_LINES:
        require_sound(pattern_of_lines(soup, options), planar=True)
    return f"{zlib.crc32(lines.tobytes())} {soup.lines_assignment.tolist()} {soup.findings}"


def _pattern(path: Path, random: Random) -> str:
    """Read a file that is small."""
    read = read_pattern_file(path, options_of(random))
    require_sound(read, planar=False)
    counts = read.pattern.counts()
    return f"{counts} {zlib.crc32(read.pattern.vertices_coords.tobytes())} {read.findings}"


def _import(path: Path, random: Random) -> str:
    """Read a file in full; one of three is read, written, and read again."""
    options = options_of(random)
    read = read_pattern_file(path, options)
    faces = path.suffix == ".obj" or (path.suffix == ".fold" and b"faces_" in path.read_bytes())
    require_sound(read, planar=not faces)
    if random.integers(3) == 0:
        require_all_drawn(path, read, options)
        require_repeats(path, read, options)
    return f"{read.pattern.counts()} {read.findings}"


def _unnamed(random: Random) -> bytes:
    """A file of any format, and what its beginning could be taken for."""
    kind = (*_READERS, "fold", "obj")[int(random.integers(len(_READERS) + 2))]
    data = _faulty(kind, random)
    if random.integers(3) == 0:
        part = data[: int(random.integers(1, 40))]
        data = part * int(random.integers(1, 400)) + data
    elif random.integers(3) == 0:
        heads = (b"<!a>", b"\n", b" ", b"<?xml ?>", b"# a\n", b"999\n1\n", b"1 1 1 1 1 ", b"g a\n")
        data = heads[int(random.integers(len(heads)))] * int(random.integers(1, 2000)) + data
    return data


def _kinds() -> list[Kind]:
    shares = {"cp": 8.0, "ori": 8.0, "opx": 4.0, "no-ending": 2.0}
    found = [
        Kind(
            name,
            f"fuzzed.{name}",
            partial(_faulty, name),
            partial(_lines, name) if name in _READERS else _pattern,
            share=shares.get(name, 2.0),
        )
        for name in (*_READERS, "fold", "obj")
    ]
    found += [
        Kind(
            f"{name}-import",
            f"fuzzed.{name}",
            partial(fuzzed, name),
            _import,
            seconds=20.0,
            memory_mb=500.0,
            opens=True,
        )
        for name in IMPORTED
    ]
    return [*found, Kind("no-ending", "fuzzed", _unnamed, _pattern)]


PATTERN_KINDS = tuple(_kinds())
