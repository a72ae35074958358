"""Crease patterns in files of all formats: the reader is chosen by ending and content."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

from fab.errors import InvalidFile
from fab.files import require_file
from fab.formats.drawn.importer import pattern_of_lines
from fab.formats.fold.reader import read_fold
from fab.formats.meshes.obj_patterns import read_obj_pattern
from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions

__all__ = ["READ", "read_pattern_file"]

# Readers of drawings, by ending: each gives the lines of a file.
_DRAWINGS = {
    ".svg": ("svg.reader", "read_svg"),
    ".svgz": ("svg.reader", "read_svg"),
    ".dxf": ("dxf.reader", "read_dxf"),
    ".cp": ("oripa.cp", "read_cp"),
    ".opx": ("oripa.opx", "read_opx"),
    ".ori": ("oripa.ori", "read_ori"),
    ".orh": ("oripa.ori", "read_ori"),
}
READ = (".fold", *_DRAWINGS, ".obj")
# What files without such an ending begin with.
_HEAD_BYTES = 4096
_BEGINNINGS = {
    ".svg": re.compile(rb"\s*(<\?xml.*?)?(<!.*?>\s*)*<(\w+:)?svg\b", re.DOTALL),
    ".opx": re.compile(rb"\s*(<\?xml.*?\?>\s*)?<java\b", re.DOTALL),
    ".dxf": re.compile(rb"(\s*999\r?\n.*\r?\n)*\s*0\r?\n\s*SECTION\b|AutoCAD Binary DXF"),
    ".fold": re.compile(rb"(\xef\xbb\xbf)?\s*\{"),
    ".cp": re.compile(rb"\s*[0-9]+(\s+[-+.0-9eE]+){4}\s*[\r\n]"),
    ".obj": re.compile(rb"(\s*(#.*|[a-z]+ .*)?\n)*?\s*v(\s+[-+.0-9eE]+){3}"),
}


def read_pattern_file(path: str | Path, options: ReadOptions | None = None) -> PatternFile:
    """The crease pattern in a file, in millimetres, its lower left corner at the origin.

    Raises `InvalidFile` with the place and the cure for what cannot be read.
    """
    options = ReadOptions() if options is None else options
    file = Path(path)
    require_file(file, InvalidFile, "Check the path of the drawing.")
    ending = file.suffix.lower()
    if ending not in READ:
        ending = _ending_by_content(file)
    if ending == ".fold":
        return read_fold(file, options)
    if options.frame not in (None, 1):
        raise InvalidFile(
            f"{path}: --frame {options.frame}: the file has 1 crease pattern. Give 1."
        )
    if ending == ".obj":
        return read_obj_pattern(file, options)
    module, function = _DRAWINGS[ending]
    reader = getattr(importlib.import_module(f"fab.formats.{module}"), function)
    return pattern_of_lines(reader(file, options), options)


def _ending_by_content(file: Path) -> str:
    """The ending that suits what is in a file."""
    with file.open("rb") as stream:
        head = stream.read(_HEAD_BYTES)
    for ending, beginning in _BEGINNINGS.items():
        if beginning.match(head):
            return ending
    raise InvalidFile(f"{file}: not a crease pattern. Files that are read: {', '.join(READ)}.")
