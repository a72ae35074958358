"""Jobs: a design, the size of its sheet, and all settings of what is made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Union

import numpy as np
from pydantic import Field, PrivateAttr, create_model, model_validator

from fab.errors import InvalidJob
from fab.folding.fold_settings import FoldSettings
from fab.jobs.design_settings import SHIPPED_DESIGNS
from fab.jobs.goal_settings import GoalSettings
from fab.pattern.development import Development
from fab.printing.thick_settings import ThickSettings
from fab.settings import Settings, apply_change, checked, read_toml
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.perforation_settings import PerforationSettings
from solver.vectors import FloatArray

__all__ = ["Job", "SheetSettings", "SheetSize", "job_model", "load_job", "parse_job"]

_CURE = "`quadfold new` copies a complete job."
# A folded sheet has no height if it is less than this share of its longest side.
_FLAT = 1e-9


class SheetSize(Settings):
    """How large the sheet is, flat or folded; exactly one of the four."""

    width_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="longer side of the flat sheet"
    )
    scale_mm_per_unit: float | None = Field(
        default=None, gt=0, le=1e8, description="mm per design unit"
    )
    folded_width_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="longest side, along x, y or z, of the folded sheet"
    )
    folded_height_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="extent of the folded sheet along z"
    )

    @model_validator(mode="after")
    def _one(self) -> SheetSize:
        given = {key: value for key, value in self.model_dump().items() if value is not None}
        if len(given) == 1:
            return self
        keys = ", ".join(type(self).model_fields)
        if not given:
            raise ValueError(f"the sheet has no size, give exactly one of {keys}")
        values = " and ".join(f"{key} = {value}" for key, value in given.items())
        raise ValueError(f"{values} are given, give exactly one of {keys}")

    def scale(self, development: Development, folded_coords: FloatArray) -> float:
        """Millimetres per design unit, for a sheet that is folded to these vertices, (n, 3).

        Raises `InvalidJob` for folded_height_mm where the folded sheet has no extent along z.
        """
        if self.scale_mm_per_unit is not None:
            return self.scale_mm_per_unit
        if self.width_mm is not None:
            return self.width_mm / float(development.vertices_coords.max())
        box = np.ptp(folded_coords, axis=0)
        if self.folded_width_mm is not None:
            return self.folded_width_mm / float(box.max())
        assert self.folded_height_mm is not None  # the validator's promise
        if box[2] <= _FLAT * box.max():
            raise InvalidJob(
                f"sheet.folded_height_mm = {self.folded_height_mm:g}: the folded sheet is flat "
                "along z. Give folded_width_mm or width_mm in its place."
            )
        return self.folded_height_mm / float(box[2])


class SheetSettings(ThickSettings):
    """All that is set of a sheet, whatever its shape: its name, its size, and how it is made."""

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$",
        description="1 to 100 letters from a to z or A to Z, digits, '_', '-' or '.', of which the "
        "first is a letter or digit: it names the files in the output folder",
    )
    description: str = Field(default="", description="one line, for lists of jobs")
    outputs: list[
        Literal[
            "fold",
            "dxf",
            "svg",
            "step",
            "stl",
            "3mf",
            "png",
            "zip",
            "glb",
            "html",
            "pdf",
            "lbrn2",
            "plt",
            "gcode",
            "assembly",
        ]
    ] = Field(
        default=["fold", "dxf", "svg", "step", "stl", "3mf", "png", "html"],
        min_length=1,
        description="what is made where nothing else is asked for",
    )
    tolerance: float = Field(default=1e-9, gt=0, description="of planarity and so on, relative")
    sheet: SheetSize
    goals: GoalSettings = GoalSettings()
    perforation: PerforationSettings = PerforationSettings()
    cutter: CutterSettings | None = Field(
        default=None, description="what sheets are cut from; a drawing without kerf where left out"
    )
    simulation: FoldSettings | None = Field(
        default=None, description="fold the sheet from flat and judge; not where left out"
    )
    _folder: Path = PrivateAttr(default=Path())

    @property
    def wanted(self) -> list[str]:
        """What is made where nothing else is asked for; sheets for a cutter have their guide."""
        usual = "outputs" not in self.model_fields_set and self.cutter is not None
        return [*self.outputs, "assembly"] if usual else list(self.outputs)

    @property
    def folder(self) -> Path:
        """Where files that the settings name are looked for."""
        return self._folder


class Job(SheetSettings):
    """All that a job file holds. Unknown keys, NaN and values out of bounds are refused."""

    design: Annotated[
        Union[tuple(SHIPPED_DESIGNS.values())],  # type: ignore[valid-type] # noqa: UP007
        Field(
            discriminator="kind",
            description="or a class in a Python file beside the job, as in mine.py:HelixFold",
        ),
    ]

    def tables(self) -> dict[str, Any]:
        """The keys that were given, as nested tables of TOML values: a job from them is this one.

        >>> tables = {"name": "m", "design": {"kind": "miura"}, "sheet": {"width_mm": 90.0}}
        >>> parse_job(tables).tables() == tables
        True
        """
        given: dict[str, Any] = self.model_dump(mode="json", exclude_unset=True)
        return given

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled by its tables: its class may be made for its design."""
        return _again, (self.tables(), self.folder)


def _again(tables: dict[str, Any], folder: Path) -> Job:
    """A job out of a pickle, which its design, that may be code, has been part of before."""
    return parse_job(tables, "job", folder, allow_code=True)


def load_job(path: str | Path, changes: Sequence[str] = (), *, allow_code: bool = False) -> Job:
    """Read a job from a TOML file, with `changes` such as "design.strips=4" laid over it.

    allow_code : whether the Python file that design.kind may name is run.

    Raises `InvalidJob` with every key at fault, its bound and its cure; `CodeNotAllowed` for a job
    that names a Python file.
    """
    path = Path(path)
    document = read_toml(path, f"Check the path. {_CURE}")
    for change in changes:
        apply_change(document, change)
    return parse_job(document, str(path), path.parent, allow_code=allow_code)


def parse_job(
    document: Mapping[str, Any],
    source: str = "job",
    folder: Path = Path(),
    *,
    allow_code: bool = False,
) -> Job:
    """Check a job given as nested tables. Raises as `load_job`; `source` begins its message.

    folder : where files that the job names are looked for.

    >>> job = parse_job({"name": "m", "design": {"kind": "miura"}, "sheet": {"width_mm": 90.0}})
    >>> job.design.fold_deg, job.panels.thickness_mm
    (45.0, 1.6)
    """
    job = checked(job_model(document, folder, allow_code=allow_code), document, source, _CURE)
    job._folder = folder
    return job


def job_model(document: Any, folder: Path, *, allow_code: bool = False) -> type[Job]:
    """The model of a job; its own where the design is not a shipped one. Raises as `load_job`."""
    design = document.get("design") if isinstance(document, Mapping) else None
    kind = design.get("kind") if isinstance(design, Mapping) else None
    if not isinstance(kind, str) or kind in SHIPPED_DESIGNS:
        return Job
    from fab.jobs.own_designs import own_design

    table = own_design(kind, folder, allow_code=allow_code)
    return Job if table is None else create_model("Job", __base__=Job, design=(table, ...))
