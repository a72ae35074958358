"""A generalised Miura sheet between two offsets of a target surface (figures 4A, S11 and S12)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from solver.designs.shells import SHELLS
from solver.errors import InvalidValue
from solver.fitting import fit_surface
from solver.goals import Goals
from solver.growth import Growth
from solver.mesh import QuadMesh
from solver.targets.base import Target
from solver.targets.parametric import ParametricSurface
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import BoolArray, FloatArray

__all__ = ["SURFACES", "SurfaceFit"]

Unit: TypeAlias = Callable[[QuadMesh], float]

_COLUMNS = 40
_METHODS = ("auto", "grow", "relax")

_ROUND = 0.75 * np.pi  # half of what the cylinders cover of a turn
_TWIST = 0.75  # half of what the helicoid covers along its ruling and of its turn


def _waves(u: FloatArray, v: FloatArray) -> FloatArray:
    a = 1.05 * np.pi
    return np.column_stack([u, v, 0.2 * np.sin(a * u) * np.cos(a * v)])


def _wave_derivatives(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    a, one, zero = 1.05 * np.pi, np.ones_like(u), np.zeros_like(u)
    along_u = np.column_stack([one, zero, 0.2 * a * np.cos(a * u) * np.cos(a * v)])
    along_v = np.column_stack([zero, one, -0.2 * a * np.sin(a * u) * np.sin(a * v)])
    return along_u, along_v


def _round(radius: Callable[[FloatArray], FloatArray]) -> ParametricSurface:
    """A surface around the y axis whose radius changes along it."""

    def position(u: FloatArray, v: FloatArray) -> FloatArray:
        r = radius(v)
        return np.column_stack([r * np.sin(_ROUND * u), 1.5 * v, r * np.cos(_ROUND * u)])

    return ParametricSurface(position)


def _paraboloid(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.column_stack([u, v, 0.4 * (u**2 + v**2)])


def _hypar(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.column_stack([u, v, 0.5 * (u**2 - v**2)])


def _landscape(u: FloatArray, v: FloatArray) -> FloatArray:
    hills = 0.22 * np.exp(-4 * ((u - 0.4) ** 2 + (v - 0.3) ** 2))
    hollow = -0.2 * np.exp(-5 * ((u + 0.5) ** 2 + (v - 0.1) ** 2))
    ridge = 0.15 * np.exp(-3 * ((u - 0.1) ** 2 + (v + 0.7) ** 2))
    return np.column_stack([u, v, hills + hollow + ridge])


def _helicoid_coordinates(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Asymptotic coordinates (s, t) of the principal ones: rulings and screw lines cross those."""
    return _TWIST * (u + v), _TWIST * (u - v)


def _helicoid(u: FloatArray, v: FloatArray) -> FloatArray:
    s, t = _helicoid_coordinates(u, v)
    return np.column_stack([np.sinh(s) * np.cos(t), np.sinh(s) * np.sin(t), t])


def _helicoid_within(u: FloatArray, v: FloatArray) -> BoolArray:
    s, t = _helicoid_coordinates(u, v)
    return (np.abs(s) <= _TWIST) & (np.abs(t) <= _TWIST)


SURFACES: dict[str, Target] = {
    "barrel": _round(lambda v: 1.0 - 0.2 * v**2),
    "cylinder": _round(lambda v: np.ones_like(v)),
    "helicoid": ParametricSurface(_helicoid, within=_helicoid_within),
    "hourglass": _round(lambda v: 0.8 + 0.2 * v**2),
    "hypar": ParametricSurface(_hypar),
    "landscape": ParametricSurface(_landscape),
    "paraboloid": ParametricSurface(_paraboloid),
    "waves": ParametricSurface(_waves, _wave_derivatives),
    **SHELLS,
}


@dataclass(frozen=True)
class SurfaceFit:
    """A sheet that follows a surface: grown on it, or relaxed onto it.

    Grown: both ways from two zigzag strips across its middle, exactly between two offsets of it.
    Relaxed: all vertices at once, near its offsets, on surfaces of any topology, with as many
    sheets as it needs.

    Attributes
    ----------
    surface : the target: a surface by its name (waves is figure 4A) or formula, or a mesh, which
        can only be relaxed onto.
    method : grow, relax, or auto: meshes are relaxed onto, and so is what folds rigidly;
        everything else is grown on.
    columns : m, number of quads across the surface's domain, along v; 40 where neither this nor
        one of the next two is given.
    cell, deviation : for relaxed sheets, in place of columns: the largest width of a quad, or the
        largest distance of a vertex from the surface, half the thickness with it. As few columns
        are taken as keep it.
    thickness : distance of the two offset surfaces, in steps of v.
    zigzag : swing of the seed's rows along u, in steps of v; None: chosen.
    row_step : distance of the seed's rows along u, in steps of v; None: chosen.
    turn : direction of growth, from the surface's u towards its v, radians; None: chosen.
    trim : whether faces outside the surface's domain are dropped; those of relaxed sheets are.
    rigid : whether the sheet folds rigidly, and flat, in one motion. It is relaxed, and follows its
        surface only as far as that allows.
    cost : what flap angles make least: mirror, or design_angles, the paper's S30. This and the
        next two are for growth alone.
    rows_may_end : whether a front goes on without vertices at its side that miss their offset.
    lookahead : whether settings that stop are tried again with one strip of lookahead.
    goals : of makers, to which a relaxed sheet comes as near as it can.
    unit : of cell and deviation, in units of a sheet, asked of it; None: it is theirs.
    """

    surface: str | Target | SurfaceMesh = field(default="waves", metadata={"target": True})
    method: str = "auto"
    columns: int | None = None
    cell: float | None = field(default=None, metadata={"length": True})
    deviation: float | None = field(default=None, metadata={"length": True})
    thickness: float = 1.0
    zigzag: float | None = None
    row_step: float | None = None
    turn: float | None = field(default=None, metadata={"angle": True})
    trim: bool = False
    rigid: bool = False
    cost: str = "mirror"
    rows_may_end: bool = False
    lookahead: bool = False
    goals: Goals | None = field(default=None, metadata={"given": "goals"})
    unit: Unit | None = field(default=None, metadata={"given": "unit"})

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        target = self.surface
        if isinstance(target, str):
            if target not in SURFACES:
                names = ", ".join(SURFACES)
                raise InvalidValue(
                    "surface",
                    target,
                    f"be one of {names}",
                    "A job can also name a file (STL, OBJ, PLY, STEP and others) there.",
                )
            target = SURFACES[target]
        elif not isinstance(target, SurfaceMesh) and not hasattr(target, "distance"):
            raise InvalidValue(
                "surface", repr(target), "be a name or a Target", "See `solver.targets`."
            )
        if self.method not in _METHODS:
            names = ", ".join(_METHODS)
            raise InvalidValue(
                "method", self.method, f"be one of {names}", "Leave it out for auto."
            )
        columns = self._columns()
        whole = isinstance(target, SurfaceMesh)
        if self.method == "relax" or (self.method == "auto" and (whole or self.rigid)):
            self._require_no_choice_of_growth()
            return self._relaxed(target, progress)
        for name in ("cell", "deviation"):
            if getattr(self, name) is not None:
                cure = "Give columns, or method = relax."
                raise InvalidValue(name, getattr(self, name), "be left out for growth", cure)
        if self.rigid:
            cure = "Leave method out: a sheet that folds rigidly is relaxed."
            raise InvalidValue("rigid", "true", "be false for a grown sheet", cure)
        if isinstance(target, SurfaceMesh):
            cure = "Give a `MeshSurface` of it, which is seen from above."
            raise InvalidValue("method", "grow", "be relax for a SurfaceMesh", cure)
        return fit_surface(
            target,
            columns,
            thickness=self.thickness,
            zigzag=self.zigzag,
            row_step=self.row_step,
            turn=self.turn,
            trim=self.trim,
            cost=self.cost,
            rows_may_end=self.rows_may_end,
            lookahead=self.lookahead,
            progress=progress,
        )

    def _columns(self) -> int:
        """Raises `InvalidValue` where more than one of columns, cell and deviation is given."""
        given = [
            name for name in ("columns", "cell", "deviation") if getattr(self, name) is not None
        ]
        if len(given) > 1:
            cure = f"Leave out all but one of {', '.join(given)}."
            raise InvalidValue(given[1], getattr(self, given[1]), f"be without {given[0]}", cure)
        return _COLUMNS if self.columns is None else self.columns

    def _relaxed(
        self, target: Target | SurfaceMesh, progress: Callable[[int, int], None] | None
    ) -> Growth:
        # as many modules as all of growth, and only needed here
        from solver.relaxed_fit import relaxed_fit, resolved_fit, sampled

        mesh = target if isinstance(target, SurfaceMesh) else sampled(target)

        def fit(columns: int) -> Growth:
            return relaxed_fit(
                mesh,
                columns,
                thickness=self.thickness,
                zigzag=self.zigzag,
                row_step=self.row_step,
                turn=self.turn,
                rigid=self.rigid,
                goals=self.goals,
                nearest=self.deviation is not None,
                progress=progress,
            )

        if self.cell is None and self.deviation is None:
            return fit(self._columns())
        return resolved_fit(fit, cell=self.cell, distance=self.deviation, unit=self.unit)

    def _require_no_choice_of_growth(self) -> None:
        usual = (("cost", "mirror"), ("rows_may_end", False), ("lookahead", False))
        for name, value in usual:
            if getattr(self, name) != value:
                shown = str(value).lower()
                cure = "It is a choice of growth: leave it out, or give method = grow."
                raise InvalidValue(
                    name, getattr(self, name), f"be {shown} for a relaxed sheet", cure
                )
