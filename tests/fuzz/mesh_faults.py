"""Faults of mesh and CAD files: STL, PLY, OFF, OBJ, GLB, 3MF and STEP.

Counts in headers that the rest does not have, indices of no vertex, numbers without an end, parts
of the file lost or repeated, references to themselves and to nothing, archives of more than they
seem, other files named.
"""

from __future__ import annotations

import io
import json
import re
import struct
import zipfile
from collections.abc import Callable

import numpy as np
from fuzz.written_faults import (
    byte_faults,
    element_faults,
    entity_faults,
    json_faults,
    number_faults,
    row_faults,
)

from fab.outputs import zip_bytes

__all__ = ["with_mesh_faults"]

Random = np.random.Generator
Fault = Callable[[Random, bytes], bytes]
_COUNTS = (0, 1, 2, 255, 65535, 65536, 10**6, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1)
_FLOATS = (0.0, np.nan, np.inf, -np.inf, 1e-45, 1e-30, 1e30, 3e38, -3e38, 1e-20)


def _of(random: Random, values):
    return values[int(random.integers(len(values)))]


def _word_faults(random: Random, data: bytes) -> bytes:
    """Four bytes at a place, by which counts, indices, offsets and coordinates are stored."""
    if len(data) < 8:
        return data
    out = bytearray(data)
    for _ in range(int(random.integers(1, 4))):
        near = (80, 84, 96, 12, 16, 20, 8)
        place = _of(random, near) if random.integers(2) else int(random.integers(len(out)))
        place = min(max(place, 0), len(out) - 4)
        if random.integers(2):
            word = struct.pack("<f", _of(random, _FLOATS))
        else:
            word = struct.pack(_of(random, ("<I", ">I")), _of(random, _COUNTS))
        out[place : place + 4] = word
    return bytes(out)


def _cut(random: Random, data: bytes) -> bytes:
    """The file without its end, or with more of it."""
    if random.integers(4) == 0:
        return data + data[: int(random.integers(len(data) + 1))]
    return data[: int(random.integers(len(data) + 1))]


def _count_faults(random: Random, data: bytes) -> bytes:
    """Counts in the head of a PLY or OFF file."""
    counts = rb"(element +\w+ +|\A\s*OFF\s+)(-?\d+)"
    found = list(re.finditer(counts, data[:2000]))
    if not found:
        return number_faults(random, data)
    one = _of(random, found)
    new = str(_of(random, (*_COUNTS, -1, 10**12, 10**30))).encode()
    return data[: one.start(2)] + new + data[one.end(2) :]


def _ply_head(random: Random, data: bytes) -> bytes:
    """Types, elements and the format that a PLY file names."""
    swaps = (
        (b"float", (b"double", b"uchar", b"int", b"float64", b"x", b"list uchar float")),
        (b"list uchar int", (b"list float int", b"list int int", b"list uchar", b"list", b"int")),
        (b"property", (b"prop", b"element vertex 3\nproperty", b"")),
        (b"ascii", (b"binary_little_endian", b"binary_big_endian", b"x")),
        (b"binary_little_endian", (b"ascii", b"binary_big_endian")),
        (
            b"end_header",
            (b"", b"end_header\nend_header", b"comment TextureFile /etc/passwd\nend_header"),
        ),
        (b"vertex", (b"face", b"edge", b"")),
        (b"face", (b"vertex", b"tristrips")),
        (b" x\n", (b" y\n", b" red\n", b"\n")),
    )
    old, new = _of(random, swaps)
    return data.replace(old, _of(random, new), int(random.integers(1, 3)))


def _obj_lines(random: Random, data: bytes) -> bytes:
    lines = (
        *(b"f 1 2 3 4 5 6 7 8 9", b"f 0 1 2", b"f -1 -2 -3", b"f 1/1/1 2//2 3/3", b"f 1 2", b"f"),
        *(b"f 99999999999 1 2", b"f 1 1 1", b"v 1 2", b"v 1 2 3 4 5 6 7", b"v nan inf -inf", b"v"),
        *(b"mtllib /etc/passwd", b"mtllib ../../x.mtl", b"usemtl a", b"o \xff", b"g", b"s off"),
        *(
            b"vt 0 0",
            b"vn 0 0 1",
            b"l 1 2",
            b"p 1",
            b"curv 0 1 1 2",
            b"call x.obj",
            b"\\",
            b"f 1 \\",
        ),
        *(b"f " + b"1 2 3 " * 3000, b"v " + b"1" * 5000 + b" 0 0", b"# " + b"x" * 20000),
    )
    rows = data.split(b"\n")
    rows.insert(int(random.integers(len(rows) + 1)), _of(random, lines))
    return b"\n".join(rows)


def _stl_lines(random: Random, data: bytes) -> bytes:
    lines = (
        *(b"facet normal 0 0 1", b"outer loop", b"vertex 1 2", b"vertex nan 0 0", b"endloop"),
        *(b"vertex 1e999 0 0", b"endfacet", b"endsolid", b"solid b", b"vertex a b c", b""),
        *(b"vertex 1 2 3 4", b"facet", b"color 1 2 3", b"\xff\xfe", b"vertex " + b"9" * 5000),
    )
    rows = data.split(b"\n")
    rows.insert(int(random.integers(len(rows) + 1)), _of(random, lines))
    return b"\n".join(rows)


def _glb(random: Random, data: bytes) -> bytes:
    """The JSON of a GLB file changed, its chunks put together again."""
    if len(data) < 20:
        return data
    (length,) = struct.unpack("<I", data[12:16])
    text, rest = data[20 : 20 + length], data[20 + length :]
    text = json_faults(random, text)
    if random.integers(4) == 0:
        try:
            document = json.loads(text)
            extra = _of(
                random,
                (
                    {"buffers": [{"byteLength": 10**9}]},
                    {"buffers": [{"byteLength": 8, "uri": "/etc/passwd"}]},
                    {"buffers": [{"byteLength": 8, "uri": "http://localhost/x.bin"}]},
                    {"images": [{"uri": "/etc/passwd"}]},
                    {"nodes": [{"children": [0], "mesh": 0}], "scenes": [{"nodes": [0]}]},
                    {"nodes": [{"mesh": 0, "matrix": [1e300] * 16}]},
                    {"scene": 99},
                    {"extensionsRequired": ["KHR_draco_mesh_compression"]},
                ),
            )
            text = json.dumps(document | extra).encode()
        except (ValueError, TypeError, RecursionError):  # no JSON since a fault before: as it is
            pass
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I", len(text)) + b"JSON" + text + rest
    return data[:8] + struct.pack("<I", 12 + len(chunks)) + chunks


def _of_3mf(random: Random, data: bytes) -> bytes:
    """A file of the archive changed, lost, doubled or made huge."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
    except Exception:  # faults before this one have damaged it
        return byte_faults(random, data)
    name = _of(random, sorted(files))
    kind = random.integers(8)
    if kind == 0:
        del files[name]
    elif kind == 1:
        files[_of(random, ("../x", "/etc/x", "3D/3dmodel.model", "x" * 3000))] = files[name]
    elif kind == 2:
        place = files[name].find(b"<vertices>")
        files[name] = files[name][:place] + b" " * 30_000_000 + files[name][place:]
    else:
        model = next((each for each in sorted(files) if each.endswith(".model")), name)
        fault = _of(random, (number_faults, number_faults, element_faults, entity_faults, _model))
        files[model] = fault(random, files[model])
    return zip_bytes(files)


def _model(random: Random, data: bytes) -> bytes:
    """Objects of objects, of themselves, and none, in the model of a 3MF file."""
    parts = (
        b'<object id="77"><components><component objectid="77"/></components></object>',
        b'<object id="78"><mesh><vertices/><triangles/></mesh></object>',
        b'<object id="1"><components><component objectid="2"/></components></object>',
    )
    if random.integers(2):
        return data.replace(b"<resources>", b"<resources>" + _of(random, parts))
    nested = b"".join(
        b'<object id="%d" type="model"><components><component objectid="%d"/>'
        b'<component objectid="%d"/></components></object>' % (i + 1000, i + 999, i + 999)
        for i in range(1, 40)
    )
    items = b'<item objectid="1039"/>'
    base = b'<object id="999" type="model"><mesh><vertices/><triangles/></mesh></object>'
    data = data.replace(b"</resources>", base + nested + b"</resources>")
    return data.replace(b"</build>", items + b"</build>")


_REFERENCE = re.compile(rb"#\d+")
_STEP_VALUES = (
    *(b"$", b"*", b"''", b"()", b".T.", b"1.E300", b"-1.E-300", b"NaN", b"#0", b"#1", b"0.", b"-1"),
    *(
        b"(" * 2000,
        b"#99999999999999999999",
        b"'" + b"x" * 5000 + b"'",
        b".UNSPECIFIED.",
        b"1000000",
    ),
)
_STEP_TYPES = (
    *(b"PLANE", b"CYLINDRICAL_SURFACE", b"CARTESIAN_POINT", b"DIRECTION", b"ADVANCED_FACE"),
    *(
        b"B_SPLINE_SURFACE_WITH_KNOTS",
        b"CLOSED_SHELL",
        b"EDGE_LOOP",
        b"CIRCLE",
        b"X",
        b"TOROIDAL_SURFACE",
    ),
)


def _step_references(random: Random, data: bytes) -> bytes:
    """References to other entities, to themselves and to none."""
    found = list(_REFERENCE.finditer(data))
    for _ in range(int(random.integers(1, 4))):
        if not found:
            break
        one, other = _of(random, found), _of(random, found)
        data = data[: one.start()] + other.group() + data[one.end() :]
        found = list(_REFERENCE.finditer(data))
    return data


def _step_values(random: Random, data: bytes) -> bytes:
    """A value of an entity, or its type, is another."""
    if random.integers(2):
        found = list(re.finditer(rb"(?<=[(,])[^(),;]*(?=[),])", data))
        new = _of(random, _STEP_VALUES)
    else:
        found = list(re.finditer(rb"(?<==)\s*[A-Z_]+", data))
        new = _of(random, _STEP_TYPES)
    if not found:
        return data
    one = _of(random, found)
    return data[: one.start()] + new + data[one.end() :]


def _step_parts(random: Random, data: bytes) -> bytes:
    """Entities lost, doubled, exchanged."""
    parts = data.split(b";")
    for _ in range(int(random.integers(1, 4))):
        first, second = (int(i) for i in random.integers(len(parts), size=2))
        kind = random.integers(3)
        if kind == 0 and len(parts) > 1:
            del parts[first]
        elif kind == 1:
            parts.insert(second, parts[first])
        else:
            parts[first], parts[second] = parts[second], parts[first]
    return b";".join(parts)


_OF_KIND: dict[str, tuple[Fault, ...]] = {
    "stl": (_word_faults, _word_faults, _cut, number_faults, row_faults, _stl_lines),
    "ply": (_count_faults, _ply_head, _ply_head, _word_faults, _cut, number_faults, row_faults),
    "off": (_count_faults, number_faults, number_faults, row_faults, row_faults, _cut),
    "obj": (_obj_lines, _obj_lines, number_faults, row_faults, _cut),
    "glb": (_glb, _glb, _glb, _word_faults, _cut),
    "3mf": (_of_3mf,),
    "step": (_step_references, _step_references, _step_values, _step_values, _step_parts, _cut),
}


def with_mesh_faults(random: Random, kind: str, data: bytes) -> bytes:
    """The bytes of a file with up to three faults, one of ten with faults of single bytes."""
    for _ in range(int(_of(random, (0, 1, 1, 1, 1, 2, 2, 3)))):
        data = _of(random, _OF_KIND[kind])(random, data)
    return byte_faults(random, data) if random.integers(10) == 0 else data
