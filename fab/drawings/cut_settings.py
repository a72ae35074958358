"""Cut settings: how fast and with which power a machine goes along the lines of an operation."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CutSetting"]


@dataclass(frozen=True)
class CutSetting:
    """Speed and power of an operation.

    Attributes
    ----------
    speed_mm_s : of the head along the lines.
    power_percent : of the laser's full power; None where it is not known.
    """

    speed_mm_s: float
    power_percent: float | None = None
