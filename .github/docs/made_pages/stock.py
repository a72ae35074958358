"""Pages of the shipped materials and machines, from their files."""

from __future__ import annotations

from typing import Any, Literal

from fab.catalogue import described, shipped
from fab.settings import read_toml
from made_pages.markdown import anchor, cell, table

__all__ = ["stock_page"]

_ABOUT = {
    "materials": (
        "Materials",
        "Sheets are what is cut (`--material`, `[cutter]`), print materials what panels are "
        "printed of "
        "(`[printer]`). [Their keys](material_keys.md) are the same for your own.",
    ),
    "machines": (
        "Machines and printers",
        "Cutters are lasers and knife plotters (`--machine`, `[cutter]`), printers are for "
        "thick panels "
        "(`--printer`, `[printer]`). [Their keys](machine_keys.md) are the same for your own.",
    ),
}
_TITLES = {
    "sheet": "Sheets to cut",
    "print": "Print materials",
    "cutter": "Cutters and plotters",
    "printer": "3D printers",
}


def stock_page(folder: Literal["materials", "machines"]) -> str:
    """What is shipped, and all values of each file."""
    title, about = _ABOUT[folder]
    files = shipped(folder)
    known = described(folder)
    out = [
        f"# {title}\n",
        about + f" `quadfold shipped {folder}` lists the names. Values that differ from machine to "
        "machine are starting points: [a test card](../guide/laser_sheets.md) finds the right "
        "ones.\n",
    ]
    for kind, heading in _TITLES.items():
        names = [name for name in files if known[name][0] == kind]
        if not names:
            continue
        out.append(f"## {heading}\n")
        for name in names:
            document = read_toml(files[name], "")
            started = set(document.get("starting_points", []))
            rows = [
                [f"`{key}`", f"`{_shown(value)}`", "to be tried" if key in started else ""]
                for key, value in _leaves(document)
                if key not in ("kind", "description", "starting_points")
            ]
            out += [
                anchor(f"stock-{name}") + f"### {name}\n",
                cell(known[name][1]) + ".\n",
                table(["key", "value", ""], rows),
            ]
    return "\n".join(out)


def _leaves(tables: dict[str, Any], above: str = "") -> list[tuple[str, Any]]:
    out: list[tuple[str, Any]] = []
    for key, value in tables.items():
        inner = isinstance(value, dict) and not above
        out += _leaves(value, f"{key}.") if inner else [(above + key, value)]
    return out


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} = {_shown(inner)}" for key, inner in value.items())
    if isinstance(value, bool):
        return str(value).lower()
    return str(value).replace("|", "\\|")
