"""How do bodies become files for printers and CAD programs: STL, 3MF and STEP?"""

from __future__ import annotations

import io
import itertools
import re
import zipfile
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias
from xml.sax.saxutils import quoteattr

import numpy as np

from fab.bodies import Bodies, TriangleMesh
from fab.thick import ThickSheet
from solver.vectors import FloatArray, cross

if TYPE_CHECKING:
    from build123d import Compound, Solid

__all__ = ["assembly", "side_loops", "step_bytes", "stl_bytes", "threemf_bytes"]

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


def assembly(sheet: ThickSheet, name: str) -> Compound:
    """The bodies of a sheet as named, coloured CAD solids in one build123d compound."""
    from build123d import Color

    compound = _labelled(sheet, name)
    for child, colour in zip(compound.children, _colours(sheet), strict=True):
        child.color = Color(*colour)
    return compound


def _labelled(sheet: ThickSheet, name: str) -> Compound:
    from build123d import Compound

    solids = _solids(sheet.bodies)
    for solid, label in zip(solids, sheet.names, strict=True):
        solid.label = label
    return Compound(label=name, children=solids)


def _colours(sheet: ThickSheet) -> list[Colour]:
    letters = sheet.pattern.edges_assignment
    hinges = zip(sheet.flexible.tolist(), sheet.creases.tolist(), strict=True)
    return [_HINGE_COLOURS[letters[e]] if soft and e >= 0 else _PANEL_COLOUR for soft, e in hinges]


def _solids(bodies: Bodies) -> list[Solid]:
    make = _solid_maker()
    return [make(bodies.mesh(i)) for i in range(len(bodies))]


def side_loops(mesh: TriangleMesh) -> list[list[list[int]]]:
    """The outlines of each planar side of a body: its outer ring and those of holes."""
    sides: dict[int, dict[int, list[int]]] = {}
    half = np.concatenate([mesh.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    plane = np.tile(mesh.triangles_plane, 3)
    inner = set(zip(plane.tolist(), half[:, 1].tolist(), half[:, 0].tolist(), strict=True))
    for p, a, b in zip(plane.tolist(), half[:, 0].tolist(), half[:, 1].tolist(), strict=True):
        if (p, a, b) not in inner:
            sides.setdefault(p, {}).setdefault(a, []).append(b)
    out = []
    for _, following in sorted(sides.items()):
        loops = []
        while following:
            start = at = next(iter(following))
            loop = []
            while True:
                loop.append(at)
                ends = following[at]
                at_next = ends.pop()
                if not ends:
                    del following[at]
                at = at_next
                if at == start:
                    break
            loops.append(loop)
        out.append(loops)
    return out


def _solid_maker() -> Callable[[TriangleMesh], Solid]:
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
    from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Shell, TopoDS_Solid, TopoDS_Wire

    builder = BRep_Builder()

    def make(mesh: TriangleMesh) -> Solid:
        points = mesh.vertices_coords
        corners = [BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex() for p in points.tolist()]
        edges: dict[tuple[int, int], TopoDS_Edge] = {}

        def edge(i: int, j: int) -> TopoDS_Edge:
            if (j, i) in edges:
                return TopoDS.Edge(edges[j, i].Reversed())
            edges[i, j] = BRepBuilderAPI_MakeEdge(corners[i], corners[j]).Edge()
            return edges[i, j]

        def wire(ring: list[int]) -> TopoDS_Wire:
            made = BRepBuilderAPI_MakeWire()
            for i, j in zip(ring, [*ring[1:], ring[0]], strict=True):
                made.Add(edge(i, j))
            return made.Wire()

        shell = TopoDS_Shell()
        builder.MakeShell(shell)
        for rings in side_loops(mesh):
            areas = [_area(points[ring]) for ring in rings]
            outer = int(np.argmax([float(area @ area) for area in areas]))
            place = points[rings[outer]].mean(axis=0)
            plane = gp_Pln(gp_Pnt(*place.tolist()), gp_Dir(*areas[outer].tolist()))
            face = BRepBuilderAPI_MakeFace(plane, wire(rings[outer]), True)
            for number, ring in enumerate(rings):
                if number != outer:
                    face.Add(wire(ring))
            builder.Add(shell, face.Face())
        shell.Closed(True)
        body = TopoDS_Solid()
        builder.MakeSolid(body)
        builder.Add(body, shell)
        return Solid(body)

    return make


def _area(ring: FloatArray) -> FloatArray:
    centred = ring - ring.mean(axis=0)
    return np.asarray(cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0))


def step_bytes(sheet: ThickSheet, name: str) -> bytes:
    """STEP AP214 file of the assembly with names and colours, the same bytes for the same solids.

    OpenCASCADE numbers the uses of parts in an assembly by a counter of the running process, and
    writes colours in the order of memory addresses. So uses are numbered from 1 here, and the
    colours are written by ourselves, one style for all solids that share it.
    """
    from build123d import export_step

    stream = io.BytesIO()
    timestamp = "1980-01-01T00:00:00"
    export_step(_labelled(sheet, name), stream, write_pcurves=False, timestamp=timestamp)
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
    return "".join([body, _step_styles(body, _colours(sheet)), end, tail]).encode()


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
