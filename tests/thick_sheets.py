"""Thick sheets that several test modules share."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
from flat_patterns import pattern_of
from helpers import PATTERNS

from fab import read_pattern
from fab.geometry.bodies import Bodies
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import ThickSheet, thicken
from fab.pattern.crease_pattern import CreasePattern, crease_pattern
from fab.pattern.development import develop
from fab.pattern.face_poses import face_poses
from fab.pattern.kinematics import fold_by_angles
from solver import Miura

SIDE_MM = 20.0
WEBS = HingeSettings(web_mm=0.2, relief_mm=0.1)


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


def creased(flat, faces, angle_deg: float) -> CreasePattern:
    """Faces whose creases all fold by one angle, with the form that two halves at x = 0 have."""
    pattern = pattern_of(flat, faces, "V" if angle_deg > 0 else "M", angle=abs(angle_deg))
    return dataclasses.replace(pattern, folded_coords=folded(flat, angle_deg))


def book(angle_deg: float) -> CreasePattern:
    """Two squares across a crease along y at x = 0, with its folded form."""
    flat = np.array([[0, 0], [0, 1], [1, 0], [1, 1], [-1, 0], [-1, 1]]) * SIDE_MM
    return creased(flat, [[0, 2, 3, 1], [4, 0, 1, 5]], angle_deg)


def folded(flat, angle_deg):
    """Each half turned up by half of the angle."""
    half = np.radians(angle_deg) / 2
    x, y = flat.T
    return np.column_stack([x * np.cos(half), y, np.abs(x) * np.sin(half)])


def in_pose(sheet: ThickSheet, coords) -> Bodies:
    """The rigid bodies, in the order of `sheet.rigid`, where a folded state has their faces.

    coords : shape (nv, 3), mm, of the pattern's vertices.
    """
    turns, shifts = face_poses(sheet.pattern, coords)
    owner = sheet.faces[sheet.rigid]
    return sheet.bodies.chosen(sheet.rigid).moved(turns[owner], shifts[owner])


def solid(pattern, **panel):
    return thicken(pattern, PanelSettings(**panel), WEBS)[0]
