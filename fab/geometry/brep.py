"""Bodies as CAD solids of build123d: planar faces that share their edges."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from fab.geometry.bodies import Bodies
from fab.geometry.side_loops import SideLoops, side_loops
from solver.polygons import next_corner
from solver.vectors import FloatArray, IntArray, norm

if TYPE_CHECKING:
    from build123d import Solid
    from OCP.BRep import BRep_Builder
    from OCP.gp import gp_Pnt
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Wire

__all__ = ["solids"]

# The tolerance of shapes that OpenCASCADE makes itself.
_TOLERANCE_MM = 1e-7


def solids(bodies: Bodies) -> list[Solid]:
    """Each body as a build123d solid with one face for each planar side, an edge for each corner.

    Faces share their edges, and have explicit planes: nothing is left for OpenCASCADE to find out.
    """
    from build123d import Solid
    from OCP.BRep import BRep_Builder
    from OCP.gp import gp_Pnt
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    loops = side_loops(bodies)
    builder = BRep_Builder()
    points = [gp_Pnt(*row) for row in bodies.vertices_coords.tolist()]
    wires = _wires(builder, points, bodies.vertices_coords, loops)
    shells = [TopoDS_Shell() for _ in range(len(bodies))]
    for shell in shells:
        builder.MakeShell(shell)
    faces = _faces(builder, points, loops, wires)
    for face, body in zip(faces, loops.bodies[loops.outer].tolist(), strict=True):
        builder.Add(shells[body], face)
    out = []
    for shell in shells:
        shell.Closed(True)
        body_shape = TopoDS_Solid()
        builder.MakeSolid(body_shape)
        builder.Add(body_shape, shell)
        out.append(Solid(body_shape))
    return out


def _wires(
    builder: BRep_Builder, points: list[gp_Pnt], coords: FloatArray, loops: SideLoops
) -> list[TopoDS_Wire]:
    """A closed wire for each ring; rings that run along the same corners share the edge there."""
    from OCP.TopoDS import TopoDS_Wire

    ends = np.column_stack([loops.corners, loops.corners[next_corner(loops.offsets)]])
    pairs, number = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    edges = _edges(builder, points, coords, pairs)
    backward = (ends[:, 0] > ends[:, 1]).astype(int)
    uses = list(zip(number.ravel().tolist(), backward.tolist(), strict=True))
    wires = []
    for first, last in pairwise(loops.offsets.tolist()):
        wire = TopoDS_Wire()
        builder.MakeWire(wire)
        for edge, reverse in uses[first:last]:
            builder.Add(wire, edges[edge][reverse])
        wire.Closed(True)
        wires.append(wire)
    return wires


def _edges(
    builder: BRep_Builder, points: list[gp_Pnt], coords: FloatArray, pairs: IntArray
) -> list[tuple[TopoDS_Edge, TopoDS_Edge]]:
    """Straight edges between pairs of points, shape (n, 2), each forwards and backwards."""
    from OCP.Geom import Geom_Line
    from OCP.gp import gp_Dir
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Vertex

    vertices = []
    for point in points:
        vertex = TopoDS_Vertex()
        builder.MakeVertex(vertex, point, _TOLERANCE_MM)
        vertices.append((vertex, vertex.Reversed()))
    span = coords[pairs[:, 1]] - coords[pairs[:, 0]]
    length = norm(span)
    edges = []
    directions = (span / length[:, None]).tolist()
    for (a, b), along, end in zip(pairs.tolist(), directions, length.tolist(), strict=True):
        edge = TopoDS_Edge()
        builder.MakeEdge(edge, Geom_Line(points[a], gp_Dir(*along)), _TOLERANCE_MM)
        builder.Add(edge, vertices[a][0])
        builder.Add(edge, vertices[b][1])
        builder.Range(edge, 0.0, end)
        edges.append((edge, edge.Reversed()))
    return edges


def _faces(
    builder: BRep_Builder, points: list[gp_Pnt], loops: SideLoops, wires: list[TopoDS_Wire]
) -> list[TopoDS_Face]:
    """A face for each planar side, with its outer ring and those of its holes."""
    from OCP.Geom import Geom_Plane
    from OCP.gp import gp_Dir
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS_Face

    in_place = TopLoc_Location()
    faces, normals = [], loops.normals.tolist()
    starts = loops.corners[loops.offsets[:-1]].tolist()
    sides = np.flatnonzero(loops.outer)
    for first, last in pairwise([*sides.tolist(), len(loops.outer)]):
        face = TopoDS_Face()
        plane = Geom_Plane(points[starts[first]], gp_Dir(*normals[first]))
        builder.MakeFace(face, plane, in_place, _TOLERANCE_MM)
        for wire in wires[first:last]:
            builder.Add(face, wire)
        faces.append(face)
    return faces
