"""Commands about jobs: run one, list the shipped ones, copy one."""

from __future__ import annotations

import tomllib
from pathlib import Path

import click

from fab.cli.completion import JobPath
from fab.cli.console import answers, say
from fab.cli.delivery import FilesOf, Told, deliver
from fab.cli.inputs import allowed_job, place_of_job
from fab.cli.kept_folds import kept_fold
from fab.cli.options import (
    ALLOW_CODE,
    DRY_RUN,
    OUT,
    SUGGEST,
    changes_of,
    formats_of,
    only,
    told_options,
)
from fab.cli.panels import say_window
from fab.cli.progress_lines import progress_of
from fab.cli.run_summary import summary
from fab.errors import InvalidJob, counted, did_you_mean
from fab.files import shortened, shown_path
from fab.scratch import replaced

__all__ = ["new", "run", "templates"]


@click.command()
@click.argument("job", type=JobPath())
@OUT
@changes_of("Change a key of the job; may be repeated.")
@only("Such as dxf,svg (default: the job's).")
@DRY_RUN
@SUGGEST
@ALLOW_CODE
@told_options
def run(
    job: Path,
    out: Path,
    changes: tuple[str, ...],
    only: tuple[str, ...],
    dry_run: bool,
    suggest: bool,
    allow_code: bool,
    told: Told,
) -> None:
    """Make all files of a job: FOLD, DXF, SVG, STEP, STL, 3MF, PNG, HTML and a report.

    JOB is a TOML file, the name of a shipped one (see `quadfold templates`), or - for a job on
    standard input.
    """
    with answers() as interrupts:
        from fab.jobs.file_names import FAMILIES
        from fab.jobs.grow import grown_pattern
        from fab.jobs.job_files import Format, make

        chosen = formats_of(only, Format)
        loaded = allowed_job(place_of_job(job), changes, allow_code)
        formats = chosen or [Format(name) for name in loaded.wanted]
        if suggest:
            with progress_of(interrupts, lines=told in (Told.LINES, Told.ALL)) as progress:
                pattern, findings = grown_pattern(loaded, progress)
            print_with = loaded.print_with(loaded.folder)
            say_window(pattern, loaded, print_with, findings, interrupts, told)
            return
        folds = loaded.simulation is not None and not dry_run
        kept = kept_fold(out, loaded.name, told) if folds else None
        deliver(
            interrupts,
            lambda progress: make(loaded, formats, progress, checkpoint=kept),
            out,
            FilesOf(loaded.name, FAMILIES),
            dry_run=dry_run,
            summary=summary,
            told=told,
            kept=kept,
        )


@click.command()
@click.argument("word", default="")
@click.option("--paper", is_flag=True, help="The series in which the paper is made again.")
def templates(word: str, paper: bool) -> None:
    """List the shipped jobs, one line each: what is of use first, then designs to change.

    With WORD those that have it in name or description, of the paper's series too.
    """
    with answers():
        from fab.catalogue import PAPER, shipped, template_groups

        jobs = shipped("jobs")
        width, found = max(map(len, jobs)), 0
        for group, names in template_groups().items():
            if not word and paper != (group == PAPER):
                continue
            if not word:  # not among the names, which scripts read
                say(f"{group}:", error=True)
            for name in names:
                document = tomllib.loads(jobs[name].read_text(encoding="utf-8"))
                description = document.get("description", "")
                if word.casefold() in f"{name} {description}".casefold():
                    say(f"{name:<{width}}  {description}")
                    found += 1
        if not word and not paper:
            series = counted(len(template_groups()[PAPER]), "job")
            say(f"{series} more of the paper's series: `quadfold templates --paper`", error=True)
        if not found:
            raise InvalidJob(
                f"none of the {len(jobs)} shipped jobs has {shortened(word)!r} in its name or "
                "description. List all: `quadfold templates`."
            )


@click.command()
@click.argument("template", metavar="NAME")
@click.option("--out", default=None, type=click.Path(path_type=Path), help="File to write.")
def new(template: str, out: Path | None) -> None:
    """Copy a shipped job, material or machine to a file of your own, to edit."""
    with answers():
        from fab.catalogue import shipped

        jobs, stock = shipped("jobs"), {"material": shipped("materials")}
        stock["machine"] = shipped("machines")
        every = {**jobs, **stock["material"], **stock["machine"]}
        if template not in every:
            hint = did_you_mean(template, every)
            raise InvalidJob(
                f"template {shortened(template)!r} must be one of {', '.join(jobs)}, or a name "
                f"that `quadfold shipped materials` or `quadfold shipped machines` lists.{hint}"
            )
        target = out if out is not None else Path(f"{template}.toml")
        try:
            with replaced(target, fresh=True) as written:
                written.write_bytes(every[template].read_bytes())
        except FileExistsError as error:
            raise InvalidJob(f"{target} exists already. Give another file with --out.") from error
        except OSError as error:
            raise InvalidJob(
                f"{shown_path(target)}: cannot be written: {error.strerror}. Choose another --out."
            ) from error
        kind = next((kind for kind, names in stock.items() if template in names), None)
        use = f"quadfold run {target} --out out"
        if kind is None:
            say(f"wrote {target}; make its files with: {use}")
        else:
            say(f"wrote {target}; give its path in place of the name of a {kind}")
