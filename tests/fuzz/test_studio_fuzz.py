"""A short run of the fuzzer of the studio; `studio_run.py` beside it makes long ones."""

import pytest
from fuzz.studio_faults import HOST, Designs, answered, designs, files_under, malformed, numbered
from starlette.testclient import TestClient

from fab.studio.app import Studio, studio_app

# Designs that take more than a second to grow are left to long runs.
SLOW = {"surface_fit", "tilted_rings"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("outside") / "studio"
    made.mkdir()
    (made / "link").symlink_to(made.parent)
    (made.parent / "x.toml").write_text("outside", encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def client(folder):
    app = studio_app(Studio(folder, "token"), frozenset({HOST}))
    with TestClient(app, base_url=f"http://{HOST}/token/") as made:
        yield made


def test_malformed_messages_are_answered_and_change_nothing_outside(client, folder):
    def outside():
        return {name for name in files_under(folder.parent).items() if "studio/" not in name[0]}

    before = outside()
    kinds = set()
    for generator in numbered(7, 100):
        outcome = answered(client, malformed(generator))
        assert outcome.kind != "fault", outcome.text
        kinds.add(outcome.text)
    assert {"200", "400", "403", "404"} <= kinds
    assert outside() == before


@pytest.mark.parametrize("kind", sorted(set(designs()) - SLOW))
def test_random_parameters_grow_or_are_refused(client, kind):
    tried, kinds = Designs(client), set()
    for generator in numbered(7, 15):
        outcome = tried.grown(designs()[kind], generator)
        assert outcome.kind != "fault", outcome.text
        kinds.add(outcome.kind)
    assert kinds == {"grown", "refused"}
