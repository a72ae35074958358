"""Errors and findings of jobs, materials and files, and how they name what is at fault."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import islice

from solver.errors import OrigamiError

__all__ = [
    "Finding",
    "InvalidFile",
    "InvalidJob",
    "Severity",
    "counted",
    "did_you_mean",
    "first_few",
    "mass_text",
    "nearest",
]

# A finding lists this many creases or panels; its text has the count of all.
_LISTED = 20


class InvalidJob(OrigamiError, ValueError):
    """A job that cannot be run as it is; the message names every key at fault."""


class InvalidFile(OrigamiError, ValueError):
    """A file that cannot be read as what it claims to be; the message names the place."""


class Severity(StrEnum):
    """How much a finding matters: an error means the files should not be used as they are."""

    NOTE = "note"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Finding:
    """One thing that was found in what was made.

    Attributes
    ----------
    code : stable name of the kind of finding, such as "development-overlaps".
    text : what, where, how much, and what helps.
    creases, panels : numbers of the edges and faces it names (the first of them where many).
    places : where it is in a drawing that was read, mm, y upwards (the first where many).
    """

    code: str
    severity: Severity
    text: str
    creases: tuple[int, ...] = field(default=())
    panels: tuple[int, ...] = field(default=())
    places: tuple[tuple[float, float], ...] = field(default=())


def nearest(word: object, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """The known word nearest to an unknown one; None where none is near.

    cutoff : of `difflib.get_close_matches`, from 0 (anything is near) to 1. Of words that are
    equally near, one with the same first letter is taken.
    """
    text = str(word)
    close = difflib.get_close_matches(text, list(known), 3, cutoff)
    if not close:
        return None
    nearness = [difflib.SequenceMatcher(None, each, text).ratio() for each in close]
    equal = [each for each, near in zip(close, nearness, strict=True) if near == nearness[0]]
    return next((each for each in equal if each[:1] == text[:1]), equal[0])


def did_you_mean(word: object, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The sentence that names the `nearest` known word; empty where none is near.

    >>> did_you_mean("dfx", ["dxf", "svg"])
    ' Did you mean dxf?'
    """
    close = nearest(word, known, cutoff)
    return f" Did you mean {close}?" if close else ""


def counted(count: int, noun: str, plural: str = "") -> str:
    """A number and what it counts, which agree.

    >>> counted(1, "piece"), counted(0, "seam"), counted(2, "mesh", "meshes")
    ('1 piece', '0 seams', '2 meshes')
    """
    return f"{count} {noun if count == 1 else plural or f'{noun}s'}"


def mass_text(mass_g: float) -> str:
    """A mass in three digits, in kilograms from one on.

    >>> mass_text(7.096), mass_text(999.7), mass_text(3548.0), mass_text(12345678.0)
    ('7.1 g', '1 kg', '3.55 kg', '12346 kg')
    """
    if mass_g < 999.5:
        return f"{mass_g:.3g} g"
    mass_kg = mass_g / 1000
    return f"{mass_kg:.3g} kg" if mass_kg < 999.5 else f"{mass_kg:.0f} kg"


def first_few(numbers: Iterable[int]) -> tuple[int, ...]:
    """The first 20 of some numbers of creases or panels, as a finding lists them."""
    return tuple(int(number) for number in islice(numbers, _LISTED))
