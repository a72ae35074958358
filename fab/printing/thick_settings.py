"""Settings of a thick sheet: the tables of its panels, hinges, printer and plates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator

from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings, require_fitting_hinges
from fab.printing.plate_settings import PlateSettings
from fab.printing.printers import (
    Printer,
    PrintMaterial,
    Slicer,
    load_print_material,
    load_printer,
)
from fab.settings import Settings, apply_change, checked

# How far webs of another material reach into panels, in nozzles, and a nozzle that is unknown.
_ANCHOR_NOZZLES, _NOZZLE_MM = 5, 0.4

__all__ = ["UNKNOWN", "PrintWith", "PrinterSettings", "ThickSettings", "thick_settings"]


class PrinterSettings(Settings):
    """Which printer prints the thick sheet, and of what: names, or paths of TOML files."""

    machine: str | None = Field(default=None, description="a shipped printer, or a .toml file")
    material: str | None = Field(default=None, description="of the print, named in the same way")
    panel_material: str | None = Field(
        default=None, description="of the panels alone; material where left out"
    )
    hinge_material: str | None = Field(
        default=None,
        description="of webs and films, printed by the second extruder; material where left out",
    )
    slicer: Slicer | None = Field(
        default=None,
        description="that 3MF files are laid out for: prusa or bambu; that of the printer where "
        "left out",
    )


@dataclass(frozen=True)
class PrintWith:
    """The printer, its materials and its slicer, where they are known.

    panels, hinges : what rigid bodies and flexible ones are printed of.
    """

    printer: Printer | None = None
    panels: PrintMaterial | None = None
    hinges: PrintMaterial | None = None
    slicer: Slicer = "prusa"

    @property
    def material_count(self) -> int:
        """How many different materials are known to be printed."""
        return len({each.model_dump_json() for each in (self.panels, self.hinges) if each})


UNKNOWN = PrintWith()


class ThickSettings(Settings):
    """The tables of a thick sheet, in a job and on the command line."""

    panels: PanelSettings = PanelSettings()
    hinges: HingeSettings = HingeSettings()
    printer: PrinterSettings = PrinterSettings()
    plates: PlateSettings = PlateSettings()

    @model_validator(mode="after")
    def _hinges_fit_panels(self) -> ThickSettings:
        require_fitting_hinges(self.panels, self.hinges)
        return self

    def printed(self, print_with: PrintWith) -> Self:
        """The same, with what they leave to the printer and its materials.

        These are the strain of webs, their anchors in panels of another material, the play of
        knuckles, the spread of the first layer, and the margin of plates.
        """
        printer, material = print_with.printer, print_with.hinges
        panels, plates, given = self.panels, self.plates, self.hinges.model_fields_set
        fitting: dict[str, float] = {}
        if material is not None and material.strain_max is not None:
            fitting["strain_max"] = material.strain_max
        if print_with.material_count > 1:
            nozzle = _NOZZLE_MM if printer is None else printer.nozzle_mm
            fitting["anchor_mm"] = round(_ANCHOR_NOZZLES * nozzle, 6)
        if printer is not None:
            fitting["play_mm"] = printer.least_gap_mm
            if panels.first_layer_mm is None:
                spread = min(printer.first_layer_mm, panels.thickness_mm / 4)
                panels = panels.model_copy(update={"first_layer_mm": spread})
            if plates.margin_mm is None:
                plates = plates.model_copy(update={"margin_mm": printer.margin_mm})
        left = {key: value for key, value in fitting.items() if key not in given}
        hinges = self.hinges.model_copy(update=left)
        return self.model_copy(update={"panels": panels, "hinges": hinges, "plates": plates})

    def print_with(self, folder: Path = Path()) -> PrintWith:
        """The printer and the materials that are named. Raises `InvalidJob` for unknown ones.

        folder : where their files are looked for.
        """

        def place(name: str) -> str | Path:
            return folder / name if name.endswith(".toml") else name

        def material(name: str | None) -> PrintMaterial | None:
            chosen = self.printer.material if name is None else name
            return None if chosen is None else load_print_material(place(chosen))

        machine = self.printer.machine
        printer = None if machine is None else load_printer(place(machine))
        return PrintWith(
            printer,
            material(self.printer.panel_material),
            material(self.printer.hinge_material),
            self.printer.slicer or ("prusa" if printer is None else printer.slicer),
        )


def thick_settings(
    changes: Sequence[str] = (), machine: str | None = None, material: str | None = None
) -> ThickSettings:
    """The default settings with changes such as "panels.thickness_mm=1.2".

    machine, material : names of the printer and its material; they prevail over the changes.
    Raises `InvalidJob` with every key at fault.
    """
    document: dict[str, Any] = {}
    for change in changes:
        apply_change(document, change)
    given = {"machine": machine, "material": material}
    printer = {key: name for key, name in given.items() if name is not None}
    if printer:
        document["printer"] = {**document.get("printer", {}), **printer}
    return checked(ThickSettings, document, "--set", "Give its table and key, with its unit.")
