"""Labels: texts engraved on pieces in letters of single strokes, as high as their room allows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.drawings.cut_paths import Layer, Operation
from fab.sheets.stroke_letters import letter_strokes
from solver.vectors import FloatArray

__all__ = [
    "Label",
    "LabelPlaces",
    "engraved",
    "fitted",
    "highest",
    "number_text",
    "text_box",
    "text_lines",
    "text_width",
]

# The larger of two labels that overlap is made lower by this factor.
_SHRINK = 0.8
# Over the size of a room: what is nearer to the line that a text is above is on it.
_ON_SIDE_REL = 1e-9
# Height of the box that a text keeps free, in heights of its capitals, and what J and Q, which
# reach lower, keep free below them.
_BOX_HEIGHT = 1.2
_BELOW = 0.1
# Digits that are digits when turned upside down.
_TURNED = str.maketrans("01689", "01986")


@dataclass(frozen=True)
class Label:
    """Text on a piece.

    Attributes
    ----------
    at : middle of the text, mm.
    height_mm : of capitals and digits.
    angle_deg : direction in which it is read, from x towards y.
    """

    text: str
    at: tuple[float, float]
    height_mm: float
    angle_deg: float


def number_text(number: int) -> str:
    """A number to be engraved, with a full stop where upside down it would read as another one.

    >>> [number_text(number) for number in (6, 8, 25, 86)]
    ['6.', '8', '25', '86.']
    """
    text = str(number)
    turned = text[::-1].translate(_TURNED)
    other = set(text) <= set("01689") and turned != text and turned[0] != "0"
    return f"{text}." if other else text


@lru_cache(maxsize=4096)
def _centred(text: str) -> tuple[FloatArray, ...]:
    """Lines of a text, capitals one high, its middle at the origin."""
    lines = letter_strokes(text)
    if not lines:
        return ()
    every = np.concatenate(lines)
    middle = (every.min(axis=0) + every.max(axis=0)) / 2
    return tuple(line - middle for line in lines)


def text_width(text: str) -> float:
    """Width of a text whose capitals are one high."""
    lines = _centred(text)
    return float(np.ptp(np.concatenate(lines)[:, 0])) if lines else 0.0


def text_lines(
    text: str,
    height_mm: float,
    at: tuple[float, float],
    angle_deg: float,
    *,
    mirrored: bool = False,
) -> tuple[FloatArray, ...]:
    """Letters as open lines, each of shape (m, 2).

    height_mm : of capitals and digits; at : middle of the text, mm; angle_deg : direction in which
    it is read. mirrored : left and right of the text exchanged, in the same room.
    """
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    turn = height_mm * np.array([[c, -s], [s, c]]) @ np.diag([-1.0 if mirrored else 1.0, 1.0])
    return tuple(line @ turn.T + np.array(at) for line in _centred(text))


def engraved(labels: Sequence[Label], *, mirrored: bool = False) -> Layer:
    """The layer with the lines of labels; mirrored ones are read on a sheet that is mirrored."""
    lines = (
        line
        for label in labels
        for line in text_lines(
            label.text, label.height_mm, label.at, label.angle_deg, mirrored=mirrored
        )
    )
    return Layer(Operation.ENGRAVE, chains=tuple(lines))


def highest(
    text: str, anchor: FloatArray, slant: float, room: shapely.Polygon, hang: float = 0.0
) -> float:
    """Height up to which a text may grow from its anchor before it leaves a room, mm.

    anchor : shape (2,). slant : direction of the text, radians. hang : distance of its middle from
    its anchor, to the left, in heights. A text of no height must be in the room, at the anchor or
    beside it. In a room that is empty it is 0.
    """
    if room.is_empty:
        return 0.0
    c, s = np.cos(slant), np.sin(slant)
    box_width, box_height = text_box(text)
    low, top = hang - box_height / 2, hang + box_height / 2
    lines, of = shapely.get_coordinates(shapely.get_rings(room), return_index=True)
    turned = (lines - anchor) @ np.array([[c, -s], [s, c]])
    turned[:, 0] /= 0.5 * box_width
    sides = np.stack([turned[:-1], turned[1:]], axis=1)[of[:-1] == of[1:]]
    # a text of height h is the box |x| <= h, low h <= y <= top h: along a side of the room the
    # least h that reaches a point is at an end of the side or where two of these are equal
    normals = np.array([[1, 0], [0, 1], [low, 1], [low, -1], [top, 1], [top, -1]])
    start, end = sides[:, 0] @ normals.T, sides[:, 1] @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.nan_to_num(start / (start - end), nan=0.0, posinf=0.0, neginf=0.0)
    share = np.clip(np.column_stack([share, np.zeros(len(start)), np.ones(len(start))]), 0, 1)
    points = sides[:, :1] + share[..., None] * (sides[:, 1:] - sides[:, :1])
    x, y = np.abs(points[..., 0]), points[..., 1]
    reached = np.maximum(x, y / top)
    if low < 0:
        return float(np.maximum(reached, y / low).min())
    # the text is off its anchor, and passes what is below it
    met = (y > _ON_SIDE_REL * np.abs(turned).max()) & (low * x <= y * (1 + _ON_SIDE_REL))
    return float(reached[met].min(initial=np.inf))


def text_box(text: str) -> tuple[float, float]:
    """Width and height of what a text keeps free, its capitals one high."""
    lines = _centred(text)
    height = float(np.ptp(np.concatenate(lines)[:, 1])) if lines else 0.0
    return text_width(text) + 0.4, max(_BOX_HEIGHT, height + _BELOW)


@dataclass(frozen=True)
class LabelPlaces:
    """Where texts are to be engraved.

    Attributes
    ----------
    texts : n of them.
    anchors, angles : point (n, 2) and direction (n,), radians, of the line each text belongs to.
    rooms : the polygon in which each must stay.
    height_mm : the greatest heights, shape (n,).
    hang : distance of a text's middle from its anchor, to the left, in heights, shape (n,).
    """

    texts: Sequence[str]
    anchors: FloatArray
    angles: FloatArray
    rooms: Sequence[shapely.Polygon]
    height_mm: FloatArray
    hang: FloatArray

    def boxes(self, height_mm: FloatArray) -> tuple[FloatArray, NDArray[np.object_]]:
        """Middles of the texts and what they keep free, for these heights: (n, 2) and (n,)."""
        half_x, half_y = np.array([text_box(text) for text in self.texts]).T / 2
        u = np.column_stack([np.cos(self.angles), np.sin(self.angles)])
        v = np.column_stack([-u[:, 1], u[:, 0]])
        middle = self.anchors + (self.hang * height_mm)[:, None] * v
        x, y = (half_x * height_mm)[:, None] * u, (half_y * height_mm)[:, None] * v
        ring = np.stack([middle - x - y, middle + x - y, middle + x + y, middle - x + y], axis=1)
        return middle, shapely.polygons(ring)


def fitted(places: LabelPlaces, least_mm: float) -> tuple[Label | None, ...]:
    """Labels as high as asked for or as their rooms allow, or lower, clear of each other.

    There is none where it would be lower than `least_mm`, which is greater than 0.
    """
    wanted = zip(
        places.texts, places.anchors, places.angles, places.rooms, places.hang, strict=True
    )
    height = np.minimum(places.height_mm, [highest(*text) for text in wanted])
    if not len(height):
        return ()
    written = height >= least_mm
    while True:
        middle, boxes = places.boxes(height)
        a, b = shapely.STRtree(boxes).query(boxes, predicate="intersects")
        # the larger of two gives way first
        clash = (a != b) & written[a] & written[b] & (height[a] >= height[b])
        if not clash.any():
            break
        height[np.unique(a[clash])] *= _SHRINK
        written &= height >= least_mm
    return tuple(
        Label(text, (x, y), h, angle) if kept else None
        for text, (x, y), h, angle, kept in zip(
            places.texts,
            middle.tolist(),
            height.tolist(),
            np.degrees(places.angles).tolist(),
            written.tolist(),
            strict=True,
        )
    )
