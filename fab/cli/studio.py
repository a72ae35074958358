"""The command that opens the studio in a browser."""

from __future__ import annotations

from pathlib import Path

import click

from fab.cli.console import answers, say
from fab.cli.options import ALLOW_CODE
from fab.errors import InvalidFile, InvalidJob
from fab.files import require_file

__all__ = ["studio"]


@click.command()
@click.argument("file", required=False, type=click.Path(path_type=Path))
@click.option(
    "--port",
    default=8765,
    show_default=True,
    type=click.IntRange(1024, 65535),
    help="Where it listens; the next free one where that is taken.",
)
@click.option("--no-browser", is_flag=True, help="Print the address; open nothing.")
@ALLOW_CODE
def studio(file: Path | None, port: int, no_browser: bool, allow_code: bool) -> None:
    """Change a job in the browser and see its sheet: a job file, a pattern, or a template.

    It reads and writes in the folder of FILE, or where it is started, and listens on this machine
    alone.
    """
    with answers() as interrupts:
        import webbrowser

        from fab.studio.serving import serve

        if file is not None:
            refusal = InvalidJob if file.suffix == ".toml" else InvalidFile
            require_file(file, refusal, "Check the path.")
            file = file.resolve()
        folder = Path.cwd() if file is None else file.parent
        show = None if no_browser else webbrowser.open
        try:
            interrupts.check()
            serve(
                folder,
                file,
                port=port,
                allow_code=allow_code,
                tell=say,
                show=show,
                ended=lambda: bool(interrupts.came),
            )
            interrupts.check()
        except KeyboardInterrupt:
            say("studio: ended")
