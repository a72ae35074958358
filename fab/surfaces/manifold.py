"""One surface out of a soup of triangles: branches cut off, the largest piece, wound in one way."""

from __future__ import annotations

import numpy as np

from fab.errors import Finding, InvalidFile, Severity, counted
from fab.surfaces.soup import Soup, packed, place_text
from solver.graphs import labels
from solver.targets.surface_mesh import SurfaceMesh, corner_labels, side_labels
from solver.targets.triangles import triangle_edges
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["largest_surface"]

# Passes over edges that more than two faces still share.
_MOST_PASSES = 5


def largest_surface(soup: Soup) -> tuple[SurfaceMesh, list[Finding]]:
    """The largest connected surface in a soup, with at most two faces at an edge.

    Where more than two faces meet at an edge, the two that continue each other most smoothly stay
    joined, then the next two; the surface comes apart elsewhere, and where faces touch at a vertex
    alone. Of several pieces the one with the largest area is kept. Faces are wound as most of its
    area is, those of a closed surface so that normals point outwards.
    """
    apart, halves, findings = _apart(soup)
    (coords, faces), halves, more = _largest(apart, halves)
    findings += more
    faces, more = _wound(coords, faces, halves)
    coords, faces = packed((coords, faces))
    return SurfaceMesh.of(coords, faces), findings + more


def _apart(soup: Soup) -> tuple[Soup, IntArray, list[Finding]]:
    """Vertices doubled where the surface comes apart, and the half-edges that meet, (n, 2)."""
    coords, faces = soup
    findings: list[Finding] = []
    for turn in range(_MOST_PASSES):
        _, edges = triangle_edges(faces, len(coords))
        halves, crowded = _met(coords, faces, edges, pair=turn == 0)
        if turn and not len(crowded):
            return (coords, faces), halves, findings
        group = corner_labels(faces, halves)
        _, first = np.unique(group, return_index=True)
        if len(crowded):
            most = int(np.bincount(edges.ravel())[crowded].max())
            middle = _edge_middle(coords, faces, edges, int(crowded[0]))
            if turn == 0:
                at = counted(len(crowded), "edge")
                text = (
                    f"{at} had more than two triangles, up to {most}, the first at "
                    f"{place_text(middle)}: the two that continue each other most smoothly stay "
                    "joined."
                )
                findings.append(Finding("mesh-branches", Severity.WARNING, text))
        elif len(first) > len(coords):
            copies = np.bincount(faces.ravel()[first], minlength=len(coords))
            touching = np.flatnonzero(copies > 1)
            text = (
                f"Parts of the mesh touched at {counted(len(touching), 'vertex', 'vertices')} "
                f"alone, the first at {place_text(coords[touching[0]])}: taken apart there."
            )
            findings.append(Finding("mesh-parts-touch", Severity.NOTE, text))
        coords, faces = coords[faces.ravel()[first]], group.reshape(-1, 3)
    raise InvalidFile(
        "its triangles cannot be taken apart into surfaces. Repair it in a mesh editor."
    )


def _edge_middle(coords: FloatArray, faces: IntArray, edges: IntArray, edge: int) -> FloatArray:
    face, corner = divmod(int(np.flatnonzero(edges.ravel() == edge)[0]), 3)
    out: FloatArray = coords[faces[face, [corner, (corner + 1) % 3]]].mean(axis=0)
    return out


def _met(
    coords: FloatArray, faces: IntArray, edges: IntArray, *, pair: bool
) -> tuple[IntArray, IntArray]:
    """Pairs of half-edges across which the surface goes on, and the edges of more than two faces.

    pair : whether the faces of these are joined two by two; else none of them is.
    """
    order = np.argsort(edges.ravel(), kind="stable")
    uses = np.bincount(edges.ravel())
    begin = np.concatenate([[0], np.cumsum(uses)[:-1]])
    two = begin[uses == 2]
    pairs = [np.column_stack([order[two], order[two + 1]])]
    crowded = np.flatnonzero(uses > 2)
    if pair and len(crowded):
        found = [
            match
            for edge in crowded.tolist()
            for match in _smoothest(coords, faces, order[begin[edge] : begin[edge] + uses[edge]])
        ]
        pairs.append(np.array(found, np.int64).reshape(-1, 2))
    return np.concatenate(pairs), crowded


def _smoothest(coords: FloatArray, faces: IntArray, half: IntArray) -> list[tuple[int, int]]:
    """Half-edges of one edge, paired so that first the two flattest faces go on in each other."""
    face, corner = half // 3, half % 3
    start, end, tip = (coords[faces[face, (corner + k) % 3]] for k in range(3))
    along = unit(end - start)
    into = tip - start
    into = unit(into - dot(into, along)[:, None] * along)
    bend = into @ into.T
    free = np.ones(len(half), bool)
    first, second = np.triu_indices(len(half), 1)
    out = []
    for k in np.argsort(bend[first, second], kind="stable").tolist():
        if free[first[k]] and free[second[k]]:
            free[[first[k], second[k]]] = False
            out.append((int(half[first[k]]), int(half[second[k]])))
    return out


def _largest(soup: Soup, halves: IntArray) -> tuple[Soup, IntArray, list[Finding]]:
    """The faces of the piece with the largest area, and the half-edges that meet in it."""
    coords, faces = soup
    piece = labels(halves // 3, len(faces))
    areas = np.bincount(piece, norm(_doubled_areas(coords, faces)))
    if len(areas) == 1:
        return soup, halves, []
    largest = int(areas.argmax())
    kept = piece == largest
    number = np.cumsum(kept) - 1
    inner = kept[halves[:, 0] // 3]
    share = 100 * areas[largest] / areas.sum()
    areas[largest] = 0
    next_one = piece == int(areas.argmax())
    where = place_text(coords[faces[next_one]].mean(axis=(0, 1)))
    text = (
        f"{counted(len(areas), 'piece')}: the largest is kept, with {share:.3g} % of the area. "
        f"The next is about {where}. Join pieces in a mesh editor where they belong together."
    )
    severity = Severity.NOTE if share > 99 else Severity.WARNING
    moved = 3 * number[halves[inner] // 3] + halves[inner] % 3
    return (coords, faces[kept]), moved, [Finding("mesh-pieces", severity, text)]


def _wound(coords: FloatArray, faces: IntArray, halves: IntArray) -> tuple[IntArray, list[Finding]]:
    """Faces in one winding, as most of the area has it; outwards where the surface is closed."""
    agree = _agree(faces, halves)
    sides = side_labels(halves // 3, agree, len(faces))
    if sides[0, 0] == sides[0, 1]:
        import igl

        text = "The surface has one side only, as a Moebius band has."
        turned = np.asarray(igl.bfs_orient(faces)[0], np.int64)
        return turned, [Finding("mesh-one-sided", Severity.NOTE, text)]
    turned = sides[:, 0] != sides[0, 0]
    areas = norm(_doubled_areas(coords, faces))
    if areas[turned].sum() > areas.sum() / 2:
        turned = ~turned
    findings = []
    if turned.any():
        where = place_text(coords[faces[turned][0]].mean(axis=0))
        were = counted(int(turned.sum()), "triangle was", "triangles were")
        text = f"{were} wound against the others, the first at {where}: turned over."
        findings.append(Finding("mesh-windings", Severity.NOTE, text))
        faces = np.where(turned[:, None], faces[:, ::-1], faces)
    if 2 * len(halves) == faces.size:
        corners = coords - coords.mean(axis=0)
        volume = dot(corners[faces[:, 0]], _doubled_areas(corners, faces)).sum()
        if volume < 0:
            text = "The closed surface was inside out: its normals point outwards now."
            findings.append(Finding("mesh-inside-out", Severity.NOTE, text))
            faces = faces[:, ::-1]
    return np.ascontiguousarray(faces), findings


def _agree(faces: IntArray, halves: IntArray) -> BoolArray:
    """Whether the two half-edges of each pair run against each other, as of one winding."""
    flat = faces.ravel()
    agree: BoolArray = flat[halves[:, 0]] != flat[halves[:, 1]]
    return agree


def _doubled_areas(coords: FloatArray, faces: IntArray) -> FloatArray:
    first, second, third = (coords[faces[:, k]] for k in range(3))
    return cross(second - first, third - first)
