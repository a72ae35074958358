"""Title of a sheet: its name, material and machine, and a scale bar, engraved beside the pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.drawings.cut_paths import CutPaths, Layer, Operation, joined
from fab.sheets.labels import text_lines, text_width
from solver.vectors import FloatArray

__all__ = ["titled"]

# Heights of letters that are tried, mm, and lengths of the scale bar.
_LETTERS_MM = (4.0, 3.0, 2.0)
_BARS_MM = (100.0, 50.0, 20.0)
# From line to line, in heights of letters; half of the bar's end strokes, and a space, likewise.
_PITCH = 1.8
_TICK = 0.5
_SPACE = 1.5
# Places tried along each side of the sheet, and the least distance between two, mm.
_PLACES = 120
_STEP_MM = 1.0


@dataclass(frozen=True)
class _Block:
    """Lines within (0, 0) to `size`, each of shape (m, 2)."""

    lines: tuple[FloatArray, ...]
    size: tuple[float, float]


def titled(
    paths: CutPaths, texts: Sequence[str], margin_mm: float, gap_mm: float
) -> CutPaths | None:
    """The sheet with texts and a scale bar where nothing else is; None where there is no room.

    Letters are as large as there is room for, up to 4 mm, and no smaller than 2 mm; the bar is 100,
    50 or 20 mm long. They stay `margin_mm` away from the edges of the sheet, and `gap_mm` from all
    other lines and from the pieces within them. Of the places that are free the lowest is taken.
    """
    taken = _taken(paths)
    for letter in _LETTERS_MM:
        for block in _blocks(texts, letter):
            at = _free_place(block.size, paths.size_mm, taken, margin_mm, gap_mm)
            if at is not None:
                lines = tuple(line + at for line in block.lines)
                layer = Layer(Operation.ENGRAVE, chains=lines)
                return CutPaths(joined([*paths.layers, layer]), paths.size_mm, paths.on_bed)
    return None


def _taken(paths: CutPaths) -> NDArray[np.object_]:
    """What is on a sheet: pieces, and lines that are in none."""
    pieces = [
        shapely.Polygon(ring)
        for layer in paths.layers
        if layer.operation is Operation.CUT
        for ring in layer.outlines
    ]
    others: list[shapely.Geometry] = []
    for layer in paths.layers:
        others += list(shapely.linestrings(layer.segments)) if len(layer.segments) else []
        others += [shapely.LineString(chain) for chain in layer.chains]
        if layer.operation is not Operation.CUT:
            others += [shapely.Polygon(ring) for ring in layer.outlines]
    lines = np.array(others, dtype=object)
    within = np.zeros(len(lines), bool)
    if pieces and len(lines):
        found = shapely.STRtree(pieces).query(lines, predicate="covered_by")[0]
        within[found] = True
    return np.array([*pieces, *lines[~within]], dtype=object)


def _blocks(texts: Sequence[str], letter: float) -> Iterator[_Block]:
    """The title one text below the other, with shorter and shorter bars, and then in one row."""
    for bar in _BARS_MM:
        yield _column(texts, letter, bar)
    for bar in _BARS_MM:
        yield _row(texts, letter, bar)


def _column(texts: Sequence[str], letter: float, bar: float) -> _Block:
    """Texts over each other, the scale bar below them."""
    lines = list(_scale_bar(letter, bar))
    y = _PITCH * letter
    for text in reversed(texts):
        width = text_width(text) * letter
        lines += text_lines(text, letter, (width / 2, y + letter / 2), 0.0)
        y += _PITCH * letter
    return _boxed(lines)


def _row(texts: Sequence[str], letter: float, bar: float) -> _Block:
    """The scale bar and the texts beside each other."""
    lines = list(_scale_bar(letter, bar))
    x = float(max(line[:, 0].max() for line in lines))
    for text in texts:
        x += _SPACE * letter
        width = text_width(text) * letter
        lines += text_lines(text, letter, (x + width / 2, letter / 2), 0.0)
        x += width
    return _boxed(lines)


def _scale_bar(letter: float, bar: float) -> Iterator[FloatArray]:
    """A bar with strokes at both ends, and its length to the right of it."""
    middle, tick = letter / 2, _TICK * letter
    ends = [[0.0, middle - tick], [0.0, middle + tick], [0.0, middle]]
    others = [[bar, middle], [bar, middle + tick], [bar, middle - tick]]
    yield np.array([*ends, *others])
    text = f"{bar:g} mm"
    width = text_width(text) * letter
    yield from text_lines(text, letter, (bar + letter + width / 2, middle), 0.0)


def _boxed(lines: Sequence[FloatArray]) -> _Block:
    """Lines moved so that their box is at the origin."""
    every = np.concatenate(lines)
    low, high = every.min(axis=0), every.max(axis=0)
    width, height = (high - low).tolist()
    return _Block(tuple(line - low for line in lines), (width, height))


def _free_place(
    size: tuple[float, float],
    sheet: tuple[float, float],
    taken: NDArray[np.object_],
    margin: float,
    gap: float,
) -> FloatArray | None:
    """The lowest, and of these the leftmost place for a box of that size, shape (2,)."""
    room = np.array(sheet) - 2 * margin - np.array(size)
    if (room < 0).any():
        return None
    steps = [np.linspace(0, r, int(min(_PLACES, r / _STEP_MM)) + 1) + margin for r in room.tolist()]
    x, y = (axis.ravel() for axis in np.meshgrid(*steps))
    boxes = shapely.box(x - gap, y - gap, x + size[0] + gap, y + size[1] + gap)
    hit = np.zeros(len(boxes), bool)
    if len(taken):
        hit[np.unique(shapely.STRtree(taken).query(boxes, predicate="intersects")[0])] = True
    free = np.flatnonzero(~hit)
    return np.array([x[free[0]], y[free[0]]]) if len(free) else None
