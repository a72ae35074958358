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

from fab.errors import Finding, Severity
from fab.geometry.bodies import Bodies
from fab.geometry.extrusion import circle
from fab.geometry.half_edges import HalfEdges, bodies_from, half_edges, triangles_within
from fab.panels.barrels import IN_TOP, Barrels, barrel_rows, solid_barrels
from fab.panels.bevelled_panels import Panels
from fab.panels.hinge_room import crease_runs, crease_sides
from fab.panels.hinges import ROUND_SIDES, HingeSettings, crease_kinds
from fab.panels.setbacks import Setbacks
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["Knuckles", "knuckles_turn", "make_knuckles", "with_knuckles"]

# No shorter barrels are advised.
_SHORTEST_MM = 1.0
# Walls lie where their setbacks put them, but for rounding.
_ON_WALL_MM = 1e-6


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
        shorter = (longest - 2 * play) / 3
        cure = (
            f"knuckle_mm = {np.floor(100 * shorter) / 100:g} fits into that one"
            if shorter >= _SHORTEST_MM
            else f"too short for barrels of {_SHORTEST_MM:g} mm"
        )
        findings.append(
            _missing(
                creases[short],
                f"are too short for knuckles: three barrels of knuckle_mm = "
                f"{settings.knuckle_mm:g} need {need:.4g} mm between the corners of their panels, "
                f"the longest of them has {longest:.4g}: {cure}. Lower knuckle_mm or "
                "thickness_mm, or enlarge the sheet",
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
) -> Bodies:
    """Every panel with its barrels, arms and pins where it has any, in one piece with it.

    An arm meets the wall of its panel over its full height. The wall is left out there, and the
    corners of the arm become corners of the sides around it.
    """
    barrels = _barrels(pattern, panels, knuckles)
    body = np.searchsorted(panels.faces, panels.sides.faces[barrels.sides])
    edges = half_edges(panels.bodies)
    bottoms, tops = edges.bottoms_and_tops(len(panels.bodies))
    pin = settings.pin_mm / 2
    rings = [
        shapely.get_coordinates(circle(np.zeros(2), radius, ROUND_SIDES, around=around))[:-1]
        for radius, around in ((pin, False), (pin + settings.play_mm, True))
    ]
    coords, owners = [panels.bodies.vertices_coords], [panels.bodies.vertices_body]
    triangles, planes = [], []
    vertex, plane = len(coords[0]), len(edges.bodies)
    on_wall = np.empty((len(body), 2, 3), np.int64)
    for row in solid_barrels(
        barrels, panels.sides, panels.setbacks, panels.heights_mm[1], rings[0], rings[1]
    ):
        whose = body[row.barrels]
        owner = whose[row.owner]
        coords.append(row.coords.reshape(-1, 3))
        owners.append(np.repeat(whose, row.coords.shape[1]))
        triangles.append(row.triangles + vertex)
        lying = np.where(row.planes == IN_TOP, tops[owner], bottoms[owner])
        planes.append(np.where(row.planes < 0, lying, row.planes + plane))
        on_wall[row.barrels] = row.corners + vertex
        vertex += len(coords[-1])
        plane += int(row.planes.max()) + 1
    places = np.concatenate(coords)
    walls = _opened(edges, panels, barrels, body, on_wall, places)
    covers, side = triangles_within(walls, places)
    return bodies_from(
        places,
        np.concatenate(owners),
        np.concatenate([covers, *triangles]),
        np.concatenate([side, *planes]),
    )


def _barrels(pattern: CreasePattern, panels: Panels, knuckles: Knuckles) -> Barrels:
    both = np.column_stack(crease_sides(pattern, panels))[knuckles.creases]
    return barrel_rows(
        knuckles.creases,
        both,
        panels.sides.length_mm[both[:, 0]],
        knuckles.ends,
        knuckles.counts,
        knuckles.play_mm,
    )


def _opened(
    edges: HalfEdges,
    panels: Panels,
    barrels: Barrels,
    body: IntArray,
    on_wall: IntArray,
    coords: FloatArray,
) -> HalfEdges:
    """The half edges of panels with corners at their barrels, their walls left out there.

    body : the panel of each barrel. on_wall : shape (n, 2, 3), vertices of each barrel, at both of
    its ends, at the bottom, axis and top of the wall.
    """
    met = [
        _along_walls(edges, panels, barrels, body, coords, z)
        for z in (panels.heights_mm[0], 0.0, panels.heights_mm[1])
    ]
    lies = np.zeros(len(edges.bodies), bool)
    for sides in edges.bottoms_and_tops(len(panels.bodies)):
        lies[sides] = True
    split = np.concatenate([edge for edge, _ in met])
    number = np.concatenate([barrel for _, barrel in met])
    level = np.repeat(np.arange(3), [len(edge) for edge, _ in met])
    # every edge that is split begins at its own start, then follow both ends of each barrel
    cut = np.unique(split)
    edge = np.concatenate([cut, np.repeat(split, 2)])
    barrel = np.concatenate([np.full(len(cut), -1), np.repeat(number, 2)])
    start = np.concatenate([edges.start[cut], on_wall[number, :, level].ravel()])
    order = np.lexsort((norm(coords[start] - coords[edges.start[edge]]), edge))
    edge, barrel, start = edge[order], barrel[order], start[order]
    goes_on = np.append(edge[1:] == edge[:-1], False)
    end = np.where(goes_on, np.roll(start, -1), edges.end[edge])
    within = goes_on & (barrel >= 0) & (barrel == np.roll(barrel, -1))
    kept = ~within | lies[edges.sides[edge]]
    # walls end at the barrels: upwards at the near end of each, downwards at its far end
    wall = np.empty((len(body), 2), np.int64)
    for column, (those, at) in enumerate((met[0], met[2])):
        upright = ~lies[edges.sides[those]]
        wall[at[upright], column] = edges.sides[those[upright]]
    near, far = on_wall[:, 0], on_wall[:, 1]
    whole = np.ones(len(edges.start), bool)
    whole[cut] = False
    return replace(
        edges,
        start=np.concatenate(
            [edges.start[whole], start[kept], near[:, :2].ravel(), far[:, 1:].ravel()]
        ),
        end=np.concatenate([edges.end[whole], end[kept], near[:, 1:].ravel(), far[:, :2].ravel()]),
        sides=np.concatenate(
            [edges.sides[whole], edges.sides[edge[kept]], wall.ravel(), wall.ravel()]
        ),
    )


def _along_walls(
    edges: HalfEdges,
    panels: Panels,
    barrels: Barrels,
    body: IntArray,
    coords: FloatArray,
    z_mm: float,
) -> tuple[IntArray, IntArray]:
    """Half edges at a height along the wall behind a barrel, and that barrel, shape (k,) each."""
    level = np.abs(coords[:, 2] - z_mm) <= _ON_WALL_MM
    there = np.flatnonzero(level[edges.start] & level[edges.end])
    owner = edges.bodies[edges.sides[there]]  # rising
    first = np.searchsorted(owner, body)
    many = np.searchsorted(owner, body, "right") - first
    barrel = np.repeat(np.arange(len(body)), many)
    edge = there[np.arange(len(barrel)) + np.repeat(first + many - np.cumsum(many), many)]
    side = barrels.sides[barrel]
    ends = coords[np.column_stack([edges.start[edge], edges.end[edge]]), :2]
    ends = ends - panels.sides.start[side][:, None]
    inward = (ends * panels.sides.inward[side][:, None]).sum(axis=2)
    along = (ends * panels.sides.along[side][:, None]).sum(axis=2)
    off = np.abs(inward - panels.setbacks.at(z_mm)[barrels.creases[barrel], None]).max(axis=1)
    covers = (along.min(axis=1) <= barrels.runs[barrel, 0]) & (
        along.max(axis=1) >= barrels.runs[barrel, 1]
    )
    fits = (off <= _ON_WALL_MM) & covers
    return edge[fits], barrel[fits]
