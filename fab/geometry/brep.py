"""How do bodies become CAD solids: planar faces that share their edges?"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from fab.geometry.bodies import Bodies
from fab.geometry.rings import next_corner
from fab.geometry.side_loops import side_loops
from solver.vectors import norm

if TYPE_CHECKING:
    from build123d import Solid

__all__ = ["solids"]

# The tolerance of shapes that OpenCASCADE makes itself.
_TOLERANCE_MM = 1e-7


def solids(bodies: Bodies) -> list[Solid]:
    """Each body as a build123d solid with one face for each planar side, an edge for each corner.

    Faces share their edges, and have explicit planes: nothing is left for OpenCASCADE to find out.
    """
    from build123d import Solid
    from OCP.BRep import BRep_Builder
    from OCP.Geom import Geom_Line, Geom_Plane
    from OCP.gp import gp_Dir, gp_Pnt
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import (
        TopoDS_Edge,
        TopoDS_Face,
        TopoDS_Shell,
        TopoDS_Solid,
        TopoDS_Vertex,
        TopoDS_Wire,
    )

    loops = side_loops(bodies)
    coords = bodies.vertices_coords
    ends = np.column_stack([loops.corners, loops.corners[next_corner(loops.offsets)]])
    pairs, number = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    way = coords[pairs[:, 1]] - coords[pairs[:, 0]]
    length = norm(way)
    here = TopLoc_Location()
    builder = BRep_Builder()
    points = [gp_Pnt(*row) for row in coords.tolist()]
    vertices = []
    for point in points:
        vertex = TopoDS_Vertex()
        builder.MakeVertex(vertex, point, _TOLERANCE_MM)
        vertices.append((vertex, vertex.Reversed()))
    edges = []
    directions = (way / length[:, None]).tolist()
    for (a, b), along, end in zip(pairs.tolist(), directions, length.tolist(), strict=True):
        edge = TopoDS_Edge()
        builder.MakeEdge(edge, Geom_Line(points[a], gp_Dir(*along)), _TOLERANCE_MM)
        builder.Add(edge, vertices[a][0])
        builder.Add(edge, vertices[b][1])
        builder.Range(edge, 0.0, end)
        edges.append((edge, edge.Reversed()))
    backward = (ends[:, 0] > ends[:, 1]).astype(int)
    uses = list(zip(number.ravel().tolist(), backward.tolist(), strict=True))
    wires = []
    for first, last in pairwise(loops.offsets.tolist()):
        wire = TopoDS_Wire()
        builder.MakeWire(wire)
        for edge_number, way_back in uses[first:last]:
            builder.Add(wire, edges[edge_number][way_back])
        wire.Closed(True)
        wires.append(wire)
    shells = [TopoDS_Shell() for _ in range(len(bodies))]
    for shell in shells:
        builder.MakeShell(shell)
    owners, normals = loops.bodies.tolist(), loops.normals.tolist()
    starts = loops.corners[loops.offsets[:-1]].tolist()
    sides = np.flatnonzero(loops.outer)
    for first, last in pairwise([*sides.tolist(), len(loops.outer)]):
        face = TopoDS_Face()
        plane = Geom_Plane(points[starts[first]], gp_Dir(*normals[first]))
        builder.MakeFace(face, plane, here, _TOLERANCE_MM)
        for wire in wires[first:last]:
            builder.Add(face, wire)
        builder.Add(shells[owners[first]], face)
    out = []
    for shell in shells:
        shell.Closed(True)
        body_shape = TopoDS_Solid()
        builder.MakeSolid(body_shape)
        builder.Add(body_shape, shell)
        out.append(Solid(body_shape))
    return out
