"""Where the faces of a sheet lie when all its creases are folded flat."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fab.geometry.rings import ring_areas
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.kinematics import fold_by_angles, unknown_angles
from fab.pattern.open_cuts import opened
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["FlatForm", "flat_form", "folds_flat"]

# Creases within this of 180 degrees are folded flat, and within this of 0 not folded.
_FLAT_DEG = 1e-3
# Around vertices, and over the diagonal of the sheet: what closes less exactly does not fold flat.
_CLOSURE_RAD, _GAP_REL = 1e-3, 1e-3
# Points of the folded form that are nearer to each other than this share of the sheet, or than so
# many times its largest gap, are one.
_REACH_REL, _REACH_GAPS = 1e-8, 2.0


@dataclass(frozen=True)
class FlatForm:
    """A sheet that is folded flat, its cuts open, in millimetres.

    Faces that creases without a fold join are one region, which moves as one.

    Attributes
    ----------
    sheet : the pattern with its cuts open; its faces are numbered as in the pattern.
    coords : shape (nv, 2), folded; the middle face of each piece of the sheet is where it was.
    faces_region : shape (nf,), regions are numbered from 0.
    faces_turned : shape (nf,), faces that look down.
    edges_folded : shape (ne,), creases that fold by 180 degrees.
    edges_sign : shape (ne,), 1 for valleys, -1 for mountains, 0 where either may be, or no fold.
    edges_source : shape (ne,), numbers in the pattern before its cuts were opened.
    assumed : number of creases of unknown angle, which are folded as well.
    gap_mm : largest distance of a vertex from where one of its faces has it.
    reach_mm : points that are nearer to each other than this are one.
    """

    sheet: CreasePattern
    coords: FloatArray
    faces_region: IntArray
    faces_turned: BoolArray
    edges_folded: BoolArray
    edges_sign: IntArray
    edges_source: IntArray
    assumed: int
    gap_mm: float
    reach_mm: float

    @property
    def region_count(self) -> int:
        """Number of regions."""
        return int(self.faces_region.max(initial=-1)) + 1


def folds_flat(pattern: CreasePattern) -> bool:
    """Whether the angles of all creases are 180 degrees or 0, or not known, and some fold."""
    angles = np.abs(pattern.edges_foldAngle[pattern.edges_joining])
    free = unknown_angles(pattern)[pattern.edges_joining]
    folded = angles >= 180 - _FLAT_DEG
    flat = (angles <= _FLAT_DEG) | folded
    return bool(flat.all() and (folded | free).any())


def flat_form(pattern: CreasePattern) -> FlatForm | None:
    """The flat-folded form of a pattern; None where its angles are others, or do not close.

    Creases of unknown angle (letter U) are folded by 180 degrees, to either side.
    """
    if not folds_flat(pattern):
        return None
    open_sheet = opened(pattern)
    sheet = open_sheet.pattern
    free = unknown_angles(sheet) & sheet.edges_joining
    sheet = replace(sheet, edges_foldAngle=np.where(free, 180.0, sheet.edges_foldAngle))
    size = float(np.hypot(*np.ptp(sheet.vertices_coords, axis=0)))
    kinematics = fold_by_angles(sheet)
    if max(kinematics.closure_max_rad, kinematics.gap_rad) > _CLOSURE_RAD:
        return None
    if kinematics.gap_mm > _GAP_REL * size:
        return None
    folded = sheet.edges_joining & (np.abs(sheet.edges_foldAngle) >= 180 - _FLAT_DEG)
    coords = kinematics.folded_coords[:, :2]
    areas = ring_areas(coords[sheet.faces_vertices], sheet.faces_offsets)
    turned = areas < 0
    across = turned[sheet.edges_faces]
    if (across[folded, 0] == across[folded, 1]).any():
        return None  # faces too small to say how they lie
    sign = np.sign(sheet.edges_foldAngle).astype(np.int64)
    return FlatForm(
        sheet,
        coords,
        labels(sheet.edges_faces[sheet.edges_joining & ~folded], sheet.face_count),
        turned,
        folded,
        np.where(folded & ~free, sign, 0),
        open_sheet.edges_source,
        int(free.sum()),
        kinematics.gap_mm,
        max(_REACH_REL * size, _REACH_GAPS * kinematics.gap_mm),
    )
