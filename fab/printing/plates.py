"""Plates of a thick sheet that is larger than the printer's bed.

It is divided into parts along as few creases as are found, which are joined after printing
(`fab.printing.dovetails`); the parts lie on as few plates as are found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from fab.errors import Finding
from fab.geometry.bodies import Bodies, TriangleMesh
from fab.geometry.booleans import joined_mesh
from fab.layout.assembly_order import assembly_order, piece_name
from fab.layout.face_sets import SheetToDivide, extent, outer_corners, upright
from fab.layout.nesting import Placements, nest
from fab.layout.partition import partition
from fab.panels.thick_sheet import ThickSheet
from fab.printing.dovetails import Joint, make_joints
from fab.printing.joint_plans import depths_mm
from fab.printing.jointed_sheet import jointed
from fab.printing.plate_settings import PlateSettings
from fab.progress import Steps, no_steps
from solver.errors import InvalidValue, require_positive
from solver.vectors import BoolArray, FloatArray, IntArray

# The margin of a bed where neither the settings nor a printer have one.
_MARGIN_MM = 5.0
# Outlines are rounded to a grid, so that the sides of faces meet.
_GRID_MM = 1e-6

__all__ = ["Part", "Plates", "make_plates"]


@dataclass(frozen=True)
class Part:
    """What is printed in one piece, where it stands on its plate.

    Attributes
    ----------
    name : "A", "B", ... in the order of assembling. plate : counted from 0.
    faces : those of the pattern, rising. numbers : its bodies among those of the sheet.
    turn, shift : shapes (3, 3) and (3,): the sheet's point p stands at turn @ p + shift.
    mesh : all of it as one closed surface on the plate, its bottom at z = 0.
    """

    name: str
    plate: int
    faces: IntArray
    numbers: IntArray
    turn: FloatArray
    shift: FloatArray
    mesh: TriangleMesh


@dataclass(frozen=True)
class Plates:
    """A thick sheet in parts on plates.

    Attributes
    ----------
    sheet : the whole sheet with its joints, its panels where they were.
    parts : in the order of assembling.
    joints : each part's to those before it, one after another.
    bed_mm : width and depth of every plate.
    """

    sheet: ThickSheet
    parts: tuple[Part, ...]
    joints: tuple[Joint, ...]
    bed_mm: tuple[float, float]

    @property
    def count(self) -> int:
        """Number of plates."""
        return 1 + max((part.plate for part in self.parts), default=-1)

    @cached_property
    def faces_part(self) -> IntArray:
        """The part of every face, -1 for those without a panel, shape (nf,)."""
        out = np.full(self.sheet.pattern.face_count, -1)
        for number, part in enumerate(self.parts):
            out[part.faces] = number
        return out

    def bodies(self, part: Part) -> Bodies:
        """The bodies of a part on its plate, side by side; names and flexible are the sheet's."""
        chosen = self.sheet.bodies.chosen(part.numbers)
        count = len(part.numbers)
        return chosen.moved(
            np.broadcast_to(part.turn, (count, 3, 3)), np.broadcast_to(part.shift, (count, 3))
        )

    def guide(self) -> dict[str, Any]:
        """The place of each part, and the joints in the order of assembling; plain values.

        Joints are numbered from 1 in the order of assembling: a part is joined to all before it
        that it has joints with. A part with pockets is laid over the tongues of the other.
        """
        angles = self.sheet.pattern.edges_foldAngle
        return {
            "bed_mm": list(self.bed_mm),
            "plates": [
                [
                    {
                        "part": part.name,
                        "panels": part.faces.tolist(),
                        "turn_deg": _round(
                            np.degrees(np.arctan2(part.turn[1, 0], part.turn[0, 0]))
                        ),
                        "shift_mm": [_round(x) for x in part.shift.tolist()],
                    }
                    for part in self.parts
                    if part.plate == plate
                ]
                for plate in range(self.count)
            ],
            "assembly": [
                {
                    "joint": number + 1,
                    "crease": joint.crease,
                    "kind": joint.kind,
                    "tongues": len(joint.tongues),
                    "tongue_part": self.parts[self.faces_part[joint.faces[0]]].name,
                    "pocket_part": self.parts[self.faces_part[joint.faces[1]]].name,
                    "panels": list(joint.faces),
                    "fold_angle_deg": _round(angles[joint.crease]),
                }
                for number, joint in enumerate(self.joints)
            ],
        }


def make_plates(
    sheet: ThickSheet,
    bed_mm: tuple[float, float],
    settings: PlateSettings,
    progress: Steps = no_steps,
) -> tuple[Plates, list[Finding]]:
    """Parts of a thick sheet that fit a bed, with joints, on plates.

    A sheet that fits is one part. Faces without a panel are in no part.

    progress : called with (steps done, steps in all): each face is set apart, then placed.

    Raises `InvalidValue` for a sheet without panels, for a bed without room between its margins,
    and for one that is smaller than a face with the joints around it.
    """
    room = _room(bed_mm, settings)
    pattern = sheet.pattern
    if not len(sheet.panels.faces):
        cure = "Lower thickness_mm or gap_mm, or enlarge the sheet."
        raise InvalidValue("panels", 0, "be at least 1", cure)
    steps = 2 * pattern.face_count
    flat = _flat(sheet, pattern.edges_joining, bed_mm, room, settings)
    sets = _face_sets(sheet, partition(flat, lambda done, _: progress(done, steps)))
    owner = np.full(pattern.face_count, -1)
    for number, faces in enumerate(sets):
        owner[faces] = number
    inner = np.flatnonzero(pattern.edges_joining)
    inner = inner[(owner[pattern.edges_faces[inner]] >= 0).all(axis=1)]
    _, rank = assembly_order(owner[pattern.edges_faces[inner]], len(sets))
    owner = np.where(owner >= 0, rank[owner], -1)
    joints, findings = make_joints(sheet, _cuts(pattern.edges_faces, inner, owner), settings.joints)
    whole, homes = jointed(sheet, joints, settings.joints, owner)

    def placed(done: float, total: int) -> None:
        progress(pattern.face_count + pattern.face_count * done // total, steps)

    turns = np.array([upright(extent(flat, faces), flat.room_mm)[0] for faces in sets])
    turns = turns[np.argsort(rank)]
    outlines = [
        shapely.transform(outline, lambda points, turn=turn: points @ turn.T)
        for outline, turn in zip(_outlines(sheet, joints, owner), turns, strict=True)
    ]
    margin, gap = _margin_mm(settings), settings.part_gap_mm
    placements = nest(outlines, bed_mm, gap, margin_mm=margin, progress=placed)
    parts = _parts(whole, turns, owner, owner[homes], placements)
    return Plates(whole, parts, tuple(joints), bed_mm), findings


def _face_sets(sheet: ThickSheet, sets: Sequence[IntArray]) -> list[IntArray]:
    """Sets of faces without those that have no panel, and without empty ones."""
    kept = [faces[np.isin(faces, sheet.panels.faces)] for faces in sets]
    return [faces for faces in kept if len(faces)]


def _room(bed_mm: tuple[float, float], settings: PlateSettings) -> tuple[float, float]:
    margin = _margin_mm(settings)
    for name, length in zip(("bed width", "bed depth"), bed_mm, strict=True):
        require_positive(name, length, "Give the size of the bed in mm.")
        if length <= 2 * margin:
            bound = f"be greater than 2 x margin_mm = {2 * margin:g} mm"
            raise InvalidValue(name, f"{length:g} mm", bound, "Lower margin_mm.")
    return bed_mm[0] - 2 * margin, bed_mm[1] - 2 * margin


def _margin_mm(settings: PlateSettings) -> float:
    return _MARGIN_MM if settings.margin_mm is None else settings.margin_mm


def _flat(
    sheet: ThickSheet,
    joined: BoolArray,
    bed_mm: tuple[float, float],
    room_mm: tuple[float, float],
    settings: PlateSettings,
) -> SheetToDivide:
    """What is divided: the pattern, with room for tongues on both sides of all creases."""
    pattern = sheet.pattern
    ends = pattern.vertices_coords[pattern.edges_vertices]
    both = np.stack([ends, ends[:, ::-1]], axis=1).reshape(-1, 2, 2)
    high = np.repeat(depths_mm(sheet, settings.joints), 2)
    reach = outer_corners(both, high, np.full((len(both), 2), np.pi / 2)).reshape(-1, 2, 2, 2)
    room_text = (
        f"the bed of {bed_mm[0]:g} x {bed_mm[1]:g} mm less margin_mm = {_margin_mm(settings):g} "
        "on each side"
    )
    none = np.zeros(len(joined), bool)
    return SheetToDivide(pattern, joined, reach, none, room_mm, room_text, ("joints", "depth_mm"))


def _cuts(edges_faces: IntArray, edges: IntArray, owner: IntArray) -> IntArray:
    """Edges between parts with both their faces, that of the earlier part first, (n, 3).

    Each part's edges to those before it come one after another.
    """
    faces = edges_faces[edges]
    apart = owner[faces[:, 0]] != owner[faces[:, 1]]
    edges, faces = edges[apart], faces[apart]
    turned = owner[faces[:, 0]] > owner[faces[:, 1]]
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    order = np.lexsort((edges, owner[faces[:, 0]], owner[faces[:, 1]]))
    return np.column_stack([edges, faces])[order]


def _parts(
    sheet: ThickSheet,
    turns: FloatArray,
    faces_part: IntArray,
    bodies_part: IntArray,
    placements: Placements,
) -> tuple[Part, ...]:
    """The parts where they were placed, in the order of assembling.

    turns : shape (n, 2, 2), of the sheet before each part was placed. faces_part, bodies_part : the
    part of each face and of each body.
    """
    parts = []
    for item in sorted(placements.items, key=lambda item: item.piece):
        numbers = np.flatnonzero(bodies_part == item.piece)
        bodies = sheet.joining.chosen(numbers)
        mesh = joined_mesh(bodies)
        turn, shift = np.eye(3), np.zeros(3)
        turn[:2, :2] = item.turn @ turns[item.piece]
        shift[:2], shift[2] = item.shift, -bodies.vertices_coords[:, 2].min()
        coords = mesh.vertices_coords @ turn.T + [*item.shift, 0.0]
        parts.append(
            Part(
                piece_name(item.piece),
                item.sheet,
                np.flatnonzero(faces_part == item.piece),
                numbers,
                turn,
                shift,
                replace(mesh, vertices_coords=coords),
            )
        )
    return tuple(parts)


def _outlines(
    sheet: ThickSheet, joints: Sequence[Joint], faces_part: IntArray
) -> list[shapely.Polygon]:
    """What the faces of each part cover of the plane, with all that it reaches out beyond them."""
    pattern, joint_parts = sheet.pattern, faces_part[[joint.faces[0] for joint in joints]]
    rings = np.split(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets[1:-1])
    out = []
    for part in range(int(faces_part.max(initial=-1)) + 1):
        faces = [shapely.Polygon(rings[face]) for face in np.flatnonzero(faces_part == part)]
        reach = [
            shapely.MultiPoint(_reached(joint))
            for joint in (joints[number] for number in np.flatnonzero(joint_parts == part).tolist())
        ]
        figure = shapely.union_all([*faces, *shapely.convex_hull(reach)], grid_size=_GRID_MM)
        # in several pieces where faces without a panel are between them
        whole = figure if isinstance(figure, shapely.Polygon) else shapely.convex_hull(figure)
        out.append(whole)
    return out


def _reached(joint: Joint) -> FloatArray:
    """Corners of what the part with the tongues of a joint reaches out to, shape (n, 2)."""
    rings = np.concatenate([joint.mouths, joint.tongues], axis=1).reshape(-1, 2)
    return np.concatenate([rings, joint.beyond])


def _round(value: float) -> float:
    return round(float(value), 6) + 0.0  # no minus before 0
