"""Soundness of the bodies of a thick sheet: closed, in one piece, and held together by hinges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fab.errors import Finding, Severity, counted
from fab.geometry.bodies import Bodies, TriangleMesh
from fab.geometry.booleans import manifold_of, manifolds
from fab.panels.thick_sheet import ThickSheet
from solver.graphs import labels
from solver.vectors import FloatArray, IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = [
    "SolidFigures",
    "held_together",
    "inspect_joined",
    "inspect_solids",
    "inspect_soundness",
    "parts_of",
]

_VOLUME_REL = 1e-9
# Corners too near to each other for single precision become one where bodies are joined.
_JOINED_REL = 1e-6


@dataclass(frozen=True)
class SolidFigures:
    """What the bodies of a sheet are.

    Attributes
    ----------
    panels : number of them; hinges : creases at which two of them hold together, by any hinge.
    bodies : number of pieces after joining.
    volume_mm3, flexible_mm3, laid_mm3 : of all solids together, of those that bend, and of those
        that are laid into the print.
    """

    panels: int
    hinges: int
    bodies: int
    volume_mm3: float
    flexible_mm3: float
    laid_mm3: float


def inspect_solids(
    sheet: ThickSheet, solids: list[Manifold], joined: TriangleMesh
) -> tuple[SolidFigures, list[Finding]]:
    """Check every body, the joined surface, and whether hinges hold each piece together.

    solids : the bodies of the sheet as manifold3d solids. joined : the surface of all of them.
    """
    findings = [*inspect_soundness(sheet, solids), *inspect_joined(sheet, joined)]
    parts = held_together(sheet)
    pieces = len(np.unique(sheet.pattern.faces_piece[sheet.panels.faces]))
    if parts > pieces:
        findings.append(
            Finding(
                "panels-loose",
                Severity.ERROR,
                f"The panels are joined into {parts} bodies, not {pieces}: some have no hinge. "
                "Lower gap_mm or relief_mm, or enlarge the sheet.",
            )
        )
    volumes = sheet.bodies.volumes_mm3()
    figures = SolidFigures(
        len(sheet.panels.bodies),
        len(sheet.held),
        parts,
        float(volumes.sum()),
        float(volumes[sheet.flexible].sum()),
        float(volumes[sheet.laid].sum()),
    )
    return figures, findings


def inspect_soundness(sheet: ThickSheet, solids: list[Manifold]) -> list[Finding]:
    """A finding for each body that is not closed, in one piece and of positive volume.

    solids : the bodies of the sheet, read by manifold3d, whose volumes must be the same.
    """
    from manifold3d import Error

    findings = []
    volumes = sheet.bodies.volumes_mm3()
    parts = parts_of(sheet.bodies)
    for body, solid in enumerate(solids):
        # NoError speaks of topology alone: the volume must be right as well
        wrong = abs(solid.volume() - volumes[body]) > _VOLUME_REL * volumes[body]
        status = solid.status()
        if status != Error.NoError or wrong or volumes[body] <= 0 or parts[body] != 1:
            panel = sheet.creases[body] < 0 <= sheet.faces[body]
            findings.append(
                Finding(
                    "solid-invalid",
                    Severity.ERROR,
                    f"{sheet.names[body].replace('_', ' ')} is not a valid solid: {status.name}, "
                    f"{counted(int(parts[body]), 'part')}, volume {solid.volume():.6g} of "
                    f"{volumes[body]:.6g} mm3. Report this with the job.",
                    creases=(int(sheet.creases[body]),) if sheet.creases[body] >= 0 else (),
                    panels=(int(sheet.faces[body]),) if panel else (),
                )
            )
    return findings


def inspect_joined(sheet: ThickSheet, joined: TriangleMesh) -> list[Finding]:
    """A finding where the joined surface is not closed, or has not the volume of all bodies."""
    from manifold3d import Error

    whole = manifold_of(joined)
    total = float(sheet.bodies.volumes_mm3()[~sheet.laid].sum())
    if whole.status() == Error.NoError and abs(whole.volume() - total) <= _JOINED_REL * total:
        return []
    fault, place = _fault(sheet, joined, whole)
    bodies = _nearest(sheet.bodies, place)
    panel, crease = sheet.faces[bodies], sheet.creases[bodies]
    near = "".join(f", near {sheet.names[body].replace('_', ' ')}" for body in bodies)
    return [
        Finding(
            "joined-invalid",
            Severity.ERROR,
            f"The joined body is not a valid solid: {whole.status().name}, volume "
            f"{whole.volume():.6g} of {total:.6g} mm3; {fault}{near}. Take the single bodies "
            "(--only zip), or change gap_mm or thickness_mm a little; report this with the job.",
            creases=tuple(crease[crease >= 0].tolist()),
            panels=tuple(panel[(panel >= 0) & (crease < 0)].tolist()),
        )
    ]


def _fault(sheet: ThickSheet, joined: TriangleMesh, whole: Manifold) -> tuple[str, FloatArray]:
    """What is wrong with the joined surface, and where in the sheet, mm; NaN where nowhere."""
    from manifold3d import Error, Manifold, OpType

    nowhere = np.full(3, np.nan)
    # the joined surface stands on z = 0
    lift = np.array([0.0, 0.0, sheet.joining.vertices_coords[:, 2].min(initial=0.0)])
    if whole.status() != Error.NoError:
        count = len(joined.vertices_coords)
        sides = joined.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        matched = np.isin(sides @ [count, 1], sides @ [1, count])
        if matched.all():
            return "its surface meets itself", nowhere
        place = joined.vertices_coords[sides[~matched][0]].mean(axis=0) + lift
        return f"it is open at {counted(int((~matched).sum()), 'edge')}", place
    moved = whole.translate(tuple(lift))
    printed = sheet.bodies.chosen(np.flatnonzero(~sheet.laid))
    bodies = Manifold.batch_boolean(manifolds(printed), OpType.Add)
    kinds = {"is missing": bodies - moved, "is too much": moved - bodies}
    what, amiss = max(kinds.items(), key=lambda item: item[1].volume())
    if amiss.volume() <= _JOINED_REL * bodies.volume():
        return "bodies overlap each other", nowhere
    largest = max(amiss.decompose(), key=lambda part: part.volume())
    low, high = np.split(np.array(largest.bounding_box()), 2)
    return f"{largest.volume():.3g} mm3 {what} in one place", (low + high) / 2


def _nearest(bodies: Bodies, place: FloatArray) -> IntArray:
    """The body whose box is nearest to a place, shape (1,); none for a place that is NaN."""
    if np.isnan(place).any():
        return np.empty(0, np.int64)
    low, high = bodies.boxes()
    off = np.maximum(np.maximum(low - place, place - high), 0.0)
    return np.array([np.argmin(np.hypot(np.hypot(off[:, 0], off[:, 1]), off[:, 2]))])


def parts_of(bodies: Bodies) -> IntArray:
    """Number of connected parts of every body, shape (n,)."""
    corners = bodies.triangles
    pairs = np.column_stack([corners[:, [0, 1]].ravel(), corners[:, [1, 2]].ravel()])
    _, member = np.unique(labels(pairs, len(bodies.vertices_coords)), return_index=True)
    return np.bincount(bodies.vertices_body[member], minlength=len(bodies))


def held_together(sheet: ThickSheet) -> int:
    """Number of bodies that the panels make with their hinges of any kind."""
    panels = sheet.panels.faces
    pairs = np.searchsorted(panels, sheet.pattern.edges_faces[sheet.held])
    return 1 + int(labels(pairs, len(panels)).max(initial=-1))
