"""What all tests share: profiles of the property tests, and a browser."""

import os

import pytest
from browser import chromium
from hypothesis import HealthCheck, settings

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


@pytest.fixture(scope="session")
def browser():
    """A browser for all tests of pages, which are skipped with the reason where there is none."""
    with chromium() as started:
        yield started
