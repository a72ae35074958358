"""The guide to thick panels: from the sheet, its plates and its scene to pages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely

from fab.errors import Finding, counted, mass_text
from fab.jobs.assembly_files import caution
from fab.panels.hinges import crease_kinds
from fab.panels.thick_sheet import ThickSheet
from fab.pattern.crease_pattern import CreasePattern
from fab.printing.plates import Plates
from fab.printing.thick_settings import PrintWith
from fab.viewing.assembly.panel_guide import PanelHinge, panel_guide
from fab.viewing.assembly.parts import Assembly, CutPiece, CutSheet, Hold, Joint, Model
from fab.viewing.drawing import size_text
from fab.viewing.leaflet import Leaflet
from fab.viewing.scene import Scene
from solver.vectors import FloatArray, IntArray

__all__ = ["panel_guide_of"]

_HOLDS = {"dovetail": Hold.DOVETAIL, "pin": Hold.PIN, "tape": Hold.TAPE}


def panel_guide_of(
    sheet: ThickSheet,
    plates: Plates | None,
    scene: Scene,
    state: int,
    name: str,
    print_with: PrintWith,
    figures: Mapping[str, Any],
    *,
    made_by: str,
    findings: Sequence[Finding] = (),
) -> Leaflet:
    """How thick panels are printed, joined and folded.

    plates : where the sheet is printed in parts. scene : of its bodies. state : the last one that
    panels reach. figures : of the report, for their mass. made_by : the command.
    findings : of all that is made.
    """
    pattern = sheet.pattern
    pieces = _parts(sheet, plates)
    joints = () if plates is None else tuple(_joints(pattern, plates))
    joined = {joint.edges[0]: joint.label for joint in joints}
    hinges = tuple(_hinges(sheet, joined))
    coords = None if scene.bodies is None else scene.bodies.coords_in(state)
    model = Model(
        name,
        pattern,
        None,
        scene.upright,
        pieces,
        joints,
        (),
        tuple(_facts(sheet, plates, hinges, coords, figures)),
        1,
        0,
        len(pieces),
        seam="joint",
    )
    printed = () if plates is None else _plates(plates)
    stock = tuple(_stock(sheet, print_with))
    assembly = Assembly(
        name,
        made_by,
        (model,),
        printed,
        stock,
        tuple(_printing(figures)),
        caution=caution(findings),
    )
    panels = tuple(int(face) for face in np.unique(sheet.panels.faces))
    return panel_guide(assembly, scene, hinges, state, panels)


def _printing(figures: Mapping[str, Any]) -> list[str]:
    """What is to be done while the panels are printed."""
    pause = figures.get("pause")
    if pause is None:
        return []
    return [
        f"Pause at z = {pause['z_mm']:g} mm, after layer {pause['after_layer']}, and lay in the "
        "film or fabric. Cut it along the outline in the end."
    ]


def _parts(sheet: ThickSheet, plates: Plates | None) -> tuple[CutPiece, ...]:
    """The parts as pieces of the pattern, their outlines in its plane."""
    sets = [("A", np.unique(sheet.panels.faces))]
    if plates is not None:
        sets = [(part.name, part.faces) for part in plates.parts]
    return tuple(CutPiece(name, faces, (), _outline(sheet.pattern, faces)) for name, faces in sets)


def _outline(pattern: CreasePattern, faces: IntArray) -> tuple[FloatArray, ...]:
    rings = [
        pattern.vertices_coords[
            pattern.faces_vertices[pattern.faces_offsets[f] : pattern.faces_offsets[f + 1]]
        ]
        for f in faces.tolist()
    ]
    whole = shapely.union_all([shapely.make_valid(shapely.Polygon(ring)) for ring in rings])
    parts = [part for part in np.atleast_1d(shapely.get_parts(whole)) if part.area > 0]
    return tuple(
        shapely.get_coordinates(ring)[:-1]
        for part in parts
        for ring in (part.exterior, *part.interiors)
    )


def _joints(pattern: CreasePattern, plates: Plates) -> list[Joint]:
    ends = pattern.vertices_coords[pattern.edges_vertices]
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    out = []
    for number, joint in enumerate(plates.joints, 1):
        first, second = (int(plates.faces_part[face]) for face in joint.faces)
        hold = _HOLDS[joint.kind]
        out.append(
            Joint(
                number,
                str(number),
                (joint.crease, joint.crease),
                (first, second),
                float(lengths[joint.crease]),
                float(pattern.edges_foldAngle[joint.crease]),
                hold,
                None if hold is Hold.TAPE else first,
            )
        )
    return out


def _hinges(sheet: ThickSheet, joined: Mapping[int, int]) -> list[PanelHinge]:
    """All hinges that hold two panels, by the numbers of their edges.

    joined : the joint at each crease between two parts.
    """
    pattern = sheet.pattern
    kinds, snaps = crease_kinds(pattern, sheet.hinge), sheet.hinge.snap
    ends = pattern.vertices_coords[pattern.edges_vertices]
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    return [
        PanelHinge(
            edge,
            "snap knuckle" if snaps and kinds[edge] == "knuckle" else str(kinds[edge]),
            joined.get(edge),
            float(lengths[edge]),
            float(pattern.edges_foldAngle[edge]),
            (int(pattern.edges_faces[edge, 0]), int(pattern.edges_faces[edge, 1])),
        )
        for edge in np.unique(sheet.held).tolist()
    ]


def _plates(plates: Plates) -> tuple[CutSheet, ...]:
    out = []
    for plate in range(plates.count):
        parts = tuple(
            (number, part.turn[:2, :2], part.shift[:2])
            for number, part in enumerate(plates.parts)
            if part.plate == plate
        )
        out.append(CutSheet((plate + 1,), plates.bed_mm, parts, None, "plate"))
    return tuple(out)


def _stock(sheet: ThickSheet, print_with: PrintWith) -> list[tuple[str, str]]:
    """Printer and materials, where they are known, and settings."""
    out = []
    if print_with.printer is not None:
        out.append(("Printer", print_with.printer.description))
    if print_with.panels is not None:
        out.append(("Panels of", print_with.panels.description))
    if print_with.hinges is not None:
        out.append(("Hinges of", print_with.hinges.description))
    out.append(
        ("Settings", f"{sheet.panel.thickness_mm:g} mm thick, gap {sheet.panel.gap_mm:g} mm")
    )
    return out


def _facts(
    sheet: ThickSheet,
    plates: Plates | None,
    hinges: tuple[PanelHinge, ...],
    coords: FloatArray | None,
    figures: Mapping[str, Any],
) -> list[tuple[str, str]]:
    kinds: dict[str, int] = {}
    for hinge in hinges:
        kinds[hinge.kind] = kinds.get(hinge.kind, 0) + 1
    by_kind = ", ".join(f"{kind}: {count}" for kind, count in kinds.items())
    out = [("Panels", str(len(np.unique(sheet.panels.faces)))), ("Hinges", by_kind or "none")]
    if plates is not None:
        parts = counted(len(plates.parts), "part")
        out.append(("Parts", f"{parts} on {counted(plates.count, 'plate')}"))
    out.append(("Flat", size_text("", sheet.bodies.vertices_coords).strip()))
    if coords is not None:
        out.append(("Folded", size_text("", coords).strip()))
    masses = [figures.get("mass_g"), figures.get("hinge_mass_g")]
    known = [mass for mass in masses if mass is not None]
    if known:
        out.append(("Mass", mass_text(sum(known))))
    return out
