"""Memory that a reader may take: what the system has free."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["free_bytes"]


def free_bytes() -> int | None:
    """Memory that can be had without swapping; None where the system does not say."""
    try:
        with Path("/proc/meminfo").open(encoding="ascii") as rows:
            found = [row.split()[1] for row in rows if row.startswith("MemAvailable:")]
        if found:
            return int(found[0]) * 1024
    except OSError:  # no Linux
        pass
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_AVPHYS_PAGES")
    except (OSError, ValueError, AttributeError):  # neither macOS nor Windows
        return None
