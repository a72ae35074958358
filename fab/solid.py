"""How do panels and hinges become meshes and CAD solids: STL, 3MF and STEP?"""

from __future__ import annotations

import io
import itertools
import re
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias
from xml.sax.saxutils import quoteattr

import numpy as np

from fab.hinges import Webs
from fab.panels import Panels, Prisms
from fab.polygons import next_corner
from solver.vectors import FloatArray, IntArray

if TYPE_CHECKING:
    from build123d import Compound, Solid

__all__ = [
    "TriangleMesh",
    "assembly",
    "joined_mesh",
    "prism_meshes",
    "step_bytes",
    "stl_bytes",
    "threemf_bytes",
]

Colour: TypeAlias = tuple[float, float, float]

_PANEL_COLOUR: Colour = (0.85, 0.82, 0.75)
_HINGE_COLOURS: dict[str, Colour] = {
    "M": (0.85, 0.2, 0.2),
    "V": (0.2, 0.35, 0.85),
    "F": (0.5, 0.5, 0.5),
}


@dataclass(frozen=True)
class TriangleMesh:
    """A closed surface: vertices (nv, 3) in mm, triangles (nt, 3) seen from outside."""

    vertices_coords: FloatArray
    triangles: IntArray


def prism_meshes(prisms: Prisms) -> list[TriangleMesh]:
    """One closed mesh for each prism."""
    out: list[TriangleMesh] = [None] * len(prisms)  # type: ignore[list-item]
    sizes = np.diff(prisms.offsets)
    for n in np.unique(sizes).tolist():
        members = np.flatnonzero(sizes == n)
        rows = prisms.offsets[members][:, None] + np.arange(n)
        bottom, top = prisms.bottom[rows], prisms.top[rows]
        low, high = cap_triangles(bottom), cap_triangles(top)
        i = np.arange(n)
        j = (i + 1) % n
        sides = np.concatenate([np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])])
        for place, member in enumerate(members.tolist()):
            height = prisms.heights_mm[member]
            vertices = np.zeros((2 * n, 3))
            vertices[:n, :2] = bottom[place]
            vertices[n:, :2] = top[place]
            vertices[n:, 2] = height
            faces = np.concatenate([low[place][:, ::-1], high[place] + n, sides])
            out[member] = TriangleMesh(vertices, faces)
    return out


def cap_triangles(rings: FloatArray) -> IntArray:
    """Triangles of simple counterclockwise polygons, shape (k, n, 2) -> (k, n - 2, 3).

    A fan from the corner that gives its thinnest triangle most area: right for every convex
    polygon and every quad. Other polygons are cut into ears by manifold3d.
    """
    count, n = rings.shape[:2]
    corners = np.arange(n)
    fans = np.stack(
        [
            np.column_stack([np.full(n - 2, s), (s + k) % n, (s + k + 1) % n])
            for s in corners
            for k in [np.arange(1, n - 1)]
        ]
    )
    points = rings[:, fans]
    one, two = points[..., 1, :] - points[..., 0, :], points[..., 2, :] - points[..., 0, :]
    thinnest = (one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]).min(axis=2)
    best = thinnest.argmax(axis=1)
    out: IntArray = fans[best]
    for row in np.flatnonzero(thinnest[np.arange(count), best] <= 0).tolist():
        from manifold3d import triangulate

        out[row] = triangulate([rings[row]])
    return out


def joined_mesh(panels: Panels, webs: Webs) -> TriangleMesh:
    """All panels and webs as one closed surface, in the flat state, ready to print.

    Built directly, without boolean operations: each web's four end corners are vertices of the
    panels' walls, so the surfaces meet exactly, and stay closed when rounded to single precision.
    Panels without a web are bodies of their own. Faces must be star-shaped seen from their hub
    (all convex polygons and all quads are).
    """
    prisms = panels.prisms
    total = len(prisms.bottom)
    count = len(prisms)
    following = next_corner(prisms.offsets)
    owner = np.repeat(np.arange(count), np.diff(prisms.offsets))
    height = prisms.heights_mm[owner]
    hubs = _hubs(prisms)

    def at(points: FloatArray, z: FloatArray | float) -> FloatArray:
        return np.column_stack([points, np.broadcast_to(z, len(points))])

    web_bottom = webs.prisms.bottom.reshape(-1, 4, 2)
    web_top = webs.prisms.top.reshape(-1, 4, 2)
    web_height = np.repeat(webs.prisms.heights_mm, 4)
    # vertex numbers: panel corners below and above, hubs below and above, webs below and above
    vertices = np.concatenate(
        [
            at(prisms.bottom, 0.0),
            at(prisms.top, height),
            at(hubs[0], 0.0),
            at(hubs[1], prisms.heights_mm),
            at(web_bottom.reshape(-1, 2), 0.0),
            at(web_top.reshape(-1, 2), web_height),
        ]
    )
    low, high = np.arange(total), np.arange(total) + total
    hub_low, hub_high = 2 * total + owner, 2 * total + count + owner
    web = 2 * total + 2 * count + np.arange(4 * len(webs.prisms)).reshape(-1, 4)
    over = web + 4 * len(webs.prisms)

    # sides with a web: in the direction of the side, corners p then q touch the web
    side = np.concatenate([webs.sides[:, 0], webs.sides[:, 1]])
    p, q = np.concatenate([web[:, 1], web[:, 3]]), np.concatenate([web[:, 0], web[:, 2]])
    p_up, q_up = np.concatenate([over[:, 1], over[:, 3]]), np.concatenate([over[:, 0], over[:, 2]])
    plain = np.ones(total, bool)
    plain[side] = False
    a, b = low[plain], low[following[plain]]
    a_up, b_up = high[plain], high[following[plain]]
    wa, wb = low[side], low[following[side]]
    wa_up, wb_up = high[side], high[following[side]]

    parts = [
        # top and bottom: fans around the hubs; the bottom passes the webs' corners
        (high, high[following], hub_high),
        (b, a, hub_low[plain]),
        (p, wa, hub_low[side]),
        (q, p, hub_low[side]),
        (wb, q, hub_low[side]),
        # walls without a web, and walls around the place where a web touches
        (a, b, b_up),
        (a, b_up, a_up),
        (wa, p, p_up),
        (wa, p_up, wa_up),
        (wa_up, p_up, q_up),
        (wa_up, q_up, wb_up),
        (wb_up, q_up, wb),
        (q_up, q, wb),
        # webs: above, below, and both ends
        (over[:, 0], over[:, 1], over[:, 2]),
        (over[:, 0], over[:, 2], over[:, 3]),
        (web[:, 1], web[:, 0], web[:, 3]),
        (web[:, 1], web[:, 3], web[:, 2]),
        (web[:, 1], web[:, 2], over[:, 2]),
        (web[:, 1], over[:, 2], over[:, 1]),
        (web[:, 3], web[:, 0], over[:, 0]),
        (web[:, 3], over[:, 0], over[:, 3]),
    ]
    triangles = np.concatenate([np.column_stack(part) for part in parts])
    return TriangleMesh(vertices, triangles.astype(np.int64))


def _hubs(prisms: Prisms) -> tuple[FloatArray, FloatArray]:
    """A point of each bottom and top ring from which all its corners are seen."""
    sizes = np.diff(prisms.offsets)
    hubs = []
    for ring in (prisms.bottom, prisms.top):
        hub = np.empty((len(prisms), 2))
        for n in np.unique(sizes).tolist():
            members = np.flatnonzero(sizes == n)
            corners = ring[prisms.offsets[members][:, None] + np.arange(n)]
            hub[members] = corners.mean(axis=1)
            if n == 4:
                # the middle of the inner diagonal sees all corners, also where one is reflex
                rows = np.arange(len(members))
                fan = cap_triangles(corners)
                hub[members] = (corners[rows, fan[:, 0, 0]] + corners[rows, fan[:, 0, 2]]) / 2
        hubs.append(hub)
    return hubs[0], hubs[1]


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
    text = re.sub(
        r"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\(')\d+(')",
        lambda match: f"{match[1]}{next(uses)}{match[2]}",
        stream.getvalue().decode("ascii"),
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
