"""A folded sheet under load: at rest under its weight, pulls and air pressure, held at vertices.

The faces of the sheet are elastic plates (`fab.folding.loads.plate_bending`), its creases springs
at rest at their angles in the folded state, and its bars stretch as the plates do. All is in SI at
this seam: with lengths relative to the size S of the sheet in metres, and energies in newtons times
S, forces are in newtons.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from fab.errors import InvalidJob
from fab.folding.bar_hinge_model import Framework, framework
from fab.folding.loads.forces import BarTension, DeadForces, Pressure, rim_forces
from fab.folding.loads.load_settings import LoadSettings
from fab.folding.loads.plate import Plate
from fab.folding.loads.plate_bending import PlateBending, plate_bending
from fab.folding.loads.refined import refined
from fab.folding.loads.supports import chosen_vertices
from fab.folding.newton_system import NewtonSystem
from fab.folding.potentials import Potential
from fab.folding.rest import relaxed, watched
from fab.pattern.kinematics import unknown_angles
from fab.progress import Steps, no_steps
from solver.graphs import EdgeIndex
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["GRAVITY_M_S2", "LoadState", "LoadedSheet", "load_sheet"]

GRAVITY_M_S2 = 9.80665
# Sides of triangles are divided into so many parts at most, for about so many triangles at most.
_MOST_PARTS, _MOST_TRIANGLES = 6, 1500
# The sheet comes to rest with softer bars first, which stretch by up to about this strain.
_SOFT_STRAIN, _SOFTEST = 1e-2, 1e-4
# Rounds in which the forces of pressure at a free rim follow it, and when they have: relative.
_ROUNDS, _FOLLOWED = 30, 1e-6
# A sheet that has not come to rest in so many of these rounds swings away from its load.
_RESTLESS = 3
# The sheet is in equilibrium where forces are balanced to this share of the load.
_BALANCED = 1e-4
# It sags or rises where the motion up or down is at least this share of the motion.
_MOSTLY = 0.5
# Held vertices within this share of the sheet of a line are on it.
_STRAIGHT = 1e-6


@dataclass(frozen=True)
class LoadState:
    """The sheet at rest under a share of its load.

    Attributes
    ----------
    share : of the whole load, 0 to 1. coords : shape (nv, 3), mm.
    strain_max : largest absolute strain of a bar; curvature_max_per_mm : of a face.
    reactions_n : shape (nv, 3), forces of the supports on the sheet.
    settled : whether it came to rest, with balanced forces.
    """

    share: float
    coords: FloatArray
    strain_max: float
    curvature_max_per_mm: float
    reactions_n: FloatArray
    settled: bool


@dataclass(frozen=True)
class LoadedSheet:
    """A sheet under load, without load first.

    Attributes
    ----------
    frame : the sheet with finer triangles. numbers : shape (nv,), the number of each of its
        vertices in the pattern, -1 for new ones. corners : of each vertex of the sheet, its number
        in the finer one.
    fixed : shape (nv,). plate : what it is made of. down : shape (3,), a unit vector.
    bars_stiffness : shape (nb,), newtons over the size of the sheet.
    weight_n : of the whole sheet. weighs : whether it is among the loads.
    load_n : shape (3,), sum of all loads, pressure as it is where the sheet is at rest.
    """

    frame: Framework
    numbers: IntArray
    corners: IntArray
    fixed: BoolArray
    plate: Plate
    bars_stiffness: FloatArray
    down: FloatArray
    weight_n: float
    weighs: bool
    load_n: FloatArray
    states: tuple[LoadState, ...]

    @property
    def last(self) -> LoadState:
        """Under the whole load."""
        return self.states[-1]

    @cached_property
    def displacement_mm(self) -> FloatArray:
        """Of all vertices by the whole load, shape (nv, 3)."""
        return self.last.coords - self.states[0].coords

    @property
    def sag_mm(self) -> float:
        """By how much the vertex that goes down most does."""
        return float(self.displacement_mm[self.sag_vertex] @ self.down)

    @property
    def sag_vertex(self) -> int:
        """The vertex that goes down most, of the finer sheet."""
        return int((self.displacement_mm @ self.down).argmax())

    @property
    def moved(self) -> tuple[str, float, int]:
        """How most of it moves, by how many mm at most, and the vertex of the finer sheet there.

        Down where it "sags", against the weight where it "rises"; "moves" where most of its
        motion is to the sides.
        """
        far, along = norm(self.displacement_mm), self.displacement_mm @ self.down
        low, high, most = (int(x.argmax()) for x in (along, -along, far))
        if max(along[low], -along[high]) < _MOSTLY * far[most]:
            return "moves", float(far[most]), most
        if -along[high] > along[low]:
            return "rises", -float(along[high]), high
        return "sags", float(along[low]), low

    @property
    def swinging(self) -> list[tuple[IntArray, IntArray]]:
        """Pieces that can swing: what holds them is on one straight line, or in one point.

        Of each all its vertices, and those that are held.
        """
        coords = self.states[0].coords
        near = _STRAIGHT * self.frame.size_mm
        component = self.frame.component
        used = np.unique(self.frame.triangles_vertices)
        out = []
        for piece in np.unique(component[used]):
            inside = used[component[used] == piece]
            held = inside[self.fixed[inside]]
            off = coords[held] - coords[held].mean(axis=0)
            *_, axes = np.linalg.svd(off, full_matrices=False)
            if norm(off - np.outer(off @ axes[0], axes[0])).max() <= near:
                out.append((inside, held))
        return out

    @property
    def outer_strain_max(self) -> float:
        """At most, of the outer fibre: that of bars and of bending."""
        last = self.last
        return last.strain_max + last.curvature_max_per_mm * self.plate.thickness_mm / 2


def load_sheet(
    frame: Framework,
    coords: FloatArray,
    plate: Plate,
    settings: LoadSettings,
    progress: Steps = no_steps,
) -> LoadedSheet:
    """Load a folded sheet, held at the fixed vertices where they are without load.

    Parameters
    ----------
    frame : of the sheet. coords : shape (nv, 3), mm, where it is folded to, z up.
    progress : called with (loads done, loads in all).

    Raises `InvalidJob` where nothing or not every piece of the sheet is held, a choice of vertices
    or faces finds none, or a pull is on vertices that are all held.
    """
    sheet = _Loading.of(frame, coords, plate, settings)
    shares = np.arange(settings.load_steps + 1) / settings.load_steps
    states = [sheet.state(0.0, sheet.start, np.zeros_like(sheet.start), True)]
    at = sheet.start
    for number, share in enumerate(shares[1:]):
        watch = partial(watched, progress, number, len(shares) - 1)
        at, gradient, settled = sheet.at_rest(at, float(share), watch)
        states.append(sheet.state(float(share), at, gradient, settled))
    progress(len(shares) - 1, len(shares) - 1)
    return LoadedSheet(
        sheet.frame,
        sheet.numbers,
        sheet.corners,
        sheet.fixed,
        plate,
        sheet.frame.bars_stiffness,
        sheet.down,
        sheet.weight_n,
        settings.weight,
        sheet.loads(at, 1.0).sum(axis=0),
        tuple(states),
    )


@dataclass(frozen=True)
class _Loading:
    """What is loaded, and how: coordinates relative to the size of the sheet."""

    frame: Framework
    numbers: IntArray
    corners: IntArray
    start: FloatArray
    rest: FloatArray
    fixed: BoolArray
    bending: PlateBending
    down: FloatArray
    weight_n: float
    forces: FloatArray
    pressed: IntArray
    pressure_n: float
    soft: float

    @staticmethod
    def of(coarse: Framework, coords: FloatArray, plate: Plate, settings: LoadSettings) -> _Loading:
        parts = settings.parts or _parts(len(coarse.triangles_vertices))
        fine = refined(coarse, parts)
        frame = framework(fine.pattern)
        source = frame.sheet.vertices_source
        number = np.full(len(fine.pattern.vertices_coords), -1)
        number[: len(coarse.vertices_coords)] = coarse.sheet.vertices_source
        numbers = number[source]
        at = fine.coords(coords)[source] / frame.size_mm
        size = 1e-3 * frame.size_mm
        down = np.asarray(settings.down, float)
        down = down / norm(down)
        sheet = frame.sheet.pattern

        def chosen(choices: Sequence[str | int | Sequence[float]], key: str) -> BoolArray:
            return chosen_vertices(sheet, numbers, at, down, choices, key)

        fixed = chosen(settings.fixed, "loads.fixed")
        _require_held(frame, fixed)
        area = _areas(frame)
        mass = 1e-3 * plate.grams_per_m2 * area * size**2
        forces = np.zeros_like(at)
        if settings.weight:
            third = np.repeat(GRAVITY_M_S2 * mass / 3, 3)
            corner = frame.triangles_vertices.ravel()
            forces += np.bincount(corner, third, len(at))[:, None] * down
        for place, pull in enumerate(settings.pulls):
            pulled = chosen(pull.at, f"loads.pulls.{place}.at")
            if fixed[pulled].all():
                raise InvalidJob(
                    f"loads.pulls.{place}.at: all vertices that it pulls are held, and none "
                    "would move. Pull others, or hold fewer."
                )
            forces[pulled] += np.asarray(pull.force_n) / pulled.sum()
        pressed = np.arange(len(area))
        if settings.pressure_faces is not None:
            pressed = _pressed(coarse, fine.faces_source, settings.pressure_faces)
        pressure = settings.pressure_pa * size**2
        crease = frame.hinges_edge
        plates = (crease < 0) | (sheet.edges_assignment[crease] == "J")
        free = unknown_angles(sheet)[crease]
        loaded = replace(
            frame,
            bars_stiffness=_stretching(frame, area, plate.stretching_stiffness_n_m * size),
            hinges_stiffness=np.where(
                plates | free, 0.0, plate.crease_stiffness_n * frame.hinges_length
            ),
        )
        bending = plate_bending(
            frame, plates, plate.bending_stiffness_nm / size, plate.poissons_ratio, fixed
        )
        largest = float(norm(forces).sum()) + abs(pressure) * float(area[pressed].sum())
        soft = largest / (plate.stretching_stiffness_n_m * size * _SOFT_STRAIN)
        return _Loading(
            loaded,
            numbers,
            np.unique(source, return_index=True)[1][: len(coarse.vertices_coords)],
            at,
            frame.angles_near(at, frame.hinges_target),
            fixed,
            bending,
            down,
            GRAVITY_M_S2 * float(mass.sum()),
            forces,
            frame.triangles_vertices[pressed],
            pressure,
            float(np.clip(soft, _SOFTEST, 1.0)),
        )

    def at_rest(
        self, coords: FloatArray, share: float, watch: Callable[[int], None]
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Coordinates under a share of the load, the gradient there, and whether it is at rest."""
        settled = True
        for frame, system in self.systems:
            restless = 0
            for _ in range(_ROUNDS if self.pressure_n and frame is self.frame else 1):
                before = coords
                rest = relaxed(
                    frame,
                    coords,
                    self.rest,
                    frame is self.frame,
                    self._potentials(frame, coords, share),
                    system=system,
                    watch=watch,
                )
                coords, settled = rest.coords, rest.settled
                restless += not settled
                if restless == _RESTLESS or norm(coords - before).max() <= _FOLLOWED:
                    break
        gradient = self._gradient(coords, share)
        left = float(norm(gradient[~self.fixed]).max(initial=0.0))
        load = float(norm(self.forces).sum()) + abs(self.pressure_n)
        return coords, gradient, settled and left <= _BALANCED * share * load

    @cached_property
    def systems(self) -> list[tuple[Framework, NewtonSystem]]:
        """The sheet with softer bars, which comes to rest in fewer steps, and as it is."""
        factors = sorted({self.soft, self.soft**0.5} - {1.0})
        softer = [
            replace(self.frame, bars_stiffness=factor * self.frame.bars_stiffness)
            for factor in factors
        ]
        return [(frame, NewtonSystem(frame, self.fixed)) for frame in (*softer, self.frame)]

    def _gradient(self, coords: FloatArray, share: float) -> FloatArray:
        """Of all energy, shape (nv, 3), newtons; at fixed vertices the forces of the supports."""
        here = self.frame.derivatives(coords, self.rest)
        out = self.frame.assembly.gradient(here.gradients, here.weights, here.values)
        for potential in self._potentials(self.frame, coords, share):
            out = out + potential.linearised(coords)[0]
        return out

    def loads(self, coords: FloatArray, share: float) -> FloatArray:
        """Forces of weight, pulls and pressure on the vertices, shape (nv, 3), newtons."""
        gradients = [load.linearised(coords)[0] for load in self._carried(coords, share)]
        forces: FloatArray = -np.sum(gradients, axis=0)
        return forces

    def _potentials(self, frame: Framework, coords: FloatArray, share: float) -> list[Potential]:
        return [self.bending, BarTension(frame), *self._carried(coords, share)]

    def _carried(self, coords: FloatArray, share: float) -> list[Potential]:
        """The loads; forces of pressure at a free rim are those at coords."""
        forces = share * self.forces
        found: list[Potential] = []
        if self.pressure_n:
            pressure = share * self.pressure_n
            forces = forces + rim_forces(coords, self.pressed, pressure)
            found.append(Pressure(self.pressed, pressure))
        return [*found, DeadForces(forces)]

    def state(
        self, share: float, coords: FloatArray, gradient: FloatArray, settled: bool
    ) -> LoadState:
        strain = float(np.abs(self.frame.strains(coords)).max())
        reactions = np.where(self.fixed[:, None], gradient, 0.0)
        size = self.frame.size_mm
        curvature = float(self.bending.curvatures(coords).max(initial=0.0)) / size
        return LoadState(share, coords * size, strain, curvature, reactions, settled)


def _parts(triangles: int) -> int:
    """Parts into which the sides of triangles are divided where nothing is said."""
    return int(np.clip(np.sqrt(_MOST_TRIANGLES / triangles), 1, _MOST_PARTS))


def _require_held(frame: Framework, fixed: BoolArray) -> None:
    """Raise `InvalidJob` unless every piece of the sheet is held somewhere."""
    component = frame.component
    used = np.zeros(len(fixed), bool)
    used[frame.triangles_vertices.ravel()] = True
    missing = np.setdiff1d(component[used], component[fixed])
    if len(missing):
        inside = np.flatnonzero((component == missing[0]) & used)
        flat = frame.sheet.pattern.vertices_coords[inside]
        box = ", ".join(f"{value:.6g}" for value in (*flat.min(axis=0), *flat.max(axis=0)))
        pieces = len(np.unique(component[used]))
        raise InvalidJob(
            f"loads.fixed holds {pieces - len(missing)} of the {pieces} pieces of the sheet, and "
            f"no vertex of the piece in [{box}] mm of the flat sheet: it would fall. Hold every "
            "piece somewhere: a region x,y,x,y may be within one."
        )


def _pressed(coarse: Framework, faces_source: IntArray, faces: Sequence[int]) -> IntArray:
    count = coarse.sheet.pattern.face_count
    for face in faces:
        if face >= count:
            raise InvalidJob(
                f"loads.pressure_faces = {face}: the sheet has faces 0 to {count - 1}. The FOLD "
                "file lists them."
            )
    return np.flatnonzero(np.isin(faces_source, faces))


def _areas(frame: Framework) -> FloatArray:
    """Areas of the flat triangles, shape (nt,)."""
    a, b, c = (frame.vertices_coords[frame.triangles_vertices[:, k], :2] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2


def _stretching(frame: Framework, area: FloatArray, stiffness: float) -> FloatArray:
    """Stiffness of the bars of a sheet that stretches, shape (nb,): of tributary strips.

    Each bar is as wide as the triangles beside it, their area over its length: exact for equal
    equilateral triangles and nu = 1/3, and for a strip along its bars.
    """
    index = EdgeIndex.of(frame.bars_vertices, len(frame.vertices_coords))
    wide = np.zeros(len(frame.bars_vertices))
    for k in range(3):
        bar = index.find(frame.triangles_vertices[:, [k, (k + 1) % 3]])
        wide += np.bincount(bar, area, len(wide))
    return stiffness * wide / frame.bars_length**2
