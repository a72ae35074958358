"""What can be asked on the command line, and with which exit code is it answered?

0: made and within tolerance. 1: made, but with a finding of severity error. 2: bad usage or bad
input, nothing written. 130: interrupted, no half file left.
"""

from __future__ import annotations

import difflib
import math
import sys
import tomllib
from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from fab.console import Interrupts, answers, progress_bar, say, tell, tell_left
from fab.errors import Finding, InvalidFile, InvalidJob, Severity
from solver.errors import InvalidValue

if TYPE_CHECKING:
    from fab.crease import CreasePattern
    from fab.make import Made
    from fab.stiffness import FoldSettings
    from fab.thick_settings import ThickSettings

__all__ = ["main"]


_OUT = click.option(
    "--out",
    default=".",
    type=click.Path(path_type=Path),
    help="Folder to write into (default: here).",
)
_MATERIAL = click.option(
    "--material", required=True, metavar="NAME", help="A shipped one, or a .toml file of your own."
)
_MACHINE = click.option(
    "--machine", required=True, metavar="NAME", help="A shipped one, or a .toml file of your own."
)
_ONLY_SHEETS = click.option(
    "--only", default=None, metavar="FORMATS", help="Such as dxf,pdf (default: dxf,svg,pdf)."
)

_WIDTH = click.option("--width-mm", default=None, type=float, help="Longer side of the flat sheet.")
_SCALE = click.option("--scale", default=None, type=float, help="Times the size in the file.")
_SUGGEST = click.option(
    "--suggest",
    is_flag=True,
    help="Say at which thicknesses and sizes every panel stands; make nothing.",
)
_STRICT = click.option(
    "--strict", is_flag=True, help="Refuse files that need a repair, or an assumption."
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="quadfold")
def main() -> None:
    """Quad origami, from a job file to files for laser cutters, 3D printers and simulators."""


@main.command()
@click.argument("job", type=click.Path(path_type=Path))
@_OUT
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
@_SUGGEST
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
        from fab.job import load_job
        from fab.make import Format, file_names, grown_pattern, left_over, make, require_folder

        chosen = _formats(only, Format)
        loaded = load_job(job, changes)
        formats = chosen or [Format(name) for name in loaded.outputs]
        if suggest:
            with progress_bar(interrupts) as progress:
                pattern, findings = grown_pattern(loaded, progress)
            _say_window(pattern, loaded.printed(loaded.print_with(loaded.folder)), interrupts)
            tell(findings)
            return
        require_folder(out)
        with progress_bar(interrupts) as progress:
            made = make(loaded, formats, progress)
        interrupts.check()
        _write(made, out, dry_run)
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


@main.command()
@click.argument("file", type=click.Path(path_type=Path))
@_MATERIAL
@_MACHINE
@_OUT
@_WIDTH
@_SCALE
@click.option("--copies", default=1, show_default=True, type=int, help="How many of the model.")
@click.option(
    "--two-sided",
    is_flag=True,
    help="Score mountains from the front and valleys from the back: two drawings for each sheet.",
)
@_ONLY_SHEETS
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
        from fab.crease import scaled
        from fab.drawings import SheetFormat
        from fab.fabricate import fabricate, sheet_names
        from fab.make import left_over, require_folder
        from fab.materials import load_machine, load_material
        from fab.pattern_file import read_pattern
        from fab.titles import plain_title
        from fab.two_sided import Registration

        stuff, cutter = load_material(material), load_machine(machine)
        formats = _formats(only, SheetFormat) or list(SheetFormat)
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
        _write(made, out, dry_run)
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


@main.command()
@click.argument("file", type=click.Path(path_type=Path))
@_OUT
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
@_WIDTH
@_SCALE
@click.option("--only", default=None, metavar="FORMATS", help="Such as step,stl (default: all).")
@click.option("--dry-run", is_flag=True, help="Make and check everything, write nothing.")
@_SUGGEST
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
        from fab.crease import scaled
        from fab.make import file_names, left_over, require_folder
        from fab.pattern_file import read_pattern
        from fab.thick_files import ORDINARY, ThickFormat, make_thick
        from fab.thick_settings import thick_settings
        from fab.titles import plain_title

        formats = _formats(only, ThickFormat) or ORDINARY
        settings = thick_settings(changes, printer, material)
        print_with = settings.print_with()
        if not suggest:
            require_folder(out)
        pattern, findings = read_pattern(file)
        pattern = scaled(pattern, width_mm=width_mm, factor=scale)
        if suggest:
            _say_window(pattern, settings.printed(print_with), interrupts)
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
        _write(made, out, dry_run)
        solids = made.report["solids"]
        if solids is not None:
            size = " x ".join(f"{side:.4g}" for side in made.report["bounding_box_mm"]["print"])
            say(f"{solids['panels']} panels, {solids['hinges']} hinges, {size} mm")
        tell_left(left_over(made.files, file_names(f"{name}_thick", formats), out))
        tell(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


@main.command()
@click.argument("file", type=click.Path(path_type=Path))
@_OUT
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
        from fab.make import require_folder
        from fab.simulate import SimulationFormat, simulate
        from fab.simulation import Solver

        formats = _formats(only, SimulationFormat) or list(SimulationFormat)
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
        _write(made, out, dry_run)
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
    from fab.stiffness import FoldSettings

    given = {} if states is None else {"steps": states}
    if file.suffix.lower() == ".toml":
        from fab.job import load_job
        from fab.make import grown_pattern

        changes = [f"simulation.steps={states}"] if states is not None else []
        job = load_job(file, changes)
        pattern, findings = grown_pattern(job, progress)
        return pattern, job.name, job.simulation or FoldSettings(), findings
    from fab.pattern_file import read_pattern
    from fab.settings import checked

    settings = checked(FoldSettings, given, "--states", "Leave it out for 10.")
    pattern, found = read_pattern(file)
    return pattern, file.stem, settings, found


@main.command()
@_MATERIAL
@_MACHINE
@_OUT
@_ONLY_SHEETS
def coupon(material: str, machine: str, out: Path, only: str | None) -> None:
    """Make a test card that finds a machine's kerf and the best dashes for a material."""
    with answers():
        from fab.coupon import coupon
        from fab.drawings import SheetFormat, drawing_files
        from fab.make import Made, require_folder
        from fab.materials import load_machine, load_material
        from fab.titles import plain_title
        from fab.tour import tour

        stuff, cutter = load_material(material), load_machine(machine)
        formats = _formats(only, SheetFormat) or list(SheetFormat)
        require_folder(out)
        names = [Path(word).name.removesuffix(".toml") for word in (material, machine)]
        name = plain_title("_".join(["coupon", *names]))
        paths = tour(coupon(cutter, stuff))
        files = drawing_files(paths, name, formats, cutter.colours, cutter.dxf_version)
        _write(Made(files, {}, ()), out)


@main.command()
@click.argument("kind", type=click.Choice(["materials", "machines"]))
def shipped(kind: str) -> None:
    """List the shipped materials or machines, one line each."""
    with answers():
        from fab.described import described

        listed = described("materials" if kind == "materials" else "machines")
        width = max(map(len, listed))
        wide = max(len(what) for what, _ in listed.values())
        for name, (what, description) in listed.items():
            say(f"{name:<{width}}  {what:<{wide}}  {description}")


@main.command()
def templates() -> None:
    """List the shipped jobs, one line each."""
    with answers():
        from fab.shipped import shipped as known

        names = known("jobs")
        width = max(map(len, names))
        for name, path in names.items():
            description = tomllib.loads(path.read_text(encoding="utf-8")).get("description", "")
            say(f"{name:<{width}}  {description}")


@main.command()
@click.argument("template")
@click.option("--out", default=None, type=click.Path(path_type=Path), help="File to write.")
def new(template: str, out: Path | None) -> None:
    """Copy a shipped job to a file of your own, to edit."""
    with answers():
        from fab.shipped import shipped as files_of

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


@main.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--tolerance", default=1e-6, show_default=True, type=click.FloatRange(0, min_open=True)
)
@_STRICT
def check(file: Path, tolerance: float, strict: bool) -> None:
    """Measure a FOLD file that has a folded frame: planar, developable, isometric, uncrossed?"""
    with answers():
        from fab.crossing import crossing_faces
        from fab.inspection import (
            inspect_accuracy,
            inspect_angles,
            inspect_crossings,
            measure_pattern,
        )
        from fab.pattern_file import read_pattern

        if not math.isfinite(tolerance):
            raise InvalidJob(f"--tolerance {tolerance} must be finite and greater than 0.")
        pattern, repairs = read_pattern(file, strict=strict)
        tell(repairs)
        if pattern.folded_coords is None:
            raise InvalidFile(
                f"{file}: no folded frame to measure. Add a frame of class foldedForm."
            )
        accuracy = measure_pattern(pattern)
        try:
            angles = inspect_angles(pattern)
        except InvalidValue as error:
            raise InvalidFile(f"{file}: {error}") from error
        crossings = crossing_faces(
            pattern.folded_coords, pattern.faces_vertices, pattern.faces_offsets
        )
        counts = pattern.counts()
        say(f"vertices            {len(pattern.vertices_coords)}")
        say(f"faces               {pattern.face_count}")
        say(f"edges               {' '.join(f'{k}:{v}' for k, v in counts.items())}")
        say(f"planarity           {accuracy.planarity_max:.3e}")
        say(f"developability      {accuracy.developability_max_rad:.3e} rad")
        say(f"isometry            {accuracy.isometry_max_rel:.3e}")
        say(f"crossings           {len(crossings)}")
        findings = inspect_accuracy(accuracy, tolerance) + angles + inspect_crossings(crossings)
        tell(findings)
    sys.exit(1 if any(f.severity == Severity.ERROR for f in findings) else 0)


@main.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--out",
    default=None,
    type=click.Path(path_type=Path),
    help="File to write (default: the last of the files).",
)
@_STRICT
@click.option("--dry-run", is_flag=True, help="Read and convert everything, write nothing.")
def convert(files: tuple[Path, ...], out: Path | None, strict: bool, dry_run: bool) -> None:
    """Convert between FOLD files and pairs of OBJ files (flat and folded), or to SVG.

    quadfold convert crane.fold mended.fold   repairs the file, and says what it did

    quadfold convert crane.fold crane.obj     writes crane_flat.obj and crane_fold.obj

    quadfold convert crane.fold crane.svg     with the colours that Origami Simulator reads

    quadfold convert crane_flat.obj crane.fold   reads crane_fold.obj beside it as well

    quadfold convert one.obj two.obj --out crane.fold   a flat and a folded mesh
    """
    with answers():
        from fab.convert import convert, read_any
        from fab.make import require_folder

        target = out if out is not None else files[-1]
        sources = files if out is not None else files[:-1]
        require_folder(target.parent)
        made = convert(read_any(sources, strict=strict), target)
        _write(made, target.parent, dry_run)
        tell(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


def _write(made: Made, folder: Path, dry_run: bool = False) -> None:
    """Write all files, unless it is a dry run, and list them."""
    from fab.make import write

    if not dry_run:
        write(made, folder)
    verb = "would write" if dry_run else "wrote"
    for name, data in made.files.items():
        say(f"{verb} {folder / name}  {len(data)} bytes")


def _say_window(pattern: CreasePattern, settings: ThickSettings, interrupts: Interrupts) -> None:
    """The feasible window of scale and thickness of a sheet."""
    from fab.collisions import collisions
    from fab.kinematics import unknown_angles
    from fab.states import folded_states, with_free_angles
    from fab.window import feasible_window

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


Kind = TypeVar("Kind", bound=StrEnum)


def _formats(only: str | None, kinds: type[Kind]) -> list[Kind] | None:
    if only is None:
        return None
    known = [str(kind) for kind in kinds]
    chosen = []
    for word in only.split(","):
        name = word.strip().lower()
        if name not in known:
            close = difflib.get_close_matches(name, known, 1, 0.6)
            hint = f" Did you mean {close[0]}?" if close else ""
            raise InvalidJob(f"--only {name!r} must be among {','.join(known)}.{hint}")
        chosen.append(kinds(name))
    return chosen
