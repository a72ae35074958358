"""The gallery: all shipped jobs, with what they say of themselves."""

from __future__ import annotations

from fab.catalogue import shipped
from fab.settings import read_toml
from solver import DESIGNS

__all__ = ["templates"]


def templates() -> list[dict[str, str]]:
    """Name, design and description of every shipped job; those that take longest to grow last."""
    documents = {name: read_toml(path, "") for name, path in shipped("jobs").items()}
    found = [
        {
            "name": name,
            "design": str(document["design"]["kind"]),
            "description": str(document.get("description", "")),
        }
        for name, document in documents.items()
    ]
    return sorted(found, key=lambda each: (_place(each["design"]), each["name"]))


def _place(design: str) -> int:
    """Designs as they are listed, but sheets that follow a surface after all others."""
    return len(DESIGNS) if design == "surface_fit" else list(DESIGNS).index(design)
