"""Geometry of quad origami: a seed strip, growth strip by strip, and measures of the result.

After L. H. Dudte, G. P. T. Choi and L. Mahadevan, "An additive algorithm for origami design",
PNAS 118 (2021), and its supplementary information; sections and equations below are of the latter.
Lengths are in any unit, angles in radians. No materials, machines or files: see `fab`.

Seeds: a first strip, or only a curve in space (the corollary)
    `seeds.curve`, `seeds.miura`, `seeds.corrugated`, `QuadMesh.from_rows`; module `seeds`.
Single vertex, S1 (S13): two old creases, the angle k they leave, one flap angle
    `growth_direction`, `design_angles`, `flap_angle_of`; module `vertex`.
Choices of its flap angle, S2
    `even_flap_angles`, `flat_foldable_flap_angles`, `continuation_flap_angles`,
    `locked_flap_angles`, `self_intersects`; module `vertex`.
Flap-angle chain: one flap angle decides all others of a strip, S44 to S49
    `coupling`, `half_angles`, `transfer_matrices`, `inverse_matrices`, `transfer_flap_angles`,
    `transfer_derivative`; module `transfer`.
Closed fronts, S1 B.2: the flap angles for which a ring closes
    `loop_closings`, `Closings`, `Closing`, `loop_misses`; module `transfer`.
All around the circle of the flap angle: a vertex, a strip, and the landscape of a cost (S13)
    `vertex_family`, `strip_family`, `flap_angle_landscape`; modules `vertex_family`, `strip_family`
    and `flap_landscape`. The strips of a finished sheet one after another: `grown_strips`, module
    `growth_order`.
Growth front: its angles beta and k, new creases, length bounds (S20, S21)
    `Front`, `Rays`; modules `front` and `rays`.
Growth strip by strip, on any side of a patch
    `grow`, `Strip`, `Stop`, `Growth`, `Status`, `Side`; module `growth`.
Strips that are chosen one by one: which of them can be grown, and a proposal
    `ChosenStrip`, `StripByStrip`; module `strip_choices`.
Growth whose rows may end where vertices at their sides cannot be grown
    `grow_ending`; module `ending_rows`.
Growth on a part of a front and around a corner, S1 B.1
    `grow_part`, `grow_corner`, `grow_pentagon`, `CornerStrip`; module `corner`.
Surface fitting, S4
    `fit_surface`, and the surfaces of `solver.targets`; modules `fitting` and `following`. Costs of
    the flap angle, S30 among them, as landscapes: modules `flap_costs` and `mirroring`.
Sheets that fold rigidly and flat, marched from a row and a column, with their one motion
    `march`, `RigidSheet`; modules `rigid_march` and `flat_foldable`.
Relaxation: all vertices of a sheet at once, onto any surface
    `relax`, `relaxed_sheet` and their terms; package `solver.relaxation`. As many sheets as a
    surface needs: `relaxed_fit`, `surface_sheets`; modules of these names. Maps of surfaces, cuts
    and cover: modules `surface_maps`, `surface_cuts`, `surface_cover`.
Designs of the figures
    `Miura`, `CurvedFold` and the others of `DESIGNS`; package `solver.designs`.
Exactness of the result
    `planarity`, `developability`, `isometry`; module `measure`.

The patch that grows is a `QuadMesh`. Arguments that cannot be used raise `InvalidValue`, or its
subclass `InvalidState` where no single value is at fault; both are `OrigamiError`. Growth that
cannot go on is no error: it keeps what it has and gives a `Status` with advice.

>>> growth = Miura(columns=6, rows=4).grow()
>>> growth.status, growth.mesh.faces_vertices.shape
(<Status.GROWN: 'grown'>, (24, 4))
>>> faces = growth.mesh.faces_vertices
>>> bool(planarity(growth.mesh.vertices_coords, faces).max() < 1e-12)
True
>>> bool(developability(growth.mesh.vertices_coords, faces).max() < 1e-12)
True
"""

from solver import seeds
from solver.corner import CornerStrip, grow_corner, grow_part, grow_pentagon
from solver.designs import (
    DESIGNS,
    BrownianRibbon,
    ClosedCurvedFold,
    CorneredMiura,
    Crumpled,
    CurvedFold,
    Design,
    Miura,
    RandomTube,
    RigidMiura,
    ShapedRibbon,
    StripByStrip,
    SurfaceFit,
    TiltedRings,
)
from solver.errors import InvalidState, InvalidValue, OrigamiError
from solver.fitting import fit_surface
from solver.flap_landscape import FlapLandscape, flap_angle_landscape
from solver.front import Front
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.growth_order import GrownStrip, grown_strips
from solver.measure import developability, isometry, planarity
from solver.mesh import QuadMesh, Side
from solver.rays import Rays
from solver.rigid_march import RigidSheet, march
from solver.strip_choices import ChosenStrip
from solver.strip_family import StripFamily, strip_family
from solver.targets import (
    Frame,
    ImplicitSurface,
    MeshSurface,
    ParametricSurface,
    Target,
    TurnedTarget,
    explicit_surface,
    ray_hit,
)
from solver.transfer import (
    Closing,
    Closings,
    coupling,
    half_angles,
    inverse_matrices,
    loop_closings,
    loop_misses,
    transfer_derivative,
    transfer_flap_angles,
    transfer_matrices,
)
from solver.vertex import (
    continuation_flap_angles,
    design_angles,
    even_flap_angles,
    flap_angle_of,
    flat_foldable_flap_angles,
    growth_direction,
    locked_flap_angles,
    self_intersects,
)
from solver.vertex_family import VertexFamily, vertex_family

__all__ = [
    "DESIGNS",
    "BrownianRibbon",
    "ChosenStrip",
    "ClosedCurvedFold",
    "Closing",
    "Closings",
    "CornerStrip",
    "CorneredMiura",
    "Crumpled",
    "CurvedFold",
    "Design",
    "FlapLandscape",
    "Frame",
    "Front",
    "GrownStrip",
    "Growth",
    "ImplicitSurface",
    "InvalidState",
    "InvalidValue",
    "MeshSurface",
    "Miura",
    "OrigamiError",
    "ParametricSurface",
    "QuadMesh",
    "RandomTube",
    "Rays",
    "RigidMiura",
    "RigidSheet",
    "ShapedRibbon",
    "Side",
    "Status",
    "Stop",
    "Strip",
    "StripByStrip",
    "StripFamily",
    "SurfaceFit",
    "Target",
    "TiltedRings",
    "TurnedTarget",
    "VertexFamily",
    "continuation_flap_angles",
    "coupling",
    "design_angles",
    "developability",
    "even_flap_angles",
    "explicit_surface",
    "fit_surface",
    "flap_angle_landscape",
    "flap_angle_of",
    "flat_foldable_flap_angles",
    "grow",
    "grow_corner",
    "grow_part",
    "grow_pentagon",
    "grown_strips",
    "growth_direction",
    "half_angles",
    "inverse_matrices",
    "isometry",
    "locked_flap_angles",
    "loop_closings",
    "loop_misses",
    "march",
    "planarity",
    "ray_hit",
    "seeds",
    "self_intersects",
    "strip_family",
    "transfer_derivative",
    "transfer_flap_angles",
    "transfer_matrices",
    "vertex_family",
]
