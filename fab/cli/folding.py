"""Commands about folding."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fab.cli.completion import StockName
from fab.cli.console import answers
from fab.cli.delivery import FilesOf, Told, deliver
from fab.cli.inputs import allowed_job, shipped_job
from fab.cli.kept_folds import kept_fold
from fab.cli.load_options import load_options, with_loads
from fab.cli.options import (
    ALLOW_CODE,
    FILE,
    OUT,
    Size,
    dry_run,
    formats_of,
    only,
    reading_options,
    size_options,
    told_options,
)
from fab.errors import Finding, InvalidJob, counted

if TYPE_CHECKING:
    from fab.folding.fold_settings import FoldSettings
    from fab.formats.read_options import ReadOptions
    from fab.jobs.job import Job
    from fab.outputs import Made
    from fab.pattern.crease_pattern import CreasePattern
    from fab.progress import Progress
    from solver.vectors import IntArray

__all__ = ["animate", "simulate"]


@click.command()
@FILE
@OUT
@click.option("--states", default=None, type=int, help="Steps from flat to folded (default: 10).")
@click.option(
    "--solver",
    type=click.Choice(["quasi-static", "dynamic"]),
    default=None,
    help="From rest to rest (default), or masses that move (slow; to compare).",
)
@click.option(
    "--fold-flat",
    is_flag=True,
    help="With --rigid: go on beyond the target until the sheet is folded flat.",
)
@click.option(
    "--tolerance-deg",
    default=None,
    type=click.FloatRange(0, 180, min_open=True),
    help="Largest error of a crease at the target (default: 0.1); 0.1 % of strain and shape for "
    "each degree.",
)
@click.option(
    "--contact/--no-contact",
    default=None,
    help="Faces stop each other, or pass through each other (default: stop, with --thickness-mm or "
    "where they would).",
)
@click.option(
    "--thickness-mm",
    default=None,
    type=click.FloatRange(0, 1000),
    help="Of the sheet, which keeps touching layers apart; over 0 faces stop each other (default: "
    "0).",
)
@click.option(
    "--material",
    type=StockName("sheet"),
    default=None,
    metavar="NAME",
    help="What the sheet is made of, for loads and for the strain that it bears. A shipped one, or "
    "a .toml file of your own.",
)
@load_options
@size_options
@reading_options
@only("Such as fold,gif (default: all).")
@dry_run("Fold and judge, write nothing.")
@ALLOW_CODE
@told_options
def simulate(
    file: Path,
    out: Path,
    states: int | None,
    solver: str | None,
    fold_flat: bool,
    tolerance_deg: float | None,
    material: str | None,
    loads: Mapping[str, Any],
    contact: bool | None,
    thickness_mm: float | None,
    size: Size,
    options: ReadOptions,
    only: tuple[str, ...],
    dry_run: bool,
    allow_code: bool,
    told: Told,
) -> None:
    """Fold a crease pattern, or the sheet of a job, from flat, and judge whether it gets there.

    FILE is FOLD, SVG, DXF, CP, OPX, ORI, ORH or OBJ; or a job (TOML, or the name of a shipped one).
    With --rigid the faces stay flat: the sheet follows its rigid motion, where there is one, to its
    target, or until the crease that folds most is at --fold-deg. With --fix the folded sheet
    carries loads, its weight for one.
    """
    with answers() as interrupts:
        from fab.folding.simulation import Solver
        from fab.jobs.file_names import FOLDING
        from fab.jobs.folding_files import SimulationFormat, simulate
        from fab.outputs import plain_title

        formats = formats_of(only, SimulationFormat) or list(SimulationFormat)
        if options.rigid and solver is not None:
            raise InvalidJob(f"--solver {solver} and --rigid: leave out one of them.")
        if fold_flat and not options.rigid:
            raise InvalidJob("--fold-flat goes on along the motion of --rigid: give both.")
        chosen = Solver.RIGID if options.rigid else Solver(solver or Solver.QUASI_STATIC)
        if options.fold_deg is None:
            options = replace(options, rigid=False)  # the angles of the file are the target
        job = _job_of(file, states, allow_code)
        if job is not None:
            _require_none(file, options, size)
        name = plain_title(file.stem) if job is None else job.name
        if chosen is not Solver.QUASI_STATIC and (contact or thickness_mm is not None):
            given = "--contact" if contact else f"--thickness-mm {thickness_mm:g}"
            other = "--rigid" if chosen is Solver.RIGID else f"--solver {chosen}"
            raise InvalidJob(
                f"{given} and {other}: only the quasi-static solver, the default, knows contact. "
                "Leave out one of them."
            )
        held = {"contact": contact, "thickness_mm": thickness_mm}
        settings = with_loads(_settings(job, states), loads).model_copy(
            update={key: value for key, value in held.items() if value is not None}
        )
        if material is None and job is not None and job.cutter is not None:
            material = job.cutter.material

        kept = None if dry_run else kept_fold(out, name, told)

        def make(progress: Progress) -> Made:
            pattern, findings, upright, orders = _pattern(file, job, options, size, progress)
            return simulate(
                pattern,
                name,
                settings,
                solver=chosen,
                formats=formats,
                findings=findings,
                progress=progress,
                tolerance_deg=tolerance_deg,
                fold_flat=fold_flat,
                upright=upright,
                face_orders=orders,
                checkpoint=kept,
                material=material,
            )

        deliver(
            interrupts,
            make,
            out,
            FilesOf(name, [FOLDING]),
            dry_run=dry_run,
            summary=_summary,
            told=told,
            kept=kept,
        )


@click.command()
@FILE
@OUT
@click.option(
    "--show",
    type=click.Choice(["growth", "folding", "both"]),
    default=None,
    help="What is shown (default: both of a job, folding of a pattern).",
)
@click.option("--states", default=None, type=int, help="Steps from flat to folded (default: 30).")
@size_options
@reading_options
@only("gif, mp4 or both (default: gif, and mp4 where an encoder is installed).")
@dry_run("Draw everything, write nothing.")
@ALLOW_CODE
@told_options
def animate(
    file: Path,
    out: Path,
    show: str | None,
    states: int | None,
    size: Size,
    options: ReadOptions,
    only: tuple[str, ...],
    dry_run: bool,
    allow_code: bool,
    told: Told,
) -> None:
    """Animate how a sheet grows, strip by strip, and how it folds.

    FILE is a job (TOML, or the name of a shipped one), or a crease pattern: FOLD, SVG, DXF, CP,
    OPX, ORI, ORH or OBJ. A pattern does not say how it grew, so its folding is shown alone: along
    its rigid motion where it has one, else as it is simulated.
    """
    with answers() as interrupts:
        from fab.jobs.animation_files import AnimationFormat, Shown, animate, formats_here
        from fab.jobs.file_names import ANIMATION
        from fab.jobs.grow import grown, growth_findings
        from fab.outputs import plain_title
        from fab.progress import Clock

        formats = formats_of(only, AnimationFormat) or formats_here()
        job = _job_of(file, None, allow_code)
        if job is not None:
            _require_none(file, options, size)
        kinds = {None: None, "both": list(Shown)}
        shown = kinds[show] if show in kinds else [Shown(str(show))]
        if job is None and shown is not None and Shown.GROWTH in shown:
            raise InvalidJob(
                f"--show {show}: {file} is a crease pattern, which does not say how it grew. Give "
                "a job (TOML), or leave out --show."
            )
        name = plain_title(file.stem) if job is None else job.name
        settings = None if states is None else _settings(None, states)
        if settings is not None and job is not None and job.simulation is not None:
            settings = job.simulation.model_copy(update={"steps": settings.steps})

        def make(progress: Progress) -> Made:
            if job is None:
                pattern, findings, *_ = _pattern(file, None, options, size, progress)
                return animate(
                    pattern,
                    name,
                    shown=shown,
                    formats=formats,
                    settings=settings,
                    findings=findings,
                    progress=progress,
                )
            sheet = grown(job, Clock(progress))
            return animate(
                sheet,
                name,
                shown=shown,
                formats=formats,
                settings=settings,
                findings=[*sheet.findings, *growth_findings(sheet.growth)],
                progress=progress,
            )

        files = FilesOf(name, [ANIMATION])
        deliver(interrupts, make, out, files, dry_run=dry_run, summary=_animated, told=told)


def _animated(report: Mapping[str, Any]) -> Iterator[str]:
    if "strips" in report:
        yield f"grows in {counted(report['strips'], 'strip')}"
    if "states" in report:
        how = "rigidly, its faces flat" if report["rigid"] else "as it is simulated"
        yield f"folds {how}: {counted(report['states'], 'state')}"


def _job_of(file: Path, states: int | None, allow_code: bool) -> Job | None:
    """The job in a TOML file, or a shipped one by its name; None for files of crease patterns."""
    file = shipped_job(file) or file
    if file.suffix.lower() != ".toml":
        return None
    changes = [f"simulation.steps={states}"] if states is not None else []
    return allowed_job(file, changes, allow_code)


def _require_none(file: Path, options: ReadOptions, size: Size) -> None:
    """Raise `InvalidJob` for options that are of files of crease patterns alone."""
    from fab.formats.read_options import ReadOptions

    if options != ReadOptions() or size != Size():
        raise InvalidJob(
            f"{file}: a job says itself how large its sheet is and how it folds. Leave out the "
            "options of drawings and sizes, or change keys of the job."
        )


def _settings(job: Job | None, states: int | None) -> FoldSettings:
    from fab.folding.fold_settings import FoldSettings
    from fab.settings import checked

    if job is not None:
        return job.simulation or FoldSettings()
    given = {} if states is None else {"steps": states}
    return checked(FoldSettings, given, "--states", "Leave it out for 10.")


def _pattern(
    file: Path, job: Job | None, options: ReadOptions, size: Size, progress: Progress
) -> tuple[CreasePattern, Sequence[Finding], bool, IntArray | None]:
    """The pattern to fold, grown for a job, or read; its findings; whether it stands upright; and
    faceOrders of its file.
    """
    if job is not None:
        from fab.jobs.grow import grown, growth_findings
        from fab.progress import Clock

        sheet = grown(job, Clock(progress))
        findings = [*sheet.findings, *growth_findings(sheet.growth)]
        return sheet.pattern, findings, sheet.target is not None, None
    from fab.formats.pattern_file import resized
    from fab.jobs.reading import read_any

    read = resized(read_any([file], options), width_mm=size.width_mm, factor=size.factor)
    return read.pattern, read.findings, False, read.face_orders


def _summary(report: Mapping[str, Any]) -> Iterator[str]:
    from fab.jobs.simulated_sheet import sentences

    yield from sentences(report)
    verdict = report["verdict"]
    if verdict is None:
        return
    far = verdict["rmsd_rel"]
    reached = "folds to its target" if verdict["reached"] else "does not reach its target"
    if verdict["kind"] == "cannot-lie-flat":
        reached = "cannot lie flat, though its angles are reached"
    elif verdict["kind"] == "is-stopped" and verdict["reached"]:
        reached = "only if its faces pass through each other it comes to its target"
    figures = (
        f"{reached}: "
        + (f"shape off by {far:.1e} of the diagonal, " if far is not None else "")
        + f"creases by at most {verdict['angle_error_max_deg']:.3g} degrees, strain "
        f"{verdict['strain_max']:.2g} (on the way {verdict['peak_strain']:.2g})"
    )
    if verdict["kind"] != "nothing-folds":
        yield figures
    if "loads" in report:
        yield report["loads"]["text"]
