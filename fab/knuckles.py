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

from fab.bodies import TriangleMesh
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
from solver.vectors import FloatArray, IntArray

__all__ = ["Knuckles", "make_knuckles", "with_knuckles"]

# Arms reach so far into their panel, with which they are united.
_REACH_MM = 1e-3
# Numbers of sides in each part of a panel with knuckles, apart from bottom 0 and top 1.
_PART = 1000


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
    half = np.arctan(np.maximum(back.above, back.below)[creases])
    turns = back.axis_mm[creases] * np.cos(half) >= play
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
            bodies = enumerate([mesh, *parts[face]])
            mesh = united([_told(body, low, high, 2 + k * _PART) for k, body in bodies])
        meshes.append(mesh)
    return meshes


def _told(mesh: TriangleMesh, low: float, high: float, base: int) -> TriangleMesh:
    """A part of a panel; its bottom and top have the same number in all parts, 0 and 1."""
    z = mesh.vertices_coords[mesh.triangles, 2]
    own = mesh.triangles_plane - mesh.triangles_plane.min() + base
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
    for crease, (low, high), count, width in zip(
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
        for side, profile, chosen in (
            (int(first[crease]), section, runs[::2]),
            # the second face sees its crease the other way round
            (int(second[crease]), section - bore, length - runs[1::2, ::-1]),
        ):
            parts = out.setdefault(int(sides.faces[side]), [])
            parts.append(_along(sides.start[side], sides.along[side], profile, chosen))
        middles = np.array([[low + width / 2, high - width / 2]])
        side = int(first[crease])
        out[int(sides.faces[side])].append(
            _along(sides.start[side], sides.along[side], pin, middles)
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


def _along(
    start: FloatArray, along: FloatArray, section: shapely.Polygon, runs: FloatArray
) -> TriangleMesh:
    """A section, seen along a side with its face to the right of the picture, over some runs.

    runs : from where to where along the side, shape (k, 2); one surface with k parts.
    """
    one = extruded(section, 0.0, 1.0)
    x, z, share = one.vertices_coords.T
    inward = np.array([-along[1], along[0]])
    place = runs[:, :1] + (runs[:, 1:] - runs[:, :1]) * share
    flat = start + place[..., None] * along + x[:, None] * inward
    coords = np.concatenate([flat, np.broadcast_to(z[:, None], (*place.shape, 1))], axis=2)
    count = len(x)
    shift = np.arange(len(runs))[:, None, None] * count
    return TriangleMesh(
        coords.reshape(-1, 3),
        (one.triangles + shift).reshape(-1, 3),
        np.tile(one.triangles_plane, len(runs)),
    )
