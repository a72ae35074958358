"""Leaflets as parts of a result page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from fab.outputs import plain_title
from fab.viewing.leaflet import Block, Facts, Heading, Leaflet, NewPage, Row, Step, Table, Text
from fab.viewing.sketch import Sketch
from fab.viewing.sketch_svg import sketch_svg

__all__ = ["leaflet_html"]


def leaflet_html(leaflet: Leaflet) -> Iterator[str]:
    """Elements for all blocks, one after another; steps are items of lists."""
    title = plain_title(leaflet.title)
    in_steps = False
    for block in leaflet.blocks:
        if isinstance(block, Step) != in_steps:
            in_steps = not in_steps
            yield '<ol class="steps">' if in_steps else "</ol>"
        yield from _elements(block, title)
    if in_steps:
        yield "</ol>"


def _elements(block: Block, title: str) -> Iterator[str]:
    if isinstance(block, Heading):
        yield f"<h3>{_text(block.text)}</h3>"
    elif isinstance(block, Text):
        yield f"<p>{_text(block.text)}</p>"
    elif isinstance(block, Facts):
        rows = "".join(
            f'<tr><th scope="row">{_text(name)}</th><td>{_text(value)}</td></tr>'
            for name, value in block.rows
        )
        yield f"<table><tbody>{rows}</tbody></table>"
    elif isinstance(block, Row):
        yield _figures(block.sketches, title)
    elif isinstance(block, Step):
        yield f'<li value="{block.number}"><h4>{_text(block.title)}</h4><p>{_text(block.text)}</p>'
        if block.sketches or block.below:
            yield _figures((*block.below, *block.sketches), block.title)
        yield "</li>"
    elif isinstance(block, Table):
        head = "".join(f'<th scope="col">{_text(name)}</th>' for name in block.head)
        body = "".join(
            "<tr>" + "".join(f"<td>{_text(cell)}</td>" for cell in row) + "</tr>"
            for row in block.rows
        )
        yield (
            f'<div class="wide" tabindex="0" role="group" aria-label="{_text(block.name)}"><table>'
            f'<thead><tr>{head}</tr></thead><tbody class="rows">{body}</tbody></table></div>'
        )
    else:
        assert isinstance(block, NewPage)  # there are none on a screen


def _figures(sketches: Sequence[Sketch], title: str) -> str:
    """Sketches side by side, as large as on paper where there is room."""
    figures = []
    for number, sketch in enumerate(sketches, 1):
        caption = f"<figcaption>{_text(sketch.caption)}</figcaption>" if sketch.caption else ""
        name = f"{title}: {sketch.caption}" if sketch.caption else f"{title}, {number}"
        figures.append(f"<figure>{sketch_svg(sketch, name)}{caption}</figure>")
    return f'<div class="sketches">{"".join(figures)}</div>'


def _text(text: str) -> str:
    return escape(plain_title(text))
