"""How is the command line reached, also when it is interrupted while it loads?"""

import signal
import sys

__all__ = ["run"]


def run() -> None:
    """Run `quadfold`; Ctrl-C during start-up ends with exit code 130, once all is loaded.

    Libraries turn an interrupt while they load into errors of their own.
    """
    came: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    from fab.cli.group import main

    signal.signal(signal.SIGINT, before)
    if came:
        sys.exit(130)
    main(prog_name="quadfold")


if __name__ == "__main__":
    run()
