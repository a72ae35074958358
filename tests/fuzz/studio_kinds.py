"""Messages to a studio, as pages that are not its own might send them."""

from __future__ import annotations

import atexit
import json
import random
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from fuzz.studio_faults import HOST, Message, answered, files_under, malformed
from fuzz.trials import Kind

from fab.studio.app import Studio, studio_app

__all__ = ["STUDIO_KINDS"]

# One of so many messages is followed by a look at the files around the studio's folder.
_LOOKED = 50


def _written(numbers: np.random.Generator) -> bytes:
    return malformed(random.Random(int(numbers.integers(2**63)))).packed()


@cache
def _client() -> tuple[Any, Path, dict[str, str]]:
    """A studio of this process, its folder, and the files around that as they should stay."""
    from starlette.testclient import TestClient

    outside = Path(tempfile.mkdtemp(prefix="fuzzed-studio-"))
    atexit.register(shutil.rmtree, outside, ignore_errors=True)
    folder = outside / "studio"
    folder.mkdir()
    (folder / "link").symlink_to(outside)
    (outside / "x.toml").write_text("outside")
    client = TestClient(
        studio_app(Studio(folder, "token"), frozenset({HOST})), f"http://{HOST}/token/"
    )
    client.__enter__()
    return client, folder, _around(folder)


def _around(folder: Path) -> dict[str, str]:
    every = files_under(folder.parent)
    return {name: digest for name, digest in every.items() if not name.startswith("studio/")}


def _sent(path: Path, numbers: np.random.Generator) -> str:
    client, folder, before = _client()
    outcome = answered(client, Message(**json.loads(path.read_bytes())))
    assert outcome.kind != "fault", outcome.text
    if numbers.integers(_LOOKED) == 0:
        assert _around(folder) == before, "a file outside the folder has changed"
        for each in folder.iterdir():
            if each.is_file() and not each.is_symlink():
                each.unlink()
    return ""


STUDIO_KINDS = (
    Kind("message", "message.json", _written, _sent, seconds=30.0, share=2.0, opens=True),
)
