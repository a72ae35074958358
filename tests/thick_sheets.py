"""Thick sheets that several test modules share."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np

from fab.crease import CreasePattern, crease_pattern
from fab.development import develop
from fab.hinges import HingeSettings
from fab.kinematics import fold_by_angles
from fab.panels import PanelSettings
from fab.pattern_file import read_pattern
from fab.thick import ThickSheet, thicken
from solver import Miura

PATTERNS = Path(__file__).parent / "patterns"


def scaled_to(pattern: CreasePattern, width_mm: float) -> CreasePattern:
    """The pattern with another width, and the shape into which its angles fold it."""
    factor = width_mm / np.ptp(pattern.vertices_coords, axis=0).max()
    flat = dataclasses.replace(pattern, vertices_coords=pattern.vertices_coords * factor)
    if pattern.folded_coords is not None:
        return dataclasses.replace(flat, folded_coords=pattern.folded_coords * factor)
    return dataclasses.replace(flat, folded_coords=fold_by_angles(flat).folded_coords)


def thick(pattern: CreasePattern, axis: str = "bottom", thickness_mm: float = 0.8) -> ThickSheet:
    """Panels and webs for a small sheet; creases fold up to 120 degrees."""
    panels = PanelSettings(thickness_mm=thickness_mm, gap_mm=0.4, axis=axis, fold_limit_deg=120.0)
    sheet, _ = thicken(pattern, panels, HingeSettings(web_mm=0.2, relief_mm=0.1))
    return sheet


@cache
def miura_pattern(columns: int = 4, rows: int = 4) -> CreasePattern:
    mesh = Miura(columns=columns, rows=rows).grow().mesh
    development = develop(mesh)
    return crease_pattern(mesh, development, 12 * columns / np.ptp(development.vertices_coords))


@cache
def shipped_pattern(name: str, width_mm: float) -> CreasePattern:
    """A pattern that others could have made, from the folder of FOLD files."""
    return scaled_to(read_pattern(PATTERNS / f"{name}.fold")[0], width_mm)
