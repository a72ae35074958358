"""What all tests share: profiles of the property tests, and a browser."""

import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from browser import chromium
from helpers import KEPT
from hypothesis import HealthCheck, settings

from fab.formats.meshes import own_process

# Derandomised where the result must repeat.
settings.register_profile("dev", deadline=None)
settings.register_profile(
    "ci", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


@pytest.fixture(scope="session", autouse=True)
def _no_own_settings(tmp_path_factory):
    """Settings of whoever runs the tests change nothing, here and in processes begun here."""
    os.environ["XDG_CONFIG_HOME"] = str(tmp_path_factory.mktemp("settings"))


@pytest.fixture(scope="session", autouse=True)
def _kept_files(tmp_path_factory, worker_id):
    """A folder for what one process makes and others take (`helpers.template_fold`)."""
    folder = tmp_path_factory.getbasetemp()
    os.environ[KEPT] = str(folder if worker_id == "master" else folder.parent)


@pytest.fixture(scope="session")
def browser():
    """A browser for all tests of pages, which are skipped with the reason where there is none."""
    with chromium() as started:
        yield started


@pytest.fixture
def read_in_this_process(monkeypatch):
    """Files of models are read without starting a process for each, as `test_own_process` does."""

    class Here:
        stdin = None

        def __init__(self, command, **_):
            *_, task, request, answer = command
            own_process._work(task, Path(request), Path(answer))

        def wait(self, seconds):
            return 0

        def poll(self):
            return 0

    monkeypatch.setattr(own_process, "_limit", lambda *_: None)
    names = {"DEVNULL": None, "PIPE": None, "TimeoutExpired": TimeoutError, "Popen": Here}
    monkeypatch.setattr(own_process, "subprocess", SimpleNamespace(**names))
