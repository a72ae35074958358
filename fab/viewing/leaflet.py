"""Leaflets: a few pages of text, tables and sketches, for paper and for result pages alike."""

from __future__ import annotations

from dataclasses import dataclass, field

from fab.viewing.sketch import Sketch

__all__ = [
    "WIDTH_MM",
    "Block",
    "Facts",
    "Heading",
    "Leaflet",
    "NewPage",
    "Row",
    "Step",
    "Table",
    "Text",
]

# Width of what is on its pages, of paper.
WIDTH_MM = 184.0


@dataclass(frozen=True)
class Heading:
    """A line above a part; it stays on the page of what follows."""

    text: str


@dataclass(frozen=True)
class Text:
    """A paragraph that stays on the page of what follows."""

    text: str


@dataclass(frozen=True)
class Facts:
    """What is so, in two columns: names and values."""

    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Row:
    """Sketches side by side, each with its caption, never torn apart.

    joined : whether it stays on the page of what follows.
    """

    sketches: tuple[Sketch, ...]
    joined: bool = False


@dataclass(frozen=True)
class Step:
    """What is done next, with its number; sketches beside it, and others below its text."""

    number: int
    title: str
    text: str
    sketches: tuple[Sketch, ...] = ()
    below: tuple[Sketch, ...] = ()


@dataclass(frozen=True)
class Table:
    """A table and what it is called; on paper its head is repeated on each page.

    columns : as many rows are side by side on paper.
    """

    name: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    columns: int = 1


@dataclass(frozen=True)
class NewPage:
    """What follows begins on a new page of paper."""


Block = Heading | Text | Facts | Row | Step | Table | NewPage


@dataclass(frozen=True)
class Leaflet:
    """What is on the pages, one after another.

    made_by : the command, such as "quadfold fabricate".
    """

    title: str
    made_by: str
    blocks: tuple[Block, ...] = field(default=())
