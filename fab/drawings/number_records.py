"""Records of numbers as text, millions at once.

Records are of equal length, one for each row of numbers, in a structured numpy array: its fields
are text that is the same in all records, and groups of digits that are looked up in tables. Numbers
keep leading zeros ("007.250000", "-012.500000"), which readers of DXF, SVG and PDF accept.
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

# Above this, double precision no longer holds six decimals.
_MOST = 4e9
# Below this, millionths fit into 32 bits.
_MOST_32 = 4290
# Up to about this many records at a time stay in the processor's cache.
_CHUNK = 4096

Text = NDArray[np.bytes_]
Digits = NDArray[np.uint64]


def write_records(
    stream: BinaryIO, text: Sequence[bytes], rows: FloatArray, handle: int | None = None
) -> None:
    """Write text[0] x text[1] y text[2] ... for each row of numbers x, y, ..., in bulk.

    Parameters
    ----------
    text : one more than there are numbers in a record; only the first may be empty.
    rows : shape (n, k), written with six decimals.
    handle : where given, each record has a number more, the first: a hexadecimal one that counts up
        from `handle`. All are as long as handle + n.

    Raises `InvalidValue` for numbers that are not finite or not below 4e9.

    >>> import io
    >>> stream = io.BytesIO()
    >>> write_records(stream, [b"M", b",", b" "], np.array([[0.5, 12.0], [7.25, 3.0]]))
    >>> stream.getvalue()
    b'M00.500000,12.000000 M07.250000,03.000000 '
    """
    if not len(rows):
        return
    size = max(float(rows.max()), -float(rows.min()))
    if not size < _MOST:  # so that NaN is refused too
        worst = float(rows.ravel()[np.argmin(np.abs(rows).ravel() < _MOST)])
        cure = "Give coordinates in millimetres."
        raise InvalidValue("coordinate", worst, f"be finite and below {_MOST:g}", cure)
    most = int(size + 1)
    sign = bool((rows < 0).any())
    hexadecimal = 0 if handle is None else len(f"{handle + len(rows):X}")
    first = 0 if handle is None else 1
    texts = [*text[: 1 + first], *(after[1:] for after in text[1 + first :])]
    out = None
    for begin in range(0, len(rows), _CHUNK):
        part = rows[begin : begin + _CHUNK]
        numbers = _decimals(np.ascontiguousarray(part.T), most, sign, text[1 + first :])
        if handle is not None:
            numbers.insert(0, _counted(handle + begin, len(part), hexadecimal))
        columns: list[bytes | Text] = [texts[0]]
        for number, after in zip(numbers, texts[1:], strict=True):
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


def _decimals(
    values: FloatArray, most: int, sign: bool, after: Sequence[bytes]
) -> list[list[Text]]:
    """For each row of values: sign, whole part, point, six decimals and the character after them.

    The whole part is as long as that of `most`.
    """
    kind = np.uint32 if most < _MOST_32 else np.uint64
    millionths: Digits = np.rint(np.abs(values) * 1e6).astype(kind)
    thousandths: Digits = millionths // 1000
    whole: Digits = thousandths // 1000
    groups = [_table(".%03d", 1000).take(thousandths - 1000 * whole)]
    last = millionths - 1000 * thousandths
    digits = len(str(most))
    while digits > 4:
        above: Digits = whole // 10000
        groups.insert(0, _table("%04d", 10000).take(whole - 10000 * above))
        whole, digits = above, digits - 4
    if sign:
        groups.insert(0, _signed(digits).take(whole + 10**digits * (values < 0).astype(kind)))
    else:
        groups.insert(0, _table(f"%0{digits}d", 10**digits).take(whole))
    return [
        [*(group[row] for group in groups), _table("%03d", 1000, text[:1]).take(last[row])]
        for row, text in enumerate(after)
    ]


def _counted(first: int, count: int, width: int) -> list[Text]:
    """Hexadecimal numbers first, first + 1, ... with `width` digits."""
    rest: IntArray = first + np.arange(count)
    out: list[Text] = []
    while width > 0:
        digits = min(width, 3)
        out.insert(0, _table(f"%0{digits}X", 16**digits).take(rest & 16**digits - 1))
        rest, width = rest >> 12, width - digits
    return out


@cache
def _table(form: str, count: int, after: bytes = b"") -> Text:
    """The numbers below `count` in a form, each with the same text after it."""
    return np.array([(form % i).encode() + after for i in range(count)])


@cache
def _signed(digits: int) -> Text:
    """Numbers with a leading zero, then the same ones with a leading minus sign."""
    form, count = f"%0{digits}d", 10**digits
    return np.concatenate([_table(f"0{form}", count), _table(f"-{form}", count)])
