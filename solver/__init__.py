"""Geometry of quad origami: seeds, growth strip by strip, and what the result measures."""

from solver.designs import (
    DESIGNS,
    BrownianRibbon,
    Crumpled,
    CurvedFold,
    Design,
    Miura,
    RandomTube,
    TiltedRings,
)
from solver.errors import InvalidValue, OrigamiError
from solver.front import Front, Rays
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.measure import developability, isometry, planarity
from solver.mesh import QuadMesh, Side

__all__ = [
    "DESIGNS",
    "BrownianRibbon",
    "Crumpled",
    "CurvedFold",
    "Design",
    "Front",
    "Growth",
    "InvalidValue",
    "Miura",
    "OrigamiError",
    "QuadMesh",
    "RandomTube",
    "Rays",
    "Side",
    "Status",
    "Stop",
    "Strip",
    "TiltedRings",
    "developability",
    "grow",
    "isometry",
    "planarity",
]
