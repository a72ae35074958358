"""Drawings: cut paths by operation, and their files. Knows nothing of patterns.

- `cut_paths`: lines by operation (`CutPaths`, `Layer`, `Operation`).
- `layer_colours`: the colour of each operation.
- `drawing_files`: files in the formats asked for; a new format is added to `SheetFormat`.
- `dxf`, `svg`, `pdf`: a writer each; `number_records`: millions of numbers as text.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fab.drawings.cut_paths import CutPaths, Layer, Operation
    from fab.drawings.drawing_files import SheetFormat

__all__ = ["CutPaths", "Layer", "Operation", "SheetFormat"]

_MODULES = {
    "CutPaths": "cut_paths",
    "Layer": "cut_paths",
    "Operation": "cut_paths",
    "SheetFormat": "drawing_files",
}


def __getattr__(name: str) -> Any:
    """The public names, whose modules are imported when they are first asked for."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
