"""Which designs are there? Each is one short module that reads like its paragraph in the paper."""

from __future__ import annotations

from solver.designs.crumpled import Crumpled
from solver.designs.curved_fold import CurvedFold
from solver.designs.miura import Miura

__all__ = ["DESIGNS", "Crumpled", "CurvedFold", "Design", "Miura"]

Design = Crumpled | CurvedFold | Miura

DESIGNS: dict[str, type[Design]] = {
    "crumpled": Crumpled,
    "curved_fold": CurvedFold,
    "miura": Miura,
}
