"""What the studio answers: its page, and what the page asks, to those who know its token.

Nothing of it lasts between two questions but the folder, so that two tabs, and a page that is
loaded again, do not disturb each other.
"""

from __future__ import annotations

import hmac
import json
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fab.catalogue import shipped, shipped_picture
from fab.errors import InvalidJob, did_you_mean
from fab.files import shortened
from fab.outputs import Made, write
from fab.scratch import temporary_folder
from fab.studio.dropped_files import MOST_DROPPED, kept_file
from fab.studio.exports import Exports
from fab.studio.job_text import MOST_BYTES
from fab.studio.messages import packed_answer
from fab.studio.places import inside
from fab.studio.stock import stock, usual_names
from fab.studio.worker import Worker, WorkerLost, WorkerStopped
from solver import Side
from solver.errors import OrigamiError

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response

__all__ = ["MOST_CHANGES", "MOST_MESSAGE", "Studio", "studio_app"]

# Seconds that a sheet, a picture, and all files of a job or its simulation may take.
_GROW_S, _PICTURE_S, _MAKE_S = 300.0, 30.0, 3600.0
# Of a message: a job's text, escaped, and changes to it.
MOST_MESSAGE = 3 * MOST_BYTES
MOST_CHANGES = 200
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
_HEADERS = {
    "Content-Security-Policy": _POLICY,
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
# Of pages that were made: within the studio's, cut off from it and from all else.
_MADE = {
    **_HEADERS,
    "Content-Security-Policy": "sandbox allow-scripts allow-downloads; frame-ancestors 'self'",
}
_ASSETS = {
    "studio.js": ("fab.studio", "text/javascript"),
    "views.js": ("fab.viewing", "text/javascript"),
    "studio.css": ("fab.studio", "text/css"),
    "page.css": ("fab.viewing", "text/css"),
    "three_licence.txt": ("fab.viewing", "text/plain"),
}


@dataclass(frozen=True)
class Studio:
    """What a studio works on.

    Attributes
    ----------
    folder : where it reads and writes, and nowhere else.
    token : without which it answers nothing.
    file : in the folder, a job or a pattern that it begins with; None for the gallery.
    allow_code : whether a Python file that a job names is run.
    worker, painter, maker : processes that grow sheets, draw the gallery, and make files and
        simulate.
    """

    folder: Path
    token: str
    file: Path | None = None
    allow_code: bool = False
    worker: Worker = field(default_factory=Worker)
    painter: Worker = field(default_factory=Worker)
    maker: Worker = field(default_factory=Worker)

    def stop(self) -> None:
        """End what all of them are at; who waits is told that it was stopped."""
        for worker in (self.worker, self.painter, self.maker):
            worker.stop()


class _Malformed(Exception):
    """A message that the page does not send."""


def studio_app(studio: Studio, hosts: frozenset[str]) -> Starlette:
    """The application; hosts : such as "127.0.0.1:8000", by which the page may be reached."""
    from starlette.applications import Starlette
    from starlette.concurrency import run_in_threadpool
    from starlette.middleware import Middleware
    from starlette.routing import Route

    pictures: dict[str, Path] = {}
    exports: list[Exports] = []

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        with temporary_folder() as folder:
            pictures["folder"] = folder
            exports[:] = [Exports(folder / "made")]
            try:
                yield
            finally:
                for worker in (studio.worker, studio.painter, studio.maker):
                    worker.close()

    async def page(_: Request) -> Response:
        return _plain((files("fab.studio") / "page_assets" / "studio.html").read_bytes())

    async def asset(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in _ASSETS:
            return _refusal(404, "no such file")
        package, media = _ASSETS[name]
        return _plain((files(package) / "page_assets" / name).read_bytes(), media)

    async def start(_: Request) -> Response:
        return _plain(json.dumps(_beginning(studio)).encode(), "application/json")

    async def picture(request: Request) -> Response:
        name = request.path_params["name"]
        path = shipped("jobs").get(name)
        if path is None:
            return _refusal(404, "no such template")
        kept = shipped_picture(name) or pictures["folder"] / f"{name}.png"
        if not kept.is_file():
            try:
                drawn = await _ask(studio.painter, "picture", {"path": str(path)}, _PICTURE_S)
            except (InvalidJob, WorkerLost):
                return _refusal(204, "")
            kept.write_bytes(drawn)
        return _plain(kept.read_bytes(), "image/png")

    def answers(ask: Callable[[Mapping[str, Any]], Any]) -> Callable[[Request], Any]:
        async def endpoint(request: Request) -> Response:
            try:
                message = await _message(request)
                return _plain(await ask(message), "application/octet-stream")
            except _Malformed as error:
                return _refusal(400, str(error))
            except _TooLarge as error:
                return _refusal(413, str(error))
            except InvalidJob as error:
                return _plain(packed_answer({"refused": str(error)}), "application/octet-stream")
            except WorkerStopped:
                return _plain(packed_answer({"stopped": True}), "application/octet-stream")
            except WorkerLost as error:
                text = f"The process that does the work was lost: {error}"
                return _plain(packed_answer({"lost": text}), "application/octet-stream")

        return endpoint

    common = {"folder": str(studio.folder), "allow_code": studio.allow_code}

    async def asked(task: str, arguments: Mapping[str, Any], message: Mapping[str, Any]) -> bytes:
        found: bytes = await _ask(studio.worker, task, arguments, _GROW_S, _tab(message))
        return found

    async def opened(message: Mapping[str, Any]) -> bytes:
        text = _text_of(message) if "text" in message else _template(_word(message, "template"))
        return await asked("opened", {"text": text, **common}, message)

    async def grow(message: Mapping[str, Any]) -> bytes:
        arguments = {
            "text": _text_of(message),
            "changes": _changes(message),
            "topology": _word(message, "topology"),
        }
        return await asked("grow", {**arguments, **common}, message)

    async def fold(message: Mapping[str, Any]) -> bytes:
        return await asked("fold", {"text": _text_of(message), **common}, message)

    async def read(message: Mapping[str, Any]) -> bytes:
        path = str(inside(studio.folder, _word(message, "file")))
        if message.get("states") is True:
            return await asked("read_fold", {"path": path}, message)
        return await asked("read", {"path": path, "topology": _word(message, "topology")}, message)

    async def hand(message: Mapping[str, Any]) -> bytes:
        arguments = {
            "text": _text_of(message),
            "changes": _changes(message),
            "strip": _count(message, "strip"),
            "landscape": _word(message, "landscape"),
        }
        return await asked("hand_state", {**arguments, **common}, message)

    async def next_strip(message: Mapping[str, Any]) -> bytes:
        side = _word(message, "side")
        if side not in list(Side):
            raise _Malformed(f"side must be one of {', '.join(Side)}.")
        arguments = {"text": _text_of(message), "changes": _changes(message), "side": side}
        return await asked("next_strip", {**arguments, **common}, message)

    async def by_hand(message: Mapping[str, Any]) -> bytes:
        arguments = {"text": _text_of(message), "changes": _changes(message)}
        return await asked("by_hand", {**arguments, **common}, message)

    async def save(message: Mapping[str, Any]) -> bytes:
        text, name, before = _text_of(message), _word(message, "file"), message.get("before")
        await asked(
            "opened", {"text": text, **common}, message
        )  # what cannot be opened is not saved
        return packed_answer(
            _saved(studio.folder, text, name, before, replace=message.get("replace") is True)
        )

    async def make(message: Mapping[str, Any]) -> bytes:
        file = "" if "text" in message else _word(message, "file")
        key, place = exports[0].place()
        arguments = {
            "command": _among(message, "command", ("run", "fabricate", "thicken")),
            "text": _text_of(message) if "text" in message else None,
            "file": str(inside(studio.folder, file)),
            "request": _stock_request(message),
            "place": str(place),
            **common,
        }
        found = await _ask(studio.maker, "export", arguments, _MAKE_S, _tab(message))
        exports[0].add(key, [name for name, _ in found["files"]])
        return packed_answer({**found, "key": key})

    async def simulate(message: Mapping[str, Any]) -> bytes:
        arguments: dict[str, Any] = {"contact": message.get("contact") is True}
        if "text" in message:
            task = "simulate"
            arguments |= {"text": _text_of(message), **common}
        else:
            task = "simulate_file"
            arguments["path"] = str(inside(studio.folder, _word(message, "file")))
        found: bytes = await _ask(studio.maker, task, arguments, _MAKE_S, _tab(message))
        return found

    async def keep(message: Mapping[str, Any]) -> bytes:
        into = inside(studio.folder, _word(message, "into"))
        await run_in_threadpool(exports[0].keep, _word(message, "key"), into)
        return packed_answer({"into": str(into)})

    async def made(request: Request) -> Response:
        key, name = request.path_params["key"], request.path_params["name"]
        try:
            if name == "all.zip":
                return _plain(await run_in_threadpool(exports[0].archive, key), "application/zip")
            path = exports[0].files(key).get(name)
        except InvalidJob as error:
            return _refusal(404, str(error))
        if path is None:
            return _refusal(404, "no such file")
        data = await run_in_threadpool(path.read_bytes)
        if path.suffix == ".html":
            return _plain(data, "text/html", _MADE)
        return _plain(data, "application/octet-stream")

    async def progress(message: Mapping[str, Any]) -> bytes:
        step = studio.maker.step(_tab(message))
        return packed_answer({"step": None if step is None else step.report()})

    async def stocked(message: Mapping[str, Any]) -> bytes:
        del message
        found = await run_in_threadpool(stock, studio.folder)
        return packed_answer({"stock": found, "usual": usual_names()})

    async def drop(request: Request) -> Response:
        try:
            data = await _body(request, MOST_DROPPED)
            name = _word(request.query_params, "name")
            kept = await run_in_threadpool(kept_file, studio.folder, name, data)
        except _TooLarge as error:
            return _refusal(413, str(error))
        except _Malformed as error:
            return _refusal(400, str(error))
        except OrigamiError as error:
            kept = {"refused": str(error)}
        return _plain(packed_answer(kept), "application/octet-stream")

    async def stop(message: Mapping[str, Any]) -> bytes:
        for worker in (studio.worker, studio.maker):
            worker.stop(_tab(message))
        return packed_answer({})

    posts = {"open": opened, "grow": grow, "fold": fold, "read": read, "save": save}
    posts |= {"make": make, "keep": keep, "progress": progress, "stop": stop, "stock": stocked}
    posts |= {"hand": hand, "next_strip": next_strip, "by_hand": by_hand, "simulate": simulate}
    base = "/{token}"
    return Starlette(
        routes=[
            Route(f"{base}/", page),
            Route(f"{base}/start", start),
            Route(f"{base}/drop", drop, methods=["POST"]),
            Route(f"{base}/pictures/{{name}}", picture),
            Route(f"{base}/made/{{key}}/{{name}}", made),
            *(
                Route(f"{base}/{name}", answers(ask), methods=["POST"])
                for name, ask in posts.items()
            ),
            Route(f"{base}/{{name}}", asset),
        ],
        middleware=[Middleware(_Guard, token=studio.token, hosts=hosts)],
        lifespan=lifespan,
    )


class _Guard:
    """Refuses, with 403, whoever lacks the token or comes from another page or by another name."""

    def __init__(self, app: Any, token: str, hosts: frozenset[str]) -> None:
        self.app, self.token, self.hosts = app, token.encode(), hosts

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "lifespan" or (scope["type"] == "http" and self._allowed(scope)):
            await self.app(scope, receive, send)
        elif scope["type"] == "http":
            await _refusal(403, "This address has no valid token, or another page sent it here.")(
                scope, receive, send
            )

    def _allowed(self, scope: Any) -> bool:
        headers = [(name.lower(), value.decode("latin-1")) for name, value in scope["headers"]]
        given = [value for name, value in headers if name == b"host"]
        origins = [value for name, value in headers if name == b"origin"]
        token = scope["path"].split("/")[1] if scope["path"].startswith("/") else ""
        return (
            len(given) == 1
            and given[0] in self.hosts
            and all(origin.removeprefix("http://") in self.hosts for origin in origins)
            and hmac.compare_digest(token.encode("utf-8", "replace"), self.token)
        )


class _TooLarge(Exception):
    """A body that is longer than its bound."""


def _plain(
    data: bytes, media: str = "text/html", headers: Mapping[str, str] = _HEADERS
) -> Response:
    from starlette.responses import Response

    return Response(data, headers=headers, media_type=media)


def _refusal(status: int, text: str) -> Response:
    from starlette.responses import PlainTextResponse

    return PlainTextResponse(text, status, headers=_HEADERS)


async def _ask(
    worker: Worker, task: str, arguments: Mapping[str, Any], seconds: float, owner: str = ""
) -> Any:
    from starlette.concurrency import run_in_threadpool

    return await run_in_threadpool(worker.ask, task, arguments, seconds, owner)


async def _body(request: Request, most: int) -> bytes:
    """The body of a request, read no further than its bound."""
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise _TooLarge(f"The message has more than {most} bytes, the most that is taken.")
        parts.append(part)
    return b"".join(parts)


async def _message(request: Request) -> Mapping[str, Any]:
    body = await _body(request, MOST_MESSAGE)
    try:
        message = json.loads(body)
    except (ValueError, RecursionError) as error:
        raise _Malformed("The message is not JSON.") from error
    if not isinstance(message, dict):
        raise _Malformed("The message is not an object.")
    return message


def _word(message: Mapping[str, Any], key: str) -> str:
    value = message.get(key)
    if not isinstance(value, str) or len(value) > 1000 or "\0" in value:
        raise _Malformed(f"{key} must be a short text.")
    return value


def _tab(message: Mapping[str, Any]) -> str:
    """Which tab asks; pages without a name for theirs stop one another."""
    return _word(message, "tab") if "tab" in message else ""


def _among(message: Mapping[str, Any], key: str, choices: Sequence[str]) -> str:
    word = _word(message, key)
    if word not in choices:
        raise _Malformed(f"{key} must be one of {', '.join(choices)}.")
    return word


def _stock_request(message: Mapping[str, Any]) -> dict[str, Any]:
    """What sheets or panels are made of and with; empty where it is left out."""
    names = ("material", "machine", "printer", "print_material")
    words = {name: _word(message, name) if name in message else "" for name in names}
    copies = message.get("copies", 1)
    if isinstance(copies, bool) or not isinstance(copies, int):
        raise _Malformed("copies must be a whole number.")
    return {**words, "copies": copies, "two_sided": message.get("two_sided") is True}


def _text_of(message: Mapping[str, Any]) -> str:
    value = message.get("text")
    if not isinstance(value, str):
        raise _Malformed("text must be the text of a job.")
    return value


def _changes(message: Mapping[str, Any]) -> list[tuple[list[str], Any]]:
    """Changes of values: tables and key, and a number, a text, true, false, null, or tables."""
    given = message.get("changes")
    if not isinstance(given, list) or len(given) > MOST_CHANGES:
        raise _Malformed(f"changes must be a list of up to {MOST_CHANGES}.")
    changes = []
    for each in given:
        if not (isinstance(each, list) and len(each) == 2 and isinstance(each[0], list)):
            raise _Malformed("A change must be a path and a value.")
        path, value = each
        if not path or len(path) > 8 or not all(isinstance(part, str) for part in path):
            raise _Malformed("A path must have 1 to 8 keys.")
        if not (_is_plain(value) or (isinstance(value, list) and all(map(_is_row, value)))):
            raise _Malformed(
                "A value must be a number, a text, true, false, null, or a list of tables of them."
            )
        changes.append((path, value))
    return changes


def _is_plain(value: Any) -> bool:
    return isinstance(value, bool | int | float | str | None)


def _is_row(value: Any) -> bool:
    """Whether a value is a table of plain values and lists of these, none of them null."""
    return isinstance(value, dict) and all(
        (_is_plain(each) and each is not None)
        or (isinstance(each, list) and all(isinstance(part, int | float | str) for part in each))
        for each in value.values()
    )


def _count(message: Mapping[str, Any], key: str) -> int | None:
    value = message.get(key)
    if value is not None and (isinstance(value, bool) or not isinstance(value, int)):
        raise _Malformed(f"{key} must be a whole number, or null.")
    return value


def _beginning(studio: Studio) -> dict[str, Any]:
    """What the page begins with: the gallery, and the file that was given."""
    from fab.studio.gallery import templates
    from fab.viewing.drawing import CREASE_INK
    from fab.viewing.page_drawings import LOWER, UPPER

    file = studio.file
    text = None
    if file is not None and file.suffix == ".toml":
        text = _read(file)
    return {
        "templates": templates(),
        "folder": str(studio.folder),
        "file": None if file is None else file.name,
        "text": text,
        "colours": {"upper": UPPER, "lower": LOWER, "edges": CREASE_INK},
    }


def _read(file: Path) -> str | None:
    """The text of a job's file; None where it is none."""
    try:
        return file.read_text(encoding="utf-8-sig")
    except (OSError, ValueError):
        return None


def _template(name: str) -> str:
    known = shipped("jobs")
    if name not in known:
        hint = did_you_mean(name, known)
        raise InvalidJob(f"template {shortened(name)!r} must be one of the gallery.{hint}")
    return known[name].read_text(encoding="utf-8")


def _saved(folder: Path, text: str, name: str, before: Any, *, replace: bool) -> dict[str, Any]:
    """Write a job into the folder; where a file has its name, only if that may be replaced.

    before : the text that the file has, as far as the page knows: then it may.
    """
    path = inside(folder, name)
    if path.parent != folder.resolve() or path.suffix != ".toml":
        raise InvalidJob(f"{shortened(name)!r} must be the name of a .toml file, without a folder.")
    known = isinstance(before, str) and _read(path) == before
    if path.exists() and not replace and not known:
        return {"exists": path.name}
    write(Made({path.name: text.encode()}, {}, ()), folder)
    return {"saved": str(path)}
