"""A process that does the work, so that a crash or hang of it ends neither page nor server."""

from __future__ import annotations

import inspect
import multiprocessing
import os
import signal
import threading
import time
import warnings
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from typing import Any

from fab.errors import InvalidJob
from solver.errors import OrigamiError

__all__ = ["Step", "Worker", "WorkerLost", "WorkerStopped"]

# Of the machine's memory that a worker may have: others need some, and so do other workers.
_MEMORY_SHARE = 0.5
# Between two reports of the same stage, so that they do not slow it down.
_REPORT_S = 0.1


class WorkerLost(Exception):
    """The process ended, or was ended, before it answered; the next question starts another."""


class WorkerStopped(WorkerLost):
    """The process was ended because whoever asked wants no answer any more."""


@dataclass(frozen=True)
class Step:
    """How far a question is: its stage, the steps done and all steps of it.

    left : seconds that are left; None while that is not known. since : when it was so far, as
    `time.monotonic` says.
    """

    stage: str
    done: int
    total: int
    left: float | None = None
    since: float = field(default_factory=time.monotonic)

    def report(self) -> dict[str, Any]:
        """What the page is told; the seconds that are left run down while nothing is heard."""
        left = self.left
        if left is not None:
            left = max(0.0, left - (time.monotonic() - self.since))
        return {"stage": self.stage, "done": self.done, "total": self.total, "left": left}


@dataclass
class _Question:
    """A question that waits or is worked on, whose it is, and whether it was stopped."""

    owner: str
    stopped: bool = False
    begun: bool = False
    step: Step = field(default_factory=lambda: Step("waiting", 0, 1))


class Worker:
    """One process that answers one question at a time; others wait.

    module : of the project, whose `TASKS` has the functions by name. One that has a parameter
    `progress` reports to it.
    """

    def __init__(self, module: str = "fab.studio.tasks") -> None:
        self._module = module
        self._lock = threading.Lock()
        self._questions: list[_Question] = []
        self._process: Any = None
        self._link: Connection[Any, Any] | None = None

    def ask(self, task: str, arguments: Mapping[str, Any], seconds: float, owner: str = "") -> Any:
        """What a task returns for arguments by name, within some seconds.

        owner : who asks, and may stop it. Raises `InvalidJob` with the message of any error of the
        project's own, `WorkerStopped` where it was stopped, and `WorkerLost` where the process
        crashed, failed, or took longer.
        """
        question = _Question(owner)
        self._questions.append(question)
        try:
            with self._lock:
                if question.stopped:
                    raise WorkerStopped("it was stopped before it began.")
                kind, value = self._answer(question, task, arguments, seconds)
        finally:
            self._questions.remove(question)
        if kind == "refused":
            raise InvalidJob(value)
        if kind == "failed":
            raise WorkerLost(f"it failed: {value}. That is a defect of quadfold; please report it.")
        return value

    def _answer(
        self, question: _Question, task: str, arguments: Mapping[str, Any], seconds: float
    ) -> tuple[str, Any]:
        question.begun = True
        link = self._started()
        if question.stopped:  # while the process was being started, which nobody could end yet
            raise WorkerStopped("it was stopped before it began.")
        question.step = Step("begun", 0, 1)
        until = time.monotonic() + seconds
        try:
            link.send((task, dict(arguments)))
            while link.poll(max(0.0, until - time.monotonic())):
                kind, value = link.recv()
                if kind != "step":
                    return kind, value
                question.step = Step(*value)
        except (EOFError, OSError) as error:
            code = self._end()
            if question.stopped:
                raise WorkerStopped("it was stopped.") from error
            raise WorkerLost(f"it crashed (exit code {code}); a new process is ready.") from error
        self._end()
        raise WorkerLost(
            f"it took over {seconds:g} seconds and was given up. Smaller numbers of quads are "
            "faster; `quadfold run` has no such bound."
        )

    def step(self, owner: str) -> Step | None:
        """How far the first question of an owner is; None where there is none."""
        own = (question for question in list(self._questions) if question.owner == owner)
        question = next(own, None)
        return None if question is None else question.step

    def stop(self, owner: str | None = None) -> None:
        """End what the worker does for an owner, or for anybody; who waits gets `WorkerStopped`."""
        process = self._process
        for question in list(self._questions):
            if owner is None or question.owner == owner:
                question.stopped = True
                with suppress(ValueError):  # it has ended and been closed
                    if question.begun and process is not None and process.is_alive():
                        process.kill()

    def _started(self) -> Connection[Any, Any]:
        if self._process is None or not self._process.is_alive() or self._link is None:
            self._end()
            context = multiprocessing.get_context("spawn")
            self._link, other = context.Pipe()
            self._process = context.Process(target=_work, args=(other, self._module), daemon=True)
            self._process.start()
            other.close()
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


class _Reports:
    """Steps that are sent to who asked: every stage as it begins, and then now and then."""

    def __init__(self, link: Connection[Any, Any]) -> None:
        self._link = link
        self._stage, self._sent = "", 0.0

    def __call__(self, stage: str, done: float, total: int, left: float | None = None) -> None:
        now = time.monotonic()
        if stage != self._stage or now > self._sent + _REPORT_S:
            self._stage, self._sent = stage, now
            self._link.send(("step", (str(stage), int(done), int(total), left)))


def _work(link: Connection[Any, Any], module: str) -> None:
    """What the process does: answer until nobody asks any more."""
    import importlib

    for number in (signal.SIGINT, signal.SIGTERM):  # the server ends it
        signal.signal(number, signal.SIG_IGN if number == signal.SIGINT else signal.SIG_DFL)
    _bound_memory()
    warnings.simplefilter("ignore", RuntimeWarning)  # of extreme numbers, which an error names
    tasks = importlib.import_module(module).TASKS
    with suppress(EOFError, OSError):
        while True:
            task, arguments = link.recv()
            if "progress" in inspect.signature(tasks[task]).parameters:
                arguments["progress"] = _Reports(link)
            link.send(_answer(tasks[task], arguments))


def _bound_memory() -> None:
    """Let numpy run out of memory before the machine does, where the system has such bounds."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        most = int(_MEMORY_SHARE * whole)
        if hard == resource.RLIM_INFINITY or most < hard:
            resource.setrlimit(resource.RLIMIT_DATA, (most, hard))


def _answer(task: Any, arguments: Mapping[str, Any]) -> tuple[str, Any]:
    try:
        return "made", task(**arguments)
    except OrigamiError as error:
        return "refused", str(error)
    except MemoryError:
        return "refused", "out of memory. Ask for fewer quads."
    except Exception as error:
        return "failed", f"{type(error).__name__}: {str(error)[:200]}"
