"""Which jobs, materials and machines come with the program?"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

__all__ = ["shipped"]

_PACKAGED = Path(__file__).parent / "templates"
_CHECKED_OUT = Path(__file__).parent.parent / "templates"


def shipped(kind: Literal["jobs", "materials", "machines"]) -> dict[str, Path]:
    """Their TOML files by name, sorted."""
    folder = _PACKAGED if _PACKAGED.is_dir() else _CHECKED_OUT
    folder = folder if kind == "jobs" else folder / kind
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}
