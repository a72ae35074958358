"""Closed slots: open cuts drawn as the outlines of thin slots, for services that take no others.

A slot is as long as the cut was, and `slot_mm` wide when cut: its outline is drawn narrower by the
kerf. Slots that meet are one, and those that reach an outline become part of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.drawings.beam import Beam
from fab.drawings.cut_paths import CutPaths, Layer, Operation, joined
from solver.errors import InvalidValue
from solver.vectors import FloatArray

__all__ = ["SLOT_REACH", "closed_slots", "dash_slots", "require_wider", "slot_beside"]

_DASHED = (Operation.MOUNTAIN, Operation.VALLEY)
# Figures of less area are where shapes only touch, mm2.
_LEAST_MM2 = 1e-6
# How sharp a mitre of a bent slot may be, in half widths.
_MITRE = 5.0
# How sharp that of a slot beside an outline may be, and how far these reach at corners, in widths.
_MITRE_BESIDE = 1.5
SLOT_REACH = float(np.hypot(_MITRE_BESIDE, 1.0))

Shapes = NDArray[np.object_]


def closed_slots(layers: Sequence[Layer], slot_mm: float, beam: Beam) -> tuple[Layer, ...]:
    """The layers of a piece with its cuts closed; creases and engraved lines stay as they are.

    Cuts within the piece are holes of their own. Material is on the left of outlines and of slots.

    slot_mm : width of the slots as they are cut. Raises `InvalidValue` for slots that are not wider
    than the kerf.
    """
    require_wider(slot_mm, beam)
    of = {layer.operation: layer for layer in joined(layers)}
    out = []
    for operation, layer in of.items():
        if operation is Operation.RELIEF:
            slots = _slots(layer, slot_mm, beam)
            rings = [ring for slot in slots for ring in _rings(slot, hole=True)]
            out.append(Layer(operation, outlines=(*layer.outlines, *rings)))
        elif operation not in (Operation.HOLE, Operation.CUT):
            out.append(layer)
    hole, cut = (of.get(kind, Layer(kind)) for kind in (Operation.HOLE, Operation.CUT))
    slots = [*_slots(hole, slot_mm, beam), *_slots(cut, slot_mm, beam)]
    outer, inner = _merged(cut.outlines, hole.outlines, slots)
    if inner:
        out.append(Layer(Operation.HOLE, outlines=tuple(inner)))
    if Operation.CUT in of:
        out.append(Layer(Operation.CUT, outlines=tuple(outer)))
    return tuple(out)


def dash_slots(paths: CutPaths, slot_mm: float, beam: Beam) -> CutPaths:
    """The paths with all dashes of creases as closed slots, in their order.

    Raises `InvalidValue` as `closed_slots`.

    >>> dash = Layer(Operation.VALLEY, np.array([[[1.0, 5.0], [4.0, 5.0]]]))
    >>> (slots,) = dash_slots(CutPaths((dash,), (9.0, 9.0)), 0.5, Beam.of(0.1)).layers
    >>> np.ptp(slots.outlines[0], axis=0).round(6).tolist(), len(slots.segments)
    ([3.0, 0.4], 0)
    """
    require_wider(slot_mm, beam)
    layers = (
        _dashes(layer, slot_mm, beam) if layer.operation in _DASHED else layer
        for layer in paths.layers
    )
    return replace(paths, layers=tuple(layers))


def slot_beside(chain: FloatArray, outline: FloatArray, slot_mm: float, beam: Beam) -> FloatArray:
    """The outline of a slot beside a part of an outline that has its material on the left, (k, 2).

    The side at the material is the polyline itself; the slot is on its right, and takes nothing of
    the material where what is cut away is narrower than the slot. It reaches out by up to
    `SLOT_REACH` times its width. Raises `InvalidValue` as `closed_slots`.

    chain : the part, shape (m, 2). outline : all of it, shape (n, 2).
    """
    require_wider(slot_mm, beam)
    width = slot_mm - float(beam.across(np.diff(chain, axis=0)).max())
    around = shapely.LineString(chain).buffer(
        width, cap_style="flat", join_style="mitre", mitre_limit=_MITRE_BESIDE
    )
    ring = shapely.Polygon(outline)
    figure = around.difference(ring) if ring.exterior.is_ccw else around.intersection(ring)
    largest = max(shapely.get_parts(figure), key=lambda part: float(part.area))
    return _ccw(largest.exterior)[::-1]


def require_wider(slot_mm: float, beam: Beam) -> None:
    """Raise `InvalidValue` unless slots are wider than the kerf."""
    if slot_mm <= beam.widest_mm:
        raise InvalidValue(
            "cutter.slot_mm",
            slot_mm,
            f"be greater than the kerf ({beam.text})",
            "Ask for wider slots, or take a finer beam.",
        )


def _dashes(layer: Layer, slot_mm: float, beam: Beam) -> Layer:
    """Each dash as a rectangle around it."""
    rings = _rectangles(layer.segments, slot_mm, beam)[:, ::-1]
    return replace(layer, segments=layer.segments[:0], outlines=(*layer.outlines, *rings))


def _rectangles(segments: FloatArray, slot_mm: float, beam: Beam) -> FloatArray:
    """Counterclockwise rectangles around segments, shape (n, 4, 2)."""
    span = segments[:, 1] - segments[:, 0]
    half = (slot_mm - beam.across(span)) / 2
    size = np.hypot(*span.T)
    left = (
        np.column_stack([-span[:, 1], span[:, 0]]) * (half / np.where(size > 0, size, 1))[:, None]
    )
    start, end = segments[:, 0], segments[:, 1]
    return np.stack([start - left, end - left, end + left, start + left], axis=1)


def _slots(layer: Layer, slot_mm: float, beam: Beam) -> list[shapely.Polygon]:
    """The slots of a layer's open cuts, those that meet in one."""
    figures = [shapely.Polygon(ring) for ring in _rectangles(layer.segments, slot_mm, beam)]
    for chain in layer.chains:
        half = (slot_mm - float(beam.across(np.diff(chain, axis=0)).max())) / 2
        line = shapely.LineString(chain)
        figures.append(line.buffer(half, cap_style="flat", join_style="mitre", mitre_limit=_MITRE))
    union = shapely.union_all(figures)
    return [part for part in shapely.get_parts(union) if part.area > _LEAST_MM2]


def _merged(
    outer: Sequence[FloatArray], inner: Sequence[FloatArray], slots: list[shapely.Polygon]
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Outlines and holes of a piece with its slots; those that meet no slot stay as they are."""
    rings = [*outer, *inner]
    lines: Shapes = np.array([shapely.LinearRing(ring) for ring in rings], dtype=object)
    parts: Shapes = np.array(slots, dtype=object)
    met, reaching = np.zeros(len(rings), bool), np.zeros(len(parts), bool)
    if len(rings) and len(parts):
        part, ring = shapely.STRtree(lines).query(parts, predicate="intersects")
        met[ring], reaching[part] = True, True
    around = [ring for ring, hit in zip(outer, met[: len(outer)], strict=True) if not hit]
    within = [ring for ring, hit in zip(inner, met[len(outer) :], strict=True) if not hit]
    for slot in parts[~reaching]:
        within += _rings(slot, hole=True)
    if met.any():
        # all outlines that anything is cut into, with the holes that slots reach
        figures: Shapes = np.array([shapely.Polygon(ring) for ring in rings], dtype=object)
        cut_away = shapely.union_all([*figures[len(outer) :][met[len(outer) :]], *parts[reaching]])
        changed = met[: len(outer)] | shapely.intersects(figures[: len(outer)], cut_away)
        around = [ring for ring, hit in zip(outer, changed, strict=True) if not hit]
        left = shapely.union_all(figures[: len(outer)][changed]).difference(cut_away)
        for figure in shapely.get_parts(left):
            if figure.area > _LEAST_MM2:
                first, *others = _rings(figure, hole=False)
                around.append(first)
                within += others
    return around, within


def _rings(figure: shapely.Polygon, *, hole: bool) -> list[FloatArray]:
    """The rings of a figure, its outer one first, material on the left of all.

    hole : whether the figure is cut away, else it is material.
    """
    out = [_ccw(figure.exterior)[:: -1 if hole else 1]]
    return out + [_ccw(ring)[:: 1 if hole else -1] for ring in figure.interiors]


def _ccw(ring: shapely.LinearRing) -> FloatArray:
    """The corners of a ring, counterclockwise, shape (m, 2)."""
    corners: FloatArray = shapely.get_coordinates(ring)[:-1]
    return corners if ring.is_ccw else corners[::-1]
