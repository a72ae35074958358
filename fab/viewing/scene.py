"""The scene: one description of a sheet for all pictures, pages and models of it.

It holds what is shown and none of how: the flat pattern, the sheet in its states from flat to
folded, colours as values on a named scale, the surface that the sheet follows, its findings, and
its thick bodies. `fab.viewing.scene_builders` makes it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fab.errors import Finding
from fab.geometry.bodies import Bodies
from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.scales import Scale
from solver.errors import InvalidValue
from solver.vectors import FloatArray, IntArray

__all__ = ["Marks", "Scene", "SceneBodies", "Surface", "Values", "marks"]


@dataclass(frozen=True)
class Values:
    """A number for each face or each vertex of the sheet, in every state.

    Attributes
    ----------
    values : shape (n_states, n), or (1, n) for values that are the same in all states.
    of_vertices : whether n counts vertices; else faces.
    scale : the colours that they have, with their name and unit.
    """

    values: FloatArray
    scale: Scale
    of_vertices: bool = False

    def in_state(self, state: int) -> FloatArray:
        """Those of one state, shape (n,)."""
        chosen: FloatArray = self.values[state if len(self.values) > 1 else 0]
        return chosen


@dataclass(frozen=True)
class Surface:
    """The surface that a sheet follows, in the pose of the sheet's last state.

    vertices_coords : shape (n, 3), mm. triangles : shape (m, 3). farthest_mm : the largest distance
    of a vertex of the sheet from it.
    """

    vertices_coords: FloatArray
    triangles: IntArray
    farthest_mm: float


@dataclass(frozen=True)
class SceneBodies:
    """Thick bodies of a sheet, flat, and how they move.

    Attributes
    ----------
    bodies : triangle meshes, mm, flat, the axes of creases at z = 0.
    names : shape (n,), such as "panel_3" and "hinge_12".
    colours : shape (n, 3), red, green and blue, 0 to 1.
    faces : shape (n,), the face that each body moves with, its panel number; -1 where it bends.
    creases : shape (n,), the edge that a hinge of its own belongs to; -1 for others.
    vertices_face : shape (nv,), the face that each vertex of the bodies moves with; -1 for vertices
        of bodies that lie under many faces, such as films, which are shown flat alone. Bodies that
        bend have a half of their vertices with the face on either side.
    turns, shifts : shapes (n_states, nf, 3, 3) and (n_states, nf, 3), mm: the motions
        x -> turn x + shift of the faces from flat to every state of the scene.
    state_names : such as "flat", "at 40 % of the fold" and "at the target".
    """

    bodies: Bodies
    names: tuple[str, ...]
    colours: FloatArray
    faces: IntArray
    creases: IntArray
    vertices_face: IntArray
    turns: FloatArray
    shifts: FloatArray
    state_names: tuple[str, ...]

    def coords_in(self, state: int) -> FloatArray:
        """Vertices of all bodies in a state, shape (nv, 3), mm; NaN for those that move with none.

        In a scene's flat state films lie where they are.
        """
        return self.coords_at(self.turns[state], self.shifts[state], flat=state == 0)

    def coords_at(self, turns: FloatArray, shifts: FloatArray, *, flat: bool = False) -> FloatArray:
        """The same, of faces moved by turns (nf, 3, 3) and shifts (nf, 3); flat : by all alike."""
        face = np.where((self.vertices_face < 0) & flat, 0, self.vertices_face)
        coords = self.bodies.vertices_coords
        moved = np.squeeze(turns[face] @ coords[:, :, None], axis=2) + shifts[face]
        moved[face < 0] = np.nan
        return np.asarray(moved)


@dataclass(frozen=True)
class Scene:
    """A sheet from flat to folded, in millimetres and degrees.

    Attributes
    ----------
    name : what it is called in titles.
    pattern : its faces (`faces_vertices`, `faces_offsets`), its edges with their assignment and
        fold angle, and its flat coordinates. Of a simulation, the sheet with its cuts open.
    shares : shape (n_states,), how far each state is folded: 0 is flat, 1 the target, and more
        is beyond it; the flat state is the first.
    states_coords : shape (n_states, nv, 3). z is up: where the sheet has an up of its own, as those
        that follow a surface, it stands as in its last state there, else its longest directions lie
        flat and most of its faces look up. Each state is turned to be near the one that follows.
    upright : whether the sheet has an up of its own.
    values : what faces or vertices are coloured by, on a named scale.
    surface : that the sheet follows.
    findings : with the numbers of panels and creases in `pattern`; `marks` says where they are.
    bodies : panels and hinges.
    lift_mm : shape (nv, 3), by how much vertices of the last state are moved so that layers of a
        sheet that is folded flat are apart (`fab.viewing.layered_scene`); None where they are not.
    layer_mm : how far one layer is from the next there.

    Raises `InvalidValue` where shapes do not fit one another.
    """

    name: str
    pattern: CreasePattern
    shares: FloatArray
    states_coords: FloatArray
    upright: bool = False
    values: Values | None = None
    surface: Surface | None = None
    findings: tuple[Finding, ...] = field(default=())
    bodies: SceneBodies | None = None
    lift_mm: FloatArray | None = None
    layer_mm: float = 0.0

    def __post_init__(self) -> None:
        states, vertices = len(self.shares), len(self.pattern.vertices_coords)
        self._require("states_coords", self.states_coords, (states, vertices, 3))
        if self.values is not None:
            count = vertices if self.values.of_vertices else self.pattern.face_count
            rows = 1 if len(self.values.values) == 1 else states
            self._require("values", self.values.values, (rows, count))
        if self.bodies is not None:
            faces = self.pattern.face_count
            self._require("bodies.turns", self.bodies.turns, (states, faces, 3, 3))
            self._require("bodies.shifts", self.bodies.shifts, (states, faces, 3))
        for array in (self.shares, self.states_coords):
            array.flags.writeable = False

    @staticmethod
    def _require(name: str, array: FloatArray, shape: tuple[int, ...]) -> None:
        if array.shape != shape or 0 in shape[:1]:
            cure = "Give an entry for each state, and each vertex or face of the pattern."
            raise InvalidValue(
                f"{name}.shape", array.shape, f"be {shape}, of 1 state or more", cure
            )

    @property
    def state_count(self) -> int:
        """Number of states, 1 where the sheet is only known flat."""
        return len(self.shares)

    @property
    def folded_coords(self) -> FloatArray | None:
        """Vertices of the last state, shape (nv, 3); None where the sheet is only known flat."""
        return self.states_coords[-1] if self.state_count > 1 else None


@dataclass(frozen=True)
class Marks:
    """Where something is in the flat sheet, mm.

    creases : shape (k, 2, 2), their ends; panels : shape (m, 2), middles of their corners;
    places : shape (n, 2), other places.
    """

    creases: FloatArray
    panels: FloatArray
    places: FloatArray


def marks(pattern: CreasePattern, finding: Finding) -> Marks:
    """Where a finding is; numbers that the pattern does not have are left out."""
    coords = pattern.vertices_coords
    creases = [e for e in finding.creases if 0 <= e < len(pattern.edges_vertices)]
    faces = [f for f in finding.panels if 0 <= f < pattern.face_count]
    bounds = pattern.faces_offsets
    middles = [
        coords[pattern.faces_vertices[bounds[f] : bounds[f + 1]]].mean(axis=0) for f in faces
    ]
    return Marks(
        coords[pattern.edges_vertices[np.array(creases, np.int64)]].reshape(-1, 2, 2),
        np.array(middles).reshape(-1, 2),
        np.array(finding.places, np.float64).reshape(-1, 2),
    )
