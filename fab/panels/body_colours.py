"""Colours of the bodies of a thick sheet in CAD programs and slicers."""

from __future__ import annotations

from typing import TypeAlias

from fab.panels.thick_sheet import ThickSheet

__all__ = ["FILM", "HINGE", "PANEL", "Rgb", "body_assignments", "body_colours"]

Rgb: TypeAlias = tuple[float, float, float]

PANEL: Rgb = (0.85, 0.82, 0.75)
FILM: Rgb = (0.5, 0.5, 0.5)
HINGE: dict[str, Rgb] = {"M": (0.85, 0.2, 0.2), "V": (0.2, 0.35, 0.85)}


def body_colours(sheet: ThickSheet) -> list[Rgb]:
    """Red, green and blue, 0 to 1, of every body: of hinges by mountain and valley."""
    return [
        HINGE.get(letter, FILM) if soft else PANEL
        for soft, letter in zip(sheet.flexible.tolist(), body_assignments(sheet), strict=True)
    ]


def body_assignments(sheet: ThickSheet) -> list[str]:
    """The assignment of the crease that each body belongs to; "" for bodies of no crease."""
    letters: list[str] = sheet.pattern.edges_assignment.tolist()
    return [letters[edge] if edge >= 0 else "" for edge in sheet.creases.tolist()]
