"""Worker processes of a sweep: their limits, and a process for a single variation.

A variation that takes too long is interrupted within its process. One that cannot be interrupted,
because it is within a library, ends its process; so does one that crashes it. The batch is then run
again one variation at a time, each in a process of its own, which says which of them it was.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from typing import Any

from fab.errors import InvalidJob
from fab.sweeps.rows import Batch, ended_row, row_of
from fab.sweeps.sweep_settings import Limits

__all__ = ["alone", "batch_rows", "local_pool", "require_parent"]

# Over the limit, until a process that could not be interrupted is ended.
_GRACE_S = 5.0
_THREADS = (
    *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"),
    *("IGL_NUM_THREADS", "RAYON_NUM_THREADS"),
)
# A worker is made anew after so many batches, so that memory that libraries lose does not add up.
_BATCHES = 200
# Exit code of a process that ends itself because a variation takes too long.
_OVER = 75


@contextmanager
def local_pool(jobs: int, limits: Limits) -> Iterator[Executor]:
    """A pool of processes on this machine, each with one thread. Its processes end with it."""
    with _one_thread():
        _begin_tracker()
        pool = ProcessPoolExecutor(
            jobs,
            multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(limits.memory_mb,),
            max_tasks_per_child=_BATCHES,
        )
        try:
            yield pool
        finally:
            processes = list((pool._processes or {}).values())  # there is no public list of them
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()


def _begin_tracker() -> None:
    """Begin the process that clears up semaphores, which outlives the pool however that ends.

    It heeds neither Ctrl-C nor SIGTERM of its own accord; here nor a terminal that is closed.
    """
    closed = getattr(signal, "SIGHUP", None)
    if closed is None:
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [closed])  # which it inherits
    try:
        resource_tracker.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Libraries in processes that begin within use one thread, as many processes work at once."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _begin(memory_mb: int | None) -> None:
    """In a worker: interrupts are left to the parent, and memory is bounded."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if memory_mb is not None:
        try:
            import resource
        except ImportError:  # not on this system, which bounds no memory
            return
        bound = memory_mb * 1024 * 1024
        resource.setrlimit(resource.RLIMIT_AS, (bound, bound))


def batch_rows(batch: Batch) -> list[dict[str, Any]]:
    """The rows of a batch, in a worker that ends itself where a variation cannot be interrupted."""
    return list(_watched_rows(batch))


def _watched_rows(batch: Batch) -> Iterator[dict[str, Any]]:
    for variation in batch.variations:
        watch = threading.Timer(batch.sweep.limits.seconds + _GRACE_S, os._exit, (_OVER,))
        watch.daemon = True
        watch.start()
        try:
            row = row_of(batch.sweep, variation, batch.folder)
        finally:
            watch.cancel()
        yield row


def alone(batch: Batch) -> list[dict[str, Any]]:
    """The rows of a batch in a process of its own, which says of each when it is done.

    Where it ends before, the variation that it was at has that as its row, and a new process goes
    on with the next. Who killed it from outside may have meant something else: then the variation
    is tried once more. Raises `InvalidJob` where no process begins.
    """
    rows: list[dict[str, Any]] = []
    tried_again = -1
    while len(rows) < len(batch.variations):
        rest = replace(batch, variations=batch.variations[len(rows) :])
        found, code = _until_it_ends(rest)
        rows += found
        at = len(rows)
        if at == len(batch.variations):
            break
        if code in _FROM_OUTSIDE and tried_again != at:
            tried_again = at
            continue
        limit = batch.sweep.limits.seconds
        status, text = (
            ("too slow", f"took more than limits.seconds = {limit:g}, and could not be interrupted")
            if code == _OVER
            else ("crashed", _end_of(code))
        )
        rows.append(ended_row(batch.variations[at], status, text))
    return rows


# Exit codes of processes that somebody killed: the kernel that has no memory left, or a user.
_FROM_OUTSIDE = tuple(-number for number in (signal.SIGTERM, getattr(signal, "SIGKILL", 9)))


def _until_it_ends(batch: Batch) -> tuple[list[dict[str, Any]], int | None]:
    """Rows of a process for a batch, and its exit code where it ended before all were done."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    with _one_thread():
        process = context.Process(target=_send_rows, args=(theirs, batch), daemon=True)
        process.start()
    theirs.close()
    rows: list[dict[str, Any]] = []
    begun = False
    try:
        begun = ours.recv()
        while len(rows) < len(batch.variations):
            rows.append(ours.recv())
    except EOFError as error:
        process.join(_GRACE_S)
        if not begun and process.exitcode not in _FROM_OUTSIDE:
            raise InvalidJob(
                f"processes that work on a sweep cannot begin: {_end_of(process.exitcode)}. "
                f"{_GUARD}"
            ) from error
        return rows, process.exitcode
    finally:
        ours.close()
        process.kill()
        process.join()
    return rows, None


_GUARD = (
    "They import the script that began the sweep: keep what it runs, the call of fab.sweep too, "
    'under `if __name__ == "__main__":`.'
)


def require_parent() -> None:
    """Raise `InvalidJob` where a script runs a sweep while a process of that sweep imports it."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise InvalidJob(f"a process that works on this sweep begins another one. {_GUARD}")


def _send_rows(connection: Connection, batch: Batch) -> None:
    _begin(batch.sweep.limits.memory_mb)
    connection.send(True)
    for row in _watched_rows(batch):
        connection.send(row)


def _end_of(code: int | None) -> str:
    """How a process ended, in words.

    >>> _end_of(-11), _end_of(3)
    ('its process ended by SIGSEGV', 'its process ended with exit code 3')
    """
    if code is not None and code < 0:
        try:
            return f"its process ended by {signal.Signals(-code).name}"
        except ValueError:
            return f"its process ended by signal {-code}"
    return f"its process ended with exit code {code}"
