"""All codes of findings: what each means, what causes it, and what cures it."""

from __future__ import annotations

from fab.findings.explanation import Explanation
from fab.findings.table import FAMILIES, explained, find

__all__ = ["FAMILIES", "Explanation", "explained", "find"]
