"""Engine of a sweep: batches of variations on an executor, of processes or of a cluster."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from typing import Any

from fab.progress import Steps, no_steps
from fab.sweeps.rows import Batch
from fab.sweeps.workers import alone, batch_rows

__all__ = ["Pool", "Rows", "run_batches"]

Rows = list[dict[str, Any]]
# So long is a batch aimed at; what is lost at most when everything is killed.
_BATCH_S = 4.0
_MOST = 50
# Batches that wait for each worker, so that none is idle.
_AHEAD = 2
# How often the engine looks around, so that an interrupt is seen.
_LOOK_S = 0.5


@dataclass(frozen=True)
class Pool:
    """Where batches are run.

    Attributes
    ----------
    executor : makes one; again where it broke, because a process was killed or crashed.
    workers : how many batches it runs at a time.
    lost : errors of a future which mean that the batch killed its worker.
    """

    executor: Callable[[], AbstractContextManager[Executor]]
    workers: int
    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)


@dataclass
class _Sizes:
    """How many variations a batch has: as many as take some seconds, by those that are done."""

    workers: int
    whole: int
    seconds: float = 0.0
    done: int = 0
    begun: int = field(default=0)

    def next_size(self) -> int:
        if not self.done:
            return 1
        fair = -(-(self.whole - self.begun) // (2 * self.workers))  # so that all end together
        aimed = int(_BATCH_S * self.done / max(self.seconds, 1e-6))
        return max(1, min(_MOST, aimed, fair))


def run_batches(
    batch_of: Callable[[int], Batch | None],
    whole: int,
    pool: Pool,
    keep: Callable[[Rows], None],
    progress: Steps = no_steps,
    *,
    most: int = _MOST,
    ahead: int = _AHEAD,
) -> None:
    """Run all variations, and keep the rows of each batch as it is done.

    Parameters
    ----------
    batch_of : gives the next batch of so many variations, or None when there are no more.
    whole : how many variations there are.
    keep : is called with the rows of a batch, in this process.
    progress : called with the variations that are done.
    most : variations in a batch. ahead : batches for each worker, at work or waiting.

    What an executor cannot do (a cluster that is gone) is raised as it comes.
    """
    sizes = _Sizes(pool.workers, whole)
    suspects: list[Batch] = []
    done = 0

    def kept(rows: Rows, seconds: float) -> None:
        nonlocal done
        keep(rows)
        done += len(rows)
        sizes.done += len(rows)
        sizes.seconds += seconds
        progress(done, whole)

    exhausted = False
    while not exhausted or suspects:
        for suspect in _drained(suspects):
            began = time.monotonic()
            kept(alone(suspect), time.monotonic() - began)
        with pool.executor() as executor:
            flying: dict[Future[Rows], Batch] = {}
            while True:
                while not exhausted and len(flying) < ahead * pool.workers:
                    batch = batch_of(min(most, sizes.next_size()))
                    if batch is None:
                        exhausted = True
                        break
                    sizes.begun += len(batch.variations)
                    if not _submitted(executor, batch, flying):
                        suspects.append(batch)
                        break
                if suspects or not flying:
                    break
                finished, _ = wait(flying, _LOOK_S, FIRST_COMPLETED)
                progress(done, whole)
                for future in finished:
                    batch = flying.pop(future)
                    try:
                        rows = future.result()
                    except pool.lost:
                        suspects.append(batch)
                        continue
                    kept(rows, sum(row["seconds"] or 0.0 for row in rows))
            suspects += _undone(flying, pool, kept)


def _submitted(executor: Executor, batch: Batch, flying: dict[Future[Rows], Batch]) -> bool:
    try:
        flying[executor.submit(batch_rows, batch)] = batch
    except BrokenExecutor:
        return False
    return True


def _undone(
    flying: dict[Future[Rows], Batch], pool: Pool, kept: Callable[[Rows, float], None]
) -> list[Batch]:
    """What was at work when the executor broke; what was done by then is kept."""
    out = []
    for future, batch in flying.items():
        rows: Rows | None = None
        with suppress(TimeoutError), suppress(*pool.lost):
            rows = future.result(timeout=_LOOK_S)
        if rows is None:
            out.append(batch)
        else:
            kept(rows, sum(row["seconds"] or 0.0 for row in rows))
    return out


def _drained(batches: list[Batch]) -> Iterator[Batch]:
    while batches:
        yield batches.pop(0)
