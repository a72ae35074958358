"""Distances that panels across a crease keep by construction: by setbacks, and by knuckles."""

from __future__ import annotations

import numpy as np

from fab.clearance.checked_bodies import CheckedBodies, faces_with_barrels
from fab.folding.folded_states import FoldedState, Stage
from fab.geometry.separating_planes import apart_along
from fab.panels.setbacks import Setbacks
from fab.panels.thick_sheet import ThickSheet
from solver.vectors import FloatArray, IntArray, norm, unit

__all__ = [
    "axis_slips_mm",
    "halfway_normals",
    "knuckled_mm",
    "mates_promised_mm",
    "promised_mm",
]

# Fold angles of states are known to this.
_ANGLE_DEG = 1e-6


def promised_mm(
    back: Setbacks, heights_mm: tuple[float, float], angles_deg: FloatArray
) -> FloatArray:
    """Distance of both panels of every crease at fold angles, shape (ne,), mm; 0 where they meet.

    angles_deg : shape (ne,). Seen along the crease, a point of a panel that is set back by s at
    the height z is s cos(rho / 2) - z sin(rho / 2) off the plane between both.
    """
    half = np.radians(angles_deg) / 2
    low, high = heights_mm
    levels = [low, high, 0.0] if low < 0 < high else [low, high]
    off = [back.at(z) * np.cos(half) - z * np.sin(half) for z in levels]
    return np.asarray(2 * np.maximum(np.min(off, axis=0), 0.0))


def mates_promised_mm(sheet: ThickSheet, checked: CheckedBodies, state: FoldedState) -> FloatArray:
    """Distance that panels across a crease must keep in a state, shape (k,), mm.

    It is what their setbacks promise; between flat and the target the least of what they promise
    at both. Panels linked by knuckles keep their play, and barrels come no nearer to any other
    panel.
    """
    panels = sheet.panels
    back, heights = panels.setbacks, panels.heights_mm
    out = promised_mm(back, heights, state.angles_deg)
    if state.stage == Stage.BETWEEN:
        out = np.fmin(promised_mm(back, heights, np.zeros_like(out)), back.clearance_mm)
    out = np.maximum(out[checked.mates_edge], 0.0)
    barrels = np.isin(checked.faces[checked.mates], faces_with_barrels(sheet)).any(axis=1)
    out[barrels] = np.minimum(out[barrels], sheet.knuckles.play_mm)
    return np.where(checked.linked >= 0, sheet.knuckles.play_mm, out)


def axis_slips_mm(sheet: ThickSheet, state: FoldedState, knuckles: IntArray) -> FloatArray:
    """How far apart a crease's ends are at most, seen from both panels, mm, shape (k,).

    knuckles : shape (k,), numbers of hinges in `sheet.knuckles`.
    """
    pattern = sheet.pattern
    edge = sheet.knuckles.creases[knuckles]
    ends = pattern.vertices_coords[pattern.edges_vertices[edge]]
    first, second = (
        ends @ state.turns[face][:, :, :2].swapaxes(1, 2) + state.shifts[face][:, None]
        for face in pattern.edges_faces[edge].T
    )
    return np.asarray(norm(first - second).max(axis=1, initial=0.0))


def knuckled_mm(
    sheet: ThickSheet, state: FoldedState, knuckles: IntArray, slips_mm: FloatArray
) -> FloatArray:
    """How far linked panels are apart at least in a state, mm, shape (k,); -inf where unknown.

    knuckles, slips_mm : shape (k,), as in `axis_slips_mm`.

    Panels without their barrels are parted by the plane between them. However far they turn about
    their axis between flat and the target, barrels and arms keep their play from all else
    (`fab.panels.knuckles`). They reach r from the axis. Where its ends slip by s, what is farther
    than r + play from it comes nearer by s at most, and the rest by s + 2 s (r + play) / l, with
    the length l of the axis.
    """
    pattern, panels, play = sheet.pattern, sheet.panels, sheet.knuckles.play_mm
    edge = sheet.knuckles.creases[knuckles]
    bare = panels.bodies.moved(state.turns[panels.faces], state.shifts[panels.faces])
    mates = np.searchsorted(panels.faces, pattern.edges_faces[edge])
    parted = apart_along(bare, mates, halfway_normals(sheet, state, edge))
    start, end = pattern.vertices_coords[pattern.edges_vertices[edge]].swapaxes(0, 1)
    ends = [np.hypot(panels.setbacks.at(z)[edge], z) for z in panels.heights_mm]
    near = np.maximum(*ends) + play
    kept = play - slips_mm * (1 + 2 * near / norm(end - start))
    angle, most = state.angles_deg[edge], pattern.edges_foldAngle[edge]
    within = (angle * np.sign(most) >= -_ANGLE_DEG) & (np.abs(angle) <= np.abs(most) + _ANGLE_DEG)
    return np.where(within, np.minimum(parted, kept), -np.inf)


def halfway_normals(sheet: ThickSheet, state: FoldedState, edges: IntArray) -> FloatArray:
    """Normals of the planes halfway between both faces of some creases, shape (k, 3)."""
    start, end = sheet.pattern.vertices_coords[sheet.pattern.edges_vertices[edges]].swapaxes(0, 1)
    along = end - start
    inward = np.column_stack([-along[:, 1], along[:, 0]])
    first, second = sheet.pattern.edges_faces[edges].T
    both = state.turns[first] + state.turns[second]
    return unit(np.squeeze(both[:, :, :2] @ inward[:, :, None], axis=2))
