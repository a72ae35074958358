"""Test card that finds the right values for a material on a machine.

It has tongues that can be folded, each on a crease of its own style: cuts grow to the right, gaps
upwards, around the material's starting values (the lengths are engraved as cut / gap). Below them
are a comb of slots, and a tab: the slot that holds it tightly is labelled with the kerf. Nothing is
corrected for the kerf, since the card is to measure it. Below all of it is engraved what it is cut
from, on which machine, and how it is read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from pydantic import ValidationError

from fab.drawings.cut_paths import CutPaths, Layer, Operation, joined
from fab.sheets.crease_cuts import cuts_along, unscaled_length
from fab.sheets.crease_styles import CreaseStyle, EngraveStyle, LatticeStyle
from fab.sheets.labels import text_lines, text_width
from fab.sheets.materials import Machine, Material, perforation_for
from fab.sheets.stroke_letters import letter_strokes
from solver.errors import InvalidValue
from solver.vectors import FloatArray

__all__ = ["coupon"]

# Shares of the starting values, the widest table first; the first that fits is taken.
_TABLES = ((0.5, 0.7, 1.0, 1.4, 2.0), (0.7, 1.0, 1.4), (1.0,))
_SPACE_MM = 4.0
_LETTER_MM = 2.5
_TONGUE_MM = 20.0
_TAB_MM = 10.0
_SLOTS = 9
# From line to line of the text, in heights of letters.
_PITCH = 1.7
# The two lengths of each kind of style that are tried.
_TRIED = {
    "dots": ("dot_mm", "pitch_mm"),
    "dashes": ("cut_mm", "gap_mm"),
    "dash_dot": ("cut_mm", "gap_mm"),
    "lattice": ("cut_mm", "gap_mm"),
}


@dataclass(frozen=True)
class _Block:
    """Layers within (0, 0) to `size`."""

    layers: tuple[Layer, ...]
    size: tuple[float, float]

    def at(self, x: float, y: float) -> list[Layer]:
        """The layers with the lower left corner at (x, y)."""
        return [layer.moved(np.eye(2), np.array([x, y])) for layer in self.layers]


def coupon(machine: Machine, material: Material, names: tuple[str, str] | None = None) -> CutPaths:
    """The test card on the bed, as large as need be, in the lower left corner of its margins.

    names : of the material and the machine, to be engraved; their descriptions where left out.

    For machines whose software perforates by itself the creases are whole lines, one for mountains
    and one for valleys: on them the software's own cut and skip lengths are tried. Raises
    `InvalidValue` where not even these two tongues fit the bed.
    """
    perforation = perforation_for(machine, material)
    styles = {Operation.MOUNTAIN: perforation.mountain, Operation.VALLEY: perforation.valley}
    beam, thickness = machine.beam, material.thickness_mm
    comb = (
        _comb(beam.x_mm, thickness)
        if beam.is_round
        else _above([_comb(beam.y_mm, thickness, "y"), _comb(beam.x_mm, thickness, "x")])
    )
    stock, cutter = names or (material.description, machine.description)
    texts = [f"{stock} on {cutter}.", *_instructions(styles)]
    if not beam.is_round:
        texts.append("Upright slots give the kerf along y, the others that along x.")
    room = machine.room_mm
    size = (0.0, 0.0)
    for shares in _TABLES:
        tables = [_table(letter, style, shares, material) for letter, style in styles.items()]
        for stacked in (_beside, _above):
            body = _above([comb, stacked(tables)])
            card = _framed(_above([_words(texts, body.size[0]), body]))
            size = card.size
            if size[0] <= room[0] and size[1] <= room[1]:
                corner = machine.margin_mm
                return CutPaths(joined(card.at(corner, corner)), machine.bed_mm, on_bed=True)
    bound = f"be at least {size[0]:.4g} x {size[1]:.4g} mm within its margins"
    cure = "Take a machine with a larger bed, or shorter starting values."
    raise InvalidValue("bed", f"{room[0]:g} x {room[1]:g} mm", bound, cure)


def _beside(blocks: Sequence[_Block]) -> _Block:
    """Blocks in a row, from left to right."""
    x, layers = 0.0, []
    for block in blocks:
        layers += block.at(x, 0)
        x += block.size[0] + _SPACE_MM
    return _Block(tuple(layers), (x - _SPACE_MM, max(block.size[1] for block in blocks)))


def _above(blocks: Sequence[_Block]) -> _Block:
    """Blocks in a column, from below upwards."""
    y, layers = 0.0, []
    for block in blocks:
        layers += block.at(0, y)
        y += block.size[1] + _SPACE_MM
    return _Block(tuple(layers), (max(block.size[0] for block in blocks), y - _SPACE_MM))


def _framed(block: _Block) -> _Block:
    """A block with the outline of the card around it."""
    width, height = block.size[0] + 2 * _SPACE_MM, block.size[1] + 2 * _SPACE_MM
    outline = np.array([[0, 0], [width, 0], [width, height], [0, height]])
    frame = Layer(Operation.CUT, outlines=(outline,))
    return _Block((*block.at(_SPACE_MM, _SPACE_MM), frame), (width, height))


def _table(
    letter: Operation, style: CreaseStyle, shares: Sequence[float], material: Material
) -> _Block:
    """Tongues with cuts of all shares (columns) by gaps of all shares (rows).

    Lengths that the style does not allow, such as dots as long as their pitch, are left out.
    """
    keys = _TRIED.get(style.kind)
    if keys is None:
        return _tongue(letter, style, f"{letter[0]} {style.kind}", _TONGUE_MM, material)
    base = style.model_dump()
    width = max(_TONGUE_MM, 2.5 * sum(base[key] for key in keys))
    rows = []
    for gap in shares:
        row = []
        for cut in shares:
            lengths = [round(s * base[key], 2) for s, key in zip((cut, gap), keys, strict=True)]
            label = f"{letter[0]} {lengths[0]:g}/{lengths[1]:g}"
            try:
                tried = type(style).model_validate(base | dict(zip(keys, lengths, strict=True)))
            except ValidationError:
                row.append(_Block((), (0.0, 0.0)))
            else:
                row.append(_tongue(letter, tried, label, width, material))
        rows.append(row)
    cell = max(tongue.size[0] for row in rows for tongue in row)
    return _above([_beside([replace(t, size=(cell, t.size[1])) for t in row]) for row in rows])


def _tongue(
    letter: Operation, style: CreaseStyle, label: str, wanted: float, material: Material
) -> _Block:
    """A tongue cut free on three sides, about `wanted` mm wide; the upper side is the crease."""
    length = unscaled_length(style, wanted)
    margin = material.perforation.margin_mm
    width = length + 2 * margin
    half = style.width_mm / 2 if isinstance(style, LatticeStyle) else 0.0
    bottom = 2 * _LETTER_MM
    middle = bottom + max(10.0, 3 * material.thickness_mm) + half
    top = middle + half
    crease = np.array([[[0, middle], [width, middle]]])
    free = np.array([[0, top], [0, bottom], [width, bottom], [width, top]])
    made = Operation.ENGRAVE if isinstance(style, EngraveStyle) else letter
    text_mm = text_width(label) * _LETTER_MM
    layers = (
        _text(label, _LETTER_MM, text_mm / 2),
        Layer(made, cuts_along(crease, style, margin).segments),
        Layer(Operation.CUT, chains=(free.astype(np.float64),)),
    )
    return _Block(layers, (max(width, text_mm), top + _SPACE_MM))


def _instructions(styles: Mapping[Operation, CreaseStyle]) -> Iterator[str]:
    """How the card is read, sentence by sentence."""
    for letter, style in styles.items():
        what = f"{letter[0]}: {letter.lower()}, {style.kind.replace('_', ' ')}"
        keys = _TRIED.get(style.kind)
        lengths = f", {' / '.join(key.removesuffix('_mm') for key in keys)} in mm" if keys else ""
        yield f"{what}{lengths}."
    yield (
        "Fold every tongue to and fro: the values of one that folds cleanly and does not tear are "
        "those of the material."
        if any(style.kind in _TRIED for style in styles.values())
        else "Set cut and skip of the machine's software, fold the tongues, and cut again."
    )
    yield (
        "Push the tab into the slots from the left: the number at the first that holds it tightly "
        "is the kerf in mm."
    )


def _words(texts: Sequence[str], width: float) -> _Block:
    """Texts in lines of up to a width, each text in a line of its own at least."""
    lines: list[str] = []
    for text in texts:
        line = ""
        for word in text.split():
            longer = f"{line} {word}".strip()
            if line and text_width(longer) * _LETTER_MM > width:
                lines.append(line)
                longer = word
            line = longer
        lines.append(line)
    y = _PITCH * _LETTER_MM * (len(lines) - 1)
    chains: list[FloatArray] = []
    for number, line in enumerate(lines):
        # all lines stand on their base, whatever letters reach below it
        strokes = [stroke * _LETTER_MM for stroke in letter_strokes(line)]
        base = np.array([0.0, y - number * _PITCH * _LETTER_MM])
        chains += [stroke + base for stroke in strokes]
    size = (max(text_width(line) for line in lines) * _LETTER_MM, y + _LETTER_MM)
    return _Block((Layer(Operation.ENGRAVE, chains=tuple(chains)),), size)


def _text(text: str, height_mm: float, middle: float) -> Layer:
    """A line of text in the strip below what it names, its middle at x = `middle`."""
    return Layer(Operation.ENGRAVE, chains=text_lines(text, height_mm, (middle, _LETTER_MM), 0.0))


def _comb(kerf_mm: float, thickness_mm: float, axis: Literal["", "x", "y"] = "") -> _Block:
    """Slots for the tab, each shorter than the last by twice a step of kerf, and the tab.

    A slot of length L comes out as L + kerf, a tab of width w as w - kerf: it fits where
    kerf = (w - L) / 2. Sheets thinner than two kerfs are held by slits.

    axis : the one along which slots and the width of the tab are, where kerfs differ; otherwise
        slots are upright, and so is the tab.
    """
    step = max(0.02, round(kerf_mm / 4, 2))
    wide = thickness_mm if thickness_mm > 2 * kerf_mm and thickness_mm >= 1 else 0.0
    slits, slots, words = [], [], []
    pitch = max(_TAB_MM if axis == "x" else 2.0, wide) + 6.0
    for i in range(_SLOTS):
        kerf = i * step
        x, length = i * pitch + 3.0, _TAB_MM - 2 * kerf
        low = 2 * _LETTER_MM
        along = np.array([length, 0.0] if axis == "x" else [0.0, length])
        across = np.array([0.0, wide] if axis == "x" else [wide, 0.0])
        begin = np.array([x, low])
        if wide:
            ring = np.array([begin, begin + across, begin + across + along, begin + along])
            slots.append(ring[::-1] if axis != "x" else ring)
        else:
            slits.append([begin, begin + along])
        words.append(_text(f"{kerf:.2f}", _LETTER_MM * 0.8, x + along[0] / 2))
    tab = _tab_outline()
    tab = tab[::-1, ::-1] if axis == "y" else tab  # its width along y
    tab = tab + np.array([_SLOTS * pitch + _SPACE_MM, 1.0])
    cut = Layer(Operation.CUT, np.array(slits, np.float64).reshape(-1, 2, 2), (tab,))
    holes = Layer(Operation.HOLE, outlines=tuple(slots))
    size = (float(tab[:, 0].max()), max(float(tab[:, 1].max()), 2 * _LETTER_MM + _TAB_MM))
    return _Block((*words, *([holes] if slots else []), cut), size)


def _tab_outline() -> FloatArray:
    """A tab on a handle with a shoulder on each side, lower left at the origin, shape (8, 2)."""
    shoulder, low, high = 4.0, 7.0, 14.0
    left, right, width = shoulder, shoulder + _TAB_MM, _TAB_MM + 2 * shoulder
    corners = [
        [0, 0],
        [width, 0],
        [width, low],
        [right, low],
        [right, high],
        [left, high],
        [left, low],
        [0, low],
    ]
    return np.array(corners)
