"""One studio for all tests of its page."""

import pytest
from helpers import TEMPLATES
from studio_pages import Served, studio_tab, verdict, wait_until


@pytest.fixture(scope="package")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("studio_page")
    text = (TEMPLATES / "miura.toml").read_text(encoding="utf-8")
    (made / "own.toml").write_text(text.replace("columns = 10 ", "columns = 6 "), encoding="utf-8")
    return made


@pytest.fixture(scope="package")
def served(browser, folder):
    made = Served(folder, "own.toml")
    yield made
    assert made.end()[0] == 0


@pytest.fixture
def page(browser, served):
    """The studio with a job, whose sheet has grown and folds, in a tab of its own."""
    with studio_tab(browser, served.address) as made:
        wait_until(made, lambda: verdict(made).startswith("grown"))
        wait_until(made, made.locator("#fold").is_enabled)  # its states have come
        yield made
