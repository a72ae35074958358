"""Files of a checked thick sheet: STEP, STL, 3MF, pictures and models, in one or on plates."""

from __future__ import annotations

from collections.abc import Callable, Collection
from enum import StrEnum

from fab.errors import Finding
from fab.geometry.bodies import TriangleMesh, bodies_of
from fab.jobs.checked_sheet import CheckedSheet
from fab.panels.thick_sheet import ThickSheet
from fab.printing.bed_place import UNMOVED, place_on_bed
from fab.printing.pauses import film_pause
from fab.printing.plates import Plates
from fab.printing.print_objects import PrintObject, body_parts, sheet_parts
from fab.printing.stl import body_stls, inspect_stl, stl_bytes
from fab.printing.thick_settings import PrintWith
from fab.printing.threemf import threemf_bytes
from fab.progress import Clock

__all__ = ["ORDINARY", "ThickFormat", "product_files"]


class ThickFormat(StrEnum):
    """The kinds of files of a thick sheet, named by their endings; zip has an STL of each body."""

    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"
    ZIP = "zip"
    GLB = "glb"
    HTML = "html"
    ASSEMBLY = "assembly"


# What is made by default: zips of all bodies and GLB are for other programs.
ORDINARY = (
    ThickFormat.STEP,
    ThickFormat.STL,
    ThickFormat.THREEMF,
    ThickFormat.PNG,
    ThickFormat.HTML,
    ThickFormat.ASSEMBLY,
)


def product_files(
    checked: CheckedSheet,
    plates: Plates | None,
    name: str,
    formats: Collection[ThickFormat],
    clock: Clock,
    print_with: PrintWith,
    *,
    upright: bool,
) -> tuple[dict[str, bytes], list[Finding]]:
    """The files of a sheet, in one or on plates, by what follows the name; findings about them."""
    from fab.panels.step import step_bytes

    sheet = checked.sheet if plates is None else plates.sheet
    surfaces: dict[str, TriangleMesh] = {}
    if ThickFormat.STL in formats:
        surfaces = {".stl": checked.joined} if plates is None else _plate_surfaces(plates)

    def objects() -> dict[str, bytes]:
        if plates is None:
            prints = {".3mf": [_whole_object(checked.sheet, name, print_with)]}
        else:
            prints = _plate_objects(plates, print_with)
        slicer, printer = print_with.slicer, print_with.printer
        pause = None if printer is None else film_pause(checked.sheet, printer.layer_mm)
        pauses = () if pause is None else (pause.next_mm,)
        return {end: threemf_bytes(each, name, slicer, pauses) for end, each in prints.items()}

    def picture() -> dict[str, bytes]:
        from fab.viewing.scene_builders import thick_scene
        from fab.viewing.thick_picture import thick_png_bytes

        states = checked.states[: checked.checked]
        scene = thick_scene(sheet, states, name, upright=upright)
        return {".png": thick_png_bytes(scene, plates)}

    def model() -> dict[str, bytes]:
        from fab.viewing.glb import bodies_glb_bytes
        from fab.viewing.scene_builders import thick_scene

        states = checked.states[: checked.checked]
        return {".glb": bodies_glb_bytes(thick_scene(checked.sheet, states, name, upright=upright))}

    writers: dict[ThickFormat, tuple[str, Callable[[], dict[str, bytes]]]] = {
        ThickFormat.STEP: ("step", lambda: {".step": step_bytes(sheet, name)}),
        ThickFormat.STL: (
            "stl",
            lambda: {end: stl_bytes(surface) for end, surface in surfaces.items()},
        ),
        ThickFormat.THREEMF: ("3mf", objects),
        ThickFormat.ZIP: ("zip", lambda: {"_bodies.zip": body_stls(sheet)}),
        ThickFormat.PNG: ("thick png", picture),
        ThickFormat.GLB: ("thick glb", model),
    }
    data: dict[str, bytes] = {}
    for kind, (stage, write) in writers.items():
        if kind in formats:
            with clock.stage(stage):
                data |= write()
    return data, [finding for surface in surfaces.values() for finding in inspect_stl(surface)]


def _plate_surfaces(plates: Plates) -> dict[str, TriangleMesh]:
    """All parts of each plate as one surface."""
    out = {}
    for plate in range(plates.count):
        parts = [part.mesh for part in plates.parts if part.plate == plate]
        every = bodies_of(parts)
        out[f"_plate_{plate + 1}.stl"] = TriangleMesh(
            every.vertices_coords, every.triangles, every.triangles_plane
        )
    return out


def _whole_object(sheet: ThickSheet, name: str, print_with: PrintWith) -> PrintObject:
    """The sheet in one, in the middle of the bed of its printer, where that is known."""
    place, printer = UNMOVED, print_with.printer
    if printer is not None:
        points = sheet.bodies.vertices_coords[:, :2]
        place = place_on_bed(points, printer.bed_mm, printer.room_mm)
    return PrintObject(name, tuple(sheet_parts(sheet, *_material_names(print_with))), place)


def _material_names(print_with: PrintWith) -> tuple[str | None, str | None]:
    panels, hinges = print_with.panels, print_with.hinges
    return (
        None if panels is None else panels.description,
        None if hinges is None else hinges.description,
    )


def _plate_objects(plates: Plates, print_with: PrintWith) -> dict[str, list[PrintObject]]:
    """All parts of each plate, each an object of its own."""
    sheet = plates.sheet
    out: dict[str, list[PrintObject]] = {}
    for part in sorted(plates.parts, key=lambda part: part.plate):
        flexible, creases = sheet.flexible[part.numbers], sheet.creases[part.numbers]
        named = _material_names(print_with)
        parts = tuple(body_parts(plates.bodies(part), flexible, creases, *named))
        out.setdefault(f"_plate_{part.plate + 1}.3mf", []).append(PrintObject(part.name, parts))
    return out
