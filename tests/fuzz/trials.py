"""One input, tried within bounds: on time, on memory, on what is opened, and on what is answered.

An input may be taken, or refused by an error of the project's own with a sentence that can be
printed. All else is a fault: other exceptions, hangs, memory, files and addresses that it names.
"""

from __future__ import annotations

import re
import resource
import signal
import sys
import time
import traceback
import unicodedata
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solver.errors import OrigamiError

__all__ = ["Kind", "Trial", "generator_of", "trial_of", "watched_opens"]

_STATUS = Path("/proc/self/status")
# Refusals say what, where and how to mend it, and not all that the file holds.
_SHORTEST, _LONGEST = 20, 20_000
# Exceptions that say something of the program and nothing of the file, wherever they are quoted.
_RAW = ("MemoryError", "RecursionError", "AssertionError", "NotImplementedError", "Segmentation")


@dataclass(frozen=True)
class Kind:
    """A kind of input.

    Attributes
    ----------
    name : as in "svg".
    file : the name of the file that an input is written to.
    written : an input, by random numbers.
    read : what is to take or to refuse it, by the path of that file; asserts what must hold of
        what it takes. It returns what it took, in words, which is the same for the same input.
    seconds : of processor time that an input may take.
    memory_mb : that it may take over what the process had.
    share : of the time of a run.
    opens : whether it may open other files than its own.
    """

    name: str
    file: str
    written: Callable[[np.random.Generator], bytes]
    read: Callable[[Path, np.random.Generator], str]
    seconds: float = 10.0
    memory_mb: float = 300.0
    share: float = 1.0
    opens: bool = False


@dataclass(frozen=True)
class Trial:
    """What came of an input: "taken", "refused" or "fault", with its text; seconds and MB."""

    outcome: str
    text: str
    seconds: float
    memory_mb: float


class _TooSlow(BaseException):
    """Raised in an input that takes too long; no reader catches it as an error of a library."""


def generator_of(kind: Kind, seed: int, number: int) -> np.random.Generator:
    """The random numbers of an input, the same in every run."""
    return np.random.default_rng([seed, zlib.crc32(kind.name.encode()), number])


def trial_of(kind: Kind, data: bytes, random: np.random.Generator, folder: Path) -> Trial:
    """Try an input, which is written to a file of the folder; twice now and then."""
    path = folder / kind.file
    path.write_bytes(data)
    twice = random.integers(32) == 0
    drawn = random.bit_generator.state
    _forget_most()
    before = _most_mb()
    begin = time.process_time()
    outcome, text = _answer(kind, path, random)
    seconds = time.process_time() - begin
    memory = _most_mb() - before
    if outcome != "fault" and memory > kind.memory_mb:
        outcome, text = "fault", f"needs {memory:.0f} MB, over {kind.memory_mb:g}: {text}"
    if outcome != "fault" and twice:
        random.bit_generator.state = drawn
        again = _answer(kind, path, random)
        if again != (outcome, text):
            outcome, text = "fault", f"read twice it differs:\n{text}\n{again[1]}"
    return Trial(outcome, text, seconds, memory)


def _answer(kind: Kind, path: Path, random: np.random.Generator) -> tuple[str, str]:
    """Whether an input is taken, refused or a fault, and the words that go with it."""
    try:
        with _within(kind.seconds), watched_opens(None if kind.opens else path) as strayed:
            try:
                outcome, text = "taken", kind.read(path, random)
            except OrigamiError as error:
                outcome, text = "refused", str(error)
    except _TooSlow:
        return "fault", f"over {kind.seconds:g} s of processor time\n{traceback.format_exc()}"
    except Exception:
        return "fault", traceback.format_exc()
    if strayed:
        return "fault", f"opens {', '.join(strayed)}"
    wrong = _wrong_words(text) if outcome == "refused" else ""
    return ("fault", f"{wrong}: {text[:500]!r}") if wrong else (outcome, text)


def _wrong_words(text: str) -> str:
    """What is wrong with the text of a refusal, in words; empty where nothing is."""
    if not _SHORTEST <= len(text) <= _LONGEST:
        return f"a refusal of {len(text)} letters"
    if any(unicodedata.category(c) in ("Cc", "Cs") for c in text if c != "\n"):
        return "a refusal with control characters"
    if not text.rstrip().endswith((".", "?")):
        return "a refusal that is no sentence"
    named = [word for word in _RAW if word in text]
    return f"a refusal that quotes {named[0]}" if named else ""


@contextmanager
def _within(seconds: float) -> Iterator[None]:
    """Raise `_TooSlow` after some seconds of processor time."""

    def stop(_number: int, _frame: object) -> None:
        raise _TooSlow

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def _forget_most() -> None:
    """Begin to count anew, where the system can: what an input before took hides nothing."""
    with suppress(OSError):
        _STATUS.with_name("clear_refs").write_text("5")


def _most_mb() -> float:
    """Memory that the process has had at most, since it was forgotten."""
    if not _STATUS.is_file():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    found = re.search(rb"VmHWM:\s*(\d+)", _STATUS.read_bytes())
    return int(found.group(1)) / 1024 if found else 0.0


# What is watched: the file that may be opened, and what else was; None while nothing is.
_watch: tuple[str, list[str]] | None = None
_hooked = False
# Files of the interpreter, its libraries and the project, and those that the system is asked by.
_OWN = (sys.prefix, sys.base_prefix, str(Path(__file__).parents[2]), "/proc/", "/dev/null", "/usr/")
# What Python 3.13 looks for where a library logs a traceback: the source of code without a file.
_NO_FILE = "<unknown>"


def _hook(event: str, arguments: tuple[object, ...]) -> None:
    if _watch is None:
        return
    if event == "open":
        name = arguments[0]
        text = name.decode(errors="replace") if isinstance(name, bytes) else name
        if (
            isinstance(text, str)
            and text not in (_watch[0], _NO_FILE)
            and not text.startswith(_OWN)
        ):
            _watch[1].append(text)
    elif event in ("socket.connect", "socket.getaddrinfo", "subprocess.Popen", "os.system"):
        _watch[1].append(f"{event} {arguments}")


@contextmanager
def watched_opens(path: Path | None) -> Iterator[list[str]]:
    """What is opened besides a file, and connected to; nothing is watched without a path."""
    global _watch, _hooked
    if not _hooked:  # hooks stay for good
        sys.addaudithook(_hook)
        _hooked = True
    found: list[str] = []
    _watch = None if path is None else (str(path), found)
    try:
        yield found
    finally:
        _watch = None
