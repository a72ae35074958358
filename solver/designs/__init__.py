"""Which designs are there? Each is one short module that reads like its paragraph in the paper."""

from __future__ import annotations

from solver.designs.brownian_ribbon import BrownianRibbon
from solver.designs.cornered_miura import CorneredMiura
from solver.designs.crumpled import Crumpled
from solver.designs.curved_fold import CurvedFold
from solver.designs.miura import Miura
from solver.designs.random_tube import RandomTube
from solver.designs.surface_fit import SurfaceFit
from solver.designs.tilted_rings import TiltedRings

__all__ = [
    "DESIGNS",
    "BrownianRibbon",
    "CorneredMiura",
    "Crumpled",
    "CurvedFold",
    "Design",
    "Miura",
    "RandomTube",
    "SurfaceFit",
    "TiltedRings",
]

Design = (
    BrownianRibbon
    | CorneredMiura
    | Crumpled
    | CurvedFold
    | Miura
    | RandomTube
    | SurfaceFit
    | TiltedRings
)

DESIGNS: dict[str, type[Design]] = {
    "brownian_ribbon": BrownianRibbon,
    "cornered_miura": CorneredMiura,
    "crumpled": Crumpled,
    "curved_fold": CurvedFold,
    "miura": Miura,
    "random_tube": RandomTube,
    "surface_fit": SurfaceFit,
    "tilted_rings": TiltedRings,
}
