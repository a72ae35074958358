"""Sketches: drawings in millimetres of paper, made of areas, lines, words and pictures.

They say what is drawn, and none of how a file holds it: `fab.viewing.sketch_svg` draws them on
pages of a browser, `fab.viewing.leaflet_pdf` on paper.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from solver.vectors import FloatArray

__all__ = ["Area", "Image", "Lines", "Mark", "Plan", "Sketch", "Words", "plan_of", "scale_text"]

# Drawings of plans have scales of 1 : n or n : 1 with these n, times powers of ten.
_SCALES = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Area:
    """What is within some rings, each of shape (m, 2), mm; rings within rings are holes.

    fill : a colour as #rrggbb, or none. edge : that of the line around it, `edge_mm` wide.
    """

    rings: tuple[FloatArray, ...]
    fill: str | None
    edge: str | None = None
    edge_mm: float = 0.2


@dataclass(frozen=True)
class Lines:
    """Straight lines, shape (n, 2, 2), mm; dashes : lengths of dashes and gaps in turn, mm."""

    segments: FloatArray
    colour: str
    width_mm: float
    dashes: tuple[float, ...] = ()


@dataclass(frozen=True)
class Words:
    """One line of text.

    at : mm, the middle of its capitals, or where it begins. size_mm : of the font.
    backing : the colour of a rectangle behind it, or none.
    """

    text: str
    at: tuple[float, float]
    size_mm: float
    across: Literal["start", "middle"] = "middle"
    bold: bool = False
    backing: str | None = None
    colour: str = "#000000"


@dataclass(frozen=True)
class Image:
    """A picture of pixels, shape (height, width, 3); corner : lower left, and its size, mm."""

    pixels: NDArray[np.uint8]
    corner: tuple[float, float]
    size_mm: tuple[float, float]


Mark = Area | Lines | Words | Image


@dataclass(frozen=True)
class Sketch:
    """A drawing from (0, 0) at its lower left to its size, mm; what is marked later is in front.

    caption : a line or so of text below it.
    """

    size_mm: tuple[float, float]
    marks: tuple[Mark, ...] = field(default=())
    caption: str = ""


@dataclass(frozen=True)
class Plan:
    """A plane as it is drawn on paper: the point p at p * scale + shift, mm.

    scale : millimetres of paper for each of the plane. size_mm : of the paper that it takes.
    """

    scale: float
    shift: FloatArray
    size_mm: tuple[float, float]

    def on_paper(self, points: FloatArray) -> FloatArray:
        """Points of the plane, shape (..., 2), on paper."""
        return np.asarray(points * self.scale + self.shift)


def plan_of(
    low: FloatArray, high: FloatArray, most_mm: tuple[float, float], margin_mm: float = 1.0
) -> Plan:
    """The largest usual scale at which a rectangle of a plane fits on paper with a margin.

    low, high : its corners, mm, shape (2,).

    >>> plan = plan_of(np.zeros(2), np.array([600.0, 400.0]), (82.0, 82.0))
    >>> plan.size_mm, scale_text(plan.scale)
    ((77.0, 52.0), '1 : 8')
    """
    span = high - low
    room = np.array(most_mm) - 2 * margin_mm
    with np.errstate(divide="ignore"):
        most = float((room / span).min())
    scale = _usual(most)
    width, height = (span * scale + 2 * margin_mm).tolist()
    return Plan(scale, margin_mm - low * scale, (width, height))


def scale_text(scale: float) -> str:
    """A scale as it is written.

    >>> scale_text(0.4), scale_text(1.0), scale_text(5.0)
    ('1 : 2.5', '1 : 1', '5 : 1')
    """
    return f"1 : {1 / scale:.4g}" if scale <= 1 else f"{scale:.4g} : 1"


def _usual(most: float) -> float:
    """The largest usual scale that is no larger than `most`."""
    if not np.isfinite(most):
        return 1.0
    power = int(np.floor(np.log10(most)))
    ratios = [n * 10.0**k for k in range(abs(power) + 2) for n in _SCALES]
    scales = [*(1 / ratio for ratio in ratios), *ratios]
    return max(scale for scale in scales if scale <= most * (1 + _ROUNDING))
