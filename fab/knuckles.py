r"""Which barrels and pins join panels so that they leave the printer as working hinges?

Along a crease, barrels of its two panels alternate; those of the first face stand at both ends and
carry a pin that runs through holes in the others. Seen along the axis, panels to the left and right
(a valley, closing above):

    +-----+   ___        +-----+
     \     \ /   \      /     /
      | arm |  o  |    |     |       barrel: eight sides, one on the bed, so it needs no support
      |     +     +    |     |       arm: from barrel to panel, behind the bisecting plane
      +-----+\___/     +-----+

Barrels stay within their radius R however far the hinge turns, and the other panel, set back by
R + play, stays beyond it. Arms lie on their own side of the plane that halves the fold angle, so
they keep (R + play) cos(rho / 2) from the other panel at the target.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from fab.bodies import TriangleMesh, bodies_of
from fab.carving import united
from fab.crease import CreasePattern
from fab.errors import Finding, Severity
from fab.extrusion import circle, extruded
from fab.hinges import (
    BARREL_SIDES,
    ROUND_SIDES,
    HingeSettings,
    crease_kinds,
    crease_runs,
    crease_sides,
)
from fab.panels import Panels
from fab.setbacks import Setbacks
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Knuckles", "knuckles_turn", "make_knuckles", "with_knuckles"]

# Arms reach so far into their panel, with which they are united.
_REACH_MM = 1e-3
# No panel has so many sides of its own.
_OTHERS = 1_000_000


@dataclass(frozen=True)
class Knuckles:
    """Where knuckles stand.

    Attributes
    ----------
    creases : the edge of each hinge, shape (n,).
    ends : shape (n, 2), from where to where its barrels stand, mm along its crease.
    counts : shape (n,), odd: barrels of both panels together.
    play_mm : the gap between two barrels.
    """

    creases: IntArray
    ends: FloatArray
    counts: IntArray
    play_mm: float

    @property
    def widths_mm(self) -> FloatArray:
        """Length of each barrel of a hinge along its crease, shape (n,)."""
        room = self.ends[:, 1] - self.ends[:, 0] - (self.counts - 1) * self.play_mm
        return np.asarray(room / self.counts)


def make_knuckles(
    pattern: CreasePattern, panels: Panels, settings: HingeSettings
) -> tuple[Knuckles, list[Finding]]:
    """Barrels for the creases of that kind; those that cannot have them are named.

    As many barrels as are at least `knuckle_mm` long, three or more, an odd number.
    """
    first, second = crease_sides(pattern, panels)
    chosen = crease_kinds(pattern, settings) == "knuckle"
    creases = np.flatnonzero((first >= 0) & (second >= 0) & chosen)
    back, play = panels.setbacks, settings.play_mm
    turns = knuckles_turn(back, settings)[creases]
    most_deg = 2 * np.degrees(np.arccos(play / back.axis_mm[creases]))
    levels = np.array([panels.heights_mm[0], 0.0, panels.heights_mm[1]])
    runs = crease_runs(panels, first[creases], second[creases], levels, up_to_axis=True)
    ends = runs + np.array([settings.relief_mm, -settings.relief_mm])
    room = ends[:, 1] - ends[:, 0]
    most = np.floor(np.maximum(room + play, 0) / (settings.knuckle_mm + play) + 1e-9)
    counts = (most - (most % 2 == 0)).astype(np.int64)
    fits = counts >= 3
    findings = []
    if not turns.all():
        worst = int(creases[~turns][np.argmin(most_deg[~turns])])
        findings.append(
            _missing(
                creases[~turns],
                f"fold too far for knuckles: crease {worst} folds by "
                f"{abs(pattern.edges_foldAngle[worst]):.4g} degrees, at which an arm comes nearer "
                f"than play_mm = {play:g}; it may fold by {most_deg[~turns].min():.4g}. Lower "
                "play_mm, raise thickness_mm, or lower fold_limit_deg",
            )
        )
    short = turns & ~fits
    if short.any():
        need = 3 * settings.knuckle_mm + 2 * play
        longest = float(np.maximum(room[short], 0).max())
        findings.append(
            _missing(
                creases[short],
                f"are too short for knuckles: three barrels of knuckle_mm = "
                f"{settings.knuckle_mm:g} need {need:.4g} mm between the corners of their panels, "
                f"the longest of them has {longest:.4g}. Lower knuckle_mm or thickness_mm, or "
                "enlarge the sheet",
            )
        )
    kept = turns & fits
    return Knuckles(creases[kept], ends[kept], counts[kept], play), findings


def knuckles_turn(back: Setbacks, settings: HingeSettings) -> BoolArray:
    """Whether arms stay `play_mm` away from the other panel as far as each crease folds, (ne,)."""
    half = np.arctan(np.maximum(back.above, back.below))
    with np.errstate(invalid="ignore"):
        return np.asarray(back.axis_mm * np.cos(half) >= settings.play_mm)


def _missing(creases: IntArray, why: str) -> Finding:
    text = f"{len(creases)} creases {why}, or choose another hinge for them."
    return Finding("hinge-missing", Severity.WARNING, text, creases=tuple(creases[:20].tolist()))


def with_knuckles(
    pattern: CreasePattern, panels: Panels, knuckles: Knuckles, settings: HingeSettings
) -> list[TriangleMesh]:
    """Every panel, united with its barrels, arms and pins where it has any."""
    parts = _parts(pattern, panels, knuckles, settings)
    low, high = panels.heights_mm
    meshes = []
    for i, face in enumerate(panels.faces.tolist()):
        mesh = panels.bodies.mesh(i)
        if face in parts:
            # those of several creases stand apart from each other
            all_parts = bodies_of(parts[face])
            barrels = TriangleMesh(
                all_parts.vertices_coords, all_parts.triangles, all_parts.triangles_plane
            )
            mesh = united([_told(mesh, low, high), _told(barrels, low, high, _OTHERS)])
        meshes.append(mesh)
    return meshes


def _told(mesh: TriangleMesh, low: float, high: float, others: int = 2) -> TriangleMesh:
    """A part of a panel; its bottom is side 0, its top 1, and its other sides follow `others`."""
    z = mesh.vertices_coords[mesh.triangles, 2]
    own = mesh.triangles_plane - mesh.triangles_plane.min() + others
    at = [(z == height).all(axis=1) for height in (low, high)]
    return replace(mesh, triangles_plane=np.where(at[0], 0, np.where(at[1], 1, own)))


def _parts(
    pattern: CreasePattern, panels: Panels, knuckles: Knuckles, settings: HingeSettings
) -> dict[int, list[TriangleMesh]]:
    """Bodies that are to be united with the panel of each face."""
    sides, back = panels.sides, panels.setbacks
    radius = panels.heights_mm[1]
    corner = radius * np.tan(np.pi / BARREL_SIDES)
    eight = [(radius, corner), (corner, radius), (-corner, radius), (-radius, corner)]
    barrel = shapely.Polygon([*eight, *((-x, -z) for x, z in eight)])
    none = np.zeros(2)
    bore = circle(none, settings.pin_mm / 2 + settings.play_mm, ROUND_SIDES, around=True)
    pin = circle(none, settings.pin_mm / 2, ROUND_SIDES, around=False)
    first, second = crease_sides(pattern, panels)
    out: dict[int, list[TriangleMesh]] = {}
    for crease, (low, _), count, width in zip(
        knuckles.creases.tolist(),
        knuckles.ends.tolist(),
        knuckles.counts.tolist(),
        knuckles.widths_mm.tolist(),
        strict=True,
    ):
        section = barrel | _arm(
            radius, float(back.axis_mm[crease]), float(back.above[crease]),
            float(back.below[crease]),
        )  # fmt: skip
        starts = low + np.arange(count) * (width + knuckles.play_mm)
        runs = np.column_stack([starts, starts + width])
        length = float(sides.length_mm[first[crease]])
        one, two = int(first[crease]), int(second[crease])
        for side, made in (
            (one, _strung(section, pin, runs[::2])),
            # the second face sees its crease the other way round
            (two, _row(section - bore, length - runs[1::2][::-1, ::-1])),
        ):
            out.setdefault(int(sides.faces[side]), []).append(
                _placed(made, sides.start[side], sides.along[side])
            )
    return out


def _arm(radius: float, off: float, above: float, below: float) -> shapely.Polygon:
    """The section of an arm: away from the axis and upwards, behind the bisecting plane."""
    return shapely.Polygon(
        [
            (below * radius, -radius),
            (off + below * radius + _REACH_MM, -radius),
            (off + _REACH_MM, 0.0),
            (off + above * radius + _REACH_MM, radius),
            (above * radius, radius),
            (0.0, 0.0),
        ]
    )


def _row(section: shapely.Polygon, runs: FloatArray) -> TriangleMesh:
    """Bodies of one section over several runs, shape (k, 2), of the third coordinate."""
    one = extruded(section, 0.0, 1.0)
    place = runs[:, :1] + (runs[:, 1:] - runs[:, :1]) * one.vertices_coords[:, 2]
    count = len(one.vertices_coords)
    shift = np.arange(len(runs))[:, None, None] * count
    return TriangleMesh(
        np.column_stack([np.tile(one.vertices_coords[:, :2], (len(runs), 1)), place.ravel()]),
        (one.triangles + shift).reshape(-1, 3),
        np.tile(one.triangles_plane, len(runs)),
    )


def _strung(section: shapely.Polygon, pin: shapely.Polygon, runs: FloatArray) -> TriangleMesh:
    """Bodies of one section over several runs, one with the pin that spans the gaps between them.

    They begin as a row with holes in the section of the pin. Walls of a hole, turned round and put
    between two of them, are those of the pin; the first and the last hole get a lid.
    """
    row = _row(section - pin, runs)
    both = len(row.vertices_coords) // len(runs)
    count, sides = both // 2, len(pin.exterior.coords) - 1
    per_run = len(row.triangles) // len(runs)
    hole = np.isin(row.triangles[:per_run] % count, np.arange(count - sides, count)).all(axis=1)
    hole &= row.triangles_plane[:per_run] > 1
    walls, wall_planes = row.triangles[:per_run][hole], row.triangles_plane[:per_run][hole]
    # from the far end of one body to the near end of the next
    across = np.where(walls < count, walls + count, walls - count + both)
    gaps = (across[:, ::-1] + np.arange(len(runs) - 1)[:, None, None] * both).reshape(-1, 3)
    ring = np.arange(count - sides, count)
    lid = np.column_stack([np.full(sides - 2, ring[0]), ring[1:-1], ring[2:]])
    end = len(row.vertices_coords) - count
    return TriangleMesh(
        row.vertices_coords,
        np.concatenate([row.triangles[np.tile(~hole, len(runs))], gaps, lid, lid[:, ::-1] + end]),
        np.concatenate(
            [
                row.triangles_plane[np.tile(~hole, len(runs))],
                np.tile(wall_planes, len(runs) - 1),
                np.repeat([0, 1], sides - 2),
            ]
        ),
    )


def _placed(mesh: TriangleMesh, start: FloatArray, along: FloatArray) -> TriangleMesh:
    """A mesh of sections (x into the panel, z) and of places along its side, where they are."""
    x, z, t = mesh.vertices_coords.T
    inward = np.array([-along[1], along[0]])
    flat = start + t[:, None] * along + x[:, None] * inward
    return replace(mesh, vertices_coords=np.column_stack([flat, z]))
