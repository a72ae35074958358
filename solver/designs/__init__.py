"""Designs of the paper's figures, by name in `DESIGNS`.

Each is one short module that reads like its paragraph in the paper: a frozen dataclass of its
parameters, in radians and design units, whose `grow` gives a `solver.Growth`.

>>> DESIGNS["miura"](columns=4, rows=3).grow().strips
2
"""

from __future__ import annotations

from solver.designs.brownian_ribbon import BrownianRibbon
from solver.designs.closed_curved_fold import ClosedCurvedFold
from solver.designs.cornered_miura import CorneredMiura
from solver.designs.crumpled import Crumpled
from solver.designs.curved_fold import CurvedFold
from solver.designs.miura import Miura
from solver.designs.random_tube import RandomTube
from solver.designs.rigid_miura import RigidMiura
from solver.designs.shaped_ribbon import ShapedRibbon
from solver.designs.strip_by_strip import StripByStrip
from solver.designs.surface_fit import SurfaceFit
from solver.designs.tilted_rings import TiltedRings

__all__ = [
    "DESIGNS",
    "BrownianRibbon",
    "ClosedCurvedFold",
    "CorneredMiura",
    "Crumpled",
    "CurvedFold",
    "Design",
    "Miura",
    "RandomTube",
    "RigidMiura",
    "ShapedRibbon",
    "StripByStrip",
    "SurfaceFit",
    "TiltedRings",
]

Design = (
    BrownianRibbon
    | ClosedCurvedFold
    | CorneredMiura
    | Crumpled
    | CurvedFold
    | Miura
    | RandomTube
    | RigidMiura
    | ShapedRibbon
    | StripByStrip
    | SurfaceFit
    | TiltedRings
)

DESIGNS: dict[str, type[Design]] = {
    "brownian_ribbon": BrownianRibbon,
    "closed_curved_fold": ClosedCurvedFold,
    "cornered_miura": CorneredMiura,
    "crumpled": Crumpled,
    "curved_fold": CurvedFold,
    "miura": Miura,
    "random_tube": RandomTube,
    "rigid_miura": RigidMiura,
    "shaped_ribbon": ShapedRibbon,
    "strip_by_strip": StripByStrip,
    "surface_fit": SurfaceFit,
    "tilted_rings": TiltedRings,
}
