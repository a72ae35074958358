"""Answers in bytes: a head of JSON and arrays of numbers, as the page's script reads them."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from solver.vectors import FloatArray, IntArray

__all__ = ["packed_answer"]


def packed_answer(
    head: Mapping[str, Any], arrays: Mapping[str, FloatArray | IntArray] | None = None
) -> bytes:
    r"""Length of the head (4 bytes), the head, then all arrays; little-endian.

    arrays : by name; written as 32 bits each, whole numbers as unsigned ones. The head lists them
    under "arrays": name, kind ("f32" or "u32") and count. It ends at a multiple of 4 bytes.

    >>> packed_answer({}, {"a": np.array([1, 2])})[-8:]
    b'\x01\x00\x00\x00\x02\x00\x00\x00'
    """
    parts, listed = [], []
    for name, array in (arrays or {}).items():
        kind = "f32" if array.dtype.kind == "f" else "u32"
        parts.append(np.ascontiguousarray(array, dtype=f"<{kind[0]}4").tobytes())
        listed.append([name, kind, array.size])
    text = json.dumps({**head, "arrays": listed}, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    return b"".join([struct.pack("<I", len(text)), text, *parts])
