"""Relaxation: all vertices of a sheet moved at once until it is exact and near what is wished."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from solver.errors import InvalidState, InvalidValue, require_count, require_positive
from solver.relaxation.minimisation import Descent, Soft, minimised
from solver.relaxation.projection import Projection, projected
from solver.relaxation.terms import Term
from solver.vectors import FloatArray, points

__all__ = ["Relaxation", "RelaxationStatus", "relax"]

# Hard residuals from which the projection converges at once, and with which a sheet is exact.
_NEAR = 1e-5
_EXACT = 1e-12


class RelaxationStatus(StrEnum):
    """How relaxation ended. Everything but RELAXED leaves an inexact sheet, with advice."""

    RELAXED = "relaxed"
    NOT_CONVERGED = "not_converged"
    STUCK = "stuck"
    STOPPED = "stopped"


@dataclass(frozen=True)
class Relaxation:
    """What relaxation made: coordinates in every case, and how it ended.

    Attributes
    ----------
    coords : shape (nv, 3). status : how it ended; advice : empty where it is RELAXED.
    rounds : steps of Levenberg-Marquardt. hard_residual : largest residual of the hard terms.
    history : the largest hard residual at first and after each round.
    projection : the same before and after each step of the projection.
    soft_values : residuals of each soft term at the end, in the order in which they were given.
    """

    coords: FloatArray
    status: RelaxationStatus
    advice: str
    rounds: int
    hard_residual: float
    history: tuple[float, ...]
    projection: tuple[float, ...]
    soft_values: tuple[FloatArray, ...]


def relax(
    coords: FloatArray,
    hard: Sequence[Term],
    soft: Sequence[Soft],
    step: float,
    *,
    rounds: int = 200,
    progress: Callable[[int, float], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Relaxation:
    """Coordinates that meet the hard terms to rounding and the soft ones as well as can be.

    Parameters
    ----------
    coords : the start, shape (nv, 3).
    step : a length of the size of a face's sides; steps are measured by it.
    rounds : at most, of Levenberg-Marquardt (`minimisation`), before the `projection`.
    progress : called after each round with its number and the largest hard residual.
    interrupted : asked before each round; once it is true, the sheet is returned as it is.

    Nothing is random: the same arguments give the same bits, with any number of threads. Raises
    `InvalidValue` for arguments out of bounds, and `InvalidState` where a term has no value at the
    start.

    The tip of a tent of four faces sinks until the sectors around it sum to 2 pi:

    >>> from solver.relaxation import DevelopableVertices, SideLengths
    >>> y, x = np.mgrid[-1:2, -1:2].reshape(2, -1)
    >>> tent = np.column_stack([x, y, 0.5 * (x == 0) * (y == 0)]).astype(float)
    >>> faces = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
    >>> soft = [Soft(SideLengths(np.array([[0, 1], [1, 2], [2, 5], [5, 8]]), np.ones(4)))]
    >>> relaxed = relax(tent, [DevelopableVertices.of(faces, 9)], soft, 1.0)
    >>> relaxed.status, relaxed.hard_residual <= 1e-12
    (<RelaxationStatus.RELAXED: 'relaxed'>, True)
    """
    coords = points("coords", coords)
    require_positive("step", step)
    require_count("rounds", rounds, 1, "One round at least is needed to see whether any helps.")
    for term in (*hard, *(wish.term for wish in soft)):
        if term.vertices.size and not -1 <= term.vertices.min() <= term.vertices.max() < len(
            coords
        ):
            raise InvalidValue(
                "vertices of a term",
                f"{term.vertices.min()} to {term.vertices.max()}",
                f"be from -1 to {len(coords) - 1}",
                "Give the coordinates of all vertices that terms name.",
            )
    with np.errstate(all="ignore"):  # what fails is NaN and is no better than what was before
        here, history, end = _searched(coords, hard, soft, step, rounds, progress, interrupted)
    done = len(history) - 1
    if end is RelaxationStatus.STOPPED:
        onto = Projection(here.coords, (here.residual,))
    else:
        onto = projected(here.coords, hard, step)
        if onto.residuals[-1] <= _EXACT:
            end = RelaxationStatus.RELAXED
    values = tuple(linear.term.linearised(onto.coords).values for linear in here.soft)
    residual = onto.residuals[-1]
    return Relaxation(
        onto.coords,
        end,
        _advice(end, done, residual),
        done,
        residual,
        history,
        onto.residuals,
        values,
    )


def _searched(
    coords: FloatArray,
    hard: Sequence[Term],
    soft: Sequence[Soft],
    step: float,
    rounds: int,
    progress: Callable[[int, float], None] | None,
    interrupted: Callable[[], bool] | None,
) -> tuple[Descent, tuple[float, ...], RelaxationStatus]:
    """Where the search ended, the hard residuals of its rounds, and the status that it has so."""
    history: list[float] = []
    search = minimised(coords, hard, soft, step)
    for here in search:
        if not here.moved:
            break
        if not history:
            _require_values(here)
        elif progress is not None:
            progress(len(history), here.residual)
        history.append(here.residual)
        if here.residual <= _NEAR and here.settled:
            return here, tuple(history), RelaxationStatus.NOT_CONVERGED
        if len(history) > rounds:
            return here, tuple(history), RelaxationStatus.NOT_CONVERGED
        if interrupted is not None and interrupted():
            return here, tuple(history), RelaxationStatus.STOPPED
    return here, tuple(history), RelaxationStatus.STUCK


def _require_values(start: Descent) -> None:
    for linear in (*start.hard, *start.soft):
        lost = np.flatnonzero(~np.isfinite(linear.values))
        if len(lost):
            name = type(linear.term).__name__
            raise InvalidState(
                "coords",
                f"{len(lost)} of {len(linear.values)} residuals of {name} have no value at the "
                f"start, the first at vertices {linear.term.vertices[lost[0]].tolist()}",
                "Start with faces that have an area, and with vertices nearer to the surface than "
                "its centres of curvature.",
            )


def _advice(status: RelaxationStatus, rounds: int, residual: float) -> str:
    if status is RelaxationStatus.RELAXED:
        return ""
    if status is RelaxationStatus.STOPPED:
        return f"Stopped after {rounds} rounds at a hard residual of {residual:.2g}: go on from it."
    found = f"After {rounds} rounds the largest hard residual is {residual:.2g}, not {_EXACT:g}."
    return (
        f"{found} A larger cell, a smaller thickness, another direction or a smaller part of the "
        "surface may fit."
    )
