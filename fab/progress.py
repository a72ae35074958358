"""Progress of a run, and the seconds that each of its stages took."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["Clock", "Progress", "Steps", "Watch", "no_steps", "silent"]

# Called with the stage, the steps done and all steps of the stage.
Progress = Callable[[str, int, int], None]
# The same within one stage.
Steps = Callable[[int, int], None]


def silent(stage: str, done: int, total: int) -> None:
    """Progress that nobody watches."""
    del stage, done, total


def no_steps(done: int, total: int) -> None:
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


class Watch:
    """Progress that takes the seconds of stages from when they are reported, each until the next.

    >>> watch = Watch(silent)
    >>> watch("nest", 0, 2)
    >>> watch("nest", 1, 2)
    >>> watch("write", 0, 1)
    >>> list(watch.seconds())
    ['nest', 'write']
    """

    def __init__(self, progress: Progress) -> None:
        self.progress = progress
        self._began: list[tuple[str, float]] = []

    def __call__(self, stage: str, done: int, total: int) -> None:
        if not self._began or self._began[-1][0] != stage:
            self._began.append((stage, time.perf_counter()))
        self.progress(stage, done, total)

    def seconds(self) -> dict[str, float]:
        """Seconds of each stage up to now; of one that came more than once, in all."""
        ends = [*(begin for _, begin in self._began[1:]), time.perf_counter()]
        out: dict[str, float] = {}
        for (stage, begin), end in zip(self._began, ends, strict=False):
            out[stage] = out.get(stage, 0.0) + end - begin
        return out
