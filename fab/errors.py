"""What goes wrong with jobs, materials and files?"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from solver.errors import OrigamiError

__all__ = ["Finding", "InvalidFile", "InvalidJob", "Severity"]


class InvalidJob(OrigamiError, ValueError):
    """A job that cannot be run as it stands; the message names every key at fault."""


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
    """

    code: str
    severity: Severity
    text: str
    creases: tuple[int, ...] = field(default=())
    panels: tuple[int, ...] = field(default=())
