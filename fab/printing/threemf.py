"""3MF files of bodies of one or two materials, laid out for the slicer that reads them.

All have the materials of the core specification. No layout keeps the parts of an object together in
every slicer:

- "prusa": an object is one mesh, and PrusaSlicer's table divides its triangles into volumes.
  PrusaSlicer takes the components of an object for objects of their own, which it arranges apart.
  Bambu Studio and OrcaSlicer open this layout as well where the model's metadata names
  PrusaSlicer.
- "bambu": an object has a component for each part, a mesh of its own, as the standard describes it
  and as Bambu Studio and OrcaSlicer write it, with their table.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias
from xml.sax.saxutils import quoteattr

import numpy as np

from fab.outputs import zip_bytes
from fab.panels.body_colours import Rgb
from fab.printing.bed_place import BedPlace
from fab.printing.print_objects import Part, PrintObject
from fab.printing.printers import Slicer
from fab.printing.slicer_tables import (
    BAMBU_TABLE,
    PRUSA_PAUSES,
    PRUSA_TABLE,
    bambu_table,
    prusa_pauses,
    prusa_table,
)
from solver.errors import InvalidState
from solver.vectors import IntArray

__all__ = ["threemf_bytes"]

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_OPC = "http://schemas.openxmlformats.org/package/2006"
_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
_TYPES = (
    f'{_HEAD}<Types xmlns="{_OPC}/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
    '<Default Extension="config" ContentType="text/xml"/>{}</Types>\n'
)
# Of the table of pauses.
_XML = '<Default Extension="xml" ContentType="text/xml"/>'
_RELATIONS = (
    f'{_HEAD}<Relationships xmlns="{_OPC}/relationships">'
    '<Relationship Id="rel0" Target="/3D/3dmodel.model" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n'
)
# Bambu Studio and OrcaSlicer read PrusaSlicer's table only where this names PrusaSlicer.
_APPLICATIONS: dict[Slicer, str] = {
    "prusa": "quadfold, with volumes as in PrusaSlicer",
    "bambu": "quadfold",
}

# Numbers of objects; that of the materials is 1.
_FIRST = 2

_Materials: TypeAlias = Mapping[tuple[str, Rgb], int]


def threemf_bytes(
    objects: Sequence[PrintObject],
    name: str,
    slicer: Slicer = "prusa",
    pauses_mm: Sequence[float] = (),
) -> bytes:
    """3MF package in millimetres; no dates, so the same objects give the same bytes.

    pauses_mm : heights of the layers before which the print pauses, for PrusaSlicer.

    Coordinates are rounded to 1e-6 mm; vertices keep their own places, so surfaces stay closed.

    Raises `InvalidState` without a triangle.
    """
    if not sum(len(part.mesh.triangles) for each in objects for part in each.parts):
        raise InvalidState("objects", "no object has a triangle", "Give a sheet with panels.")
    every = [_material(part) for each in objects for part in each.parts]
    materials = {material: number for number, material in enumerate(dict.fromkeys(every))}
    lay_out = _volumes if slicer == "prusa" else _components
    model, built, tables = lay_out(objects, materials)
    if pauses_mm:
        tables[PRUSA_PAUSES] = prusa_pauses(pauses_mm)
    text = "".join([_opening(name, _APPLICATIONS[slicer], materials), *model, _build(built)])
    return zip_bytes(
        {
            "[Content_Types].xml": _TYPES.format(_XML if pauses_mm else "").encode(),
            "_rels/.rels": _RELATIONS.encode(),
            "3D/3dmodel.model": text.encode(),
            **{path: table.encode() for path, table in tables.items()},
        }
    )


def _material(part: Part) -> tuple[str, Rgb]:
    named = part.name if part.material is None else f"{part.name}: {part.material}"
    return named, part.colour


_Laid: TypeAlias = tuple[list[str], list[tuple[int, BedPlace]], dict[str, str]]


def _volumes(objects: Sequence[PrintObject], materials: _Materials) -> _Laid:
    """One mesh for each object: its XML, what is built where, and the tables of slicers.

    Objects are where they lie on the bed: of one that its item moves, PrusaSlicer moves the first
    volume alone.
    """
    numbered = list(enumerate(map(_on_bed, objects), _FIRST))
    model = [
        text
        for number, each in numbered
        for text in _mesh(number, each.name, each.parts, materials)
    ]
    table = prusa_table([(number, each.name, each.parts) for number, each in numbered])
    return model, [(number, each.place) for number, each in numbered], {PRUSA_TABLE: table}


def _on_bed(each: PrintObject) -> PrintObject:
    """An object whose own coordinates are those of its place."""
    parts = []
    for part in each.parts:
        coords = part.mesh.vertices_coords
        flat = each.place.moved(coords[:, :2])
        mesh = replace(part.mesh, vertices_coords=np.column_stack([flat, coords[:, 2]]))
        parts.append(replace(part, mesh=mesh))
    return PrintObject(each.name, tuple(parts))


def _components(objects: Sequence[PrintObject], materials: _Materials) -> _Laid:
    """The same with a mesh for each part, and an object of components for each object."""
    model: list[str] = []
    meshes: list[tuple[int, str, Sequence[Part]]] = []
    wholes: list[tuple[int, PrintObject, Sequence[int]]] = []
    number = _FIRST
    for each in objects:
        numbers = range(number, number + len(each.parts))
        number = numbers.stop + 1
        for own, part in zip(numbers, each.parts, strict=True):
            model += _mesh(own, part.name, [part], materials)
            meshes.append((own, part.name, [part]))
        listed = "".join(f'<component objectid="{own}"/>' for own in numbers)
        model.append(
            f'<object id="{numbers.stop}" type="model" name={quoteattr(each.name)}>'
            f"<components>{listed}</components></object>\n"
        )
        wholes.append((numbers.stop, each, numbers))
    tables = {PRUSA_TABLE: prusa_table(meshes), BAMBU_TABLE: bambu_table(wholes)}
    return model, [(own, each.place) for own, each, _ in wholes], tables


def _opening(name: str, application: str, materials: _Materials) -> str:
    bases = "".join(
        f"<base name={quoteattr(title)} displaycolor="
        f'"#{"".join(f"{round(255 * x):02X}" for x in colour)}"/>'
        for title, colour in materials
    )
    return (
        f'{_HEAD}<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">\n'
        f'<metadata name="Title">{quoteattr(name)[1:-1]}</metadata>\n'
        f'<metadata name="Application">{application}</metadata>\n'
        f'<resources><basematerials id="1">{bases}</basematerials>\n'
    )


def _build(built: Sequence[tuple[int, BedPlace]]) -> str:
    items = "".join(f'<item objectid="{own}"{_transform(place)}/>' for own, place in built)
    return f"</resources>\n<build>{items}</build>\n</model>\n"


def _transform(place: BedPlace) -> str:
    """The attribute that moves an item: the rows of its matrix, which stands to the right."""
    if place == BedPlace():
        return ""
    (x, y), (sine, cosine) = place.shift_mm, _sine_cosine(place.turn_deg)
    rows = [cosine, sine, 0, -sine, cosine, 0, 0, 0, 1, x, y, 0]
    return f' transform="{" ".join(f"{round(value, 9) + 0.0:.9g}" for value in rows)}"'


def _sine_cosine(turn_deg: float) -> tuple[float, float]:
    turn = float(np.radians(turn_deg))
    return float(np.sin(turn)), float(np.cos(turn))


def _mesh(number: int, name: str, parts: Sequence[Part], materials: _Materials) -> Iterator[str]:
    """An object whose mesh is that of some parts, one after another."""
    numbers = [materials[_material(part)] for part in parts]
    yield (
        f'<object id="{number}" type="model" name={quoteattr(name)} pid="1" '
        f'pindex="{numbers[0]}"><mesh>\n<vertices>'
    )
    for part in parts:
        rows = part.mesh.vertices_coords
        yield '<vertex x="%.6f" y="%.6f" z="%.6f"/>' * len(rows) % tuple(rows.flat)
    yield "</vertices>\n<triangles>"
    first = 0
    for place, part in zip(numbers, parts, strict=True):
        corners: IntArray = part.mesh.triangles + first
        # the first material is the object's own
        material = f' pid="1" p1="{place}"' if place != numbers[0] else ""
        text = f'<triangle v1="%d" v2="%d" v3="%d"{material}/>'
        yield text * len(corners) % tuple(corners.flat)
        first += len(part.mesh.vertices_coords)
    yield "</triangles>\n</mesh></object>\n"
