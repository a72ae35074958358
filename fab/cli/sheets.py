"""Commands about sheets for laser cutters and plotters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from fab.cli.completion import StockName
from fab.cli.console import answers, say
from fab.cli.delivery import FilesOf, Told, deliver, write_made
from fab.cli.inputs import sheet_of
from fab.cli.options import (
    DRY_RUN,
    FILES,
    MACHINE,
    MATERIAL,
    OUT,
    Size,
    changes_of,
    formats_of,
    only,
    reading_options,
    size_options,
    told_options,
)
from fab.cli.preferences import preferred, required
from fab.cli.printer_coupons import write_test_print
from fab.errors import InvalidJob, counted, mass_text
from fab.files import shortened

if TYPE_CHECKING:
    from fab.formats.read_options import ReadOptions
    from fab.outputs import Made
    from fab.progress import Progress

__all__ = ["coupon", "fabricate", "sheet_lines", "shipped"]

# Files are named after up to this many patterns.
_MOST_NAMED = 3


@click.command()
@FILES
@MATERIAL
@MACHINE
@OUT
@size_options
@reading_options
@click.option(
    "--copies", default=None, metavar="N", help="How many of each, or such as 2,1 (default: 1)."
)
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
    files: tuple[Path, ...],
    material: str | None,
    machine: str | None,
    out: Path,
    size: Size,
    options: ReadOptions,
    copies: str | None,
    two_sided: bool,
    changes: tuple[str, ...],
    only: tuple[str, ...],
    dry_run: bool,
    told: Told,
) -> None:
    """Make the sheets that a laser cutter or plotter cuts from crease patterns.

    FILES are FOLD, SVG, DXF, CP, OPX, ORI, ORH or OBJ; pieces of several lie on the same sheets.
    """
    with answers() as interrupts:
        from fab.drawings.drawing_files import USUAL, SheetFormat
        from fab.formats.drawn.letters import unused_in_all
        from fab.jobs.file_names import SHEETS
        from fab.jobs.sheet_files import FabricatedFormat, fabricate_together
        from fab.outputs import plain_title
        from fab.sheets.cut_pieces import PatternCopies
        from fab.sheets.cutter_settings import cutter_tables

        of_all, of_each = _copies(copies, len(files))
        tables = cutter_tables(changes, _given(changes, material, machine, of_all, two_sided))
        other = (FabricatedFormat.HTML, FabricatedFormat.ASSEMBLY)
        usual = [*map(FabricatedFormat, USUAL), *other]
        chosen = formats_of(only, FabricatedFormat) or usual
        request = tables.cutter.request(
            [SheetFormat(kind) for kind in chosen if kind not in other],
            perforation=tables.perforation,
            page=FabricatedFormat.HTML in chosen,
            guide=FabricatedFormat.ASSEMBLY in chosen,
        )

        titles = _titles([plain_title(file.stem) for file in files])
        name = _together(titles)

        def make(progress: Progress) -> Made:
            read = [sheet_of(file, options, size) for file in files]
            found = unused_in_all([findings for _, _, findings in read])
            patterns = [
                PatternCopies(title, pattern, many, findings)
                for title, (pattern, _, _), many, findings in zip(
                    titles, read, of_each, found, strict=True
                )
            ]
            return fabricate_together(patterns, name, request, progress=progress)

        made = FilesOf(name, [SHEETS])
        deliver(interrupts, make, out, made, dry_run=dry_run, summary=sheet_lines, told=told)


def _copies(text: str | None, files: int) -> tuple[int | None, list[int]]:
    """How many of all patterns, if that is said, and how many times that of each."""
    if text is None:
        return None, [1] * files
    try:
        numbers = [int(number) for number in text.split(",")]
    except ValueError as error:
        raise InvalidJob(
            f"--copies {shortened(text)}: must be a whole number, or one for each file: 2,1."
        ) from error
    if min(numbers) < 1:
        raise InvalidJob(f"--copies {shortened(text)}: copies = {min(numbers)} must be at least 1.")
    if len(numbers) == 1:
        return numbers[0], [1] * files
    if len(numbers) != files:
        raise InvalidJob(
            f"--copies {shortened(text)}: {len(numbers)} numbers for {counted(files, 'file')}. "
            "Give one number, or one for each file."
        )
    return 1, numbers


def _titles(names: Sequence[str]) -> list[str]:
    """Names of patterns, those that are there already with a number.

    >>> _titles(["lid", "box", "lid"])
    ['lid', 'box', 'lid_2']
    """
    titles: list[str] = []
    for name in names:
        numbered = (f"{name}_{number}" for number in range(2, len(names) + 2))
        free = (title for title in (name, *numbered) if title not in titles)
        titles.append(next(free))
    return titles


def _together(titles: Sequence[str]) -> str:
    """What the files of several patterns are named after.

    >>> _together(["lid", "box"]), _together(["lid", "box", "foot", "hinge"])
    ('lid_box', 'lid_and_3_more')
    """
    if len(titles) <= _MOST_NAMED:
        return "_".join(titles)
    return f"{titles[0]}_and_{len(titles) - 1}_more"


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
    """Pieces, seams and sheets of a report, how long they take, their mass, how to turn them."""
    sheets, material = report["sheets"], report["material"]
    width, depth = report["machine"]["bed_mm"]
    covered_mm3 = sum(each["used"] for each in sheets) * width * depth * material["thickness_mm"]
    mass_g = covered_mm3 * material["density_kg_m3"] * 1e-6
    yield (
        f"{counted(len(report['pieces']), 'piece')}, {counted(len(report['glue_up']), 'seam')}, "
        f"{counted(len(sheets), 'sheet')} of {width:g} x {depth:g} mm, "
        f"about {sum(sheet['minutes'] for sheet in sheets):.1f} minutes, {mass_text(mass_g)}"
    )
    if len(report["patterns"]) > 1:
        for row in report["patterns"]:
            copies = counted(row["copies"], "copy", "copies")
            pieces, seams = counted(row["pieces"], "piece"), counted(row["seams"], "seam")
            yield f"{row['name']}: {copies} of {pieces}, {seams}"
    if "turn" in sheets[0]:  # two-sided
        others = " Treat the other sheets alike." if len(sheets) > 1 else ""
        yield sheets[0]["turn"] + others


@click.command()
@MATERIAL
@MACHINE
@click.option(
    "--printer",
    type=StockName("printer"),
    default=None,
    metavar="NAME",
    help="In place of a machine, with a print material: gaps, webs and knuckles to try.",
)
@OUT
@only("Such as dxf,pdf (default: dxf,svg,pdf); of a printer stl,3mf (default: both).")
def coupon(
    material: str | None,
    machine: str | None,
    printer: str | None,
    out: Path,
    only: tuple[str, ...],
) -> None:
    """Make a test card that finds a machine's kerf and the best dashes for a material.

    With --printer a test print, to find its least gap, the spread of its first layer, and webs that
    last; what is printed on the terminal says how to read it.
    """
    if printer is not None and machine is not None:
        raise click.UsageError("--machine and --printer exclude each other.")
    with answers():
        if printer is not None:
            write_test_print(printer, preferred("print_material", material), only, out)
            return
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
        paths = tour(coupon(cutter, stock, (words[0], words[1])))
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
