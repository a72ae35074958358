"""What tests of sweeps share: a pool that starts no processes."""

from concurrent.futures import Executor, Future
from contextlib import contextmanager

import pytest


class Here(Executor):
    """Runs what it is given at once, in this process."""

    def submit(self, function, /, *words, **named):
        future = Future()
        try:
            future.set_result(function(*words, **named))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def here(monkeypatch):
    """Sweeps run in this process: for tests of what is swept, and not of who does it."""

    @contextmanager
    def pool(jobs, limits):
        yield Here()

    monkeypatch.setattr("fab.sweeps.sweep_run.local_pool", pool)
