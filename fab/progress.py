"""Progress of a run, and the seconds that each of its stages took."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["Clock", "Progress", "Steps", "no_steps", "silent"]

# Called with the stage, the steps done and all steps of the stage; a step may be done in part.
Progress = Callable[[str, float, int], None]
# The same within one stage.
Steps = Callable[[float, int], None]


def silent(stage: str, done: float, total: int) -> None:
    """Progress that nobody watches."""
    del stage, done, total


def no_steps(done: float, total: int) -> None:
    """Steps that nobody watches."""
    del done, total


class Clock:
    """Seconds per stage, reported to `progress` as stages begin."""

    def __init__(self, progress: Progress) -> None:
        self.progress = progress
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[Steps]:
        begin = time.perf_counter()
        self.progress(name, 0, 1)
        yield lambda done, total: self.progress(name, done, total)
        self.progress(name, 1, 1)
        self.seconds[name] = round(time.perf_counter() - begin, 4)
