"""Work on foreign files in a process of its own, with bounds on its time and memory.

Libraries in C++ crash on damaged files, or never return: here that ends their own process alone.
The process is a new interpreter on every system, `python -m` this module `TASK REQUEST ANSWER`;
arrays come back in a file.
"""

from __future__ import annotations

import importlib
import json
import math
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import InvalidFile, InvalidJob
from fab.files import shown_path
from fab.scratch import temporary_folder
from solver.errors import InvalidState, InvalidValue, OrigamiError

__all__ = ["Bounds", "in_own_process"]

_CURE = "It is damaged, or too large: export it again, or as a simpler mesh."
# On a busy machine a second of processor time may take several on the clock.
_BUSY = 3
# How a process ends that the system stops for the time it took.
_OUT_OF_TIME = -int(getattr(signal, "SIGXCPU", 24))
# And where what it read cannot be written, as in sysexits.h.
_UNWRITTEN = 73


@dataclass(frozen=True)
class Bounds:
    """What the work may take: seconds of processor time, and MB of address space.

    Both are bounded where the operating system can, as Linux does; on the clock it may take three
    times as long.
    """

    seconds: float
    memory_mb: float


def in_own_process(
    task: str, path: Path, arguments: Mapping[str, Any], bounds: Bounds
) -> dict[str, Any]:
    """The arrays that a function returns for a file, called in a process of its own.

    task : as in "module:function". path : of the file, for messages. arguments : by name, as JSON
    has them.

    Raises what the function raises of the project's own errors, and `InvalidFile` where it raises
    others, crashes, or needs more than its bounds; `InvalidJob` where its answer cannot be written.
    The process ends with this call, however it ends.
    """
    with temporary_folder() as folder:
        request, answer = folder / "request.json", folder / "answer.npz"
        limits = [math.ceil(bounds.seconds), math.ceil(bounds.memory_mb)]
        request.write_text(json.dumps({"arguments": dict(arguments), "limits": limits}))
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__, task, str(request), str(answer)],
            stdin=subprocess.PIPE,  # which ends with this process, however that ends
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=_environment(),
        )
        try:
            code = process.wait(_BUSY * bounds.seconds)
        except subprocess.TimeoutExpired:
            code = _OUT_OF_TIME
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
            if process.stdin is not None:
                process.stdin.close()
        if code == _OUT_OF_TIME:
            took = f"took over {bounds.seconds:.4g} seconds to read and was given up"
            raise InvalidFile(f"{shown_path(path)}: {took}. {_CURE}")
        if code == _UNWRITTEN:
            raise InvalidJob(
                f"temporary files cannot be written: what was read of {shown_path(path)} does not "
                "fit. Free some space, or set TMPDIR to a folder that has some."
            )
        if code != 0 or not answer.is_file():
            why = f"the library that reads it crashed ({_ending(code)})"
            raise InvalidFile(f"{shown_path(path)}: {why}. {_CURE}")
        with np.load(answer, allow_pickle=False) as archive:
            found = {name: archive[name] for name in archive.files}
    if "refusal" in found:
        raise _refusal(path, json.loads(str(found["refusal"])), bounds)
    return found


def _environment() -> dict[str, str]:
    """The environment with the same modules to be found, and a single thread of linear algebra.

    Each thread of it would take address space, which is bounded.
    """
    places = [place or str(Path.cwd()) for place in sys.path]
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(places),
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
    }


def _ending(code: int) -> str:
    if code >= 0:
        return f"exit code {code}"
    with suppress(ValueError):
        return signal.Signals(-code).name
    return f"signal {-code}"


def _refusal(path: Path, parts: Mapping[str, Any], bounds: Bounds) -> OrigamiError:
    """The error that the process reported."""
    kind, said = parts["kind"], parts["parts"]
    if kind == "InvalidState":
        return InvalidState(said[0], said[1], said[3])
    if kind == "InvalidValue":
        return InvalidValue(*said)
    if kind == "InvalidFile":
        return InvalidFile(said[0])
    if kind == "MemoryError":
        needed = f"needs over {bounds.memory_mb:.4g} MB of memory to be read"
        return InvalidFile(f"{shown_path(path)}: {needed}. {_CURE}")
    return InvalidFile(f"{shown_path(path)}: cannot be read: {kind}: {said[0]}. {_CURE}")


def _parts(error: BaseException) -> dict[str, Any]:
    """An error as `_refusal` takes it."""
    kind = type(error).__name__
    if isinstance(error, InvalidValue):
        value = error.value
        shown = value if value is None or isinstance(value, int | float | str) else str(value)
        return {"kind": kind, "parts": [error.name, shown, error.bound, error.cure]}
    if isinstance(error, InvalidFile):
        return {"kind": kind, "parts": [str(error)]}
    lines = str(error).strip().splitlines() or ["no reason is given"]
    return {"kind": kind, "parts": [lines[0][:200].rstrip(".")]}


def _limit(seconds: int, megabytes: int) -> None:
    """Bound the processor time and address space of this process, where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for limit, value in (
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_AS, megabytes * 10**6),
        (resource.RLIMIT_CORE, 0),
    ):
        with suppress(ValueError, OSError):  # macOS has no bound on address space
            most = resource.getrlimit(limit)[1]
            if most != resource.RLIM_INFINITY:
                value = min(value, most)
            resource.setrlimit(limit, (value, most))


def _end_with_parent() -> None:
    """End this process when the one that waits for it ends, even where that was killed."""
    with suppress(OSError):
        os.read(0, 1)  # not of `sys.stdin`, whose lock an interpreter that ends would wait for
    os._exit(1)


def _work(task: str, request: Path, answer: Path) -> None:
    """What the process does: call the function and write its arrays, or why there are none."""
    asked = json.loads(request.read_text())
    _limit(*asked["limits"])
    module, _, function = task.partition(":")
    try:
        found = getattr(importlib.import_module(module), function)(**asked["arguments"])
    except Exception as error:  # readers of foreign files raise all kinds
        found = {"refusal": np.array(json.dumps(_parts(error)))}
    try:
        np.savez(answer, **found)
    except OSError:
        os._exit(_UNWRITTEN)


if __name__ == "__main__":
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _work(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
