"""The gallery: all shipped jobs, with what they say of themselves."""

from __future__ import annotations

from fab.catalogue import shipped, template_groups
from fab.settings import read_toml

__all__ = ["templates"]


def templates() -> list[dict[str, str]]:
    """Name, design and description of every shipped job, what is of use first."""
    documents = {name: read_toml(path, "") for name, path in shipped("jobs").items()}
    return [
        {
            "name": name,
            "design": str(document["design"]["kind"]),
            "description": str(document.get("description", "")),
        }
        for names in template_groups().values()
        for name, document in ((name, documents[name]) for name in names)
    ]
