"""Picture of what was read from a file: its letters in colours, with the places of repairs."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np

from fab.errors import Finding, counted
from fab.formats.pattern_file import PatternFile
from fab.formats.strictness import is_repair
from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.canvas import Box, Canvas
from fab.viewing.drawing import FlatPlace, divided, draw_form, draw_pattern, size_text
from fab.viewing.scene import Scene
from fab.viewing.scene_builders import pattern_scene
from fab.viewing.shapes import sheet_shapes, sheet_triangles
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray

__all__ = ["reading_png_bytes"]

# Colour and name of each letter, in the order of the legend; borders are drawn over the others.
_LETTERS = {
    "M": ("#d62020", "mountain", "mountains"),
    "V": ("#2050d6", "valley", "valleys"),
    "F": ("#d0a000", "facet crease", "facet creases"),
    "U": ("#d030c0", "unassigned", "unassigned"),
    "J": ("#20a0a8", "join", "joins"),
    "C": ("#20a040", "cut", "cuts"),
    "B": ("#202020", "border", "borders"),
}
_REPAIR, _FACT = "#e07000", "#606060"
_WIDTH, _HEIGHT = 1600, 900
# Pixels from the left at which text begins, what a line of it holds, and how far lines are apart.
_TEXT, _LINE_LETTERS, _STEP = 1024, 80, 21.0
_MOST_LINES = 34
_RING_PIXELS = 6.0
# The pattern is what was read: it is larger than its folded form.
_FORM_SHARES = (0.36,)


def reading_png_bytes(read: PatternFile, title: str) -> bytes:
    """The picture, 1600 x 900 pixels: the pattern, the upper side seen, and its folded form where
    that is known; beside them counts and lengths by letter, size, unit, and the findings, numbered
    as they are marked in the pattern.

    Repairs and assumptions are orange, facts grey.
    """
    canvas = Canvas(_WIDTH, _HEIGHT)
    scene = pattern_scene(read.pattern, title)
    flat = _draw_form(canvas, Box(0, 0, _TEXT - 16, _HEIGHT), scene)
    ink = {letter: colour for letter, (colour, _, _) in _LETTERS.items()}
    size = size_text("flat", read.pattern.vertices_coords)
    _draw_marks(canvas, read, draw_pattern(canvas, flat, read.pattern, "", size, ink))
    _write_text(canvas, read, title)
    return canvas.png_bytes()


def _draw_form(canvas: Canvas, whole: Box, scene: Scene) -> Box:
    """Draw the folded form, where it is known; the box that is left for the pattern."""
    folded = scene.folded_coords
    if folded is None:
        return whole
    triangles = sheet_triangles(scene.pattern)
    shapes = sheet_shapes(folded, triangles)
    axes = best_view([shapes.corners], triangles.faces, upright=False)
    seen, coords = folded @ axes[:2].T, scene.pattern.vertices_coords
    (form,), flat = divided(whole, 1, seen, coords, _FORM_SHARES)
    draw_form(canvas, form, [shapes], "", size_text("folded", folded), axes=axes)
    return flat


def _draw_marks(canvas: Canvas, read: PatternFile, place: FlatPlace) -> None:
    """A ring at each place of a finding, and its number at the first of them."""
    turn = np.linspace(0, 2 * np.pi, 25)
    ring = _RING_PIXELS * np.column_stack([np.cos(turn), np.sin(turn)])
    sides = np.stack([ring[:-1], ring[1:]], axis=1)
    for number, finding in enumerate(read.findings, 1):
        if not finding.places:
            continue
        at = place.pixels(np.array(finding.places) - read.origin)
        colour = _colour(finding)
        canvas.lines((at[:, None, None] + sides).reshape(-1, 2, 2), colour, 1.0)
        x, y = (at[0] + [10, -12]).tolist()
        canvas.text(str(number), x, y, colour=colour, weight="bold", size=10)


def _colour(finding: Finding) -> str:
    return _REPAIR if is_repair(finding) else _FACT


def _write_text(canvas: Canvas, read: PatternFile, title: str) -> None:
    top = 45.0

    def write(text: str, colour: str = "black", size: float = 10.0, weight: str = "normal") -> None:
        nonlocal top
        canvas.text(text, _TEXT, top, colour=colour, size=size, weight=weight)
        top += _STEP * size / 10

    write(_short(title), size=14, weight="bold")
    width, depth = np.ptp(read.pattern.vertices_coords, axis=0)
    unit = f"1 unit of the file is {read.mm_per_unit:.6g} mm"
    write(f"{width:.6g} x {depth:.6g} mm, {unit}")
    write(counted(read.pattern.face_count, "face"))
    top += _STEP / 2
    for letter, text in _legend(read.pattern):
        write(f"\u2501\u2501  {letter}  {text}", _LETTERS[letter][0], 11.0)
    top += _STEP / 2
    for text, colour in _listed(read.findings):
        write(text, colour, 9.0)


def _short(title: str) -> str:
    return textwrap.shorten(title, 50, placeholder=" ...") if len(title) > 50 else title


def _legend(pattern: CreasePattern) -> list[tuple[str, str]]:
    """Letters that the pattern has, each with its count and length."""
    letters = pattern.edges_assignment
    ends = pattern.vertices_coords[pattern.edges_vertices]
    lengths: FloatArray = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    out = []
    for letter, (_, single, several) in _LETTERS.items():
        chosen = letters == letter
        if chosen.any():
            count = counted(int(chosen.sum()), single, several)
            out.append((letter, f"{count}, {lengths[chosen].sum():.6g} mm"))
    return out


def _listed(findings: Sequence[Finding]) -> list[tuple[str, str]]:
    """Lines of text about the findings with their colours, as many as there is room for."""
    if not findings:
        return [("nothing was repaired or assumed", _FACT)]
    lines: list[tuple[str, str]] = []
    for number, finding in enumerate(findings, 1):
        text = f"{number}  {finding.code}: {finding.text}"
        wrapped = textwrap.wrap(text, _LINE_LETTERS, subsequent_indent="    ", max_lines=4)
        if len(lines) + len(wrapped) > _MOST_LINES:
            lines.append((f"and {counted(len(findings) - number + 1, 'more finding')}", _FACT))
            break
        lines += [(line, _colour(finding)) for line in wrapped]
    return lines
