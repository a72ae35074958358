r"""Barrels, arms and pins along the sides of panels, as surfaces that are open at their walls.

The section of a barrel with its arm, x into its panel and z upwards, around a hole for the pin:

      6----5    3------2
     7      \  /      /
     |   o   4       1       0, 1, 2: on the wall of the panel, at its bottom, its axis and its top.
     8      /        |       3, 4, 5: a notch between barrel and arm. Creases that fold little have
      9-------------0        none, and there is one more corner where 4 is below the slanted side.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fab.geometry.extrusion import walls
from fab.geometry.triangulation import covered
from fab.panels.hinges import BARREL_SIDES
from fab.panels.setbacks import Setbacks, Sides
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["IN_BOTTOM", "IN_TOP", "BarrelRow", "Barrels", "barrel_rows", "solid_barrels"]

# Notches are left out up to this slope over that at which they have no area.
_NOTCH = 1e-6
# Planes of triangles that go on in the bottom or the top of the panel.
IN_BOTTOM, IN_TOP = -1, -2
# Corners of a section on the wall of the panel, the first ones: bottom, axis, top.
_ON_WALL = 3


@dataclass(frozen=True)
class Barrels:
    """Barrels one after another along creases.

    Attributes
    ----------
    creases : shape (n,), rising, the edge of each.
    sides : shape (n,), the side of a face (`Sides`) that it is at.
    runs : shape (n, 2), where it begins and ends, mm from the start of that side.
    pinned : shape (n,), whether it carries a pin, which the others turn about.
    first, last : shape (n,), whether it is the first or the last one with its pin.
    """

    creases: IntArray
    sides: IntArray
    runs: FloatArray
    pinned: BoolArray
    first: BoolArray
    last: BoolArray


@dataclass(frozen=True)
class BarrelRow:
    """Surfaces of barrels whose sections have equally many corners, open at their panel's wall.

    Attributes
    ----------
    barrels : shape (n,), which barrels.
    coords : shape (n, k, 3), mm: vertices of each.
    triangles : shape (m, 3), numbers of vertices, those of the first barrel first.
    planes : shape (m,), equal for triangles of one planar side; IN_BOTTOM or IN_TOP
        where it goes on in that of the panel.
    owner : shape (m,), the barrel of each triangle, as a number in `barrels`.
    corners : shape (n, 2, 3), the vertices at both ends on the wall: at bottom, axis, top.
    """

    barrels: IntArray
    coords: FloatArray
    triangles: IntArray
    planes: IntArray
    owner: IntArray
    corners: IntArray


def barrel_rows(
    creases: IntArray,
    both_sides: IntArray,
    lengths_mm: FloatArray,
    ends: FloatArray,
    counts: IntArray,
    play_mm: float,
) -> Barrels:
    """Barrels of both sides of creases in turn, those of the first one at both ends, with the pin.

    both_sides : shape (k, 2), sides in the first and the second face, which runs against the first.
    lengths_mm : shape (k,), of these sides. ends, counts : shapes (k, 2) and (k,), where the first
    barrel begins and the last one ends on the first side, and their number.
    """
    hinge = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(hinge)) - np.repeat(np.cumsum(counts) - counts, counts)
    width = (ends[:, 1] - ends[:, 0] - (counts - 1) * play_mm) / counts
    start = ends[hinge, 0] + number * (width[hinge] + play_mm)
    runs = np.column_stack([start, start + width[hinge]])
    pinned = number % 2 == 0
    turned = lengths_mm[hinge, None] - runs[:, ::-1]
    return Barrels(
        creases[hinge],
        both_sides[hinge, (~pinned).astype(np.int64)],
        np.where(pinned[:, None], runs, turned),
        pinned,
        number == 0,
        number == counts[hinge] - 1,
    )


def solid_barrels(
    barrels: Barrels,
    sides: Sides,
    back: Setbacks,
    radius_mm: float,
    pin: FloatArray,
    bore: FloatArray,
) -> Iterator[BarrelRow]:
    """The surfaces of barrels, each with its arm, and of their pins.

    radius_mm : from the axis to the sides of a barrel. pin, bore : shape (k, 2), counterclockwise
    corners of a pin and of the hole that turns about it.
    """
    creases = np.unique(barrels.creases)
    slopes = np.column_stack([back.above, back.below])[creases]
    notches = np.searchsorted(np.tan(np.pi / 8 * np.array([1, 3])) + _NOTCH, slopes)
    for kind in np.unique(notches, axis=0):
        alike = creases[(notches == kind).all(axis=1)]
        outline = _outlines(
            radius_mm, back.axis_mm[alike], back.above[alike], back.below[alike], kind
        )
        for ring, with_pin in ((pin, True), (bore, False)):
            holes = np.broadcast_to(ring[::-1], (len(alike), *ring.shape))
            sections = np.concatenate([outline, holes], axis=1)
            chosen = np.flatnonzero(np.isin(barrels.creases, alike) & (barrels.pinned == with_pin))
            section = np.searchsorted(alike, barrels.creases[chosen])
            yield _row(barrels, chosen, sides, sections, section, outline.shape[1])


def _outlines(
    radius: float, off: FloatArray, above: FloatArray, below: FloatArray, notches: IntArray
) -> FloatArray:
    """Counterclockwise corners of sections, shape (k, n, 2), as drawn above.

    notches : above and below, 0 without one, 1 from the slanted side of the barrel, 2 from its
    upright one.
    """
    corner = radius * np.tan(np.pi / BARREL_SIDES)

    def notched(slope: FloatArray, kind: int) -> list[tuple[FloatArray, FloatArray]]:
        """From the arm's own corner to the barrel's level side, all above the axis."""
        if kind == 0:
            return []
        ones = np.ones_like(slope)
        x = slope * np.sqrt(2) * radius / (1 + slope) if kind == 1 else radius * ones
        more = [] if kind == 1 else [(radius * ones, corner * ones)]
        begin, end = (slope * radius, radius * ones), (corner * ones, radius * ones)
        return [begin, (x, x / slope), *more, end]

    def at(x: float, z: float) -> tuple[FloatArray, FloatArray]:
        return np.full_like(off, x), np.full_like(off, z)

    points = [
        (off + below * radius, at(0, -radius)[1]),
        (off, at(0, 0)[1]),
        (off + above * radius, at(0, radius)[1]),
        *notched(above, int(notches[0])),
        at(-corner, radius),
        at(-radius, corner),
        at(-radius, -corner),
        at(-corner, -radius),
        *((x, -z) for x, z in notched(below, int(notches[1]))[::-1]),
    ]
    return np.stack([np.column_stack(point) for point in points], axis=1)


def _row(
    barrels: Barrels,
    chosen: IntArray,
    sides: Sides,
    sections: FloatArray,
    section: IntArray,
    around: int,
) -> BarrelRow:
    """Barrels over sections, shape (k, n, 2), whose first `around` corners are not of the hole."""
    kinds, count = sections.shape[:2]
    starts = np.arange(kinds) * count
    rings = np.concatenate([[0], np.column_stack([starts + around, starts + count]).ravel()])
    cap = covered(sections.reshape(-1, 2), rings, np.arange(0, len(rings), 2))
    cap = (cap.reshape(kinds, count, 3) - starts[:, None, None])[section]
    # one after another the barrels and arms, the ends of the first one before those of the next
    edge = np.arange(_ON_WALL - 1, around)
    outer = walls(edge, np.where(edge + 1 < around, edge + 1, 0), count)
    plane = 2 + edge
    plane[0], plane[-1] = IN_TOP, IN_BOTTOM
    ring = np.arange(around, count)
    hole = walls(ring, np.roll(ring, -1), count)
    fan = np.column_stack([np.full(len(ring) - 2, ring[0]), ring[1:-1], ring[2:]])
    pinned = barrels.pinned[chosen]
    first, last = (np.flatnonzero(pinned & at[chosen]) for at in (barrels.first, barrels.last))
    inner = np.flatnonzero(pinned & ~barrels.last[chosen])
    bored = np.flatnonzero(~pinned)
    every = np.arange(len(chosen))
    # walls of a hole, from the far end of one barrel to the near end of the next and turned round,
    # are those of a pin
    between = hole[:, ::-1] + count
    parts = [
        (every, cap[:, :, ::-1], np.zeros(count, np.int64)),
        (every, cap + count, np.ones(count, np.int64)),
        (every, outer, np.tile(plane, 2)),
        (bored, hole, np.tile(2 + ring, 2)),
        (inner, between, np.tile(2 + ring, 2)),
        (first, fan, np.zeros(len(fan), np.int64)),
        (last, fan[:, ::-1] + count, np.ones(len(fan), np.int64)),
    ]
    triangles, planes, owners = [], [], []
    for owner, local, own in parts:
        triangles.append((local + 2 * count * owner[:, None, None]).reshape(-1, 3))
        shift = np.where(own < 0, 0, (count + 2) * owner[:, None])
        planes.append((own + shift).ravel())
        owners.append(np.repeat(owner, len(own)))
    side = barrels.sides[chosen]
    x, z = sections[section].transpose(2, 0, 1)[:, :, None]
    along = barrels.runs[chosen][:, :, None, None] * sides.along[side][:, None, None]
    flat = (
        sides.start[side][:, None, None] + along + x[..., None] * sides.inward[side][:, None, None]
    )
    high = np.broadcast_to(z[..., None], (*flat.shape[:3], 1))
    ends = 2 * count * every[:, None, None] + count * np.arange(2)[:, None] + np.arange(_ON_WALL)
    return BarrelRow(
        chosen,
        np.concatenate([flat, high], axis=3).reshape(len(chosen), 2 * count, 3),
        np.concatenate(triangles),
        np.concatenate(planes),
        np.concatenate(owners),
        ends,
    )
