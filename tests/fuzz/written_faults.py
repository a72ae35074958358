"""Faults of files: numbers, elements, letters and bytes changed, most of them in valid syntax."""

from __future__ import annotations

import json
import re
from collections.abc import Callable

import numpy as np
from fuzz.drawn_faults import EXTREMES

__all__ = [
    "byte_faults",
    "element_faults",
    "entity_faults",
    "json_faults",
    "number_faults",
    "row_faults",
    "with_file_faults",
]

_NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_WORDS = [
    *(b"NaN", b"nan", b"inf", b"-Infinity", b"1e308", b"1e309", b"-1e999", b"5e-324", b"1e-400"),
    *(b"0", b"-0", b"-1", b"99999999999999999999999", b"0x10", b"1_000", b"1e", b".", b"--3"),
    *(b"", b"1,5", "٣".encode(), b"true", b"1e+", b"9" * 400, b"0." + b"0" * 400 + b"1"),
    *(b"1" * 30_000 + b"x", b"1" + b" " * 30_000 + b"!"),
]
_COLOURS = [
    *(b"#f00", b"#FF0000", b"red", b"blue", b"#00f", b"rgb(0,0,0)", b"rgb(110%,-5%,0)", b"none"),
    *(b"#000", b"lime", b"yellow", b"magenta", b"currentColor", b"url(#a)", b"hsl(0,100%,50%)"),
    *(b"#ff000080", b"rgba(0,0,255,nan)", b"transparent", b"#12", b"inherit", b"oklch(1 2 3)"),
]
_TRANSFORMS = [
    *(b"scale(0)", b"scale(1,0)", b"scale(1e300)", b"scale(-1,1)", b"matrix(1 0 0 1 0 0)"),
    *(b"matrix(1 1 1 1 0 0)", b"rotate(90)", b"rotate(1e20, 5 5)", b"skewX(90)", b"skewY(89.99)"),
    *(b"translate(1e17)", b"matrix(1 2 3)", b"translate(", b"scale(1e-200)", b"none", b"foo(1)"),
    *(b"translate(nan)", b"scale(1e-5) translate(3,4)", b"rotate(1turn)", b"matrix(0 1 1 0 0 0)"),
]
_ELEMENTS = [
    b'<use href="#a"/>',
    b'<g id="a"><use xlink:href="#a"/></g>',
    b'<circle cx="50" cy="50" r="20" stroke="#000"/>',
    b'<ellipse cx="50" cy="50" rx="1e-9" ry="30" stroke="blue"/>',
    b'<rect x="-5" y="-5" width="200" height="200" stroke="black" rx="3"/>',
    b'<polygon points="0,0 10,0 10" stroke="red"/>',
    b'<polyline points="0,0 1e3,0 5,5 0,0" stroke="red"/>',
    b'<path d="M0 0C10 20 30 40 50 0S3 3 4 4Q1 2 3 4T9 9A5 5 0 01 9 19z" stroke="red"/>',
    b'<path d="M10 10A1e9 1e-9 45 1 0 60 60" stroke="blue"/>',
    b'<path d="M0 0 1e5 1e5M3 3ZZZM5 5L" stroke="blue"/>',
    b'<path d="M0 50H100" stroke="red" stroke-dasharray="3 1 nan"/>',
    b'<svg viewBox="0 0 0 0" width="50%"><line x2="9" y2="9" stroke="red"/></svg>',
    b'<svg viewBox="0 0 10 10" x="5" width="50" height="20"><line x2="9" y2="9"/></svg>',
    b'<symbol id="s" viewBox="0 0 1 1"><line x2="1" y2="1" stroke="red"/></symbol>',
    b'<use href="#s" width="30" height="30"/>',
    b"<style>line,path{stroke:red;stroke-width:1e9}*{display:none}</style>",
    b"<style>.a{stroke:#00f} .b > path{stroke:#f00;opacity:.3}</style>",
    b"<style>@import 'x'; {}} /* </style>",
    b"<text>M</text>",
    b'<image href="http://localhost/x.png" width="9" height="9"/>',
    b'<clipPath id="c"><path d="M0 0h9"/></clipPath>',
    b"<desc>x</desc><!-- -- -->",
    b'<line x1="0" y1="0" x2="30%" y2="4cm" stroke="red"/>',
]
_ATTRIBUTES = [
    *(b'opacity="0.5"', b'stroke-opacity="1e9"', b'display="none"', b'visibility="hidden"'),
    *(b'class="mountain"', b'id="valley"', b'style="stroke:#0f0;opacity:.2"', b'stroke="none"'),
    *(b'clip-path="url(#c)"', b'stroke-dasharray="4,4"', b'data-foldAngle="1e3"', b"x=1"),
    *(b'data-assignment="V"', b'data-foldAngle="nan"', b'style="transform:scale(0)"'),
    *(b'viewBox="0 0 nan 3"', b'width="1e300mm"', b'height="0"', b'viewBox="1 1 -3 5"'),
    *(b'width="5em"', b'preserveAspectRatio="xMaxYMin slice"', b'xml:space="preserve"'),
]
_DXF_ENTITIES = [
    "0 CIRCLE 8 0 10 50 20 50 40 20",
    "0 ARC 8 cut 10 50 20 50 40 1e9 50 0 51 1e-5",
    "0 ELLIPSE 8 0 10 5 20 5 11 9 21 0 40 0 41 0 42 6.3",
    "0 LWPOLYLINE 8 mountain 90 3 70 1 10 0 20 0 42 1 10 9 20 9 42 -1e9 10 3 20 0",
    "0 SPLINE 8 valley 70 8 71 3 72 8 73 4 40 0 40 0 40 0 40 0 40 1 40 1 40 1 40 1 "
    "10 0 20 0 10 1 20 5 10 9 20 5 10 9 20 0",
    "0 SPLINE 8 valley 70 8 71 99 72 0 73 0",
    "0 INSERT 8 0 2 A 10 3 20 4 41 0 42 1 50 90 70 3 71 1000000 44 1 45 1",
    "0 INSERT 8 0 2 *Model_Space 10 3 20 4",
    "0 POLYLINE 8 0 66 1 70 1 0 VERTEX 8 0 10 1 20 1 0 VERTEX 8 0 10 9 20 1 42 nan 0 SEQEND",
    "0 POINT 8 0 10 1 20 1",
    "0 TEXT 8 0 1 M 10 1 20 1 40 1e300",
    "0 LINE 8 0 10 0 20 0 30 5 11 100 21 100 31 -5",
    "0 LINE 8 0 10 0 20 0 11 100",
    "0 3DFACE 8 0 10 0 20 0 30 0 11 9 21 0 31 0 12 9 22 9 32 0 13 0 23 9 33 0",
    "0 HATCH 8 0 91 1",
    "0 LINE 8 0 10 1 20 1 11 50 21 60 210 0 220 0 230 -1",
]


def _number(random) -> bytes:
    if random.integers(2):
        return _WORDS[random.integers(len(_WORDS))]
    value = random.choice(EXTREMES) * random.choice([-1, 1])
    return repr(float(value)).encode()


def number_faults(random, data: bytes) -> bytes:
    """Some numbers replaced: by extremes, or by others of the file."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    rows = np.sort(random.choice(len(found), min(len(found), int(random.integers(1, 4)))))[::-1]
    for row in np.unique(rows)[::-1].tolist():
        kind = random.integers(4)
        if kind == 0:
            new = found[random.integers(len(found))].group()
        elif kind == 1:
            try:
                value = float(found[row].group()) * (1 + 10.0 ** random.uniform(-16, 0))
            except ValueError:
                value = 0.0
            new = repr(value).encode()
        else:
            new = _number(random)
        data = data[: found[row].start()] + new + data[found[row].end() :]
    return data


def byte_faults(random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(int(random.integers(1, 6))):
        place = int(random.integers(len(out) + 1))
        kind = random.integers(5)
        if kind == 0:
            out[place : place + int(random.integers(1, 20))] = b""
        elif kind == 1:
            out[place:place] = bytes(random.integers(0, 256, int(random.integers(1, 5))).tolist())
        elif kind == 2 and place < len(out):
            out[place] ^= 1 << int(random.integers(8))
        elif kind == 3:
            start = int(random.integers(len(out) + 1))
            out[place:place] = out[start : start + int(random.integers(1, 60))]
        elif random.integers(4) == 0:
            del out[place:]
    return bytes(out)


def _parts(random, parts: list[bytes]) -> list[bytes]:
    """Parts of a file with some removed, repeated or exchanged."""
    parts = list(parts)
    for _ in range(int(random.integers(1, 4))):
        if not parts:
            break
        a, b = (int(place) for place in random.integers(len(parts), size=2))
        kind = random.integers(4)
        if kind == 0:
            del parts[a]
        elif kind == 1:
            parts.insert(b, parts[a])
        elif kind == 2:
            parts[a], parts[b] = parts[b], parts[a]
        else:
            del parts[min(a, b) : min(a, b) + 5]
    return parts


def row_faults(random, data: bytes) -> bytes:
    lines = data.split(b"\n")
    kind = random.integers(3)
    if kind == 0:
        return b"\n".join(_parts(random, lines))
    row = int(random.integers(len(lines)))
    words = lines[row].split(b" ")
    if kind == 1:
        words = _parts(random, words)
    else:
        words[random.integers(len(words))] = _number(random)
    lines[row] = b" ".join(words)
    return b"\n".join(lines)


# XML

_TAG = re.compile(rb"<[^<>]+>")


def element_faults(random, data: bytes) -> bytes:
    """Empty elements, or whole tags, removed, repeated, exchanged."""
    pattern = rb"<[^<>]+/>" if random.integers(5) else rb"<[^<>]+>"
    found = [part for part in re.split(rb"(" + pattern + rb")", data) if part]
    tags = [i for i, part in enumerate(found) if re.fullmatch(pattern, part)]
    if not tags:
        return data
    new = _parts(random, [found[i] for i in tags])
    first = tags[0]
    rest = [part for i, part in enumerate(found) if i not in set(tags)]
    return b"".join([*found[:first], *new, *rest[first:]])


def _svg_inserted(random, data: bytes) -> bytes:
    places = [match.end() for match in _TAG.finditer(data)]
    if not places:
        return data
    place = places[random.integers(len(places))]
    return data[:place] + _ELEMENTS[random.integers(len(_ELEMENTS))] + data[place:]


def _svg_attribute(random, data: bytes) -> bytes:
    places = [match.end() for match in re.finditer(rb"<(svg|g|line|path|poly\w+|rect)\b", data)]
    if not places:
        return data
    place = places[random.integers(len(places))]
    if random.integers(2):
        text = b'transform="' + _TRANSFORMS[random.integers(len(_TRANSFORMS))] + b'"'
    else:
        text = _ATTRIBUTES[random.integers(len(_ATTRIBUTES))]
    return data[:place] + b" " + text + data[place:]


def _svg_colour(random, data: bytes) -> bytes:
    found = list(re.finditer(rb"#[0-9a-fA-F]{3,8}|\b(red|blue|black|green)\b", data))
    if not found:
        return data
    one = found[random.integers(len(found))]
    colour = _COLOURS[random.integers(len(_COLOURS))]
    if random.integers(2):
        return data.replace(one.group(), colour)
    return data[: one.start()] + colour + data[one.end() :]


def _svg_nested(random, data: bytes) -> bytes:
    begin = re.search(rb"<svg\b[^<>]*>", data)
    end = data.rfind(b"</svg>")
    if not begin or end < begin.end():
        return data
    depth = int(random.choice([1, 3, 30, 240, 255, 300, 3000]))
    text = b"<g>"
    if random.integers(2):
        text = b'<g transform="' + _TRANSFORMS[random.integers(len(_TRANSFORMS))] + b'">'
    inner = data[begin.end() : end]
    return data[: begin.end()] + text * depth + inner + b"</g>" * depth + data[end:]


def _svg_path(random, data: bytes) -> bytes:
    """A letter of path data changed or put in."""
    found = list(re.finditer(rb'\bd="[^"]*"', data))
    if not found:
        return _svg_inserted(random, data)
    one = found[random.integers(len(found))]
    place = int(random.integers(one.start() + 3, one.end()))
    letter = b"MmLlHhVvCcSsQqTtAaZz"[random.integers(20) :][:1]
    return data[:place] + b" " + letter + b" " + data[place + int(random.integers(2)) :]


def entity_faults(random, data: bytes) -> bytes:
    head = random.choice(
        [
            b'<!DOCTYPE svg [<!ENTITY a "red"><!ENTITY b "&a;&a;&a;">]>',
            b'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/hostname">]>',
            b'<!DOCTYPE svg [<!ENTITY a "1">]>',
            b'<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://localhost/svg11.dtd">',
            b'<?xml version="1.0" encoding="UTF-7"?>',
            b'<?xml version="1.0" encoding="cp037"?>',
        ]
    )
    start = data.find(b"<svg") if b"<svg" in data else data.find(b"<java")
    return data[: max(start, 0)] + head + data[max(start, 0) :].replace(b"red", b"&a;")


# JSON


def json_faults(random, data: bytes) -> bytes:
    """Nodes of a JSON document replaced, removed, repeated, exchanged."""
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        return number_faults(random, data)
    for _ in range(int(random.integers(1, 4))):
        _changed(random, document)
    return json.dumps(document).encode()


def _changed(random, document) -> None:
    node, parent, key = document, None, None
    while isinstance(node, dict | list) and node and (parent is None or random.integers(6)):
        keys = list(node) if isinstance(node, dict) else range(len(node))
        parent, key = node, keys[random.integers(len(keys))]
        node = parent[key]
    if parent is None:
        return
    kind = random.integers(9)
    values = [None, True, "M", "", [], {}, [[]], -1, 10**30, float("nan"), float("inf"), "B", 1.5]
    if kind < 2 and isinstance(node, int | float) and not isinstance(node, bool):
        near = float(min(max(node, -1e300), 1e300)) * (1 + 10.0 ** random.uniform(-16, 0))
        other = int(random.integers(0, 40)) if isinstance(node, int) else near
        parent[key] = random.choice([random.choice(EXTREMES), float(other)]).item()
        if isinstance(node, int) and abs(parent[key]) < 2**70 and random.integers(4):
            parent[key] = int(parent[key])
    elif kind == 2:
        del parent[key]
    elif kind == 3 and isinstance(parent, list):
        parent.insert(int(random.integers(len(parent) + 1)), json.loads(json.dumps(node)))
    elif kind == 4 and isinstance(parent, list):
        other = int(random.integers(len(parent)))
        parent[key], parent[other] = parent[other], parent[key]
    elif kind == 5 and isinstance(node, list):
        parent[key] = node[: int(random.integers(len(node) + 1))]
    elif kind == 6 and isinstance(node, list):
        parent[key] = node[::-1]
    elif kind == 7 and isinstance(node, str):
        parent[key] = str(random.choice([*"BMVFUCJbmvx", "creasePattern", "foldedForm", "2D", "m"]))
    elif kind == 8:
        value = values[random.integers(len(values))]
        parent[key] = json.loads(json.dumps(value))


_JSON_TEXTS = (
    *(b"NaN", b"-Infinity", b"1e400", b"9" * 5000, b"0." + b"3" * 5000, b"-0", b"1E+", b"01"),
    *(b'"\\ud800"', b'"\\u0000"', b'"\\u001b]0;x"', b"[" * 3000, b"[" * 900 + b"]" * 900),
    *(b'{"a":' * 900 + b"1" + b"}" * 900, b'{"a":1,"a":2}', b"'x'", b"1,,2", b"//x\n1", b"\xff"),
)


def _json_text(random, data: bytes) -> bytes:
    """A value of the text replaced, a key doubled, or the text in another encoding."""
    kind = random.integers(6)
    if kind == 0:
        return data.decode("utf-8", "replace").encode(
            ("utf-16", "utf-8-sig", "utf-32", "utf-16-be")[random.integers(4)]
        )
    found = list(re.finditer(rb'(?<=[:,\[])\s*(?:[-+.\w]+|"[^"\\]*")', data))
    if not found:
        return data
    one = found[random.integers(len(found))]
    if kind == 1:
        keys = re.findall(rb'"\w+"(?=\s*:)', data)
        key = keys[random.integers(len(keys))] if keys else b'"a"'
        place = data.find(b"{") + 1
        return data[:place] + key + b":" + one.group() + b"," + data[place:]
    new = _JSON_TEXTS[random.integers(len(_JSON_TEXTS))]
    return data[: one.start()] + new + data[one.end() :]


def _fold_keys(random, data: bytes) -> bytes:
    """Keys of a FOLD file removed or put in."""
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        return data
    if not isinstance(document, dict):
        return data
    optional = [
        *("faces_vertices", "edges_assignment", "edges_foldAngle", "frame_unit", "frame_classes"),
        *("file_frames", "edges_vertices", "vertices_coords", "frame_attributes", "edges_faces"),
    ]
    kind = random.integers(5)
    if kind < 2:
        document.pop(str(random.choice(optional)), None)
    elif kind == 2:
        frame = {key: value for key, value in document.items() if key != "file_frames"}
        frame.update(random.choice([{}, {"frame_parent": 0, "frame_inherit": True}]))
        document["file_frames"] = [frame] * int(random.integers(1, 4))
    elif kind == 3:
        document["frame_classes"] = [str(random.choice(["creasePattern", "foldedForm", "x"]))]
        document["frame_unit"] = str(random.choice(["mm", "in", "unit", "m", "nm", "?"]))
    else:
        points = document.get("vertices_coords")
        if isinstance(points, list):
            turned = [point[::-1] if isinstance(point, list) else point for point in points]
            document["vertices_coords"] = turned
    return json.dumps(document).encode()


# DXF


def _dxf_pairs(data: bytes) -> list[bytes]:
    lines = data.split(b"\n")
    return [b"\n".join(lines[i : i + 2]) for i in range(0, len(lines), 2)]


def _dxf_groups(data: bytes) -> list[bytes]:
    """A DXF file as its structures, each from a group code 0 to the next."""
    groups: list[list[bytes]] = [[]]
    for pair in _dxf_pairs(data):
        if pair.split(b"\n")[0].strip() == b"0":
            groups.append([])
        groups[-1].append(pair)
    return [b"\n".join(group) for group in groups if group]


def _dxf_inserted(random, data: bytes) -> bytes:
    groups = _dxf_groups(data)
    entity = _DXF_ENTITIES[random.integers(len(_DXF_ENTITIES))].replace(" ", "\n").encode()
    places = [i for i, group in enumerate(groups) if b"ENTITIES" in group or b"\nLINE" in group]
    place = places[random.integers(len(places))] + 1 if places else len(groups)
    return b"\n".join([*groups[:place], entity, *groups[place:]])


def _dxf_structures(random, data: bytes) -> bytes:
    groups = _dxf_groups(data)
    entities = [i for i, group in enumerate(groups) if b"ENTITIES" in group]
    first = entities[0] + 1 if entities and random.integers(4) else 0
    return b"\n".join([*groups[:first], *_parts(random, groups[first:])])


def _dxf_value(random, data: bytes) -> bytes:
    pairs = _dxf_pairs(data)
    wanted = random.choice([b"10", b"20", b"11", b"21", b"62", b"70", b"8", b"5", b"330", b"42"])
    rows = [i for i, pair in enumerate(pairs) if pair.split(b"\n")[0].strip() == wanted]
    if not rows:
        return number_faults(random, data)
    row = rows[random.integers(len(rows))]
    value = random.choice([b"mountain", b"Cut", b"0", b"256", b"-7", b"1A", _number(random)])
    pairs[row] = pairs[row].split(b"\n")[0] + b"\n" + bytes(value)
    return b"\n".join(pairs)


_OF_KIND: dict[str, list[Callable]] = {
    "svg": [
        *(
            number_faults,
            number_faults,
            element_faults,
            _svg_inserted,
            _svg_inserted,
            _svg_attribute,
        ),
        *(_svg_attribute, _svg_colour, _svg_nested, _svg_path, entity_faults),
    ],
    "dxf": [number_faults, _dxf_value, _dxf_value, _dxf_inserted, _dxf_inserted, _dxf_structures],
    "cp": [number_faults, row_faults, row_faults],
    "opx": [number_faults, element_faults, row_faults, entity_faults],
    "ori": [json_faults, json_faults, json_faults, _json_text, number_faults],
    "fold": [json_faults, json_faults, _fold_keys, _json_text, number_faults],
    "obj": [number_faults, row_faults, row_faults],
}


def with_file_faults(random: np.random.Generator, kind: str, data: bytes) -> bytes:
    """The bytes of a file with up to three faults, one of twenty with faults of single bytes."""
    for _ in range(int(random.choice([0, 0, 0, 0, 1, 1, 1, 2, 3]))):
        faults = _OF_KIND[kind]
        data = faults[random.integers(len(faults))](random, data)
    if random.integers(20) == 0:
        data = byte_faults(random, data)
    return data
