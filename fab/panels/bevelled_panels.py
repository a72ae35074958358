"""Panels: the solid of each face of the sheet, set back from its creases.

Every panel lies between two heights and stays behind all setbacks of its sides
(`fab.panels.setbacks`).
Axes x of the creases lie at z = 0; a panel on its axis is cut straight at a mountain and bevelled
at a valley, one with the axis in its middle is bevelled on the side that closes:

    +-+      +-----+ top            +-+      +----+ top
    | |     /      |                | |     /     |
    | |    /       |                | +  x +      |  z = 0
    +-+-x-+--------+ bottom, z = 0  |/     |      |
                                    +      +------+ bottom
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from pydantic import Field, model_validator

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of, stacked
from fab.geometry.booleans import corners_and_triangles, manifold_of
from fab.geometry.rings import are_convex
from fab.panels.inset_limits import inradii
from fab.panels.inset_sides import SHORTEST_SIDE_MM, inset, spans
from fab.panels.setbacks import Setbacks, Sides, sides_of
from fab.pattern.crease_pattern import CreasePattern
from fab.settings import Settings
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "LEAST_RADIUS_MM",
    "LEAST_THICKNESS_MM",
    "MOST_THICKNESS_MM",
    "PanelSettings",
    "Panels",
    "lost_sides",
    "make_panels",
]

LEAST_THICKNESS_MM, MOST_THICKNESS_MM = 0.01, 1000.0
# A face has a panel where a circle of this radius fits into its bottom and its top.
LEAST_RADIUS_MM = SHORTEST_SIDE_MM / 2


class PanelSettings(Settings):
    """Thickness of the panels, where the axes of their hinges lie, and the gaps between them."""

    thickness_mm: float = Field(
        default=1.6, ge=LEAST_THICKNESS_MM, le=MOST_THICKNESS_MM, description="height of the panels"
    )
    axis: Literal["bottom", "middle", "offset"] = Field(
        default="bottom", description="where the axes of all hinges lie in the panels"
    )
    axis_mm: float | None = Field(
        default=None,
        ge=-1000,
        le=1000,
        description="height of the axes over the bottom of the panels, for axis = offset; "
        "negative below it",
    )
    gap_mm: float = Field(
        default=1.0,
        ge=0.01,
        le=1000,
        description="least gap between two panels, across their crease, when flat",
    )
    clearance_mm: float = Field(
        default=0.1,
        ge=0,
        le=1000,
        description="least distance of two panels at the target, across their crease",
    )
    fold_limit_deg: float = Field(
        default=180.0,
        gt=0,
        le=180,
        description="creases that should fold further get panels that fold as far as this. The "
        "largest that works where left out",
    )
    first_layer_mm: float | None = Field(
        default=None,
        ge=0,
        le=10,
        description="by how much the first layer of a print spreads: bottoms are cut back by that "
        "where another body is near. That of the printer where left out, else 0",
    )

    @model_validator(mode="after")
    def _offset(self) -> PanelSettings:
        if (self.axis == "offset") != (self.axis_mm is not None):
            raise ValueError(
                f"axis = {self.axis} and axis_mm = {self.axis_mm}: give axis_mm with "
                "axis = offset, and only then"
            )
        if self.axis_mm is not None and self.axis_mm > self.thickness_mm:
            raise ValueError(
                f"axis_mm = {self.axis_mm:g} must be at most thickness_mm = {self.thickness_mm:g}"
            )
        if (self.first_layer_mm or 0.0) > self.thickness_mm / 4:
            raise ValueError(
                f"first_layer_mm = {self.first_layer_mm:g} must be at most a quarter of "
                f"thickness_mm = {self.thickness_mm:g}"
            )
        return self

    @property
    def heights_mm(self) -> tuple[float, float]:
        """Bottom and top of the panels over the axes of their hinges."""
        axis = {"bottom": 0.0, "middle": self.thickness_mm / 2}.get(self.axis, self.axis_mm or 0.0)
        return -axis, self.thickness_mm - axis


@dataclass(frozen=True)
class Panels:
    """The panels of a pattern.

    Attributes
    ----------
    bodies : one for each panel, with the axes of the creases at z = 0.
    faces : the face of each panel, rising, shape (n,).
    heights_mm : bottom and top of all panels.
    sides, setbacks : of all faces, also of those without a panel.
    """

    bodies: Bodies
    faces: IntArray
    heights_mm: tuple[float, float]
    sides: Sides
    setbacks: Setbacks

    @property
    def faces_has_panel(self) -> BoolArray:
        """Whether each face of the pattern has a panel, shape (nf,)."""
        out = np.zeros(len(self.sides.offsets) - 1, bool)
        out[self.faces] = True
        return out


def make_panels(
    pattern: CreasePattern, heights_mm: tuple[float, float], back: Setbacks
) -> tuple[Panels, list[Finding]]:
    """One panel for each face; faces that can have none are left out.

    heights_mm : bottom and top of the panels over their axes. back : setbacks of every edge.

    Where all sides stay, panels are stacked rings. A convex face whose sides do not all stay is cut
    by the planes of all its setbacks. Findings name faces that are not convex and have no panel;
    for the others see `fab.panels.feasibility`.
    """
    sides = sides_of(pattern)
    offsets = sides.offsets
    low, high = heights_mm
    levels = np.array([low, 0.0, high]) if low < 0 < high else np.array([low, high])
    rings, whole = _rings(sides, back, levels)
    convex = are_convex(sides.start, offsets)
    radii = [inradii(sides, back.at(z)) for z in heights_mm]
    room = convex & (np.minimum(*radii) >= LEAST_RADIUS_MM)
    whole &= room | ~convex
    for face in np.flatnonzero(whole & ~convex & (np.diff(offsets) > 4)).tolist():
        ends = rings[offsets[face] : offsets[face + 1]]
        whole[face] = all(shapely.Polygon(ends[:, k]).is_valid for k in range(len(levels)))
    easy = np.flatnonzero(whole)
    chosen = np.repeat(whole, np.diff(offsets))
    sizes = np.diff(offsets)[whole]
    simple = stacked(rings[chosen], np.concatenate([[0], np.cumsum(sizes)]), levels)
    meshes, cut, shed = [], [], []
    for face in np.flatnonzero(~whole & room).tolist():
        made = _cut(sides, back, heights_mm, face)
        if made is not None:
            meshes.append(made)
            cut.append(face)
            shed += _lost(sides, back, heights_mm, face)
    faces = np.concatenate([easy, np.array(cut, np.int64)])
    bodies = simple
    if cut:
        order = np.argsort(faces)
        bodies = bodies_of([*(simple.mesh(i) for i in range(len(simple))), *meshes]).chosen(order)
        faces = faces[order]
    panels = Panels(bodies, faces, heights_mm, sides, back)
    without = np.flatnonzero(~panels.faces_has_panel)
    return panels, [
        *_not_convex(without[~convex[without]]),
        *_vanished_sides(np.unique(np.array(shed, np.int64))),
    ]


def _rings(sides: Sides, back: Setbacks, levels: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Corners of all faces at all levels, (total, k, 2), and which faces keep all their sides."""
    kept = np.ones(len(sides.offsets) - 1, bool)
    rings = []
    for z in levels.tolist():
        ring, fine = inset(sides.start, sides.offsets, back.at(z)[sides.edges])
        rings.append(ring)
        kept &= fine
    return np.stack(rings, axis=1), kept


def _planes(
    sides: Sides, back: Setbacks, heights_mm: tuple[float, float], face: int
) -> tuple[FloatArray, FloatArray]:
    """Planes that bound a panel, n . x >= d: normals (k, 3), not of length 1, and d (k,).

    First the bottom and the top, then for each side the one below its axis and the one above.
    """
    rows = slice(sides.offsets[face], sides.offsets[face + 1])
    inward, edges = sides.inward[rows], sides.edges[rows]
    distance = (inward * sides.start[rows]).sum(axis=1) + back.axis_mm[edges]
    normals = [np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])]
    offsets = [heights_mm[0], -heights_mm[1]]
    for n, edge, d in zip(inward, edges.tolist(), distance.tolist(), strict=True):
        normals += [np.array([*n, back.below[edge]]), np.array([*n, -back.above[edge]])]
        offsets += [d, d]
    return np.array(normals), np.array(offsets)


def _cut(
    sides: Sides, back: Setbacks, heights_mm: tuple[float, float], face: int
) -> TriangleMesh | None:
    """A convex face's panel, cut by all its planes; None where none is left at both heights."""
    normals, distance = _planes(sides, back, heights_mm, face)
    if not np.isfinite(normals).all() or not np.isfinite(distance).all():
        return None
    rows = slice(sides.offsets[face], sides.offsets[face + 1])
    corners = sides.start[rows]
    prism = stacked(
        np.stack([corners, corners], axis=1),
        np.array([0, len(corners)]),
        np.array(heights_mm),
    ).mesh(0)
    solid = manifold_of(prism)
    # vertical walls once, borders of the sheet not at all: cuts along a wall leave idle vertices
    used = np.unique(np.column_stack([normals, distance]), axis=0, return_index=True)[1]
    border = np.repeat((back.axis_mm[sides.edges[rows]] == 0.0), 2)
    for i in np.sort(used[(used >= 2) & ~np.concatenate([[True, True], border])[used]]).tolist():
        normal, d = normals[i], float(distance[i])
        length = float(np.hypot(np.hypot(*normal[:2]), normal[2]))
        solid = solid.trim_by_plane(tuple((normal / length).tolist()), d / length)
    if solid.is_empty() or solid.num_tri() == 0:
        return None
    coords, triangles = corners_and_triangles(solid)
    size = np.hypot(np.hypot(normals[:, 0], normals[:, 1]), normals[:, 2])
    off = np.abs((coords @ normals.T - distance) / size)
    return TriangleMesh(coords, triangles, off[triangles].max(axis=1).argmin(axis=1))


def _lost(sides: Sides, back: Setbacks, heights_mm: tuple[float, float], face: int) -> list[int]:
    """Edges under sides of a face that do not reach the axis height of its panel, or its end."""
    z = float(np.clip(0.0, *heights_mm))
    rows = np.arange(sides.offsets[face], sides.offsets[face + 1])
    low, high = spans(sides, back, z, rows)
    lost: list[int] = sides.edges[rows[high - low < SHORTEST_SIDE_MM]].tolist()
    return lost


def lost_sides(panels: Panels) -> IntArray:
    """Edges under sides of convex panels that do not reach their axis height, or their end."""
    sides = panels.sides
    own = panels.faces_has_panel & are_convex(sides.start, sides.offsets)
    rows = np.flatnonzero(own[sides.faces])
    z = float(np.clip(0.0, *panels.heights_mm))
    low, high = spans(sides, panels.setbacks, z, rows)
    return np.unique(sides.edges[rows[high - low < SHORTEST_SIDE_MM]])


def _not_convex(faces: IntArray) -> list[Finding]:
    if not len(faces):
        return []
    first = counted(
        len(faces),
        "face is not convex and loses a side, or crosses itself, by the setbacks of its creases; "
        "it has no panel. Split it by creases",
        "faces are not convex and lose a side, or cross themselves, by the setbacks of their "
        "creases; they have no panel. Split them by creases",
    )
    text = f"{first}, or enlarge the sheet."
    return [Finding("panel-not-convex", Severity.ERROR, text, panels=first_few(faces))]


def _vanished_sides(edges: IntArray) -> list[Finding]:
    if not len(edges):
        return []
    text = (
        f"{counted(len(edges), 'edge is', 'edges are')} so short that a panel beside "
        f"{'it' if len(edges) == 1 else 'them'} loses its side to the setbacks of the others."
    )
    return [Finding("panel-side-vanishes", Severity.WARNING, text, creases=first_few(edges))]
