"""Checkpoints of long folds: files from which a fold that was cut short goes on.

A fold that takes longer than some seconds is kept, load after load, in a file beside the files that
it is made for. Started again with the same sheet and settings by the same version, it goes on from
there, and ends with the same bytes as in one go, since each load depends alone on what the one
before leaves to it (`fab.folding.quasi_static.Reached`). The file is named by a hash of all this,
so that no other fold takes it up.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import Finding, Severity
from fab.files import shortened
from fab.folding.bar_hinge_model import Energy, Framework
from fab.folding.quasi_static import FoldState, Reached
from fab.scratch import replaced
from solver.vectors import FloatArray, IntArray

__all__ = ["FoldCheckpoints"]

# A fold is kept after so many seconds, and as often from then on.
_EVERY_S = 5.0
# What the bits of a fold depend on besides the sheet.
_PACKAGES = ("quadfold", "numpy", "scipy", "rslab")
# Before the names of arrays that a fold carries from load to load.
_CARRIED = "carried_"


class FoldCheckpoints:
    """Those of the folds of one run, in a folder.

    folder : where they are written; made where it is missing. name : of the job or pattern.
    told : called with a line where a fold goes on, and a finding where a file cannot be used.
    every_s : seconds from one to the next, and before the first.
    """

    def __init__(
        self,
        folder: Path,
        name: str,
        told: Callable[[str | Finding], None] = lambda _: None,
        every_s: float = _EVERY_S,
    ) -> None:
        self._folder, self._name, self._told, self._every_s = folder, name, told, every_s
        self._key, self._used = "", list[Path]()
        self._kept_at = time.monotonic()
        self._fails = False

    def begin(
        self,
        frame: Framework,
        path: FloatArray,
        loads: int,
        per_step: int,
        others: Sequence[FloatArray | IntArray] = (),
    ) -> Reached | None:
        """How far the fold had come when it was cut short; None where it begins."""
        self._key = _key(frame, path, loads, per_step, others)
        self._kept_at, self._fails = time.monotonic(), False
        file = self._file
        if not file.is_file():
            return None
        self._used.append(file)
        try:
            reached = _read(file, self._key)
        except Exception as error:  # NumPy and zipfile raise whatever damaged bytes lead to
            why = str(error).partition("\n")[0]
            text = f"{file.name} cannot be used ({shortened(why)}): the fold begins from flat."
            self._told(Finding("checkpoint-unusable", Severity.WARNING, text))
            return None
        done = reached.number / loads
        self._told(f"fold: goes on at {done:.0%}, where it was cut short ({file.name})")
        return reached

    def keep(self, reached: Reached) -> None:
        """Write how far the fold has come, if the last time was long ago.

        And where it is over, if it has been kept before.
        """
        file = self._file
        over = reached.over and file in self._used
        if self._fails or not (over or time.monotonic() >= self._kept_at + self._every_s):
            return
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with replaced(file) as written, written.open("wb") as stream:
                np.savez(stream, **_arrays(reached, self._key))
        except OSError as error:
            self._fails = True
            text = f"{file.name} cannot be written ({error.strerror}): the fold is not kept."
            self._told(Finding("checkpoint-unusable", Severity.WARNING, text))
            return
        if file not in self._used:
            self._used.append(file)
        self._kept_at = time.monotonic()

    def cut_short(self) -> None:
        """Tell from which files the folds of this run can go on."""
        for file in self._used:
            if file.is_file():
                self._told(f"fold: kept in {file.name}; the same command goes on from there")

    def remove(self) -> None:
        """Remove the files of this run: what they are for has been made."""
        for file in self._used:
            with suppress(OSError):
                file.unlink(missing_ok=True)

    @property
    def _file(self) -> Path:
        return self._folder / f"{self._name}_checkpoint_{self._key[:12]}.npz"


def _key(
    frame: Framework,
    path: FloatArray,
    loads: int,
    per_step: int,
    others: Sequence[FloatArray | IntArray],
) -> str:
    """A hash of all that the states of a fold depend on."""
    digest = hashlib.sha256()
    for package in _PACKAGES:
        digest.update(f"{package} {version(package)}\n".encode())
    digest.update(f"{loads} {per_step} {frame.size_mm!r}\n".encode())
    for array in (
        path,
        frame.vertices_coords,
        frame.triangles_vertices,
        frame.bars_vertices,
        frame.bars_length,
        frame.bars_stiffness,
        frame.hinges_vertices,
        frame.hinges_stiffness,
        frame.hinges_target,
        *others,
    ):
        digest.update(f"{array.dtype} {array.shape}\n".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _arrays(reached: Reached, key: str) -> dict[str, Any]:
    """As arrays; the last of the states is the one that the next load begins from."""
    states = [*reached.states, reached.state]
    arrays = {
        "key": np.array(key),
        "number": np.array(reached.number),
        "solved": np.array(reached.solved),
        "rested": np.array(reached.rested),
        "peak": np.array(reached.peak),
        "over": np.array(reached.over),
        **{_CARRIED + name: array for name, array in reached.carried.items()},
        "coords": np.stack([state.coords for state in states]),
        "load": np.array([state.load for state in states]),
        **_ragged("energy", [(s.energy.bars, s.energy.hinges, *s.energy.others) for s in states]),
        "strain": np.array([[s.strain_mean, s.strain_max, s.strain_peak] for s in states]),
        "iterations": np.array([state.iterations for state in states]),
        "settled": np.array([state.settled for state in states]),
        **_ragged("accepted", [state.accepted for state in states]),
    }
    return {**arrays, "digest": np.array(_digest(arrays))}


def _digest(arrays: Mapping[str, Any]) -> str:
    """A hash of arrays with their names, types and shapes."""
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _ragged(name: str, rows: Sequence[Sequence[float]]) -> dict[str, Any]:
    """Rows of several lengths, as arrays; `_rows` gives them back."""
    return {name: np.concatenate(rows, dtype=float), f"{name}_count": np.array([*map(len, rows)])}


def _rows(found: Mapping[str, Any], name: str) -> list[list[float]]:
    ends = found[f"{name}_count"].cumsum()
    return [row.tolist() for row in np.split(found[name], ends[:-1])]


def _read(file: Path, key: str) -> Reached:
    """What a file holds. Raises any error where it is damaged, or of another fold."""
    with file.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
        if str(archive["key"]) != key:
            raise ValueError("it is of another fold")
        found = {name: archive[name] for name in archive.files}
    if str(found.pop("digest")) != _digest(found):
        raise ValueError("it is damaged")
    accepted, energy = _rows(found, "accepted"), _rows(found, "energy")
    states = [
        FoldState(
            float(found["load"][k]),
            coords,
            Energy(energy[k][0], energy[k][1], tuple(energy[k][2:])),
            float(found["strain"][k, 0]),
            float(found["strain"][k, 1]),
            float(found["strain"][k, 2]),
            tuple(accepted[k]),
            int(found["iterations"][k]),
            bool(found["settled"][k]),
        )
        for k, coords in enumerate(found["coords"])
    ]
    return Reached(
        int(found["number"]),
        tuple(states[:-1]),
        states[-1],
        int(found["solved"]),
        bool(found["rested"]),
        float(found["peak"]),
        bool(found["over"]),
        {
            name.removeprefix(_CARRIED): array
            for name, array in found.items()
            if name.startswith(_CARRIED)
        },
    )
