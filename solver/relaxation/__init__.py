"""Relaxation: quad origami fitted to any surface, all vertices at once.

Growth holds every vertex exactly on its offset and is left with one flap angle a strip: on domes
its errors grow from row to row. Relaxation lets the vertices of the whole sheet move, hard terms
exact to rounding and soft ones as small as can be.

| terms | module |
|---|---|
| `PlanarFaces`, `DevelopableVertices`, `FlatFoldableVertices`: hard | `constraints` |
| `MeetingVertices`: hard, of several sheets | `constraints` |
| `SurfaceOffsets`, `RimReach`, `SideLengths`, `LeastDistances`, `FoldBounds`: soft | `objectives` |
| any class with the attributes of `Term` | `terms` |

`relax` takes terms and a start, `relaxed_sheet` a surface (`solver.targets`) and a `PleatedSheet`
over it (`pleated_patch`, `pleated_tube`). Arrays are float64, vertex coordinates of shape (nv, 3),
lengths in any unit, angles in radians. Search: module `minimisation`; last steps to rounding:
module `projection`; their sparse systems: `solver.assembly`, `solver.sparse`.

Sources: L. H. Dudte, E. Vouga, T. Tachi and L. Mahadevan, "Programming curvature using origami
tessellations", Nature Materials 15 (2016); T. Tachi, "Generalization of rigid foldable
quadrilateral mesh origami", Journal of the IASS 50 (2009).
"""

from solver.relaxation.constraints import (
    DevelopableVertices,
    FlatFoldableVertices,
    MeetingVertices,
    PlanarFaces,
)
from solver.relaxation.method import Relaxation, RelaxationStatus, relax
from solver.relaxation.minimisation import Soft
from solver.relaxation.objectives import (
    FoldBounds,
    LeastDistances,
    RimReach,
    SideLengths,
    SurfaceOffsets,
)
from solver.relaxation.pleats import Cell, PleatedSheet, pleated_patch, pleated_tube, prolonged
from solver.relaxation.sheet_fit import SheetFit, Wishes, relaxed_sheet
from solver.relaxation.terms import Linear, Term

__all__ = [
    "Cell",
    "DevelopableVertices",
    "FlatFoldableVertices",
    "FoldBounds",
    "LeastDistances",
    "Linear",
    "MeetingVertices",
    "PlanarFaces",
    "PleatedSheet",
    "Relaxation",
    "RelaxationStatus",
    "RimReach",
    "SheetFit",
    "SideLengths",
    "Soft",
    "SurfaceOffsets",
    "Term",
    "Wishes",
    "pleated_patch",
    "pleated_tube",
    "prolonged",
    "relax",
    "relaxed_sheet",
]
