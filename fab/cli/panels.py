"""Commands about thick panels."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fab.cli.completion import StockName
from fab.cli.console import answers, say, tell, tell_all
from fab.cli.delivery import FilesOf, Told, deliver
from fab.cli.inputs import sheet_of
from fab.cli.options import (
    DRY_RUN,
    FILE,
    OUT,
    SUGGEST,
    Size,
    changes_of,
    formats_of,
    only,
    reading_options,
    size_options,
    told_options,
)
from fab.cli.preferences import preferred
from fab.cli.progress_lines import progress_of
from fab.errors import Finding, Severity, counted, mass_text
from fab.interrupts import Interrupts
from fab.outputs import finding_entry

if TYPE_CHECKING:
    from fab.formats.read_options import ReadOptions
    from fab.outputs import Made
    from fab.pattern.crease_pattern import CreasePattern
    from fab.printing.thick_settings import PrintWith, ThickSettings
    from fab.progress import Progress

__all__ = ["say_window", "solid_lines", "thicken"]


@click.command()
@FILE
@OUT
@changes_of("Such as panels.thickness_mm=1.2 or hinges.web_mm=0.4, as in a job; may be repeated.")
@click.option(
    "--printer",
    type=StockName("printer"),
    default=None,
    metavar="NAME",
    help="A shipped one, or a .toml file of your own.",
)
@click.option(
    "--material",
    type=StockName("print"),
    default=None,
    metavar="NAME",
    help="Of the print: a shipped one, or a .toml file.",
)
@size_options
@reading_options
@only("Such as step,stl (default: all but zip and glb).")
@DRY_RUN
@SUGGEST
@told_options
def thicken(
    file: Path,
    out: Path,
    changes: tuple[str, ...],
    printer: str | None,
    material: str | None,
    size: Size,
    options: ReadOptions,
    only: tuple[str, ...],
    dry_run: bool,
    suggest: bool,
    told: Told,
) -> None:
    """Make thick panels and hinges from a crease pattern: STEP, STL, 3MF, PNG, HTML and a guide.

    FILE is FOLD, SVG, DXF, CP, OPX, ORI, ORH or OBJ.
    """
    with answers() as interrupts:
        from fab.jobs.file_names import THICK
        from fab.jobs.print_files import ORDINARY, ThickFormat, make_thick
        from fab.outputs import plain_title
        from fab.printing.thick_settings import thick_settings

        formats = formats_of(only, ThickFormat) or ORDINARY
        if not any(change.startswith("printer") for change in changes):
            printer = preferred("printer", printer)
            material = preferred("print_material", material)
        settings = thick_settings(changes, printer, material)
        print_with = settings.print_with()
        if suggest:
            pattern, _, findings = sheet_of(file, options, size)
            say_window(pattern, settings, print_with, findings, interrupts, told)
            return

        def make(progress: Progress) -> Made:
            pattern, name, findings = sheet_of(file, options, size)
            return make_thick(
                pattern,
                name,
                settings,
                print_with=print_with,
                formats=formats,
                findings=findings,
                progress=progress,
            )

        files = FilesOf(plain_title(file.stem), [THICK])
        deliver(interrupts, make, out, files, dry_run=dry_run, summary=solid_lines, told=told)


def solid_lines(report: Mapping[str, Any]) -> Iterator[str]:
    """What was made of panels, and that they stay apart in the states that were checked."""
    solids = report["solids"]
    if solids is None:
        return
    panels, hinges = counted(solids["panels"], "panel"), counted(solids["hinges"], "hinge")
    size = " x ".join(f"{side:.4g}" for side in report["bounding_box_mm"]["print"])
    plates = solids.get("plates", report.get("plates"))
    on = "" if plates is None else f" on {counted(len(plates['plates']), 'plate')}"
    mass = "" if solids.get("mass_g") is None else f", {mass_text(solids['mass_g'])}"
    yield f"{panels}, {hinges}, {size} mm{on}{mass}"
    near = [state for state in solids["states"] if state["clearance_min_mm"] is not None]
    if solids["overlap_max_mm3"] or not near:
        return
    nearest = min(near, key=lambda state: float(state["clearance_min_mm"]))
    yield (
        f"nothing overlaps in {counted(len(solids['states']), 'checked state')} of the fold; the "
        f"least clearance is {nearest['clearance_min_mm']:.2g} mm, {nearest['state']}"
    )


def say_window(
    pattern: CreasePattern,
    settings: ThickSettings,
    print_with: PrintWith,
    findings: Sequence[Finding],
    interrupts: Interrupts,
    told: Told,
) -> None:
    """The feasible window of scale and thickness of a sheet, line by line or as JSON."""
    from fab.jobs.suggestion import suggested_window

    in_lines = told in (Told.LINES, Told.ALL)
    with progress_of(interrupts, lines=in_lines) as progress:
        window = suggested_window(
            pattern, settings.printed(print_with), progress, print_with.printer
        )
    if told is Told.JSON:
        listed = [finding_entry(finding) for finding in findings]
        say(json.dumps({"window": asdict(window), "findings": listed}, indent=2))
    if told is Told.ERRORS:
        tell([finding for finding in findings if finding.severity is Severity.ERROR])
    if in_lines:
        for line in window.lines():
            say(line)
        (tell_all if told is Told.ALL else tell)(findings)
