"""STEP files of a thick sheet, which CAD programs open with its names and colours."""

from __future__ import annotations

import io
import itertools
import re

from fab.panels.body_colours import Rgb, body_colours
from fab.panels.cad_assembly import placed_solids
from fab.panels.step_strings import escaped, with_tokens
from fab.panels.thick_sheet import ThickSheet
from solver.vectors import FloatArray

__all__ = ["step_bytes"]

_TIMESTAMP = "1980-01-01T00:00:00"


def step_bytes(sheet: ThickSheet, name: str, coords: FloatArray | None = None) -> bytes:
    """STEP AP214 file of the assembly with names and colours, the same bytes for the same solids.

    coords : shape (nv, 3), mm, of the pattern's vertices in a folded state: the rigid bodies alone,
        where that state has them. Without it, all bodies of the flat sheet.

    OpenCASCADE numbers the uses of parts in an assembly by a counter of the running process, and
    writes colours in the order of memory addresses. So uses are numbered from 1, and colours are
    written without it, one style for all solids that share a colour.
    """
    from build123d import Compound, export_step

    made = placed_solids(sheet, coords)
    colours = body_colours(sheet)
    stream = io.BytesIO()
    whole = Compound(label=with_tokens(name), children=list(made.values()))
    export_step(whole, stream, write_pcurves=False, timestamp=_TIMESTAMP)
    uses = itertools.count(1)
    # on one line each: where OpenCASCADE breaks them depends on the length of its number
    text = re.sub(
        r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\(\s*'\d+'(.*?);\n",
        lambda match: (
            f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{next(uses)}'"
            + re.sub(r"\n\s*", "", match[1])
            + ";\n"
        ),
        stream.getvalue().decode("ascii"),
        flags=re.DOTALL,
    )
    body, end, tail = text.rpartition("ENDSEC;")
    styles = _styles(body, [colours[i] for i in made])
    return escaped("".join([body, styles, end, tail])).encode("ascii")


def _styles(body: str, colours: list[Rgb]) -> str:
    """Entities that colour the solids of a STEP file, in the order of the file."""
    solids = re.findall(r"^#(\d+) = MANIFOLD_SOLID_BREP\(", body, re.MULTILINE)
    context = re.search(r"^#(\d+) = \( GEOMETRIC_REPRESENTATION_CONTEXT\(3\)", body, re.MULTILINE)
    if context is None or len(solids) != len(colours):
        raise RuntimeError(f"STEP file with {len(solids)} solids for {len(colours)} colours")
    last = body.rindex("\n#") + 2
    number = itertools.count(int(body[last : body.index(" ", last)]) + 1)
    lines: list[str] = []

    def entity(text: str) -> str:
        lines.append(f"#{next(number)} = {text};\n")
        return lines[-1].partition(" ")[0]

    styles: dict[Rgb, str] = {}
    items = []
    for solid, colour in zip(solids, colours, strict=True):
        if colour not in styles:
            rgb = entity("COLOUR_RGB('',%.6f,%.6f,%.6f)" % colour)
            fill = entity(f"FILL_AREA_STYLE_COLOUR('',{rgb})")
            area = entity(f"FILL_AREA_STYLE('',({fill}))")
            side = entity(f"SURFACE_STYLE_FILL_AREA({area})")
            sides = entity(f"SURFACE_SIDE_STYLE('',({side}))")
            usage = entity(f"SURFACE_STYLE_USAGE(.BOTH.,{sides})")
            styles[colour] = entity(f"PRESENTATION_STYLE_ASSIGNMENT(({usage}))")
        items.append(entity(f"STYLED_ITEM('color',({styles[colour]}),#{solid})"))
    entity(
        "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',("
        + ",".join(items)
        + f"),#{context[1]})"
    )
    return "".join(lines)
