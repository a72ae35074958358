"""Drawings of a result page as SVG: crease patterns and sheets in layers, and the folded form.

Drawings have y upwards, SVG downwards: heights are turned around, nothing is mirrored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np

from fab.drawings.cut_paths import CutPaths
from fab.drawings.layer_colours import Colours
from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.drawing import CREASE_INK
from fab.viewing.scene import Scene
from solver.polygons import face_normals
from solver.vectors import FloatArray, IntArray, unit

__all__ = [
    "LOWER",
    "MOST_LINES",
    "UPPER",
    "Drawing",
    "crease_drawing",
    "form_svg",
    "sheet_drawing",
]

# Colours of the sides of a sheet.
UPPER, LOWER = "#f5d69e", "#9ebddb"
_EDGES = {
    "B": "outline",
    "M": "mountains",
    "V": "valleys",
    "F": "flat creases",
    "U": "unassigned creases",
    "C": "cuts",
    "J": "joins",
}
_SHADES = 6
# All sheets of a page have no more lines than this.
MOST_LINES = 15_000
# Dashes are of one line where the next begins on it, no further away, mm.
_ONE_LINE_MM = 8.0
_STRAIGHT_MM = 1e-3
_MARGIN = 0.02


@dataclass(frozen=True)
class Drawing:
    """An SVG element and its layers: by name, what they are called and their colour.

    note : what it does not show, empty where it shows everything.
    """

    svg: str
    layers: dict[str, tuple[str, str]]
    note: str = ""


def crease_drawing(pattern: CreasePattern, title: str) -> Drawing:
    """The crease pattern, with a layer for each assignment that occurs."""
    coords = pattern.vertices_coords
    low, high = coords.min(axis=0), coords.max(axis=0)
    layers, groups = {}, []
    for letter, name in _EDGES.items():
        colour = CREASE_INK[letter]
        lines = coords[pattern.edges_vertices[pattern.edges_assignment == letter]]
        if len(lines):
            layers[letter] = (name, colour)
            groups.append(_group(letter, colour, _lines_path(lines, high[1])))
    groups += ['<path class="lit-panels" d=""/>', '<path class="lit-creases" d=""/>']
    return Drawing(_svg((low[0], 0.0), high - low, groups, title), layers)


def sheet_drawing(
    paths: CutPaths, title: str, colours: Colours | None = None, most: int = MOST_LINES
) -> Drawing:
    """A sheet as it is cut, with a layer for each operation.

    most : of more lines, dashes are joined to the lines that they are on; where that is not enough
    only outlines are drawn. The drawing says so.
    """
    width, height = paths.size_mm
    chosen = colours or Colours()
    lines = [layer.segments for layer in paths.layers]
    note = ""
    if sum(map(len, lines)) > most:
        note = "Dashes are drawn as lines here; the files have them all."
        lines = [_lines_of_dashes(segments) for segments in lines]
        if sum(map(len, lines)) > most:
            note = "Only outlines are drawn here; the files have all lines."
            lines = [segments[:0] for segments in lines]
    layers, groups = {}, []
    for layer, segments in zip(paths.layers, lines, strict=True):
        colour, name = chosen.of(layer.operation).hex, layer.operation.value
        layers[name] = (name.lower(), colour)
        path = _lines_path(segments, height) + _rings_path(layer.outlines, height)
        path += _rings_path(layer.chains, height, end="")
        groups.append(_group(name, colour, path))
    return Drawing(_svg((0.0, 0.0), (width, height), groups, title), layers, note)


def form_svg(scene: Scene, axes: FloatArray, title: str) -> str:
    """The last state of a sheet, what is in front over the rest.

    axes : shape (3, 3), to the right, upwards and towards the viewer.
    """
    pattern, coords = scene.pattern, scene.states_coords[-1]
    right, up, toward = axes
    flat = coords @ np.stack([right, -up], axis=1)
    low, high = flat.min(axis=0), flat.max(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = face_normals(coords, pattern.faces_vertices, pattern.faces_offsets)
    facing = np.nan_to_num(normals @ toward)
    depth = np.add.reduceat(coords[pattern.faces_vertices] @ toward, pattern.faces_offsets[:-1])
    order = np.argsort(depth / np.diff(pattern.faces_offsets), kind="stable")
    light = np.abs(np.nan_to_num(normals @ unit(np.array([-0.3, -0.4, 0.9]))))
    shade = np.minimum((light * _SHADES).astype(int), _SHADES - 1)
    bounds = list(pairwise(pattern.faces_offsets.tolist()))
    parts = []
    for face in order.tolist():
        begin, end = bounds[face]
        ring = (flat[pattern.faces_vertices[begin:end]] - low).round(2).tolist()
        points = " ".join(f"{x:g},{y:g}" for x, y in ring)
        side = "u" if facing[face] > 0 else "l"
        parts.append(f'<polygon class="{side}{shade[face]}" points="{points}"/>')
    return _svg((0.0, 0.0), high - low, parts, title)


def shades_css() -> str:
    """Style rules of the faces of `form_svg`."""
    rules = []
    for side, colour in (("u", UPPER), ("l", LOWER)):
        parts = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        for shade in range(_SHADES):
            lit = 0.6 + 0.4 * shade / (_SHADES - 1)
            rules.append(
                f".{side}{shade}{{fill:rgb({','.join(str(round(lit * p)) for p in parts)})}}"
            )
    return "".join(rules)


def _svg(
    corner: tuple[float, float],
    size: tuple[float, float] | FloatArray,
    parts: list[str],
    title: str,
) -> str:
    (x, y), (width, height) = corner, size
    edge = _MARGIN * max(width, height, 1e-9)
    box = f"{x - edge:.6g} {y - edge:.6g} {width + 2 * edge:.6g} {height + 2 * edge:.6g}"
    inner = "".join(parts)
    return f'<svg viewBox="{box}" role="img" aria-label="{escape(title)}">{inner}</svg>'


def _group(layer: str, colour: str, path: str) -> str:
    return f'<g data-layer="{layer}" stroke="{colour}"><path d="{path}"/></g>'


def _rings_path(outlines: Sequence[FloatArray], height: float, end: str = "Z") -> str:
    rings = []
    for outline in outlines:
        points = (outline * [1.0, -1.0] + [0.0, height]).round(2).tolist()
        rings.append("M" + "L".join(f"{x:g},{y:g}" for x, y in points) + end)
    return "".join(rings)


def _lines_path(lines: FloatArray, height: float) -> str:
    """Lines, shape (n, 2, 2), to hundredths of a mm; each ends relative to where it begins."""
    hundredths: IntArray = np.rint(lines * [100.0, -100.0] + [0.0, 100.0 * height]).astype(np.int64)
    hundredths[:, 1] -= hundredths[:, 0]
    rows = (hundredths.reshape(-1, 4) / 100).tolist()
    return "".join(f"M{x:g} {y:g}l{dx:g} {dy:g}" for x, y, dx, dy in rows)


def _lines_of_dashes(segments: FloatArray) -> FloatArray:
    """The lines that runs of dashes are on, shape (m, 2, 2)."""
    if len(segments) < 2:
        return segments
    start, end = segments[:-1, 0], segments[:-1, 1]
    along = unit(end - start)
    onward = segments[1:] - end[:, None]
    off = np.abs(along[:, None, 0] * onward[..., 1] - along[:, None, 1] * onward[..., 0]).max(
        axis=1
    )
    ahead = (along[:, None] * onward).sum(axis=2)
    same = (off < _STRAIGHT_MM) & (ahead[:, 0] > 0) & (ahead[:, 0] < _ONE_LINE_MM)
    same &= ahead[:, 1] > ahead[:, 0]
    first = np.flatnonzero(np.concatenate([[True], ~same]))
    last = np.concatenate([first[1:] - 1, [len(segments) - 1]])
    return np.stack([segments[first, 0], segments[last, 1]], axis=1)
