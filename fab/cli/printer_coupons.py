"""The test print of a 3D printer, as the command `coupon` makes it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fab.cli.console import say, tell
from fab.cli.delivery import write_made
from fab.cli.options import formats_of

__all__ = ["write_test_print"]


def write_test_print(printer: str, material: str | None, only: Sequence[str], out: Path) -> None:
    """Write the test print of a printer, and say how to read it.

    printer, material : names, or paths of TOML files. only : as the option of that name.
    """
    from fab.jobs.printer_coupon_files import CouponFormat, make_printer_coupon
    from fab.outputs import require_folder
    from fab.printing.printers import load_print_material, load_printer

    machine = load_printer(printer)
    stock = None if material is None else load_print_material(material)
    formats = formats_of(only, CouponFormat) or tuple(CouponFormat)
    require_folder(out)
    words = [Path(word).name.removesuffix(".toml") for word in (printer, material) if word]
    made = make_printer_coupon(machine, stock, "_".join(["coupon", *words]), formats)
    write_made(made, out)
    for number, sentence in enumerate(made.report["how_to_read"], 1):
        say(f"{number}. {sentence}")
    tell(made.findings)
