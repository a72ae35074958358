"""Clean triangle meshes: what a file holds, repaired, each repair a finding."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fab.errors import Finding, Severity
from fab.surfaces.crossings import inspect_crossings
from fab.surfaces.holes import filled
from fab.surfaces.manifold import largest_surface
from fab.surfaces.soup import Soup, checked, merged, place_text, with_area, without_repeats
from solver.errors import InvalidState
from solver.targets.decimation import decimated
from solver.targets.refinement import refined
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import norm

__all__ = ["MOST_TRIANGLES", "CleanMesh", "clean_mesh"]

# Larger meshes are decimated to this many triangles.
MOST_TRIANGLES = 100_000
# Edges longer than this, in sizes of the mesh, are divided, if the triangles are not too many then.
_LONGEST = 1 / 32
# Farther from the origin than this, in sizes of the mesh, coordinates lack digits of the sheet's.
_FARTHEST = 100.0


@dataclass(frozen=True)
class CleanMesh:
    """A connected surface, and what was done to have it.

    Attributes
    ----------
    mesh : at most two faces at an edge, all with an area, wound in one way where it has two sides.
    findings : repairs and facts, with their places.
    """

    mesh: SurfaceMesh
    findings: tuple[Finding, ...]


def clean_mesh(soup: Soup) -> CleanMesh:
    """The largest surface in a soup of triangles, see `fab.surfaces.soup`, made clean.

    In turn: vertices merged, flat and repeated triangles left out, branches and touching parts
    taken apart, the largest piece kept, windings made one, closed surfaces turned outwards,
    meshes of more than 100 000 triangles decimated, small holes filled, self-crossings reported,
    what is over 100 sizes from the origin moved there, edges over 1/32 of the size divided. All
    bounds are relative to the size of the mesh. Raises `InvalidFile`, without the file's name,
    where no surface is left.

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]])
    >>> clean = clean_mesh((corners, np.array([[0, 1, 2], [3, 5, 4]])))
    >>> clean.mesh.kind, [finding.code for finding in clean.findings]
    (<MeshKind.DISC: 'disc'>, ['mesh-windings'])
    """
    soup = checked(soup)
    soup, findings = merged(soup)
    for step in (without_repeats, with_area, without_repeats):
        soup, more = step(soup)
        findings += more
    mesh, more = largest_surface(soup)
    findings += more
    mesh, more = _few_enough(mesh)
    findings += more
    mesh, more = filled(mesh)
    findings += more
    findings += inspect_crossings(mesh)
    mesh, more = _near_origin(mesh)
    findings += more
    return CleanMesh(refined(mesh, _LONGEST * mesh.size, MOST_TRIANGLES), tuple(findings))


def _few_enough(mesh: SurfaceMesh) -> tuple[SurfaceMesh, list[Finding]]:
    count = len(mesh.faces_vertices)
    if count <= MOST_TRIANGLES:
        return mesh, []
    try:
        few = decimated(mesh, MOST_TRIANGLES)
    except InvalidState as error:
        text = f"{count} triangles are kept: {error}"
        return mesh, [Finding("mesh-large", Severity.NOTE, text)]
    text = (
        f"{count} triangles decimated to {len(few.mesh.faces_vertices)}: vertices are up to "
        f"{few.distances.max():.3g} from the surface that is left."
    )
    return few.mesh, [Finding("mesh-decimated", Severity.NOTE, text)]


def _near_origin(mesh: SurfaceMesh) -> tuple[SurfaceMesh, list[Finding]]:
    coords = mesh.vertices_coords
    middle = (coords.min(axis=0) + coords.max(axis=0)) / 2
    sizes = float(norm(middle)) / mesh.size
    if sizes <= _FARTHEST:
        return mesh, []
    text = (
        f"The surface is about {place_text(middle, 12)}, {sizes:.0f} times its size from the "
        "origin, where coordinates have too few digits for a sheet: it is moved to the origin, and "
        "the folded sheet is there."
    )
    return replace(mesh, vertices_coords=coords - middle), [
        Finding("mesh-moved", Severity.NOTE, text)
    ]
