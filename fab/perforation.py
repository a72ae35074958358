"""Which lines does the cutter run along: dashes on creases, outlines around the sheet?"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from fab.crease import CreasePattern
from fab.errors import Finding, Severity
from fab.paths import CutPaths, Layer, Operation
from fab.settings import Settings
from solver.errors import InvalidValue
from solver.mesh import boundary_loops
from solver.vectors import FloatArray, IntArray

__all__ = ["DashStyle", "PerforationSettings", "perforate"]


# What is left of a crease between its margins must be longer than this to be cut.
_SHORTEST_CUT_MM = 0.01
# A cutter takes days over more, and they fill the memory.
_MOST_DASHES = 5_000_000


class DashStyle(Settings):
    """Cuts and gaps along a crease; the ratio is kept and the period fitted to each crease."""

    cut_mm: float = Field(ge=0.01, le=1000, description="length of each cut")
    gap_mm: float = Field(ge=0.01, le=1000, description="uncut material between two cuts")


class PerforationSettings(Settings):
    """How creases are perforated, by assignment."""

    mountain: DashStyle = DashStyle(cut_mm=3.0, gap_mm=1.0)
    valley: DashStyle = DashStyle(cut_mm=1.0, gap_mm=1.0)
    margin_mm: float = Field(
        default=0.5, gt=0, le=1000, description="uncut at both ends of every crease"
    )


def perforate(
    pattern: CreasePattern, settings: PerforationSettings
) -> tuple[CutPaths, list[Finding]]:
    """Dashes on mountains and valleys, and the outline of the sheet as closed polylines.

    Creases that are too short for their margins stay uncut and are named in a finding; flat
    creases (F) are not cut.
    """
    layers = []
    findings = []
    for operation, letter, style in (
        (Operation.MOUNTAIN, "M", settings.mountain),
        (Operation.VALLEY, "V", settings.valley),
    ):
        creases = np.flatnonzero(pattern.edges_assignment == letter)
        ends = pattern.vertices_coords[pattern.edges_vertices[creases]]
        segments, owner = dashes(ends, style, settings.margin_mm)
        uncut = np.setdiff1d(creases, creases[owner])
        if len(uncut):
            findings.append(
                Finding(
                    "crease-too-short",
                    Severity.ERROR if len(uncut) == len(creases) else Severity.WARNING,
                    f"{len(uncut)} of {len(creases)} {operation.lower()} creases leave nothing "
                    f"between their margins ({2 * settings.margin_mm:g} mm) and stay uncut. "
                    "Lower margin_mm or enlarge the sheet.",
                    creases=tuple(uncut[:20].tolist()),
                )
            )
        layers.append(Layer(operation, segments))
    outlines = tuple(pattern.vertices_coords[loop] for loop in boundary_loops(pattern.edges))
    layers.append(Layer(Operation.CUT, np.empty((0, 2, 2)), outlines))
    low, high = pattern.vertices_coords.min(axis=0), pattern.vertices_coords.max(axis=0)
    width, height = (high - low).tolist()
    return CutPaths(tuple(layers), (width, height)), findings


def dashes(ends: FloatArray, style: DashStyle, margin_mm: float) -> tuple[FloatArray, IntArray]:
    """Cuts along lines, symmetrical, with a whole number of periods between the margins.

    Parameters
    ----------
    ends : shape (n, 2, 2): line, end, coordinate, mm.

    Returns
    -------
    segments, shape (m, 2, 2), and the number of each segment's line, shape (m,), rising. The first
    cut begins and the last one ends at the margin; cut and gap are scaled alike to fit. A line too
    short for two cuts has one in its middle, not longer than asked for. A line that leaves less
    than 0.01 mm between its margins has none.
    """
    span = ends[:, 1] - ends[:, 0]
    length = np.hypot(span[:, 0], span[:, 1])
    room = length - 2 * margin_mm
    period = style.cut_mm + style.gap_mm
    count = np.where(
        room > _SHORTEST_CUT_MM, np.maximum(1, np.rint((room + style.gap_mm) / period)), 0
    )
    count = count.astype(np.int64)
    if count.sum() > _MOST_DASHES:
        raise InvalidValue(
            "number of dashes",
            int(count.sum()),
            f"be at most {_MOST_DASHES}",
            "Raise cut_mm and gap_mm, or make the sheet smaller.",
        )
    owner = np.repeat(np.arange(len(ends)), count)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(count > 1, room / (count * period - style.gap_mm), 1.0)
        direction = span / length[:, None]
    cut = np.minimum(scale * style.cut_mm, room)
    first = np.where(count > 1, margin_mm, (length - cut) / 2)
    begin = first[owner] + number * (scale * period)[owner]
    along = np.stack([begin, begin + cut[owner]], axis=1)
    segments = ends[owner, None, 0] + along[:, :, None] * direction[owner][:, None]
    return segments, owner
