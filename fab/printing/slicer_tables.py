"""Tables of parts and extruders that slicers keep in 3MF files, beside what the standard has.

PrusaSlicer's table divides the triangles of a mesh into volumes. That of Bambu Studio and
OrcaSlicer names the components of an object, each a mesh of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

from fab.printing.print_objects import Part, PrintObject

__all__ = [
    "BAMBU_TABLE",
    "PRUSA_PAUSES",
    "PRUSA_TABLE",
    "bambu_table",
    "prusa_pauses",
    "prusa_table",
]

PRUSA_TABLE = "Metadata/Slic3r_PE_model.config"
PRUSA_PAUSES = "Metadata/Prusa_Slicer_custom_gcode_per_print_z.xml"
BAMBU_TABLE = "Metadata/model_settings.config"

_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def prusa_table(meshes: Sequence[tuple[int, str, Sequence[Part]]]) -> str:
    """PrusaSlicer's table of the volumes of all meshes.

    meshes : for each its number in the model, its name, and the parts of which it has the triangles
    one after another.
    """
    lines = [f"{_HEAD}<config>"]
    for number, name, parts in meshes:
        lines.append(f'<object id="{number}" instances_count="1">')
        lines.append(f'<metadata type="object" key="name" value={quoteattr(name)}/>')
        first = 0
        for part in parts:
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


def prusa_pauses(before_mm: Sequence[float]) -> str:
    """PrusaSlicer's table of pauses. before_mm : heights of the layers that they come before."""
    codes = "".join(
        f'<code print_z="{z:g}" type="1" extruder="1" color="" extra="" gcode="M601"/>\n'
        for z in before_mm
    )
    mode = '<mode value="SingleExtruder"/>'
    return f"{_HEAD}<custom_gcodes_per_print_z>\n{codes}{mode}\n</custom_gcodes_per_print_z>\n"


def bambu_table(objects: Sequence[tuple[int, PrintObject, Sequence[int]]]) -> str:
    """The table of Bambu Studio and OrcaSlicer.

    objects : for each its number in the model, and those of its components, in the order of its
    parts.
    """
    lines = [f"{_HEAD}<config>"]
    for number, each, components in objects:
        lines.append(f'<object id="{number}">')
        lines += _entries(each.name, each.parts[0].extruder)
        for component, part in zip(components, each.parts, strict=True):
            lines.append(f'<part id="{component}" subtype="normal_part">')
            lines += [*_entries(part.name, part.extruder), "</part>"]
        lines.append("</object>")
    return "\n".join([*lines, "</config>\n"])


def _entries(name: str, extruder: int) -> list[str]:
    return [
        f'<metadata key="name" value={quoteattr(name)}/>',
        f'<metadata key="extruder" value="{extruder}"/>',
    ]
