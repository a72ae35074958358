"""Rows of a sweep: a variation run as far as it is asked to; figures, or why it ended."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from fab.errors import Severity
from fab.jobs.job_files import Sheet, grown_sheet
from fab.outputs import Made, write
from fab.sweeps.columns import FIGURES, figures_of
from fab.sweeps.sweep_settings import Measure, Sweep
from fab.sweeps.variations import Variation
from solver.errors import OrigamiError

__all__ = ["Batch", "ended_row", "row_of"]

# Which files a job makes so that these figures are in its report.
_FORMATS = {Measure.THICK: "stl", Measure.SHEETS: "dxf"}
_LONGEST_MESSAGE = 500


@dataclass(frozen=True)
class Batch:
    """Variations that a worker takes at once. It can be sent to another process.

    folder : where files of variations are written; None where none are kept.
    """

    sweep: Sweep
    variations: tuple[Variation, ...]
    folder: Path | None = None


def row_of(sweep: Sweep, variation: Variation, folder: Path | None = None) -> dict[str, Any]:
    """The row of a variation. What goes wrong in it is in the row, and raises nothing.

    Its key "picture", of sweeps that have pictures, is no column, but a PNG file. Raises
    `InvalidJob` where its files cannot be written, which is no fault of the variation.
    """
    began = time.perf_counter()
    made: Made | None = None
    try:
        with _time_limit(sweep.limits.seconds):
            outcome, made = _made(sweep, variation)
    except _TooSlow:
        text = f"took more than limits.seconds = {sweep.limits.seconds:g}"
        outcome = {"status": "too slow", "message": text}
    except OrigamiError as error:
        outcome = {"status": "refused", "message": _short(error)}
    except MemoryError:
        outcome = {"status": "too large", "message": _memory_text(sweep)}
    except Exception as error:  # a fault of ours or of a library must not end the sweep
        outcome = {"status": "failed", "message": _short(f"{type(error).__name__}: {error}")}
    if folder is not None and made is not None:
        write(made, folder / variation.job_hash)
    seconds = round(time.perf_counter() - began, 4)
    return _row(variation, {**outcome, "seconds": seconds})


def ended_row(variation: Variation, status: str, message: str) -> dict[str, Any]:
    """The row of a variation whose process ended: it crashed, or could not be interrupted."""
    return _row(variation, {"status": status, "message": message, "seconds": None})


def _row(variation: Variation, outcome: Mapping[str, Any]) -> dict[str, Any]:
    empty = {"message": "", "errors": "", "warnings": "", **dict.fromkeys(c.name for c in FIGURES)}
    return {"job_hash": variation.job_hash, **empty, **outcome}


def _made(sweep: Sweep, variation: Variation) -> tuple[dict[str, Any], Made]:
    """What is in the row, and the files that are kept."""
    sheet = grown_sheet(sweep.job(variation.values))
    formats = {_FORMATS[measure] for measure in sweep.measure if measure in _FORMATS}
    made = sheet.make([*formats, *sweep.outputs], rigidity=Measure.RIGID in sweep.measure)
    kept = tuple(f".{ending}" for ending in (*sweep.outputs, "json"))
    files = {name: data for name, data in made.files.items() if name.endswith(kept)}
    codes: dict[Severity, list[str]] = {severity: [] for severity in Severity}
    for finding in made.findings:
        codes[finding.severity].append(finding.code)
    outcome = {
        "status": "made",
        "errors": " ".join(dict.fromkeys(codes[Severity.ERROR])),
        "warnings": " ".join(dict.fromkeys(codes[Severity.WARNING])),
        **figures_of(made.report),
        **({"picture": _picture(sheet)} if sweep.pictures else {}),
    }
    return outcome, Made(files, made.report, made.findings)


def _picture(sheet: Sheet) -> bytes:
    from fab.sweeps.thumbnails import thumbnail_bytes
    from fab.viewing.scene_builders import pattern_scene

    scene = pattern_scene(sheet.pattern, sheet.settings.name, upright=sheet.upright)
    return thumbnail_bytes(scene)


class _TooSlow(BaseException):
    """Raised within a variation at its limit; no library may swallow it as an Exception."""


@contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    """Raise `_TooSlow` after so long, where the system has timers and this is the main thread."""
    if (
        not hasattr(signal, "setitimer")
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return

    def over(number: int, frame: FrameType | None) -> None:
        del number, frame
        raise _TooSlow

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _short(error: object) -> str:
    text = " ".join(str(error).split())
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[: _LONGEST_MESSAGE - 3]}..."


def _memory_text(sweep: Sweep) -> str:
    limit = sweep.limits.memory_mb
    return "out of memory" if limit is None else f"needs more than limits.memory_mb = {limit}"
