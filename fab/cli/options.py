"""Options that several commands share, and what they do with files."""

from __future__ import annotations

import difflib
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from fab.cli.console import say
from fab.errors import InvalidJob

if TYPE_CHECKING:
    from fab.outputs import Made

__all__ = [
    "MACHINE",
    "MATERIAL",
    "ONLY_SHEETS",
    "OUT",
    "SCALE",
    "STRICT",
    "SUGGEST",
    "WIDTH",
    "formats_of",
    "write_made",
]


OUT = click.option(
    "--out",
    default=".",
    type=click.Path(path_type=Path),
    help="Folder to write into (default: here).",
)
MATERIAL = click.option(
    "--material", required=True, metavar="NAME", help="A shipped one, or a .toml file of your own."
)
MACHINE = click.option(
    "--machine", required=True, metavar="NAME", help="A shipped one, or a .toml file of your own."
)


ONLY_SHEETS = click.option(
    "--only", default=None, metavar="FORMATS", help="Such as dxf,pdf (default: dxf,svg,pdf)."
)
WIDTH = click.option("--width-mm", default=None, type=float, help="Longer side of the flat sheet.")
SCALE = click.option("--scale", default=None, type=float, help="Times the size in the file.")
SUGGEST = click.option(
    "--suggest",
    is_flag=True,
    help="Say at which thicknesses and sizes every panel stands; make nothing.",
)
STRICT = click.option(
    "--strict", is_flag=True, help="Refuse files that need a repair, or an assumption."
)


Kind = TypeVar("Kind", bound=StrEnum)


def formats_of(only: str | None, kinds: type[Kind]) -> list[Kind] | None:
    """The kinds of files that --only names; None where it is left out. Raises `InvalidJob`."""
    if only is None:
        return None
    known = [str(kind) for kind in kinds]
    chosen = []
    for word in only.split(","):
        name = word.strip().lower()
        if name not in known:
            close = difflib.get_close_matches(name, known, 1, 0.6)
            hint = f" Did you mean {close[0]}?" if close else ""
            raise InvalidJob(f"--only {name!r} must be among {','.join(known)}.{hint}")
        chosen.append(kinds(name))
    return chosen


def write_made(made: Made, folder: Path, dry_run: bool = False) -> None:
    """Write all files, unless it is a dry run, and list them."""
    from fab.outputs import write

    if not dry_run:
        write(made, folder)
    verb = "would write" if dry_run else "wrote"
    for name, data in made.files.items():
        say(f"{verb} {folder / name}  {len(data)} bytes")
