"""Geometry of quad origami: seeds, growth strip by strip, and what the result measures."""

from solver.designs import (
    DESIGNS,
    BrownianRibbon,
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
from solver.target_frames import Frame
from solver.target_implicit import ImplicitSurface
from solver.target_meshes import MeshSurface
from solver.targets import ParametricSurface, explicit_surface

__all__ = [
    "DESIGNS",
    "BrownianRibbon",
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
    "Side",
    "Status",
    "Stop",
    "Strip",
    "SurfaceFit",
    "TiltedRings",
    "developability",
    "explicit_surface",
    "grow",
    "isometry",
    "planarity",
]
