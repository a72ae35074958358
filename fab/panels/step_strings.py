"""Names in STEP files, whose strings are ASCII with escapes (ISO 10303-21, 6.4.3).

OpenCASCADE writes bytes beyond ASCII as they come, encoded once or twice, and breaks lines within
them. So it is given names that are ASCII, in which tokens hold the place of all other characters,
and the tokens become escapes in what it wrote.
"""

from __future__ import annotations

import re

from fab.outputs import plain_title

__all__ = ["escaped", "with_tokens"]

_MARK = "~"
# A token, wherever OpenCASCADE broke the line.
_TOKEN = re.compile(rf"{_MARK}([0-9A-F\n]+){_MARK}")
_LAST_OF_TWO_BYTES = 0xFFFF
_NO_CHARACTER = re.compile("[\ud800-\udfff]")


def with_tokens(name: str) -> str:
    """A name as ASCII, in which every other character is a token for `escaped`.

    What cannot be printed, and bytes of file names that are no text, become "_".

    >>> with_tokens("fälten")
    'f~000000E4~lten'
    """
    plain = _NO_CHARACTER.sub("_", plain_title(name))
    return re.sub(
        rf"([^ -~]|{_MARK})+",
        lambda run: _MARK + "".join(f"{ord(letter):08X}" for letter in run[0]) + _MARK,
        plain,
    )


def escaped(text: str) -> str:
    r"""A STEP file with its tokens as escapes: \\X2\\ with four digits for each character, \\X4\\
    with eight where one of them needs more.

    >>> print(escaped(with_tokens("fälten ~ 😀")))
    f\X2\00E4\X0\lten ~ \X4\0001F600\X0\
    """
    return _TOKEN.sub(lambda token: _escape(token[1].replace("\n", "")), text)


def _escape(digits: str) -> str:
    codes = [int(digits[i : i + 8], 16) for i in range(0, len(digits), 8)]
    if codes == [ord(_MARK)] * len(codes):
        return _MARK * len(codes)
    if max(codes) > _LAST_OF_TWO_BYTES:
        return "\\X4\\" + "".join(f"{code:08X}" for code in codes) + "\\X0\\"
    return "\\X2\\" + "".join(f"{code:04X}" for code in codes) + "\\X0\\"
