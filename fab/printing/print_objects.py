"""Objects for slicers: what stays together on the plate, in parts of one material each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.geometry.bodies import Bodies, TriangleMesh
from fab.panels.body_colours import FILM, HINGE, PANEL, Rgb
from fab.panels.thick_sheet import ThickSheet
from fab.printing.bed_place import UNMOVED, BedPlace
from solver.vectors import BoolArray, IntArray

__all__ = ["Part", "PrintObject", "body_parts", "sheet_parts"]


@dataclass(frozen=True)
class Part:
    """What is printed of one material: its name, its surface, the number of its extruder from 1.

    material : what it is of, in words; where it is unknown the name of the part is all that is
    written.
    """

    name: str
    mesh: TriangleMesh
    extruder: int
    colour: Rgb = PANEL
    material: str | None = None


@dataclass(frozen=True)
class PrintObject:
    """What stays together on the plate: its name, its parts, which touch each other, its place."""

    name: str
    parts: tuple[Part, ...]
    place: BedPlace = UNMOVED


def sheet_parts(
    sheet: ThickSheet, panel_material: str | None = None, hinge_material: str | None = None
) -> list[Part]:
    """The rigid bodies of a sheet for the first extruder, and the flexible ones for the second.

    Bodies of both touch each other and do not overlap. They stand on z = 0. What is laid into the
    print is left out.
    """
    rows = np.flatnonzero(~sheet.laid)
    return body_parts(
        sheet.bodies.chosen(rows),
        sheet.flexible[rows],
        sheet.creases[rows],
        panel_material,
        hinge_material,
    )


def body_parts(
    bodies: Bodies,
    flexible: BoolArray,
    creases: IntArray,
    panel_material: str | None = None,
    hinge_material: str | None = None,
) -> list[Part]:
    """The same of any bodies. flexible, creases : shape (n,), as in a `ThickSheet`."""
    ground = bodies.vertices_coords[:, 2].min(initial=0.0)
    parts = []
    hinged = bool((creases[flexible] >= 0).any())
    soft = ("hinges", HINGE["V"]) if hinged else ("film", FILM)
    for extruder, chosen, (name, colour), material in (
        (1, ~flexible, ("panels", PANEL), panel_material),
        (2, flexible, soft, hinge_material),
    ):
        if chosen.any():
            surface = _surface(bodies.chosen(np.flatnonzero(chosen)), float(ground))
            parts.append(Part(name, surface, extruder, colour, material))
    return parts


def _surface(bodies: Bodies, ground_mm: float) -> TriangleMesh:
    coords = bodies.vertices_coords - np.array([0.0, 0.0, ground_mm])
    return TriangleMesh(coords, bodies.triangles, bodies.triangles_plane)
