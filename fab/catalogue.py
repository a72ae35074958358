"""The catalogue of shipped jobs, materials and machines, and files of one's own in their form."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

from pydantic import Field, field_validator, model_validator

from fab.errors import InvalidJob, did_you_mean
from fab.files import shortened
from fab.preferences import own_files
from fab.settings import Settings, checked, read_toml

__all__ = [
    "CURE",
    "PAPER",
    "Bedded",
    "Described",
    "described",
    "known",
    "known_of",
    "load_described",
    "shipped",
    "shipped_picture",
    "template_groups",
    "with_thickness",
]

CURE = "Begin with a copy of a shipped file."
# What a file is that does not name its kind.
_KINDS = {"materials": "sheet", "machines": "cutter"}
# Shipped jobs by what they are for; all others are of the series in which the paper is made again.
_TO_USE = (
    *("lamp_shade", "vase", "bowl", "dome", "canopy", "helmet", "bonnet", "wall_relief"),
    *("acoustic_panel", "miura_pieces"),
)
_TO_CHANGE = (
    *("miura", "rigid_miura", "cornered_miura", "strip_by_strip", "curved_fold", "wave_fold"),
    *("elliptic_ring", "trefoil_knot", "twisted_squares", "nested_cones", "random_tube"),
    *("cylinder", "barrel", "hourglass", "surface_fit", "crumpled", "brownian_ribbon"),
    "spiral_ribbon",
)
PAPER = "Series of the paper"
# Where the files are in an installed package, and in a checkout.
_PACKAGED = Path(__file__).parent / "templates"
_CHECKED_OUT = Path(__file__).parent.parent / "templates"

Folder = Literal["materials", "machines"]


class Described(Settings):
    """Base of materials and machines: what it is, and which of its values are to be tried first."""

    description: str = Field(min_length=1, description="one line, for lists of names")
    starting_points: list[str] = Field(
        default=[],
        description="keys, such as speeds.cut_mm_s, whose values differ by machine: "
        "a test card finds the right ones",
    )

    @model_validator(mode="after")
    def _names_keys(self) -> Described:
        known = sorted(_keys(self.model_dump()))
        for key in self.starting_points:
            if key not in known:
                hint = did_you_mean(key, known)
                raise ValueError(f"starting_points names {key}, which is no key here.{hint}")
        return self


def _keys(table: Mapping[str, Any], above: str = "") -> Iterator[str]:
    for key, value in table.items():
        yield above + key
        if isinstance(value, Mapping):
            yield from _keys(value, f"{above}{key}.")


class Bedded(Described):
    """Base of machines: the bed on which they work."""

    bed_mm: tuple[float, float] = Field(strict=False, description="width and depth")
    margin_mm: float = Field(ge=0, le=500, description="of the bed, on all sides, kept free")

    @field_validator("bed_mm")
    @classmethod
    def _has_size(cls, sides: tuple[float, float]) -> tuple[float, float]:
        if not all(0 < side <= 1e5 for side in sides):
            raise ValueError("both sides must be above 0 and at most 100000 mm")
        return sides

    @model_validator(mode="after")
    def _has_room(self) -> Bedded:
        if min(self.room_mm) <= 0:
            raise ValueError(
                f"margin_mm = {self.margin_mm:g} leaves nothing of bed_mm = {list(self.bed_mm)}: "
                f"it must be below {min(self.bed_mm) / 2:g}"
            )
        return self

    @property
    def room_mm(self) -> tuple[float, float]:
        """Width and depth of the bed within its margins."""
        width, depth = self.bed_mm
        return width - 2 * self.margin_mm, depth - 2 * self.margin_mm


Model = TypeVar("Model", bound=Described)


def shipped(folder: Literal["jobs", "materials", "machines"]) -> dict[str, Path]:
    """The shipped TOML files of a folder by name, sorted."""
    templates = _PACKAGED if _PACKAGED.is_dir() else _CHECKED_OUT
    place = templates if folder == "jobs" else templates / folder
    return {path.stem: path for path in sorted(place.glob("*.toml"))}


def template_groups() -> dict[str, tuple[str, ...]]:
    """Names of the shipped jobs by what they are for: what is of use first, `PAPER` last."""
    others = sorted(set(shipped("jobs")) - {*_TO_USE, *_TO_CHANGE})
    return {"To use": _TO_USE, "Designs to change": _TO_CHANGE, PAPER: tuple(others)}


def shipped_picture(name: str) -> Path | None:
    """The picture of the folded form of a shipped job, 480 x 360 pixels; None where it has none."""
    templates = _PACKAGED if _PACKAGED.is_dir() else _CHECKED_OUT
    path = templates / "pictures" / f"{name}.png"
    return path if path.is_file() else None


def known(folder: Folder) -> dict[str, Path]:
    """The shipped materials or machines and the user's own, by name; of one name, the user's."""
    return shipped(folder) | own_files(folder)


def described(folder: Folder) -> dict[str, tuple[str, str]]:
    """Kind and description of every material or machine that is known, by name.

    One of the user's that cannot be read is of no kind, and says why instead.
    """
    out = {}
    for name, path in known(folder).items():
        try:
            document = read_toml(path, "")
        except InvalidJob as error:
            out[name] = ("", str(error))
            continue
        text, thickness = str(document.get("description", "")), document.get("thickness_mm")
        if isinstance(thickness, float | int):
            text = with_thickness(text, thickness)
        out[name] = _kind(document, folder), text
    return out


def with_thickness(description: str, thickness_mm: float) -> str:
    """The description of a material, with its thickness where that is not a part of it.

    >>> with_thickness("Card, 300 g/m2", 0.36), with_thickness("Birch plywood, 3 mm", 3.0)
    ('Card, 300 g/m2, 0.36 mm', 'Birch plywood, 3 mm')
    """
    thickness = f"{thickness_mm:g} mm"
    return description if f" {thickness}" in description else f"{description}, {thickness}"


def known_of(kind: Literal["sheet", "print", "cutter", "printer"]) -> dict[str, Path]:
    """TOML files of the sheets, print materials, cutters or printers that are known, by name."""
    folder: Folder = "materials" if kind in ("sheet", "print") else "machines"
    kinds = described(folder)
    return {name: path for name, path in known(folder).items() if kinds[name][0] == kind}


def load_described(model: type[Model], folder: Folder, name_or_path: str | Path) -> Model:
    """A shipped file or one of the user's own by name, or any by its path, as its kind's model.

    Raises `InvalidJob` with every key at fault, and for files of another kind.
    """
    (wanted,) = get_args(model.model_fields["kind"].annotation)
    path = Path(name_or_path)
    if path.suffix != ".toml":
        path = _known_file(str(name_or_path), folder, wanted)
    document = read_toml(path, f"Check the path, or list the names: `quadfold shipped {folder}`.")
    kind = _kind(document, folder)
    if kind != wanted:
        raise InvalidJob(
            f"{path}: kind = {kind!r} must be {wanted!r} here. List the names: "
            f"`quadfold shipped {folder}`."
        )
    return checked(model, document, str(path), CURE)


def _known_file(name: str, folder: Folder, wanted: str) -> Path:
    own = own_files(folder)
    if name in own:
        return own[name]
    kinds = {other: kind for other, (kind, _) in described(folder).items()}
    names = [other for other, kind in kinds.items() if kind == wanted]
    if name not in names:
        what = f"is a {kinds[name]}, not a {wanted}: it " if name in kinds else ""
        raise InvalidJob(
            f"{folder[:-1]} {shortened(name)!r} {what}must be one of {', '.join(names)}, or the "
            f"path of a .toml file.{did_you_mean(name, names, 0.4)}"
        )
    return shipped(folder)[name]


def _kind(document: Mapping[str, Any], folder: Folder) -> str:
    return str(document.get("kind", _KINDS[folder]))
