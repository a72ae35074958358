r"""Relief of the first layer: bottoms cut back where squeezed plastic would bridge a gap.

The first layer of a print is pressed onto the bed and comes out wider than drawn. Bodies that
must stay apart are cut back at the bed by c, upright up to c and at 45 degrees above. Seen along
an edge at the bed, the body to the left:

         |       2c
        /
       |         c
    ---+         bed
       <c>
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely

from fab.errors import Finding, Severity, counted
from fab.geometry.bodies import Bodies, bodies_of
from fab.geometry.booleans import difference, meshes, solid
from solver.graphs import edge_keys
from solver.vectors import BoolArray, FloatArray, IntArray, cross

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["BedEdges", "bed_edges", "relieved"]

_ON_BED_MM = 1e-6
# What is nearer to the front of an edge than this only touches it.
_APART_MM = 1e-4
# Edges that are shorter get no relief: what is left of them beside a web.
_SHORTEST_MM = 1e-3
# Edges go on straight where they turn by less than this, as a sine.
_STRAIGHT = 1e-6
# Cutters begin below the bed and reach out beyond their edge by this many times c; they go on
# beyond its convex ends, where a side may lean out, and a little into the concave ones.
_BEYOND, _INTO = 2.0, 0.5
# Sides are upright that lean out by less than this over their height.
_UPRIGHT = 0.5


@dataclass(frozen=True)
class BedEdges:
    """Edges at which bodies rise from the bed, seen from above.

    Attributes
    ----------
    bodies : shape (n,), rising, the body of each.
    ends : shape (n, 2, 2), mm: from start to end, the body on the right.
    beyond : shape (n, 2), how far cutters go on beyond each end, in units of what they cut off:
        at a corner that sticks out, a little at one that goes in, not at all beside a web.
    upright : shape (n,), whether the side above leans out little or not at all.
    """

    bodies: IntArray
    ends: FloatArray
    beyond: FloatArray
    upright: BoolArray

    def chosen(self, rows: IntArray) -> BedEdges:
        """Some of the edges."""
        return BedEdges(self.bodies[rows], self.ends[rows], self.beyond[rows], self.upright[rows])

    @property
    def along(self) -> FloatArray:
        """Unit directions, shape (n, 2)."""
        along = self.ends[:, 1] - self.ends[:, 0]
        return np.asarray(along / np.hypot(*along.T)[:, None])

    @property
    def outward(self) -> FloatArray:
        """Unit normals that point away from the bodies, shape (n, 2)."""
        along = self.along
        return np.column_stack([-along[:, 1], along[:, 0]])


def relieved(
    bodies: Bodies, joining: Bodies, rigid: BoolArray, first_layer_mm: float, gap_mm: float
) -> tuple[Bodies, Bodies, list[Finding]]:
    """The bodies of a sheet with rigid ones cut back at the bed, and a note of it.

    bodies, joining, rigid : as in a `ThickSheet`. gap_mm : that must be left when the first layer
    has spread by first_layer_mm on both sides of a gap: only where another body is nearer than that
    is one cut back. Beside webs nothing is cut, as they join their panels.
    """
    low = float(bodies.vertices_coords[:, 2].min(initial=np.inf))
    edges = _facing(bodies, rigid, low, gap_mm + 2 * first_layer_mm)
    edges = _beside_webs(bodies, ~rigid, edges, low)
    if not len(edges.bodies):
        return bodies, joining, []
    cutters = _cutters(edges, low, first_layer_mm)
    first = np.searchsorted(edges.bodies, np.arange(len(bodies) + 1))

    chosen = np.unique(edges.bodies).tolist()
    solids = [
        difference([solid(bodies.mesh(body)), *cutters[first[body] : first[body + 1]]])
        for body in chosen
    ]
    changed = dict(zip(chosen, meshes(solids), strict=True))

    def cut(whole: Bodies) -> Bodies:  # rigid bodies are the same ones in both
        return bodies_of([changed.get(row) or whole.mesh(row) for row in range(len(whole))])

    text = (
        f"bottoms are cut back by first_layer_mm = {first_layer_mm:g} along "
        f"{counted(len(edges.bodies), 'edge')}, where the first layer would come too near to "
        "another body as it spreads. Switch off what the slicer does about elephant's foot."
    )
    note = Finding("first-layer-relief", Severity.NOTE, text)
    return cut(bodies), cut(joining), [note]


def bed_edges(bodies: Bodies, bed_mm: float) -> BedEdges:
    """The straight edges around all sides of bodies that lie on a bed at z = bed_mm."""
    coords = bodies.vertices_coords[:, :2]
    corners = bodies.triangles[_on_bed(bodies, bed_mm)]
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    keys = edge_keys(np.column_stack([start, end]), len(coords))
    _, number, times = np.unique(keys, return_inverse=True, return_counts=True)
    rim = np.flatnonzero(times[number] == 1)
    rim = rim[np.argsort(start[rim], kind="stable")]  # by body, as vertices are
    start, end = start[rim], end[rim]
    leaving = {vertex: row for row, vertex in enumerate(start.tolist())}
    following = np.array([leaving[vertex] for vertex in end.tolist()], np.int64)
    along = coords[end] - coords[start]
    along /= np.hypot(*along.T)[:, None]
    after = along[following]
    turn = along[:, 0] * after[:, 1] - along[:, 1] * after[:, 0]
    goes_on = (np.abs(turn) <= _STRAIGHT) & ((along * after).sum(axis=1) > 0)
    before = np.arange(len(following))
    before[following] = np.arange(len(following))
    first = np.flatnonzero(~goes_on[before])
    last = first.copy()
    while goes_on[last].any():
        last = np.where(goes_on[last], following[last], last)
    ends = np.stack([coords[start[first]], coords[end[last]]], axis=1)
    convex = np.column_stack([turn[before[first]] < 0, turn[last] < 0])  # the body is on the right
    upright = _lean(bodies, start[first], end[first]) <= _UPRIGHT
    beyond = np.where(convex, _BEYOND, _INTO)
    return BedEdges(bodies.vertices_body[start[first]], ends, beyond, upright)


def _lean(bodies: Bodies, start: IntArray, end: IntArray) -> FloatArray:
    """How far sides above some edges lean out over their height; below 0 where they lean in."""
    coords, count = bodies.vertices_coords, len(bodies.vertices_coords)
    directed = bodies.triangles.ravel() * count + np.roll(bodies.triangles, -1, axis=1).ravel()
    order = np.argsort(directed)
    side = order[np.searchsorted(directed, end * count + start, sorter=order)] // 3
    a, b, c = coords[bodies.triangles[side]].swapaxes(0, 1)
    normal = cross(b - a, c - a)
    with np.errstate(divide="ignore"):
        return np.asarray(-normal[:, 2] / np.hypot(normal[:, 0], normal[:, 1]))


def _facing(bodies: Bodies, rigid: BoolArray, bed_mm: float, near_mm: float) -> BedEdges:
    """Edges of rigid bodies that another rigid body is nearer to than near_mm, in front of them.

    Upright sides count as facing what is beside their front as well, unless the body itself is in
    front of them. Sides that lean out do not: their gaps are wider at the bed than above.
    """
    edges = bed_edges(bodies, bed_mm)
    edges = edges.chosen(np.flatnonzero(rigid[edges.bodies]))
    on_bed = _on_bed(bodies, bed_mm) & rigid[bodies.triangles_body]
    owner = bodies.triangles_body[on_bed]
    floor = shapely.polygons(bodies.vertices_coords[bodies.triangles[on_bed]][:, :, :2])
    tree = shapely.STRtree(floor)

    def met(beside_mm: float) -> tuple[BoolArray, BoolArray]:
        """Which edges have their own body in front of them, and which another one."""
        longer = beside_mm - _APART_MM  # what only touches the front is not in it
        ends = edges.ends + longer * np.stack([-edges.along, edges.along], axis=1)
        near, far = (y * edges.outward[:, None] for y in (_APART_MM, near_mm - _APART_MM))
        front = shapely.polygons(np.concatenate([ends + near, (ends + far)[:, ::-1]], axis=1))
        row, body = tree.query(front, predicate="intersects")
        own = edges.bodies[row] == owner[body]
        out = np.zeros((2, len(edges.bodies)), bool)
        out[0, row[own]] = out[1, row[~own]] = True
        return out[0], out[1]

    own, other = met(0.0)
    _, beside = met(near_mm)
    return edges.chosen(np.flatnonzero(other | (beside & edges.upright & ~own)))


def _beside_webs(bodies: Bodies, soft: BoolArray, edges: BedEdges, bed_mm: float) -> BedEdges:
    """The parts of edges at which no soft body on the bed begins."""
    low, _ = bodies.boxes()
    webs = bed_edges(
        bodies.chosen(np.flatnonzero(soft & (low[:, 2] <= bed_mm + _ON_BED_MM))), bed_mm
    )
    if not len(webs.bodies) or not len(edges.bodies):
        return edges
    lines = shapely.linestrings(edges.ends)
    rims = shapely.buffer(shapely.linestrings(webs.ends), _SHORTEST_MM, cap_style="square")
    row, web = shapely.STRtree(rims).query(lines, predicate="intersects")
    kept, ends = [], []
    for number, line in enumerate(lines):
        free = shapely.difference(line, shapely.union_all(rims[web[row == number]]))
        parts = [part for part in shapely.get_parts(free) if part.length >= _SHORTEST_MM]
        kept += [number] * len(parts)
        ends += [shapely.get_coordinates(part)[[0, -1]] for part in parts]
    parted = edges.chosen(np.array(kept, np.int64))
    new = np.array(ends).reshape(-1, 2, 2)
    corner = (new == parted.ends).all(axis=2)
    return BedEdges(parted.bodies, new, np.where(corner, parted.beyond, 0.0), parted.upright)


def _on_bed(bodies: Bodies, bed_mm: float) -> BoolArray:
    """Which triangles lie on the bed, shape (nt,)."""
    heights = bodies.vertices_coords[bodies.triangles][:, :, 2]
    return np.asarray((np.abs(heights - bed_mm) <= _ON_BED_MM).all(axis=1))


def _cutters(edges: BedEdges, bed_mm: float, by_mm: float) -> list[Manifold]:
    """A prism along each edge, of what is cut off in front of it."""
    from manifold3d import Manifold

    ends = edges.ends + by_mm * edges.beyond[:, :, None] * np.stack(
        [-edges.along, edges.along], axis=1
    )
    far = _BEYOND * by_mm
    section = [(-by_mm, -far), (far, -far), (far, far + 2 * by_mm), (-by_mm, by_mm)]
    outward = edges.outward
    points = [
        np.concatenate([ends + x * outward[:, None], np.full((*ends.shape[:2], 1), bed_mm + z)], 2)
        for x, z in section
    ]
    return [
        Manifold.hull_points(np.ascontiguousarray(corners))
        for corners in np.concatenate(points, axis=1)
    ]
