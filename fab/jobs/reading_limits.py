"""Bounds of all readers of files: size, depth, how many parts, memory.

They are checked before the work that they bound; the documentation shows this table.
"""

from __future__ import annotations

from dataclasses import dataclass

from fab.formats.drawn.line_soup import MOST_LINES
from fab.formats.dxf import document, reader
from fab.formats.fold import frames
from fab.formats.meshes import obj, surface
from fab.formats.oripa import cp, opx, ori
from fab.formats.svg import safe_xml, tree

__all__ = ["LIMITS", "Limit"]


@dataclass(frozen=True)
class Limit:
    """The bounds of a reader.

    Attributes
    ----------
    endings : of the files that it reads.
    largest_bytes : of a file, and of what a compressed one holds.
    depth : how deep parts may be in each other, in words; empty where they are not.
    count : how many parts there may be, in words.
    memory : what bounds the memory, in words.
    """

    endings: tuple[str, ...]
    largest_bytes: int
    depth: str
    count: str
    memory: str


_LINES = f"{MOST_LINES:,} lines"
_BY_SIZE = "by the size of the file, and by the number of lines"
_JSON = "estimated from the file before it is parsed: what is not free is refused"
_OWN = (
    f"a process of its own: {surface.MEMORY_MB:,} MB, and {surface.MEMORY_MB_PER_MB} MB for each "
    f"MB of the file; {surface.SECONDS} s, and {surface.SECONDS_PER_MB} s for each MB"
)
LIMITS = (
    Limit(
        (".fold",),
        frames.LARGEST_BYTES,
        "that of the JSON parser, some hundred",
        f"without faces {_LINES}",
        _JSON,
    ),
    Limit(
        (".svg", ".svgz"),
        safe_xml.MOST_BYTES,
        f"{safe_xml.DEEPEST} elements, {tree.DEEPEST_USE} references (`use`)",
        f"{safe_xml.MOST_ELEMENTS:,} elements, {tree.MOST_SHAPES:,} shapes, {_LINES}, "
        f"{safe_xml.MOST_ENTITIES} entities, which add 1 MB",
        _BY_SIZE,
    ),
    Limit((".dxf",), document.LARGEST_BYTES, f"{reader.DEEPEST} blocks", _LINES, _BY_SIZE),
    Limit((".cp",), cp.LARGEST_BYTES, "", _LINES, _BY_SIZE),
    Limit(
        (".opx",),
        opx.LARGEST_BYTES,
        f"{opx.DEEPEST} elements",
        f"{opx.MOST_ELEMENTS:,} elements, {_LINES}",
        _BY_SIZE,
    ),
    Limit((".ori", ".orh"), ori.LARGEST_BYTES, "as in FOLD files", _LINES, _JSON),
    Limit((".obj",), obj.LARGEST_BYTES, "", "as a pattern: any, as its size allows", _BY_SIZE),
    Limit(
        (".stl", ".ply", ".off", ".obj"),
        surface.LARGEST_BYTES,
        "",
        "any; over 100,000 triangles are made fewer",
        f"{_BY_SIZE.partition(',')[0]}; over {surface.LARGE_MESH_BYTES / 1e6:g} MB, {_OWN}",
    ),
    Limit((".glb", ".3mf"), surface.LARGEST_BYTES, "20 components", "as of other meshes", _OWN),
    Limit((".step", ".stp"), surface.LARGEST_BYTES, "", "any", _OWN),
)
