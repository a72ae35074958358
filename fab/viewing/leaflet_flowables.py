"""What is put on the pages of a leaflet for each of its blocks, by reportlab."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from xml.sax.saxutils import escape

from fab.viewing.leaflet import WIDTH_MM, Block, Facts, Heading, NewPage, Row, Step, Table, Text
from fab.viewing.print_fonts import BOLD, PLAIN, printable, text_width_mm
from fab.viewing.sketch import Sketch
from fab.viewing.sketch_print import draw_sketch

__all__ = ["SMALL", "flowables", "paragraph", "styles"]

# Sizes of fonts, in points.
SMALL, _TEXT = 7.5, 9.0
_NUMBER_MM, _WORDS_MM = 9.0, 72.0
_BETWEEN_MM = 3.0
# Between facts and the names of those beside them.
_APART_MM = 4.0


def styles() -> dict[str, Any]:
    """Styles of text, by what it is."""
    from reportlab.lib.styles import ParagraphStyle

    plain = {"fontName": PLAIN, "splitLongWords": 1}
    return {
        "title": ParagraphStyle(
            "title", fontName=BOLD, fontSize=15, leading=18, spaceAfter=5, splitLongWords=1
        ),
        "heading": ParagraphStyle(
            "heading",
            fontName=BOLD,
            fontSize=11,
            leading=14,
            spaceBefore=8,
            spaceAfter=3,
            keepWithNext=1,
        ),
        "text": ParagraphStyle("text", fontSize=_TEXT, leading=1.35 * _TEXT, spaceAfter=3, **plain),
        "lead": ParagraphStyle(
            "lead", fontSize=_TEXT, leading=1.35 * _TEXT, spaceAfter=3, keepWithNext=1, **plain
        ),
        "small": ParagraphStyle("small", fontSize=SMALL, leading=1.25 * SMALL, **plain),
        "number": ParagraphStyle("number", fontName=BOLD, fontSize=13, leading=14),
        "step": ParagraphStyle("step", fontName=BOLD, fontSize=_TEXT, leading=1.3 * _TEXT),
    }


def paragraph(text: str, style: Any) -> Any:
    """Text that wraps; none of it is markup."""
    from reportlab.platypus import Paragraph

    return Paragraph(escape(printable(text)), style)


def flowables(block: Block, looks: dict[str, Any]) -> list[Any]:
    """What is put on the pages for a block."""
    from reportlab.platypus import PageBreak

    if isinstance(block, Heading):
        return [paragraph(block.text, looks["heading"])]
    if isinstance(block, Text):
        return [paragraph(block.text, looks["lead"])]
    if isinstance(block, Facts):
        return [_facts(block, looks)]
    if isinstance(block, Row):
        row = _row(block.sketches, looks, WIDTH_MM)
        row.keepWithNext = block.joined
        return [row]
    if isinstance(block, Step):
        return [_step(block, looks)]
    if isinstance(block, Table):
        return [_table(block)]
    assert isinstance(block, NewPage)
    return [PageBreak()]


def _facts(facts: Facts, looks: dict[str, Any]) -> Any:
    from reportlab.lib.units import mm

    half = (len(facts.rows) + 1) // 2
    cells = [
        [
            paragraph(text, looks["small"])
            for row in facts.rows[number::half]
            for text in (row[0], row[1])
        ]
        for number in range(half)
    ]
    cells = [row + [""] * (4 - len(row)) for row in cells]
    name, value = 24.0, WIDTH_MM / 2 - 24.0
    apart = ("RIGHTPADDING", (1, 0), (1, -1), _APART_MM * mm)
    return _grid(cells, [name * mm, value * mm] * 2, [*_plain_grid(0.6 * mm), apart])


def _row(sketches: Sequence[Sketch], looks: dict[str, Any], width_mm: float) -> Any:
    """Sketches side by side over their captions, each as wide as itself."""
    from reportlab.lib.units import mm

    count = len(sketches)
    least = [max(sketch.size_mm[0], 30.0) for sketch in sketches]
    spare = max(0.0, width_mm - sum(least)) / count
    cells = [
        [_drawn(sketch) for sketch in sketches],
        [paragraph(sketch.caption, looks["small"]) for sketch in sketches],
    ]
    if not any(sketch.caption for sketch in sketches):
        del cells[1]
    widths = [(own + spare) * mm for own in least]
    return _grid(cells, widths, [*_plain_grid(0.8 * mm), ("NOSPLIT", (0, 0), (-1, -1))])


def _step(step: Step, looks: dict[str, Any]) -> Any:
    from reportlab.lib.units import mm

    words = [paragraph(step.title, looks["step"]), paragraph(step.text, looks["text"])]
    if step.below:
        words.append(_row(step.below, looks, _WORDS_MM))
    cells: list[Any] = [paragraph(str(step.number), looks["number"]), words]
    widths = [_NUMBER_MM, WIDTH_MM - _NUMBER_MM]
    if step.sketches:
        rest = WIDTH_MM - _NUMBER_MM - _WORDS_MM - _BETWEEN_MM
        cells.append([_row([sketch], looks, rest) for sketch in step.sketches])
        widths = [_NUMBER_MM, _WORDS_MM + _BETWEEN_MM, rest]
    rule = ("LINEABOVE", (0, 0), (-1, 0), 0.3, "#999999")
    style = [*_plain_grid(1.2 * mm), rule, ("NOSPLIT", (0, 0), (-1, -1))]
    return _grid([cells], [width * mm for width in widths], style)


def _table(table: Table) -> Any:
    """A table, its rows side by side in columns, read from left to right."""
    from reportlab.lib.units import mm

    side, gap = table.columns, _BETWEEN_MM
    wide = (WIDTH_MM - gap * (side - 1)) / side
    columns = len(table.head)
    texts = [[printable(text) for text in row] for row in (table.head, *table.rows)]
    own = [
        max(text_width_mm(row[k], SMALL / mm, BOLD) for row in texts) + 2.0 for k in range(columns)
    ]
    own = [width * min(1.0, wide / sum(own)) for width in own]
    height = 1.55 * SMALL
    rows: list[list[str]] = []
    for start in range(1, len(texts), side):
        row: list[str] = []
        for part in range(side):
            at = start + part
            row += [""] * (part > 0)
            row += texts[at] if at < len(texts) else [""] * columns
        rows.append(row)
    head: list[str] = []
    widths: list[float] = []
    for part in range(side):
        head += [""] * (part > 0) + texts[0]
        widths += [gap * mm] * (part > 0) + [width * mm for width in own]
    style: list[tuple[Any, ...]] = [
        ("FONT", (0, 0), (-1, -1), PLAIN, SMALL),
        ("FONT", (0, 0), (-1, 0), BOLD, SMALL),
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 0),
        ("TOPPADDING", (0, 0), (-1, -1), 0),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2),
    ]
    for part in range(side):
        first = part * (columns + 1)
        style.append(("LINEBELOW", (first, 0), (first + columns - 1, -1), 0.25, "#bbbbbb"))
    return _grid([head, *rows], widths, style, [height] * (len(rows) + 1), repeated=1)


def _grid(
    cells: list[list[Any]],
    widths: list[float],
    style: Sequence[tuple[Any, ...]],
    heights: list[float] | None = None,
    repeated: int = 0,
) -> Any:
    from reportlab.platypus import Table as Cells

    grid = Cells(cells, widths, heights, repeatRows=repeated, hAlign="LEFT")
    font = ("FONT", (0, 0), (-1, -1), PLAIN, SMALL)
    grid.setStyle([("VALIGN", (0, 0), (-1, -1), "TOP"), font, *style])
    return grid


def _plain_grid(below: float) -> list[tuple[Any, ...]]:
    return [
        ("LEFTPADDING", (0, 0), (-1, -1), 0),
        ("RIGHTPADDING", (0, 0), (-1, -1), 2),
        ("TOPPADDING", (0, 0), (-1, -1), below),
        ("BOTTOMPADDING", (0, 0), (-1, -1), below),
    ]


def _drawn(sketch: Sketch) -> Any:
    """A sketch among what flows over the pages."""
    from reportlab.lib.units import mm
    from reportlab.platypus import Flowable

    class Drawn(Flowable):  # type: ignore[misc]  # reportlab has no types
        def wrap(self, *_room: float) -> tuple[float, float]:
            return sketch.size_mm[0] * mm, sketch.size_mm[1] * mm

        def draw(self) -> None:
            draw_sketch(self.canv, sketch, 0.0, 0.0)

    return Drawn()
