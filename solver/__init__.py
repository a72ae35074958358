"""Geometry of quad origami: seeds, growth strip by strip, and what the result measures."""

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
    ShapedRibbon,
    SurfaceFit,
    TiltedRings,
)
from solver.errors import InvalidValue, OrigamiError
from solver.fitting import fit_surface
from solver.front import Front, Rays
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.measure import developability, isometry, planarity
from solver.mesh import QuadMesh, Side
from solver.target_frames import Frame
from solver.target_implicit import ImplicitSurface
from solver.target_meshes import MeshSurface
from solver.targets import ParametricSurface, Target, TurnedTarget, explicit_surface, ray_hit

__all__ = [
    "DESIGNS",
    "BrownianRibbon",
    "ClosedCurvedFold",
    "CornerStrip",
    "CorneredMiura",
    "Crumpled",
    "CurvedFold",
    "Design",
    "Frame",
    "Front",
    "Growth",
    "ImplicitSurface",
    "InvalidValue",
    "MeshSurface",
    "Miura",
    "OrigamiError",
    "ParametricSurface",
    "QuadMesh",
    "RandomTube",
    "Rays",
    "ShapedRibbon",
    "Side",
    "Status",
    "Stop",
    "Strip",
    "SurfaceFit",
    "Target",
    "TiltedRings",
    "TurnedTarget",
    "developability",
    "explicit_surface",
    "fit_surface",
    "grow",
    "grow_corner",
    "grow_part",
    "grow_pentagon",
    "isometry",
    "planarity",
    "ray_hit",
]
