"""A thick sheet as CAD objects, with a joint at every crease to pose it by."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from fab.geometry.brep import solids
from fab.panels.body_colours import body_colours
from fab.panels.film_parts import creased_films
from fab.panels.hinge_room import crease_sides
from fab.panels.thick_sheet import ThickSheet
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.face_poses import face_poses
from fab.pattern.face_tree import face_tree
from solver.errors import InvalidValue
from solver.vectors import FloatArray, IntArray, norm

if TYPE_CHECKING:
    from build123d import Compound, Solid

__all__ = ["assembly", "placed_solids", "pose"]

_PANEL = "panel_"
_CREASE = "crease_"


def assembly(sheet: ThickSheet, name: str, coords: FloatArray | None = None) -> Compound:
    """The bodies of a sheet as named, coloured CAD solids in one build123d compound.

    Each crease between two panels has the joint "crease_E", E the number of its edge: a
    `RevoluteJoint` on the panel of its first face and a `RigidJoint` on the other panel. Angles
    are fold angles in degrees, 0 when flat, positive at valleys:

        first.joints["crease_7"].connect_to(second.joints["crease_7"], angle=60)

    moves the second panel. `pose` does it for all creases.

    coords : as in `placed_solids`.
    """
    from build123d import Color, Compound

    made = _flat_solids(sheet, coords)
    panels = {sheet.faces[body]: solid for body, solid in made.items() if sheet.faces[body] >= 0}
    _add_joints(sheet, panels)
    _place(sheet, made, coords)
    colours = body_colours(sheet)
    for body, solid in made.items():
        solid.color = Color(*colours[body])
    return Compound(label=name, children=list(made.values()))


def placed_solids(sheet: ThickSheet, coords: FloatArray | None = None) -> dict[int, Solid]:
    """The bodies of a sheet as build123d solids, labelled by their names, by their numbers.

    coords : shape (nv, 3), mm, of the pattern's vertices in a folded state: the rigid bodies alone,
        where that state has them. Without it, all bodies of the flat sheet.
    """
    made = _flat_solids(sheet, coords)
    _place(sheet, made, coords)
    return made


def _flat_solids(sheet: ThickSheet, coords: FloatArray | None) -> dict[int, Solid]:
    """The solids that `placed_solids` has, by their numbers, where they are when flat."""
    if coords is None:
        made = dict(enumerate(solids(creased_films(sheet))))
    else:
        rigid = solids(sheet.bodies.chosen(sheet.rigid))
        made = dict(zip(sheet.rigid.tolist(), rigid, strict=True))
    for body, solid in made.items():
        solid.label = sheet.names[body]
    return made


def _place(sheet: ThickSheet, made: Mapping[int, Solid], coords: FloatArray | None) -> None:
    """Move flat solids to a folded state, where one is given."""
    from build123d import Location
    from OCP.gp import gp_Trsf

    if coords is None:
        return
    turns, shifts = face_poses(sheet.pattern, coords)
    rows = np.concatenate([turns, shifts[:, :, None]], axis=2).reshape(-1, 12).tolist()
    for body, solid in made.items():
        motion = gp_Trsf()
        motion.SetValues(*rows[sheet.faces[body]])
        solid.location = Location(motion)


def _add_joints(sheet: ThickSheet, panels: Mapping[int, Solid]) -> None:
    """Add joints to flat solids, given by their faces."""
    from build123d import Axis, RevoluteJoint, RigidJoint

    pattern = sheet.pattern
    first, second = crease_sides(pattern, sheet.panels)
    ends = pattern.vertices_coords[pattern.edges_vertices]
    for edge in np.flatnonzero((first >= 0) & (second >= 0)).tolist():
        (x, y), (x_end, y_end) = ends[edge].tolist()
        # against the edge: its first face lies on the left, and the second one rises at a valley
        axis = Axis((x, y, 0.0), (x - x_end, y - y_end, 0.0))
        left, right = pattern.edges_faces[edge].tolist()
        label = f"{_CREASE}{edge}"
        RevoluteJoint(label, panels[left], axis, angular_range=(-180.0, 180.0))
        RigidJoint(label, panels[right], axis.location)


def pose(compound: Compound, pattern: CreasePattern, angles_deg: FloatArray) -> Compound:
    """The panels of an `assembly`, folded by its joints; hinges, which bend, are left out.

    Panels are carried along a tree of faces, over long creases first; that in the middle of each
    piece stays. The solids share their geometry with those given, and have joints of their own.

    angles_deg : shape (ne,), the fold angle of every edge of the pattern, -180 to 180; those of
        edges without a joint do not matter.

    Raises `InvalidValue` for angles of another shape or out of bounds.
    """
    from build123d import Compound, Location, RevoluteJoint

    angles = np.asarray(angles_deg, np.float64)
    edges = len(pattern.edges_vertices)
    if angles.shape != (edges,):
        cure = "Give one angle for every edge of the pattern."
        raise InvalidValue("angles_deg", f"of shape {angles.shape}", f"have {edges} numbers", cure)
    children = [child for child in compound.children if child.label.startswith(_PANEL)]
    panels = [_jointed(child) for child in children]
    faces = np.array([int(child.label.removeprefix(_PANEL)) for child in children], np.int64)
    turning = np.array(
        [
            int(label.removeprefix(_CREASE))
            for panel in panels
            for label, joint in panel.joints.items()
            if isinstance(joint, RevoluteJoint)
        ],
        np.int64,
    )
    wrong = turning[~(np.abs(angles[turning]) <= 180)]
    if len(wrong):
        name = f"angles_deg[{wrong[0]}]"
        cure = "Fold angles are 0 when flat and positive at valleys."
        raise InvalidValue(name, angles[wrong[0]], "lie from -180 to 180", cure)
    place = np.full(pattern.face_count, -1)
    place[faces] = np.arange(len(faces))
    ends = pattern.vertices_coords[pattern.edges_vertices[turning]]
    sizes = np.diff(pattern.faces_offsets)
    corners = pattern.vertices_coords[pattern.faces_vertices]
    centres = np.add.reduceat(corners, pattern.faces_offsets[:-1]) / sizes[:, None]
    tree = face_tree(
        centres[faces], place[pattern.edges_faces[turning]], norm(ends[:, 1] - ends[:, 0])
    )
    for child in _from_the_roots(tree.parent).tolist():
        edge = int(turning[tree.link[child]])
        above = panels[tree.parent[child]].joints[f"{_CREASE}{edge}"]
        above.connect_to(panels[child].joints[f"{_CREASE}{edge}"], angle=float(angles[edge]))
        # one motion, not a product of more and more of them along the tree
        panels[child].location = Location(panels[child].wrapped.Location().Transformation())
    return Compound(label=compound.label, children=panels)


def _jointed(panel: Solid) -> Solid:
    """A solid of the same shape, name, colour and place with the same joints."""
    from build123d import Location, RevoluteJoint, RigidJoint, Solid

    place = panel.location
    out = Solid(panel.wrapped.Located(Location().wrapped), label=panel.label, color=panel.color)
    for label, joint in panel.joints.items():
        if isinstance(joint, RevoluteJoint):
            RevoluteJoint(label, out, joint.relative_axis, angular_range=joint.angular_range)
        else:
            RigidJoint(label, out, joint.relative_location)
    out.location = place
    return out


def _from_the_roots(parent: IntArray) -> IntArray:
    """All faces of trees but their roots, each after the face above it."""
    depth = np.zeros(len(parent), np.int64)
    above = parent
    while (below := above != parent[above]).any():
        depth += below
        above = parent[above]
    depth += parent != np.arange(len(parent))
    order = np.argsort(depth, kind="stable")
    return order[depth[order] > 0]
