"""Edges that end within a face: slits through its panel, and creases that no panel can follow."""

from __future__ import annotations

import numpy as np
import shapely

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.bodies import Bodies, bodies_of
from fab.geometry.booleans import difference, meshes, solid
from fab.geometry.extrusion import extruded
from fab.panels.bevelled_panels import Panels
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.outlines import inner_cuts
from solver.vectors import IntArray

__all__ = ["slitted"]

# Slots reach this far beyond their panel at the bottom and at the top.
_BEYOND_MM = 1.0


def slitted(pattern: CreasePattern, panels: Panels, bodies: Bodies) -> tuple[Bodies, list[Finding]]:
    """The bodies of panels with a slot along every cut that ends within its face.

    bodies : one for each panel, with its knuckles and holes. Slots are as wide as gaps across
    other cuts are, through the whole panel, and half their width longer at both ends.

    Findings name slits that would take all of their panel, or part it, and creases that end
    within a face: panels do not bend there.
    """
    inner = pattern.edges_faces[:, 0] == pattern.edges_faces[:, 1]
    inner &= pattern.edges_faces[:, 0] >= 0
    if not inner.any():
        return bodies, []
    cuts = inner_cuts(pattern)
    creases = np.flatnonzero(inner & ~cuts)
    slits = np.flatnonzero(inner & cuts)
    findings = _not_folded(creases)
    owners = pattern.edges_faces[slits, 0]
    place = np.searchsorted(panels.faces, owners)
    with_panel = np.isin(owners, panels.faces)
    slits, place = slits[with_panel], place[with_panel]
    if not len(slits):
        return bodies, findings
    out = [bodies.mesh(i) for i in range(len(bodies))]
    whole: list[int] = []
    low, high = panels.heights_mm
    for body in np.unique(place).tolist():
        own = slits[place == body]
        lines = shapely.linestrings(pattern.vertices_coords[pattern.edges_vertices[own]])
        half = panels.setbacks.axis_mm[own]
        slots = shapely.union_all(
            shapely.buffer(lines, half, cap_style="square", join_style="mitre")
        )
        cutters = [
            solid(extruded(slot, low - _BEYOND_MM, high + _BEYOND_MM))
            for slot in shapely.get_parts(slots)
        ]
        left = difference([solid(out[body]), *cutters])
        if len(left.decompose()) != 1:
            whole += own.tolist()
        else:
            out[body] = meshes([left])[0]
    return bodies_of(out), [*findings, *_not_cut(pattern, np.array(whole, np.int64))]


def _not_cut(pattern: CreasePattern, slits: IntArray) -> list[Finding]:
    if not len(slits):
        return []
    text = (
        f"{counted(len(slits), 'cut that ends', 'cuts that end')} within a face "
        f"{'is' if len(slits) == 1 else 'are'} not made, since a slot as wide as gap_mm leaves "
        "nothing of the panel, or parts it. Lower gap_mm, or enlarge the sheet."
    )
    panels = first_few(np.unique(pattern.edges_faces[slits, 0]))
    return [Finding("slit-not-cut", Severity.ERROR, text, first_few(slits), panels)]


def _not_folded(creases: IntArray) -> list[Finding]:
    if not len(creases):
        return []
    text = (
        f"{counted(len(creases), 'crease ends', 'creases end')} within a face, whose panel does "
        f"not bend: {'it has' if len(creases) == 1 else 'they have'} no hinge. Divide the face by "
        "creases from border to border."
    )
    return [Finding("crease-within-panel", Severity.WARNING, text, creases=first_few(creases))]
