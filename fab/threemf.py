"""How do bodies of one or two materials become one object in a 3MF file?

The object is one mesh. Its triangles name their material as the core specification has it, and
PrusaSlicer's own table says which run of them is which volume, of what name, for which extruder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np

from fab.bodies import Bodies, TriangleMesh
from fab.body_colours import FILM, HINGE, PANEL, Rgb
from fab.package import zip_bytes
from fab.thick import ThickSheet
from solver.errors import InvalidValue
from solver.vectors import IntArray

__all__ = ["Part", "sheet_parts", "threemf_bytes"]

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


@dataclass(frozen=True)
class Part:
    """What is printed of one material: its name, its surface, the number of its extruder from 1."""

    name: str
    mesh: TriangleMesh
    extruder: int
    colour: Rgb = PANEL


def sheet_parts(sheet: ThickSheet) -> list[Part]:
    """The rigid bodies of a sheet for the first extruder, and the flexible ones for the second.

    Bodies of both touch each other and do not overlap. They stand on z = 0.
    """
    ground = sheet.bodies.vertices_coords[:, 2].min(initial=0.0)
    parts = []
    hinged = bool((sheet.creases[sheet.flexible] >= 0).any())
    soft = ("hinges", HINGE["V"]) if hinged else ("film", FILM)
    for extruder, chosen, (name, colour) in (
        (1, ~sheet.flexible, ("panels", PANEL)),
        (2, sheet.flexible, soft),
    ):
        if chosen.any():
            surface = _surface(sheet.bodies.chosen(np.flatnonzero(chosen)), float(ground))
            parts.append(Part(name, surface, extruder, colour))
    return parts


def _surface(bodies: Bodies, ground_mm: float) -> TriangleMesh:
    coords = bodies.vertices_coords - np.array([0.0, 0.0, ground_mm])
    return TriangleMesh(coords, bodies.triangles, bodies.triangles_plane)


def threemf_bytes(parts: Sequence[Part], name: str) -> bytes:
    """3MF package with one object, in millimetres; no dates, so the same parts give the same bytes.

    Coordinates are rounded to 1e-6 mm; vertices keep their own places, so surfaces stay closed.

    Raises `InvalidValue` without a triangle.
    """
    ends = np.cumsum([0, *(len(part.mesh.triangles) for part in parts)])
    if not ends[-1]:
        raise InvalidValue("parts", len(parts), "have triangles", "Give a sheet with panels.")
    return zip_bytes(
        {
            "[Content_Types].xml": _TYPES.encode(),
            "_rels/.rels": _RELATIONS.encode(),
            "3D/3dmodel.model": _model(parts, name).encode(),
            "Metadata/Slic3r_PE_model.config": _volumes(parts, name, ends).encode(),
        }
    )


def _model(parts: Sequence[Part], name: str) -> str:
    title = quoteattr(name)
    bases = "".join(
        f"<base name={quoteattr(part.name)} displaycolor="
        f'"#{"".join(f"{round(255 * x):02X}" for x in part.colour)}"/>'
        for part in parts
    )
    pieces = [
        f'{_HEAD}<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">\n'
        f'<metadata name="Title">{title[1:-1]}</metadata>\n'
        f'<resources><basematerials id="1">{bases}</basematerials>\n'
        f'<object id="2" type="model" name={title} pid="1" pindex="0"><mesh>\n<vertices>'
    ]
    for part in parts:
        rows = part.mesh.vertices_coords
        pieces.append('<vertex x="%.6f" y="%.6f" z="%.6f"/>' * len(rows) % tuple(rows.flat))
    pieces.append("</vertices>\n<triangles>")
    first = 0
    for number, part in enumerate(parts):
        corners: IntArray = part.mesh.triangles + first
        # the first material is the object's own
        material = f' pid="1" p1="{number}"' if number else ""
        text = f'<triangle v1="%d" v2="%d" v3="%d"{material}/>'
        pieces.append(text * len(corners) % tuple(corners.flat))
        first += len(part.mesh.vertices_coords)
    pieces.append(
        "</triangles>\n</mesh></object></resources>\n"
        '<build><item objectid="2"/></build>\n</model>\n'
    )
    return "".join(pieces)


def _volumes(parts: Sequence[Part], name: str, ends: IntArray) -> str:
    """PrusaSlicer's table of the volumes of the object."""
    lines = [f'{_HEAD}<config>\n<object id="2" instances_count="1">']
    lines.append(f'<metadata type="object" key="name" value={quoteattr(name)}/>')
    for part, first, end in zip(parts, ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        lines.append(f'<volume firstid="{first}" lastid="{end - 1}">')
        for key, value in (
            ("name", part.name),
            ("volume_type", "ModelPart"),
            ("extruder", str(part.extruder)),
        ):
            lines.append(f'<metadata type="volume" key="{key}" value={quoteattr(value)}/>')
        lines.append("</volume>")
    return "\n".join([*lines, "</object>\n</config>\n"])
