r"""Glue tabs: on which side of each seam there is one, or on both, and how large it is.

A tab is a trapezoid on one of the two pieces, to be glued under the face across the seam:

        b---------a      edge of the piece, its face above
         \       /
          q-----p        height by setting; both mitres leave the neighbours' room free

Where both sides have one, they are mirror images, folded behind the sheet and glued to each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from fab.sheets.seams import SeamSides
from fab.sheets.tab_offers import TabOffers, tab_clashes, tab_offers
from solver.vectors import FloatArray, IntArray

__all__ = ["Tabs", "glue_tabs", "paired_tabs"]


@dataclass(frozen=True)
class Tabs:
    """Tabs on seams, in the order of these.

    Attributes
    ----------
    seam, side : the seam that each tab is on, and the side of it, shape (m,).
    tops : the tab's outer corners, from p to q, in the plane of the whole pattern, mm, (m, k, 2).
    foldAngle : by which each is folded against the face that it is on, degrees, shape (m,).
    """

    seam: IntArray
    side: IntArray
    tops: FloatArray
    foldAngle: FloatArray  # noqa: N815 (the FOLD format's own name)

    @classmethod
    def none(cls) -> Tabs:
        """No tabs."""
        empty = np.empty(0, np.int64)
        return cls(empty, empty, np.empty((0, 2, 2)), np.empty(0))

    def sides_of(self, count: int) -> IntArray:
        """For each of `count` seams the first side that has a tab, -1 for none, shape (count,)."""
        out = np.full(count, -1)
        out[self.seam[::-1]] = self.side[::-1]
        return out


def glue_tabs(
    pattern: CreasePattern,
    faces_piece: IntArray,
    sides: SeamSides,
    tab_mm: float,
    angle_deg: float,
) -> Tabs:
    """The tab of each seam, with the side that carries it.

    Tabs overlap no face of their piece and no other tab of it, and lie within the face that they
    are glued to. The side with room for the higher tab carries it; where both have the same room,
    the piece with fewer tabs up to then.

    Parameters
    ----------
    faces_piece : number of the piece that each face is in, shape (nf,).
    tab_mm : greatest height; angle_deg : greatest angle at the foot of a tab, up to 90.
    """
    if not len(sides):
        return Tabs.none()
    offers = tab_offers(pattern, faces_piece, sides, tab_mm, angle_deg)
    against = tab_clashes(offers)
    carried: dict[int, int] = {}
    taken: dict[int, None] = {}  # in their order
    for offered in _by_seam(offers, len(sides)):
        open_to = [number for number in offered if not against[number] & taken.keys()]
        if open_to:
            best = min(
                open_to,
                key=lambda n: (
                    -round(float(offers.height_mm[n]), 6),
                    carried.get(int(offers.piece[n]), 0),
                    n,
                ),
            )
            taken[best] = None
            carried[int(offers.piece[best])] = carried.get(int(offers.piece[best]), 0) + 1
    return _taken(offers, list(taken), sides.foldAngle)


def paired_tabs(
    pattern: CreasePattern,
    faces_piece: IntArray,
    sides: SeamSides,
    tab_mm: float,
    angle_deg: float,
) -> Tabs:
    """Tabs on both sides of each seam that are laid onto each other; as `glue_tabs`.

    They halve the angle between their faces behind the sheet, so each is folded by half of the
    seam's angle less 90 degrees. Seams without room on both sides have none.
    """
    if not len(sides):
        return Tabs.none()
    offers = tab_offers(pattern, faces_piece, sides, tab_mm, angle_deg, alike=True)
    against = tab_clashes(offers)
    taken: dict[int, None] = {}  # in their order
    for offered in _by_seam(offers, len(sides)):
        free = [number for number in offered if not against[number] & taken.keys()]
        pairs = [
            (first, second)
            for first in free
            for second in free
            if offers.row[first] + 1 == offers.row[second]
            and abs(offers.height_mm[first] - offers.height_mm[second]) < 1e-9
        ]
        if pairs:
            highest = max(pairs, key=lambda pair: float(offers.height_mm[pair[0]]))
            taken |= dict.fromkeys(highest)
    return _taken(offers, list(taken), sides.foldAngle / 2 - 90)


def _by_seam(offers: TabOffers, count: int) -> list[list[int]]:
    """The numbers of the tabs that are offered for each seam."""
    out: list[list[int]] = [[] for _ in range(count)]
    for number, row in enumerate(offers.row.tolist()):
        out[row // 2].append(number)
    return out


def _taken(offers: TabOffers, taken: list[int], angle: FloatArray) -> Tabs:
    """The tabs that are taken; angle : the fold angle of those on each seam."""
    row = offers.row[taken]
    return Tabs(row // 2, row % 2, offers.tops[taken].reshape(-1, 2, 2), angle[row // 2])
