"""Styles of the lines of maps, and what they mean: different in print in grey as well."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fab.viewing.assembly.parts import Hold, Model
from fab.viewing.drawing import CREASE_INK
from fab.viewing.sketch import Area, Lines, Mark, Plan, Sketch, Words
from solver.vectors import FloatArray, IntArray

__all__ = ["DOT", "DRAWN", "OUTLINE_MM", "crease_lines", "legend", "seam_lines", "tab_lines"]

OUTLINE_MM = 0.3
# Letters of creases in the order in which they are drawn; the mark of a point, shape (4, 2).
DRAWN = "FJUMVC"
DOT = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
_SEAM_MM, _CREASE_MM, _TAB_MM = 0.5, 0.22, 0.15
_SEAM_INK, _TAB_INK = "#000000", "#555555"
_TAB_DASHES, _LEGEND_MM = (0.6, 0.4), 4.0
# Dashes are this share of creases, within bounds in mm.
_DASH_SHARE, _DASHES = 1 / 3, (0.5, 2.4)


def seam_lines(segments: FloatArray) -> Lines:
    """Seams, shape (n, 2, 2), on paper."""
    return Lines(segments, _SEAM_INK, _SEAM_MM)


def tab_lines(segments: FloatArray) -> Lines:
    """Sides of tabs, shape (n, 2, 2), on paper."""
    return Lines(segments, _TAB_INK, _TAB_MM, _TAB_DASHES)


def legend(letters: Sequence[str], model: Model, width_mm: float) -> Sketch:
    """What the lines of maps mean."""
    names = {
        "M": "mountain: fold away from you",
        "V": "valley: fold towards you",
        "F": "flat, not folded",
        "J": "flat, not folded",
        "U": "crease without direction",
        "C": "cut",
    }
    shown = [(letter, names[letter]) for letter in "MVFJUC" if letter in letters]
    if model.joints:
        shown.append(("", f"{model.seam}, with its number"))
    if any(len(piece.tabs) for piece in model.pieces):
        tongues = any(joint.hold is Hold.TONGUE for joint in model.joints)
        shown.append(("t", "tongue" if tongues else "tab"))
    if model.points:
        shown.append(("p", "point that is glued, with its number"))
    marks: list[Mark] = []
    x, row = 0.0, 0
    placed = []
    for letter, name in shown:
        wide = 19.0 + 1.38 * len(name)
        if x + wide > width_mm and x > 0:
            x, row = 0.0, row + 1
        placed.append((letter, name, x, row))
        x += wide
    height = _LEGEND_MM * (row + 1)
    for letter, name, x, row in placed:
        y = height - _LEGEND_MM * (row + 0.5)
        line = np.array([[[x, y], [x + 12.0, y]]])
        if letter == "":
            marks.append(seam_lines(line))
        elif letter == "p":
            marks.append(Area((line[0, 1] + 0.6 * DOT,), "#000000"))
        elif letter == "t":
            marks.append(tab_lines(line))
        else:
            marks.append(_styled(line, letter, _DASHES[1]))
        marks.append(Words(name, (x + 13.5, y), 2.5, across="start"))
    return Sketch((width_mm, height), tuple(marks))


def crease_lines(
    plan: Plan, coords: FloatArray, edges_vertices: IntArray, edges: dict[str, IntArray]
) -> list[Lines]:
    """Creases by their letter, numbers of edges, on paper; short ones have short dashes."""
    lines = {k: plan.on_paper(coords[edges_vertices[each]]) for k, each in edges.items()}
    folded = np.concatenate([lines["M"], lines["V"]])
    lengths = np.hypot(*(folded[:, 1] - folded[:, 0]).T)
    usual = float(np.median(lengths)) if len(lengths) else _DASHES[1]
    dash = float(np.clip(_DASH_SHARE * usual, *_DASHES))
    return [_styled(lines[letter], letter, dash) for letter in DRAWN if len(lines[letter])]


def _styled(lines: FloatArray, letter: str, dash_mm: float) -> Lines:
    """Creases in the style of their letter."""
    colour = CREASE_INK[letter]
    if letter == "M":
        gap = max(0.3 * dash_mm, 0.25)
        return Lines(lines, colour, 1.2 * _CREASE_MM, (dash_mm, gap, 0.15 * dash_mm, gap))
    if letter == "V":
        return Lines(lines, colour, _CREASE_MM, (0.5 * dash_mm, max(0.35 * dash_mm, 0.25)))
    if letter == "C":
        return Lines(lines, "#000000", OUTLINE_MM)
    if letter == "U":
        return Lines(lines, colour, _CREASE_MM)
    return Lines(lines, "#888888", 0.6 * _CREASE_MM, (0.2, 0.6))
