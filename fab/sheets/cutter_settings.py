"""Settings of sheets: the table `[cutter]` of a job, and of the command that cuts any pattern."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import Field

from fab.drawings.drawing_files import USUAL, SheetFormat
from fab.settings import Settings, apply_change, checked
from fab.sheets.cut_wishes import CutWishes
from fab.sheets.materials import Degrees, Machine, Material, load_machine, load_material
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.registration import Registration
from fab.sheets.sheet_request import SheetRequest

__all__ = ["CutterSettings", "CutterTables", "cutter_tables"]


class CutterSettings(CutWishes):
    """What sheets are cut from, on which machine, and what is wished of them."""

    material: str = Field(description="a shipped sheet material, or a .toml file")
    machine: str = Field(description="a shipped cutter, or a .toml file")
    copies: int = Field(default=1, ge=1, le=10_000, description="how many of the whole pattern")
    sheets: int | None = Field(
        default=None, ge=1, description="how many are at hand: a need for more is reported"
    )
    two_sided: bool = Field(
        default=False, description="creases are scored on the side on which they open"
    )
    margin_mm: float | None = Field(
        default=None, ge=0, le=500, description="of the bed, kept free; that of the machine"
    )
    piece_gap_mm: float | None = Field(
        default=None,
        gt=0,
        le=500,
        description="kept free between two pieces; 2 mm, or 4 kerfs, where left out",
    )
    priority: list[str] = Field(
        default=[],
        description="pieces that lie on the first sheets, by their names, such as A, or those of "
        "their patterns",
    )
    shared_cuts: bool = Field(
        default=False,
        description="pieces lie side to side along straight sides of equal length, which are cut "
        "once",
    )
    grain_deg: Degrees | None = Field(
        default=None,
        description="direction in the pattern that is to lie along the grain, 0 for x; pieces are "
        "turned freely where left out, unless the material forbids it",
    )

    def request(
        self,
        formats: Sequence[SheetFormat] = USUAL,
        *,
        perforation: PerforationSettings | None = None,
        page: bool = True,
        guide: bool = False,
        folder: Path = Path(),
    ) -> SheetRequest:
        """The sheets that are asked for.

        formats : of the drawings. perforation : its keys that were given prevail over those of the
        material. page, guide : whether a result page is made, and an assembly guide. folder : where
        files that the settings name are looked for.

        Raises `InvalidJob` for unknown materials and machines and for a margin that leaves nothing
        of the bed, `InvalidState` as `SheetRequest`.
        """

        def place(name: str) -> str | Path:
            return folder / name if name.endswith(".toml") else name

        wishes = CutWishes.model_fields
        return SheetRequest(
            _with_creases(load_material(place(self.material)), perforation),
            _with_margin(load_machine(place(self.machine)), self.margin_mm),
            self.copies,
            Registration() if self.two_sided else None,
            formats,
            page,
            stock_sheets=self.sheets,
            grain_deg=self.grain_deg,
            piece_gap_mm=self.piece_gap_mm,
            wishes=CutWishes.model_validate({key: getattr(self, key) for key in wishes}),
            names=(_stem(self.material), _stem(self.machine)),
            guide=guide,
            priority=tuple(self.priority),
            shared_cuts=self.shared_cuts,
        )


def _with_margin(machine: Machine, margin_mm: float | None) -> Machine:
    """The machine with another margin. Raises `InvalidJob` for one that leaves nothing."""
    if margin_mm is None:
        return machine
    document = {**machine.model_dump(), "margin_mm": margin_mm}
    return checked(Machine, document, "[cutter]", "Lower margin_mm.")


def _stem(name: str) -> str:
    """What a material or machine is called, whether shipped or in a file."""
    return Path(name).name.removesuffix(".toml")


def _with_creases(material: Material, perforation: PerforationSettings | None) -> Material:
    """The material with the keys of creases that were given."""
    if perforation is None or not perforation.model_fields_set:
        return material
    given = {key: getattr(perforation, key) for key in sorted(perforation.model_fields_set)}
    creases = material.perforation.model_copy(update=given)
    return material.model_copy(update={"perforation": creases})


class CutterTables(Settings):
    """The tables of a job that say how its sheets are cut."""

    cutter: CutterSettings
    perforation: PerforationSettings | None = None


def cutter_tables(
    changes: Sequence[str] = (), given: Mapping[str, Any] | None = None
) -> CutterTables:
    """The tables with changes such as "cutter.sheets=2".

    given : keys of `[cutter]` that prevail over the changes, such as {"material": "card_300gsm"}.

    Raises `InvalidJob` with every key at fault.

    >>> stock = {"material": "card_300gsm", "machine": "knife_a4"}
    >>> cutter_tables(["cutter.copies=3"], stock).cutter.copies
    3
    """
    document: dict[str, Any] = {}
    for change in changes:
        apply_change(document, change)
    table = document.get("cutter", {})
    if isinstance(table, Mapping):
        document["cutter"] = {**table, **(given or {})}
    return checked(CutterTables, document, "--set", "Give its table and key, with its unit.")
