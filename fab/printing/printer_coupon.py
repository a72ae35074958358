"""Test print of a printer and a material: gaps to turn, webs to bend, and knuckles.

All numbers on it are raised, in hundredths of a mm. Plugs stand in the holes of two plates with
gaps in steps around the printer's least gap; those of the second plate, which has a notch, are cut
back at the bed for the spread of the first layer. Webs of several whole layers join pairs of
panels, and a pair of panels turns on knuckles. All hinges are made as those of sheets are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fab.errors import Finding
from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of, concatenated, stacked
from fab.geometry.booleans import difference, joined_mesh, meshes, prism, solid
from fab.geometry.extrusion import circle, extruded
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings, least_thickness_mm
from fab.panels.thick_sheet import ThickSheet, thicken
from fab.pattern.crease_pattern import CreasePattern
from fab.printing.printers import Printer, PrintMaterial
from fab.printing.raised_digits import number_outline
from solver.errors import InvalidValue
from solver.mesh import edges_of
from solver.vectors import FloatArray

__all__ = ["PrinterCoupon", "TriedGap", "TriedWeb", "printer_coupon"]

# Gaps that are tried, as shares of the printer's own, in steps of so many mm.
_SHARES = (1 / 3, 1 / 2, 2 / 3, 5 / 6, 1, 4 / 3, 5 / 3)
_STEP_MM = 0.05
# Webs that are tried, in layers.
_LAYERS = (1, 2, 3, 4)
# Lengths for a nozzle of 0.4 mm and less; they grow with larger ones.
_NOZZLE_MM = 0.4
_PLUG_MM = 7.0
_WALL_MM = 2.0
_STROKE_MM = 0.8
_PLATE_MM = 2.4
_DRIVER_MM = (5.5, 1.2, 1.0)
_PANEL_MM = (10.0, 10.0)
_KNUCKLED_MM = (16.0, 26.0)
_PIN_MM, _BARREL_MM = 1.2, 4.0
_SPACE_MM = 5.0
_FOLD_DEG = 90.0
_ROUND_SIDES = 48
_BEYOND_MM = 1.0


@dataclass(frozen=True)
class TriedGap:
    """The gap around a plug, and whether it is cut back at the bed."""

    gap_mm: float
    cut_back: bool


@dataclass(frozen=True)
class TriedWeb:
    """A web: its thickness, its length across the crease, its stretch when folded by 90 degrees."""

    web_mm: float
    length_mm: float
    strain: float


@dataclass(frozen=True)
class PrinterCoupon:
    """The test print.

    Attributes
    ----------
    bodies : all solids, on z = 0; those that move are apart. mesh : their joined surface.
    gaps, webs : what is tried, from left to right. play_mm : of the knuckles.
    reading : how to read it, a sentence for each part.
    findings : of hinges that could not be made.
    """

    bodies: Bodies
    mesh: TriangleMesh
    gaps: tuple[TriedGap, ...]
    webs: tuple[TriedWeb, ...]
    play_mm: float
    reading: tuple[str, ...]
    findings: tuple[Finding, ...]


def printer_coupon(printer: Printer, material: PrintMaterial | None) -> PrinterCoupon:
    """The test print for a printer, and a material where it is known.

    Raises `InvalidValue` where it does not fit the bed.
    """
    size = max(1.0, printer.nozzle_mm / _NOZZLE_MM)
    gaps = _gaps(printer)
    plates = [_plate(printer, gaps, size, 0.0)]
    if printer.first_layer_mm > 0:
        plates.append(_plate(printer, gaps, size, printer.first_layer_mm))
    webs, tried, findings = _webs(printer, material, size)
    knuckles, found = _knuckles(printer, size)
    placed = _in_rows([*plates, *webs, knuckles], printer.room_mm, _SPACE_MM * size)
    bodies = concatenated(placed)
    return PrinterCoupon(
        bodies,
        joined_mesh(bodies),
        tuple(TriedGap(gap, back > 0) for back in range(len(plates)) for gap in gaps),
        tuple(tried),
        printer.least_gap_mm,
        tuple(_reading(printer, material, len(plates) > 1)),
        (*findings, *found),
    )


def _gaps(printer: Printer) -> list[float]:
    steps = {max(1, round(share * printer.least_gap_mm / _STEP_MM)) for share in _SHARES}
    return [round(step * _STEP_MM, 6) for step in sorted(steps)]


def _whole_layers(height_mm: float, printer: Printer) -> float:
    return float(np.ceil(height_mm / printer.layer_mm - 1e-9)) * printer.layer_mm


def _plate(printer: Printer, gaps: Sequence[float], size: float, spread_mm: float) -> Bodies:
    """A plate with a plug in each of its holes, and the gap around each raised beside it.

    spread_mm : by how much both are cut back at the bed.
    """
    radius, wall, stroke = _PLUG_MM * size / 2, _WALL_MM * size, _STROKE_MM * size
    height = _whole_layers(_PLATE_MM * size, printer)
    labels = [_label(gap, stroke) for gap in gaps]
    around = radius + max(gaps) + spread_mm
    pitch = max(2 * around, *(label.bounds[2] for label in labels)) + wall
    text_y = 2 * (around + wall)
    figure = shapely.box(0, 0, pitch * len(gaps) + wall, text_y + 7 * stroke + wall)
    if spread_mm > 0:  # the notch by which it is known
        figure -= shapely.box(0, text_y, wall / 2, text_y + 2 * wall)
    holes, plugs, bumps = [], [], []
    for number, (gap, label) in enumerate(zip(gaps, labels, strict=True)):
        middle = np.array([wall / 2 + pitch * (number + 0.5), wall + around])
        plugs.append(_plug(middle, radius, height, size, spread_mm))
        top = height + _BEYOND_MM
        holes.append(solid(_round(middle, radius + gap, -_BEYOND_MM, top, -spread_mm)))
        shift = np.array([middle[0] - label.bounds[2] / 2, text_y])
        bumps += _raised(label, shift, height, printer)
    plate = meshes([difference([solid(extruded(figure, 0.0, height)), *holes])])
    return bodies_of([joined_mesh(bodies_of([*plate, *bumps])), *plugs])


def _label(length_mm: float, stroke_mm: float) -> shapely.Geometry:
    return number_outline(round(100 * length_mm), stroke_mm)


def _round(
    middle: FloatArray, radius: float, low_mm: float, high_mm: float, back_mm: float
) -> TriangleMesh:
    """A round body whose foot is smaller by back_mm, up to that over the bed and to twice that."""
    foot, up = radius - back_mm, abs(back_mm)
    edges = [(low_mm, foot), (up, foot), (2 * up, radius)] if up else [(low_mm, radius)]
    profile = [*edges, (high_mm, radius)]
    # corners of holes are around their circle, those of plugs on it
    rings = [
        shapely.get_coordinates(circle(middle, far, _ROUND_SIDES, around=low_mm < 0))[:-1]
        for _, far in profile
    ]
    heights = np.array([z for z, _ in profile])
    return stacked(np.stack(rings, axis=1), np.array([0, _ROUND_SIDES]), heights).mesh(0)


def _plug(
    middle: FloatArray, radius: float, height: float, size: float, spread_mm: float
) -> TriangleMesh:
    """A plug with a slot for a screwdriver."""
    length, width, depth = (side * size for side in _DRIVER_MM)
    whole = _round(middle, radius, 0.0, height, spread_mm)
    x, y = middle.tolist()
    slot = shapely.box(x - length / 2, y - width / 2, x + length / 2, y + width / 2, ccw=True)
    ring = shapely.get_coordinates(slot)[:-1]
    cut = difference([solid(whole), prism(ring, height - depth, height + _BEYOND_MM)])
    return meshes([cut])[0]


def _raised(
    label: shapely.Geometry, shift: FloatArray, floor_mm: float, printer: Printer
) -> list[TriangleMesh]:
    """A label on a plate, two layers high, and a little into the plate so that both join."""
    outline = shapely.transform(label, lambda points: points + shift)
    low, high = floor_mm - printer.layer_mm, floor_mm + 2 * printer.layer_mm
    return [extruded(part, low, high) for part in shapely.get_parts(outline)]


def _webs(
    printer: Printer, material: PrintMaterial | None, size: float
) -> tuple[list[Bodies], list[TriedWeb], list[Finding]]:
    """Pairs of panels with webs of several thicknesses, raised on each, and what they are."""
    made, tried, findings = [], [], []
    thickness = 2 * max(_LAYERS) * printer.layer_mm
    width, depth = (side * size for side in _PANEL_MM)
    for layers in _LAYERS:
        web = round(layers * printer.layer_mm, 6)
        hinge = HingeSettings(web_mm=web, strain_max=_strain_max(material))
        panel = PanelSettings(thickness_mm=thickness, gap_mm=2 * printer.least_gap_mm)
        sheet, found = thicken(_pair(width, depth), panel, hinge)
        findings += found
        label = _label(web, _STROKE_MM * size)
        shift = np.array([width / 2, depth / 2]) - np.array(label.bounds[2:]) / 2
        made.append(_with_label(sheet, _raised(label, shift, thickness, printer)))
        (crease,) = np.flatnonzero(sheet.pattern.edges_joining).tolist()
        length = 2 * float(sheet.panels.setbacks.axis_mm[crease])
        tried.append(TriedWeb(web, length, float(web * np.radians(_FOLD_DEG) / (2 * length))))
    return made, tried, findings


def _strain_max(material: PrintMaterial | None) -> float:
    if material is None or material.strain_max is None:
        return HingeSettings().strain_max
    return material.strain_max


def _with_label(sheet: ThickSheet, bumps: Sequence[TriangleMesh]) -> Bodies:
    """A sheet in one body, with letters on it."""
    return bodies_of([joined_mesh(concatenated([sheet.joining, bodies_of(bumps)]))])


def _knuckles(printer: Printer, size: float) -> tuple[Bodies, list[Finding]]:
    """A pair of panels on knuckles with the least gap as their play."""
    hinge = HingeSettings(
        kind="knuckle",
        play_mm=printer.least_gap_mm,
        pin_mm=_PIN_MM * size,
        wall_mm=_NOZZLE_MM * 1.5 * size,
        knuckle_mm=_BARREL_MM * size,
    )
    least = least_thickness_mm(PanelSettings(axis="middle"), hinge)
    thickness = _whole_layers(least, printer)
    panel = PanelSettings(
        thickness_mm=thickness,
        axis="middle",
        first_layer_mm=min(printer.first_layer_mm, thickness / 4),
    )
    width, depth = (side * size for side in _KNUCKLED_MM)
    sheet, findings = thicken(_pair(width, depth), panel, hinge)
    return sheet.bodies, [each for each in findings if each.code != "first-layer-relief"]


def _pair(width_mm: float, depth_mm: float) -> CreasePattern:
    """Two panels side by side, with a valley between them."""
    x = np.repeat([0.0, width_mm, 2 * width_mm], 2)
    coords = np.column_stack([x, np.tile([0.0, depth_mm], 3)])
    corners, offsets = np.array([0, 2, 3, 1, 2, 4, 5, 3]), np.array([0, 4, 8])
    edges = edges_of(corners, offsets)
    inner = edges.edges_faces[:, 1] >= 0
    return CreasePattern(
        coords,
        edges.edges_vertices,
        edges.edges_faces,
        np.where(inner, "V", "B"),
        np.where(inner, _FOLD_DEG, 0.0),
        corners,
        offsets,
    )


def _in_rows(items: Sequence[Bodies], room_mm: tuple[float, float], gap_mm: float) -> list[Bodies]:
    """Items side by side on z = 0, from left to right and row above row, within a room."""
    out, x, y, high = [], 0.0, 0.0, 0.0
    wide = 0.0
    for item in items:
        low, top = item.vertices_coords.min(axis=0), item.vertices_coords.max(axis=0)
        width, depth, _ = (top - low).tolist()
        if x > 0 and x + width > room_mm[0]:
            x, y, high = 0.0, y + high + gap_mm, 0.0
        shift = np.array([x, y, 0.0]) - low
        turns = np.broadcast_to(np.eye(3), (len(item), 3, 3))
        out.append(item.moved(turns, np.broadcast_to(shift, (len(item), 3))))
        wide, x, high = max(wide, x + width), x + width + gap_mm, max(high, depth)
    if wide > room_mm[0] or y + high > room_mm[1]:
        raise InvalidValue(
            "bed",
            f"{room_mm[0]:g} x {room_mm[1]:g} mm",
            f"be at least {wide:.4g} x {y + high:.4g} mm within its margins",
            "Take a printer with a larger bed, or a smaller nozzle.",
        )
    return out


def _reading(printer: Printer, material: PrintMaterial | None, two_plates: bool) -> Iterator[str]:
    yield (
        "Numbers are hundredths of a mm. Turn each plug with a screwdriver, from the widest gap "
        "down: the least gap that lets go is least_gap_mm of the printer, now "
        f"{printer.least_gap_mm:g}."
    )
    if two_plates:
        yield (
            "The plate with the notch is cut back at the bed by first_layer_mm = "
            f"{printer.first_layer_mm:g}. Take least_gap_mm from it. If the other plate lets go "
            "only at wider gaps, its first layer spreads by half of the least gap that does: that "
            "is first_layer_mm. Print with the slicer's compensation of elephant's foot off."
        )
    yield (
        f"Bend each web by {_FOLD_DEG:g} degrees and back, as often as your sheet will be folded. "
        "web_mm of [hinges] is the thickest one that bends as easily as you like and does not "
        "whiten or tear."
    )
    yield (
        f"Webs are as long as strain_max = {_strain_max(material):g} wants. If all of them tear, "
        "lower strain_max of the material; if none does, raise it."
    )
    yield (
        "Free the knuckles by moving them to and fro. If they stay fused, raise least_gap_mm; if "
        "they rattle, lower it."
    )
