"""Commands about a pattern itself: measured, and converted for other programs."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fab.cli.console import answers, say, tell
from fab.cli.delivery import write_made
from fab.cli.options import FILE, Size, dry_run, reading_options, size_options
from fab.errors import InvalidFile, InvalidJob, Severity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fab.errors import Finding
    from fab.formats.read_options import ReadOptions

__all__ = ["check", "convert"]


@click.command()
@FILE
@click.option(
    "--tolerance", default=1e-6, show_default=True, type=click.FloatRange(0, min_open=True)
)
@size_options
@reading_options
def check(file: Path, tolerance: float, size: Size, options: ReadOptions) -> None:
    """Measure a pattern: is its folded form planar, developable, isometric, uncrossed?

    FILE is of any format that is read. Of any pattern it says whether it folds with flat faces, and
    with how many degrees of freedom; and of one that folds flat whether its layers have an order.
    A folded form is measured where the file has one, as FOLD files and pairs of OBJ files may.
    """
    with answers():
        from fab.folding.rigid_motion import rigid_motion
        from fab.formats.pattern_file import resized
        from fab.jobs.pattern_check import check_pattern
        from fab.jobs.reading import read_any
        from fab.layers.layer_findings import inspect_layers
        from fab.layers.layer_orders import layer_orders
        from solver import InvalidValue

        if not math.isfinite(tolerance):
            raise InvalidJob(f"--tolerance {tolerance} must be finite and greater than 0.")
        read = resized(read_any([file], options), width_mm=size.width_mm, factor=size.factor)
        pattern = read.pattern
        tell(read.findings)
        try:
            found = check_pattern(pattern, tolerance)
            motion = rigid_motion(pattern)
            layers = layer_orders(pattern, read.face_orders)
        except InvalidValue as error:
            raise InvalidFile(f"{file}: {error}") from error
        counts = pattern.counts()
        say(f"vertices            {len(pattern.vertices_coords)}")
        say(f"faces               {pattern.face_count}")
        say(f"edges               {' '.join(f'{k}:{v}' for k, v in counts.items())}")
        say(f"flat faces          {motion.sentence()}")
        if layers is not None:
            say(f"layers              {layers.text()}")
        unordered = inspect_layers(layers)
        tell(unordered)
        if found is None:
            say("folded form         none to measure; the FOLD file that `simulate` writes has one")
            sys.exit(1 if _has_error([*read.findings, *unordered]) else 0)
        say(f"planarity           {found.accuracy.planarity_max:.3e}")
        say(f"developability      {found.accuracy.developability_max_rad:.3e} rad")
        say(f"isometry            {found.accuracy.isometry_max_rel:.3e}")
        say(f"crossings           {found.crossings}")
        tell(found.findings)
        sys.exit(0 if found.within_tolerance and not _has_error(unordered) else 1)


def _has_error(findings: Sequence[Finding]) -> bool:
    return any(finding.severity == Severity.ERROR for finding in findings)


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--out",
    default=None,
    type=click.Path(path_type=Path),
    help="File to write (default: the last of the files).",
)
@size_options
@reading_options
@dry_run("Read and convert everything, write nothing.")
def convert(
    files: tuple[Path, ...], out: Path | None, size: Size, options: ReadOptions, dry_run: bool
) -> None:
    """Convert crease patterns between programs.

    Reads FOLD, SVG, DXF, CP, OPX, ORI, ORH and OBJ; writes FOLD, SVG, DXF, CP, OBJ (pairs, or
    the flat sheet alone where there is no folded form), and PNG, a picture of what was understood.

    quadfold convert crane.svg crane.png      the letters of all lines, and what was repaired

    quadfold convert crane.cp crane.fold      with faces and fold angles

    quadfold convert crane.fold mended.fold   repairs the file, and says what it did

    quadfold convert crane.fold crane.svg     with the colours that Origami Simulator reads

    quadfold convert crane.fold crane.obj     writes crane_flat.obj and crane_fold.obj

    quadfold convert crane_flat.obj crane.fold   reads crane_fold.obj beside it as well

    quadfold convert first.obj second.obj --out crane.fold   a flat and a folded mesh
    """
    with answers():
        from fab.formats.pattern_file import resized
        from fab.jobs.conversion import convert
        from fab.jobs.reading import read_any
        from fab.outputs import require_folder

        target = out if out is not None else files[-1]
        sources = files if out is not None else files[:-1]
        require_folder(target.parent)
        read = resized(read_any(sources, options), width_mm=size.width_mm, factor=size.factor)
        made = convert(read, target)
        write_made(made, target.parent, dry_run=dry_run)
        tell(made.findings)
        sys.exit(0 if made.within_tolerance else 1)
