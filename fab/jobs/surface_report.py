"""What the report says of how a sheet was grown, and how far it is from its surface, in mm."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver import Growth
from solver.vectors import FloatArray

__all__ = ["growth_report"]


def growth_report(growth: Growth, mm: float) -> dict[str, Any]:
    """How a sheet was grown, or relaxed onto its surface; `mm` : the length of a unit of it."""
    report: dict[str, Any] = {
        "status": growth.status,
        "strips": growth.strips,
        "advice": growth.advice,
        "coverage": growth.coverage,
        "chosen": dict(growth.chosen),
    }
    if growth.coverage is not None:
        report["method"] = "grow" if growth.deviations is None else "relax"
    if growth.deviations is not None:
        report["deviation"] = _spread(growth.deviations * mm)
        report["cell_mm"] = growth.chosen["step"] * mm
    if growth.distance is not None:
        report["distance_max_mm"] = growth.distance * mm
    if growth.distances is not None:
        smoothed = growth.chosen.get("smoothing_length", 0.0) * mm
        report["distance"] = _spread(growth.distances * mm) | {"smoothing_length_mm": smoothed}
    return report


def _spread(distances_mm: FloatArray) -> dict[str, float]:
    """Signed distances in short, positive on the surface's upper side."""
    return {
        "mean_mm": float(distances_mm.mean()),
        "rms_mm": float(np.sqrt((distances_mm**2).mean())),
        "lowest_mm": float(distances_mm.min()),
        "highest_mm": float(distances_mm.max()),
        "largest_mm": float(np.abs(distances_mm).max()),
    }
