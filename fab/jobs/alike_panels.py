"""Panels of a pattern that are alike, turned or turned over as they may be: how many differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.panel_shapes import PanelShapes, different_shapes, shape_lengths
from solver.vectors import IntArray

__all__ = ["AlikePanels", "alike_panels", "needed_mm"]


@dataclass(frozen=True)
class AlikePanels:
    """Which template each panel is cut by.

    Attributes
    ----------
    faces_template : numbers of templates, by the first panels that are cut by them, shape (nf,).
    within_mm : no side or diagonal differs by more from that of the template.
    """

    faces_template: IntArray
    within_mm: float

    @property
    def different(self) -> int:
        """How many templates there are."""
        return int(self.faces_template.max(initial=-1)) + 1

    def report(self) -> dict[str, Any]:
        """How many differ, and how many panels are cut by the template of most of them."""
        most = np.bincount(self.faces_template).max(initial=0)
        return {
            "different": self.different,
            "within_mm": self.within_mm,
            "largest_group": int(most),
        }


def alike_panels(pattern: CreasePattern, within_mm: float, most: int | None = None) -> AlikePanels:
    """Templates by which all panels are cut, few as they are found.

    most : so many are tried besides, of a pattern whose faces have as many corners each.
    """
    groups = np.empty(pattern.face_count, np.int64)
    for faces, corners in pattern.faces_by_size():
        lengths = shape_lengths(pattern.vertices_coords[corners])
        groups[faces] = faces[different_shapes(lengths, within_mm)]
        if most is not None and len(faces) == pattern.face_count:
            shapes = PanelShapes.of(lengths, most)
            if shapes.unlike(lengths).max() <= within_mm:
                groups = shapes.nearest(lengths)
    _, first, number = np.unique(groups, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return AlikePanels(rank[number.ravel()], within_mm)


def needed_mm(pattern: CreasePattern, most: int) -> float | None:
    """Within what so many templates are enough; None where faces differ in numbers of corners."""
    sizes = list(pattern.faces_by_size())
    if len(sizes) > 1:
        return None
    lengths = shape_lengths(pattern.vertices_coords[sizes[0][1]])
    return float(PanelShapes.of(lengths, most).unlike(lengths).max())
