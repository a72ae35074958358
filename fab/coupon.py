"""Which test card finds the right values for a material on a machine?

Tongues that can be folded, each on a crease of its own style: cuts grow to the right, gaps upwards,
around the material's starting values (the lengths are engraved as cut / gap). Below them a comb of
slots, and a tab: the slot that holds it tightly is labelled with the kerf. Nothing is corrected for
kerf here: that is what the card is to tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fab.materials import Machine, Material, Style, perforation_for
from fab.paths import CutPaths, Layer, Operation, joined
from solver.errors import InvalidValue
from solver.vectors import FloatArray

__all__ = ["coupon"]

# Shares of the starting values, the widest table first; the first one that fits is taken.
_TABLES = ((0.5, 0.7, 1.0, 1.4, 2.0), (0.7, 1.0, 1.4), (1.0,))
_SPACE_MM = 4.0
_LETTER_MM = 2.5
_TONGUE_MM = 20.0
_TAB_MM = 10.0
_SLOTS = 9


@dataclass(frozen=True)
class _Block:
    """Layers within (0, 0) to `size`."""

    layers: tuple[Layer, ...]
    size: tuple[float, float]

    def at(self, x: float, y: float) -> list[Layer]:
        return [layer.moved(np.eye(2), np.array([x, y])) for layer in self.layers]


def coupon(machine: Machine, material: Material) -> CutPaths:
    """The test card, as large as need be and within the bed's margins.

    For machines whose software perforates by itself the creases are whole lines, one of each
    letter: there the software's own cut and skip lengths are tried. Raises `InvalidValue` where
    not even one tongue of each letter fits the bed.
    """
    perforation = perforation_for(machine, material)
    styles = {Operation.MOUNTAIN: perforation.mountain, Operation.VALLEY: perforation.valley}
    comb = _comb(machine.kerf_mm, material.thickness_mm)
    room = machine.room_mm
    size = (0.0, 0.0)
    for shares in _TABLES:
        tables = [_table(letter, style, shares, material) for letter, style in styles.items()]
        for stacked in (_beside, _above):
            card = _framed(_above([comb, stacked(tables)]))
            size = card.size
            if size[0] <= room[0] and size[1] <= room[1]:
                return CutPaths(joined(card.layers), size)
    bound = f"be at least {size[0]:.4g} x {size[1]:.4g} mm within its margins"
    cure = "Take a machine with a larger bed, or shorter starting values."
    raise InvalidValue("bed", f"{room[0]:g} x {room[1]:g} mm", bound, cure)


def _beside(blocks: Sequence[_Block]) -> _Block:
    x, layers = 0.0, []
    for block in blocks:
        layers += block.at(x, 0)
        x += block.size[0] + _SPACE_MM
    return _Block(tuple(layers), (x - _SPACE_MM, max(block.size[1] for block in blocks)))


def _above(blocks: Sequence[_Block]) -> _Block:
    y, layers = 0.0, []
    for block in blocks:
        layers += block.at(0, y)
        y += block.size[1] + _SPACE_MM
    return _Block(tuple(layers), (max(block.size[0] for block in blocks), y - _SPACE_MM))


def _framed(block: _Block) -> _Block:
    width, height = block.size[0] + 2 * _SPACE_MM, block.size[1] + 2 * _SPACE_MM
    outline = np.array([[0, 0], [width, 0], [width, height], [0, height]])
    frame = Layer(Operation.CUT, outlines=(outline,))
    return _Block((*block.at(_SPACE_MM, _SPACE_MM), frame), (width, height))


def _table(letter: Operation, style: Style, shares: Sequence[float], material: Material) -> _Block:
    """Tongues with cuts of all shares (columns) by gaps of all shares (rows)."""
    kind = style["kind"]
    first, second = {
        "dots": ("dot_mm", "pitch_mm"),
        "dashes": ("cut_mm", "gap_mm"),
        "dash_dot": ("cut_mm", "gap_mm"),
        "lattice": ("cut_mm", "gap_mm"),
    }.get(str(kind), ("", ""))
    if not first:
        return _tongue(letter, style, f"{letter[0]} {kind}", _TONGUE_MM, material)
    base = (float(style[first]), float(style[second]))
    width = max(_TONGUE_MM, 2.5 * sum(base))
    tongues = []
    for gap in shares:
        for cut in shares:
            tried = {**style, first: round(cut * base[0], 2), second: round(gap * base[1], 2)}
            label = f"{letter[0]} {tried[first]:g}/{tried[second]:g}"
            tongues.append(_tongue(letter, tried, label, width, material))
    cell = max(tongue.size[0] for tongue in tongues)
    cells = [replace(tongue, size=(cell, tongue.size[1])) for tongue in tongues]
    count = len(shares)
    return _above([_beside(cells[i : i + count]) for i in range(0, len(cells), count)])


def _tongue(
    letter: Operation, style: Style, label: str, wanted: float, material: Material
) -> _Block:
    """A tongue cut free on three sides; the fourth, above, is the crease. About `wanted` wide."""
    marks, length = _marks(style, wanted)
    margin = material.perforation.margin_mm
    width = length + 2 * margin
    half = float(np.ptp(marks[..., 1])) / 2 if len(marks) else 0.0
    bottom = 2 * _LETTER_MM
    middle = bottom + max(10.0, 3 * material.thickness_mm) + half
    top = middle + half
    free = np.array([[0, top], [0, bottom], [width, bottom], [width, top]])
    made = Operation.ENGRAVE if style["kind"] == "engrave" else letter
    words = tuple(_text_outlines(label, _LETTER_MM, (0, _LETTER_MM / 2), 0.0))
    text_width = max(float(outline[:, 0].max()) for outline in words)
    layers = (
        Layer(Operation.ENGRAVE, outlines=words),
        Layer(made, marks + np.array([margin, middle])),
        Layer(Operation.CUT, np.stack([free[:-1], free[1:]], axis=1)),
    )
    return _Block(layers, (max(width, text_width), top + _SPACE_MM))


def _marks(style: Style, wanted: float) -> tuple[FloatArray, float]:
    """Cuts of a style along the x axis from 0 on, shape (n, 2, 2), and how far they go."""
    kind = style["kind"]
    if kind == "none":
        return np.empty((0, 2, 2)), wanted
    if kind in ("score", "engrave"):
        spans = np.array([[0.0, wanted]])
    elif kind == "dots":
        dot, pitch = float(style["dot_mm"]), float(style["pitch_mm"])
        spans = _whole([dot], [max(pitch - dot, dot)], wanted)
    elif kind == "dash_dot":
        gap = float(style["gap_mm"])
        spans = _whole([float(style["cut_mm"]), float(style["dot_mm"])], [gap, gap], wanted)
    else:
        spans = _whole([float(style["cut_mm"])], [float(style["gap_mm"])], wanted)
    length = float(spans[-1, 1])
    rows, pitch = (1, 0.0)
    if kind == "lattice":
        rows, pitch = int(style["rows"]), float(style["pitch_mm"])
    out = []
    for row in range(rows):
        x = spans if row % 2 == 0 else _between(spans)
        out.append(np.stack([x, np.full_like(x, (row - (rows - 1) / 2) * pitch)], axis=-1))
    return np.concatenate(out), length


def _whole(cuts: Sequence[float], gaps: Sequence[float], wanted: float) -> FloatArray:
    """From and to of cuts and gaps in turn, two periods at least, about `wanted` long, (n, 2).

    They begin and end with the first cut, and have exactly the lengths that the label names.
    """
    count = max(2, round((wanted - cuts[0]) / (sum(cuts) + sum(gaps))))
    period = [length for pair in zip(cuts, gaps, strict=True) for length in pair]
    ends = np.concatenate([[0.0], np.cumsum([*period * count, cuts[0]])])
    return ends.reshape(-1, 2)


def _between(spans: FloatArray) -> FloatArray:
    """The row next to `spans` in a lattice: cuts across its gaps, shortened at both ends."""
    gap = float(spans[1, 0] - spans[0, 1])
    middles = spans.mean(axis=1)
    starts = np.concatenate([spans[:1, 0], middles + gap / 2])
    ends = np.concatenate([middles - gap / 2, spans[-1:, 1]])
    return np.column_stack([starts, ends])[ends > starts]


def _comb(kerf_mm: float, thickness_mm: float) -> _Block:
    """Slots for the tab, each shorter than the last by twice a step of kerf, and the tab.

    A slot of length L comes out as L + kerf, a tab of width w as w - kerf: it fits where
    kerf = (w - L) / 2. Sheets thinner than two kerfs are held by slits.
    """
    step = max(0.02, round(kerf_mm / 4, 2))
    wide = thickness_mm if thickness_mm > 2 * kerf_mm and thickness_mm >= 1 else 0.0
    slits, slots, words = [], [], []
    pitch = max(8.0, wide + 6.0)
    for i in range(_SLOTS):
        kerf = i * step
        x, length = i * pitch + 3.0, _TAB_MM - 2 * kerf
        low = 2 * _LETTER_MM
        if wide:
            high = low + length
            slots.append(np.array([[x, low], [x + wide, low], [x + wide, high], [x, high]]))
        else:
            slits.append([[x, low], [x, low + length]])
        words += _text_outlines(f"{kerf:.2f}", _LETTER_MM * 0.8, (x - 3.0, _LETTER_MM / 2), 0.0)
    x, low, shoulder = _SLOTS * pitch + _SPACE_MM, 1.0, 4.0
    tab = np.array(
        [
            [0, 0],
            [_TAB_MM + 2 * shoulder, 0],
            [_TAB_MM + 2 * shoulder, 7],
            [_TAB_MM + shoulder, 7],
            [_TAB_MM + shoulder, 14],
            [shoulder, 14],
            [shoulder, 7],
            [0, 7],
        ]
    ) + np.array([x, low])
    cut = Layer(Operation.CUT, np.array(slits).reshape(-1, 2, 2), (*slots, tab))
    size = (float(tab[:, 0].max()), max(float(tab[:, 1].max()), 2 * _LETTER_MM + _TAB_MM))
    return _Block((Layer(Operation.ENGRAVE, outlines=tuple(words)), cut), size)


def _text_outlines(
    text: str, height_mm: float, at: tuple[float, float], angle_deg: float
) -> list[FloatArray]:
    """Closed outlines of letters, the first one's lower left corner at `at`, each (m, 2)."""
    from matplotlib.textpath import TextPath

    path = TextPath((0, 0), text, size=height_mm / 0.73)  # capitals of the font are 0.73 high
    turn = np.radians(angle_deg)
    onto = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    polygons = [np.asarray(polygon) for polygon in path.to_polygons()]
    return [polygon[:-1] @ onto + np.array(at) for polygon in polygons if len(polygon) > 3]
