"""Goals of makers: bounds of sides, inradii, sectors and folds, room for panels, alike panels.

Bounds of lengths are given in a maker's unit. How long that is in the units of a surface may only
be known of a sheet, whose flat or folded size is given: `Goals.unit` is asked of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from solver.errors import InvalidValue
from solver.hinge_angles import hinge_angles
from solver.incircles import incircles
from solver.measure import sector_angles
from solver.mesh import QuadMesh
from solver.panel_shapes import PanelCount, shape_lengths
from solver.quad_hinges import side_hinges
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["Bounds", "FaceMeasures", "Goals", "PanelRoom", "face_measures"]

# Bounds count as met within rounding.
_MET = 1e-9
# Soft terms aim beyond bounds by this many times what is missed, and by this share of the bound.
_FARTHER, _SAFE = 1.1, 0.005
# A bound of which half of the faces have less than this share is out of reach; one that is missed
# by the second share of it after relaxing is far.
_HALFWAY, _MUCH = 0.7, 0.4
# They hold alike panels to no less than this share of what they may differ by.
_CLOSEST = 0.5


@dataclass(frozen=True)
class PanelRoom:
    """Room that a panel needs in its face: a circle behind the setbacks of its creases.

    Attributes
    ----------
    setbacks : of fold angles, radians, shape (n,): at each of k heights, shape (k, n).
    radius : of the circle. size : by what setbacks are multiplied.
    """

    setbacks: Callable[[FloatArray], FloatArray]
    radius: float
    size: float = 1.0

    def at(self, angles: FloatArray) -> FloatArray:
        """Setbacks at each height, shape (k, n); none where the angle is NaN."""
        known = np.isfinite(angles)
        out = self.size * self.setbacks(np.where(known, angles, 0.0))
        return np.where(known, out, 0.0)


@dataclass(frozen=True)
class Bounds:
    """Bounds of a sheet, lengths in its own units, angles in radians.

    Attributes
    ----------
    least_side, least_inradius : of all faces, the radius of the widest circle in each.
    least_sector : of all sector angles. most_fold : of all fold angles, mountains or valleys.
    panels : room for panels, or None. alike : how many different panels there may be, or None.
    """

    least_side: float = 0.0
    least_inradius: float = 0.0
    least_sector: float = 0.0
    most_fold: float = np.pi
    panels: PanelRoom | None = None
    alike: PanelCount | None = None

    def measures(self, coords: FloatArray, faces_vertices: IntArray) -> FaceMeasures:
        """What these bounds are of, of a sheet; see `face_measures`."""
        return face_measures(coords, faces_vertices, self.panels, self.alike)

    def with_templates(self, coords: FloatArray, faces_vertices: IntArray) -> Bounds:
        """These bounds, of panels that are alike the templates which a sheet has now."""
        if self.alike is None:
            return self
        shapes = self.alike.templates(shape_lengths(coords[faces_vertices]))
        return replace(self, alike=replace(self.alike, shapes=shapes))

    def faces_fine(self, coords: FloatArray, faces_vertices: IntArray) -> BoolArray:
        """`fine` of a sheet with vertices (nv, 3) and faces (nf, 4)."""
        return self.fine(self.measures(coords, faces_vertices))

    def misses(self, reached: FaceMeasures) -> FloatArray:
        """By what share of its bound each of the six is missed, shape (6,); 0 where it is met.

        Folds count as shares of what is left of a half turn.
        """
        straight = np.array([np.pi - reached.most_fold])
        lacks = [
            _lack(self.least_side, reached.side),
            _lack(self.least_inradius, reached.inradius),
            _lack(self.least_sector, reached.sector),
            _lack(np.pi - self.most_fold, straight),
            0.0 if self.panels is None else _lack(self.panels.radius, reached.room),
            0.0 if self.alike is None else _excess(self.alike.within, reached.unlike),
        ]
        return np.array([0.0 if lack <= _MET else lack for lack in lacks])

    def far(self, reached: FaceMeasures) -> bool:
        """Whether any of these but that of alike panels is missed by much: other cells are needed.

        By the sheet, or even by half of its faces.
        """
        return bool((self.misses(reached)[:5] > _MUCH).any()) or self.out_of_reach(reached)

    def out_of_reach(self, reached: FaceMeasures) -> bool:
        """Whether half of the faces are far from a bound of length: only fewer faces are larger."""
        of_panels = 0.0 if self.panels is None else self.panels.radius
        return any(
            np.median(values) < _HALFWAY * bound
            for bound, values in (
                (self.least_side, reached.side),
                (self.least_inradius, reached.inradius),
                (of_panels, reached.room),
            )
        )

    def fine(self, reached: FaceMeasures) -> BoolArray:
        """Whether each face is within the bounds, except that of folds, shape (nf,)."""
        out = (
            (reached.side >= self.least_side * (1 - _MET))
            & (reached.inradius >= self.least_inradius * (1 - _MET))
            & (reached.sector >= self.least_sector * (1 - _MET))
        )
        if self.panels is not None:
            out = out & (reached.room >= self.panels.radius * (1 - _MET))
        if self.alike is not None:
            out = out & (reached.unlike <= self.alike.within * (1 + _MET))
        return np.asarray(out)

    def beyond(self, reached: FaceMeasures, aim: Bounds, share: float = 1.0) -> Bounds:
        """The next aim of soft terms, which end short of it: beyond these bounds and `aim`.

        By a little more than what is missed. With share < 1 it is nearer to what is reached, by
        that share of the way from there to these bounds.
        """

        def next_aim(least: float, values: FloatArray, before: float) -> float:
            low = float(values.min(initial=np.inf))
            if least <= low:
                return max(least, before) if share == 1 else least
            if share < 1:
                return low + share * (least - low)
            return max(least, before) + _FARTHER * (least - low) + _SAFE * least

        panels = self.panels
        if panels is not None:
            before = 0.0 if aim.panels is None else aim.panels.radius
            panels = replace(panels, radius=next_aim(panels.radius, reached.room, before))
        alike = self.alike
        if alike is not None:
            unlike = float(reached.unlike.max(initial=0.0))
            before = alike.within if aim.alike is None else aim.alike.within
            within = before - _FARTHER * max(0.0, unlike - alike.within)
            if share < 1:
                within = unlike + share * (alike.within - unlike)
            alike = replace(alike, within=max(within, _CLOSEST * alike.within))
        straight = np.pi - reached.most_fold
        fold = np.pi - next_aim(np.pi - self.most_fold, np.array([straight]), np.pi - aim.most_fold)
        return Bounds(
            next_aim(self.least_side, reached.side, aim.least_side),
            next_aim(self.least_inradius, reached.inradius, aim.least_inradius),
            next_aim(self.least_sector, reached.sector, aim.least_sector),
            max(fold, self.most_fold / 2),
            panels,
            alike,
        )


@dataclass(frozen=True)
class Goals:
    """What a maker wants of sheets.

    Attributes
    ----------
    bounds : lengths in the maker's unit.
    unit : the length of that unit, in units of a sheet, asked of the sheet and of the vertices of
        all that is folded together, shape (n, 3). None: it is theirs.
    """

    bounds: Bounds
    unit: Callable[[QuadMesh, FloatArray], float] | None = None

    def __post_init__(self) -> None:
        bounds = self.bounds
        for name in ("least_side", "least_inradius"):
            if not 0 <= getattr(bounds, name) < np.inf:
                raise InvalidValue(name, getattr(bounds, name), "be 0 or more", "Give a length.")
        if not 0 <= bounds.least_sector < np.pi / 2:
            raise InvalidValue(
                "least_sector", bounds.least_sector, "be from 0 to pi / 2", "A quad has 2 pi."
            )
        if not 0 < bounds.most_fold <= np.pi:
            raise InvalidValue(
                "most_fold", bounds.most_fold, "be over 0, at most pi", "Flat sheets fold by 0."
            )

    def angles(self) -> Bounds:
        """The bounds that have no length."""
        return Bounds(least_sector=self.bounds.least_sector, most_fold=self.bounds.most_fold)

    def of(self, sheet: QuadMesh, folded: FloatArray, larger: float = 1.0) -> Bounds:
        """The bounds in the units of a sheet, lengths `larger` than they are."""
        unit = larger * (1.0 if self.unit is None else self.unit(sheet, folded))
        bounds, panels = self.bounds, self.bounds.panels
        if panels is not None:
            panels = replace(panels, radius=unit * panels.radius, size=unit * panels.size)
        alike = bounds.alike
        if alike is not None:
            alike = replace(alike, within=unit * alike.within)
        return replace(
            bounds,
            least_side=unit * bounds.least_side,
            least_inradius=unit * bounds.least_inradius,
            panels=panels,
            alike=alike,
        )


@dataclass(frozen=True)
class FaceMeasures:
    """Measures of each face: least side, inradius, least sector, radius for a panel, shape (nf,).

    most_fold : the largest fold angle of the sheet, radians. room is infinite where panels have no
    bounds. unlike : the largest difference of each face from its template, 0 where none are wanted.
    """

    side: FloatArray
    inradius: FloatArray
    sector: FloatArray
    room: FloatArray
    most_fold: float
    unlike: FloatArray


def face_measures(
    coords: FloatArray,
    faces_vertices: IntArray,
    panels: PanelRoom | None = None,
    alike: PanelCount | None = None,
) -> FaceMeasures:
    """What goals bound, of a sheet with vertices (nv, 3) and faces (nf, 4).

    >>> square = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    >>> found = face_measures(square, np.array([[0, 1, 2, 3]]))
    >>> found.side.tolist(), found.inradius.tolist(), np.degrees(found.sector).round(9).tolist()
    ([2.0], [1.0], [90.0])
    """
    corners = coords[faces_vertices]
    side = norm(np.roll(corners, -1, axis=1) - corners).min(axis=1)
    radius = incircles(corners, np.zeros(corners.shape[:2])).radii
    sector = sector_angles(coords, faces_vertices).min(axis=1)
    inner, beside = side_hinges(faces_vertices, len(coords))
    angles = hinge_angles(coords, inner)
    room = np.full(len(corners), np.inf)
    if panels is not None:
        around = np.append(angles, np.nan)[beside]
        for back in panels.at(around.ravel()):
            room = np.minimum(room, incircles(corners, back.reshape(around.shape)).radii)
    unlike = np.zeros(len(corners))
    if alike is not None:
        lengths = shape_lengths(corners)
        unlike = alike.templates(lengths).unlike(lengths)
    return FaceMeasures(side, radius, sector, room, float(np.abs(angles).max(initial=0.0)), unlike)


def _excess(most: float, reached: FloatArray) -> float:
    found = float(reached.max(initial=0.0))
    return max(0.0, 1 - most / found) if found > 0 else 0.0


def _lack(least: float, reached: FloatArray) -> float:
    return max(0.0, 1 - float(reached.min(initial=np.inf)) / least) if least > 0 else 0.0
