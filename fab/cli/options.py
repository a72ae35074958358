"""Options and arguments that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, TypeVar

import click

from fab.outputs import Kind, formats_among

__all__ = [
    "ALLOW_CODE",
    "DRY_RUN",
    "FILE",
    "MACHINE",
    "MATERIAL",
    "ONLY_SHEETS",
    "OUT",
    "SCALE",
    "STRICT",
    "SUGGEST",
    "WIDTH",
    "changes_of",
    "dry_run",
    "formats_of",
    "only",
]

Command = TypeVar("Command", bound=Callable[..., Any])


class Option(Protocol):
    """What adds an option to a command."""

    def __call__(self, command: Command, /) -> Command: ...


_NAMED = "A shipped one, or a .toml file of your own."


def only(text: str) -> Option:
    """The option --only, with its help."""
    return click.option("--only", default=None, metavar="FORMATS", help=text)


def dry_run(text: str) -> Option:
    """The option --dry-run, with its help."""
    return click.option("--dry-run", is_flag=True, help=text)


def changes_of(text: str) -> Option:
    """The option --set, with its help."""
    return click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=text)


FILE = click.argument("file", type=click.Path(path_type=Path))
OUT = click.option(
    "--out",
    default=".",
    type=click.Path(path_type=Path),
    help="Folder to write into (default: here).",
)
MATERIAL = click.option("--material", required=True, metavar="NAME", help=_NAMED)
MACHINE = click.option("--machine", required=True, metavar="NAME", help=_NAMED)
ONLY_SHEETS = only("Such as dxf,pdf (default: dxf,svg,pdf).")
WIDTH = click.option("--width-mm", default=None, type=float, help="Longer side of the flat sheet.")
SCALE = click.option("--scale", default=None, type=float, help="Times the size in the file.")
DRY_RUN = dry_run("Make and check everything, write nothing.")
SUGGEST = click.option(
    "--suggest",
    is_flag=True,
    help="Say at which thicknesses and sizes every panel exists; make nothing.",
)
STRICT = click.option(
    "--strict", is_flag=True, help="Refuse files that need a repair, or an assumption."
)
ALLOW_CODE = click.option(
    "--allow-code",
    is_flag=True,
    help="Run the Python file that a job names as its design (asked at a terminal).",
)


def formats_of(names: str | None, kinds: type[Kind]) -> list[Kind] | None:
    """The kinds of files that --only names; None where it is left out. Raises `InvalidJob`."""
    if names is None:
        return None
    return formats_among([name.strip().lower() for name in names.split(",")], kinds, "--only")
