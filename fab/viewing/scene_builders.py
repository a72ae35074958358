"""Scenes of crease patterns, of simulations, and of thick sheets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fab.errors import Finding
from fab.folding.folded_states import FoldedState
from fab.folding.quasi_static import Folding, aligned
from fab.folding.strain import faces_strain
from fab.geometry.boxes import smallest_box
from fab.panels.body_colours import body_colours
from fab.panels.thick_sheet import ThickSheet
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.face_poses import nearest_motions
from fab.pattern.open_cuts import Opened, opened
from fab.viewing.scales import STRAIN, distance_scale
from fab.viewing.scene import Scene, SceneBodies, Surface, Values
from solver.polygons import face_normals
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import FloatArray, IntArray

__all__ = [
    "folding_scene",
    "laid_flat",
    "over_surface",
    "pattern_scene",
    "thick_scene",
    "with_open_cuts",
]

# Sides of a box that differ by a smaller share are equal.
_SQUARE = 1e-6


def pattern_scene(
    pattern: CreasePattern,
    name: str,
    *,
    findings: Sequence[Finding] = (),
    upright: bool = False,
) -> Scene:
    """The flat sheet, and its folded form where the pattern has one.

    upright : whether z is up in the folded form; else it is laid flat.
    """
    flat = _in_space(pattern)
    if pattern.folded_coords is None:
        return Scene(name, pattern, np.zeros(1), flat[None], findings=tuple(findings))
    folded = pattern.folded_coords
    if not upright:
        turn, shift = laid_flat(pattern, folded)
        folded = folded @ turn.T + shift
    states = np.stack([aligned(flat, folded), folded])
    return Scene(
        name, pattern, np.array([0.0, 1.0]), states, upright=upright, findings=tuple(findings)
    )


def folding_scene(
    folding: Folding,
    name: str,
    *,
    findings: Sequence[Finding] = (),
    upright: bool = False,
) -> Scene:
    """A simulated fold, its faces with their strain in percent; of a rigid one, `RigidFold.shown`.

    findings : with numbers of the pattern that was folded: its cuts are open in the scene, which
    has edges and numbers of its own where there are cuts.
    upright : whether z is up in the folded form of the pattern, which the last state then has the
    pose of.
    """
    frame = folding.frame
    sheet = frame.sheet.pattern
    coords = np.stack([state.coords for state in folding.states]) * frame.size_mm
    if upright and sheet.folded_coords is not None:
        turn, shift = _motion(coords[-1], sheet.folded_coords)
    else:
        turn, shift = laid_flat(sheet, coords[-1])
    strain = np.stack([faces_strain(frame, state.coords) for state in folding.states])
    return Scene(
        name,
        sheet,
        np.array([state.load for state in folding.states]),
        coords @ turn.T + shift,
        upright=upright,
        values=Values(100.0 * strain, STRAIN),
        findings=tuple(_renumbered(finding, frame.sheet) for finding in findings),
    )


def thick_scene(
    sheet: ThickSheet,
    states: Sequence[FoldedState],
    name: str,
    *,
    findings: Sequence[Finding] = (),
    upright: bool = False,
) -> Scene:
    """Panels and hinges in the states of their rigid faces, the flat one first.

    upright : as in `folding_scene`, of the last state, whose pose is that of the folded form where
    the pattern has one.
    """
    split = _split(sheet.pattern)
    pattern = split.pattern
    coords = np.stack([_corners_mean(pattern, state) for state in states])
    turns = np.stack([state.turns for state in states])
    shifts = np.stack([state.shifts for state in states])
    for number in reversed(range(len(states))):
        if number < len(states) - 1:
            turn, shift = _motion(coords[number], coords[number + 1])
        elif upright:
            turn, shift = np.eye(3), np.zeros(3)
        else:
            turn, shift = laid_flat(pattern, coords[number])
        coords[number] = coords[number] @ turn.T + shift
        turns[number] = turn @ turns[number]
        shifts[number] = shifts[number] @ turn.T + shift
    bodies = SceneBodies(
        sheet.bodies,
        sheet.names,
        np.array(body_colours(sheet)).reshape(-1, 3),
        sheet.faces,
        _numbers_in(split, sheet.creases),
        _faces_moved_with(sheet),
        turns,
        shifts,
        tuple(state.name for state in states),
    )
    shares = np.array([state.share for state in states])
    return Scene(
        name,
        pattern,
        shares,
        coords,
        upright=upright,
        findings=with_open_cuts(findings, sheet.pattern),
        bodies=bodies,
    )


def over_surface(scene: Scene, surface: SurfaceMesh) -> Scene:
    """The scene with the surface that its sheet follows, its faces with their distance from it.

    surface : in mm, in the pose of the sheet's last state. Distances are of the middles of the
    faces' corners there, positive on the side of the surface's normals.
    """
    from solver.targets.mesh_target import MeshTarget

    pattern, folded = scene.pattern, scene.states_coords[-1]
    middles = np.add.reduceat(folded[pattern.faces_vertices], pattern.faces_offsets[:-1])
    middles /= np.diff(pattern.faces_offsets)[:, None]
    target = MeshTarget(surface)
    points = np.concatenate([middles, folded])
    every, _, _ = target.distance(points, target.unknown(len(points)))
    distances, farthest = every[: len(middles)], float(np.abs(every[len(middles) :]).max())
    return replace(
        scene,
        surface=Surface(surface.vertices_coords, surface.faces_vertices, farthest),
        values=Values(distances[None], distance_scale(distances)),
    )


def laid_flat(pattern: CreasePattern, coords: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The motion x -> turn x + shift that lays a form flat, upper side up, its length along x.

    The plane that is nearest to the form comes to lie at z = 0, and there the smallest box around
    it along x and y. The middle of the vertices comes to the origin.

    coords : shape (nv, 3). The turn has shape (3, 3) and is no mirror; the shift has shape (3,).
    """
    middle = coords.mean(axis=0)
    size = float(np.abs(coords - middle).max(initial=0.0)) or 1.0
    local = (coords - middle) / size
    _, vectors = np.linalg.eigh(local.T @ local)
    axes: FloatArray = vectors.T[::-1].copy()
    for axis in axes[:2]:
        axis *= 1.0 if axis[np.argmax(np.abs(axis))] > 0 else -1.0
    axes[2] = np.cross(axes[0], axes[1])
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = face_normals(local, pattern.faces_vertices, pattern.faces_offsets)
    if np.nan_to_num(normals).sum(axis=0) @ axes[2] < -1e-9 * len(normals):
        axes[1:] *= -1
    x, y = _box_length(local @ axes[:2].T)
    axes = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]]) @ axes
    return axes, -axes @ middle


def _box_length(coords: FloatArray) -> FloatArray:
    """The direction of the longer side of the smallest box around points, (n, 2), a unit vector."""
    import shapely

    corners = smallest_box(shapely.MultiPoint(coords))
    sides = np.diff(corners, axis=0)[:2]
    lengths = np.hypot(*sides.T)
    if not len(sides) or lengths.max() == 0:
        return np.array([1.0, 0.0])
    # of a square the first side, whatever rounding says
    longest = sides[-1] if lengths[-1] > lengths[0] * (1 + _SQUARE) else sides[0]
    along: FloatArray = longest / np.hypot(*longest)
    return along if along[np.argmax(np.abs(along))] > 0 else -along


def _in_space(pattern: CreasePattern) -> FloatArray:
    flat: FloatArray = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    return flat


def _motion(coords: FloatArray, onto: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The rigid motion x -> turn x + shift of points nearest to others, shapes (3, 3) and (3,)."""
    turns, shifts = nearest_motions(coords[None], onto[None])
    return turns[0], shifts[0]


def _corners_mean(pattern: CreasePattern, state: FoldedState) -> FloatArray:
    """Vertices of a state with rigid faces: the mean of where its faces have each of them."""
    corners = pattern.faces_vertices
    face = np.repeat(np.arange(pattern.face_count), np.diff(pattern.faces_offsets))
    flat = pattern.vertices_coords[corners]
    moved = np.squeeze(state.turns[face, :, :2] @ flat[:, :, None], axis=2) + state.shifts[face]
    count = np.bincount(corners, minlength=len(pattern.vertices_coords))
    out = np.zeros((len(pattern.vertices_coords), 3))
    np.add.at(out, corners, moved)
    return out / np.maximum(count, 1)[:, None]


def _faces_moved_with(sheet: ThickSheet) -> IntArray:
    """The face that each vertex of the bodies moves with: bodies that bend, by the side of their
    crease that it is on.
    """
    bodies, pattern = sheet.bodies, sheet.pattern
    owner = bodies.vertices_body
    face = sheet.faces[owner]
    bent = np.flatnonzero((face < 0) & (sheet.creases[owner] >= 0))
    edge = sheet.creases[owner[bent]]
    start, end = pattern.vertices_coords[pattern.edges_vertices[edge]].swapaxes(0, 1)
    along, off = end - start, bodies.vertices_coords[bent, :2] - start
    # the first face of an edge is on its left
    left = along[:, 0] * off[:, 1] > along[:, 1] * off[:, 0]
    face[bent] = np.where(left, *pattern.edges_faces[edge].T)
    return face


def with_open_cuts(findings: Sequence[Finding], pattern: CreasePattern) -> tuple[Finding, ...]:
    """Findings about a pattern, with the numbers that creases have in its thick scene.

    The cuts between its faces are open there.
    """
    split = _split(pattern)
    return tuple(_renumbered(finding, split) for finding in findings)


def _split(pattern: CreasePattern) -> Opened:
    """The pattern with its cuts open; as it is, with its own numbers, where it has none."""
    if (pattern.edges_assignment == "C").any():
        return opened(pattern)
    vertices, edges = len(pattern.vertices_coords), len(pattern.edges_vertices)
    return Opened(pattern, np.arange(vertices), np.arange(edges))


def _numbers_in(split: Opened, edges: IntArray) -> IntArray:
    """The numbers that edges of a pattern have with its cuts open; -1 for those of number -1."""
    number = np.full(
        max(int(split.edges_source.max(initial=-1)), int(edges.max(initial=-1))) + 2, -1
    )
    number[split.edges_source] = np.arange(len(split.edges_source))
    return np.asarray(number[edges])


def _renumbered(finding: Finding, split: Opened) -> Finding:
    """A finding with the numbers that its creases have with the cuts of their pattern open."""
    own = np.flatnonzero(np.isin(split.edges_source, finding.creases))
    return replace(finding, creases=tuple(own.tolist()))
