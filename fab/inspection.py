"""Can it be made: do the files hold what they promise, and where do they not?

Every finding has a code, a severity and names the creases or panels it is about.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fab.bodies import Bodies, TriangleMesh
from fab.crease import CreasePattern, fold_angles_deg
from fab.errors import Finding, Severity
from fab.hinges import crease_sides
from fab.joining import manifold_of, manifolds
from fab.kinematics import vertices_closure_rad
from fab.thick import ThickSheet
from solver.measure import angle_excess, isometry, planarity
from solver.vectors import IntArray

__all__ = [
    "Accuracy",
    "SolidFigures",
    "inspect_accuracy",
    "inspect_angles",
    "inspect_closure",
    "inspect_crossings",
    "inspect_solids",
    "measure_pattern",
]

# manifold3d reports up to 5e-13 mm3 where two bodies only touch; real overlaps are far larger.
_OVERLAP_MM3 = 1e-6
# Fold angles measured on short edges lose digits; a wrong crease is off by far more.
_ANGLE_DEG = 1e-3
# Files have their angles with a few digits, and each vertex has several of them.
_CLOSURE_DEG = 1e-2
# Clearance may fall short of the gap by rounding alone.
_CLEARANCE_SHARE = 0.97


@dataclass(frozen=True)
class Accuracy:
    """How exact a folded sheet and its crease pattern are; NaN where there is no folded form.

    Attributes
    ----------
    planarity_max : largest distance of a face from flat over its longest diagonal.
    developability_max_rad : largest |2 pi - sum of sector angles| at an interior vertex.
    isometry_max_rel : largest relative change of a side or diagonal from flat to folded.
    """

    planarity_max: float
    developability_max_rad: float
    isometry_max_rel: float


def measure_pattern(pattern: CreasePattern) -> Accuracy:
    """Measure a pattern with a folded form, faces of any size."""
    folded = pattern.folded_coords
    if folded is None:
        return Accuracy(float("nan"), float("nan"), float("nan"))
    planar = change = np.float64(0.0)
    excess = np.zeros(len(folded))
    corners = np.zeros(len(folded))
    inside = np.ones(len(folded), bool)
    inside[pattern.edges_vertices[pattern.edges_faces[:, 1] < 0]] = False
    for _, faces in pattern.faces_by_size():
        # numpy's maximum keeps NaN, the mark of a face without area
        planar = np.maximum(planar, planarity(folded, faces).max())
        change = np.maximum(change, isometry(folded, pattern.vertices_coords, faces).max())
        everywhere = np.ones(len(folded), bool)
        excess += angle_excess(folded, faces, everywhere) + 2 * np.pi
        corners += np.bincount(faces.ravel(), minlength=len(folded))
    inside &= corners > 0
    developable = np.abs(excess - 2 * np.pi)[inside].max(initial=0.0)
    return Accuracy(float(planar), float(developable), float(change))


def inspect_accuracy(accuracy: Accuracy, tolerance: float) -> list[Finding]:
    """A finding for each figure over `tolerance`, or not a number."""
    findings = []
    for code, value, cure in (
        ("not-planar", accuracy.planarity_max, "Faces are bent: their creases will not meet."),
        (
            "not-developable",
            accuracy.developability_max_rad,
            "The folded form does not unfold into a flat sheet.",
        ),
        (
            "not-isometric",
            accuracy.isometry_max_rel,
            "Flat and folded form differ in lengths: short edges lose digits first.",
        ),
    ):
        if not value <= tolerance:
            text = f"{code.replace('-', ' ')}: {value:.3g} is over the tolerance {tolerance:.3g}."
            findings.append(Finding(code, Severity.ERROR, f"{text} {cure}"))
    return findings


def inspect_angles(pattern: CreasePattern) -> list[Finding]:
    """A finding where stored fold angles differ from those of the folded form.

    Cuts, and creases that end within a face, have none there.
    """
    if pattern.folded_coords is None:
        return []
    measured = fold_angles_deg(
        pattern.folded_coords, pattern.edges, pattern.faces_vertices, pattern.faces_offsets
    )
    turn = np.abs(measured - pattern.edges_foldAngle)
    off = np.minimum(turn, 360 - turn)
    one, two = pattern.edges_faces.T
    off[(one == two) | (pattern.edges_assignment == "C")] = 0.0
    wrong = np.flatnonzero(off > _ANGLE_DEG)
    if not len(wrong):
        return []
    worst = int(np.argmax(off))
    return [
        Finding(
            "angles-differ",
            Severity.ERROR,
            f"{len(wrong)} stored fold angles differ from the folded form by over {_ANGLE_DEG:g} "
            f"degrees; worst is edge {worst}: {pattern.edges_foldAngle[worst]:.6g} stored, "
            f"{measured[worst]:.6g} folded.",
            creases=tuple(wrong[:20].tolist()),
        )
    ]


def inspect_closure(pattern: CreasePattern) -> list[Finding]:
    """A finding where the fold angles around a vertex do not close."""
    gaps = np.nan_to_num(np.degrees(vertices_closure_rad(pattern)))
    wrong = np.flatnonzero(gaps > _CLOSURE_DEG)
    if not len(wrong):
        return []
    worst = int(np.argmax(gaps))
    x, y = pattern.vertices_coords[worst]
    return [
        Finding(
            "angles-open",
            Severity.WARNING,
            f"the fold angles around {len(wrong)} vertices do not close by over {_CLOSURE_DEG:g} "
            f"degrees; worst is vertex {worst} at ({x:.6g}, {y:.6g}) mm, by {gaps[worst]:.4g} "
            "degrees. Faces cannot stay flat there: change its angles, or add a crease.",
        )
    ]


def inspect_crossings(crossings: IntArray) -> list[Finding]:
    """A finding where faces of the folded form cross: pairs of `fab.crossing`, shape (n, 2).

    A warning: the flat files are as good as ever, but what is folded from them stops short.
    """
    if not len(crossings):
        return []
    one, two = crossings[0]
    return [
        Finding(
            "sheet-crosses-itself",
            Severity.WARNING,
            f"the folded sheet passes through itself: {len(crossings)} pairs of faces cross, the "
            f"first are {one} and {two}. The flat sheet can be cut, but no sheet can fold to the "
            "whole of this shape: grow fewer strips, or change flap angles or lengths.",
            panels=tuple(sorted({int(face) for face in crossings[:10].ravel()})),
        )
    ]


@dataclass(frozen=True)
class SolidFigures:
    """What the check of the bodies measured.

    Attributes
    ----------
    panels, hinges : number of solids; bodies : number of pieces after joining.
    volume_mm3 : of all solids together.
    pairs_checked : neighbouring pairs whose overlap and clearance were measured.
    overlap_max_mm3 : largest common volume of two solids.
    clearance_min_mm : least distance of two panels, in the flat state.
    """

    panels: int
    hinges: int
    bodies: int
    volume_mm3: float
    pairs_checked: int
    overlap_max_mm3: float
    clearance_min_mm: float


def inspect_solids(
    sheet: ThickSheet, joined: TriangleMesh, gap_mm: float
) -> tuple[SolidFigures, list[Finding]]:
    """Check every solid and every neighbouring pair with manifold3d, in the flat state.

    Neighbours are all pairs whose boxes come within the gap of each other: panels across a crease
    and around a vertex, webs and the panels they join.
    """
    from manifold3d import Error

    findings: list[Finding] = []
    volumes = sheet.bodies.volumes_mm3()
    solids = manifolds(sheet.bodies)
    names = [name.replace("_", " ") for name in sheet.names]
    panels = sheet.panels
    count = len(panels.bodies)
    for body, solid in enumerate(solids):
        # NoError speaks of topology alone: the volume must be right as well
        wrong = abs(solid.volume() - volumes[body]) > 1e-9 * volumes[body] or volumes[body] <= 0
        if solid.status() != Error.NoError or wrong:
            findings.append(
                Finding(
                    "solid-invalid",
                    Severity.ERROR,
                    f"{names[body]} is not a valid solid: {solid.status().name}, volume "
                    f"{solid.volume():.6g} of {volumes[body]:.6g} mm3. Report this with the job.",
                    creases=() if body < count else (int(sheet.creases[body]),),
                    panels=(int(sheet.faces[body]),) if body < count else (),
                )
            )
    overlap_max, clearance = 0.0, np.inf
    joined_faces = {(min(pair), max(pair)) for pair in sheet.pattern.edges_faces.tolist()}
    pairs = _near_pairs(sheet.bodies, gap_mm)
    for one, two in pairs.tolist():
        common = (solids[one] ^ solids[two]).volume()
        overlap_max = max(overlap_max, common)
        both_panels = two < count
        gap = solids[one].min_gap(solids[two], 2 * gap_mm) if both_panels else np.inf
        clearance = min(clearance, gap)
        named = tuple(int(sheet.faces[body]) for body in (one, two) if body < count)
        if common > _OVERLAP_MM3:
            findings.append(
                Finding(
                    "solids-overlap",
                    Severity.ERROR,
                    f"{names[one]} and {names[two]} share {common:.3g} mm3. The flat sheet "
                    "overlaps itself, or its faces are too thin for their gaps.",
                    panels=named,
                )
            )
        elif gap < _CLEARANCE_SHARE * gap_mm:
            # only panels with a common crease are promised the gap; others may come closer
            # around a narrow panel at a vertex, but must not touch
            promised = named in joined_faces or gap == 0.0
            findings.append(
                Finding(
                    "clearance-too-small",
                    Severity.ERROR if promised else Severity.WARNING,
                    f"{names[one]} and {names[two]} are {gap:.4g} mm apart, gaps are "
                    f"{gap_mm:g} mm. Raise gap_mm, or enlarge the sheet.",
                    panels=named,
                )
            )
    bodies = _body_count(sheet)
    if bodies > 1:
        findings.append(
            Finding(
                "panels-loose",
                Severity.ERROR,
                f"The panels are joined into {bodies} bodies, not 1: some have no hinge. "
                "Lower gap_mm or relief_mm, or enlarge the sheet.",
            )
        )
    whole = manifold_of(joined)
    total = float(volumes.sum())
    if whole.status() != Error.NoError or abs(whole.volume() - total) > 1e-9 * total:
        findings.append(
            Finding(
                "joined-invalid",
                Severity.ERROR,
                f"The joined body is not a valid solid: {whole.status().name}, volume "
                f"{whole.volume():.6g} of {total:.6g} mm3. Report this with the job.",
            )
        )
    figures = SolidFigures(
        count,
        len(sheet.bodies) - count,
        bodies,
        total,
        len(pairs),
        float(overlap_max),
        float(min(clearance, 2 * gap_mm)),
    )
    return figures, findings


def _near_pairs(bodies: Bodies, reach_mm: float) -> IntArray:
    """Pairs (i < j) of bodies whose boxes come within `reach_mm` of each other, shape (n, 2)."""
    if not len(bodies):
        return np.empty((0, 2), np.int64)
    low, high = bodies.boxes()
    low, high = low - reach_mm / 2, high + reach_mm / 2
    shapes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    one, two = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    keep = one < two
    order = np.lexsort((two[keep], one[keep]))
    return np.column_stack([one[keep], two[keep]])[order]


def _body_count(sheet: ThickSheet) -> int:
    panels = sheet.panels
    first, second = crease_sides(sheet.pattern, panels)
    hinges = sheet.creases[sheet.creases >= 0]
    place = np.searchsorted(panels.faces, panels.sides.faces)
    one, two = place[first[hinges]], place[second[hinges]]
    size = len(panels.bodies)
    graph = coo_array((np.ones(len(one)), (one, two)), shape=(size, size))
    return int(connected_components(graph, directed=False)[0]) if size else 0
