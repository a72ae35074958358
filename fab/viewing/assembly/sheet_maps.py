"""Sheets in small, as they are cut: each piece in its colour, with its letters."""

from __future__ import annotations

import numpy as np
import shapely

from fab.errors import counted
from fab.viewing.assembly.parts import Assembly, CutSheet
from fab.viewing.assembly.piece_colours import hex_colour, piece_colours
from fab.viewing.leaflet import WIDTH_MM, Block, Row
from fab.viewing.sketch import Area, Mark, Sketch, Words, plan_of, scale_text
from solver.vectors import FloatArray

__all__ = ["SheetMaps", "map_rows"]

_LETTERS = (1.6, 6.0)
_SIMPLE_MM = 0.05


class SheetMaps:
    """Maps of the sheets of an assembly; what its pieces look like is found once."""

    def __init__(self, assembly: Assembly) -> None:
        self._pieces = [piece for model in assembly.models for piece in model.pieces]
        self._face_down = assembly.face_down
        self._colours = piece_colours(len(self._pieces))
        self._places = [_place(piece.outline) for piece in self._pieces]

    def map(self, sheet: CutSheet, most_mm: tuple[float, float]) -> Sketch:
        """One sheet, at a usual scale."""
        plan = plan_of(np.zeros(2), np.array(sheet.size_mm), most_mm, 0.3)
        bed = plan.on_paper(shapely.get_coordinates(shapely.box(0, 0, *sheet.size_mm))[:-1])
        marks: list[Mark] = [Area((bed,), "#ffffff", "#000000", 0.25)]
        letters: list[Mark] = []
        for number, turn, shift in sheet.pieces:
            piece, colour = self._pieces[number], self._colours[number]
            rings = [shapely.LinearRing(ring) for ring in piece.outline]
            simple = shapely.simplify(rings, _SIMPLE_MM / plan.scale)
            placed = tuple(
                plan.on_paper(shapely.get_coordinates(ring)[:-1] @ turn.T + shift)
                for ring in simple
            )
            marks.append(Area(placed, hex_colour(colour), "#000000", 0.15))
            middle, radius = self._places[number]
            size = 1.1 * radius * plan.scale / max(1.0, 0.7 * len(piece.name))
            if len(self._pieces) > 1 and size > _LETTERS[0] / 2:
                x, y = plan.on_paper(turn @ middle + shift).tolist()
                size = float(np.clip(size, *_LETTERS))
                letters.append(Words(piece.name, (x, y), size, bold=True))
        caption = _caption(sheet, plan.scale)
        if self._face_down:
            caption += " Face down."
        return Sketch(plan.size_mm, (*marks, *letters), caption)


def map_rows(assembly: Assembly, maps: SheetMaps) -> list[Block]:
    """Maps of all sheets, side by side, smaller where there are many."""
    count = len(assembly.sheets)
    across = 2 if count <= 4 else 3 if count <= 12 else 4
    most = (WIDTH_MM / across - 3.0, 70.0 if across == 2 else 50.0)
    drawn = [maps.map(sheet, most) for sheet in assembly.sheets]
    return [Row(tuple(drawn[k : k + across])) for k in range(0, count, across)]


def _caption(sheet: CutSheet, scale: float) -> str:
    """Such as "Sheets 2 to 5: 600 x 400 mm, 3 pieces, about 4.2 min each. Scale 1 : 8."."""
    noun = sheet.noun.capitalize()
    first, last = sheet.numbers[0], sheet.numbers[-1]
    each = ""
    if first == last:
        name = f"{noun} {first}"
    elif len(sheet.numbers) == last - first + 1:
        name, each = f"{noun}s {first} to {last}", " each"
    else:
        name, each = f"{noun}s {', '.join(map(str, sheet.numbers))}", " each"
    width, depth = sheet.size_mm
    pieces = counted(len(sheet.pieces), "piece" if sheet.noun == "sheet" else "part")
    time = "" if sheet.minutes is None else f", about {sheet.minutes:.1f} min{each}"
    return f"{name}: {width:g} x {depth:g} mm, {pieces}{time}. Scale {scale_text(scale)}."


def _place(rings: tuple[FloatArray, ...]) -> tuple[FloatArray, float]:
    """Where the letters of a piece go, and the radius of their room."""
    outer = max(rings, key=lambda ring: float(shapely.Polygon(ring).area))
    shape = shapely.Polygon(outer, [ring for ring in rings if ring is not outer])
    if not shape.is_valid:
        return shapely.get_coordinates(shape.centroid)[0], 0.0
    disk = shapely.maximum_inscribed_circle(shape, tolerance=0.05 * float(np.sqrt(shape.area)))
    return shapely.get_coordinates(disk)[0], float(shapely.length(disk))
