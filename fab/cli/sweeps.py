"""Commands about sweeps: many variations of a job, and the table of them."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from fab.cli.console import answers, say
from fab.cli.options import ALLOW_CODE, OUT
from fab.cli.progress_lines import progress_of
from fab.errors import counted

__all__ = ["sweep", "table"]


@click.command()
@click.argument("sweep", metavar="SWEEP", type=click.Path(path_type=Path))
@OUT
@click.option("--jobs", type=click.IntRange(1, 1024), help="Processes (default: one a processor).")
@click.option("--cluster", metavar="ADDRESS", help="A scheduler of Dask, such as tcp://node:8786.")
@click.option("--dry-run", is_flag=True, help="Say how many variations and how long; make nothing.")
@ALLOW_CODE
@click.option("--job-script", is_flag=True, help="Show what a batch system is given; run nothing.")
def sweep(
    sweep: Path,
    out: Path,
    jobs: int | None,
    cluster: str | None,
    dry_run: bool,
    allow_code: bool,
    job_script: bool,
) -> None:
    """Run many variations of a job, and write a table of what became of each.

    SWEEP is a TOML file: a base job, and the values that keys of it take. What is in the folder
    already is not done again, so that a sweep that was ended goes on where it was.
    """
    with answers() as interrupts:
        from fab.sweeps.cluster import ClusterSettings
        from fab.sweeps.cluster import job_script as script_of
        from fab.sweeps.sweep_run import estimate, run_sweep
        from fab.sweeps.sweep_settings import load_sweep

        loaded = load_sweep(sweep, allow_code=allow_code)
        if job_script:
            say(script_of(loaded.cluster or ClusterSettings(kind="slurm")))
            return
        if dry_run:
            with progress_of(interrupts) as progress:
                found = estimate(loaded, jobs=jobs, source=str(sweep), progress=progress)
            for line in found.lines():
                say(line)
            return
        address = None if cluster is None else ClusterSettings(kind="address", address=cluster)
        with progress_of(interrupts) as progress:
            result = run_sweep(
                loaded,
                out,
                jobs=jobs,
                cluster=address or loaded.cluster,
                source=str(sweep),
                progress=progress,
            )
        for line in result.lines():
            say(line)


@click.command()
@click.argument("folder", default=".", type=click.Path(path_type=Path))
@click.option("--best", metavar="COLUMN", help="Lowest values first; -COLUMN: highest.")
@click.option("--where", metavar="CONDITION", help='As in SQL, such as "crossings = 0".')
@click.option("--top", type=click.IntRange(1), help="At most so many rows.")
@click.option(
    "--show", metavar="COLUMNS", help="Such as number,mass_g (default: axes and what is asked for)."
)
@click.option("--csv", "as_csv", is_flag=True, help="Print all columns as CSV.")
@click.option("--schema", is_flag=True, help="Print the JSON schema of reports instead.")
def table(
    folder: Path,
    best: str | None,
    where: str | None,
    top: int | None,
    show: str | None,
    as_csv: bool,
    schema: bool,
) -> None:
    """Show rows of the table of a sweep: the best, or those that meet a condition."""
    with answers():
        if schema:
            from fab.sweeps.report_schema import report_schema

            say(json.dumps(report_schema(), indent=2))
            return
        from fab.sweeps.sweep_table import choose

        names = [] if show is None else [name.strip() for name in show.split(",")]
        chosen = choose(
            folder / "results.parquet",
            best=best,
            where=where,
            top=top,
            show=names,
            whole=as_csv and not names,
        )
        if as_csv:
            say(_csv(chosen.columns, chosen.rows))
            return
        for line in _aligned(chosen.columns, chosen.rows):
            say(line)
        say(f"{counted(len(chosen.rows), 'row')} of {chosen.matching}")


def _csv(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return out.getvalue().removesuffix("\n")


def _aligned(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    cells = [list(columns), *([_shown(value) for value in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells
    ]


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.5g}"
    text = str(value)
    return text if len(text) <= _WIDEST else f"{text[: _WIDEST - 3]}..."


_WIDEST = 60
