"""Leaflets as PDF files for A4 and US letter paper alike.

Why reportlab: it has text that wraps, tables that go over pages and vector drawing in one library
of 2 MB that is loaded in a sixth of a second, is kept up since 2000, has a BSD licence, and gives
the same bytes for the same pages. fpdf2 has less of tables, and the LGPL; matplotlib, which is
there already, knows neither paragraphs nor tables, and takes half a second to load.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any
from xml.sax.saxutils import escape

from fab.outputs import plain_title
from fab.viewing.leaflet import Block, Facts, Heading, Leaflet, NewPage, Row, Step, Table, Text
from fab.viewing.print_fonts import BOLD, PLAIN, printable, text_width_mm
from fab.viewing.sketch import Sketch
from fab.viewing.sketch_print import draw_sketch

__all__ = ["FRAME_MM", "PAGE_MM", "leaflet_pdf_bytes"]

# As wide as A4, as high as US letter: on either one it is printed at its true size.
PAGE_MM = (210.0, 279.4)
_MARGIN_MM, _FOOT_MM = 13.0, 8.0
# Room for what is on a page.
FRAME_MM = (PAGE_MM[0] - 2 * _MARGIN_MM, PAGE_MM[1] - 2 * _MARGIN_MM - _FOOT_MM)
_CHECK_MM = 50.0
_TEXT, _SMALL = 9.0, 7.5
_NUMBER_MM, _WORDS_MM = 9.0, 72.0
_BETWEEN_MM = 3.0
_MOST_LETTERS = 90


def leaflet_pdf_bytes(leaflet: Leaflet) -> bytes:
    """The pages of a leaflet; the same bytes for the same leaflet.

    Each page says its number and how many there are, and has a line of 50 mm, by which a print at
    true size is recognised. Fonts are embedded. "_" takes the place of what cannot be printed.
    """
    from reportlab.lib.units import mm
    from reportlab.platypus import BaseDocTemplate, Frame, PageTemplate

    printable("")  # both fonts are known from here on
    text_width_mm("", 1.0, BOLD)
    stream = io.BytesIO()
    margin = _MARGIN_MM * mm
    document = BaseDocTemplate(
        stream,
        pagesize=(PAGE_MM[0] * mm, PAGE_MM[1] * mm),
        title=plain_title(leaflet.title),
        author="quadfold",
        creator=plain_title(leaflet.made_by),
        invariant=1,
    )
    frame = Frame(
        margin, margin + _FOOT_MM * mm, FRAME_MM[0] * mm, FRAME_MM[1] * mm, 0, 0, 0, 0, id="frame"
    )
    document.addPageTemplates(PageTemplate(frames=[frame]))
    styles = _styles()
    story = [_paragraph(_shortened(leaflet.title), styles["title"])]
    for block in leaflet.blocks:
        story += _flowables(block, styles)
    with _binary_streams():
        document.build(story, canvasmaker=_numbered(leaflet))
    return _packed(stream.getvalue())


@contextmanager
def _binary_streams() -> Iterator[None]:
    """Streams as they are: to spell them in letters, as reportlab does, takes long."""
    from reportlab import rl_config

    before = rl_config.useA85
    rl_config.useA85 = 0
    try:
        yield
    finally:
        rl_config.useA85 = before


def _shortened(title: str) -> str:
    """A title that takes no more than two lines or so."""
    return title if len(title) <= _MOST_LETTERS else f"{title[: _MOST_LETTERS - 1]}…"


def _packed(data: bytes) -> bytes:
    """The same pages in fewer bytes, without dates."""
    import pikepdf

    out = io.BytesIO()
    with pikepdf.open(io.BytesIO(data)) as pdf:
        for key in ("/CreationDate", "/ModDate", "/Keywords", "/Subject"):
            if key in pdf.docinfo:
                del pdf.docinfo[key]
        pdf.save(
            out,
            deterministic_id=True,
            object_stream_mode=pikepdf.ObjectStreamMode.generate,
            stream_decode_level=pikepdf.StreamDecodeLevel.generalized,
            compress_streams=True,
            recompress_flate=True,
        )
    return out.getvalue()


def _styles() -> dict[str, Any]:
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
        "small": ParagraphStyle("small", fontSize=_SMALL, leading=1.25 * _SMALL, **plain),
        "number": ParagraphStyle("number", fontName=BOLD, fontSize=13, leading=14),
        "step": ParagraphStyle("step", fontName=BOLD, fontSize=_TEXT, leading=1.3 * _TEXT),
    }


def _paragraph(text: str, style: Any) -> Any:
    from reportlab.platypus import Paragraph

    return Paragraph(escape(printable(text)), style)


def _flowables(block: Block, styles: dict[str, Any]) -> list[Any]:
    """What is put on the pages for a block."""
    from reportlab.platypus import PageBreak

    if isinstance(block, Heading):
        return [_paragraph(block.text, styles["heading"])]
    if isinstance(block, Text):
        return [_paragraph(block.text, styles["lead"])]
    if isinstance(block, Facts):
        return [_facts(block, styles)]
    if isinstance(block, Row):
        row = _row(block.sketches, styles, FRAME_MM[0])
        row.keepWithNext = block.joined
        return [row]
    if isinstance(block, Step):
        return [_step(block, styles)]
    if isinstance(block, Table):
        return [_table(block)]
    assert isinstance(block, NewPage)
    return [PageBreak()]


def _facts(facts: Facts, styles: dict[str, Any]) -> Any:
    from reportlab.lib.units import mm

    half = (len(facts.rows) + 1) // 2
    cells = [
        [
            _paragraph(text, styles["small"])
            for row in facts.rows[number::half]
            for text in (row[0], row[1])
        ]
        for number in range(half)
    ]
    cells = [row + [""] * (4 - len(row)) for row in cells]
    name, value = 24.0, FRAME_MM[0] / 2 - 24.0
    return _grid(cells, [name * mm, value * mm] * 2, _plain_grid(0.6 * mm))


def _row(sketches: Sequence[Sketch], styles: dict[str, Any], width_mm: float) -> Any:
    """Sketches side by side over their captions, each as wide as itself."""
    from reportlab.lib.units import mm

    count = len(sketches)
    least = [max(sketch.size_mm[0], 30.0) for sketch in sketches]
    spare = max(0.0, width_mm - sum(least)) / count
    cells = [
        [_drawn(sketch) for sketch in sketches],
        [_paragraph(sketch.caption, styles["small"]) for sketch in sketches],
    ]
    if not any(sketch.caption for sketch in sketches):
        del cells[1]
    widths = [(own + spare) * mm for own in least]
    return _grid(cells, widths, [*_plain_grid(0.8 * mm), ("NOSPLIT", (0, 0), (-1, -1))])


def _step(step: Step, styles: dict[str, Any]) -> Any:
    from reportlab.lib.units import mm

    words = [_paragraph(step.title, styles["step"]), _paragraph(step.text, styles["text"])]
    if step.below:
        words.append(_row(step.below, styles, _WORDS_MM))
    cells: list[Any] = [_paragraph(str(step.number), styles["number"]), words]
    widths = [_NUMBER_MM, FRAME_MM[0] - _NUMBER_MM]
    if step.sketches:
        rest = FRAME_MM[0] - _NUMBER_MM - _WORDS_MM - _BETWEEN_MM
        cells.append([_row([sketch], styles, rest) for sketch in step.sketches])
        widths = [_NUMBER_MM, _WORDS_MM + _BETWEEN_MM, rest]
    rule = ("LINEABOVE", (0, 0), (-1, 0), 0.3, "#999999")
    style = [*_plain_grid(1.2 * mm), rule, ("NOSPLIT", (0, 0), (-1, -1))]
    return _grid([cells], [width * mm for width in widths], style)


def _table(table: Table) -> Any:
    """A table, its rows side by side in columns, read from left to right."""
    from reportlab.lib.units import mm

    side, gap = table.columns, _BETWEEN_MM
    wide = (FRAME_MM[0] - gap * (side - 1)) / side
    columns = len(table.head)
    texts = [[printable(text) for text in row] for row in (table.head, *table.rows)]
    own = [
        max(text_width_mm(row[k], _SMALL / mm, BOLD) for row in texts) + 2.0 for k in range(columns)
    ]
    own = [width * min(1.0, wide / sum(own)) for width in own]
    height = 1.55 * _SMALL
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
        ("FONT", (0, 0), (-1, -1), PLAIN, _SMALL),
        ("FONT", (0, 0), (-1, 0), BOLD, _SMALL),
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
    grid.setStyle([("VALIGN", (0, 0), (-1, -1), "TOP"), *style])
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


def _numbered(leaflet: Leaflet) -> Any:
    """A canvas that writes the foot of each page once their number is known."""
    from reportlab.lib.units import mm
    from reportlab.pdfgen.canvas import Canvas

    class Numbered(Canvas):  # type: ignore[misc]  # reportlab has no types
        def __init__(self, *arguments: Any, **named: Any) -> None:
            super().__init__(*arguments, **named)
            self._pages: list[dict[str, Any]] = []

        def showPage(self) -> None:
            self._pages.append(dict(self.__dict__))
            self._startPage()

        def save(self) -> None:
            for number, page in enumerate(self._pages, 1):
                self.__dict__.update(page)
                _foot(self, leaflet, f"page {number} of {len(self._pages)}", mm)
                super().showPage()
            super().save()

    return Numbered


def _foot(canvas: Any, leaflet: Leaflet, page: str, mm: float) -> None:
    """Title, a line of 50 mm to check the print by, and the number of the page."""
    left, right, low = _MARGIN_MM * mm, (PAGE_MM[0] - _MARGIN_MM) * mm, _MARGIN_MM * mm
    canvas.setFillColor("#000000")
    canvas.setStrokeColor("#000000")
    canvas.setFont(PLAIN, _SMALL)
    canvas.drawRightString(right, low, page)
    title = printable(leaflet.title)
    room = 62.0
    while text_width_mm(title, _SMALL / mm) > room:
        title = title[:-2].rstrip() + "…"
    canvas.drawString(left, low, title)
    middle = PAGE_MM[0] / 2 * mm
    start, end = middle - _CHECK_MM / 2 * mm, middle + _CHECK_MM / 2 * mm
    canvas.setLineWidth(0.6)
    canvas.setDash()
    tick = 1.2 * mm
    canvas.lines(
        [
            (start, low + 3 * mm, end, low + 3 * mm),
            (start, low + 3 * mm - tick, start, low + 3 * mm + tick),
            (end, low + 3 * mm - tick, end, low + 3 * mm + tick),
        ]
    )
    canvas.drawCentredString(middle, low, f"{_CHECK_MM:g} mm, printed at 100 %")
