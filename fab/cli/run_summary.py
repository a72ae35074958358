"""Closing lines of `run`: what a maker asks of a sheet that was made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fab.cli.panels import solid_lines
from fab.cli.sheets import sheet_lines
from fab.errors import counted

__all__ = ["summary"]


def summary(report: Mapping[str, Any]) -> Iterator[str]:
    """The lines of a report, those of each kind of product where it was made."""
    yield (
        f"{counted(report['counts']['faces'], 'face')}; planarity {report['planarity_max']:.1e}, "
        f"developability {report['developability_max_rad']:.1e} rad, "
        f"isometry {report['isometry_max_rel']:.1e}"
    )
    boxes = report["bounding_box_mm"]
    yield f"flat {_sides(boxes['flat'])} mm; folded {_sides(boxes['folded'])} mm"
    if report["simulation"] is not None:
        yield report["simulation"]["text"]
    elif report["rigid"] is not None:
        yield report["rigid"]["text"]
    if "layers" in report:
        yield report["layers"]["text"]
    if "loads" in report:
        yield report["loads"]["text"]
    growth = report["growth"]
    if growth["coverage"] is not None:
        yield f"{growth['coverage']:.1%} of the surface is under the sheet"
    if "distance" in growth:
        yield _distance(growth["distance"])
    for key, goal in (report["goals"] or {}).items():
        within = f" within {goal['within_mm']:g} mm" if "within_mm" in goal else ""
        yield f"{key} = {goal['bound']:g}: {goal['reached']:.4g} reached{within}"
    if "sheets" in report:
        yield from sheet_lines(report)
    for number, line in enumerate(solid_lines(report)):
        yield line if number else f"thick: {line}"


def _sides(box: Sequence[float]) -> str:
    return " x ".join(f"{side:.4g}" for side in box)


def _distance(distance: Mapping[str, float]) -> str:
    mean, rms, lowest, highest = (
        f"{distance[key]:.3g}" for key in ("mean_mm", "rms_mm", "lowest_mm", "highest_mm")
    )
    smoothed = distance["smoothing_length_mm"]
    copy = f"; a copy of it smoothed over {smoothed:.3g} mm is followed" if smoothed else ""
    return f"vertices are {lowest} to {highest} mm from the surface, mean {mean}, RMS {rms}{copy}"
