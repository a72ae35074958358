"""A process that does the work, so that a crash or hang of it ends neither page nor server."""

from __future__ import annotations

import multiprocessing
import signal
import threading
import warnings
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from fab.errors import InvalidJob
from solver.errors import OrigamiError

__all__ = ["Worker", "WorkerLost"]


class WorkerLost(Exception):
    """The process ended, or was ended, before it answered; the next question starts another."""


class Worker:
    """One process that answers one question at a time; others wait.

    module : of the project, whose `TASKS` has the functions by name.
    """

    def __init__(self, module: str = "fab.studio.tasks") -> None:
        self._module = module
        self._lock = threading.Lock()
        self._process: Any = None
        self._link: Connection[Any, Any] | None = None
        self._stopped = False

    def ask(self, task: str, arguments: Mapping[str, Any], seconds: float) -> Any:
        """What a task returns for arguments by name, within some seconds.

        Raises `InvalidJob` with the message of any error of the project's own, and `WorkerLost`
        where the process crashed, failed, was stopped, or took longer.
        """
        with self._lock:
            link = self._started()
            try:
                link.send((task, dict(arguments)))
                if not link.poll(seconds):
                    self._end()
                    raise WorkerLost(
                        f"it took over {seconds:g} seconds and was given up. Smaller numbers of "
                        "quads are faster; `quadfold run` has no such bound."
                    )
                kind, value = link.recv()
            except (EOFError, OSError) as error:
                code, stopped = self._end(), self._stopped
                why = "it was stopped" if stopped else f"it crashed (exit code {code})"
                raise WorkerLost(f"{why}; a new process is ready.") from error
        if kind == "refused":
            raise InvalidJob(value)
        if kind == "failed":
            raise WorkerLost(f"it failed: {value}. That is a defect of quadfold; please report it.")
        return value

    def stop(self) -> None:
        """End what it does; who waits for it gets `WorkerLost`."""
        self._stopped = True
        process = self._process
        if process is not None and process.is_alive():
            process.kill()

    def _started(self) -> Connection[Any, Any]:
        if self._process is None or not self._process.is_alive() or self._link is None:
            self._end()
            context = multiprocessing.get_context("spawn")
            self._link, other = context.Pipe()
            self._process = context.Process(target=_work, args=(other, self._module), daemon=True)
            self._process.start()
            other.close()
        self._stopped = False
        return self._link

    def _end(self) -> int | None:
        """End the process, and return the exit code that it had."""
        process, link = self._process, self._link
        self._process = self._link = None
        if link is not None:
            link.close()
        if process is None:
            return None
        process.join(0.5)
        if process.is_alive():
            process.kill()
            process.join()
        code: int | None = process.exitcode
        process.close()
        return code

    def close(self) -> None:
        """End the process for good."""
        self.stop()
        with self._lock:
            self._end()


def _work(link: Connection[Any, Any], module: str) -> None:
    """What the process does: answer until nobody asks any more."""
    import importlib

    for number in (signal.SIGINT, signal.SIGTERM):  # the server ends it
        signal.signal(number, signal.SIG_IGN if number == signal.SIGINT else signal.SIG_DFL)
    warnings.simplefilter("ignore", RuntimeWarning)  # of extreme numbers, which an error names
    tasks = importlib.import_module(module).TASKS
    with suppress(EOFError, OSError):
        while True:
            task, arguments = link.recv()
            link.send(_answer(tasks[task], arguments))


def _answer(task: Any, arguments: Mapping[str, Any]) -> tuple[str, Any]:
    try:
        return "made", task(**arguments)
    except OrigamiError as error:
        return "refused", str(error)
    except MemoryError:
        return "refused", "out of memory. Ask for fewer quads."
    except Exception as error:
        return "failed", f"{type(error).__name__}: {str(error)[:200]}"
