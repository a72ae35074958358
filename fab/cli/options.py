"""Options and arguments that several commands share."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, TypeVar

import click

from fab.cli.completion import StockName
from fab.cli.console import answers
from fab.cli.delivery import Told
from fab.errors import InvalidJob
from fab.outputs import Kind, formats_among

__all__ = [
    "ALLOW_CODE",
    "DRY_RUN",
    "FILE",
    "FILES",
    "MACHINE",
    "MATERIAL",
    "OUT",
    "SUGGEST",
    "Size",
    "changes_of",
    "dry_run",
    "formats_of",
    "only",
    "reading_options",
    "size_options",
    "told_options",
]

Command = TypeVar("Command", bound=Callable[..., Any])


class Option(Protocol):
    """What adds an option to a command."""

    def __call__(self, command: Command, /) -> Command: ...


_INCH_MM = 25.4
_NAMED = "A shipped one, or a .toml file of your own."


def only(text: str) -> Option:
    """The option --only, with its help."""
    return click.option("--only", multiple=True, metavar="FORMATS", help=text)


def dry_run(text: str) -> Option:
    """The option --dry-run, with its help."""
    return click.option("--dry-run", is_flag=True, help=text)


def changes_of(text: str) -> Option:
    """The option --set, with its help."""
    return click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=text)


_TOLD = (
    click.option("--json", "as_json", is_flag=True, help="Print the report, one JSON document."),
    click.option("--quiet", is_flag=True, help="Print nothing but errors."),
    click.option("--verbose", is_flag=True, help="Print every finding, and how long stages took."),
)


def told_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """A command with --json, --quiet and --verbose, which it takes as one `Told`, `told`."""

    @functools.wraps(command)
    def with_told(*arguments: Any, as_json: bool, quiet: bool, verbose: bool, **others: Any) -> Any:
        asked = {"--json": as_json, "--quiet": quiet, "--verbose": verbose}
        given = [option for option, is_given in asked.items() if is_given]
        if len(given) > 1:
            raise click.UsageError(f"{' and '.join(given)} exclude each other.")
        told = {"--json": Told.JSON, "--quiet": Told.ERRORS, "--verbose": Told.ALL}
        return command(*arguments, told=told[given[0]] if given else Told.LINES, **others)

    return _with_all(with_told, _TOLD)


FILE = click.argument("file", type=click.Path(path_type=Path))
FILES = click.argument(
    "files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILES..."
)
OUT = click.option(
    "--out",
    default=".",
    type=click.Path(path_type=Path),
    help="Folder to write into (default: here).",
)
_OF_SETTINGS = " Default: that of `quadfold settings`."
MATERIAL = click.option(
    "--material",
    type=StockName("sheet"),
    default=None,
    metavar="NAME",
    help=_NAMED + _OF_SETTINGS,
)
MACHINE = click.option(
    "--machine",
    type=StockName("cutter"),
    default=None,
    metavar="NAME",
    help=_NAMED + _OF_SETTINGS,
)
DRY_RUN = dry_run("Make and check everything, write nothing.")
SUGGEST = click.option(
    "--suggest",
    is_flag=True,
    help="Say at which thicknesses and sizes every panel exists; make nothing.",
)
ALLOW_CODE = click.option(
    "--allow-code",
    is_flag=True,
    help="Run the Python file that a job names as its design (asked at a terminal).",
)


# How files of crease patterns are understood: the same for all commands that read them.
_READING = (
    click.option("--strict", is_flag=True, help="Refuse what needs a repair or an assumption."),
    click.option(
        "--mm-per-unit",
        type=float,
        metavar="MM",
        help="Size of a unit in files that name none (default: 1, or 1/96 inch for SVG).",
    ),
    click.option(
        "--dpi", type=float, metavar="N", help="The same as units per inch: 96 or 72 for SVG."
    ),
    click.option(
        "--merge-mm",
        type=float,
        metavar="MM",
        help="Join ends of lines that are nearer (default: 0.1 % of the drawing, or less).",
    ),
    click.option(
        "--colours",
        metavar="MAP",
        help='What colours and layers mean: "#ff00aa=mountain,layer name=cut".',
    ),
    click.option(
        "--border",
        type=click.Choice(["drawn", "hull"]),
        default="drawn",
        show_default=True,
        help="hull: the convex hull of all lines, where no border is drawn.",
    ),
    click.option(
        "--inner-border",
        type=click.Choice(["refuse", "cut"]),
        default="refuse",
        show_default=True,
        help="What borders with the sheet on both sides are.",
    ),
    click.option(
        "--fold-deg",
        type=float,
        metavar="DEG",
        help="Fold angle of mountains and valleys that have none (default: 180).",
    ),
    click.option(
        "--rigid",
        is_flag=True,
        help="Find these fold angles by folding rigidly, up to --fold-deg.",
    ),
    click.option(
        "--assign",
        is_flag=True,
        help="Make unassigned creases mountains or valleys where there is one choice alone.",
    ),
    click.option(
        "--frame", type=int, metavar="N", help="Which crease pattern of several in a FOLD file."
    ),
)


def reading_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """A command with the options of reading, which it takes as one `ReadOptions`, `options`."""

    @functools.wraps(command)
    def with_options(
        *arguments: Any,
        strict: bool,
        mm_per_unit: float | None,
        dpi: float | None,
        merge_mm: float | None,
        colours: str | None,
        border: Literal["drawn", "hull"],
        inner_border: Literal["refuse", "cut"],
        fold_deg: float | None,
        rigid: bool,
        assign: bool,
        frame: int | None,
        **others: Any,
    ) -> Any:
        with answers():
            from fab.formats.read_options import ReadOptions

            options = ReadOptions(
                strict=strict,
                mm_per_unit=_unit_mm(mm_per_unit, dpi),
                merge_mm=merge_mm,
                colours=_letters_of(colours),
                border=border,
                inner_border=inner_border,
                fold_deg=fold_deg,
                assign=assign,
                rigid=rigid,
                frame=frame,
            )
        return command(*arguments, options=options, **others)

    return _with_all(with_options, _READING)


def size_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """A command with the options of size, which it takes as one `Size`, `size`."""

    @functools.wraps(command)
    def with_size(
        *arguments: Any, width_mm: float | None, scale: float | None, **others: Any
    ) -> Any:
        return command(*arguments, size=Size(width_mm, scale), **others)

    return _with_all(with_size, _SIZE)


@dataclass(frozen=True)
class Size:
    """The size that is asked for, if any: the longer side of the sheet, or a factor."""

    width_mm: float | None = None
    factor: float | None = None


_SIZE = (
    click.option("--width-mm", default=None, type=float, help="Longer side of the flat sheet."),
    click.option("--scale", default=None, type=float, help="Times the size in the file."),
)


def _with_all(command: Callable[..., Any], options: Sequence[Option]) -> Callable[..., Any]:
    for option in reversed(options):
        command = option(command)
    return command


def _unit_mm(mm_per_unit: float | None, dpi: float | None) -> float | None:
    """Millimetres per unit by one of two options."""
    if dpi is None:
        return mm_per_unit
    from solver.errors import require_positive

    if mm_per_unit is not None:
        raise InvalidJob(f"--mm-per-unit {mm_per_unit:g} and --dpi {dpi:g}: give one of them.")
    require_positive("dpi", dpi)
    return _INCH_MM / dpi


def _letters_of(colours: str | None) -> dict[str, str]:
    if colours is None:
        return {}
    from fab.formats.drawn.letters import parse_colours

    return parse_colours(colours)


def formats_of(names: Sequence[str], kinds: type[Kind]) -> list[Kind] | None:
    """The kinds of files that --only names, each once; None where it is left out.

    names : of several options, with commas in each. Raises `InvalidJob`.
    """
    if not names:
        return None
    listed = [name.strip().lower() for option in names for name in option.split(",")]
    return formats_among(list(dict.fromkeys(listed)), kinds, "--only")
