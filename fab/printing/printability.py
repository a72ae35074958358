"""Printability of a thick sheet, flat on the bed of a printer, and whether its webs last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.clearance.soundness import SolidFigures
from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.bodies import TriangleMesh
from fab.panels.bevelled_panels import Panels
from fab.panels.panel_widths import panel_widths_mm
from fab.panels.thick_sheet import ThickSheet
from fab.printing.bed_place import fitting_box
from fab.printing.printers import Printer, PrintMaterial
from solver.vectors import FloatArray, IntArray, cross, norm, unit

__all__ = [
    "PrintFigures",
    "bed_area_mm2",
    "inspect_print",
    "inspect_webs",
    "print_figures",
]

_ON_BED_MM = 1e-6
# Sides that are level but for rounding are bridges, not overhangs.
_LEVEL_DEG = 89.9
# Heights that are off a whole number of layers by a larger share have a finding.
_OFF_LAYER = 0.05


@dataclass(frozen=True)
class PrintFigures:
    """What a print of a thick sheet needs.

    Attributes
    ----------
    mass_g : of all printed solids in their materials; None where one of these is unknown.
    hinge_mass_g : of what bends alone.
    bed_area_mm2 : of the sides that lie on the printer's bed.
    """

    mass_g: float | None
    hinge_mass_g: float | None
    bed_area_mm2: float


def print_figures(
    solids: SolidFigures,
    joined: TriangleMesh,
    panels: PrintMaterial | None,
    hinges: PrintMaterial | None,
) -> PrintFigures:
    """The figures of a print. joined : the common surface of all bodies."""

    def mass_g(volume_mm3: float, material: PrintMaterial | None) -> float | None:
        if volume_mm3 == 0:
            return 0.0
        return None if material is None else volume_mm3 * material.density_kg_m3 * 1e-6

    rigid = mass_g(solids.volume_mm3 - solids.flexible_mm3, panels)
    soft = mass_g(solids.flexible_mm3 - solids.laid_mm3, hinges)
    whole = None if rigid is None or soft is None else rigid + soft
    return PrintFigures(whole, soft, bed_area_mm2(joined))


def inspect_print(
    sheet: ThickSheet, joined: TriangleMesh, printer: Printer, material_count: int = 1
) -> list[Finding]:
    """Findings about size, walls, gaps, webs, overhangs and materials; each with its cure.

    material_count : of how many different materials panels and hinges are to be.
    """
    return [
        *_size(joined, printer, divided=not sheet.hinge.embedded),
        *_walls(sheet.panels, printer),
        *_gaps(sheet, printer),
        *_layers(sheet, printer),
        *_overhangs(sheet, printer),
        *_bridges(sheet, printer),
        *_materials(sheet, printer, material_count),
    ]


def inspect_webs(sheet: ThickSheet, material: PrintMaterial, limit_deg: float) -> list[Finding]:
    """Findings about webs that break: too thick for their length and fold angle.

    limit_deg : creases that fold further count as folded by that angle. See
    `fab.panels.hinges.hinge_setbacks` for their strain.
    """
    webs = _webs(sheet)
    creases = sheet.creases[webs]
    if not len(webs):
        return []
    if material.strain_max is None:
        return [
            Finding(
                "hinge-breaks",
                Severity.WARNING,
                f"{counted(len(webs), 'web is', 'webs are')} of a material that breaks where it "
                f"bends. Print {'it' if len(webs) == 1 else 'them'} of PP or TPU, or choose other "
                "hinges.",
                creases=first_few(creases),
            )
        ]
    rho = np.radians(np.minimum(np.abs(sheet.pattern.edges_foldAngle[creases]), limit_deg))
    thick = _heights_mm(sheet, webs)
    strain = thick * rho / (4 * sheet.panels.setbacks.axis_mm[creases])
    wrong = np.flatnonzero(strain > material.strain_max * (1 + 1e-9))
    if not len(wrong):
        return []
    worst = int(np.argmax(strain))
    needed = float(thick[worst] * rho[worst] / (2 * material.strain_max))
    return [
        Finding(
            "hinge-strains",
            Severity.WARNING,
            f"{counted(len(wrong), 'web stretches', 'webs stretch')} by over strain_max = "
            f"{material.strain_max:g}, worst is crease {creases[worst]}: {strain[worst]:.3g}. Set "
            "hinges.strain_max to that of the material, or gap_mm to at least "
            f"{needed:.3g}, or make web_mm thinner.",
            creases=first_few(creases[wrong]),
        )
    ]


def bed_area_mm2(joined: TriangleMesh) -> float:
    """Area of the sides that lie on the bed, of a surface in mm."""
    corners = joined.vertices_coords[joined.triangles]
    lowest = joined.vertices_coords[:, 2].min(initial=np.inf)
    a, b, c = corners[(corners[:, :, 2] <= lowest + _ON_BED_MM).all(axis=1)].swapaxes(0, 1)
    return float(norm(cross(b - a, c - a)).sum() / 2)


def _size(joined: TriangleMesh, printer: Printer, *, divided: bool) -> list[Finding]:
    """Whether the print fits the bed and height of the printer, at any angle on the bed.

    divided : whether it is one that can be printed in parts.
    """
    coords = joined.vertices_coords
    if not len(coords):
        return []
    findings = []
    room = np.sort(printer.room_mm)
    _, box, over = fitting_box(coords[:, :2], printer.room_mm)
    if over > _ON_BED_MM:
        short, long = box
        cure = (
            "let `thicken` print it in parts"
            if divided
            else "leave hinges.embedded out: films below their panels are printed in parts"
        )
        findings.append(
            Finding(
                "print-too-large",
                Severity.ERROR,
                f"the flat print needs {long:.4g} x {short:.4g} mm, the printer has {room[1]:g} x "
                f"{room[0]:g} within its margins. Scale it to {min(room / box):.3g} of "
                f"its size at most, or {cure}.",
            )
        )
    height = float(np.ptp(coords[:, 2]))
    if height > printer.height_mm:
        findings.append(
            Finding(
                "print-too-high",
                Severity.ERROR,
                f"the flat print is {height:.4g} mm high, the printer reaches "
                f"{printer.height_mm:g}. Lower thickness_mm.",
            )
        )
    return findings


def _walls(panels: Panels, printer: Printer) -> list[Finding]:
    width = panel_widths_mm(panels)
    thin = np.flatnonzero(width < printer.nozzle_mm)
    if not len(thin):
        return []
    worst = int(width.argmin())
    return [
        Finding(
            "wall-too-thin",
            Severity.WARNING,
            f"{counted(len(thin), 'panel is', 'panels are')} narrower than nozzle_mm = "
            f"{printer.nozzle_mm:g} at {'its' if len(thin) == 1 else 'their'} bottom or top, worst "
            f"is panel {panels.faces[worst]}: {width[worst]:.3g} mm. Slicers leave such ridges "
            "out: lower thickness_mm or gap_mm, or enlarge the sheet.",
            panels=first_few(panels.faces[thin]),
        )
    ]


def _gaps(sheet: ThickSheet, printer: Printer) -> list[Finding]:
    """Whether gaps between panels, and the play of knuckles, stay open."""
    has_panel = np.append(sheet.panels.faces_has_panel, False)  # the last one for borders
    gap = 2 * sheet.panels.setbacks.axis_mm
    gap[~has_panel[sheet.pattern.edges_faces].all(axis=1)] = np.inf
    creases = sheet.knuckles.creases
    play = np.full(len(creases), sheet.knuckles.play_mm)
    return [
        *_narrow(
            np.arange(len(gap)), gap, printer, ("gap is", "gaps are"), "panels fuse. Raise gap_mm."
        ),
        *_narrow(
            creases,
            play,
            printer,
            ("knuckle has a play that is", "knuckles have a play that is"),
            "they fuse. Raise play_mm.",
        ),
    ]


def _narrow(
    creases: IntArray, gap_mm: FloatArray, printer: Printer, words: tuple[str, str], cure: str
) -> list[Finding]:
    """A finding where gaps at some creases, shape (k,), are narrower than a printer keeps open."""
    narrow = gap_mm < printer.least_gap_mm - _ON_BED_MM
    if not narrow.any():
        return []
    text = (
        f"{counted(int(narrow.sum()), *words)} narrower than the printer's least_gap_mm = "
        f"{printer.least_gap_mm:g}, the least is {gap_mm.min():.3g} mm: {cure}"
    )
    return [Finding("gap-too-narrow", Severity.WARNING, text, creases=first_few(creases[narrow]))]


def _layers(sheet: ThickSheet, printer: Printer) -> list[Finding]:
    """Whether webs are at least one layer, and whole layers."""
    webs = _webs(sheet)
    if not len(webs):
        return []
    height = _heights_mm(sheet, webs)
    layers = height / printer.layer_mm
    least = float(height.min())
    if layers.min() < 1 - _OFF_LAYER:
        return [
            Finding(
                "web-too-thin",
                Severity.ERROR,
                f"webs are {least:.3g} mm thick, less than one layer of layer_mm = "
                f"{printer.layer_mm:g}: they are not printed. Raise web_mm to that at least.",
                creases=first_few(sheet.creases[webs]),
            )
        ]
    off = np.abs(layers - np.round(layers))
    if off.max() <= _OFF_LAYER:
        return []
    worst = float(height[off.argmax()])
    down = np.floor(worst / printer.layer_mm) * printer.layer_mm
    return [
        Finding(
            "web-between-layers",
            Severity.NOTE,
            f"webs are {worst:.3g} mm thick, no whole number of layers of layer_mm = "
            f"{printer.layer_mm:g}: they come out thinner or thicker. Set web_mm to {down:.3g} or "
            f"{down + printer.layer_mm:.3g}.",
        )
    ]


def _overhangs(sheet: ThickSheet, printer: Printer) -> list[Finding]:
    """Sides of panels that look down, more than the printer prints without support."""
    bodies = sheet.panels.bodies
    corners = bodies.vertices_coords[bodies.triangles]
    a, b, c = corners.swapaxes(0, 1)
    down = -unit(cross(b - a, c - a))[:, 2]
    angle = np.degrees(np.arcsin(np.clip(np.nan_to_num(down), -1, 1)))
    over = (angle > printer.overhang_deg + 1e-6) & (angle < _LEVEL_DEG)
    owner = np.unique(bodies.triangles_body[over])
    if not len(owner):
        return []
    return [
        Finding(
            "overhang-too-flat",
            Severity.WARNING,
            f"{counted(len(owner), 'panel has', 'panels have')} sides that lean out by over "
            f"overhang_deg = {printer.overhang_deg:g} degrees, up to {angle[over].max():.4g}. "
            "Print with support, set axis = bottom, or lower fold_limit_deg.",
            panels=first_few(sheet.panels.faces[owner]),
        )
    ]


def _bridges(sheet: ThickSheet, printer: Printer) -> list[Finding]:
    """Webs that span a gap over air."""
    webs = _webs(sheet)
    low, _ = sheet.bodies.boxes()
    lowest = sheet.bodies.vertices_coords[:, 2].min(initial=np.inf)
    aloft = webs[low[webs, 2] > lowest + _ON_BED_MM]
    span = 2 * sheet.panels.setbacks.axis_mm[sheet.creases[aloft]]
    wide = np.flatnonzero(span > printer.bridge_mm)
    if not len(wide):
        return []
    return [
        Finding(
            "bridge-too-long",
            Severity.WARNING,
            f"{counted(len(wide), 'web spans', 'webs span')} up to {span.max():.3g} mm over air, "
            f"more than the printer's bridge_mm = {printer.bridge_mm:g}. Set axis = bottom, "
            "or print with support.",
            creases=first_few(sheet.creases[aloft[wide]]),
        )
    ]


def _materials(sheet: ThickSheet, printer: Printer, material_count: int) -> list[Finding]:
    printed = sheet.flexible[~sheet.laid]
    if not printed.any() or printed.all():
        return []
    if material_count > printer.extruders:
        return [
            Finding(
                "too-few-extruders",
                Severity.WARNING,
                f"panels and hinges are of {counted(material_count, 'material')}, and the printer "
                f"prints {printer.extruders} at a time (its key extruders). Give one material, or "
                "take a printer with a changer of materials.",
            )
        ]
    if printer.extruders > 1:
        return []
    return [
        Finding(
            "one-material",
            Severity.NOTE,
            "the printer has one extruder: panels and hinges are printed of the same material. "
            "Choose one that bends, such as PP or TPU.",
        )
    ]


def _webs(sheet: ThickSheet) -> IntArray:
    """Numbers of the bodies across a crease that bend."""
    return np.flatnonzero(sheet.flexible & (sheet.faces < 0) & (sheet.creases >= 0))


def _heights_mm(sheet: ThickSheet, chosen: IntArray) -> FloatArray:
    """From the bottom to the top of chosen bodies."""
    low, high = sheet.bodies.boxes()
    return np.asarray((high - low)[chosen, 2])
