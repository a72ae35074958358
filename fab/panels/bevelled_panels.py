"""Which solid stands on each face of the sheet, set back from its creases?

Every panel lies between two heights and stays behind all setbacks of its sides (`fab.setbacks`).
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

from fab.errors import Finding, Severity
from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of, stacked
from fab.geometry.rings import are_convex, next_corner
from fab.panels.inset_limits import inradii
from fab.panels.setbacks import Setbacks, Sides, sides_of
from fab.pattern.crease_pattern import CreasePattern
from fab.settings import Settings
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["PanelSettings", "Panels", "inset", "make_panels", "spans"]

LEAST_THICKNESS_MM, MOST_THICKNESS_MM = 0.01, 1000.0
# A side of a panel that is shorter than this after its setbacks is none.
SHORTEST_SIDE_MM = 0.05
# A panel stands where a circle of this radius fits into its bottom and its top.
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
        description="creases that should fold further get panels that fold as far as this",
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


def make_panels(
    pattern: CreasePattern, heights_mm: tuple[float, float], back: Setbacks
) -> tuple[Panels, list[Finding]]:
    """One panel for each face; faces on which none can stand are left out.

    Where all sides stay, panels are stacked rings. A convex face whose sides do not all stay is cut
    by the planes of all its setbacks. Faces that are not convex are named where none can stand;
    for the others see `fab.standing`.
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
    standing = np.zeros(len(offsets) - 1, bool)
    standing[faces] = True
    panels = Panels(bodies, faces, heights_mm, sides, back)
    findings = _findings(np.flatnonzero(~standing), convex, np.unique(np.array(shed, np.int64)))
    return panels, findings


def _rings(sides: Sides, back: Setbacks, levels: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Corners of all faces at all levels, (total, k, 2), and which faces keep all their sides."""
    kept = np.ones(len(sides.offsets) - 1, bool)
    rings = []
    for z in levels.tolist():
        ring, fine = inset(sides.start, sides.offsets, back.at(z)[sides.edges])
        rings.append(ring)
        kept &= fine
    return np.stack(rings, axis=1), kept


def inset(
    corners: FloatArray, offsets: IntArray, setback: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Polygons with each side moved inwards by its own setback.

    corners : counterclockwise rings, shape (total, 2); setback : of the side from each corner to
    the next, shape (total,). Returns the new corners, and which polygons keep all their sides in
    direction, each at least `SHORTEST_SIDE_MM` long, shape (n,).

    With unit directions d1, d2 of the sides before and after a corner and their setbacks s1, s2,
    the corner moves by (s1 d2 - s2 d1) / (d1 x d2).
    """
    following = next_corner(offsets)
    side = corners[following] - corners
    length = np.hypot(side[:, 0], side[:, 1])
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        after = side / length[:, None]
        before = np.empty_like(after)
        before[following] = after
        s2 = setback
        s1 = np.empty_like(s2)
        s1[following] = s2
        sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        move = (s1[:, None] * after - s2[:, None] * before) / sine[:, None]
        # straight corners: both sides move alike, or there is no corner to move to
        straight = (np.abs(sine) < 1e-9) & (s1 == s2) & ((before * after).sum(axis=1) > 0)
        move[straight] = (s2[:, None] * np.column_stack([-after[:, 1], after[:, 0]]))[straight]
        moved = corners + move
        along = ((moved[following] - moved) * after).sum(axis=1)
        back = (np.abs(sine) < 1e-9) & ~straight  # where the ring turns back, or has a step
        fine = np.isfinite(along) & (along >= np.minimum(SHORTEST_SIDE_MM, length / 2)) & ~back
    kept = np.logical_and.reduceat(fine, offsets[:-1])
    return moved, kept


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
    from manifold3d import Manifold, Mesh64

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
    solid = Manifold(Mesh64(prism.vertices_coords, prism.triangles.astype(np.uint64)))
    # vertical walls once, borders of the sheet not at all: cuts along a wall leave idle vertices
    used = np.unique(np.column_stack([normals, distance]), axis=0, return_index=True)[1]
    border = np.repeat((back.axis_mm[sides.edges[rows]] == 0.0), 2)
    for i in np.sort(used[(used >= 2) & ~np.concatenate([[True, True], border])[used]]).tolist():
        normal, d = normals[i], float(distance[i])
        length = float(np.hypot(np.hypot(*normal[:2]), normal[2]))
        solid = solid.trim_by_plane(tuple((normal / length).tolist()), d / length)
    if solid.is_empty() or solid.num_tri() == 0:
        return None
    mesh = solid.to_mesh64()
    coords = np.asarray(mesh.vert_properties[:, :3], np.float64)
    triangles = np.asarray(mesh.tri_verts, np.int64)
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


def spans(
    sides: Sides, back: Setbacks, z_mm: float, rows: IntArray, own_mm: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """From where to where each of some sides runs at a height, in mm from its start, shape (k,).

    own_mm : how far inwards it runs, shape (k,); the setbacks of these sides where left out.

    The side, moved inwards so far, ends where the next one crosses it; in convex faces
    any other may. The start comes after the end where nothing is left of it.
    """
    offsets = sides.offsets
    convex = are_convex(sides.start, offsets)
    back_mm = back.at(z_mm)[sides.edges]
    own_mm = back_mm[rows] if own_mm is None else own_mm
    face = sides.faces[rows]
    low, high = np.full(len(rows), -np.inf), np.full(len(rows), np.inf)
    sizes = np.diff(offsets)[face]
    for step in range(1, int(sizes.max(initial=1))):
        active = step < sizes
        # of a face that is not convex the two neighbours alone
        active &= convex[face] | (step == 1) | (step == sizes - 1)
        me = rows[active]
        other = offsets[face[active]] + (me - offsets[face[active]] + step) % sizes[active]
        point = sides.start[me] + own_mm[active, None] * sides.inward[me]
        slope = (sides.along[me] * sides.inward[other]).sum(axis=1)
        gap = ((sides.start[other] - point) * sides.inward[other]).sum(axis=1) + back_mm[other]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / slope  # where slope * t >= gap
        parallel = np.abs(slope) < 1e-9
        shut = parallel & (gap > 1e-9)
        if not convex.all():
            reflex = ~convex[face[active]]
            # beyond a reflex corner the neighbour cuts from the other end
            first, last = step == 1, step == sizes[active] - 1
            slope = np.where(reflex, np.where(first, -1.0, np.where(last, 1.0, slope)), slope)
        t = np.where(parallel, np.nan, t)
        low[active] = np.fmax(low[active], np.where(shut, np.inf, np.where(slope > 0, t, np.nan)))
        high[active] = np.fmin(
            high[active], np.where(shut, -np.inf, np.where(slope < 0, t, np.nan))
        )
    length = sides.length_mm[rows]
    return np.where(np.isinf(low) & (low < 0), 0.0, low), np.where(high == np.inf, length, high)


def _findings(without: IntArray, convex: BoolArray, shed: IntArray) -> list[Finding]:
    findings = []
    crossed = without[~convex[without]]
    if len(crossed):
        findings.append(
            Finding(
                "panel-not-convex",
                Severity.ERROR,
                f"{len(crossed)} faces are not convex and lose a side, or cross themselves, by the "
                "setbacks of their creases; they have no panel. Split them by creases, or enlarge "
                "the sheet.",
                panels=tuple(crossed[:20].tolist()),
            )
        )
    if len(shed):
        findings.append(
            Finding(
                "panel-side-vanishes",
                Severity.WARNING,
                f"{len(shed)} edges are so short that a panel beside them loses its side to the "
                "setbacks of the others.",
                creases=tuple(shed[:20].tolist()),
            )
        )
    return findings
