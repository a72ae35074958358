"""Target surfaces: what a sheet follows, between two offsets of it, grown or relaxed.

A `Target` gives points, unit normals, signed distances and a domain, all by places whose first two
numbers are the parameters u and v in [-1, 1]. Six kinds are here; any class with the methods of
`Target` is one more.

| surface | class or function | module |
|---|---|---|
| X(u, v) | `ParametricSurface` | `parametric` |
| z = f(x, y) | `explicit_surface` | `parametric` |
| g(x, y, z) = 0 within a `Frame` | `ImplicitSurface` | `implicit` |
| triangle or quad mesh, from arrays or from an STL, OBJ or PLY file | `MeshSurface` | `mesh` |
| `SurfaceMesh` of any topology, followed as a smooth one | `MeshTarget` | `mesh_target` |
| any of these with u and v turned | `TurnedTarget` | `parametric` |

A `SurfaceMesh` has known topology (`MeshKind`); `smoothed`, `noise_level` and `smoothing_length`
(module `smoothing`), `decimated` and `refined` make others of it. Any other target is one by
`solver.relaxed_fit.sampled`; named ones are in `solver.designs.surface_fit` and `.shells`.

`ray_hit` (module `base`) finds where rays meet an offset of any of them.
"""

from solver.targets.base import Target, ray_hit
from solver.targets.frame import Frame
from solver.targets.implicit import ImplicitSurface
from solver.targets.mesh import MeshSurface
from solver.targets.mesh_target import MeshTarget
from solver.targets.parametric import ParametricSurface, TurnedTarget, explicit_surface
from solver.targets.surface_mesh import MeshKind, SurfaceMesh

__all__ = [
    "Frame",
    "ImplicitSurface",
    "MeshKind",
    "MeshSurface",
    "MeshTarget",
    "ParametricSurface",
    "SurfaceMesh",
    "Target",
    "TurnedTarget",
    "explicit_surface",
    "ray_hit",
]
