"""What the figures of the paper show: vertices, fronts, and the sheets of shipped jobs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fab.catalogue import shipped
from fab.folding.bar_hinge_model import framework
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import fold
from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.viewing.scene import Scene
from fab.viewing.scene_builders import folding_scene as make_scene
from solver import (
    Crumpled,
    Front,
    QuadMesh,
    Rays,
    SurfaceFit,
    VertexFamily,
    vertex_family,
)
from solver.designs.surface_fit import SURFACES
from solver.growth_order import GrownStrip, grown_strips
from solver.targets.base import ray_hit
from solver.vectors import FloatArray, dot

__all__ = [
    "crumpled_strip",
    "folding_scene",
    "loop_sheets",
    "offset_lengths",
    "pair_front",
    "shipped_mesh",
    "surface_fit",
    "vertex",
    "vertex_of",
]

# Of the figures of one vertex: beta, and the sectors of its old faces.
_BETA, _THETA3, _THETA4 = np.radians([110.0, 80.0, 115.0])


def vertex(flap_angles: FloatArray | int) -> VertexFamily:
    """The vertex of the figures, at these flap angles or as many."""
    return vertex_of(_BETA, _THETA3, _THETA4, flap_angles)


def vertex_of(
    beta: float, theta3: float, theta4: float, flap_angles: FloatArray | int
) -> VertexFamily:
    """A vertex by the angle of its front and the sectors of its old faces, radians.

    Its front lies in the plane z = 0, symmetrical about y, and its old crease c below it.
    """
    half = beta / 2
    a = np.array([-np.sin(half), -np.cos(half), 0.0])
    b = np.array([np.sin(half), -np.cos(half), 0.0])
    x = (np.cos(theta3) - np.cos(theta4)) / (2 * np.sin(half))
    y = -(np.cos(theta3) + np.cos(theta4)) / (2 * np.cos(half))
    c = np.array([x, y, -np.sqrt(1 - x * x - y * y)])
    return vertex_family(a, b, c, flap_angles)


def pair_front() -> Front:
    """A front of two interior vertices, with three faces behind it."""
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.6, 0.1], [2.1, 0.05, -0.1], [3.0, 0.6, 0.15]])
    lengths = np.array([[1.0], [0.9], [1.1], [1.0]])
    return Front.between(x, x + lengths * np.array([0.05, -0.5, -0.8]))


def crumpled_strip(
    *, columns: int, strip: int, power: float = 2.0
) -> tuple[GrownStrip, FloatArray]:
    """A strip of a crumpled sheet, counted from 0 after its seed, and the row behind its front."""
    design = Crumpled(columns=columns, strips=strip + 2, random_seed=7, power=power)
    mesh = design.grow().mesh
    return grown_strips(mesh)[strip], mesh.vertices_coords[mesh.grid[-3]]


def loop_sheets() -> list[tuple[str, QuadMesh]]:
    """Three rings of cones whose rims close in each of the three ways (S1 B.2)."""
    return [
        ("7 vertices", _cone(np.ones(7))),
        ("8 vertices, rim in a plane", _cone(np.ones(8))),
        ("8 vertices, rim out of plane", _cone(np.tile([1.3, 1.0, 0.75, 1.0], 2))),
    ]


def _cone(reach: FloatArray) -> QuadMesh:
    """A ring of the cone over a regular polygon, out to these shares of its generators."""
    around = 2 * np.pi * np.arange(len(reach)) / len(reach)
    generators = np.column_stack([np.cos(around), np.sin(around), np.ones_like(around)])
    rows = np.stack([0.5 * generators, reach[:, None] * generators])
    return QuadMesh.from_rows(rows, closed=True)


def surface_fit() -> tuple[QuadMesh, list[GrownStrip]]:
    """The surface fit of figure 4A with the paper's cost S30, and its strips."""
    design = SurfaceFit(
        "waves", method="grow", zigzag=3.0, row_step=1.0, turn=0.0, cost="design_angles"
    )
    mesh = design.grow().mesh
    return mesh, grown_strips(mesh, seed_rows=3)


def offset_lengths(strip: GrownStrip, surface: str = "waves") -> Callable[[Rays], FloatArray]:
    """Lengths to the offset of a surface that a strip reached.

    NaN for creases that miss it, or set out away from it. surface : a name of `SURFACES` that is a
    graph over x = u and y = v.
    """
    target = SURFACES[surface]
    offset = float(np.median(target.distance(strip.row, target.places(strip.row[:, :2]))[0]))
    places = target.places(strip.front.row_coords[:, :2])
    normals = target.normal(places)

    def lengths(rays: Rays) -> FloatArray:
        x, r = rays.vertices_coords, rays.directions
        out = np.full(len(x), np.nan)
        on = np.flatnonzero(dot(normals, r) * offset > 0)
        if len(on):
            out[on] = ray_hit(target, x[on], r[on], offset, places[on])[0]
        return out

    return lengths


def shipped_mesh(name: str) -> QuadMesh:
    """The folded sheet of a shipped job."""
    job = load_job(shipped("jobs")[name])
    design, _ = job.design.design(Path())
    mesh: QuadMesh = design.grow().mesh
    return mesh


def folding_scene(name: str, *, states: int) -> Scene:
    """A shipped job's sheet on its simulated way from flat to folded, at rest at every step."""
    pattern, _ = grown_pattern(load_job(shipped("jobs")[name]))
    folding = fold(framework(pattern, FoldSettings(steps=states)), states)
    return make_scene(folding, name, upright=True)
