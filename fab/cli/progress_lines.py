"""Progress of a run: a bar at a terminal, a line for each long stage in a pipe; the time left."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fab.cli.console import say
from fab.interrupts import Interrupts
from fab.progress import Progress

__all__ = ["StageLines", "progress_of"]

# A stage of a run whose output nobody watches is worth a line after so long.
_LONG_S = 10.0
# Of less than this share of a stage the time left is a guess: searches end early, and steps differ.
_LEAST_SHARE = 0.05


@contextmanager
def progress_of(interrupts: Interrupts, *, lines: bool = True) -> Iterator[Progress]:
    """What shows progress, and sees interrupts: a bar at a terminal, else lines of long stages.

    lines : whether these are printed, to the error stream.
    """
    if sys.stderr is not None and sys.stderr.isatty():
        with _bar() as show:
            yield _checked(interrupts, show)
        return
    stages = StageLines(lambda text: say(text, error=True) if lines else None)
    yield _checked(interrupts, stages)
    stages.end()


def _checked(interrupts: Interrupts, show: Progress) -> Progress:
    def checked(stage: str, done: float, total: int) -> None:
        interrupts.check()
        show(stage, done, total)

    return checked


class StageLines:
    """A line for each stage of more than ten seconds: where it is then, and the time left.

    One that reports no steps on its way has its line when it is over. now : seconds of a clock.

    >>> seconds = iter([0.0, 12.0, 30.0, 30.0])
    >>> stages = StageLines(print, now=lambda: next(seconds))
    >>> stages("nest", 0, 10); stages("nest", 4, 10); stages("nest", 10, 10)
    nest: 4 of 10 after 12 s, about 18 s left
    """

    def __init__(
        self, line: Callable[[str], None], now: Callable[[], float] = time.monotonic
    ) -> None:
        self._line, self._now = line, now
        self._stage, self._began, self._said = "", 0.0, True

    def __call__(self, stage: str, done: float, total: int) -> None:
        if stage != self._stage:
            self.end()
            self._stage, self._began, self._said = stage, self._now(), False
            return
        if self._said:
            return
        taken = self._now() - self._began
        if taken < _LONG_S or done >= total:
            return
        self._said = True
        left = ""
        if done > _LEAST_SHARE * total:
            left = f", about {_seconds(taken * (total - done) / done)} left"
        self._line(f"{stage}: {int(done)} of {total} after {_seconds(taken)}{left}")

    def end(self) -> None:
        """The stage is over."""
        taken = 0.0 if self._said else self._now() - self._began
        if taken >= _LONG_S:
            self._line(f"{self._stage}: done after {_seconds(taken)}")
        self._said = True


def _seconds(seconds: float) -> str:
    """Rounded, in seconds or minutes.

    >>> _seconds(59.6), _seconds(3661.0)
    ('60 s', '61 min')
    """
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


@contextmanager
def _bar() -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    bar = Bar(
        TextColumn("{task.description:<10}"),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    with bar:
        task = bar.add_task("", total=1)
        shown = ""

        def show(stage: str, done: float, total: int) -> None:
            nonlocal shown
            if stage != shown:  # so that the time left is that of the stage
                bar.reset(task)
                shown = stage
            bar.update(task, description=stage, completed=done, total=total)

        yield show
