"""Commands about jobs: run one, list the shipped ones, copy one."""

from __future__ import annotations

import difflib
import sys
import tomllib
from pathlib import Path

import click

from fab.cli.console import answers, progress_bar, say, tell, tell_left
from fab.cli.options import (
    OUT,
    SUGGEST,
    formats_of,
    write_made,
)
from fab.cli.panels import say_window
from fab.errors import InvalidJob

__all__ = ["new", "run", "templates"]


@click.command()
@click.argument("job", type=click.Path(path_type=Path))
@OUT
@click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a key of the job; may be repeated.",
)
@click.option(
    "--only", default=None, metavar="FORMATS", help="Such as dxf,svg (default: the job's)."
)
@click.option("--dry-run", is_flag=True, help="Make and check everything, write nothing.")
@SUGGEST
def run(
    job: Path,
    out: Path,
    changes: tuple[str, ...],
    only: str | None,
    dry_run: bool,
    suggest: bool,
) -> None:
    """Make all files of a job: FOLD, DXF, SVG, STEP, STL, 3MF, PNG and report.json."""
    with answers() as interrupts:
        from fab.jobs.grow import grown_pattern
        from fab.jobs.job import load_job
        from fab.jobs.job_files import Format, make
        from fab.outputs import file_names, left_over, require_folder

        chosen = formats_of(only, Format)
        loaded = load_job(job, changes)
        formats = chosen or [Format(name) for name in loaded.outputs]
        if suggest:
            with progress_bar(interrupts) as progress:
                pattern, findings = grown_pattern(loaded, progress)
            say_window(pattern, loaded.printed(loaded.print_with(loaded.folder)), interrupts)
            tell(findings)
            return
        require_folder(out)
        with progress_bar(interrupts) as progress:
            made = make(loaded, formats, progress)
        interrupts.check()
        write_made(made, out, dry_run)
        report = made.report
        say(
            f"{report['counts']['faces']} faces; planarity {report['planarity_max']:.1e}, "
            f"developability {report['developability_max_rad']:.1e} rad, "
            f"isometry {report['isometry_max_rel']:.1e}"
        )
        if report["growth"]["coverage"] is not None:
            say(f"{report['growth']['coverage']:.1%} of the surface lies under the sheet")
        tell_left(left_over(made.files, file_names(loaded.name, formats), out))
        tell(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


@click.command()
def templates() -> None:
    """List the shipped jobs, one line each."""
    with answers():
        from fab.catalogue import shipped as known

        names = known("jobs")
        width = max(map(len, names))
        for name, path in names.items():
            description = tomllib.loads(path.read_text(encoding="utf-8")).get("description", "")
            say(f"{name:<{width}}  {description}")


@click.command()
@click.argument("template")
@click.option("--out", default=None, type=click.Path(path_type=Path), help="File to write.")
def new(template: str, out: Path | None) -> None:
    """Copy a shipped job to a file of your own, to edit."""
    with answers():
        from fab.catalogue import shipped as files_of

        known = files_of("jobs")
        if template not in known:
            close = difflib.get_close_matches(template, known, 1, 0.6)
            hint = f" Did you mean {close[0]}?" if close else ""
            raise InvalidJob(f"template {template!r} must be one of {', '.join(known)}.{hint}")
        target = out if out is not None else Path(f"{template}.toml")
        try:
            with target.open("xb") as file:
                file.write(known[template].read_bytes())
        except FileExistsError as error:
            raise InvalidJob(f"{target} exists already. Give another file with --out.") from error
        except OSError as error:
            raise InvalidJob(
                f"{target}: cannot be written: {error.strerror}. Choose another --out."
            ) from error
        say(f"wrote {target}; make its files with: quadfold run {target} --out out")
