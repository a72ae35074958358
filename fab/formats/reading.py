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
# What files without such an ending begin with. Each pattern fits a beginning in one way only, so
# that no file takes long to refuse.
_HEAD_BYTES = 4096
_BEGINNINGS = {
    ".dxf": re.compile(rb"(?:\s*999\r?\n[^\r\n]*\r?\n)*\s*0\r?\n\s*SECTION\b|AutoCAD Binary DXF"),
    ".fold": re.compile(rb"(?:\xef\xbb\xbf)?\s*\{"),
    ".cp": re.compile(rb"\s*[0-9]+(?:\s+[-+.0-9eE]+){4}\s*[\r\n]"),
    ".obj": re.compile(
        rb"(?:[ \t]*(?:#[^\r\n]*|(?!v\s)[a-z]+ [^\r\n]*)?\r?\n)*"
        rb"[ \t]*v(?:[ \t]+[-+.0-9eE]+){3}"
    ),
}
# The first element of XML, by its name without a prefix, behind all comments.
_XML = re.compile(rb"(?:\xef\xbb\xbf)?\s*<")
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_FIRST_ELEMENT = re.compile(rb"<(?:[A-Za-z_][\w.-]*:)?([A-Za-z_][\w.-]*)")
_ENDINGS_BY_ELEMENT = {b"svg": ".svg", b"java": ".opx"}


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
    if _XML.match(head):
        element = _FIRST_ELEMENT.search(_COMMENT.sub(b"", head))
        if element and element.group(1) in _ENDINGS_BY_ELEMENT:
            return _ENDINGS_BY_ELEMENT[element.group(1)]
    for ending, beginning in _BEGINNINGS.items():
        if beginning.match(head):
            return ending
    raise InvalidFile(f"{file}: not a crease pattern. Files that are read: {', '.join(READ)}.")
