"""The worker: what happens to it is reported, and the next question finds another."""

import threading

import pytest

from fab.errors import InvalidJob
from fab.studio.worker import Worker, WorkerLost


@pytest.fixture
def worker():
    made = Worker("studio_answers")
    yield made
    made.close()


def test_one_process_answers_until_it_is_lost(worker):
    first = worker.ask("pid", {}, 60)
    assert worker.ask("pid", {}, 60) == first
    with pytest.raises(InvalidJob, match="rows = 0"):
        worker.ask("refuse", {}, 60)
    with pytest.raises(WorkerLost, match="ZeroDivisionError: by design"):
        worker.ask("fail", {}, 60)
    assert worker.ask("pid", {}, 60) == first
    with pytest.raises(WorkerLost, match="crashed \\(exit code 7\\)"):
        worker.ask("crash", {}, 60)
    second = worker.ask("pid", {}, 60)
    assert second != first
    with pytest.raises(WorkerLost, match=r"over 0\.2 seconds"):
        worker.ask("hang", {}, 0.2)
    assert worker.ask("pid", {}, 60) not in (first, second)


def test_what_takes_too_long_is_stopped_by_the_user(worker):
    first = worker.ask("pid", {}, 60)
    threading.Timer(0.3, worker.stop).start()
    with pytest.raises(WorkerLost, match="it was stopped"):
        worker.ask("hang", {}, 60)
    assert worker.ask("pid", {}, 60) != first
