"""XML of files from anywhere, parsed as data: nothing is expanded without bound, nothing fetched.

A document type declaration may name an external DTD, which is never read, and may declare entities
that are short plain texts, as Adobe Illustrator writes them; every other entity is refused.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from fab.errors import InvalidFile
from fab.files import shortened
from fab.formats.source_files import shown, source_bytes

__all__ = ["DEEPEST", "MOST_BYTES", "MOST_ELEMENTS", "MOST_ENTITIES", "Document", "read_xml"]

# What is read with less than 1 GB of memory.
MOST_BYTES = 100_000_000
MOST_ELEMENTS = 500_000
DEEPEST = 256
# Entities of a file, and all that they may add to it.
MOST_ENTITIES, _MOST_EXPANDED = 100, 1_000_000
_LONGEST_ENTITY = 1000
_GZIP = b"\x1f\x8b"


@dataclass(frozen=True)
class Document:
    """The root element, and the comments before it, where programs sign."""

    root: ET.Element
    comments: str


class _Refused(Exception):
    """Raised within callbacks of the parser; its text goes on as that of `InvalidFile`."""


def read_xml(path: Path) -> Document:
    """The elements of an XML file.

    One that is compressed (svgz) is unpacked.

    Raises `InvalidFile` for files over 100 MB, unpacked or not, with more than 500,000 elements or
    with elements in each other over 256 deep, for files that are not XML, and for entities that are
    declared as anything but plain text of up to 1000 characters, that are more than 100, or that
    add over 1 MB to the file.
    """
    data = source_bytes(path, MOST_BYTES)
    if data.startswith(_GZIP):
        data = _unpacked(path, data)
    if len(data) > MOST_BYTES:
        raise InvalidFile(
            f"{path}: larger than {MOST_BYTES // 10**6} MB. Split the drawing into several files."
        )
    if not data.strip():
        raise InvalidFile(f"{path}: the file is empty. Save the drawing again.")
    try:
        comments = _inspected(data)
        root = ET.fromstring(data)
    except _Refused as error:
        raise InvalidFile(f"{path}: {error}") from error
    except (expat.ExpatError, ET.ParseError) as error:
        line, column = (
            error.position if isinstance(error, ET.ParseError) else (error.lineno, error.offset)
        )
        what = expat.ErrorString(error.code)
        raise InvalidFile(
            f"{path}: not XML at line {line}, column {column + 1}: {what}. Save the file again "
            "with the program that made it."
        ) from error
    except (LookupError, ValueError) as error:
        raise InvalidFile(
            f"{path}: the encoding of the file cannot be read ({shortened(str(error))}). Save it "
            "as UTF-8."
        ) from error
    return Document(root, comments)


def _unpacked(path: Path, data: bytes) -> bytes:
    """What is in a gzip file, one byte over the bound where it is larger."""
    unpacking = zlib.decompressobj(zlib.MAX_WBITS | 16)
    try:
        plain = unpacking.decompress(data, MOST_BYTES + 1)
    except zlib.error as error:
        raise InvalidFile(
            f"{path}: the compressed file (svgz) is damaged. Save it again, as plain SVG."
        ) from error
    if not unpacking.eof and len(plain) <= MOST_BYTES:
        raise InvalidFile(
            f"{path}: the compressed file (svgz) ends too early. Save it again, as plain SVG."
        )
    return plain


def _inspected(data: bytes) -> str:
    """The comments before the root element; raises `_Refused` for what would not be read safely."""
    parser = expat.ParserCreate()
    parser.ordered_attributes = parser.buffer_text = True
    entities: dict[str, int] = {}
    comments: list[str] = []
    depth = count = letters = 0

    def begin(_name: str, attributes: list[str]) -> None:
        nonlocal depth, count
        added(sum(map(len, attributes)))
        depth += 1
        count += 1
        if depth > DEEPEST:
            raise _Refused(f"elements are within each other over {DEEPEST} deep. Ungroup them.")
        if count > MOST_ELEMENTS:
            raise _Refused(
                f"more than {MOST_ELEMENTS} elements. Join lines of one kind to paths, or split "
                "the drawing into several files."
            )

    def end(_name: str) -> None:
        nonlocal depth
        depth -= 1

    def comment(text: str) -> None:
        if count == 0:
            comments.append(text[:1000])

    def entity(
        name: str,
        is_parameter: bool,
        value: str | None,
        _base: str | None,
        _system: str | None,
        _public: str | None,
        _notation: str | None,
    ) -> None:
        plain = value is not None and not is_parameter and not any(c in value for c in "&%<")
        if not plain or len(value or "") > _LONGEST_ENTITY:
            kind = "refers to another file" if value is None else "is no short plain text"
            raise _Refused(
                f"the entity {shown(name)} {kind}; such entities are refused, as they can read "
                "other files or fill the memory. Save the file as plain SVG."
            )
        entities[name] = len(value or "")
        if len(entities) > MOST_ENTITIES:
            raise _Refused(f"it declares over {MOST_ENTITIES} entities. Save it as plain SVG.")

    def added(length: int) -> None:
        nonlocal letters
        letters += length
        if letters > len(data) + _MOST_EXPANDED:
            raise _Refused("its entities add over 1 MB to the file. Save it as plain SVG.")

    def external(_context: str, _base: str | None, _system: str | None, _public: str | None) -> int:
        raise _Refused("it refers to another file as an entity, which is refused.")

    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    parser.CommentHandler = comment
    parser.CharacterDataHandler = lambda text: added(len(text))
    parser.EntityDeclHandler = entity
    parser.ExternalEntityRefHandler = external
    parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
    parser.Parse(data, True)
    return "\n".join(comments)
