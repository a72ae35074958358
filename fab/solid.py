"""How do bodies become files for printers and CAD programs: STL, 3MF and STEP?"""

from __future__ import annotations

import io
import itertools
import re
import zipfile
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeAlias
from xml.sax.saxutils import quoteattr

import numpy as np

from fab.bodies import TriangleMesh
from fab.hinges import Webs
from fab.panels import Panels, Prisms
from solver.vectors import FloatArray

if TYPE_CHECKING:
    from build123d import Compound, Solid

__all__ = ["assembly", "step_bytes", "stl_bytes", "threemf_bytes"]

Colour: TypeAlias = tuple[float, float, float]

_PANEL_COLOUR: Colour = (0.85, 0.82, 0.75)
_HINGE_COLOURS: dict[str, Colour] = {
    "M": (0.85, 0.2, 0.2),
    "V": (0.2, 0.35, 0.85),
    "F": (0.5, 0.5, 0.5),
}


def stl_bytes(mesh: TriangleMesh) -> bytes:
    """Binary STL (single precision, as the format has it)."""
    import trimesh

    surface = trimesh.Trimesh(mesh.vertices_coords, mesh.triangles, process=False)
    data: bytes = trimesh.exchange.stl.export_stl(surface)
    return data


def threemf_bytes(mesh: TriangleMesh, name: str) -> bytes:
    """3MF package with one object, in millimetres; no dates, so the same mesh gives the same bytes.

    Coordinates are rounded to 1e-6 mm; vertices keep their own places, so the surface stays closed.
    """
    vertices = "".join(
        '<vertex x="%.6f" y="%.6f" z="%.6f"/>' % tuple(row) for row in mesh.vertices_coords.tolist()
    )
    triangles = "".join(
        '<triangle v1="%d" v2="%d" v3="%d"/>' % tuple(row) for row in mesh.triangles.tolist()
    )
    model = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xml:lang="en-US" '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">\n'
        f'<metadata name="Title">{quoteattr(name)[1:-1]}</metadata>\n'
        f'<resources><object id="1" type="model" name={quoteattr(name)}><mesh>\n'
        f"<vertices>{vertices}</vertices>\n<triangles>{triangles}</triangles>\n"
        "</mesh></object></resources>\n"
        '<build><item objectid="1"/></build>\n</model>\n'
    )
    types = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
        '<Default Extension="rels" '
        'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        '<Default Extension="model" '
        'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>\n'
    )
    relations = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        '<Relationship Id="rel0" Target="/3D/3dmodel.model" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n'
    )
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as package:
        for path, text in (
            ("[Content_Types].xml", types),
            ("_rels/.rels", relations),
            ("3D/3dmodel.model", model),
        ):
            entry = zipfile.ZipInfo(path, date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            package.writestr(entry, text)
    return stream.getvalue()


def assembly(panels: Panels, webs: Webs, assignments: Sequence[str], name: str) -> Compound:
    """The panels and webs as named, coloured CAD solids in one build123d compound.

    assignments : letter of every edge of the pattern. Panel f stands on face f, hinge e on edge e.
    """
    from build123d import Color

    compound = _labelled(panels, webs, name)
    for child, colour in zip(compound.children, _colours(panels, webs, assignments), strict=True):
        child.color = Color(*colour)
    return compound


def _labelled(panels: Panels, webs: Webs, name: str) -> Compound:
    from build123d import Compound

    solids = _solids(panels.prisms) + _solids(webs.prisms)
    labels = [f"panel_{face}" for face in panels.faces] + [f"hinge_{e}" for e in webs.creases]
    for solid, label in zip(solids, labels, strict=True):
        solid.label = label
    return Compound(label=name, children=solids)


def _colours(panels: Panels, webs: Webs, assignments: Sequence[str]) -> list[Colour]:
    hinges = [_HINGE_COLOURS[assignments[edge]] for edge in webs.creases.tolist()]
    return [_PANEL_COLOUR] * len(panels.faces) + hinges


def _solids(prisms: Prisms) -> list[Solid]:
    make = _solid_maker()
    return [
        make(prisms.bottom[prisms.ring(i)], prisms.top[prisms.ring(i)], float(prisms.heights_mm[i]))
        for i in range(len(prisms))
    ]


def _solid_maker() -> Callable[[FloatArray, FloatArray, float], Solid]:
    """A function that makes a boundary representation from shared edges and explicit planes."""
    from build123d import Solid
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakeVertex,
        BRepBuilderAPI_MakeWire,
    )
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
    from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Shell, TopoDS_Solid

    builder = BRep_Builder()

    def make(bottom: FloatArray, top: FloatArray, height: float) -> Solid:
        n = len(bottom)
        points = np.zeros((2 * n, 3))
        points[:n, :2], points[n:, :2], points[n:, 2] = bottom, top, height
        corners = [BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex() for p in points.tolist()]
        edges: dict[tuple[int, int], TopoDS_Edge] = {}

        def edge(i: int, j: int) -> TopoDS_Edge:
            if (j, i) in edges:
                return TopoDS.Edge(edges[j, i].Reversed())
            edges[i, j] = BRepBuilderAPI_MakeEdge(corners[i], corners[j]).Edge()
            return edges[i, j]

        shell = TopoDS_Shell()
        builder.MakeShell(shell)
        rings = [list(range(n))[::-1], list(range(n, 2 * n))]
        rings += [[i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)]
        for ring in rings:
            wire = BRepBuilderAPI_MakeWire()
            for i, j in zip(ring, [*ring[1:], ring[0]], strict=True):
                wire.Add(edge(i, j))
            centred = points[ring] - points[ring].mean(axis=0)
            normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
            plane = gp_Pln(gp_Pnt(*points[ring].mean(axis=0)), gp_Dir(*normal))
            builder.Add(shell, BRepBuilderAPI_MakeFace(plane, wire.Wire(), True).Face())
        shell.Closed(True)
        body = TopoDS_Solid()
        builder.MakeSolid(body)
        builder.Add(body, shell)
        return Solid(body)

    return make


def step_bytes(panels: Panels, webs: Webs, assignments: Sequence[str], name: str) -> bytes:
    """STEP AP214 file of the assembly with names and colours, the same bytes for the same solids.

    OpenCASCADE numbers the uses of parts in an assembly by a counter of the running process, and
    writes colours in the order of memory addresses. So uses are numbered from 1 here, and the
    colours are written by ourselves, one style for all solids that share it.
    """
    from build123d import export_step

    stream = io.BytesIO()
    timestamp = "1980-01-01T00:00:00"
    export_step(_labelled(panels, webs, name), stream, write_pcurves=False, timestamp=timestamp)
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
    return "".join(
        [body, _step_styles(body, _colours(panels, webs, assignments)), end, tail]
    ).encode()


def _step_styles(body: str, colours: list[Colour]) -> str:
    """Entities that colour the solids of a STEP file, in the order of the file."""
    solids = re.findall(r"^#(\d+) = MANIFOLD_SOLID_BREP\(", body, re.MULTILINE)
    context = re.search(r"^#(\d+) = \( GEOMETRIC_REPRESENTATION_CONTEXT\(3\)", body, re.MULTILINE)
    last = re.findall(r"^#(\d+) = ", body, re.MULTILINE)[-1]
    if context is None or len(solids) != len(colours):
        raise RuntimeError(f"STEP file with {len(solids)} solids, {len(colours)} were given")
    number = itertools.count(int(last) + 1)
    lines: list[str] = []

    def entity(text: str) -> str:
        lines.append(f"#{next(number)} = {text};\n")
        return lines[-1].partition(" ")[0]

    styles: dict[Colour, str] = {}
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
