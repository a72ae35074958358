"""Picture of what was read from a file: its letters in colours, with the places of repairs."""

from __future__ import annotations

import io
import textwrap
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from fab.errors import Finding, counted
from fab.formats.pattern_file import PatternFile
from fab.formats.strictness import is_repair
from fab.outputs import plain_title
from fab.pattern.crease_pattern import CreasePattern
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
_INCHES = (16.0, 9.0)
_DPI = 100
# Share of the width that is for text, and what it holds.
_TEXT = 0.36
_LINE_LETTERS = 80
_MOST_LINES = 34
_STEP = 0.0235


def reading_png_bytes(read: PatternFile, title: str) -> bytes:
    """The picture, 1600 x 900 pixels: the pattern, the upper side seen; beside it counts and
    lengths by letter, size, unit, and the findings, numbered as they are marked in the pattern.

    Repairs and assumptions are orange, facts grey.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=_INCHES, dpi=_DPI)
    FigureCanvasAgg(figure)
    plane: Any = figure.add_axes((0.045, 0.07, 1 - _TEXT - 0.075, 0.86))
    _draw_pattern(plane, read.pattern)
    _draw_marks(plane, read)
    plane.set_aspect("equal")
    plane.margins(0.04)
    plane.autoscale_view()
    plane.set_xlabel("mm")
    _write_text(figure, read, title)
    stream = io.BytesIO()
    with warnings.catch_warnings():  # letters that the font has not are boxes
        warnings.filterwarnings("ignore", message="Glyph")
        figure.savefig(stream, format="png", metadata={"Software": "quadfold"})
    return stream.getvalue()


def _draw_pattern(plane: Any, pattern: CreasePattern) -> None:
    from matplotlib.collections import LineCollection

    width = min(1.6, 60 / np.sqrt(len(pattern.edges_vertices)))
    for letter, (colour, _, _) in _LETTERS.items():
        chosen = pattern.edges_assignment == letter
        lines = pattern.vertices_coords[pattern.edges_vertices[chosen]]
        plane.add_collection(LineCollection(lines, colors=colour, linewidths=width))


def _draw_marks(plane: Any, read: PatternFile) -> None:
    """A ring at each place of a finding, and its number at the first of them."""
    for number, finding in enumerate(read.findings, 1):
        if not finding.places:
            continue
        places = np.array(finding.places) - read.origin
        colour = _colour(finding)
        plane.scatter(*places.T, s=90, facecolors="none", edgecolors=colour, zorder=5)
        plane.annotate(
            str(number),
            places[0],
            xytext=(7, 7),
            textcoords="offset points",
            color=colour,
            weight="bold",
            zorder=6,
        )


def _colour(finding: Finding) -> str:
    return _REPAIR if is_repair(finding) else _FACT


def _write_text(figure: Any, read: PatternFile, title: str) -> None:
    left, height = 1 - _TEXT, 0.95

    def write(text: str, colour: str = "black", size: float = 10.0, weight: str = "normal") -> None:
        nonlocal height
        figure.text(
            left,
            height,
            plain_title(text),
            color=colour,
            size=size,
            weight=weight,
            va="top",
            parse_math=False,
        )
        height -= _STEP * size / 10

    write(_short(title), size=14, weight="bold")
    width, depth = np.ptp(read.pattern.vertices_coords, axis=0)
    unit = f"1 unit of the file is {read.mm_per_unit:.6g} mm"
    write(f"{width:.6g} x {depth:.6g} mm, {unit}")
    write(counted(read.pattern.face_count, "face"))
    height -= _STEP / 2
    for letter, text in _legend(read.pattern):
        write(f"\u2501\u2501  {letter}  {text}", _LETTERS[letter][0], 11.0)
    height -= _STEP / 2
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
