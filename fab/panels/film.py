"""The film or fabric below all panels or embedded in them; axes of creases lie in its middle."""

from __future__ import annotations

import numpy as np
import shapely

from fab.geometry.bodies import Bodies, bodies_of
from fab.geometry.booleans import section
from fab.geometry.extrusion import circle, extruded
from fab.panels.bevelled_panels import Panels
from fab.panels.hinge_room import vertex_distances
from fab.panels.hinges import ROUND_SIDES, HingeSettings
from fab.panels.webs import inner_vertices
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.outlines import outlines_of

__all__ = ["make_film"]

# Holes of a smaller radius are left out.
_LEAST_RADIUS_MM = 0.1
# Films between panels end this far before them, and what is smaller is rounding along the outline.
_CLEAR_MM = 1e-4
_LEAST_AREA_MM2 = 1e-3


def make_film(
    pattern: CreasePattern, panels: Panels, settings: HingeSettings, gap_mm: float
) -> Bodies:
    """A film for each piece of the sheet; of embedded ones what is free between the panels.

    Its outline is that of the sheet; cuts within are as wide as the gap of the panels there. Around
    inner vertices it has holes that end `relief_mm` before the nearest corner of a panel.
    """
    outlines = outlines_of(pattern)
    rings = [shapely.Polygon(ring) for ring in outlines.rings]
    ccw = [shapely.is_ccw(ring.exterior) for ring in rings]
    sheet = shapely.union_all([ring for ring, outer in zip(rings, ccw, strict=True) if outer])
    inner = shapely.union_all([ring for ring, outer in zip(rings, ccw, strict=True) if not outer])
    slits = shapely.buffer(
        shapely.union_all(shapely.linestrings(outlines.slits)),
        gap_mm / 2,
        cap_style="flat",
        join_style="mitre",
    )
    level = 0.0 if settings.embedded else panels.heights_mm[0]
    least, _ = vertex_distances(pattern, panels, np.array([level]))
    radius = np.where(inner_vertices(pattern) & np.isfinite(least), least, 0) - settings.relief_mm
    holes = [
        circle(pattern.vertices_coords[v], float(radius[v]), ROUND_SIDES, around=False)
        for v in np.flatnonzero(radius >= _LEAST_RADIUS_MM).tolist()
    ]
    film = sheet - inner - slits - shapely.union_all(holes)
    if settings.embedded:
        bodies = panels.bodies
        within = [section(bodies.mesh(number), 0.0) for number in range(len(bodies))]
        film -= shapely.buffer(shapely.union_all(within), _CLEAR_MM, join_style="mitre")
    half = settings.film_mm / 2
    parts = [
        part
        for part in shapely.get_parts(film)
        if part.geom_type == "Polygon" and part.area > _LEAST_AREA_MM2
    ]
    return bodies_of([extruded(part, -half, half) for part in parts])
