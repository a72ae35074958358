r"""Slot-and-tab joints: tabs whose tongues go through a slot in the face across their seam.

        b-----------a       edge of the piece, its face above
         \         /
          \_q   p_/         shoulders, at the depth of the slot
            |   |
             \_/            tongue

Up to its shoulders the tab is under the other face; its tongue comes up through the slot and lies
on it. The slot is parallel to the seam, as wide as the material is thick, and a little longer than
the tongue is wide.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from fab.pattern.crease_pattern import CreasePattern
from fab.sheets.glue_tabs import Tabs
from fab.sheets.openings import Openings, beside_seams
from fab.sheets.seams import SeamSides
from solver.vectors import FloatArray

__all__ = ["slotted"]

# Where the shoulders are, as a share of the height of the tab.
_DEPTH = 0.5
_SHOULDER_MM = 1.0
# Narrower tongues tear, mm; they get narrower by this share towards their end.
_LEAST_TONGUE_MM = 3.0
_TAPER = 0.2
# Play of a tongue in its slot, on both of its sides together, and across the material, mm.
_PLAY_MM = 0.3
_PLAY_ACROSS_MM = 0.1
# Material that is left between a slot and the next edge or slot, mm.
_LEFT_MM = 1.0


@dataclass(frozen=True)
class _Joint:
    """A tongue and its slot.

    tops : outer corners of the tab, shape (6, 2). slot : clockwise, shape (4, 2); face : it is in.
    """

    tops: FloatArray
    slot: FloatArray
    face: int


def slotted(
    pattern: CreasePattern, sides: SeamSides, tabs: Tabs, thickness_mm: float
) -> tuple[Tabs, Openings]:
    """Glue tabs made tongues, with the slots that they go through.

    Slots lie within their face, 1 mm from its edges and from each other; seams for which there is
    no such slot, or only a tongue of less than 3 mm, have no tab.
    """
    kept: list[int] = []
    joints: list[_Joint] = []
    taken: dict[int, list[shapely.Polygon]] = {}
    for number in range(len(tabs.seam)):
        joint = _joint(pattern, sides, tabs, number, thickness_mm)
        if joint is None:
            continue
        begin, end = pattern.faces_offsets[joint.face : joint.face + 2]
        room = shapely.Polygon(pattern.vertices_coords[pattern.faces_vertices[begin:end]])
        grown = shapely.Polygon(joint.slot).buffer(_LEFT_MM, join_style="mitre")
        others = taken.setdefault(joint.face, [])
        if room.covers(grown) and not any(grown.intersects(other) for other in others):
            others.append(shapely.Polygon(joint.slot))
            kept.append(number)
            joints.append(joint)
    tops = np.array([joint.tops for joint in joints]).reshape(-1, 6, 2)
    out = replace(
        tabs,
        seam=tabs.seam[kept],
        side=tabs.side[kept],
        tops=tops,
        foldAngle=tabs.foldAngle[kept],
    )
    faces = np.array([joint.face for joint in joints], np.int64)
    return out, Openings(tuple(joint.slot for joint in joints), faces, out.seam)


def _joint(
    pattern: CreasePattern, sides: SeamSides, tabs: Tabs, number: int, thickness_mm: float
) -> _Joint | None:
    """The tongue of a trapezoid tab and its slot; None where it would be too narrow."""
    seam, side = int(tabs.seam[number]), int(tabs.side[number])
    foot = pattern.vertices_coords[sides.vertices[seam, side]]
    span = foot[1] - foot[0]
    length = float(np.hypot(*span))
    u = span / length
    top = tabs.tops[number] - foot[0]
    along, out = top @ u, top @ np.array([u[1], -u[0]])
    height = float(out[0])
    depth = _DEPTH * height
    # shoulders are on the sides of the trapezoid
    begin, end = float(along[0]), float(along[1])
    left = _DEPTH * begin
    right = length - _DEPTH * (length - end)
    low, high = max(begin, left + _SHOULDER_MM), min(end, right - _SHOULDER_MM)
    wide = high - low
    if wide < _LEAST_TONGUE_MM:
        return None
    taper = _TAPER * wide / 2
    corners = np.array(
        [
            [left, depth],
            [low, depth],
            [low + taper, height],
            [high - taper, height],
            [high, depth],
            [right, depth],
        ]
    )
    tops = foot[0] + corners @ np.array([u, [u[1], -u[0]]])
    # across the seam: its other side begins where this one ends
    other = pattern.vertices_coords[sides.vertices[seam, 1 - side]]
    first, last = length - high - _PLAY_MM / 2, length - low + _PLAY_MM / 2
    far = depth + thickness_mm + _PLAY_ACROSS_MM
    slot = np.array([[first, depth], [first, far], [last, far], [last, depth]])
    return _Joint(tops, beside_seams(other, slot), int(sides.faces[seam, 1 - side]))
