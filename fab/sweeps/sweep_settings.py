"""Sweeps: a base job, the axes along which it is varied, and what is measured of each variation."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from copy import deepcopy
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr, model_validator

from fab.catalogue import shipped
from fab.errors import InvalidJob, did_you_mean
from fab.jobs.job import Job, job_model, parse_job
from fab.settings import Settings, checked, read_toml, types_of
from fab.sweeps.cluster import ClusterSettings
from fab.sweeps.search_settings import SearchSettings

__all__ = ["Limits", "Measure", "Sweep", "load_sweep", "sweep_of"]

_CURE = 'The page "Many variations" of the documentation shows a complete one.'


class Measure(StrEnum):
    """What is measured of a variation besides its growth, exactness and size."""

    RIGID = "rigid"
    FOLD = "fold"
    THICK = "thick"
    SHEETS = "sheets"


# What fills the columns whose names begin so.
_MEASURES = {
    "rigid": Measure.RIGID,
    "simulation": Measure.FOLD,
    "solids": Measure.THICK,
    "sheets": Measure.SHEETS,
}


class Limits(Settings):
    """What a variation may take; one that takes more is a row that says so."""

    seconds: float = Field(default=600.0, gt=0, le=1e6, description="of a clock, for one variation")
    memory_mb: int | None = Field(
        default=None, ge=256, description="of a worker process; unlimited where left out"
    )


class Sweep(Settings):
    """All that a sweep file holds."""

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$",
        description="1 to 100 letters, digits, '_', '-' or '.'",
    )
    base: str | None = Field(
        default=None, description="a job beside the sweep, or the name of a shipped one"
    )
    axes: dict[str, Any] = Field(description="keys of the job, and their values")
    combine: Literal["grid", "zip", "latin_hypercube"] = Field(
        default="grid",
        description="every combination; the first values of all, then the second, and so on; or "
        "`count` combinations spread evenly along every axis",
    )
    count: int | None = Field(default=None, ge=1, description="of a Latin hypercube")
    seed: int = Field(default=0, ge=0, description="of a Latin hypercube")
    constraints: list[str] = Field(
        default=[], max_length=100, description='such as "design.columns <= 2 * design.rows"'
    )
    measure: list[Annotated[Measure, Field(strict=False)]] = Field(
        default=[],
        description="what is measured besides growth: rigid, fold, thick, sheets",
    )
    outputs: list[Literal["fold", "dxf", "svg", "step", "stl", "3mf", "png", "glb", "html"]] = (
        Field(default=[], description="files that are kept of each variation")
    )
    pictures: bool = Field(
        default=False, description="of the folded forms, for the page and a contact sheet"
    )
    limits: Limits = Limits()
    cluster: ClusterSettings | None = None
    search: SearchSettings | None = None
    _document: dict[str, Any] = PrivateAttr(default_factory=dict)
    _folder: Path = PrivateAttr(default=Path())
    _allow_code: bool = PrivateAttr(default=False)

    @model_validator(mode="after")
    def _counted(self) -> Sweep:
        if (self.combine == "latin_hypercube") != (self.count is not None):
            raise ValueError(
                f"combine = {self.combine!r} and count = {self.count}: a Latin hypercube needs "
                "count, and the others have none"
            )
        if self.search is not None and self.combine != "grid":
            raise ValueError(
                f"combine = {self.combine!r} and a table search: a search proposes the variations "
                "itself. Leave one of them out"
            )
        return self

    @property
    def document(self) -> dict[str, Any]:
        """The tables of the base job, a copy."""
        return deepcopy(self._document)

    @property
    def folder(self) -> Path:
        """Where files that the job names are looked for."""
        return self._folder

    @property
    def measured(self) -> list[str]:
        """What decides the figures of a variation besides its job."""
        return [
            *sorted(self.measure),
            *sorted(self.outputs),
            *(["pictures"] if self.pictures else []),
        ]

    def types_of(self, key: str) -> list[Any]:
        """The types that a key of the job takes; none where the base job has no such key."""
        document = self._document
        model = job_model(document, self._folder, allow_code=self._allow_code)
        return types_of(model, key, document)

    def varied(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The tables of the base job with the values of a variation laid over them."""
        document = self.document
        for key, value in values.items():
            *tables, last = key.split(".")
            table = document
            for name in tables:
                table = table.setdefault(name, {})
                if not isinstance(table, dict):
                    raise InvalidJob(f"axes.{key}: {name} is a value in the job, not a table.")
            table[last] = value
        if Measure.FOLD in self.measure:
            document.setdefault("simulation", {})
        return document

    def require_measured(self, columns: Sequence[str]) -> None:
        """Raise `InvalidJob` where the sweep measures nothing that fills one of the columns."""
        for column in columns:
            measure = _MEASURES.get(column.partition(".")[0])
            if measure is None or measure in self.measure or self.outputs:
                continue
            if not (measure is Measure.FOLD and "simulation" in self._document):
                raise InvalidJob(
                    f"search: {column} is not measured. Add measure = [{measure.value!r}] to the "
                    "sweep."
                )

    def job(self, values: Mapping[str, Any]) -> Job:
        """The job of a variation. Raises `InvalidJob` with every key at fault."""
        return parse_job(self.varied(values), "job", self._folder, allow_code=self._allow_code)


def load_sweep(path: str | Path, *, allow_code: bool = False) -> Sweep:
    """Read a sweep and its base job. Raises `InvalidJob` with every key at fault and its cure.

    allow_code : whether the Python file that the base job may name is run, in every process.
    """
    path = Path(path)
    sweep = checked(Sweep, read_toml(path, f"Check the path. {_CURE}"), str(path), _CURE)
    if sweep.base is None:
        raise InvalidJob(f"{path}: base is missing. Name a job beside it, or a shipped one.")
    place = _base(path, sweep.base)
    tables = read_toml(place, "Check base in the sweep.")
    return _with_base(sweep, tables, place.parent, allow_code=allow_code)


def sweep_of(job: Job, document: Mapping[str, Any]) -> Sweep:
    """The sweep of a job: its axes and other keys, as in a sweep file but for its base.

    Raises `InvalidJob` with every key at fault.
    """
    sweep = checked(Sweep, {"name": job.name, **document}, "sweep", _CURE)
    return _with_base(sweep, job.tables(), job.folder, allow_code=True)


def _with_base(sweep: Sweep, tables: dict[str, Any], folder: Path, *, allow_code: bool) -> Sweep:
    sweep._document, sweep._folder = tables, folder.absolute()
    sweep._allow_code = allow_code
    return sweep


def _base(path: Path, name: str) -> Path:
    """The file of the base job: beside the sweep, or shipped."""
    beside, jobs = path.parent / name, shipped("jobs")
    if beside.suffix or os.path.exists(beside):  # noqa: PTH110 - false for names no file can have
        return beside
    if name not in jobs:
        raise InvalidJob(
            f"{path}: base = {name!r} is neither a file beside it nor a shipped job."
            f"{did_you_mean(name, jobs)} List these: `quadfold templates`."
        )
    return jobs[name]
