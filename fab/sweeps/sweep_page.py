"""The page of a sweep: a table that sorts, parallel coordinates that filter, and pictures."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from fab import __version__
from fab.errors import counted
from fab.sweeps.columns import FIGURES, OUTCOME
from fab.sweeps.dotted_names import short_names
from fab.viewing.html_file import Script, html_file

__all__ = ["MOST_ROWS", "sweep_page_bytes"]

# A page holds so many rows; the table has all of them.
MOST_ROWS = 5000
# Axes of parallel coordinates, after which they are too near to each other.
_MOST_AXES = 12
_NOT_SHOWN = ("job_hash", "seconds")


def sweep_page_bytes(
    name: str,
    axes: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    whole: int,
    pictures: Mapping[str, bytes],
) -> bytes:
    """The page as an HTML file, the same bytes for the same rows: without durations.

    Parameters
    ----------
    axes : keys of the axes. rows : of the table, up to `MOST_ROWS`, of `whole` in all.
    pictures : PNG files by the hash of the job.
    """
    shown = _columns(axes, rows)
    numbers = {column.name for column in (*OUTCOME, *FIGURES) if column.kind in _NUMBERS}
    numbers |= {key for key in axes if all(_is_number(row[key]) for row in rows)}
    along = _side_by_side(axes, shown, numbers, rows)
    titles = short_names(along)
    data = {
        "columns": [
            {"name": each, "numbers": each in numbers, "axis": titles.get(each)} for each in shown
        ],
        "rows": [[row[each] for each in shown] for row in rows],
        "pictures": [_source(pictures.get(row["job_hash"])) for row in rows],
    }
    style = _asset("fab.viewing", "page.css") + _asset("fab.sweeps", "sweep.css")
    body = _body(name, shown, numbers, rows, whole, pictures, axes)
    script = Script(_asset("fab.sweeps", "sweep.js"), module=True)
    return html_file(f"{name}: quadfold sweep", style, body, data, [script])


_NUMBERS = ("whole", "number")
# What a maker compares first; exactness and counts come after it.
_FIRST = (
    *("sheets.minutes", "sheets.count", "solids.mass_g", "solids.clearance_min_mm"),
    *("simulation.peak_strain", "growth.coverage", "flat.x_mm", "flat.y_mm"),
    *("folded.x_mm", "folded.y_mm", "folded.z_mm", "crossings", "counts.faces"),
)


def _side_by_side(
    axes: Sequence[str],
    shown: Sequence[str],
    numbers: set[str],
    rows: Sequence[Mapping[str, Any]],
) -> list[str]:
    """The columns of parallel coordinates: axes, then numbers that are not the same in all rows."""
    every = dict.fromkeys([*axes, *(n for n in _FIRST if n in shown), *shown])
    chosen = [
        name
        for name in every
        if (name in numbers or name in axes)
        and name != "number"
        and len({row[name] for row in rows} - {None}) > 1
    ]
    return chosen[:_MOST_AXES]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _columns(axes: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Number, axes and status, then all that differs from row to row, what is compared first."""
    first = ["number", *axes, "status"]
    outcome, figures = ([column.name for column in columns] for columns in (OUTCOME, FIGURES))
    others = dict.fromkeys([*outcome, *_FIRST, *figures])
    return [
        *first,
        *(
            each
            for each in others
            if each not in (*first, *_NOT_SHOWN) and len({row[each] for row in rows}) > 1
        ),
    ]


def _body(
    name: str,
    shown: Sequence[str],
    numbers: set[str],
    rows: Sequence[Mapping[str, Any]],
    whole: int,
    pictures: Mapping[str, bytes],
    axes: Sequence[str],
) -> Iterator[str]:
    yield f"<header><h1>{escape(name)}</h1>"
    yield "<p>made by <code>quadfold sweep</code></p></header><main>"
    if len(rows) < whole:
        yield (
            f"<section><p>The page has the first {len(rows)} of {counted(whole, 'variation')}; "
            "<code>results.parquet</code> and <code>results.csv</code> have all.</p></section>"
        )
    yield "<section><h2>Variations side by side</h2>"
    yield '<div class="bar"><p id="count" role="status"></p>'
    yield '<button type="button" id="clear">Show all</button></div>'
    yield '<div class="wide"><svg id="axes" viewBox="0 0 1000 350" role="img" '
    yield 'aria-label="Parallel coordinates: a line for each variation"></svg></div>'
    yield "<p>Drag along an axis to keep what is within; click it to let go.</p></section>"
    yield '<section><h2>Table</h2><div class="wide"><table class="rows"><thead><tr>'
    texts = {column.name: column.text for column in (*OUTCOME, *FIGURES)}
    for place, each in enumerate(shown):
        if pictures and place == 1:
            yield '<td class="text">folded form</td>'
        kind = "" if each in numbers else ' class="text"'
        about = escape(texts.get(each, "an axis of the sweep"))
        yield f'<th scope="col"{kind} title="{about}">'
        yield f'<button type="button">{escape(each)}</button></th>'
    yield "</tr></thead><tbody></tbody></table></div></section>"
    if pictures:
        yield '<section><h2>Pictures</h2><ul class="sheet-of-pictures">'
        for row in rows:
            source = _source(pictures.get(row["job_hash"]))
            if source is not None:
                about = ", ".join(f"{key} {_value(row[key])}" for key in axes)
                yield f'<li><figure><img loading="lazy" src="{source}" alt="">'
                yield f"<figcaption>{row['number']}: {escape(about)}</figcaption></figure></li>"
        yield "</ul></section>"
    yield f"</main><footer><p>quadfold {__version__}</p></footer>"


def _value(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _source(picture: bytes | None) -> str | None:
    return (
        None if picture is None else f"data:image/png;base64,{base64.b64encode(picture).decode()}"
    )


def _asset(package: str, name: str) -> str:
    return (files(package) / "page_assets" / name).read_text(encoding="utf-8")
