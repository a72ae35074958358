"""What may a title say, so that every file can hold it and every reader takes it?"""

from __future__ import annotations

__all__ = ["plain_title"]


def plain_title(text: str) -> str:
    """The text with "_" for everything that cannot be printed.

    Those are control characters (XML has no way to write them), bytes of a file name that are not
    text, marks that turn the direction of reading, and line breaks.
    """
    return "".join(letter if letter.isprintable() else "_" for letter in text)
