"""How are millions of numbers written as text at once?

As records of equal length, one for each row of numbers, in a structured numpy array: its fields are
text that is the same in all records, and groups of digits that are looked up in tables. Numbers
keep leading zeros ("007.250000", "-012.500000"), which DXF, SVG and PDF readers take as any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from solver.errors import InvalidValue
from solver.vectors import FloatArray, IntArray

__all__ = ["write_records"]

# Over this six decimals are no longer held exactly.
_MOST = 4e9
# So many records at a time stay in the processor's cache.
_CHUNK = 2048

Text = NDArray[np.bytes_]


def write_records(
    stream: BinaryIO, text: Sequence[bytes], rows: FloatArray, handle: int | None = None
) -> None:
    """Write text[0] x text[1] y text[2] ... for each row of numbers x, y, ..., in bulk.

    Parameters
    ----------
    text : one more than there are numbers in a record.
    rows : shape (n, k), written with six decimals. Raises `InvalidValue` where one is not finite or
        not below 4e9.
    handle : where given, each record has one number more, the first: a hexadecimal one that counts
        up from here. All are as long as handle + n.
    """
    if not len(rows):
        return
    size = np.abs(rows)
    if not (size < _MOST).all():  # so that NaN is refused too
        worst = float(rows.ravel()[np.argmin(size.ravel() < _MOST)])
        cure = "Give coordinates in millimetres."
        raise InvalidValue("coordinate", worst, f"be finite and below {_MOST:g}", cure)
    whole = len(str(int(size.max() + 1)))
    sign = bool((rows < 0).any())
    hexadecimal = 0 if handle is None else len(f"{handle + len(rows):X}")
    out = None
    for begin in range(0, len(rows), _CHUNK):
        part = rows[begin : begin + _CHUNK]
        numbers = [_decimals(column, whole, sign) for column in part.T]
        if handle is not None:
            numbers.insert(0, _counted(handle + begin, len(part), hexadecimal))
        columns: list[bytes | Text] = [text[0]]
        for number, after in zip(numbers, text[1:], strict=True):
            columns += [*number, after]
        columns = [column for column in columns if len(column)]
        if out is None:
            out = _blank(columns, len(part))
        fields = out[: len(part)]
        for i, column in enumerate(columns):
            if isinstance(column, np.ndarray):
                fields[f"{i}"] = column
        stream.write(fields.view(np.uint8).data)


def _blank(columns: Sequence[bytes | Text], count: int) -> NDArray[np.void]:
    """Records with a field for each column, the text that is the same in all of them filled in."""
    lengths = [c.itemsize if isinstance(c, np.ndarray) else len(c) for c in columns]
    out = np.empty(count, [(f"{i}", f"S{length}") for i, length in enumerate(lengths)])
    out[:] = tuple(b"" if isinstance(c, np.ndarray) else c for c in columns)
    return out


def _decimals(values: FloatArray, whole_digits: int, sign: bool) -> list[Text]:
    """Sign, whole part, point and six decimals of each number."""
    size = np.abs(values)
    whole = np.floor(size)
    fraction = np.rint((size - whole) * 1e6)
    carry = fraction == 1e6
    fraction[carry] = 0
    above = np.floor(fraction / 1e3)
    out = [_table(".%03d", 1000)[above.astype(np.intp)]]
    out.append(_table("%03d", 1000)[(fraction - 1e3 * above).astype(np.intp)])
    rest = whole + carry
    while whole_digits > 0:
        width = min(whole_digits, 4)
        above = np.floor(rest / 1e4)
        four = (rest - 1e4 * above).astype(np.intp)
        out.insert(0, _table(f"%0{width}d", 10**width)[four])
        rest, whole_digits = above, whole_digits - width
    return [np.where(values < 0, b"-", b"0"), *out] if sign else out


def _counted(first: int, count: int, width: int) -> list[Text]:
    """Hexadecimal numbers first, first + 1, ... with `width` digits."""
    rest: IntArray = first + np.arange(count)
    out: list[Text] = []
    while width > 0:
        digits = min(width, 3)
        out.insert(0, _table(f"%0{digits}X", 16**digits)[rest & 16**digits - 1])
        rest, width = rest >> 12, width - digits
    return out


@cache
def _table(form: str, count: int) -> Text:
    return np.array([(form % i).encode() for i in range(count)])
