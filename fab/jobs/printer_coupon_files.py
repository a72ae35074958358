"""Files of the test print of a printer: STL, 3MF, and the report that says how to read it."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from enum import StrEnum
from typing import Any

from fab.outputs import Made, box_mm, plain_title, with_report
from fab.printing.bed_place import place_on_bed
from fab.printing.print_objects import Part, PrintObject
from fab.printing.printer_coupon import printer_coupon
from fab.printing.printers import Printer, PrintMaterial
from fab.printing.stl import inspect_stl, stl_bytes
from fab.printing.threemf import threemf_bytes

__all__ = ["CouponFormat", "make_printer_coupon"]


class CouponFormat(StrEnum):
    """The kinds of files of a test print, named by their endings."""

    STL = "stl"
    THREEMF = "3mf"


def make_printer_coupon(
    printer: Printer,
    material: PrintMaterial | None,
    name: str,
    formats: Collection[CouponFormat] = tuple(CouponFormat),
) -> Made:
    """The test print of a printer, and of a material where it is known.

    The report, NAME_report.json, has what is tried and how it is read.

    Raises `InvalidValue` where the print does not fit the bed.
    """
    name = plain_title(name)
    coupon = printer_coupon(printer, material)
    files: dict[str, bytes] = {}
    if CouponFormat.STL in formats:
        files[f"{name}.stl"] = stl_bytes(coupon.mesh)
    if CouponFormat.THREEMF in formats:
        place = place_on_bed(coupon.mesh.vertices_coords[:, :2], printer.bed_mm, printer.room_mm)
        named = None if material is None else material.description
        part = Part("test print", coupon.mesh, 1, material=named)
        files[f"{name}.3mf"] = threemf_bytes(
            [PrintObject(name, (part,), place)], name, printer.slicer
        )
    report: dict[str, Any] = {
        "name": name,
        "printer": printer.model_dump(mode="json"),
        "material": None if material is None else material.model_dump(mode="json"),
        "how_to_read": list(coupon.reading),
        "gaps": [dataclasses.asdict(each) for each in coupon.gaps],
        "webs": [dataclasses.asdict(each) for each in coupon.webs],
        "knuckles": {"play_mm": coupon.play_mm},
        "bounding_box_mm": {"print": box_mm(coupon.mesh.vertices_coords)},
    }
    findings = (*coupon.findings, *inspect_stl(coupon.mesh))
    return with_report(files, f"{name}_report.json", report, findings)
