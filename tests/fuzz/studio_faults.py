"""What a studio is asked by pages that are not its own, and by users who try everything."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import random
import resource
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from starlette.testclient import TestClient
from studio_answers import head_of

from fab.catalogue import shipped
from fab.settings import read_toml

HOST = "127.0.0.1:8765"
# What the application may answer at all; whatever else it raises is a fault.
STATUSES = {200, 204, 400, 403, 404, 405, 413}
# A growth that takes longer is named, and the worker may have so much memory.
GROW_S = 60.0
MOST_BYTES = 4 * 10**9
POSTS = (
    *("open", "grow", "fold", "read", "save", "make", "keep", "progress", "stop", "stock"),
    *("hand", "next_strip", "by_hand"),
    *("drop", "start", "nothing", "made/0123456789abcdef/all.zip", "pictures/miura", "studio.js"),
)
WILD: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1e300, -1e300, float("nan"), float("inf"), 10**400, 2**53 + 1),
    *("", "x", "\0", "\ud800", "../..", "/etc/passwd", "miura", "a" * 1001, "\n", "%s%n", "🦢"),
    *([], {}, [[]], [None], {"a": {}}, [[["design", "rows"], {}]], ["\ud800"], [1] * 300),
)
PATHS = (
    *("..", "../x.toml", "/tmp/x.toml", "a/../../x.toml", ".", "", "x.toml/", "\\..\\x.toml"),
    *("~/x.toml", "x\0.toml", "\ud800.toml", "link/x.toml", "con.toml", "." * 300 + ".toml"),
)


@dataclass(frozen=True)
class Outcome:
    """How a question ended, its text and seconds.

    kind : "grown", "refused", "answered", "slow" or "fault".
    """

    kind: str
    text: str
    seconds: float


@dataclass(frozen=True)
class Message:
    """A message to the studio; its body is bytes, each as a letter."""

    method: str
    name: str
    body: str
    headers: dict[str, str]
    params: dict[str, str]

    def packed(self) -> bytes:
        return json.dumps(dataclasses.asdict(self)).encode()


def malformed(generator: random.Random) -> Message:
    """A message that no page sends."""
    name = generator.choice(POSTS)
    body = _body(generator)
    headers = generator.choice(
        ({}, {}, {}, {"origin": "null"}, {"host": "x"}, {"cookie": "a" * 5000})
    )
    method = generator.choice(("POST", "POST", "POST", "POST", "GET", "PUT", "DELETE", "HEAD"))
    query = generator.choice(({}, {"name": generator.choice(PATHS)}, {"name": "x.fold"}))
    params = {key: value.encode("utf-8", "replace").decode() for key, value in query.items()}
    return Message(method, name, body.decode("latin-1"), headers, params)


def answered(client: TestClient, message: Message) -> Outcome:
    """Send a message; a fault is what is not answered soundly."""
    name, body = message.name, message.body.encode("latin-1")
    begin = time.monotonic()
    try:
        response = client.request(
            message.method, name, content=body, headers=message.headers, params=message.params
        )
    except Exception as error:
        text = f"{message.method} {name} {body[:200]!r}: {type(error).__name__}: {error}"
        return Outcome("fault", text, time.monotonic() - begin)
    seconds = time.monotonic() - begin
    if response.status_code not in STATUSES:
        return Outcome("fault", f"{name} {body[:200]!r}: {response.status_code}", seconds)
    packed = response.headers.get("content-type") == "application/octet-stream"
    head = head_of(response.content) if packed and response.content[:1] != b"{" else {}
    if "lost" in head:
        return Outcome("fault", f"{name} {body[:300]!r}: {head['lost']}", seconds)
    return Outcome("answered", str(response.status_code), seconds)


def _body(generator: random.Random) -> bytes:
    """Bytes, torn JSON, or a message of which some values are not what they should be."""
    kind = generator.random()
    if kind < 0.1:
        return generator.randbytes(generator.randrange(200))
    job = generator.choice(("miura", "strip_by_strip"))
    text = shipped("jobs")[job].read_text(encoding="utf-8")
    message: dict[str, Any] = {
        "text": text,
        "template": "miura",
        "changes": generator.choice(([[["design", "rows"], generator.randrange(2, 9)]], [])),
        "side": generator.choice(("top", "left")),
        "strip": generator.choice((None, generator.randrange(-1, 9))),
        "landscape": "",
        "topology": "",
        "file": generator.choice(("x.fold", *PATHS)),
        "into": generator.choice(PATHS),
        "key": "0123456789abcdef",
        "command": generator.choice(("fabricate", "thicken")),
        "material": generator.choice(("card_300gsm", *PATHS)),
        "machine": generator.choice(("co2_60w_600x400", *PATHS)),
        "replace": True,
        "tab": generator.choice(("a", "b")),
    }
    for key in generator.sample(sorted(message), generator.randrange(1, 6)):
        if generator.random() < 0.4:
            del message[key]
        else:
            message[key] = generator.choice(WILD)
    if generator.random() < 0.3:
        message["text"] = _torn(generator, text)
    data = json.dumps(message).encode()
    if kind < 0.3:
        place = generator.randrange(len(data))
        data = data[:place] + generator.choice((b"", b"\xff", b"[" * 3000)) + data[place + 1 :]
    return data


def _torn(generator: random.Random, text: str) -> str:
    """The text of a job with a line lost, doubled, or turned into something else."""
    lines = text.splitlines()
    place = generator.randrange(len(lines))
    other = generator.choice(
        ("", lines[place] + "\n" + lines[place], "[design]", "a.b = 1", "x = [[[", '"\\ud800" = 1')
    )
    surface = f'[design]\nkind = "surface_fit"\nsurface = {json.dumps(generator.choice(PATHS))}'
    lines[place] = generator.choice((other, surface, "\ud800", "x = 1e400", "outputs = []"))
    return "\n".join(lines)


def designs() -> dict[str, str]:
    """A template of each design, the one of fewest columns."""
    columns: dict[str, tuple[int, str]] = {}
    for name, path in shipped("jobs").items():
        design = read_toml(path, "")["design"]
        found = (design.get("columns", 0), name)
        columns[design["kind"]] = min(columns.get(design["kind"], found), found)
    return {kind: name for kind, (_, name) in columns.items()}


class Designs:
    """Random parameters for the designs, as the fields of the page take them."""

    def __init__(self, client: TestClient) -> None:
        self._client = client
        self._opened: dict[str, Mapping[str, Any]] = {}

    def grown(self, template: str, generator: random.Random) -> Outcome:
        """Grow a template with some other values; a fault is any answer but a sheet or a reason."""
        if template not in self._opened:
            self._opened[template] = head_of(self._post("open", template=template))
        opened = self._opened[template]
        fields = [each for each in opened["fields"] if each["path"][0] in ("design", "sheet")]
        chosen = generator.sample(fields, min(len(fields), generator.randrange(1, 5)))
        changes = [[each["path"], _value(each, opened["values"], generator)] for each in chosen]
        if any(path[0] == "sheet" for path, _ in changes):  # the page leaves out other sizes
            path, value = next(each for each in changes if each[0][0] == "sheet")
            sizes = [each["path"] for each in opened["fields"] if each["path"][0] == "sheet"]
            changes = [each for each in changes if each[0][0] != "sheet"]
            changes += [[each, value if each == path else None] for each in sizes]
        begin = time.monotonic()
        try:
            data = self._post("grow", text=opened["text"], changes=changes, topology="")
            head = head_of(data)
        except Exception as error:
            head = {"lost": f"{type(error).__name__}: {error}"}
        seconds = time.monotonic() - begin
        if "refused" in head:
            return Outcome("refused", head["refused"], seconds)
        if seconds > GROW_S:
            return Outcome("slow", f"{template} {changes}", seconds)
        if "faces" in head:
            return Outcome("grown", head["status"], seconds)
        return Outcome("fault", f"{template} {changes}: {head}", seconds)

    def _post(self, name: str, **message: Any) -> bytes:
        return self._client.post(name, content=json.dumps(message)).content


def _value(field: Mapping[str, Any], values: Any, generator: random.Random) -> Any:
    """A value for a field: most often one that its slider reaches."""
    kind = generator.random()
    for key in field["path"]:
        values = values.get(key) if isinstance(values, Mapping) else None
    now = field["default"] if values is None else values
    if kind < 0.1:
        return generator.choice([each for each in WILD if not isinstance(each, list | dict)])
    if field["kind"] == "boolean":
        return generator.random() < 0.5
    if field["choices"]:
        return generator.choice(field["choices"])
    if field["kind"] not in ("number", "integer"):
        return generator.choice(("", "x", "dome", 1))
    now = now if isinstance(now, int | float) and not isinstance(now, bool) else 1
    low, high = field["low"], field["high"]
    if kind < 0.2:
        return generator.choice([low, high, 0, -now, 1e-9 * now, 10 * now])
    wide = 180.0 if field["unit"] == "°" else 3 * abs(now) or 3.0
    least = -wide if now < 0 else 0.0
    value = generator.uniform(least if low is None else max(low, least), min(high or wide, wide))
    return round(value) if field["kind"] == "integer" else value


def files_under(folder: Path) -> dict[str, str]:
    """A digest of every file in a folder."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file()
    }


def peak_bytes(process: int) -> int:
    """Memory that a process has had at most."""
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024


def numbered(seed: int, count: int) -> Iterator[random.Random]:
    """A generator for each number, so that each can be repeated alone."""
    return (random.Random(f"{seed}/{number}") for number in range(count))
