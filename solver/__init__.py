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
from solver.targets.base import Target, ray_hit
from solver.targets.frame import Frame
from solver.targets.implicit import ImplicitSurface
from solver.targets.mesh import MeshSurface
from solver.targets.parametric import ParametricSurface, TurnedTarget, explicit_surface

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
