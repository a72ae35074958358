"""Sheets of one surface brought together at their rims, as far as it harms none of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from solver.matched_rims import RimSheet, met_rims
from solver.mesh import interior_vertices
from solver.self_intersection import crossing_faces
from solver.surface_cover import covered
from solver.surface_sheet import OFF, SurfaceSheet, least_sector
from solver.targets.mesh_target import MeshTarget
from solver.vectors import FloatArray, IntArray

__all__ = ["met_sheets"]

# So often, at most, vertices of the rims of several sheets are brought together; twice where sheets
# have more than half of so many faces.
_MEETINGS, _FACES_MET = 8, 8000
# Those that are nearer than this, in steps; where that does harm, those nearer than half of it, and
# so on until it is less than the second.
_MOST_APART, _LEAST_APART = 1.2, 0.2
# They may be as much farther from the surface for it.
_FARTHER = 1.6


def met_sheets(
    target: MeshTarget,
    sheets: tuple[SurfaceSheet, ...],
    judged: Callable[[SurfaceSheet], SurfaceSheet],
    interrupted: Callable[[], bool] | None = None,
) -> tuple[SurfaceSheet, ...]:
    """The sheets with as many vertices of their rims that meet as leave them as good.

    Parameters
    ----------
    target : the whole surface. judged : a sheet with what it misses of the goals.
    interrupted : asked between rounds; once it is true the best so far is returned.
    """
    pairs, barred = np.empty((0, 2), np.int64), np.empty(0, np.int64)
    reach = _MOST_APART
    faces = sum(len(sheet.mesh.faces_vertices) for sheet in sheets)
    for _ in range(min(_MEETINGS, max(2, _FACES_MET // faces))):
        if (interrupted is not None and interrupted()) or reach < _LEAST_APART:
            break
        found = met_rims(target, _rims(sheets), pairs, barred, reach, interrupted)
        if found is None:
            break
        each = zip(sheets, found.coords, found.deviations, found.distances, strict=True)
        moved = tuple(judged(_moved(*one)) for one in each)
        as_good = (
            (new.faults, new.missed) <= (old.faults, old.missed)
            and new.distance <= _FARTHER * old.distance
            for new, old in zip(moved, sheets, strict=True)
        )
        if all(as_good) and not len(found.faulty):
            sheets, pairs = moved, found.pairs
        else:
            beside = _beside_faults(moved, found.faulty, found.pairs[len(pairs) :])
            reach /= 1 if len(beside) else 2
            barred = np.union1d(barred, beside)
    return sheets


def _moved(
    sheet: SurfaceSheet, coords: FloatArray, deviations: FloatArray, distance: float
) -> SurfaceSheet:
    """A sheet with its vertices elsewhere, measured again."""
    mesh, target = replace(sheet.mesh, vertices_coords=coords), MeshTarget(sheet.part)
    made = [(coords, mesh.faces_vertices)]
    return replace(
        sheet,
        mesh=mesh,
        deviations=deviations,
        coverage=float(covered(target, made, 2 * sheet.step * sheet.pleats.thickness).mean()),
        crossings=len(crossing_faces(coords, *mesh.polygons)),
        least_sector=least_sector(mesh),
        distance=distance,
    )


def _rims(sheets: Sequence[SurfaceSheet]) -> list[RimSheet]:
    return [
        RimSheet(
            sheet.mesh.vertices_coords,
            sheet.mesh.faces_vertices,
            sheet.part,
            sheet.step * sheet.pleats.stretch,
            sheet.step * sheet.pleats.thickness,
        )
        for sheet in sheets
    ]


def _beside_faults(sheets: Sequence[SurfaceSheet], faulty: IntArray, pairs: IntArray) -> IntArray:
    """Vertices around the faulty ones, faces that cross, and vertices that are too far off.

    Numbered through all sheets; so many rings around them that some are in the pairs.
    """
    faces, bad, start = [], [faulty], 0
    for sheet in sheets:
        mesh, count = sheet.mesh, len(sheet.mesh.vertices_coords)
        crossed = crossing_faces(mesh.vertices_coords, *mesh.polygons).ravel()
        inner = np.flatnonzero(interior_vertices(mesh.faces_vertices, count))
        off = inner[np.abs(sheet.deviations) > OFF * sheet.step]
        bad += [start + mesh.faces_vertices[crossed].ravel(), start + off]
        faces.append(start + mesh.faces_vertices)
        start += count
    every, out = np.concatenate(faces), np.unique(np.concatenate(bad))
    while len(out) and not np.isin(pairs, out).any():
        wider = np.unique(every[np.isin(every, out).any(axis=1)])
        if len(wider) == len(out):
            break
        out = wider
    return out
