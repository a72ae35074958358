"""Printers, and the materials that bodies are printed of."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, TypeAlias

from pydantic import Field, model_validator

from fab.catalogue import Bedded, Described, load_described

__all__ = ["PrintMaterial", "Printer", "Slicer", "load_print_material", "load_printer"]

# Whose table of parts a 3MF file has, and is laid out for.
Slicer: TypeAlias = Literal["prusa", "bambu"]


class Printer(Bedded):
    """A 3D printer: its size, its resolution, and how far it prints over air."""

    kind: Literal["printer"]
    height_mm: float = Field(gt=0, le=1e5, description="of the tallest print")
    nozzle_mm: float = Field(gt=0, le=10, description="diameter, or the width of a beam")
    layer_mm: float = Field(gt=0, le=10, description="height of the layers")
    least_gap_mm: float = Field(
        gt=0, le=10, description="between two bodies that are printed apart and stay apart"
    )
    first_layer_mm: float = Field(
        default=0.0,
        ge=0,
        le=10,
        description="by how much the first layer spreads on the bed, on each side; 0 where there "
        "is none, as in powder",
    )
    overhang_deg: float = Field(
        ge=0, le=90, description="of sides that need no support: 0 upright, 90 over air"
    )
    bridge_mm: float = Field(ge=0, le=1000, description="longest print over air, from side to side")
    extruders: int = Field(
        ge=1, le=64, description="materials in one print, by extruders or by a changer"
    )
    slicer: Slicer = Field(
        default="prusa",
        description="what 3MF files are laid out for: prusa (PrusaSlicer; Bambu Studio and "
        "OrcaSlicer open them too), or bambu (Bambu Studio and OrcaSlicer, parts as components)",
    )

    @model_validator(mode="after")
    def _has_layers(self) -> Printer:
        if self.layer_mm > self.nozzle_mm:
            raise ValueError(
                f"layer_mm = {self.layer_mm:g} must be at most nozzle_mm = {self.nozzle_mm:g}"
            )
        return self


class PrintMaterial(Described):
    """What bodies are printed of."""

    kind: Literal["print"]
    density_kg_m3: float = Field(gt=0, le=30000, description="when printed full, 1240 for PLA")
    strain_max: float | None = Field(
        default=None,
        gt=0,
        le=10,
        description="stretch of the outside of a web that bends again and again; none where it "
        "breaks",
    )


def load_printer(name_or_path: str | Path) -> Printer:
    """A shipped printer by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault, and for machines that cut.
    """
    return load_described(Printer, "machines", name_or_path)


def load_print_material(name_or_path: str | Path) -> PrintMaterial:
    """A shipped print material by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault, and for sheets.
    """
    return load_described(PrintMaterial, "materials", name_or_path)
