"""All kinds of input that are fuzzed, by name."""

from __future__ import annotations

from fuzz.command_kinds import COMMAND_KINDS
from fuzz.kept_kinds import KEPT_KINDS
from fuzz.mesh_kinds import MESH_KINDS
from fuzz.pattern_kinds import PATTERN_KINDS
from fuzz.product_kinds import PRODUCT_KINDS
from fuzz.studio_kinds import STUDIO_KINDS
from fuzz.table_kinds import TABLE_KINDS

__all__ = ["KINDS"]

KINDS = {
    kind.name: kind
    for kind in (
        *TABLE_KINDS,
        *PATTERN_KINDS,
        *MESH_KINDS,
        *KEPT_KINDS,
        *COMMAND_KINDS,
        *STUDIO_KINDS,
        *PRODUCT_KINDS,
    )
}
