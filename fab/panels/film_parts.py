"""Films divided along the creases above them: for CAD programs, and for plates of a printer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of
from fab.geometry.extrusion import extruded_parts
from fab.panels.thick_sheet import ThickSheet
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import IntArray

__all__ = ["connected", "creased_films", "film_numbers", "film_regions", "film_solid"]


def film_numbers(sheet: ThickSheet) -> IntArray:
    """Numbers of the films among the bodies of a sheet."""
    return np.flatnonzero((sheet.faces < 0) & (sheet.creases < 0))


def creased_films(sheet: ThickSheet) -> Bodies:
    """The bodies of a sheet, with the level sides of its films divided along their creases.

    A level side with a hole at each vertex takes OpenCASCADE a time that grows with the square of
    their number; divided it grows with their number.
    """
    films = set(film_numbers(sheet).tolist())
    if not films:
        return sheet.bodies
    made = []
    for number in range(len(sheet.bodies)):
        mesh = sheet.bodies.mesh(number)
        if number in films:
            mesh = film_solid([region for region, _ in film_regions(mesh, sheet.pattern)], mesh)
        made.append(mesh)
    return bodies_of(made)


def film_regions(film: TriangleMesh, pattern: CreasePattern) -> list[tuple[shapely.Polygon, int]]:
    """What a film covers, divided along the creases of a pattern, each with a face above it.

    Regions beside each other have the same corners on their common border.
    """
    corners = film.vertices_coords[film.triangles]
    top = corners[:, :, 2].min(axis=1) >= film.vertices_coords[:, 2].max() - 1e-9
    whole = shapely.coverage_union_all(shapely.polygons(corners[top, :, :2]))
    ends = pattern.vertices_coords[pattern.edges_vertices[pattern.edges_joining]]
    lines = shapely.union_all([shapely.boundary(whole), *shapely.linestrings(ends)])
    regions = np.array(
        shapely.get_parts(shapely.polygonize(shapely.get_parts(lines).tolist())).tolist()
    )
    inside = shapely.point_on_surface(regions)
    shapely.prepare(whole)
    within = shapely.contains(whole, inside)
    rings = np.split(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets[1:-1])
    tree = shapely.STRtree([shapely.Polygon(ring) for ring in rings])
    faces = tree.nearest(inside[within])
    return list(zip(regions[within].tolist(), faces.tolist(), strict=True))


def connected(regions: Sequence[shapely.Polygon]) -> list[list[shapely.Polygon]]:
    """Regions of a film in groups that share borders, in their order; a vertex alone is none."""
    whole = shapely.get_parts(shapely.coverage_union_all(list(regions)))
    inside = shapely.point_on_surface(list(regions))
    number, part = shapely.STRtree(whole).query(inside, "within")
    part = part[np.argsort(number, kind="stable")]
    return [
        [region for region, own in zip(regions, part.tolist(), strict=True) if own == each]
        for each in range(len(whole))
    ]


def film_solid(regions: Sequence[shapely.Polygon], film: TriangleMesh) -> TriangleMesh:
    """The part of a film over some of its regions."""
    low, high = film.vertices_coords[:, 2].min(), film.vertices_coords[:, 2].max()
    return extruded_parts(regions, float(low), float(high))
