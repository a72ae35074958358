"""Commands about folding."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fab.cli.console import answers, progress_bar, say, tell
from fab.cli.options import (
    OUT,
    formats_of,
    write_made,
)
from fab.errors import Finding

if TYPE_CHECKING:
    from fab.folding.fold_settings import FoldSettings
    from fab.pattern.crease_pattern import CreasePattern

__all__ = ["simulate"]


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@OUT
@click.option("--states", default=None, type=int, help="Steps from flat to folded (default: 10).")
@click.option(
    "--solver",
    type=click.Choice(["quasi-static", "dynamic"]),
    default="quasi-static",
    show_default=True,
    help="From rest to rest, or masses that move (slow; to compare).",
)
@click.option("--only", default=None, metavar="FORMATS", help="Such as fold,gif (default: all).")
@click.option("--dry-run", is_flag=True, help="Fold and judge, write nothing.")
def simulate(
    file: Path, out: Path, states: int | None, solver: str, only: str | None, dry_run: bool
) -> None:
    """Fold a FOLD file, or the sheet of a job, from flat, and judge whether it gets there."""
    with answers() as interrupts:
        from fab.folding.folding_files import SimulationFormat, simulate
        from fab.folding.simulation import Solver
        from fab.outputs import require_folder

        formats = formats_of(only, SimulationFormat) or list(SimulationFormat)
        require_folder(out)
        with progress_bar(interrupts) as progress:
            pattern, name, settings, findings = _to_simulate(file, states, progress)
            made = simulate(
                pattern,
                name,
                settings,
                solver=Solver(solver),
                formats=formats,
                findings=findings,
                progress=progress,
            )
        interrupts.check()
        write_made(made, out, dry_run)
        verdict = made.report["verdict"]
        far = verdict["rmsd_rel"]
        say(
            f"{'folds to its target' if verdict['reached'] else 'does not reach its target'}: "
            + (f"shape off by {far:.1e} of the diagonal, " if far is not None else "")
            + f"creases by at most {verdict['angle_error_max_deg']:.1e} degrees, strain "
            f"{verdict['strain_max']:.1e} (on the way {verdict['peak_strain']:.1e})"
        )
        tell(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


def _to_simulate(
    file: Path, states: int | None, progress: Callable[[str, int, int], None]
) -> tuple[CreasePattern, str, FoldSettings, Sequence[Finding]]:
    """The pattern of a FOLD file or a job, its name, and how it is to be folded."""
    from fab.folding.fold_settings import FoldSettings

    given = {} if states is None else {"steps": states}
    if file.suffix.lower() == ".toml":
        from fab.jobs.grow import grown_pattern
        from fab.jobs.job import load_job

        changes = [f"simulation.steps={states}"] if states is not None else []
        job = load_job(file, changes)
        pattern, findings = grown_pattern(job, progress)
        return pattern, job.name, job.simulation or FoldSettings(), findings
    from fab.formats.fold_reader import read_pattern
    from fab.settings import checked

    settings = checked(FoldSettings, given, "--states", "Leave it out for 10.")
    pattern, found = read_pattern(file)
    return pattern, file.stem, settings, found
