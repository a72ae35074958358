"""Designs of one's own: classes in a Python file beside the job, or of an installed package."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from pydantic import PydanticUserError

from fab.errors import InvalidJob, did_you_mean
from fab.files import require_file
from fab.jobs.design_settings import DesignSettings, design_settings
from solver.errors import OrigamiError

__all__ = ["GROUP", "CodeNotAllowed", "code_at", "own_design"]

# Packages offer designs under this group of entry points.
GROUP = "quadfold.designs"
_FORM = "such as mine.py:HelixFold, a file beside the job and a class in it"
_NEEDED = "It must be a dataclass with a method `grow`, as in solver/designs/miura.py."


class CodeNotAllowed(InvalidJob):
    """A job that names a Python file, whose code runs only where the user allows it.

    Attributes
    ----------
    path : the file.
    """

    def __init__(self, kind: str, path: Path) -> None:
        super().__init__(
            f"design.kind = {kind!r} runs the code of {path}. Read that file, then allow it with "
            "--allow-code (from Python: allow_code=True)."
        )
        self.path = path


def own_design(kind: str, folder: Path, *, allow_code: bool) -> type[DesignSettings] | None:
    """The job table of a design that is not a shipped one; None where nothing has that name.

    kind : "mine.py:HelixFold", a class in a file in `folder`, or the name of an entry point.
    allow_code : whether the file may be run; what is installed may be run at any time.

    Raises `CodeNotAllowed`, and `InvalidJob` for a file or class that is no design.
    """
    file, colon, name = kind.rpartition(":")
    if file.endswith(".py") or kind.endswith(".py"):
        if not (colon and name.isidentifier()):
            raise InvalidJob(f"design.kind = {kind!r} must name a file and a class, {_FORM}.")
        return _of_file(kind, folder / file, name, allow_code)
    points = tuple(entry_points(group=GROUP, name=kind))
    return _of_package(kind, points) if points else None


def _of_file(kind: str, path: Path, name: str, allow_code: bool) -> type[DesignSettings]:
    require_file(path, InvalidJob, "Put the file beside the job, or correct design.kind.")
    if not allow_code:
        raise CodeNotAllowed(kind, path)
    module = _module(path)
    if not hasattr(module, name):
        classes = [
            key for key, value in vars(module).items() if isinstance(value, type) and key[0] != "_"
        ]
        raise InvalidJob(f"{path}: no class {name}.{did_you_mean(name, classes)}")
    return _table(kind, getattr(module, name), str(path), name)


def _of_package(kind: str, points: tuple[EntryPoint, ...]) -> type[DesignSettings]:
    if len(points) > 1:
        values = ", ".join(point.value for point in points)
        raise InvalidJob(f"design.kind = {kind!r} is the name of several: {values}. Remove one.")
    place = f"entry point {kind} = {points[0].value}"
    try:
        cls = points[0].load()
        place = inspect.getsourcefile(cls) or place
    except Exception as error:
        raise InvalidJob(f"{place}: {_words(error)}. Correct its package.") from error
    return _table(kind, cls, place, cls.__name__)


def _module(path: Path) -> ModuleType:
    """The module in a file, run anew, since the file may have been edited."""
    digest = hashlib.sha256(str(path.absolute()).encode()).hexdigest()[:16]
    spec = importlib.util.spec_from_file_location(f"quadfold_design_{digest}", path)
    assert spec is not None  # the file ends in .py
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    try:
        with code_at(str(path)):
            # compiled anew: cached byte code is that of an edit within the same second
            exec(compile(path.read_bytes(), str(path), "exec"), vars(module))
    except BaseException:
        del sys.modules[spec.name]
        raise
    return module


def _table(kind: str, cls: Any, place: str, name: str) -> type[DesignSettings]:
    """The table of a class, or why it is no design."""
    if not (isinstance(cls, type) and dataclasses.is_dataclass(cls)):
        raise InvalidJob(f"{place}: {name} is not a dataclass. {_NEEDED}")
    if not callable(getattr(cls, "grow", None)):
        raise InvalidJob(f"{place}: {name} has no method `grow`. {_NEEDED}")
    taken = {"kind", "face", "up", *dir(DesignSettings)}
    for field in dataclasses.fields(cls):
        if field.init and (field.name in taken or field.name.startswith("_")):
            raise InvalidJob(f"{place}: {name}.{field.name} cannot be a key. Rename the field.")
    try:
        return design_settings(kind, cls, place)
    except (PydanticUserError, NameError, TypeError) as error:
        raise InvalidJob(
            f"{place}: a field of {name} cannot be a key: {_words(error)}. Use numbers, text and "
            "lists, with types that are imported when it runs."
        ) from error


@contextmanager
def code_at(place: str) -> Iterator[None]:
    """Name file and line where code of the user's own fails. The project's own errors pass.

    place : the file of the code.
    """
    try:
        yield
    except (OrigamiError, MemoryError):
        raise
    except (Exception, SystemExit) as error:
        line = _line(error, place)
        at = f"{place}, line {line}" if line is not None else place
        raise InvalidJob(f"{at}: {_words(error)}. Correct it there.") from error


def _line(error: BaseException, place: str) -> int | None:
    """The innermost line of a file that an error came by."""
    if isinstance(error, SyntaxError) and error.filename == place:
        return error.lineno
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == place]
    return lines[-1] if lines else None


def _words(error: BaseException) -> str:
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    first = text.splitlines()[0].rstrip(".") if text else ""
    return f"{type(error).__name__}: {first}" if first else type(error).__name__
