"""3MF files of bodies of one or two materials.

An object is one mesh. Its triangles name their material as the core specification has it, and
PrusaSlicer's own table has the triangles, name and extruder of each volume.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np

from fab.geometry.bodies import Bodies, TriangleMesh
from fab.outputs import zip_bytes
from fab.panels.body_colours import FILM, HINGE, PANEL, Rgb
from fab.panels.thick_sheet import ThickSheet
from solver.errors import InvalidState
from solver.vectors import BoolArray, IntArray

__all__ = ["Part", "PrintObject", "body_parts", "sheet_parts", "threemf_bytes"]

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_OPC = "http://schemas.openxmlformats.org/package/2006"
_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
_TYPES = (
    f'{_HEAD}<Types xmlns="{_OPC}/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
    '<Default Extension="config" ContentType="text/xml"/></Types>\n'
)
_RELATIONS = (
    f'{_HEAD}<Relationships xmlns="{_OPC}/relationships">'
    '<Relationship Id="rel0" Target="/3D/3dmodel.model" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n'
)


# Numbers of objects; that of the materials is 1.
_FIRST = 2


@dataclass(frozen=True)
class Part:
    """What is printed of one material: its name, its surface, the number of its extruder from 1."""

    name: str
    mesh: TriangleMesh
    extruder: int
    colour: Rgb = PANEL


@dataclass(frozen=True)
class PrintObject:
    """What stays together on the plate: its name, and its parts, which touch each other."""

    name: str
    parts: tuple[Part, ...]


def sheet_parts(sheet: ThickSheet) -> list[Part]:
    """The rigid bodies of a sheet for the first extruder, and the flexible ones for the second.

    Bodies of both touch each other and do not overlap. They stand on z = 0.
    """
    return body_parts(sheet.bodies, sheet.flexible, sheet.creases)


def body_parts(bodies: Bodies, flexible: BoolArray, creases: IntArray) -> list[Part]:
    """The same of any bodies. flexible, creases : shape (n,), as in a `ThickSheet`."""
    ground = bodies.vertices_coords[:, 2].min(initial=0.0)
    parts = []
    hinged = bool((creases[flexible] >= 0).any())
    soft = ("hinges", HINGE["V"]) if hinged else ("film", FILM)
    for extruder, chosen, (name, colour) in (
        (1, ~flexible, ("panels", PANEL)),
        (2, flexible, soft),
    ):
        if chosen.any():
            surface = _surface(bodies.chosen(np.flatnonzero(chosen)), float(ground))
            parts.append(Part(name, surface, extruder, colour))
    return parts


def _surface(bodies: Bodies, ground_mm: float) -> TriangleMesh:
    coords = bodies.vertices_coords - np.array([0.0, 0.0, ground_mm])
    return TriangleMesh(coords, bodies.triangles, bodies.triangles_plane)


def threemf_bytes(objects: Sequence[PrintObject], name: str) -> bytes:
    """3MF package in millimetres; no dates, so the same objects give the same bytes.

    Coordinates are rounded to 1e-6 mm; vertices keep their own places, so surfaces stay closed.

    Raises `InvalidValue` without a triangle.
    """
    if not sum(len(part.mesh.triangles) for each in objects for part in each.parts):
        raise InvalidState("objects", "no object has a triangle", "Give a sheet with panels.")
    return zip_bytes(
        {
            "[Content_Types].xml": _TYPES.encode(),
            "_rels/.rels": _RELATIONS.encode(),
            "3D/3dmodel.model": _model(objects, name).encode(),
            "Metadata/Slic3r_PE_model.config": _volumes(objects).encode(),
        }
    )


def _model(objects: Sequence[PrintObject], name: str) -> str:
    """The XML of the model, with a material for each pair of name and colour."""
    every = [(part.name, part.colour) for each in objects for part in each.parts]
    materials = {material: number for number, material in enumerate(dict.fromkeys(every))}
    bases = "".join(
        f"<base name={quoteattr(title)} displaycolor="
        f'"#{"".join(f"{round(255 * x):02X}" for x in colour)}"/>'
        for title, colour in materials
    )
    pieces = [
        f'{_HEAD}<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">\n'
        f'<metadata name="Title">{quoteattr(name)[1:-1]}</metadata>\n'
        f'<resources><basematerials id="1">{bases}</basematerials>\n'
    ]
    for number, each in enumerate(objects, _FIRST):
        pieces += _object(each, number, materials)
    items = "".join(f'<item objectid="{k}"/>' for k in range(_FIRST, _FIRST + len(objects)))
    return "".join([*pieces, f"</resources>\n<build>{items}</build>\n</model>\n"])


def _object(
    each: PrintObject, number: int, materials: Mapping[tuple[str, Rgb], int]
) -> Iterator[str]:
    numbers = [materials[part.name, part.colour] for part in each.parts]
    yield (
        f'<object id="{number}" type="model" name={quoteattr(each.name)} pid="1" '
        f'pindex="{numbers[0]}"><mesh>\n<vertices>'
    )
    for part in each.parts:
        rows = part.mesh.vertices_coords
        yield '<vertex x="%.6f" y="%.6f" z="%.6f"/>' * len(rows) % tuple(rows.flat)
    yield "</vertices>\n<triangles>"
    first = 0
    for place, part in zip(numbers, each.parts, strict=True):
        corners: IntArray = part.mesh.triangles + first
        # the first material is the object's own
        material = f' pid="1" p1="{place}"' if place != numbers[0] else ""
        text = f'<triangle v1="%d" v2="%d" v3="%d"{material}/>'
        yield text * len(corners) % tuple(corners.flat)
        first += len(part.mesh.vertices_coords)
    yield "</triangles>\n</mesh></object>\n"


def _volumes(objects: Sequence[PrintObject]) -> str:
    """PrusaSlicer's table of the volumes of all objects."""
    lines = [f"{_HEAD}<config>"]
    for number, each in enumerate(objects, _FIRST):
        lines.append(f'<object id="{number}" instances_count="1">')
        lines.append(f'<metadata type="object" key="name" value={quoteattr(each.name)}/>')
        first = 0
        for part in each.parts:
            end = first + len(part.mesh.triangles)
            lines.append(f'<volume firstid="{first}" lastid="{end - 1}">')
            first = end
            for key, value in (
                ("name", part.name),
                ("volume_type", "ModelPart"),
                ("extruder", str(part.extruder)),
            ):
                lines.append(f'<metadata type="volume" key="{key}" value={quoteattr(value)}/>')
            lines.append("</volume>")
        lines.append("</object>")
    return "\n".join([*lines, "</config>\n"])
