"""Whether a sheet that is folded flat has an order of layers, how many orders, and one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import prod
from typing import Any

import numpy as np

from fab.errors import counted, first_few
from fab.layers.cells import Cells, cells_of
from fab.layers.conditions import Conditions, conditions_of, overlapping
from fab.layers.flat_form import FlatForm, flat_form
from fab.layers.heights import corner_heights
from fab.layers.satisfaction import Clock
from fab.layers.solution import solved
from fab.layers.unordered_faces import unordered_regions
from fab.pattern.crease_pattern import CreasePattern
from solver.errors import InvalidState
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["FoldsFlat", "LayerOrders", "layer_orders", "named"]

# Faces over cells, as bits of numbers: more do not fit into memory.
_MOST_BITS = 4e8
# So many times the reach of points.
_REACHES = (1.0, 3.0, 10.0, 30.0, 100.0)
# A text names up to this many faces, and numbers beyond this by three digits.
_SHOWN, _MANY = 12, 1_000_000
_NO_ROWS = np.empty((0, 3), np.int64)


class FoldsFlat(StrEnum):
    """Whether layers have an order in which no sheet passes through itself."""

    YES = "yes"
    NO = "no"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class LayerOrders:
    """The layers of a sheet that is folded flat.

    Attributes
    ----------
    folds_flat : whether they have an order.
    orders : rows [f, g, s] of FOLD's faceOrders of one order, shape (n, 3), for all pairs of faces
        that overlap: s is 1 where f is on the side of g to which the upper side of g looks, -1
        where it is on the other. None are known where there is no order.
    heights : of each corner of each face, as `faces_vertices` has them, in layers: faces in this
        order are apart. Upwards is where faces look that are not turned. None without an order.
    faces_turned : faces that look down, shape (nf,).
    states : number of orders, or a lower bound; 0 where there is none, None where not decided.
    states_exact : whether it is the number.
    parts : number of orders of each part that is independent of the others, where it has several.
    faces : faces that have no order, whatever the rest of the sheet does, none of which can be left
        out.
    reason : why it was not decided.
    assumed : number of creases of unknown angle, taken to be folded by 180 degrees.
    overlaps, conditions : number of pairs of faces that overlap, and of conditions on their order.
    given : whether `orders` has the orders that were given; None where none were.
    given_faces : faces of which the given orders contradict each other or the letters.
    """

    folds_flat: FoldsFlat
    orders: IntArray = field(default_factory=lambda: _NO_ROWS)
    heights: FloatArray | None = None
    faces_turned: BoolArray = field(default_factory=lambda: np.empty(0, np.bool_))
    states: int | None = None
    states_exact: bool = False
    parts: tuple[int, ...] = ()
    faces: tuple[int, ...] = ()
    reason: str = ""
    assumed: int = 0
    overlaps: int = 0
    conditions: int = 0
    given: bool | None = None
    given_faces: tuple[int, ...] = ()

    def text(self) -> str:
        """Such as "folds flat: yes, its layers have 4 orders".

        >>> LayerOrders(FoldsFlat.NO, states=0, faces=(2, 5, 7)).text()
        'folds flat: no, because of faces 2, 5 and 7'
        """
        if self.folds_flat is FoldsFlat.UNDECIDED:
            return f"folds flat: undecided, {self.reason}"
        if self.folds_flat is FoldsFlat.NO:
            return "folds flat: no" + (f", because of {named(self.faces)}" if self.faces else "")
        assert self.states is not None
        number = f"{self.states:.3g}" if self.states > _MANY else str(self.states)
        least = "" if self.states_exact else "at least "
        orders = "order" if number == "1" else "orders"
        either = ""
        if self.assumed:
            either = f", with {counted(self.assumed, 'unassigned crease')} folded to either side"
        return f"folds flat: yes, its layers have {least}{number} {orders}{either}"

    def report(self) -> dict[str, Any]:
        """As JSON values: the first 20 faces and parts, and KEY_count for all."""
        return {
            "text": self.text(),
            "folds_flat": self.folds_flat.value,
            "states": self.states,
            "states_exact": self.states_exact,
            "parts": list(first_few(self.parts)),
            "parts_count": len(self.parts),
            "faces": list(first_few(self.faces)),
            "faces_count": len(self.faces),
            "reason": self.reason,
            "assumed": self.assumed,
            "overlaps": self.overlaps,
            "conditions": self.conditions,
            "face_orders_of_file": self.given,
        }


def named(faces: Sequence[int]) -> str:
    """Such as "faces 2, 5 and 7"; of many, the first few and how many there are."""
    if len(faces) > _SHOWN:
        first = ", ".join(map(str, faces[:_SHOWN]))
        return f"{counted(len(faces), 'face')} ({first}, …)"
    *others, last = map(str, faces)
    return f"faces {', '.join(others)} and {last}" if others else f"face {last}"


def layer_orders(
    pattern: CreasePattern, given: IntArray | None = None, seconds: float = 60.0
) -> LayerOrders | None:
    """The layers of a pattern whose creases all fold by 180 degrees, or not at all.

    None for patterns with other angles, and those whose angles do not close. Of several orders one
    is chosen, the same every time.

    Parameters
    ----------
    given : rows of FOLD's faceOrders, shape (n, 3), which the chosen order has where it can.
    seconds : what takes longer is left undecided.

    Three stamps in a row, folded onto each other by creases that may be of either kind, have six
    orders (Koehler 1968, Folding a strip of stamps); with two valleys they have one.

    >>> from solver.mesh import edges_of
    >>> x, y = np.meshgrid(np.arange(4.0), [0.0, 10.0])
    >>> faces = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6]])
    >>> edges = edges_of(faces.ravel(), np.array([0, 4, 8, 12]))
    >>> inner = edges.edges_faces[:, 1] >= 0
    >>> strip = CreasePattern(
    ...     np.column_stack([x.ravel(), y.ravel()]), edges.edges_vertices, edges.edges_faces,
    ...     np.where(inner, "U", "B"), np.zeros(len(inner)), faces.ravel(), np.array([0, 4, 8, 12])
    ... )
    >>> layer_orders(strip).states
    6
    >>> folded = replace(strip, edges_assignment=np.where(inner, "V", "B"),
    ...     edges_foldAngle=np.where(inner, 180.0, 0.0))
    >>> layer_orders(folded).orders.tolist()
    [[0, 1, 1], [0, 2, 1], [1, 2, 1]]
    """
    form = flat_form(pattern)
    if form is None:
        return None
    clock = Clock(seconds)
    if form.sheet.face_count**2 > _MOST_BITS:
        reason = f"{form.sheet.face_count} faces are too many"
        return LayerOrders(FoldsFlat.UNDECIDED, reason=reason)
    try:
        cells = _exact_cells(form)
    except InvalidState as error:
        return LayerOrders(FoldsFlat.UNDECIDED, reason=str(error))
    if cells is None:
        reason = (
            "its vertices are not exact enough to say which edges are on each other when it is "
            f"folded: faces miss each other by up to {form.gap_mm:.2g} mm"
        )
        return LayerOrders(FoldsFlat.UNDECIDED, reason=reason)
    try:
        return _answered(form, cells, given, clock, seconds)
    except ImportError:
        reason = "python-sat, which finds the order, is not installed: pip install python-sat"
        return LayerOrders(FoldsFlat.UNDECIDED, reason=reason)


def _answered(
    form: FlatForm, cells: Cells, given: IntArray | None, clock: Clock, seconds: float
) -> LayerOrders:
    """The layers of a folded form. Raises `ImportError` without python-sat."""
    conditions = conditions_of(form, cells)
    found = solved(conditions, clock)
    pairs = overlapping(form, cells)
    size = len(conditions.equal) + len(conditions.clauses) + conditions.triple_count
    answer = LayerOrders(
        FoldsFlat.UNDECIDED,
        faces_turned=form.faces_turned,
        assumed=form.assumed,
        overlaps=len(pairs),
        conditions=size,
    )
    if found.exists is None:
        reason = f"{size} conditions on layers were not solved within {seconds:g} s"
        return replace(answer, reason=reason)
    if not found.exists:
        faces = _unordered(form, conditions, clock)
        return replace(answer, folds_flat=FoldsFlat.NO, states=0, states_exact=True, faces=faces)
    assert found.values is not None
    answer = replace(
        answer,
        folds_flat=FoldsFlat.YES,
        orders=_face_orders(form, conditions, found.values, pairs),
        heights=corner_heights(form, cells, conditions, found.values),
        states=prod(each.number for each in found.counts),
        states_exact=all(each.exact for each in found.counts),
        parts=tuple(each.number for each in found.counts),
    )
    if given is None or not len(given):
        return answer
    true = _literals(form, conditions, given)
    if not len(true):
        return answer
    again = solved(conditions, clock, true, count=False)
    if again.values is not None:
        orders = _face_orders(form, conditions, again.values, pairs)
        heights = corner_heights(form, cells, conditions, again.values)
        return replace(answer, orders=orders, heights=heights, given=True)
    return replace(answer, given=False, given_faces=_unordered(form, conditions, clock, true))


def _exact_cells(form: FlatForm) -> Cells | None:
    """Cells without slivers, points joined over a larger distance where that is needed.

    None where faces would be lost, as those are that are narrower.
    """
    every = (1 << form.sheet.face_count) - 1
    for factor in _REACHES:
        cells = cells_of(replace(form, reach_mm=factor * form.reach_mm))
        if not cells.narrow and cells.all_faces == every:
            return cells
    return None


def _literals(form: FlatForm, conditions: Conditions, given: IntArray) -> IntArray:
    """What rows of faceOrders say of pairs of regions that overlap."""
    first, second, side = given[np.isin(given[:, 2], [1, -1])].T
    region = form.faces_region
    above = conditions.above(region[first], region[second])
    literals: IntArray = above * side * np.where(form.faces_turned[second], -1, 1)
    out: IntArray = literals[literals != 0]
    return out


def _unordered(
    form: FlatForm, conditions: Conditions, clock: Clock, true: IntArray | None = None
) -> tuple[int, ...]:
    regions = unordered_regions(conditions, form.region_count, clock, true)
    if regions is None:
        return ()
    return tuple(np.flatnonzero(np.isin(form.faces_region, regions)).tolist())


def _face_orders(
    form: FlatForm, conditions: Conditions, values: IntArray, pairs: IntArray
) -> IntArray:
    """Rows of faceOrders of pairs of faces that overlap, shape (n, 2)."""
    first, second = pairs.T
    literal = conditions.above(*form.faces_region[pairs].T)
    above = np.sign(literal) * values[np.abs(literal) - 1]
    turned = np.where(form.faces_turned[second], -1, 1)
    return np.column_stack([first, second, above * turned])
