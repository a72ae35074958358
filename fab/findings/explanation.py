"""What a code of a finding means, what causes it, and what cures it."""

from __future__ import annotations

from dataclasses import dataclass

from fab.errors import Severity

__all__ = ["ERROR", "NOTE", "WARNING", "Explanation"]

NOTE, WARNING, ERROR = Severity.NOTE, Severity.WARNING, Severity.ERROR


@dataclass(frozen=True)
class Explanation:
    """What is known of all findings of one code; the text of each has its numbers and places.

    Attributes
    ----------
    code : stable name of the kind of finding.
    severities : those that it may have, the mildest first.
    meaning : what is the case.
    cause : how it comes about, and where there are several severities, what decides.
    cure : what to do; that nothing needs to be done where that is so.
    """

    code: str
    severities: tuple[Severity, ...]
    meaning: str
    cause: str
    cure: str
