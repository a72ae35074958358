"""Whole files of each kind that faults are put into."""

from __future__ import annotations

import json
from functools import cache

import ezdxf
import flat_patterns
import numpy as np
from formats import drawing_dialects
from formats.svg import dialects as svg_dialects
from fuzz.drawn_faults import Drawn, with_faults
from fuzz.written_faults import with_file_faults
from helpers import PATTERNS

from fab.formats.fold.reader import read_fold
from fab.formats.fold.writer import fold_bytes
from fab.formats.meshes.obj import obj_bytes
from fab.pattern.crease_pattern import CreasePattern, crease_pattern
from fab.pattern.development import develop
from solver import Miura

__all__ = ["KINDS", "fuzzed", "undated"]

KINDS = ("svg", "dxf", "cp", "opx", "ori", "fold", "obj")
_LARGEST_SEED = 400


@cache
def patterns() -> tuple[CreasePattern, ...]:
    """Patterns of all sorts: published, of triangles, with holes and pieces, over themselves."""
    found = [read_fold(path).pattern for path in sorted(PATTERNS.glob("*.fold"))]
    mesh = Miura(columns=5, rows=4).grow().mesh
    found += [
        crease_pattern(mesh, develop(mesh), 20.0),
        flat_patterns.fan(7, 50.0),
        flat_patterns.grid(4, 3, 20.0, without=[(1, 1)]),
        flat_patterns.grid(3, 3, 20.0, cuts=[(5, 6), (9, 10)]),
        flat_patterns.triangles(3),
        flat_patterns.triangles(5, count=12),
        flat_patterns.turned_strip(9, 0.9),
        flat_patterns.turned_strip(14, 1.4),
    ]
    return tuple(pattern for pattern in found if len(pattern.edges_vertices) <= _LARGEST_SEED)


@cache
def drawings() -> tuple[Drawn, ...]:
    """Lines of patterns that do not lie over themselves."""
    found = [svg_dialects.lines_of(name) for name in svg_dialects.NAMES]
    out = [Drawn(one.coords, one.letters, one.angles) for one in found]
    for pattern in patterns():
        coords = pattern.vertices_coords[pattern.edges_vertices]
        out.append(Drawn(coords, pattern.edges_assignment, pattern.edges_foldAngle))
    square = np.array([[0, 0], [100, 0], [100, 100], [0, 100]], float)
    sides = np.stack([square, np.roll(square, -1, axis=0)], axis=1)
    out += [Drawn(sides, np.full(4, "B"), np.zeros(4))] * 4
    return tuple(one for one in out if len(one.coords) <= _LARGEST_SEED)


def _of(random, choices):
    return choices[int(random.integers(len(choices)))]


def _svg(random) -> bytes:
    drawn = with_faults(random, _of(random, drawings()))
    lines = svg_dialects.Source(drawn.coords, drawn.letters, drawn.angles)
    dialect = _of(random, list(svg_dialects.DIALECTS.values()))
    return dialect(lines).text.encode()


def _drawing(random, kind: str) -> bytes:
    drawn = with_faults(random, _of(random, drawings()))
    named = [
        dialect for dialect in drawing_dialects.DIALECTS.values() if dialect.ending[1:] == kind
    ]
    source = drawing_dialects.Source("fuzz", drawn.coords, drawn.letters)
    return undated(_of(random, named), source)


def undated(dialect: drawing_dialects.Dialect, source: drawing_dialects.Source) -> bytes:
    """The file of a dialect, the same whenever it is written."""
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        return dialect.write(source)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = False


def _fold(random) -> bytes:
    if random.integers(3) == 0:
        document = json.loads(fold_bytes(_of(random, patterns()), "fuzz"))
        if random.integers(3) == 0:
            del document["faces_vertices"]
        return json.dumps(document).encode()
    drawn = with_faults(random, _of(random, drawings()))
    ends = drawn.coords.reshape(-1, 2)
    points, place = (ends, np.arange(len(ends)))
    if random.integers(4):
        points, place = np.unique(ends, axis=0, return_inverse=True)
    if random.integers(5) == 0:  # upright, as others save it
        points = np.column_stack([points[:, 0], np.zeros(len(points)), points[:, 1]])
    document = {
        "file_spec": 1.1,
        "vertices_coords": points.tolist(),
        "edges_vertices": place.reshape(-1, 2).tolist(),
        "edges_assignment": drawn.letters.tolist(),
        "edges_foldAngle": drawn.angles.tolist(),
    }
    if random.integers(2):
        del document["edges_foldAngle"]
    return json.dumps(document).encode()


def _obj(random) -> bytes:
    pattern = _of(random, patterns())
    coords = np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])
    if pattern.folded_coords is not None and random.integers(2):
        coords = pattern.folded_coords.copy()
    if random.integers(3) == 0:
        coords = coords[:, [0, 2, 1]]
    if random.integers(3) == 0:
        coords = coords + random.normal(size=coords.shape) * 10.0 ** random.uniform(-15, 1)
    if random.integers(5) == 0:
        coords = coords * 10.0 ** random.uniform(-30, 30)
    return obj_bytes(coords, pattern.faces_vertices, pattern.faces_offsets, "fuzz")


def fuzzed(kind: str, random: np.random.Generator) -> bytes:
    """A file of a kind, by random numbers."""
    while True:
        try:
            if kind in ("fold", "obj", "svg"):
                data = {"fold": _fold, "obj": _obj, "svg": _svg}[kind](random)
            else:
                data = _drawing(random, kind)
            return with_file_faults(random, kind, data)
        except Exception:  # a dialect cannot write such numbers: other ones are taken
            continue
