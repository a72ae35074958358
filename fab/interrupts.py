"""Interrupts: signals that ask a process to end, noted, raised where that does no harm.

Ctrl-C is one of them, and so are SIGTERM and a terminal that is closed.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

__all__ = ["Interrupts", "held", "ignore_interrupts"]

_NUMBERS = tuple(
    number
    for name in ("SIGINT", "SIGTERM", "SIGHUP")
    if (number := getattr(signal, name, None)) is not None
)


class _Holds:
    """How many blocks are at work that no interrupt may leave half done, and whether one came."""

    count = 0
    waiting = False


class Interrupts:
    """Notes interrupts while it is entered: some libraries swallow the exception that they raise.

    raises : whether `KeyboardInterrupt` is raised too; without, one within takes up what came.
    A signal that the process was started to ignore, as behind `nohup`, stays ignored.
    """

    def __init__(self, *, raises: bool = True) -> None:
        self.came = 0  # the number of the signal; 0 where there was none
        self._raises = raises
        self._before: dict[int, Any] = {}

    def __enter__(self) -> None:
        if threading.current_thread() is not threading.main_thread():
            return
        outer = None
        for number in _NUMBERS:
            before = signal.getsignal(number)
            if before is not signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._note)
                outer = getattr(before, "__self__", None)
        if self._raises and isinstance(outer, Interrupts) and outer.came:
            self.came = outer.came
            self.__exit__()
            raise KeyboardInterrupt

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before = {}

    @property
    def exit_code(self) -> int:
        """Of a process that ends by what came: 130 by Ctrl-C, 143 by SIGTERM."""
        return 128 + (self.came or int(signal.SIGINT))

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.came = number
        if not self._raises or _importing(frame):
            return
        if _Holds.count:
            _Holds.waiting = True
            return
        raise KeyboardInterrupt

    def check(self) -> None:
        """Raise again what a library may have swallowed."""
        if self.came:
            raise KeyboardInterrupt


@contextmanager
def held() -> Iterator[None]:
    """A short block that no interrupt leaves half done: it is raised when the block has ended."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _Holds.count += 1
    try:
        yield
    finally:
        _Holds.count -= 1
        if not _Holds.count and _Holds.waiting:
            _Holds.waiting = False
            raise KeyboardInterrupt


def ignore_interrupts() -> None:
    """Let none change the exit code of a process that has done its work and ends."""
    for number in _NUMBERS:
        signal.signal(number, signal.SIG_IGN)


def _importing(frame: FrameType | None) -> bool:
    """Whether a library is being imported, which an exception would leave half done."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False
