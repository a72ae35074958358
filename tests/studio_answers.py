"""Answers of the studio, taken apart as its page does, and tasks of a worker that misbehaves."""

from __future__ import annotations

import json
import os
import struct
import time

import numpy as np

from fab.errors import InvalidJob


def head_of(data: bytes) -> dict:
    (length,) = struct.unpack("<I", data[:4])
    return json.loads(data[4 : 4 + length])


def arrays_of(data: bytes) -> dict[str, np.ndarray]:
    place, found = 4 + struct.unpack("<I", data[:4])[0], {}
    assert place % 4 == 0
    for name, kind, count in head_of(data)["arrays"]:
        found[name] = np.frombuffer(data, f"<{kind[0]}4", count, place)
        place += 4 * count
    return found


def _crash() -> None:
    os._exit(7)


def _hang() -> None:
    time.sleep(60)


def _fail() -> None:
    raise ZeroDivisionError("by design")


def _refuse() -> None:
    raise InvalidJob("rows = 0 is out of bounds")


def _steps(progress) -> None:
    progress("first", 0, 1, 30.0)
    progress("second", 1, 4)
    progress("second", 2, 4)  # too soon after the other
    time.sleep(60)


def _hog() -> int:
    whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return len(np.empty(int(0.6 * whole), dtype=np.uint8))  # of which nothing is touched


TASKS = {
    "hog": _hog,
    "steps": _steps,
    "pid": os.getpid,
    "crash": _crash,
    "hang": _hang,
    "fail": _fail,
    "refuse": _refuse,
}
