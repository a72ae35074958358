"""Clip paths of SVG: which of the lines that are read they cut off in what the file shows."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from fab.formats.svg.shapes import SHAPES, Place, Point, drawn_shape
from fab.formats.svg.styles import local_name
from fab.formats.svg.transforms import attribute_transform, product
from fab.formats.svg.viewports import IDENTITY, Matrix, length_px

__all__ = ["Clip", "Clips", "clip_of"]

_REFERENCE = re.compile(r"""url\(\s*["']?#([^"')]+?)["']?\s*\)""")
_XLINK_HREF = "{http://www.w3.org/1999/xlink}href"
# Lines of a shape may leave what is shown by so many times the distance of chords from curves.
_SLACK = 2.0


@dataclass(frozen=True)
class Clip:
    """A clip path where it applies.

    Attributes
    ----------
    identity : of its element.
    matrix : from its user space to the page.
    size : of the user space, for percentages.
    """

    identity: str
    matrix: Matrix
    size: tuple[float, float]


def clip_of(value: str, matrix: Matrix, size: tuple[float, float]) -> Clip | None:
    """The clip that a value of clip-path names in a user space; None where it names no element."""
    found = _REFERENCE.fullmatch(value.strip())
    return None if found is None else Clip(found[1], matrix, size)


class Clips:
    """The clip paths of a file, each worked out once for each place."""

    def __init__(self, known: Mapping[str, ET.Element], tolerance: float) -> None:
        self._known = known
        self._tolerance = tolerance
        self._regions: dict[Clip, tuple[Any, Any] | None] = {}

    def cut_off(self, runs: list[list[Point]], clips: tuple[Clip, ...]) -> list[Point]:
        """The middle of what is not shown of each line that the clips cut off, all or in part.

        A clip that cannot be worked out counts as one that shows all, and holes in it as shown.
        """
        regions = [region for clip in clips if (region := self._region(clip)) is not None]
        if not regions:
            return []
        import shapely

        ends = np.array([pair for run in runs for pair in pairwise(run)])
        lines = shapely.linestrings(ends[np.isfinite(ends).all(axis=(1, 2))])
        out = []
        for region, slack in regions:
            cut = ~shapely.covers(slack, lines)
            hidden = shapely.difference(lines[cut], region)
            middles = shapely.line_interpolate_point(
                shapely.get_geometry(hidden, 0), 0.5, normalized=True
            )
            out += [(x, y) for x, y in shapely.get_coordinates(middles).tolist()]
            lines = lines[~cut]
        return out

    def _region(self, clip: Clip) -> tuple[Any, Any] | None:
        """What a clip shows, on the page, and how far lines may leave it; None if not known."""
        if clip not in self._regions:
            region = self._worked_out(clip)
            if region is None:
                self._regions[clip] = None
            else:
                slack = region.buffer(_SLACK * self._tolerance, join_style="mitre")
                self._regions[clip] = region, slack
        return self._regions[clip]

    def _worked_out(self, clip: Clip) -> Any:
        element = self._known.get(clip.identity)
        if element is None or local_name(element) != "clipPath":
            return None
        if element.get("clipPathUnits", "userSpaceOnUse") != "userSpaceOnUse":
            return None
        own = _moved(clip.matrix, element)
        runs: list[list[Point]] = []
        for child in element:
            drawn = None if own is None else self._runs(child, own, clip.size)
            if drawn is None:
                return None
            runs += drawn
        if not np.isfinite([value for run in runs for point in run for value in point]).all():
            return None
        import shapely

        rings = [shapely.Polygon(run) for run in runs if len(run) > 3]
        return shapely.union_all(shapely.make_valid(rings, method="structure"))

    def _runs(
        self, child: ET.Element, matrix: Matrix, size: tuple[float, float]
    ) -> list[list[Point]] | None:
        """The closed outlines of a child of a clip path; None where they are not known."""
        tag = local_name(child)
        inner = _moved(matrix, child)
        if inner is not None and tag == "use":
            target = child.get("href") or child.get(_XLINK_HREF) or ""
            across, up = length_px(child.get("x"), size[0]), length_px(child.get("y"), size[1])
            inner = product(inner, (1.0, 0.0, 0.0, 1.0, across, up))
            child = self._known.get(target.strip().removeprefix("#"), child)
            tag = local_name(child)
            inner = _moved(inner, child)
        if tag in ("", "title", "desc", "metadata"):
            return []
        if inner is None or tag not in SHAPES:
            return None
        try:
            drawn = drawn_shape(tag, child.attrib, Place(inner, size, self._tolerance))
        except (OverflowError, ValueError):
            return None
        return None if drawn.broken else [[*run, run[0]] for run in drawn.runs]


def _moved(matrix: Matrix, element: ET.Element) -> Matrix | None:
    """The matrix with the transform of an element; None where that cannot be read."""
    text = element.get("transform")
    own = IDENTITY if text is None else attribute_transform(text)
    return None if own is None or "transform" in element.get("style", "") else product(matrix, own)
