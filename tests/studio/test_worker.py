"""The worker: what happens to it is reported, and the next question finds another."""

import multiprocessing
import sys
import threading
import time

import pytest

from fab.errors import InvalidJob
from fab.studio.worker import Step, Worker, WorkerLost, WorkerStopped


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


@pytest.mark.skipif(sys.platform != "linux", reason="bounds of memory are those of Linux")
def test_the_memory_of_a_worker_is_bounded(worker):
    first = worker.ask("pid", {}, 60)
    with pytest.raises(InvalidJob, match="out of memory"):
        worker.ask("hog", {}, 60)
    assert worker.ask("pid", {}, 60) == first


def test_what_takes_too_long_is_stopped_by_the_user(worker):
    first = worker.ask("pid", {}, 60)
    threading.Timer(0.3, worker.stop).start()
    with pytest.raises(WorkerStopped):
        worker.ask("hang", {}, 60)
    assert worker.ask("pid", {}, 60) != first


def test_what_is_stopped_while_its_process_starts_is_not_begun(worker, monkeypatch):
    context = multiprocessing.get_context

    def stopping(how):
        worker.stop()
        return context(how)

    monkeypatch.setattr(multiprocessing, "get_context", stopping)
    with pytest.raises(WorkerStopped):
        worker.ask("hang", {}, 60)


def asked(worker, owner, found):
    """Ask in a thread for what never ends, and note how it ended."""

    def ask():
        try:
            worker.ask("steps", {}, 60, owner)
        except WorkerLost as error:
            found[owner] = type(error)

    thread = threading.Thread(target=ask)
    thread.start()
    return thread


def test_owners_see_and_stop_their_own_questions(worker):
    found = {}
    threads = [asked(worker, "a", found)]
    wait_until(lambda: (step := worker.step("a")) is not None and step.stage == "second")
    report = worker.step("a").report()
    assert report == {"stage": "second", "done": 1, "total": 4, "left": None}
    threads.append(asked(worker, "b", found))
    wait_until(lambda: worker.step("b") is not None)
    assert worker.step("b").stage == "waiting"
    worker.stop("c")
    worker.stop("b")  # which waits for a
    assert worker.step("a").stage == "second"
    worker.stop("a")
    for thread in threads:
        thread.join(30)
    assert found == {"a": WorkerStopped, "b": WorkerStopped}
    assert worker.step("a") is None
    assert isinstance(worker.ask("pid", {}, 60), int)


def test_seconds_left_run_down():
    assert 2.5 < Step("x", 0, 1, 3.0).report()["left"] <= 3.0
    assert Step("x", 0, 1, 3.0, since=time.monotonic() - 2).report()["left"] == pytest.approx(
        1, abs=0.1
    )
    assert Step("x", 0, 1, 3.0, since=0.0).report()["left"] == 0.0


def wait_until(true):
    until = time.monotonic() + 30
    while not true():
        assert time.monotonic() < until
        time.sleep(0.02)
