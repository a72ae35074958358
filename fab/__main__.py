"""How is the command line reached, also when it is interrupted while it loads?"""

import sys

__all__ = ["run"]


def run() -> None:
    """Run `quadfold`; Ctrl-C during start-up ends with exit code 130."""
    try:
        from fab.cli import main
    except KeyboardInterrupt:
        sys.exit(130)
    main(prog_name="quadfold")


if __name__ == "__main__":
    run()
