"""The table of all findings, by the stage that reports them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from fab.errors import InvalidJob, did_you_mean
from fab.files import shortened
from fab.findings.drawings import DRAWINGS
from fab.findings.explanation import Explanation
from fab.findings.folding import FOLDING
from fab.findings.growth import GROWTH
from fab.findings.meshes import MESHES
from fab.findings.panels import PANELS
from fab.findings.printing import PRINTING
from fab.findings.sheets import SHEETS

__all__ = ["FAMILIES", "explained", "find"]

# Of each stage: what its findings are of, and the findings.
FAMILIES: Mapping[str, tuple[Explanation, ...]] = MappingProxyType(
    {
        "Growing and measuring a sheet": GROWTH,
        "Reading a surface": MESHES,
        "Reading a crease pattern, and converting it": DRAWINGS,
        "Folding": FOLDING,
        "Sheets for cutters": SHEETS,
        "Thick panels": PANELS,
        "Printing": PRINTING,
    }
)


def explained() -> dict[str, Explanation]:
    """Every code and its explanation, in the order of the alphabet."""
    return {
        each.code: each
        for each in sorted(
            (each for family in FAMILIES.values() for each in family), key=lambda each: each.code
        )
    }


def find(word: str) -> list[Explanation]:
    """The explanation of a code; of another word, of all findings that have it in code or text.

    Raises `InvalidJob` where none has, with the code that is nearest.

    >>> [each.code for each in find("no-kerf")]
    ['no-kerf']
    """
    known = explained()
    if word in known:
        return [known[word]]
    found = [
        each
        for each in known.values()
        if word.casefold() in f"{each.code} {each.meaning} {each.cause} {each.cure}".casefold()
    ]
    if not found:
        raise InvalidJob(
            f"{shortened(word)!r} is neither the code of a finding nor in the text of one."
            f"{did_you_mean(word, known)} List all: `quadfold findings`."
        )
    return found
