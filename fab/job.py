"""How does a job become files: which design, which size, which styles, which outputs?

The flow, and the only place where its branches join:

    design -> mesh -> development -> crease pattern -+-> perforation -> DXF, SVG
                                                     +-> FOLD, PNG
                                                     +-> panels, webs -> STEP, STL, 3MF
"""

from __future__ import annotations

import dataclasses
import difflib
import hashlib
import json
import math
import os
import shutil
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_type_hints

from pydantic import Field, ValidationError, create_model, model_validator

from fab.crease import CreasePattern, crease_pattern
from fab.development import Development, develop
from fab.errors import Finding, InvalidJob, Severity
from fab.fold_file import fold_bytes
from fab.hinges import HingeSettings, make_webs
from fab.inspection import inspect_accuracy, inspect_solids, measure_pattern
from fab.panels import PanelSettings, make_panels
from fab.perforation import PerforationSettings, perforate
from fab.settings import Settings
from solver import DESIGNS, Design, Growth, InvalidValue, Status

__all__ = ["Format", "Job", "Made", "SheetSettings", "load_job", "make", "parse_job", "write"]

Progress = Callable[[str, int, int], None]


class Format(StrEnum):
    """The kinds of files that a job makes, named by their endings."""

    FOLD = "fold"
    DXF = "dxf"
    SVG = "svg"
    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"


class DesignSettings(Settings):
    """Base of the `design` tables; one for each design of the solver."""

    def design(self) -> Design:
        """The solver's design with these parameters, angles in radians."""
        values = self.model_dump()
        cls = DESIGNS[values.pop("kind")]
        turned = {
            field.name: math.radians(values[_key(field)])
            if _is_angle(field)
            else values[field.name]
            for field in dataclasses.fields(cls)
        }
        design: Design = cls(**turned)  # type: ignore[arg-type]
        return design


def _is_angle(field: dataclasses.Field[Any]) -> bool:
    return bool(field.metadata.get("angle"))


def _key(field: dataclasses.Field[Any]) -> str:
    return f"{field.name}_deg" if _is_angle(field) else field.name


def _design_settings(kind: str, cls: type[Design]) -> type[DesignSettings]:
    """The job table of a design: its own fields, with angles in degrees and named so."""
    types = get_type_hints(cls)
    fields: dict[str, Any] = {"kind": (Literal[kind], ...)}
    for field in dataclasses.fields(cls):
        default = round(math.degrees(field.default), 10) if _is_angle(field) else field.default  # type: ignore[arg-type]
        fields[_key(field)] = (types[field.name], default)
    return create_model(f"{cls.__name__}Settings", __base__=DesignSettings, **fields)


_DESIGN_SETTINGS = {kind: _design_settings(kind, cls) for kind, cls in DESIGNS.items()}


class SheetSettings(Settings):
    """How large the flat sheet is; exactly one of the two."""

    width_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="longer side of the flat sheet"
    )
    scale_mm_per_unit: float | None = Field(
        default=None, gt=0, le=1e8, description="mm per design unit"
    )

    @model_validator(mode="after")
    def _one(self) -> SheetSettings:
        if (self.width_mm is None) == (self.scale_mm_per_unit is None):
            raise ValueError(
                f"width_mm = {self.width_mm} and scale_mm_per_unit = {self.scale_mm_per_unit}, "
                "give exactly one of them"
            )
        return self

    def scale(self, development: Development) -> float:
        """Millimetres per design unit."""
        if self.scale_mm_per_unit is not None:
            return self.scale_mm_per_unit
        assert self.width_mm is not None  # the validator's promise
        return self.width_mm / float(development.vertices_coords.max())


class Job(Settings):
    """Everything that a job file says. Unknown keys, NaN and values out of bounds are refused."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$")
    description: str = ""
    tolerance: float = Field(default=1e-9, gt=0, description="of planarity and so on, relative")
    design: Annotated[Union[tuple(_DESIGN_SETTINGS.values())], Field(discriminator="kind")]  # type: ignore[valid-type] # noqa: UP007
    sheet: SheetSettings
    perforation: PerforationSettings = PerforationSettings()
    panels: PanelSettings = PanelSettings()
    hinges: HingeSettings = HingeSettings()

    @model_validator(mode="after")
    def _web_below_panel(self) -> Job:
        if self.hinges.web_mm >= self.panels.thickness_mm:
            raise ValueError(
                f"hinges.web_mm = {self.hinges.web_mm:g} must be below panels.thickness_mm = "
                f"{self.panels.thickness_mm:g}: a web is thinner than its panels"
            )
        return self


def load_job(path: Path, changes: Sequence[str] = ()) -> Job:
    """Read a job from a TOML file, with `changes` such as "design.strips=4" laid over it.

    Raises `InvalidJob` with every key at fault, its bound and its cure.
    """
    try:
        document = tomllib.loads(_text(path))
    except OSError as error:
        raise InvalidJob(
            f"{path}: cannot be read: {error.strerror}. Check the path, or copy a template with "
            "`quadfold new`."
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InvalidJob(f"{path}: not a TOML file: {error}.") from error
    for change in changes:
        _apply(document, change)
    return parse_job(document, str(path))


def _text(path: Path) -> str:
    if path.exists() and not path.is_file():
        raise InvalidJob(f"{path}: not a file. Give the path of a job file.")
    return path.read_text(encoding="utf-8-sig")


def _apply(document: dict[str, Any], change: str) -> None:
    key, equals, text = change.partition("=")
    parts = [part.strip() for part in key.split(".")]
    if not equals or not all(parts):
        raise InvalidJob(f"--set {change}: must have the form key=value, as in design.strips=4.")
    try:
        parsed = tomllib.loads(f"value = {text}")
        value = parsed["value"] if len(parsed) == 1 else text
    except (tomllib.TOMLDecodeError, RecursionError):
        value = text.strip()
    table = document
    for part in parts[:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise InvalidJob(f"--set {change}: {part} is a value, not a table.")
    table[parts[-1]] = value


def parse_job(document: Mapping[str, Any], source: str = "job") -> Job:
    """Check a job given as nested tables. Raises `InvalidJob`; `source` begins its message."""
    try:
        job = Job.model_validate(document)
    except ValidationError as error:
        lines = [_explain(e, document) for e in error.errors(include_url=False)]
        raise InvalidJob(f"{source}: " + "\n".join(lines)) from error
    return job


def _explain(error: Any, document: Mapping[str, Any]) -> str:
    place = [str(part) for part in error["loc"]]
    if place[:1] == ["design"] and len(place) > 1:
        place.pop(1)  # pydantic names the kind between table and key
    key = ".".join(place) or "job"
    kind, value = error["type"], error.get("input")
    if kind == "extra_forbidden":
        here = _known_keys(place[:-1], document)
        hint = _hint(place, here, document)
        return f"{key} is not a known key.{hint} Known here: {', '.join(sorted(here))}."
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        given = value.get("kind") if isinstance(value, Mapping) else None
        close = difflib.get_close_matches(str(given), DESIGNS, 1, 0.4)
        hint = f" Did you mean {close[0]}?" if close else ""
        return f"design.kind = {given!r} must be one of {', '.join(sorted(DESIGNS))}.{hint}"
    if kind == "missing":
        return f"{key} is missing. Add it; `quadfold new` copies a complete job."
    if key == "name":
        return (
            f"name = {value!r} must be 1 to 100 letters, digits, '_', '-' or '.', and begin with a "
            "letter or digit: it names the files in the output folder."
        )
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return f"{key} = {value!r} must be a table, such as [{key}] with keys below it."
    message = error["msg"].removeprefix("Value error, ")
    if isinstance(value, Mapping | Settings):
        return f"{key}: {message}."
    return f"{key} = {value!r} is refused: {message}."


def _hint(place: Sequence[str], here: Sequence[str], document: Mapping[str, Any]) -> str:
    """The nearest known key, in the same table or else in any other."""
    close = difflib.get_close_matches(place[-1], here, 1, 0.6)
    if close:
        return f" Did you mean {'.'.join([*place[:-1], close[0]])}?"
    elsewhere = {
        key: f"{table}.{key}"
        for table in ("design", "sheet", "perforation", "panels", "hinges")
        for key in _known_keys([table], document)
    }
    close = difflib.get_close_matches(place[-1], elsewhere, 1, 0.8)
    return f" Did you mean {elsewhere[close[0]]}?" if close else ""


def _known_keys(place: Sequence[str], document: Mapping[str, Any]) -> list[str]:
    model: Any = Job
    for part in place:
        if model is Job and part == "design":
            table = document.get("design")
            kind = table.get("kind") if isinstance(table, Mapping) else None
            model = _DESIGN_SETTINGS.get(str(kind), DesignSettings)
        else:
            model = model.model_fields[part].annotation
    return list(model.model_fields)


@dataclass(frozen=True)
class Made:
    """What a job made: files by name, and the report that goes with them."""

    files: Mapping[str, bytes]
    report: Mapping[str, Any]
    findings: tuple[Finding, ...]

    @property
    def within_tolerance(self) -> bool:
        """Whether no finding is an error."""
        return all(finding.severity != Severity.ERROR for finding in self.findings)


def _silent(stage: str, done: int, total: int) -> None:
    del stage, done, total


class _Clock:
    """Seconds per stage, told to `progress` as stages begin."""

    def __init__(self, progress: Progress) -> None:
        self.progress = progress
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[Callable[[int, int], None]]:
        begin = time.perf_counter()
        self.progress(name, 0, 1)
        yield lambda done, total: self.progress(name, done, total)
        self.progress(name, 1, 1)
        self.seconds[name] = round(time.perf_counter() - begin, 4)


def make(job: Job, formats: Sequence[Format] = tuple(Format), progress: Progress = _silent) -> Made:
    """Run a job in memory: grow, develop, and write each of `formats` as bytes.

    progress : called with (stage, steps done, steps in the stage).

    Raises `InvalidJob` where the design's parameters leave nothing to grow, or a sheet without
    area. Growth that stops early, overlaps and the like are findings in the report.
    """
    clock = _Clock(progress)
    findings: list[Finding] = []
    with clock.stage("grow") as step, _named(job):
        growth = job.design.design().grow(step)
    findings += _growth_findings(growth)
    with clock.stage("develop"), _named(job):
        development = develop(growth.mesh)
        pattern = crease_pattern(growth.mesh, development, job.sheet.scale(development))
    findings += _overlap_findings(development)
    with clock.stage("measure"):
        accuracy = measure_pattern(pattern)
        findings += inspect_accuracy(accuracy, job.tolerance)

    files: dict[str, bytes] = {}
    boxes = {
        "flat": _box(pattern.vertices_coords),
        "folded": _box(pattern.folded_coords),
    }
    wanted = set(formats)
    if Format.FOLD in wanted:
        with clock.stage("fold"):
            files[f"{job.name}.fold"] = fold_bytes(pattern, job.name)
    findings += _flat_files(job, pattern, wanted, files, clock)
    solids: dict[str, Any] | None = None
    if wanted & {Format.STEP, Format.STL, Format.THREEMF}:
        solids = _solid_files(job, pattern, wanted, files, findings, boxes, clock)
    if Format.PNG in wanted:
        from fab.picture import png_bytes

        with clock.stage("png"):
            files[f"{job.name}.png"] = png_bytes(pattern, job.name)
    report = {
        "quadfold": _version(),
        "job": job.model_dump(mode="json"),
        "growth": {"status": growth.status, "strips": growth.strips, "advice": growth.advice},
        "counts": {
            "vertices": len(pattern.vertices_coords),
            "faces": pattern.face_count,
            "creases": pattern.counts(),
        },
        **{key: _number(value) for key, value in dataclasses.asdict(accuracy).items()},
        "bounding_box_mm": boxes,
        "solids": solids,
        "outputs": [
            {"file": name, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
            for name, data in files.items()
        ],
        "seconds": clock.seconds,
        "findings": [dataclasses.asdict(finding) for finding in findings],
    }
    files["report.json"] = (json.dumps(report, indent=2, allow_nan=False) + "\n").encode()
    return Made(files, report, tuple(findings))


@contextmanager
def _named(job: Job) -> Iterator[None]:
    """Name the job's own key where the solver refuses a value."""
    try:
        yield
    except InvalidValue as error:
        design = DESIGNS[job.design.kind]
        keys = {field.name: _key(field) for field in dataclasses.fields(design)}
        key = keys.get(error.name.partition("[")[0])
        place = f"design.{key}" if key else "design"
        raise InvalidJob(f"{place}: {error}") from error


def _flat_files(
    job: Job,
    pattern: CreasePattern,
    wanted: set[Format],
    files: dict[str, bytes],
    clock: _Clock,
) -> list[Finding]:
    if not wanted & {Format.DXF, Format.SVG}:
        return []
    with clock.stage("perforate"):
        paths, findings = perforate(pattern, job.perforation)
    if Format.DXF in wanted:
        from fab.dxf import dxf_bytes

        with clock.stage("dxf"):
            files[f"{job.name}.dxf"] = dxf_bytes(paths)
    if Format.SVG in wanted:
        from fab.svg import svg_bytes

        with clock.stage("svg"):
            files[f"{job.name}.svg"] = svg_bytes(paths, job.name)
    return findings


def _solid_files(
    job: Job,
    pattern: CreasePattern,
    wanted: set[Format],
    files: dict[str, bytes],
    findings: list[Finding],
    boxes: dict[str, list[float]],
    clock: _Clock,
) -> dict[str, Any] | None:
    from fab.solid import joined_mesh, step_bytes, stl_bytes, threemf_bytes

    with clock.stage("panels"):
        panels, missing = make_panels(pattern, job.panels)
        webs, open_creases = make_webs(pattern, panels, job.hinges)
    findings += missing + open_creases
    if not len(panels.prisms):
        return None
    with clock.stage("join"):
        joined = joined_mesh(panels, webs)
        boxes["print"] = _box(joined.vertices_coords)
    with clock.stage("inspect"):
        figures, wrong = inspect_solids(pattern, panels, webs, joined, job.panels.gap_mm)
        findings += wrong
    if Format.STEP in wanted:
        with clock.stage("step"):
            letters = pattern.edges_assignment.tolist()
            files[f"{job.name}.step"] = step_bytes(panels, webs, letters, job.name)
    if Format.STL in wanted:
        with clock.stage("stl"):
            files[f"{job.name}.stl"] = stl_bytes(joined)
    if Format.THREEMF in wanted:
        with clock.stage("3mf"):
            files[f"{job.name}.3mf"] = threemf_bytes(joined, job.name)
    return dataclasses.asdict(figures)


def _growth_findings(growth: Growth) -> list[Finding]:
    if growth.status == Status.GROWN:
        return []
    text = f"growth stopped after {growth.strips} strips ({growth.status}). {growth.advice}"
    return [Finding("growth-stopped", Severity.ERROR, text)]


def _overlap_findings(development: Development) -> list[Finding]:
    pairs = development.overlaps
    if not len(pairs):
        return []
    return [
        Finding(
            "development-overlaps",
            Severity.ERROR,
            f"the flat sheet overlaps itself: {len(pairs)} pairs of faces share area, the first "
            f"are {pairs[0][0]} and {pairs[0][1]}. It cannot be cut from one sheet: grow fewer "
            "columns or strips, or change the angles.",
            panels=tuple(sorted({int(face) for face in pairs[:10].ravel()})),
        )
    ]


def _box(coords: Any) -> list[float]:
    return [round(float(side), 6) for side in coords.max(axis=0) - coords.min(axis=0)]


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _version() -> str:
    try:
        return version("quadfold")
    except PackageNotFoundError:
        return "not installed"


def require_folder(folder: Path) -> None:
    """Raise `InvalidJob` unless `folder` is a writable folder, or can become one."""
    existing = next(p for p in [folder, *folder.absolute().parents] if p.exists())
    if not existing.is_dir():
        raise InvalidJob(f"{folder}: {existing} is a file, not a folder. Choose another --out.")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InvalidJob(f"{folder}: no permission to write in {existing}. Choose another --out.")


def write(made: Made, folder: Path) -> None:
    """Write all files of a job into `folder`, made if need be.

    Every file is written in full beside its place before any is renamed, so an interrupted run
    leaves no half file under a final name. Raises `InvalidJob` where the folder cannot take them.
    """
    require_folder(folder)
    for name in made.files:
        if (folder / name).is_dir():
            raise InvalidJob(f"{folder / name} is a folder. Move it, or choose another --out.")
    fresh = [p for p in [folder, *folder.absolute().parents] if not p.exists()]
    beside: Path | None = None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(prefix=".quadfold-", dir=folder))
        for name, data in made.files.items():
            (beside / name).write_bytes(data)
        for name in made.files:
            (beside / name).replace(folder / name)
        fresh = []
    except OSError as error:
        raise InvalidJob(
            f"{folder}: cannot be written: {error.strerror or error}. No half file was left; "
            "free some space, or choose another --out."
        ) from error
    finally:
        if beside is not None:
            shutil.rmtree(beside, ignore_errors=True)
        for made_folder in fresh:
            if made_folder.is_dir() and not any(made_folder.iterdir()):
                made_folder.rmdir()
