"""Fonts of printed pages: DejaVu Sans, which comes with matplotlib, embedded as far as it is used.

Names may have letters of any alphabet, and pages look alike on every machine.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from fab.outputs import plain_title

__all__ = ["BOLD", "PLAIN", "printable", "text_width_mm"]

PLAIN, BOLD = "DejaVuSans", "DejaVuSans-Bold"
_FOLDER = "mpl-data/fonts/ttf"
_MISSING = "□"


def printable(text: str) -> str:
    """The text as the fonts can write it: a box for letters that they do not have, no controls."""
    known = _face(PLAIN).face.charToGlyph
    return "".join(letter if ord(letter) in known else _MISSING for letter in plain_title(text))


def text_width_mm(text: str, size_mm: float, font: str = PLAIN) -> float:
    """How long a line of text is."""
    _face(font)
    from reportlab.pdfbase.pdfmetrics import stringWidth

    return float(stringWidth(text, font, size_mm))


@cache
def _face(font: str) -> Any:
    """A font that reportlab knows from then on."""
    from reportlab.pdfbase.pdfmetrics import registerFont
    from reportlab.pdfbase.ttfonts import TTFont

    spec = find_spec("matplotlib")  # found without being loaded
    assert spec is not None
    assert spec.origin is not None
    face = TTFont(font, str(Path(spec.origin).parent / _FOLDER / f"{font}.ttf"))
    registerFont(face)
    return face
