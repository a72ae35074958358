r"""Knuckles: barrels and pins that leave the printer as working hinges between panels.

Along a crease, barrels of its two panels alternate; those of the first face are at both ends and
carry a pin that runs through holes in the others. Seen along the axis, panels to the left and right
(a valley, closing above):

    +-----+   ___        +-----+
     \     \ /   \      /     /
      | arm |  o  |    |     |       barrel: eight sides, one on the bed, so it needs no support
      |     +     +    |     |       arm: from barrel to panel, behind the bisecting plane
      +-----+\___/     +-----+

Barrels stay within their radius R however far the hinge turns, and the other panel, set back by
R + play, stays beyond it. Arms lie on their own side of the plane that halves the fold angle, so
they keep (R + play) cos(rho / 2) from the other panel at the target.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.errors import Finding, Severity, counted, first_few
from fab.panels.bevelled_panels import Panels
from fab.panels.hinge_room import crease_runs, crease_sides
from fab.panels.hinges import HingeSettings, crease_kinds
from fab.panels.setbacks import Setbacks
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Knuckles", "knuckles_turn", "make_knuckles"]

# Advice names no shorter barrels.
_SHORTEST_MM = 1.0


@dataclass(frozen=True)
class Knuckles:
    """Creases with knuckles, and how many barrels each has.

    Attributes
    ----------
    creases : the edge of each hinge, shape (n,).
    ends : shape (n, 2), where its first barrel begins and its last one ends, mm along its crease.
    counts : shape (n,), odd: barrels of both panels together.
    play_mm : the gap between two barrels.
    """

    creases: IntArray
    ends: FloatArray
    counts: IntArray
    play_mm: float


def make_knuckles(
    pattern: CreasePattern, panels: Panels, settings: HingeSettings
) -> tuple[Knuckles, list[Finding]]:
    """Barrels for the creases of that kind, and findings of those that cannot have them.

    Each crease has the largest odd number of barrels, three or more, that are at least
    `knuckle_mm` long.
    """
    first, second = crease_sides(pattern, panels)
    chosen = crease_kinds(pattern, settings) == "knuckle"
    creases = np.flatnonzero((first >= 0) & (second >= 0) & chosen)
    back, play = panels.setbacks, settings.play_mm
    turns = knuckles_turn(back, settings)[creases]
    most_deg = 2 * np.degrees(np.arccos(play / back.axis_mm[creases]))
    levels = np.array([panels.heights_mm[0], 0.0, panels.heights_mm[1]])
    runs = crease_runs(panels, first[creases], second[creases], levels, up_to_axis=True)
    ends = runs + np.array([settings.relief_mm, -settings.relief_mm])
    room = ends[:, 1] - ends[:, 0]
    most = np.floor(np.maximum(room + play, 0) / (settings.knuckle_mm + play) + 1e-9)
    counts = (most - (most % 2 == 0)).astype(np.int64)
    fits = counts >= 3
    findings = []
    if not turns.all():
        findings.append(_overfolded(pattern, creases[~turns], most_deg[~turns], play))
    short = turns & ~fits
    if short.any():
        findings.append(_short(creases[short], room[short], settings))
    kept = turns & fits
    return Knuckles(creases[kept], ends[kept], counts[kept], play), findings


def _overfolded(
    pattern: CreasePattern, creases: IntArray, most_deg: FloatArray, play_mm: float
) -> Finding:
    """The finding of creases that fold further than `most_deg`, shape (k,), at which arms jam."""
    worst = int(creases[np.argmin(most_deg)])
    return _missing(
        f"{counted(len(creases), 'crease folds', 'creases fold')} too far for knuckles: crease "
        f"{worst} folds by {abs(pattern.edges_foldAngle[worst]):.4g} degrees, at which an arm "
        f"comes nearer than play_mm = {play_mm:g}; it may fold by {most_deg.min():.4g}. Lower "
        "play_mm, raise thickness_mm, or lower fold_limit_deg",
        creases,
    )


def _short(creases: IntArray, room_mm: FloatArray, settings: HingeSettings) -> Finding:
    """The finding of creases that have no room, shape (k,), for three barrels."""
    need = 3 * settings.knuckle_mm + 2 * settings.play_mm
    longest = float(np.maximum(room_mm, 0).max())
    shorter = (longest - 2 * settings.play_mm) / 3
    cure = (
        f"knuckle_mm = {np.floor(100 * shorter) / 100:g} fits into the longest"
        if shorter >= _SHORTEST_MM
        else f"too short for barrels of {_SHORTEST_MM:g} mm"
    )
    panels = (
        "its panels, and this crease has"
        if len(creases) == 1
        else "their panels, and the longest crease has"
    )
    return _missing(
        f"{counted(len(creases), 'crease is', 'creases are')} too short for knuckles: three "
        f"barrels of knuckle_mm = {settings.knuckle_mm:g} need {need:.4g} mm between the corners "
        f"of {panels} {longest:.4g}: {cure}. Lower knuckle_mm or thickness_mm, or enlarge the "
        "sheet",
        creases,
    )


def _missing(text: str, creases: IntArray) -> Finding:
    text += f", or choose another hinge for {'it' if len(creases) == 1 else 'them'}."
    return Finding("hinge-missing", Severity.WARNING, text, creases=first_few(creases))


def knuckles_turn(back: Setbacks, settings: HingeSettings) -> BoolArray:
    """Whether arms stay `play_mm` away from the other panel as far as each crease folds, (ne,)."""
    half = np.arctan(np.maximum(back.above, back.below))
    with np.errstate(invalid="ignore"):
        return np.asarray(back.axis_mm * np.cos(half) >= settings.play_mm)
