"""Geometry of quad origami: seeds, growth strip by strip, and what the result measures."""

from solver.designs import DESIGNS, Crumpled, CurvedFold, Design, Miura
from solver.errors import InvalidValue, OrigamiError
from solver.front import Front, Rays
from solver.growth import Growth, Status, Strip, grow
from solver.measure import developability, isometry, planarity
from solver.mesh import QuadMesh, Side

__all__ = [
    "DESIGNS",
    "Crumpled",
    "CurvedFold",
    "Design",
    "Front",
    "Growth",
    "InvalidValue",
    "Miura",
    "OrigamiError",
    "QuadMesh",
    "Rays",
    "Side",
    "Status",
    "Strip",
    "developability",
    "grow",
    "isometry",
    "planarity",
]
