"""Commands about sheets for laser cutters and plotters."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from fab.cli.console import answers, progress_bar, say, tell, tell_left
from fab.cli.options import (
    MACHINE,
    MATERIAL,
    ONLY_SHEETS,
    OUT,
    SCALE,
    WIDTH,
    formats_of,
    write_made,
)

__all__ = ["coupon", "fabricate", "shipped"]


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@MATERIAL
@MACHINE
@OUT
@WIDTH
@SCALE
@click.option("--copies", default=1, show_default=True, type=int, help="How many of the model.")
@click.option(
    "--two-sided",
    is_flag=True,
    help="Score mountains from the front and valleys from the back: two drawings for each sheet.",
)
@ONLY_SHEETS
@click.option("--dry-run", is_flag=True, help="Make and check everything, write nothing.")
def fabricate(
    file: Path,
    material: str,
    machine: str,
    out: Path,
    width_mm: float | None,
    scale: float | None,
    copies: int,
    two_sided: bool,
    only: str | None,
    dry_run: bool,
) -> None:
    """Make the sheets that a laser cutter or plotter cuts from a FOLD file."""
    with answers() as interrupts:
        from fab.drawings.drawing_files import SheetFormat
        from fab.formats.fold_reader import read_pattern
        from fab.outputs import left_over, plain_title, require_folder
        from fab.pattern.crease_pattern import scaled
        from fab.sheets.materials import load_machine, load_material
        from fab.sheets.registration import Registration
        from fab.sheets.sheet_files import fabricate, sheet_names

        stuff, cutter = load_material(material), load_machine(machine)
        formats = formats_of(only, SheetFormat) or list(SheetFormat)
        require_folder(out)
        pattern, findings = read_pattern(file)
        pattern = scaled(pattern, width_mm=width_mm, factor=scale)
        name = plain_title(file.stem)
        with progress_bar(interrupts) as progress:
            made = fabricate(
                pattern,
                name,
                stuff,
                cutter,
                copies=copies,
                registration=Registration() if two_sided else None,
                formats=formats,
                findings=findings,
                progress=progress,
            )
        interrupts.check()
        write_made(made, out, dry_run)
        report = made.report
        say(
            f"{len(report['pieces'])} pieces, {len(report['glue_up'])} seams, "
            f"{len(report['sheets'])} sheets of {cutter.bed_mm[0]:g} x {cutter.bed_mm[1]:g} mm, "
            f"about {sum(sheet['minutes'] for sheet in report['sheets']):.1f} minutes"
        )
        if two_sided:
            others = " Treat the other sheets alike." if len(report["sheets"]) > 1 else ""
            say(report["sheets"][0]["turn"] + others)
        tell_left(left_over(made.files, sheet_names(name), out))
        tell(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


@click.command()
@MATERIAL
@MACHINE
@OUT
@ONLY_SHEETS
def coupon(material: str, machine: str, out: Path, only: str | None) -> None:
    """Make a test card that finds a machine's kerf and the best dashes for a material."""
    with answers():
        from fab.drawings.drawing_files import SheetFormat, drawing_files
        from fab.outputs import Made, plain_title, require_folder
        from fab.sheets.coupon import coupon
        from fab.sheets.cutting_order import tour
        from fab.sheets.materials import load_machine, load_material

        stuff, cutter = load_material(material), load_machine(machine)
        formats = formats_of(only, SheetFormat) or list(SheetFormat)
        require_folder(out)
        names = [Path(word).name.removesuffix(".toml") for word in (material, machine)]
        name = plain_title("_".join(["coupon", *names]))
        paths = tour(coupon(cutter, stuff))
        files = drawing_files(paths, name, formats, cutter.colours, cutter.dxf_version)
        write_made(Made(files, {}, ()), out)


@click.command()
@click.argument("kind", type=click.Choice(["materials", "machines"]))
def shipped(kind: str) -> None:
    """List the shipped materials or machines, one line each."""
    with answers():
        from fab.catalogue import described

        listed = described("materials" if kind == "materials" else "machines")
        width = max(map(len, listed))
        wide = max(len(what) for what, _ in listed.values())
        for name, (what, description) in listed.items():
            say(f"{name:<{width}}  {what:<{wide}}  {description}")
