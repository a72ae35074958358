"""Geometry of quad origami: seeds, growth strip by strip, and what the result measures."""

from solver.corner import CornerStrip, grow_corner, grow_part, grow_pentagon
from solver.designs import (
    DESIGNS,
    BrownianRibbon,
    CorneredMiura,
    Crumpled,
    CurvedFold,
    Design,
    Miura,
    RandomTube,
    SurfaceFit,
    TiltedRings,
)
from solver.errors import InvalidValue, OrigamiError
from solver.front import Front, Rays
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.measure import developability, isometry, planarity
from solver.mesh import QuadMesh, Side
from solver.targets import ParametricSurface, explicit_surface

__all__ = [
    "DESIGNS",
    "BrownianRibbon",
    "CornerStrip",
    "CorneredMiura",
    "Crumpled",
    "CurvedFold",
    "Design",
    "Front",
    "Growth",
    "InvalidValue",
    "Miura",
    "OrigamiError",
    "ParametricSurface",
    "QuadMesh",
    "RandomTube",
    "Rays",
    "Side",
    "Status",
    "Stop",
    "Strip",
    "SurfaceFit",
    "TiltedRings",
    "developability",
    "explicit_surface",
    "grow",
    "grow_corner",
    "grow_part",
    "grow_pentagon",
    "isometry",
    "planarity",
]
