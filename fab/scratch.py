"""Folders that a run works in, and files that appear whole or not at all.

A folder of a run is removed when the run is done with it. Those of runs that were killed are
removed by the next run that works in the same place: a run holds a lock of the operating system on
its folder, which no process outlives. Where there are no such locks (Windows, some network
drives) these stay.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from fab.errors import InvalidJob
from fab.interrupts import held

__all__ = ["beside", "locked", "replaced", "temporary_folder"]

_TEMPORARY, _BESIDE = "quadfold-", ".quadfold-"
# What `tempfile` appends.
_SUFFIX = re.compile(r"[a-z0-9_]{8}")
# A folder that another run removes before it is locked is made again.
_TRIES = 20


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder among the system's temporary files, for the time of the block.

    Raises `InvalidJob` where there is no place for it.
    """
    with ExitStack() as stack:
        try:
            place = Path(tempfile.gettempdir())
            folder = stack.enter_context(_own_folder(place, _TEMPORARY))
        except OSError as error:
            why = error.strerror or error
            raise InvalidJob(
                f"temporary files cannot be written: {why}. Free some space, or set TMPDIR to a "
                "folder that has some."
            ) from error
        yield folder


@contextmanager
def beside(folder: Path) -> Iterator[Path]:
    """A folder within `folder`, on the same disk, for the time of the block."""
    with _own_folder(folder, _BESIDE) as own:
        yield own


@contextmanager
def replaced(path: Path, *, fresh: bool = False) -> Iterator[Path]:
    """A place to write a file at, which is at `path` when the block ends, and not where it fails.

    fresh : whether `FileExistsError` is raised where there is a file already.
    """
    with beside(path.parent) as own:
        written = own / path.name
        yield written
        with held():
            if fresh:
                _link(written, path)
            else:
                written.replace(path)


def _link(written: Path, path: Path) -> None:
    """Give a file a name that no other has, in one step where the file system can."""
    try:
        os.link(written, path, follow_symlinks=False)
    except FileExistsError:
        raise
    except (OSError, NotImplementedError):  # such as on FAT
        if os.path.lexists(path):  # a link to nothing is there too
            raise FileExistsError(path) from None
        written.replace(path)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Wait until no other run is within such a block; at once where there are no locks."""
    handle = _opened(folder.resolve())
    try:
        if handle is not None:
            _lock(handle, wait=True)
        yield
    finally:
        if handle is not None:
            os.close(handle)


@contextmanager
def _own_folder(place: Path, prefix: str) -> Iterator[Path]:
    folder: Path | None = None
    handle: int | None = None
    try:
        with held():
            _clear(place, prefix)
            folder, handle = _made(place, prefix)
        yield folder
    finally:
        with held():
            if folder is not None:
                shutil.rmtree(folder, ignore_errors=True)
            if handle is not None:
                os.close(handle)


def _made(place: Path, prefix: str) -> tuple[Path, int | None]:
    """A new folder and its lock; None where there is none."""
    for _ in range(_TRIES):
        folder = Path(tempfile.mkdtemp(prefix=prefix, dir=place))
        handle = _opened(folder)
        if handle is None or not _lock(handle, wait=True):
            if handle is not None:
                os.close(handle)
            if folder.is_dir():
                return folder, None
            continue
        with suppress(OSError):
            if os.path.samestat(os.fstat(handle), folder.stat()):
                return folder, handle
        os.close(handle)
    raise OSError(f"folders in {place} vanish as soon as they are made")


def _clear(place: Path, prefix: str) -> None:
    """Remove the folders of this user's runs that were killed."""
    try:
        names = [entry.name for entry in os.scandir(place) if entry.name.startswith(prefix)]
    except OSError:
        return
    for name in names:
        if not _SUFFIX.fullmatch(name.removeprefix(prefix)):
            continue
        handle = _opened(place / name)
        if handle is None:
            continue
        try:
            if os.fstat(handle).st_uid == os.geteuid() and _lock(handle, wait=False):
                shutil.rmtree(place / name, ignore_errors=True)
        finally:
            os.close(handle)


def _opened(folder: Path) -> int | None:
    """A folder as what a lock is held on; None for a link, or where the system has none."""
    if not hasattr(os, "O_DIRECTORY"):
        return None
    try:
        return os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except OSError:
        return None


def _lock(handle: int, *, wait: bool) -> bool:
    """Whether the lock was taken. It is held until the handle is closed, or the process ends."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except (ImportError, OSError):
        return False
    return True
