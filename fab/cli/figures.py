"""The command about the paper: its figures and movies, made by the solver."""

from __future__ import annotations

from pathlib import Path

import click

from fab.cli.console import answers, say
from fab.cli.delivery import write_made
from fab.cli.options import DRY_RUN, OUT, formats_of, only
from fab.cli.progress_lines import progress_of
from fab.errors import InvalidJob

__all__ = ["figure"]


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@OUT
@only("Such as svg or mp4 (default: png,svg of figures, gif of movies).")
@click.option("--list", "listed", is_flag=True, help="List names and captions; make nothing.")
@DRY_RUN
def figure(
    names: tuple[str, ...], out: Path, only: tuple[str, ...], listed: bool, dry_run: bool
) -> None:
    """Make figures (S1 to S18) and movies (M1 to M10) of the paper, or all of them.

    The paper is "An additive algorithm for origami design" (PNAS 2021); they are those of its
    supplementary information, made by the solver.
    """
    with answers() as interrupts:
        from fab.jobs.figure_files import FigureFormat, chosen_figures, figure_files
        from fab.jobs.paper_figures import NUMBERING, PAPER_FIGURES
        from fab.outputs import require_folder

        if listed:
            for each in PAPER_FIGURES:
                say(f"{each.name:<4} {each.caption}")
            say(NUMBERING)
            return
        if not names:
            raise InvalidJob("Name a figure such as S13, or all. `quadfold figure --list` has all.")
        chosen = chosen_figures(names, formats_of(only, FigureFormat))
        require_folder(out)
        for each, formats in chosen:
            with progress_of(interrupts) as progress:
                made = figure_files(each, formats, progress)
            interrupts.check()
            write_made(made, out, dry_run=dry_run)
            say(f"{each.name}: {each.caption}")
