"""Commands about thick panels."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fab.cli.console import Interrupts, answers, progress_bar, say, tell, tell_left
from fab.cli.options import (
    OUT,
    SCALE,
    SUGGEST,
    WIDTH,
    formats_of,
    write_made,
)

if TYPE_CHECKING:
    from fab.pattern.crease_pattern import CreasePattern
    from fab.printing.thick_settings import ThickSettings

__all__ = ["say_window", "thicken"]


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@OUT
@click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="KEY=VALUE",
    help="Such as panels.thickness_mm=1.2 or hinges.web_mm=0.4, as in a job; may be repeated.",
)
@click.option(
    "--printer", default=None, metavar="NAME", help="A shipped one, or a .toml file of your own."
)
@click.option(
    "--material",
    default=None,
    metavar="NAME",
    help="Of the print: a shipped one, or a .toml file.",
)
@WIDTH
@SCALE
@click.option("--only", default=None, metavar="FORMATS", help="Such as step,stl (default: all).")
@click.option("--dry-run", is_flag=True, help="Make and check everything, write nothing.")
@SUGGEST
def thicken(
    file: Path,
    out: Path,
    changes: tuple[str, ...],
    printer: str | None,
    material: str | None,
    width_mm: float | None,
    scale: float | None,
    only: str | None,
    dry_run: bool,
    suggest: bool,
) -> None:
    """Make thick panels and hinges from a FOLD file: STEP, STL, 3MF and PNG."""
    with answers() as interrupts:
        from fab.formats.fold_reader import read_pattern
        from fab.outputs import file_names, left_over, plain_title, require_folder
        from fab.pattern.crease_pattern import scaled
        from fab.printing.print_files import ORDINARY, ThickFormat, make_thick
        from fab.printing.thick_settings import thick_settings

        formats = formats_of(only, ThickFormat) or ORDINARY
        settings = thick_settings(changes, printer, material)
        print_with = settings.print_with()
        if not suggest:
            require_folder(out)
        pattern, findings = read_pattern(file)
        pattern = scaled(pattern, width_mm=width_mm, factor=scale)
        if suggest:
            say_window(pattern, settings.printed(print_with), interrupts)
            tell(findings)
            return
        name = plain_title(file.stem)
        with progress_bar(interrupts) as progress:
            made = make_thick(
                pattern,
                name,
                settings,
                print_with=print_with,
                formats=formats,
                findings=findings,
                progress=progress,
            )
        interrupts.check()
        write_made(made, out, dry_run)
        solids = made.report["solids"]
        if solids is not None:
            size = " x ".join(f"{side:.4g}" for side in made.report["bounding_box_mm"]["print"])
            say(f"{solids['panels']} panels, {solids['hinges']} hinges, {size} mm")
        tell_left(left_over(made.files, file_names(f"{name}_thick", formats), out))
        tell(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


def say_window(pattern: CreasePattern, settings: ThickSettings, interrupts: Interrupts) -> None:
    """The feasible window of scale and thickness of a sheet."""
    from fab.clearance.thickness_limit import collisions
    from fab.folding.folded_states import folded_states, with_free_angles
    from fab.panels.feasible_window import feasible_window
    from fab.pattern.kinematics import unknown_angles

    panels, hinges = settings.panels, settings.hinges
    with progress_bar(interrupts) as progress:
        states = None
        if unknown_angles(pattern).any():
            states, _ = folded_states(pattern, progress=progress)
            pattern = with_free_angles(pattern, states)
        clear = collisions(pattern, panels, hinges, progress, states)
        window = feasible_window(pattern, panels, hinges, clear)
    for line in window.lines():
        say(line)
