"""Faults of files that the program keeps for itself: archives of arrays, tables, journals, words.

Values, types, shapes and names changed in files that are written again as a whole, so that their
checksums are right; and bytes of the files themselves.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from fuzz.written_faults import byte_faults, json_faults, row_faults

__all__ = ["archive_faults", "journal_faults", "option_faults", "table_faults"]

Random = np.random.Generator
_SHAPES: tuple[tuple[int, ...], ...] = ((), (0,), (1,), (3,), (2, 2), (0, 4, 3), (1, 1, 1, 1))
_TYPES = ("<f8", "<f4", "<i8", "|b1", "<U4", "<c16", ">f8")
_NUMBERS = (np.nan, np.inf, -1.0, 0.0, 1e300, -1e300, 1e18, 3.0)
_HEADS = (
    *(b"(10000000000000,)", b"(-1,)", b"(3, 'x')", b"()", b"(" * 3000, b"(9,)" * 3000, b"(1e3,)"),
    *(b"(4000000000, 4000000000)", b"\xff", b"__import__('os')", b"(" + b"9" * 5000 + b",)"),
)
_WORDS = (
    *("", "=", "x", ".", "..=1", "é=1", "a" * 5000 + "=1", "\x00=1", "panels=1", "panels={}"),
    *("cutter.material=1", "cutter.sheets=0x" + "f" * 5000, "panels.thickness_mm=1e999", "=="),
    *("perforation.bands=[{}]", "panels.x.y.z=1", "hinges.kind=web", "printer.machine=mine.toml"),
    *("cutter=[]", "cutter.copies=[[[1]]]", "panels.thickness_mm='''", "hinges.web_mm=1 # x"),
)


def _of(random: Random, values: Sequence[Any]) -> Any:
    return values[int(random.integers(len(values)))]


def _cut(random: Random, data: bytes) -> bytes:
    return data[: int(random.integers(len(data) + 1))]


def archive_faults(random: Random, data: bytes) -> bytes:
    """An archive of arrays with up to three faults."""
    for _ in range(int(_of(random, (0, 1, 1, 1, 2, 3)))):
        data = _of(random, (_array, _array, _member, _head, byte_faults, _cut))(random, data)
    return data


def _members(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _archive(members: dict[str, bytes], how: int = zipfile.ZIP_STORED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", how) as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(name), data, how)
    return out.getvalue()


def _array(random: Random, data: bytes) -> bytes:
    """An array of other values, another shape or type."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        name = _of(random, sorted(arrays))
    except Exception:  # faults before this one have damaged it
        return byte_faults(random, data)
    array, kind = arrays[name], random.integers(5)
    with np.errstate(all="ignore"), suppress(OverflowError, ValueError):
        if kind == 0:
            arrays[name] = np.zeros(_of(random, _SHAPES), array.dtype)
        elif kind == 1:
            arrays[name] = array.astype(_of(random, _TYPES))
        elif kind == 2:
            arrays[name] = np.concatenate([array.ravel()] * 2)
        elif kind == 3:
            arrays[name] = array.ravel()[: int(random.integers(array.size + 1))]
        elif array.size and array.dtype.kind in "fi":
            array.ravel()[int(random.integers(array.size))] = _of(random, _NUMBERS)
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def _member(random: Random, data: bytes) -> bytes:
    """An array lost, renamed, doubled, squeezed, or no array."""
    try:
        members = _members(data)
        name = _of(random, sorted(members))
    except Exception:  # as above
        return byte_faults(random, data)
    kind = random.integers(5)
    if kind == 0:
        del members[name]
    elif kind == 1:
        members[_of(random, ("../x.npy", "x", "key.npy", "é.npy"))] = members.pop(name)
    elif kind == 2:
        members[name] = _of(random, (b"", b"\x93NUMPY", b"cos\nsystem\n(S'x'\ntR.", b"x" * 100))
    elif kind == 3:
        return _archive(members, _of(random, (zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA)))
    else:
        members[name] = byte_faults(random, members[name])
    return _archive(members)


def _head(random: Random, data: bytes) -> bytes:
    """The shape or type that the head of an array names, with a length that is right."""
    try:
        members = _members(data)
        name = _of(random, sorted(members))
        head = members[name][10 : 10 + int.from_bytes(members[name][8:10], "little")]
    except Exception:  # as above
        return byte_faults(random, data)
    rest = members[name][10 + len(head) :]
    if random.integers(3):
        place = head.find(b"'shape': ") + len(b"'shape': ")
        head = head[:place] + _of(random, _HEADS) + head[max(head.find(b"}"), place) :]
    else:
        head = head.replace(b"<f8", _of(random, (b"|O", b"<f9", b"<U99999999", b"|V0", b"<M8[x]")))
    members[name] = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + rest
    return _archive(members)


def table_faults(random: Random, data: bytes) -> bytes:
    """A Parquet file with up to two faults of tables, or of bytes."""
    for _ in range(int(_of(random, (0, 1, 1, 1, 2)))):
        data = _of(random, (_column, _column, byte_faults, byte_faults, _cut))(random, data)
    return data


def _column(random: Random, data: bytes) -> bytes:
    """A table without a column, with another one, of other types, names or rows."""
    try:
        table = pq.read_table(pa.BufferReader(data))
        place = int(random.integers(table.num_columns))
    except Exception:  # faults before this one have damaged it
        return byte_faults(random, data)
    name, kind, rows = table.column_names[place], random.integers(7), table.num_rows
    if kind == 0:
        table = table.remove_column(place)
    elif kind == 1:
        table = table.rename_columns(
            [*table.column_names[:place], "é", *table.column_names[place + 1 :]]
        )
    elif kind == 2:
        values = _of(
            random, ([None], [float("nan")], ["x"], [[1]], [{"a": 1}], [2**62], [b"\xff"], [True])
        )
        table = table.set_column(place, name, pa.array(values * rows))
    elif kind == 3:
        table = table.select([name])
    elif kind == 4:
        table = table.append_column(_of(random, (name, "number", "x.y")), pa.array(range(rows)))
    elif kind == 5:
        table = _of(random, (table.slice(0, 0), table.slice(1), pa.concat_tables([table] * 3)))
    else:
        table = pa.table({})
    out = io.BytesIO()
    how = _of(random, ("snappy", "none", "zstd", "gzip"))
    pq.write_table(table, out, compression=how)
    return out.getvalue()


def journal_faults(random: Random, data: bytes) -> bytes:
    """A journal of lines of JSON with up to three faults."""
    for _ in range(int(_of(random, (0, 1, 1, 1, 2, 3)))):
        data = _of(random, (_entry, _entry, _entry, row_faults, byte_faults, _cut))(random, data)
    return data


def _entry(random: Random, data: bytes) -> bytes:
    """A line changed as JSON."""
    lines = data.split(b"\n")
    place = int(random.integers(len(lines)))
    fault: Callable[[Random, bytes], bytes] = json_faults
    if random.integers(3) == 0:
        lines[place] = _of(random, (b"", b"{}", b"[]", b"1", b"null", b'{"op_code": 99}', b"\xff"))
    else:
        try:
            entry = json.loads(lines[place])
            entry["op_code"] = int(random.integers(12))
            lines[place] = json.dumps(entry).encode() if random.integers(3) == 0 else lines[place]
        except (ValueError, TypeError):  # the last line, or one with a fault
            pass
        lines[place] = fault(random, lines[place])
    return b"\n".join(lines)


def option_faults(random: Random, words: Sequence[str]) -> list[str]:
    """Some of the words of options, with keys and values exchanged, cut and put in."""
    chosen = [str(_of(random, words)) for _ in range(int(random.integers(1, 4)))]
    for place, word in enumerate(chosen):
        key, equals, value = word.partition("=")
        kind = random.integers(8)
        if kind == 0:
            value = str(_of(random, words)).partition("=")[2]
        elif kind == 1:
            key = str(_of(random, words)).partition("=")[0]
        elif kind == 2:
            value = repr(_of(random, _NUMBERS))
        elif kind == 3:
            equals = _of(random, ("", "==", " = ", ":"))
        elif kind == 4:
            key = f"{key}{_of(random, ('s', '.x', '.', ' ', '_mm'))}"
        chosen[place] = key + equals + value
        if kind == 5:
            chosen[place] = _of(random, _WORDS)
        elif kind == 6:
            chosen[place] = byte_faults(random, chosen[place].encode()).decode("utf-8", "replace")
    return chosen
