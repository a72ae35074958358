"""Folded sheets under load: what they are made of, figures, findings, and their picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fab.errors import Finding, InvalidJob, Severity, first_few
from fab.folding.loads.load_settings import LoadSettings
from fab.folding.loads.loaded_sheet import LoadedSheet, load_sheet
from fab.folding.loads.plate import Plate
from fab.folding.quasi_static import Folding
from fab.pattern.face_poses import nearest_motions
from fab.progress import Progress, silent
from fab.sheets.materials import Material, load_material
from fab.viewing.scene_builders import folding_scene
from solver.vectors import FloatArray, IntArray, norm

__all__ = ["CarriedLoads", "carried_loads"]

# Creases are as stiff as the sheet is over so many of its thicknesses, where nothing is known.
_CREASE_THICKNESSES = 100.0


@dataclass(frozen=True)
class CarriedLoads:
    """A sheet under its loads.

    Attributes
    ----------
    name : of the sheet. material : what it is made of. sheet : in its states under load.
    guessed_creases : whether the stiffness of the creases is not that of the material.
    """

    name: str
    material: Material
    sheet: LoadedSheet
    guessed_creases: bool

    def report(self) -> dict[str, Any]:
        """Figures as JSON values; reactions of the first 20 fixed vertices, and their sum."""
        sheet, last = self.sheet, self.sheet.last
        flat = sheet.frame.sheet.pattern.vertices_coords
        held = np.flatnonzero(sheet.fixed)
        strongest = held[np.argsort(-norm(last.reactions_n[held]), kind="stable")]
        return {
            "text": self.sentence(),
            "settled": last.settled,
            "weight_n": sheet.weight_n,
            "sag_mm": sheet.sag_mm,
            "sag_vertex": self._number(sheet.sag_vertex),
            "sag_at_mm": flat[sheet.sag_vertex].tolist(),
            "displacement_max_mm": float(norm(sheet.displacement_mm).max()),
            "outer_strain_max": sheet.outer_strain_max,
            "strain_max": self.material.strain_max,
            "crease_stiffness_n": sheet.plate.crease_stiffness_n,
            "bending_stiffness_nm": sheet.plate.bending_stiffness_nm,
            "triangles": len(sheet.frame.triangles_vertices),
            "fixed_count": len(held),
            "load_sum_n": sheet.load_n.tolist(),
            "reaction_sum_n": last.reactions_n.sum(axis=0).tolist(),
            "reactions": [
                {
                    "vertex": self._number(vertex),
                    "at_mm": flat[vertex].tolist(),
                    "force_n": last.reactions_n[vertex].tolist(),
                }
                for vertex in first_few(strongest.tolist())
            ],
            "states": [
                {
                    "load": state.share,
                    "sag_mm": float(((state.coords - sheet.states[0].coords) @ sheet.down).max()),
                    "strain_max": state.strain_max,
                    "settled": state.settled,
                }
                for state in sheet.states
            ],
        }

    def sentence(self) -> str:
        """Such as "under load it sags by 12.3 mm at vertex 14 (card, weight 0.31 N)".

        It is said to rise or to move where it does so; the weight is named where it loads it.
        """
        sheet = self.sheet
        how, far, vertex = sheet.moved
        number = self._number(vertex)
        x, y = sheet.frame.sheet.pattern.vertices_coords[vertex]
        where = f"({x:.4g}, {y:.4g}) mm of the flat sheet" if number is None else f"vertex {number}"
        weight = f", weight {sheet.weight_n:.3g} N" if sheet.weighs else ""
        return (
            f"under load it {how} by {far:.3g} mm at {where} ({self.material.description}{weight})"
        )

    def findings(self) -> Iterator[Finding]:
        """What a user should know of it."""
        sheet = self.sheet
        if not all(state.settled for state in sheet.states):
            share = next(state.share for state in sheet.states if not state.settled)
            text = (
                f"at {share:.0%} of its load the sheet does not come to rest: it may move without "
                "end. Fix more vertices, take more load_steps, or less load."
            )
            yield Finding("loads-not-at-rest", Severity.ERROR, text)
        bears = self.material.strain_max
        if bears is not None and sheet.outer_strain_max > bears:
            text = (
                f"under load its outer fibre is strained by up to {sheet.outer_strain_max:.2g}; "
                f"{self.material.description} bears {bears:g}."
            )
            yield Finding("strained-by-loads", Severity.WARNING, text)
        for piece, held in sheet.swinging:
            text = self._swings(piece, held)
            yield Finding("swings-about-support", Severity.NOTE, text)
        if self.guessed_creases:
            text = (
                "the material does not say how stiff its creases are: they are taken as stiff as "
                f"the sheet over {_CREASE_THICKNESSES:g} of its thicknesses, "
                f"{sheet.plate.crease_stiffness_n:.3g} N. Give it crease_stiffness_n."
            )
            yield Finding("crease-stiffness-guessed", Severity.NOTE, text)

    def _swings(self, piece: IntArray, held: IntArray) -> str:
        """That a piece of the sheet can swing about what holds it, and how to clamp it."""
        frame = self.sheet.frame
        flat = frame.sheet.pattern.vertices_coords
        what = "the sheet"
        if len(piece) < len(np.unique(frame.triangles_vertices)):
            what = f"the piece in [{_box(flat[piece])}] mm of the flat sheet"
        beside = np.isin(frame.triangles_vertices, held).any(axis=1)
        row = flat[np.unique(frame.triangles_vertices[beside])]
        small = np.ptp(row, axis=0).prod() < np.ptp(flat[piece], axis=0).prod() / 2
        first, last = (f"({x:.4g}, {y:.4g})" for x, y in _ends(flat[held]))
        if first == last:
            where = f"at one point only, {first} mm"
        else:
            where = f"along one straight line only, from {first} to {last} mm"
        return (
            f"{what} is held {where} of the flat sheet: it can swing about it as on a hinge. To "
            f"clamp it, hold a region{f', such as --fix {_box(row)}' if small else ' x,y,x,y'}."
        )

    def states_mm(self, coords: FloatArray) -> list[tuple[str, FloatArray]]:
        """States under load of the sheet's own vertices, moved to where the fold has the sheet.

        coords : shape (nv, 3), mm, of the sheet's vertices without load.
        """
        corners = self.sheet.corners
        unloaded = self.sheet.states[0].coords[corners]
        turns, shifts = nearest_motions(unloaded[None], coords[None])
        return [
            (f"under {state.share:.2%} of the load", state.coords[corners] @ turns[0].T + shifts[0])
            for state in self.sheet.states[1:]
        ]

    def png_bytes(self) -> bytes:
        """The picture without load and under load, as a PNG file."""
        from fab.viewing.loads_picture import loads_png_bytes

        first, last = self.sheet.states[0], self.sheet.last
        pattern = self.sheet.frame.sheet.pattern
        return loads_png_bytes(
            pattern, first.coords, last.coords, f"{self.name}: {self.sentence()}"
        )

    def _number(self, vertex: int) -> int | None:
        """The number of a vertex in the pattern; None for those between."""
        number = int(self.sheet.numbers[vertex])
        return number if number >= 0 else None


def carried_loads(
    folding: Folding,
    settings: LoadSettings,
    material: str | None,
    name: str,
    *,
    upright: bool = False,
    progress: Progress = silent,
) -> CarriedLoads:
    """Load the end of a fold, in the pose in which pictures show it.

    material : by its name or path, where the settings have none. progress : called with the stage
    "load".

    Raises `InvalidJob` where the material is not known or has no youngs_modulus_mpa, and as
    `fab.folding.loads.loaded_sheet.load_sheet`.
    """
    wanted = settings.material or material
    if wanted is None:
        raise InvalidJob(
            "loads.material is missing: the weight and the stiffness of the sheet are those of a "
            "material, such as card_300gsm. Give it (--material)."
        )
    sheet = load_material(wanted)
    if sheet.youngs_modulus_mpa is None:
        raise InvalidJob(
            f"{wanted} has no youngs_modulus_mpa: how far it bends under load is not known. Give "
            "it in a copy of its file."
        )
    modulus, ratio = sheet.youngs_modulus_mpa, sheet.poissons_ratio
    plate = Plate(sheet.thickness_mm, sheet.density_kg_m3, modulus, ratio, 0.0)
    stiffness = sheet.crease_stiffness_n
    guessed = stiffness is None
    if stiffness is None:
        length = 1e-3 * _CREASE_THICKNESSES * sheet.thickness_mm
        stiffness = plate.bending_stiffness_nm / length
    plate = Plate(sheet.thickness_mm, sheet.density_kg_m3, modulus, ratio, stiffness)
    coords = folding_scene(folding, name, upright=upright).states_coords[-1]
    loaded = load_sheet(folding.frame, coords, plate, settings, partial(progress, "load"))
    return CarriedLoads(name, sheet, loaded, guessed and _has_creases(loaded))


def _ends(points: FloatArray) -> FloatArray:
    """The first point of some on a line, and the last."""
    first = points[np.lexsort(points.T[::-1])[0]]
    return np.stack([first, points[norm(points - first).argmax()]])


def _box(points: FloatArray) -> str:
    """The region of the flat sheet around points, x,y,x,y, rounded outwards to 0.001 mm."""
    low = np.floor(np.round(1e3 * points.min(axis=0), 3)) / 1e3
    high = np.ceil(np.round(1e3 * points.max(axis=0), 3)) / 1e3
    return ",".join(f"{value + 0.0:.10g}" for value in (*low, *high))


def _has_creases(sheet: LoadedSheet) -> bool:
    return bool((sheet.frame.hinges_stiffness > 0).any())
