"""The command line: its commands, and the exit codes that they answer with.

0: made and within tolerance. 1: made, but with a finding of severity error. 2: bad usage or bad
input, nothing written. 130: interrupted (143: by SIGTERM), no partial file left.
"""

from __future__ import annotations

import click

from fab.cli.figures import figure
from fab.cli.findings import findings
from fab.cli.folding import animate, simulate
from fab.cli.jobs import new, run, templates
from fab.cli.panels import thicken
from fab.cli.patterns import check, convert
from fab.cli.preferences import settings
from fab.cli.sheets import coupon, fabricate, shipped
from fab.cli.studio import studio
from fab.cli.sweeps import sweep, table

__all__ = ["main"]


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="quadfold")
def main() -> None:
    """Quad origami, from a job file to files for laser cutters, 3D printers and simulators."""


for command in (
    *(run, fabricate, thicken, simulate, animate, coupon, shipped, templates, new, check, convert),
    figure,
    findings,
    studio,
    settings,
    sweep,
    table,
):
    main.add_command(command)
