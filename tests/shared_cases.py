"""Small inputs after public reports, which lie beside the project and are read in place."""

from pathlib import Path

import pytest
from helpers import SHARED

__all__ = ["shared_case"]


def shared_case(name: str) -> Path:
    """The file or folder of a case; skips where the folder of all cases is missing.

    A case that is missing from a folder that is there is an error: its name is wrong, or it has
    been lost, and a test of it would prove nothing.
    """
    folder = SHARED / "cases"
    if not folder.is_dir():
        pytest.skip(f"no folder {folder.name} in {SHARED.name}, beside the project")
    assert (folder / name).exists(), f"{folder / name} is missing"
    return folder / name
