"""Commands about sheets for laser cutters and plotters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from fab.cli.console import answers, say
from fab.cli.delivery import FilesOf, Told, deliver, write_made
from fab.cli.inputs import sheet_of
from fab.cli.options import (
    DRY_RUN,
    FILE,
    MACHINE,
    MATERIAL,
    ONLY_SHEETS,
    OUT,
    Size,
    changes_of,
    formats_of,
    only,
    reading_options,
    size_options,
    told_options,
)
from fab.cli.preferences import required
from fab.errors import InvalidJob, counted
from fab.files import shortened

if TYPE_CHECKING:
    from fab.formats.read_options import ReadOptions
    from fab.outputs import Made
    from fab.progress import Progress

__all__ = ["coupon", "fabricate", "sheet_lines", "shipped"]


@click.command()
@FILE
@MATERIAL
@MACHINE
@OUT
@size_options
@reading_options
@click.option("--copies", default=None, type=int, help="How many of the model (default: 1).")
@click.option(
    "--two-sided",
    is_flag=True,
    help="Score mountains from the front and valleys from the back: two drawings for each sheet.",
)
@changes_of("Such as cutter.sheets=2, as in a job; may be repeated.")
@only("Such as dxf,lbrn2 (default: dxf,svg,pdf,html,assembly).")
@DRY_RUN
@told_options
def fabricate(
    file: Path,
    material: str | None,
    machine: str | None,
    out: Path,
    size: Size,
    options: ReadOptions,
    copies: int | None,
    two_sided: bool,
    changes: tuple[str, ...],
    only: tuple[str, ...],
    dry_run: bool,
    told: Told,
) -> None:
    """Make the sheets that a laser cutter or plotter cuts from a crease pattern.

    FILE is FOLD, SVG, DXF, CP, OPX, ORI, ORH or OBJ.
    """
    with answers() as interrupts:
        from fab.drawings.drawing_files import USUAL, SheetFormat
        from fab.jobs.file_names import SHEETS
        from fab.jobs.sheet_files import FabricatedFormat, fabricate
        from fab.outputs import plain_title
        from fab.sheets.cutter_settings import cutter_tables

        tables = cutter_tables(changes, _given(changes, material, machine, copies, two_sided))
        other = (FabricatedFormat.HTML, FabricatedFormat.ASSEMBLY)
        usual = [*map(FabricatedFormat, USUAL), *other]
        chosen = formats_of(only, FabricatedFormat) or usual
        request = tables.cutter.request(
            [SheetFormat(kind) for kind in chosen if kind not in other],
            perforation=tables.perforation,
            page=FabricatedFormat.HTML in chosen,
            guide=FabricatedFormat.ASSEMBLY in chosen,
        )

        def make(progress: Progress) -> Made:
            pattern, name, findings = sheet_of(file, options, size)
            return fabricate(
                pattern,
                name,
                request,
                findings=findings,
                progress=progress,
            )

        files = FilesOf(plain_title(file.stem), [SHEETS])
        deliver(interrupts, make, out, files, dry_run=dry_run, summary=sheet_lines, told=told)


def _given(
    changes: Sequence[str],
    material: str | None,
    machine: str | None,
    copies: int | None,
    two_sided: bool,
) -> dict[str, Any]:
    """Keys of the table of sheets that options give, or else changes, or else the settings."""
    keys: dict[str, Any] = {"copies": copies, "two_sided": two_sided or None}
    stock: tuple[tuple[Literal["material", "machine"], str | None], ...] = (
        ("material", material),
        ("machine", machine),
    )
    for key, name in stock:
        changed = any(change.replace(" ", "").startswith(f"cutter.{key}=") for change in changes)
        keys[key] = name if changed else required(key, name)
    return {key: value for key, value in keys.items() if value is not None}


def sheet_lines(report: Mapping[str, Any]) -> Iterator[str]:
    """How many pieces, seams and sheets a report has, how long they take, how to turn them."""
    sheets = report["sheets"]
    width, depth = report["machine"]["bed_mm"]
    yield (
        f"{counted(len(report['pieces']), 'piece')}, {counted(len(report['glue_up']), 'seam')}, "
        f"{counted(len(sheets), 'sheet')} of {width:g} x {depth:g} mm, "
        f"about {sum(sheet['minutes'] for sheet in sheets):.1f} minutes"
    )
    if "turn" in sheets[0]:  # two-sided
        others = " Treat the other sheets alike." if len(sheets) > 1 else ""
        yield sheets[0]["turn"] + others


@click.command()
@MATERIAL
@MACHINE
@OUT
@ONLY_SHEETS
def coupon(material: str | None, machine: str | None, out: Path, only: tuple[str, ...]) -> None:
    """Make a test card that finds a machine's kerf and the best dashes for a material."""
    with answers():
        from fab.drawings.drawing_files import USUAL, SheetFormat, drawing_files
        from fab.outputs import Made, plain_title, require_folder
        from fab.sheets.coupon import coupon
        from fab.sheets.cutting_order import tour
        from fab.sheets.materials import load_machine, load_material
        from fab.sheets.sheet_request import SheetRequest

        names = required("material", material), required("machine", machine)
        stock, cutter = load_material(names[0]), load_machine(names[1])
        formats = formats_of(only, SheetFormat) or USUAL
        require_folder(out)
        words = [Path(word).name.removesuffix(".toml") for word in names]
        name = plain_title("_".join(["coupon", *words]))
        paths = tour(coupon(cutter, stock))
        request = SheetRequest(stock, cutter, formats=formats)
        files = drawing_files(paths, name, formats, request.drawing_style)
        write_made(Made(files, {}, ()), out)


@click.command()
@click.argument("kind", type=click.Choice(["materials", "machines"]))
@click.argument("word", default="")
def shipped(kind: str, word: str) -> None:
    """List the materials or machines that are known by name, one line each; yours are marked.

    With WORD, those that have it in their name, kind or description.
    """
    with answers():
        from fab.catalogue import described
        from fab.preferences import own_files

        folder: Literal["materials", "machines"] = (
            "materials" if kind == "materials" else "machines"
        )
        every, own = described(folder), own_files(folder)
        listed = {
            name: (what, description)
            for name, (what, description) in every.items()
            if word.casefold() in f"{name} {what} {description}".casefold()
        }
        if not listed:
            raise InvalidJob(
                f"none of the {len(every)} {kind} has {shortened(word)!r} in its name, kind or "
                f"description. List all: `quadfold shipped {kind}`."
            )
        width = max(map(len, listed))
        wide = max(len(what) for what, _ in listed.values())
        for name, (what, description) in listed.items():
            yours = f" (yours: {own[name]})" if name in own else ""
            say(f"{name:<{width}}  {what:<{wide}}  {description}{yours}")
