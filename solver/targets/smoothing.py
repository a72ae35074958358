"""Noisy meshes smoothed, how noisy they are, and how much smoothing a sheet's cells want.

Points x of the mesh are replaced by those that least

    |x - x0|^2 + s^4 E(x),    s = 1.25 length / 2 pi,

with the curved Hessian energy E of O. Stein, A. Jacobson, M. Wardetzky and E. Grinspun ("A
smoothness energy without boundary distortion for curved surfaces", ACM TOG 39, 2020): planes and
straight rims stay as they are, corners of rims are rounded by up to a tenth of the length. What is
taken away is smoothed in turn and put back. A wave over the surface then keeps half of its height
where it is `length` long, 98 % where it is twice as long, and 5 % where it is half as long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csc_array

from solver.errors import InvalidState, require_positive
from solver.sparse import Factors, SymmetricSystem, Triangle
from solver.targets.surface_mesh import SurfaceMesh
from solver.targets.triangles import TriangleTree, least_heights
from solver.vectors import BoolArray, FloatArray, IntArray, dot, scattered, unit

__all__ = ["Smoothed", "edge_length", "noise_level", "smoothed", "smoothing_length"]

# Half of a wave of one length is left: 1 - (1 - 1 / (1 + (k s)^4))^2 = 1/2, k = 2 pi / length.
_SCALE = (1 + np.sqrt(2)) ** 0.25 / (2 * np.pi)
# Waves shorter than so many edges are noise, of which the level is found.
_NOISE_EDGES = 8.0
# Smoothing by less than so many edges changes little.
_LEAST_EDGES = 4.0
# What may be left of noise: in cells, and of its slope, radians; the most smoothing, in cells.
_LEFT, _LEFT_SLOPE, _MOST_CELLS = 0.05, 0.1, 4.0
# The standard deviation of normal noise, from the median of its absolute values.
_MEDIAN = 1.4826
_FLAT = 1e-9
# Passes of smoothing, the surface of each being that on which the energy of the next one is.
_PASSES = 2


@dataclass(frozen=True)
class Smoothed:
    """A smoothed copy of a mesh.

    Attributes
    ----------
    mesh : with the same faces. distances : of its vertices from the original surface, (nv,).
    """

    mesh: SurfaceMesh
    distances: FloatArray


def smoothed(mesh: SurfaceMesh, length: float) -> Smoothed:
    """The mesh without waves shorter than `length`, in the unit of its coordinates.

    A sphere's radius shrinks by less than 2e-4 of it for lengths up to the radius, and by 1.5 % for
    twice the radius. Raises
    `InvalidState` where nothing is left of the surface at such a length.
    """
    require_positive("length", length)
    coords = _low_pass(mesh, length)
    left = SurfaceMesh(coords, mesh.faces_vertices.copy())
    heights = least_heights(coords, mesh.faces_vertices)
    if not (np.isfinite(coords).all() and (heights > _FLAT * left.size).all()):
        state = f"smoothing by {length:.6g} collapses triangles of a mesh of size {mesh.size:.6g}"
        raise InvalidState("length", state, "Smooth by less.")
    tree = TriangleTree.of(mesh.vertices_coords, mesh.faces_vertices)
    return Smoothed(left, tree.nearest(coords)[0])


def noise_level(mesh: SurfaceMesh) -> float:
    """The standard deviation of noise across the surface, if it is alike in all vertices.

    What smoothing by 8 edges takes away; creases and corners of the surface do not count, as it is
    found by the median. On a smooth surface it is a small part of the height of its facets.
    """
    coords = _low_pass(mesh, _NOISE_EDGES * edge_length(mesh))
    normals = unit(_vertex_sums(mesh, coords))
    across = np.abs(dot(mesh.vertices_coords - coords, normals))
    return _MEDIAN * float(np.median(across[np.isfinite(across)]))


def smoothing_length(mesh: SurfaceMesh, cell: float) -> float:
    """The length by which a mesh wants to be smoothed for a sheet with cells of size `cell`; or 0.

    White noise of standard deviation n, on edges e, is left with about 1.8 n e / length across the
    surface, and with a slope of 7.9 n e / length^2: at most 0.05 cells and 0.1 radians are wanted,
    but no smoothing by more than 4 cells. Where 4 edges would do, there is no noise to speak of.
    """
    require_positive("cell", cell)
    edge = edge_length(mesh)
    noise = noise_level(mesh) * edge
    length = max(np.sqrt(np.pi) * noise / (_LEFT * cell), np.sqrt(7.9 * noise / _LEFT_SLOPE))
    return 0.0 if length < _LEAST_EDGES * edge else float(min(length, _MOST_CELLS * cell))


def edge_length(mesh: SurfaceMesh) -> float:
    """The length of edges, by the area that a vertex has on an even mesh."""
    return float(np.sqrt(mesh.area / len(mesh.vertices_coords) * 2 / np.sqrt(3)))


def _vertex_sums(mesh: SurfaceMesh, coords: FloatArray) -> FloatArray:
    """Sums of the faces' normals times areas around each vertex, shape (nv, 3)."""
    areas = SurfaceMesh(coords, mesh.faces_vertices).doubled_areas
    return scattered(mesh.faces_vertices.ravel(), np.repeat(areas, 3, axis=0), len(coords))


def _low_pass(mesh: SurfaceMesh, length: float) -> FloatArray:
    """Points of the mesh without short waves, shape (nv, 3).

    The energy is that on a surface averaged over neighbours, then on the one that this made: noise
    would make triangles larger, and turn some over.
    """
    import igl

    middle = mesh.vertices_coords.mean(axis=0)
    coords = (mesh.vertices_coords - middle) / mesh.size
    scale = _SCALE * length / mesh.size
    metric = _averaged(mesh, coords, (_SCALE * length / edge_length(mesh)) ** 2)
    for _ in range(_PASSES):
        energy = csc_array(igl.curved_hessian_energy(metric, mesh.faces_vertices))
        kind = igl.MASSMATRIX_TYPE_BARYCENTRIC
        mass = csc_array(igl.massmatrix(metric, mesh.faces_vertices, kind))
        factors = _factors(mass + scale**4 * energy)
        once = _solved(factors, mass @ coords)
        metric = once + _solved(factors, mass @ (coords - once))
    out: FloatArray = metric * mesh.size + middle
    return out


def _averaged(mesh: SurfaceMesh, coords: FloatArray, steps: float) -> FloatArray:
    """Points moved towards the mean of their neighbours, by so many steps of diffusion.

    Those of the rim follow those beside them on the rim alone: it would draw back else.
    """
    rim = mesh.rim_edges
    out = _diffused(mesh.edges_vertices[rim], coords, steps, np.ones(len(coords), bool))
    inner = np.ones(len(coords), bool)
    inner[mesh.edges_vertices[rim]] = False
    return _diffused(mesh.edges_vertices, out, steps, inner)


def _diffused(edges: IntArray, coords: FloatArray, steps: float, free: BoolArray) -> FloatArray:
    """Points after diffusion along edges, shape (n, 3); those that are not free stay."""
    first, second = edges.T
    count = len(coords)
    valence = np.bincount(edges.ravel(), minlength=count)
    weight = steps / max(valence.mean(), 1.0)
    moves = free[first] & free[second]
    held = coords * np.where(free, 1.0, 1.0 + weight * valence)[:, None]
    for near, far in ((first, second), (second, first)):
        pulls = free[near] & ~free[far]
        held += weight * scattered(near[pulls], coords[far[pulls]], count)
    diagonal = np.arange(count)
    rows = np.concatenate([diagonal, first[moves], second[moves]])
    columns = np.concatenate([diagonal, second[moves], first[moves]])
    beside = np.full(2 * int(moves.sum()), -weight)
    data = np.concatenate([1.0 + weight * valence, beside])
    matrix = coo_array((data, (rows, columns)), shape=(count, count))
    return _solved(_factors(csc_array(matrix)), held)


def _factors(matrix: csc_array) -> Factors:
    """Factors of a symmetric matrix."""
    entries = matrix.tocoo()
    rows, columns = (np.asarray(part, np.int64) for part in entries.coords)
    lower = rows >= columns
    triangle, slots = Triangle.of(matrix.shape[0], rows[lower], columns[lower])
    data = triangle.summed(slots, np.asarray(entries.data, np.float64)[lower])
    return SymmetricSystem(triangle).factorised(data)


def _solved(factors: Factors, right: FloatArray) -> FloatArray:
    """Solutions for each column of `right`, shape (n, 3)."""
    return np.stack([factors.solve(column).x for column in right.T], axis=1)
