"""Faults of TOML files: tables, keys and values changed, moved, lost and put in, and the text torn.

Documents are changed as tables, so that most of what is written is valid TOML; what is put in are
values of the same key in other files, values near the bounds of numbers, and values of other types.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from fuzz.drawn_faults import EXTREMES
from fuzz.written_faults import byte_faults

__all__ = ["Corpus", "toml_text"]

Random = np.random.Generator
_STRINGS = (
    *("", " ", "x", "dashes", "score", "any", "none", "nan", "1.5", "true", "../..", "/etc/passwd"),
    *("a" * 5000, "\x1b]0;title\x07", "\u202e", "\x7f", "%s%n", "{}", "🦢", "é", "mine.py:Helix"),
    *("\n", "miura", "card_300gsm", "co2_60w_600x400", "design.rows <= 2", "x.stl", "#ff0000"),
)
_SCALARS = (
    *(True, False, 0, 1, -1, 2, 3, 7, 64, 65, 1000, 10**6, 10**9, 2**31, 2**63 - 1, -(2**63)),
    *(0.0, -0.0, 0.5, -0.5, 1.0, 90.0, 179.9, 180.0, 360.0, 1e5, math.nan, math.inf, -math.inf),
    *(
        10**30,
        10**400,
        10**4200,
        10**5000,
        1e-300,
        1e300,
        datetime.date(2020, 1, 1),
        datetime.time(1, 2, 3),
    ),
    datetime.datetime(2020, 1, 1, tzinfo=datetime.UTC),
)
_KEYS = ("kind", "unknown", "name", "", "a.b", "é", "x" * 300, "design", "perforation", "sheet")
_LINES = (
    *("[design]", "[[design]]", "[sheet.x]", "x = ", "= 1", "x = 1\nx = 2", "a.b.c = 1", '"" = 1'),
    *('x = """', "x = '''", "[a.b]\n[a]\nb = 1", "x = 1979-05-27T07:32:00Z", "x = 0x_1", "\ufeff"),
    *('x = "\\ud800"', 'x = "\\u0000"', "x = 1e400", "x = -nan", "x = {a = 1, a = 2}", "# é"),
    *("x = " + "[" * 400 + "]" * 400, "x = " + "{a=" * 200 + "1" + "}" * 200, "[" + "a." * 300),
    *("x = " + "[" * 51 + "]" * 51, "x = " + "[" * 900 + "]" * 900, "[" + "a." * 900 + "b]\nx = 1"),
    *(
        "x = " + "[" * 20000,
        "x = " + "9" * 5000,
        "x = 0x" + "f" * 5000,
        "x = 0." + "3" * 5000,
        "\0",
        "x = {a.b.c = 1}",
    ),
)


def _of(random: Random, values: Sequence[Any]) -> Any:
    return values[int(random.integers(len(values)))]


def _copied(node: Any) -> Any:
    if isinstance(node, dict):
        return {key: _copied(value) for key, value in node.items()}
    return [_copied(value) for value in node] if isinstance(node, list) else node


class Corpus:
    """Documents that faults are put into.

    changed : makes of random numbers and the documents one more fault of a kind's own.
    """

    def __init__(
        self,
        documents: Sequence[Mapping[str, Any]],
        changed: Callable[[Random, dict[str, Any]], None] | None = None,
    ) -> None:
        self.documents = [dict(document) for document in documents]
        self.changed = changed
        self._known: dict[tuple[str, ...], list[Any]] = {}
        for document in self.documents:
            for place, value in _places(document):
                if value not in self._known.setdefault(place, []):
                    self._known[place].append(value)
        self._paths = sorted(self._known)

    def written(self, random: Random) -> bytes:
        """The text of a document with up to four faults."""
        document = _copied(_of(random, self.documents))
        for _ in range(int(_of(random, (0, 1, 1, 1, 2, 2, 3, 4)))):
            kind = random.integers(8)
            if kind < 3:
                self._of_another(random, document)
            elif kind == 3 and self.changed is not None:
                self.changed(random, document)
            else:
                _changed_value(random, document)
        text = toml_text(document)
        if random.integers(8) == 0:
            text = _torn(random, text)
        if random.integers(60) == 0:
            text = f"\ufeff{text}"
        data = text.encode("utf-8", "surrogatepass")
        return byte_faults(random, data) if random.integers(25) == 0 else data

    def _of_another(self, random: Random, document: dict[str, Any]) -> None:
        """A key of any document, with the value that it has there, or one near it."""
        path = _of(random, self._paths)
        value = _copied(_of(random, self._known[path]))
        table = document
        for key in path[:-1]:
            inner = table.get(key)
            if not isinstance(inner, dict):
                inner = table[key] = {}
            table = inner
        if path[-1] in table and random.integers(3) == 0:
            del table[path[-1]]
        else:
            table[path[-1]] = _near(random, value) if random.integers(2) else value


def _places(table: Mapping[str, Any], above: tuple[str, ...] = ()) -> Iterator[tuple[Any, Any]]:
    for key, value in table.items():
        yield (*above, key), value
        if isinstance(value, Mapping):
            yield from _places(value, (*above, key))


def _near(random: Random, value: Any) -> Any:
    """A value of the same type, mostly one that is possible."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        if value != value or abs(value) > 10**300:
            return _wild(random)
        kind = random.integers(6)
        if kind == 0:
            return -value
        if kind == 1:
            return float(_of(random, EXTREMES)) * (-1) ** int(random.integers(2))
        if kind == 2:
            return float(value) if isinstance(value, int) else int(value)
        factor = 10.0 ** random.uniform(-2, 2) if kind < 5 else 1 + 10.0 ** random.uniform(-16, -1)
        near = float(value) * factor
        return round(near) if isinstance(value, int) else near
    if isinstance(value, str):
        return _of(random, _STRINGS)
    if isinstance(value, list):
        value = list(value)
        kind = random.integers(5)
        if kind == 0 or not value:
            return value * 2 if kind else []
        place = int(random.integers(len(value)))
        if kind == 1:
            del value[place]
        elif kind == 2:
            value[place] = _near(random, value[place])
        elif kind == 3:
            value = value * int(_of(random, (2, 3, 1000)))
        else:
            value.insert(place, _copied(value[place]))
        return value
    return _wild(random)


def _wild(random: Random) -> Any:
    """A value of any type."""
    kind = random.integers(12)
    if kind < 7:
        return _of(random, _SCALARS)
    if kind < 9:
        return _of(random, _STRINGS)
    if kind < 11:
        return [_of(random, _SCALARS) for _ in range(int(random.integers(4)))]
    return {_of(random, _KEYS): _of(random, _SCALARS)}


def _changed_value(random: Random, document: dict[str, Any]) -> None:
    """One value replaced, lost, renamed, or put in, anywhere in the tables."""
    node: Any = document
    while True:
        keys = list(node) if isinstance(node, dict) else list(range(len(node)))
        if not keys:
            break
        key = _of(random, keys)
        if not (isinstance(node[key], dict | list) and node[key] and random.integers(4)):
            break
        node = node[key]
    kind = random.integers(8)
    if not keys or kind == 0:
        if isinstance(node, dict):
            node[_of(random, _KEYS)] = _wild(random)
        else:
            node.append(_wild(random))
    elif kind == 1:
        del node[key]
    elif kind == 2 and isinstance(node, dict):
        node[key + _of(random, ("s", "_mm", "x"))] = node.pop(key)
    elif kind == 3 and isinstance(node, dict):
        node[key] = {_of(random, _KEYS): node[key]}
    elif kind == 4:
        node[key] = [node[key]]
    elif kind < 7:
        node[key] = _near(random, node[key])
    else:
        node[key] = _wild(random)


def _torn(random: Random, text: str) -> str:
    """The text with a line lost, doubled, exchanged or put in."""
    lines = text.split("\n")
    place = int(random.integers(len(lines)))
    kind = random.integers(5)
    if kind == 0:
        del lines[place]
    elif kind == 1:
        lines.insert(int(random.integers(len(lines))), lines[place])
    elif kind == 2:
        other = int(random.integers(len(lines)))
        lines[place], lines[other] = lines[other], lines[place]
    else:
        lines.insert(place, _of(random, _LINES))
    return "\n".join(lines)


def toml_text(document: Mapping[str, Any]) -> str:
    """The TOML text of tables; values that TOML has not are written as what is nearest.

    >>> toml_text({"a": 1, "b": {"c": [1.5, "x"], "d": {}}})
    'a = 1\\n[b]\\nc = [1.5, "x"]\\nd = {}\\n'
    """
    rows = [f"{_key(k)} = {_value(v)}\n" for k, v in document.items() if not _is_table(v)]
    for key, table in document.items():
        if _is_table(table):
            rows.append(f"[{_key(key)}]\n")
            rows += [f"{_key(k)} = {_value(v)}\n" for k, v in table.items() if not _is_table(v)]
            for inner, value in table.items():
                if _is_table(value):
                    rows.append(f"[{_key(key)}.{_key(inner)}]\n")
                    rows += [f"{_key(k)} = {_value(v)}\n" for k, v in value.items()]
    return "".join(rows)


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping) and bool(value)


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "a").replace("-", "a").isalnum()
    return key if bare else _string(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and abs(value) > 10**4000:
        return hex(value)
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, datetime.date | datetime.time | datetime.datetime):
        return value.isoformat()
    return repr(value)


def _string(text: str) -> str:
    escapes = {'"': '\\"', "\\": "\\\\"}
    return (
        '"'
        + "".join(
            escapes.get(c) or (f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c)
            for c in text
        )
        + '"'
    )
