"""DXF files of any version as documents of ezdxf, or a refusal in plain words."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import ezdxf
from ezdxf import recover
from ezdxf.document import Drawing
from ezdxf.lldxf.encoding import decode_dxf_unicode, has_dxf_unicode
from ezdxf.lldxf.tagger import binary_tags_loader

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.source_files import shown, source_bytes

__all__ = ["mm_per_unit_of", "read_document", "unit_findings"]

# About 800,000 lines.
LARGEST_BYTES = 100_000_000
_BINARY = b"AutoCAD Binary DXF\r\n\x1a\x00"
_FEET, _MILE = 304.8, 1_609_344.0
_SURVEY_FEET = 1_200_000.0 / 3937
# Millimetres per unit by $INSUNITS.
_MM = {
    1: 25.4,
    2: _FEET,
    3: _MILE,
    4: 1.0,
    5: 10.0,
    6: 1e3,
    7: 1e6,
    8: 25.4e-6,
    9: 25.4e-3,
    10: 3 * _FEET,
    11: 1e-7,
    12: 1e-6,
    13: 1e-3,
    14: 100.0,
    15: 1e4,
    16: 1e5,
    17: 1e12,
    18: 149_597_870_700e3,
    19: 9_460_730_472_580_800e3,
    20: 3.085677581491367e19,
    21: _SURVEY_FEET,
    22: _SURVEY_FEET / 12,
    23: 3 * _SURVEY_FEET,
    24: 5280 * _SURVEY_FEET,
}


def read_document(path: Path) -> tuple[Drawing, tuple[Finding, ...]]:
    """The document of a DXF file of up to 100 MB, text or binary, R12 to R2018 and before.

    A file that breaks the rules of the format is recovered as far as may be: finding
    "file-recovered". Raises `InvalidFile` for what cannot be, and for DWG files.
    """
    data = source_bytes(path, LARGEST_BYTES)
    if data[:2] == b"AC" and data[2:6].isdigit():
        raise InvalidFile(
            f"{path}: a DWG file under the name of a DXF file. Save it as DXF, in AutoCAD, "
            "LibreCAD, FreeCAD or the ODA File Converter."
        )
    with _silent():
        if data.startswith(_BINARY):
            return _named_unit(_binary(path, data), data), ()
        if b"\0" in data:
            raise InvalidFile(
                f"{path}: neither a text file nor a binary DXF file. Export it again."
            )
        if b"\n" not in data:  # lines of old Macintosh programs
            data = data.replace(b"\r", b"\n")
        if b"SECTION" not in data:
            raise InvalidFile(f"{path}: it has no section of a DXF file. Export it as DXF.")
        try:
            return _named_unit(_plain(data), data), ()
        except Exception as error:  # ezdxf raises whatever a damaged file leads to
            broken = str(error) or type(error).__name__
        try:
            document, auditor = recover.read(io.BytesIO(data))
        except Exception as error:
            reason = shown(str(error)) if str(error) else "its structure is damaged"
            raise InvalidFile(
                f"{path}: the DXF file cannot be read: {reason}. Export it again as DXF, of "
                "version R2000 or R12."
            ) from error
    count = max(1, len(auditor.errors) + len(auditor.fixes))
    text = (
        f"the file breaks the rules of DXF and was recovered with {count} "
        f"{'repair' if count == 1 else 'repairs'}, first: {shown(broken)}. Compare the result with "
        "the drawing."
    )
    return _named_unit(document, data), (Finding("file-recovered", Severity.WARNING, text),)


def mm_per_unit_of(document: Drawing) -> float | None:
    """Millimetres per unit by $INSUNITS; None where the file has none, 0, or an unknown one."""
    return _MM.get(_number(document, "$INSUNITS"))


def unit_findings(document: Drawing) -> tuple[Finding, ...]:
    """What the header says of a unit that it does not name. Code: "unit-imperial"."""
    if mm_per_unit_of(document) is not None or _number(document, "$MEASUREMENT", 1) != 0:
        return ()
    text = (
        "the file names no unit, but is marked as imperial ($MEASUREMENT = 0): its unit may be an "
        "inch. Say so with --mm-per-unit 25.4."
    )
    return (Finding("unit-imperial", Severity.WARNING, text),)


def _number(document: Drawing, name: str, default: int = 0) -> int:
    try:
        return int(document.header.get(name, default))
    except (TypeError, ValueError, OverflowError):
        return default


def _plain(data: bytes) -> Drawing:
    head = io.StringIO(data.decode("utf-8", "ignore"), newline=None)
    encoding = ezdxf.filemanagement.dxf_stream_info(head).encoding
    text = data.decode(encoding, "surrogateescape").removeprefix("\ufeff")
    if has_dxf_unicode(text):  # \\U+5C71: what is not in the code page of R12 to R2004
        text = decode_dxf_unicode(text)
    return ezdxf.read(io.StringIO(text, newline=None))


def _named_unit(document: Drawing, data: bytes) -> Drawing:
    """The document without the metres that ezdxf gives to a file whose header names no unit."""
    if b"$INSUNITS" not in data:
        document.header["$INSUNITS"] = 0
    return document


def _binary(path: Path, data: bytes) -> Drawing:
    try:
        return Drawing.load(binary_tags_loader(data))
    except Exception as error:
        raise InvalidFile(
            f"{path}: a binary DXF file that cannot be read. Save it as text (ASCII) DXF."
        ) from error


@contextmanager
def _silent() -> Iterator[None]:
    """Warnings of ezdxf held back: what matters of them becomes findings."""
    logger = logging.getLogger("ezdxf")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)
