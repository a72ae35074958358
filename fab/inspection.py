"""Can it be made: do the files hold what they promise, and where do they not?

Every finding has a code, a severity and names the creases or panels it is about.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fab.bodies import TriangleMesh, prism_meshes
from fab.crease import CreasePattern, fold_angles_deg
from fab.errors import Finding, Severity
from fab.hinges import Webs
from fab.kinematics import vertices_closure_rad
from fab.panels import Panels, Prisms
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
    pattern: CreasePattern, panels: Panels, webs: Webs, joined: TriangleMesh, gap_mm: float
) -> tuple[SolidFigures, list[Finding]]:
    """Check every solid and every neighbouring pair with manifold3d, in the flat state.

    Neighbours are all pairs whose boxes come within the gap of each other: panels across a crease
    and around a vertex, webs and the panels they join.
    """
    from manifold3d import Error, Manifold, Mesh64

    def manifold(mesh: TriangleMesh) -> Manifold:
        return Manifold(Mesh64(mesh.vertices_coords, mesh.triangles.astype(np.uint64)))

    findings: list[Finding] = []
    volumes = np.concatenate([panels.prisms.volumes_mm3(), webs.prisms.volumes_mm3()])
    solids = [manifold(m) for m in [*prism_meshes(panels.prisms), *prism_meshes(webs.prisms)]]
    count = len(panels.prisms)

    def name(body: int) -> str:
        if body < count:
            return f"panel {panels.faces[body]}"
        return f"hinge {webs.creases[body - count]}"

    for body, solid in enumerate(solids):
        # NoError speaks of topology alone: the volume must be right as well
        wrong = abs(solid.volume() - volumes[body]) > 1e-9 * volumes[body] or volumes[body] <= 0
        if solid.status() != Error.NoError or wrong:
            findings.append(
                Finding(
                    "solid-invalid",
                    Severity.ERROR,
                    f"{name(body)} is not a valid solid: {solid.status().name}, volume "
                    f"{solid.volume():.6g} of {volumes[body]:.6g} mm3. Report this with the job.",
                    creases=() if body < count else (int(webs.creases[body - count]),),
                    panels=(int(panels.faces[body]),) if body < count else (),
                )
            )
    overlap_max, clearance = 0.0, np.inf
    joined_faces = {(min(pair), max(pair)) for pair in pattern.edges_faces.tolist()}
    pairs = _near_pairs([panels.prisms, webs.prisms], gap_mm)
    for one, two in pairs.tolist():
        common = (solids[one] ^ solids[two]).volume()
        overlap_max = max(overlap_max, common)
        both_panels = two < count
        gap = solids[one].min_gap(solids[two], 2 * gap_mm) if both_panels else np.inf
        clearance = min(clearance, gap)
        named = tuple(int(panels.faces[body]) for body in (one, two) if body < count)
        if common > _OVERLAP_MM3:
            findings.append(
                Finding(
                    "solids-overlap",
                    Severity.ERROR,
                    f"{name(one)} and {name(two)} share {common:.3g} mm3. The flat sheet overlaps "
                    "itself, or its faces are too thin for their gaps.",
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
                    f"{name(one)} and {name(two)} are {gap:.4g} mm apart, gaps are {gap_mm:g} mm. "
                    "Raise gap_mm, or enlarge the sheet.",
                    panels=named,
                )
            )
    bodies = _body_count(panels, webs)
    if bodies > 1:
        findings.append(
            Finding(
                "panels-loose",
                Severity.ERROR,
                f"The panels are joined into {bodies} bodies, not 1: some have no hinge. "
                "Lower gap_mm or relief_mm, or enlarge the sheet.",
            )
        )
    whole = manifold(joined)
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
        len(webs.prisms),
        bodies,
        total,
        len(pairs),
        float(overlap_max),
        float(min(clearance, 2 * gap_mm)),
    )
    return figures, findings + _fold_limits(pattern, panels, gap_mm)


def _near_pairs(groups: list[Prisms], reach_mm: float) -> IntArray:
    """Pairs (i < j) of prisms whose boxes come within `reach_mm` of each other, shape (n, 2)."""
    boxes = []
    for prisms in groups:
        if len(prisms):
            ring = np.concatenate([prisms.bottom, prisms.top], axis=1)
            low = np.minimum.reduceat(ring, prisms.offsets[:-1]) - reach_mm / 2
            high = np.maximum.reduceat(ring, prisms.offsets[:-1]) + reach_mm / 2
            x0, y0 = np.minimum(low[:, 0], low[:, 2]), np.minimum(low[:, 1], low[:, 3])
            x1, y1 = np.maximum(high[:, 0], high[:, 2]), np.maximum(high[:, 1], high[:, 3])
            boxes.append(shapely.box(x0, y0, x1, y1))
    shapes = np.concatenate(boxes) if boxes else np.empty(0, object)
    one, two = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    keep = one < two
    order = np.lexsort((two[keep], one[keep]))
    return np.column_stack([one[keep], two[keep]])[order]


def _body_count(panels: Panels, webs: Webs) -> int:
    owner = np.repeat(np.arange(len(panels.prisms)), np.diff(panels.prisms.offsets))
    one, two = owner[webs.sides].T if len(webs.sides) else (np.empty(0, int), np.empty(0, int))
    size = len(panels.prisms)
    graph = coo_array((np.ones(len(one)), (one, two)), shape=(size, size))
    return int(connected_components(graph, directed=False)[0]) if size else 0


def _fold_limits(pattern: CreasePattern, panels: Panels, gap_mm: float) -> list[Finding]:
    """Valleys whose vertical panel walls meet before the target: 2 t tan(angle / 2) > gap."""
    if not len(panels.prisms):
        return []
    thickness = float(panels.prisms.heights_mm.max())
    reach_deg = float(np.degrees(2 * np.arctan(gap_mm / (2 * thickness))))
    standing = np.zeros(pattern.face_count + 1, bool)  # the last entry stands for no face
    standing[panels.faces] = True
    between = standing[pattern.edges_faces].all(axis=1)
    blocked = np.flatnonzero(between & (pattern.edges_foldAngle > reach_deg))
    if not len(blocked):
        return []
    most = pattern.edges_foldAngle[blocked].max()
    return [
        Finding(
            "fold-blocked",
            Severity.WARNING,
            f"{len(blocked)} valleys should fold by up to {most:.1f} degrees, but panels "
            f"{thickness:g} mm thick with gaps of {gap_mm:g} mm meet at {reach_deg:.1f} degrees. "
            "Lower thickness_mm or raise gap_mm.",
            creases=tuple(blocked[:20].tolist()),
        )
    ]
