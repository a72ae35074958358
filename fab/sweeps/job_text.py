"""Jobs as TOML files, from their tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["job_bytes"]


def job_bytes(document: Mapping[str, Any]) -> bytes:
    """The tables of a job as TOML.

    >>> job_bytes({"name": "a", "design": {"kind": "miura", "fold_deg": 30.0}}).decode().split()
    ['name', '=', '"a"', '[design]', 'kind', '=', '"miura"', 'fold_deg', '=', '30.0']
    """
    import tomlkit

    # values before tables, as TOML has them
    ordered = sorted(document.items(), key=lambda item: isinstance(item[1], Mapping))
    return tomlkit.dumps(dict(ordered)).encode()
