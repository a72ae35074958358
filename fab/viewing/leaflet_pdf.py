"""Leaflets as PDF files for A4 and US letter paper alike.

Why reportlab: it has text that wraps, tables that go over pages and vector drawing in one library
of 2 MB that is loaded in a sixth of a second, is kept up since 2000, has a BSD licence, and gives
the same bytes for the same pages. fpdf2 has less of tables, and the LGPL; matplotlib, which is
there already, knows neither paragraphs nor tables, and takes half a second to load.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fab.outputs import plain_title
from fab.viewing.leaflet import WIDTH_MM, Leaflet
from fab.viewing.leaflet_flowables import SMALL, flowables, paragraph, styles
from fab.viewing.print_fonts import BOLD, PLAIN, printable, text_width_mm

__all__ = ["PAGE_MM", "leaflet_pdf_bytes"]

# As wide as A4, as high as US letter: on either one it is printed at its true size.
PAGE_MM = (210.0, 279.4)
_MARGIN_MM, _FOOT_MM = (PAGE_MM[0] - WIDTH_MM) / 2, 8.0
_HEIGHT_MM = PAGE_MM[1] - 2 * _MARGIN_MM - _FOOT_MM
_CHECK_MM = 50.0
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
        initialFontName=PLAIN,
        creator=plain_title(leaflet.made_by),
        invariant=1,
    )
    frame = Frame(
        margin, margin + _FOOT_MM * mm, WIDTH_MM * mm, _HEIGHT_MM * mm, 0, 0, 0, 0, id="frame"
    )
    document.addPageTemplates(PageTemplate(frames=[frame]))
    looks = styles()
    story = [paragraph(_shortened(leaflet.title), looks["title"])]
    for block in leaflet.blocks:
        story += flowables(block, looks)
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
    canvas.setFont(PLAIN, SMALL)
    canvas.drawRightString(right, low, page)
    title = printable(leaflet.title)
    room = 62.0
    while text_width_mm(title, SMALL / mm) > room:
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
