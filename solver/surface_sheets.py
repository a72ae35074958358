"""Sheets for a surface of any topology: relaxed onto it whole, opened along a cut, or in parts.

| surface | sheets |
|---|---|
| disc, also with holes | a patch over its map (`laying`), trimmed to the rim (`rim_trimming`) |
| ring | a tube around it, or a patch with a hole |
| torus, one-sided band | the same, opened along the shortest cut |
| closed, or where none of these is good | the same for its two halves, again and again |

Several shapes of cells and directions are tried; a sheet is good if it is exact, does not cross
itself, covers its part and stays near its offsets. Of good ones the one with the largest least
sector angle is taken: slim faces are hard to make. Of sheets that fold rigidly, which have no
freedom left to follow a surface, it is the one nearest to its offsets. Where makers have goals
(`solver.goals`), it is the one of those that miss them least. Rims of several sheets are brought
together last (`solver.sheets_meeting`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.errors import InvalidState, InvalidValue, require_count
from solver.goals import Bounds, FaceMeasures, Goals
from solver.relaxation.laying import Pleats, held_vertices, laid_patch, laid_tube, rim_planes
from solver.relaxation.pleats import PleatedSheet
from solver.relaxation.rim_trimming import trimmings
from solver.relaxation.sheet_fit import Wishes, relaxed_sheet
from solver.self_intersection import crossing_faces
from solver.sheets_meeting import met_sheets
from solver.surface_cover import covered
from solver.surface_cuts import halves, opened
from solver.surface_maps import cylinder_map, disc_map, principal_turn
from solver.surface_sheet import SurfaceSheet, least_sector
from solver.targets.mesh_target import MeshTarget
from solver.targets.surface_mesh import MeshKind, SurfaceMesh
from solver.vectors import FloatArray

__all__ = [
    "MOST_COLUMNS",
    "MOST_SHEETS",
    "NARROW_PLEATS",
    "PLEATS",
    "TURNS",
    "SurfaceSheets",
    "surface_sheets",
]

# Cells that are tried, the most usual first, and directions from the map's longest extent.
PLEATS = (
    Pleats(),
    Pleats(zigzag=1.0),
    Pleats(zigzag=0.7),
    Pleats(spacing=1.5),
    Pleats(zigzag=3.0),
    Pleats(stretch=1.3),
    Pleats(zigzag=1.0, thickness=0.6),
    Pleats(zigzag=0.5),
    Pleats(zigzag=0.5, stretch=1.25),
)
TURNS = (np.pi / 2, 0.0, np.pi / 4)
# Narrow ones that are tried last around a part of a surface: with many of them around it, folds of
# the same depth reach from wide places to narrow ones.
NARROW_PLEATS = (
    Pleats(zigzag=0.2, spacing=0.5, thickness=0.4, stretch=1.2),
    Pleats(zigzag=0.15, spacing=0.4, thickness=0.35, stretch=1.2),
    Pleats(zigzag=0.1, spacing=0.4, thickness=0.5, stretch=1.2),
    Pleats(zigzag=0.3, spacing=0.55, thickness=0.45, stretch=1.2),
    Pleats(zigzag=0.3, spacing=0.6, thickness=0.5, stretch=1.2),
    Pleats(zigzag=0.3, spacing=0.7, thickness=0.5, stretch=1.2),
)
# Good sheets among which the best is taken.
_CHOICES = 2
# The same where none is within the goals.
_MOST_CHOICES = 6
# A sheet is relaxed towards its goals so often, at most, and no more where this share is still
# missed of what was before.
_GOAL_ROUNDS = 4
_NO_NEARER = 0.8
# A part of a surface with more than this share of its area is the whole of it.
_WHOLE = 0.999
# Shares of a sheet that may be lost where it reaches over the rim by more than half a cell: the
# first with which this much is covered, or else none.
_MAY_FALL = (0.02, 0.006, 0.0)
_WELL_COVERED = 0.993
# Sheets of more columns are tried with this number first.
_FIRST_COLUMNS = 24
# The same around a part of a surface.
_FIRST_AROUND = 40
MOST_COLUMNS = 400
# Finer sheets hold all but sides and rim by as much more, at most, else the rim bends them.
_FIRMEST = 4.0
# A surface is halved at most twice.
MOST_SHEETS = 4


@dataclass(frozen=True)
class SurfaceSheets:
    """All sheets of a surface, and the share of it that they cover together."""

    sheets: tuple[SurfaceSheet, ...]
    coverage: float

    @property
    def good(self) -> bool:
        """Whether all of them are."""
        return all(sheet.good for sheet in self.sheets)


def surface_sheets(
    mesh: SurfaceMesh,
    columns: int,
    *,
    pleats: Sequence[Pleats] = PLEATS,
    narrow_pleats: Sequence[Pleats] = NARROW_PLEATS,
    turns: Sequence[float] = TURNS,
    wishes: Wishes | None = None,
    goals: Goals | None = None,
    most_sheets: int = MOST_SHEETS,
    nearest: bool = False,
    progress: Callable[[int, int], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> SurfaceSheets:
    """Sheets that cover a surface.

    Parameters
    ----------
    columns : faces across the map of the surface along the lines of the sheet, or around a tube.
    pleats, turns : what is tried; turns are directions of the lines, radians from the longest
        extent of the map.
    narrow_pleats : what is tried after them around a part that is a tube.
    wishes : soft terms; None for the usual ones. goals : of makers: sheets are relaxed towards
        them, and among good ones those that miss them least are preferred.
    most_sheets : 1 for one that is not halved, good or not.
    nearest : whether of good sheets that nearest to the surface is preferred.
    progress : called with the number of settings tried and about how many there are.
    interrupted : asked between rounds; once it is true the best so far is returned.

    Raises `InvalidValue` for numbers out of bounds and `InvalidState` where no sheet can begin.

    >>> from solver.relaxation.laying import Pleats
    >>> y, x = np.mgrid[-1:1:17j, -1:1:17j].reshape(2, -1)
    >>> dome = np.column_stack([x, y, 0.4 * (2 - x**2 - y**2)])
    >>> k = np.arange(17 * 16).reshape(16, 17)[:, :-1].ravel()
    >>> corners = (k, k + 1, k + 18), (k, k + 18, k + 17)
    >>> triangles = np.concatenate([np.stack(c, axis=1) for c in corners])
    >>> found = surface_sheets(SurfaceMesh.of(dome, triangles), 10, turns=[0.0])
    >>> found.good, len(found.sheets), found.coverage > 0.99
    (True, 1, True)
    """
    require_count("columns", columns, 4, "A sheet needs vertices to follow a surface.")
    if columns > MOST_COLUMNS:
        raise InvalidValue(
            "columns", columns, f"be at most {MOST_COLUMNS}", "More would take hours."
        )
    require_count("most_sheets", most_sheets, 1, "The surface needs one.")
    search = _Search(
        tuple(pleats),
        tuple(narrow_pleats),
        tuple(turns),
        wishes or Wishes(),
        goals,
        mesh,
        progress,
        interrupted,
        nearest,
    )
    sheets = tuple(search.sheets_of(mesh, columns, most_sheets))
    target = MeshTarget(mesh)
    if len(sheets) > 1 and not search.wishes.rigid:
        sheets = met_sheets(target, sheets, search.judged, interrupted)
    reach = 2 * max(sheet.step * sheet.pleats.thickness for sheet in sheets)
    under = covered(
        target, [(s.mesh.vertices_coords, s.mesh.faces_vertices) for s in sheets], reach
    )
    return SurfaceSheets(sheets, float(under.mean()))


@dataclass
class _Search:
    pleats: tuple[Pleats, ...]
    narrow_pleats: tuple[Pleats, ...]
    turns: tuple[float, ...]
    wishes: Wishes
    goals: Goals | None
    whole: SurfaceMesh
    progress: Callable[[int, int], None] | None
    interrupted: Callable[[], bool] | None
    nearest: bool = False
    surfaces: int = 1  # whole ones and parts that are known to be looked at
    begun: int = 0
    tried: int = 0  # settings, of the last one begun

    def sheets_of(self, mesh: SurfaceMesh, columns: int, most: int) -> list[SurfaceSheet]:
        """The best single sheet, or those of the halves where it is not good."""
        if mesh.kind is MeshKind.SPHERE:
            if most < 2:
                raise InvalidState(
                    "surface",
                    "a closed surface cannot be covered by one sheet",
                    "Allow two sheets, or cut it to a tube.",
                )
            return self._halved(mesh, columns, most)
        whole = opened(mesh) or mesh
        best = self._best(whole, columns)
        if best is not None and (best.good or most < 2 or self._stopped()):
            return [best]
        parts = self._halved(mesh, columns, most) if most > 1 else []
        if best is None and not parts:
            raise InvalidState(
                "surface", "no sheet can begin on it", "Try more columns, or a part of it."
            )
        if best is None or (parts and sum(p.faults for p in parts) < best.faults):
            return parts
        return [best]

    def _halved(self, mesh: SurfaceMesh, columns: int, most: int) -> list[SurfaceSheet]:
        parts = halves(mesh)
        if not 2 <= len(parts) <= most:
            return []
        self.surfaces += len(parts)
        found = []
        for part in parts:
            share = max(4, round(columns * np.sqrt(part.area / mesh.area)))
            found += self.sheets_of(part, share, most // 2)
        return found

    def _best(self, mesh: SurfaceMesh, columns: int) -> SurfaceSheet | None:
        """The best sheet of this many columns, found with fewer first where these are many."""
        self.begun, self.tried = self.begun + 1, 0
        ranked: list[tuple[float, float, float, SurfaceSheet, _Lay]] = []
        for lay in self._lays(mesh, columns):
            for pleats, turn in self._settings(lay):
                sheet = self._tried(lay, lay.first_columns, pleats, turn)
                if sheet is not None:
                    ranked.append((sheet.faults, sheet.missed, self._rank(sheet), sheet, lay))
                if self._stopped() or _enough(ranked):
                    break
            if any(r[0] == 0 for r in ranked):
                break
        ranked.sort(key=lambda r: r[:3])
        found: list[SurfaceSheet] = []
        for *_, coarse, lay in ranked[:3]:
            if lay.columns == lay.first_columns:
                return coarse
            sheet = self._tried(lay, lay.columns, coarse.pleats, coarse.turn)
            if sheet is not None:
                found.append(sheet)
            if self._stopped() or any(one.good and not one.missed for one in found):
                break
        return min(found, key=lambda one: (one.faults, one.missed), default=None)

    def _rank(self, sheet: SurfaceSheet) -> float:
        """What is least of the best among good sheets."""
        if self.wishes.rigid:
            return sheet.off
        return sheet.distance if self.nearest else -sheet.least_sector

    def _lays(self, mesh: SurfaceMesh, columns: int) -> Iterator[_Lay]:
        """A tube around a ring, and a patch; on a torus, which is long around, a tube alone."""
        whole = mesh.area > _WHOLE * self.whole.area
        if mesh.kind is MeshKind.RING:
            yield from _Lay.of(_tube, mesh, columns, whole)
        if not (whole and self.whole.kind is MeshKind.TORUS):
            yield from _Lay.of(_patch, mesh, columns, whole)

    def _settings(self, lay: _Lay) -> Iterator[tuple[Pleats, float]]:
        if not lay.around:
            for pleats in self.pleats:
                for turn in self.turns:
                    yield pleats, turn
            return
        # around a tube small zigzags reach furthest
        for pleats in sorted(self.pleats, key=lambda one: one.zigzag):
            yield pleats, self.turns[0]
        if not lay.whole:
            for pleats in self.narrow_pleats:
                yield pleats, self.turns[0]

    def _tried(self, lay: _Lay, columns: int, pleats: Pleats, turn: float) -> SurfaceSheet | None:
        """The sheet of a setting, of so many columns; None where there is none."""
        self.tried += 1
        if self.progress is not None:
            each = len(self.pleats) * len(self.turns)
            done = (self.begun - 1) * each + min(self.tried, each)
            self.progress(done, max(self.surfaces, self.begun) * each)
        try:
            laid = _Laid(lay, lay.sheet(columns, pleats, turn), pleats, turn, columns)
            return self._near_goals(laid, lay.columns / columns)
        except InvalidState:
            return None

    def _relaxed(
        self,
        laid: _Laid,
        aim: Bounds,
        start: FloatArray | None = None,
        wanted: Bounds | None = None,
    ) -> tuple[SurfaceSheet, FloatArray]:
        """A sheet relaxed and trimmed, and all its vertices before it was trimmed.

        aim : bounds of its soft terms; wanted : those that faces keep when they are trimmed.
        """
        target, sheet, pleats = laid.lay.target, laid.sheet, laid.pleats
        firm = min(max(1.0, (laid.columns / _FIRST_COLUMNS) ** 2), _FIRMEST)
        wishes = replace(
            self.wishes,
            bounds=aim,
            offset=self.wishes.offset * firm,
            least=self.wishes.least * firm,
            fold=self.wishes.fold * firm,
            bound=self.wishes.bound * firm,
        )
        held = held_vertices(target, sheet)
        fit = relaxed_sheet(
            target,
            sheet,
            wishes,
            held=held,
            rim=rim_planes(target, sheet),
            start=start,
            interrupted=self.interrupted,
        )
        fine_faces = None
        if wanted is not None:
            now = fit.relaxation.coords, sheet.faces_vertices
            fine_faces = wanted.with_templates(*now).faces_fine
        half = sheet.cell.along / 2
        tried = (
            iter([fit.mesh])
            if sheet.closed
            else trimmings(target, fit.mesh, _MAY_FALL, fine_faces, half)
        )
        for mesh in tried:
            made = [(mesh.vertices_coords, mesh.faces_vertices)]
            under = float(covered(target, made, 2 * sheet.cell.thickness).mean())
            if under >= _WELL_COVERED:
                break
        off = fit.deviations * sheet.cell.step
        used = np.unique(sheet.faces_vertices)
        used = used[held[used]]
        found = SurfaceSheet(
            mesh,
            target.mesh,
            fit.relaxation.status,
            fit.relaxation.advice,
            fit.relaxation.rounds,
            off,
            under,
            len(crossing_faces(mesh.vertices_coords, *mesh.polygons)),
            least_sector(mesh),
            sheet.cell.step / pleats.stretch,
            pleats,
            laid.turn,
            float(np.abs(off + sheet.offsets[used]).max(initial=0.0)),
        )
        return found, fit.relaxation.coords

    def _near_goals(self, laid: _Laid, larger: float) -> SurfaceSheet:
        """A sheet relaxed, and again towards its goals, aimed beyond them by what is missed.

        larger : by how much lengths of the goals are larger, for a sheet of larger cells. Where a
        sheet fails on its way, it is aimed half as far.
        """
        goals = self.goals
        aim = Bounds() if goals is None else goals.angles()
        best, at = self._relaxed(laid, aim)
        if not best.good and aim != Bounds():
            aim = Bounds()
            best, at = self._relaxed(laid, aim)
        if goals is None or not best.made:
            return best
        best, wanted, reached = self._judged(best, goals, larger)
        share = 1.0
        for _ in range(_GOAL_ROUNDS):
            if not best.missed or wanted.out_of_reach(reached) or self._stopped():
                break
            aim = wanted.beyond(reached, aim, share).with_templates(at, laid.sheet.faces_vertices)
            found, coords = self._relaxed(laid, aim, at, wanted)
            found, nearer, measures = self._judged(found, goals, larger)
            if (found.faults, found.missed) >= (best.faults, best.missed):
                share /= 2
            elif found.missed > _NO_NEARER * best.missed:
                return found
            else:
                best, at, wanted, reached = found, coords, nearer, measures
        return best

    def _judged(
        self, sheet: SurfaceSheet, goals: Goals, larger: float
    ) -> tuple[SurfaceSheet, Bounds, FaceMeasures]:
        """A sheet with what it misses of its goals, these in its units, and its measures."""
        coords = folded = sheet.mesh.vertices_coords
        if sheet.part.area <= _WHOLE * self.whole.area:
            folded = np.concatenate([coords, self.whole.vertices_coords])
        if not sheet.made:
            measures = goals.bounds.measures(coords, sheet.mesh.faces_vertices)
            return replace(sheet, missed=np.inf), goals.bounds, measures
        wanted = goals.of(sheet.mesh, folded, larger)
        measures = wanted.measures(coords, sheet.mesh.faces_vertices)
        missed, far = float(wanted.misses(measures).sum()), wanted.far(measures)
        return replace(sheet, missed=missed, far=far), wanted, measures

    def judged(self, sheet: SurfaceSheet) -> SurfaceSheet:
        """A sheet with what it misses of its goals."""
        return sheet if self.goals is None else self._judged(sheet, self.goals, 1.0)[0]

    def _stopped(self) -> bool:
        return self.interrupted is not None and self.interrupted()


def _enough(ranked: Sequence[tuple[float, float, float, SurfaceSheet, _Lay]]) -> bool:
    """Whether there are good sheets enough to choose from, within the goals, far from them, or at
    all.
    """
    good = [sheet for faults, _, _, sheet, _ in ranked if faults == 0]
    enough = len(good) >= _CHOICES and all(sheet.far for sheet in good)
    return enough or len(good) >= _MOST_CHOICES or [s.missed for s in good].count(0.0) >= _CHOICES


@dataclass(frozen=True)
class _Laid:
    """A sheet laid on a map, with the setting that it was laid by."""

    lay: _Lay
    sheet: PleatedSheet
    pleats: Pleats
    turn: float
    columns: int


@dataclass(frozen=True)
class _Lay:
    """A surface with its map, on which sheets are laid.

    Attributes
    ----------
    columns : of the sheet that is wanted. first_columns : of those that are tried.
    around : whether it is a tube. whole : whether it is all of the surface.
    """

    target: MeshTarget
    sheet: Callable[[int, Pleats, float], PleatedSheet]
    columns: int
    first_columns: int
    around: bool
    whole: bool

    @staticmethod
    def of(
        kind: Callable[[SurfaceMesh, int, bool], _Lay],
        mesh: SurfaceMesh,
        columns: int,
        whole: bool,
    ) -> Iterator[_Lay]:
        """That of a patch or of a tube; none where there is no map."""
        try:
            yield kind(mesh, columns, whole)
        except InvalidState:
            return


def _patch(mesh: SurfaceMesh, columns: int, whole: bool) -> _Lay:
    corners = disc_map(mesh)
    target, along = MeshTarget(mesh, corners), principal_turn(corners)
    few = min(columns, _FIRST_COLUMNS)

    def sheet(count: int, pleats: Pleats, turn: float) -> PleatedSheet:
        return laid_patch(target, count, pleats, along + turn)

    return _Lay(target, sheet, columns, few, around=False, whole=whole)


def _tube(mesh: SurfaceMesh, columns: int, whole: bool) -> _Lay:
    corners, period = cylinder_map(mesh)
    target = MeshTarget(mesh, corners, period)
    few = min(columns, _FIRST_COLUMNS)
    if not whole:  # its cells are those of the other parts
        columns = max(4, round(columns * period / np.sqrt(mesh.area)))
        few = min(columns, _FIRST_AROUND)

    def sheet(count: int, pleats: Pleats, _: float) -> PleatedSheet:
        return laid_tube(target, period, count, pleats)

    return _Lay(target, sheet, columns, few, around=True, whole=whole)
