"""How far the faces of a sheet bend and stretch on its way from flat to folded.

The simulation folds with bars that are about as soft as hinges, so that it finds its way: they
stretch by percents where paper would bend. What a sheet must bear is looked at in the states that
are strained most, at rest once more with bars a thousand times as stiff, about those of paper: a
strip of width w and thickness t resists stretching 12 (w / t)^2 times as much as bending.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fab.folding.bar_hinge_model import Framework, wrapped
from fab.folding.quasi_static import Folding, FoldState
from fab.folding.rest import relaxed
from fab.pattern.face_poses import bend_mm
from solver.hinge_angles import hinge_angles
from solver.vectors import FloatArray

__all__ = ["Bend", "curvature_max_per_mm", "largest_bend"]

# Bars of paper, over those of the simulation; and on the way there.
_STIFFER = (30.0, 1000.0)
# Springs that keep creases about where they are, over those of the simulation.
_KEPT = 1e-2
# States of larger sheets are taken as they are.
_MOST_HINGES = 20_000
# States with less strain are those of flat faces.
_STRAINED = 1e-6


@dataclass(frozen=True)
class Bend:
    """The most that any face of a fold bends.

    Attributes
    ----------
    distance_mm : largest distance of a corner from its face, were that flat.
    curvature_per_mm : largest curvature of a bent face: times half the thickness of the sheet it is
        the strain of the outer fibre. 0 for triangles, which stretch in its place.
    strain : largest absolute strain of a bar.
    load : share of the target angles of the state with the largest strain.
    energy : the largest of these states, in the units of `fab.folding.bar_hinge_model.Energy`.
    as_paper : whether the bars were as stiff as those of paper; else strain is an upper bound.
    """

    distance_mm: float
    curvature_per_mm: float
    strain: float
    load: float
    energy: float
    as_paper: bool


def largest_bend(folding: Folding) -> Bend:
    """That of all states of a fold."""
    frame = folding.frame
    strained = max(folding.states, key=lambda state: state.strain_max)
    few = len(frame.hinges_edge) <= _MOST_HINGES
    # without contact, what is pressed would slip through its faces and come to rest elsewhere
    as_paper = few and strained.strain_max > _STRAINED and folding.stopped is None
    states: Sequence[FoldState] = folding.states
    coords = [state.coords for state in states]
    energy = max(state.energy.total for state in states)
    if as_paper:
        bent = max(states, key=lambda state: _bend_mm(frame, state.coords))
        chosen = [strained] if bent is strained else [strained, bent]
        made = [_with_stiff_bars(folding, state) for state in chosen]
        coords = [each for each, _ in made]
        energy = max(each for _, each in made)
    return Bend(
        max(_bend_mm(frame, each) for each in coords),
        max(curvature_max_per_mm(frame, each) for each in coords),
        max(float(np.abs(frame.strains(each)).max()) for each in coords),
        strained.load,
        energy,
        as_paper,
    )


def _bend_mm(frame: Framework, coords: FloatArray) -> float:
    return bend_mm(frame.sheet.pattern, coords * frame.size_mm)


def _with_stiff_bars(folding: Folding, state: FoldState) -> tuple[FloatArray, float]:
    """The state at rest with stiff bars, shape (nv, 3), and its energy.

    Its creases are driven to the same angles.
    """
    frame = folding.frame
    target = state.load * frame.hinges_target
    if folding.in_turn:  # each at a rate of its own: soft springs keep them about where they are
        driven = frame.hinges_target != 0
        target = np.where(driven, frame.angles_near(state.coords, target), 0.0)
        softer = np.where(driven, _KEPT * frame.hinges_stiffness, frame.hinges_stiffness)
        frame = replace(frame, hinges_stiffness=softer)
    coords = state.coords
    for factor in _STIFFER:
        stiff = replace(frame, bars_stiffness=factor * frame.bars_stiffness)
        coords = relaxed(stiff, coords, target, last=False).coords
    return coords, stiff.energy(coords, target).total


def curvature_max_per_mm(frame: Framework, coords: FloatArray) -> float:
    """Largest curvature of a face whose triangles meet at an angle, 1 / mm.

    The angle between two triangles over the mean of their heights: that of a face whose corners are
    where they are, bent evenly across the side that they share.

    coords : shape (nv, 3), relative to the framework's size.
    """
    crease = frame.hinges_edge
    letters = frame.sheet.pattern.edges_assignment
    within = np.flatnonzero((crease < 0) | (letters[crease] == "J"))
    if not len(within):
        return 0.0
    angle = np.abs(wrapped(hinge_angles(coords, frame.hinges_vertices[within])))
    corners = frame.vertices_coords[frame.hinges_vertices[within]]
    side = corners[:, 1] - corners[:, 0]
    off = corners[:, 2:] - corners[:, :1]
    twice = np.abs(side[:, None, 0] * off[..., 1] - side[:, None, 1] * off[..., 0]).sum(axis=1)
    height = twice / frame.hinges_length[within]
    return float((2 * angle / height).max()) / frame.size_mm
