"""Sheet materials of which it is known what strain they bear."""

from __future__ import annotations

from pathlib import Path

from fab.catalogue import shipped
from fab.folding.verdict_words import Bearer
from fab.settings import read_toml
from fab.sheets.materials import load_material

__all__ = ["bearing_sheets"]


def bearing_sheets(material: str | None = None) -> list[Bearer]:
    """One material by its name or path, or all shipped sheets, that have a strain_max; thin first.

    Raises `InvalidJob` where the material is not known.
    """
    if material is not None:
        wanted: dict[str, str | Path] = {Path(material).name.removesuffix(".toml"): material}
    else:
        every = shipped("materials").items()
        wanted = {name: path for name, path in every if "kind" not in read_toml(path, "")}
    sheets = {name: load_material(source) for name, source in wanted.items()}
    found = [
        Bearer(name, sheet.thickness_mm, sheet.strain_max)
        for name, sheet in sheets.items()
        if sheet.strain_max is not None
    ]
    return sorted(found, key=lambda each: each.thickness_mm)
