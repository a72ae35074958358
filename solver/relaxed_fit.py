"""Surfaces followed by relaxed sheets, told as growth is: one mesh, a status, what was chosen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from solver.errors import InvalidState, require_count, require_finite, require_within
from solver.goals import Goals
from solver.graphs import labels
from solver.growth import Growth, Status
from solver.mesh import QuadMesh
from solver.relaxation.laying import Pleats
from solver.relaxation.sheet_fit import Wishes
from solver.resolution import fewest_columns
from solver.surface_sheet import SurfaceSheet
from solver.surface_sheets import (
    MOST_COLUMNS,
    MOST_SHEETS,
    NARROW_PLEATS,
    PLEATS,
    TURNS,
    SurfaceSheets,
    surface_sheets,
)
from solver.targets.base import Target
from solver.targets.mesh_target import MeshTarget
from solver.targets.smoothing import smoothed, smoothing_length
from solver.targets.surface_mesh import MeshKind, SurfaceMesh
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["joined", "relaxed_fit", "resolved_fit", "sampled"]

# Quads along either parameter by which a surface with formulas is sampled.
_SAMPLES = 96
# Columns of the first sheet by which others are chosen.
_FIRST = 14
# Samples at its sides are the same where they are nearer than this share of its size.
_SAME = 1e-9


def relaxed_fit(
    mesh: SurfaceMesh,
    columns: int,
    *,
    thickness: float = 1.0,
    zigzag: float | None = None,
    row_step: float | None = None,
    turn: float | None = None,
    rigid: bool = False,
    goals: Goals | None = None,
    nearest: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """Sheets relaxed onto a surface, as many as it needs, joined in one mesh.

    Parameters
    ----------
    columns : faces across the surface's map, or around a tube.
    thickness, zigzag, row_step : of the cell, in steps (thickness: in rows' distances); see
        `Pleats`. turn : direction of the lines, radians from the longest extent of the map. What
        is not given is chosen.
    rigid : whether sheets fold rigidly, and flat; they are then as near to their offsets as that
        allows, and a surface that is not closed gets a single one.
    goals : bounds that are wanted of the sheets; they come as near as they can.
    nearest : whether the good sheet nearest to the surface is taken, not that with wide sectors.
    progress : called with the number of settings tried and about how many there are.

    A noisy mesh is smoothed first by as much as its noise wants (`smoothing_length`);
    `Growth.chosen` then tells that length, and how far the copy is from the mesh at
    most. Raises `InvalidValue` and `InvalidState` as `surface_sheets`.
    """
    require_count("columns", columns, 4, "A sheet needs vertices to follow a surface.")
    for name, value in (("thickness", thickness), ("zigzag", zigzag), ("row_step", row_step)):
        if value is not None:
            require_within(name, value, 0.0, 1000.0, "It is counted in steps.")
    if turn is not None:
        require_finite("turn", turn)
    followed, smoothing = _without_noise(mesh, float(np.sqrt(mesh.area)) / columns)

    def given(usual: Sequence[Pleats]) -> list[Pleats]:
        tried = [
            Pleats(
                zigzag=one.zigzag if zigzag is None else zigzag,
                spacing=one.spacing if row_step is None else row_step,
                thickness=thickness * one.thickness,
                stretch=one.stretch,
            )
            for one in usual
        ]
        return list(dict.fromkeys(tried))

    found = surface_sheets(
        followed,
        columns,
        pleats=given(PLEATS),
        narrow_pleats=given(NARROW_PLEATS),
        turns=TURNS if turn is None else (turn,),
        wishes=Wishes(rigid=rigid),
        goals=goals,
        most_sheets=1 if rigid and mesh.kind is not MeshKind.SPHERE else MOST_SHEETS,
        nearest=nearest,
        progress=progress,
    )
    growth = _told(found, columns, smoothing, rigid)
    return replace(growth, distances=_distances(growth.mesh, mesh, followed))


def resolved_fit(
    fit: Callable[[int], Growth],
    *,
    cell: float | None = None,
    distance: float | None = None,
    unit: Callable[[QuadMesh], float] | None = None,
) -> Growth:
    """Sheets of as few columns as have quads, or distances from the surface, of a given size.

    Parameters
    ----------
    fit : sheets of so many columns, as `relaxed_fit` makes them.
    cell, distance : the width of a quad, and the largest distance of a vertex from the surface,
        which are to be kept; one of the two.
    unit : of either, in units of a sheet, asked of the sheet; None: it is theirs.

    Status NOT_FITTED says where no sheet of at most 400 columns is as fine.
    """
    name, bound = ("cell", cell) if distance is None else ("deviation", distance)
    if bound is None:
        raise InvalidState("cell", "neither cell nor distance is given", "Give one of them.")
    require_within(name, bound, 0.0, np.inf, "It is a length.")

    def size(growth: Growth) -> float:
        found = growth.chosen["step"] if distance is None else growth.distance
        assert found is not None  # of relaxed sheets
        return found / (1.0 if unit is None else unit(growth.mesh))

    found = fewest_columns(fit, size, bound, first=_FIRST, least=4, most=MOST_COLUMNS)
    growth = found.sheet
    if found.held or growth.status is not Status.GROWN:
        return growth
    tried = "sheet tried has" if len(found.sizes) == 1 else "sheets tried have"
    advice = (
        f"{name} = {bound:g} is not reached: {len(found.sizes)} {tried} "
        f"{min(found.sizes.values()):.4g} at least, at {found.columns} columns."
    )
    if found.needed is None:
        advice += " Allow that, or give columns."
    else:
        within = found.sizes[found.columns] * found.columns / MOST_COLUMNS
        advice += (
            f" About {found.needed} columns would be needed, and {MOST_COLUMNS} is the most: allow "
            f"about {within:.2g}, or give columns."
        )
    return replace(growth, status=Status.NOT_FITTED, advice=advice)


def _without_noise(mesh: SurfaceMesh, cell: float) -> tuple[SurfaceMesh, dict[str, float]]:
    """The surface that is followed, and what is told of its smoothing; nothing where it is none."""
    length = smoothing_length(mesh, cell)
    if length > 0:
        try:
            copy = smoothed(mesh, length)
        except InvalidState:  # it would collapse: the surface is followed as it is
            return mesh, {}
        return copy.mesh, {
            "smoothing_length": length,
            "smoothing_moved": float(copy.distances.max()),
        }
    return mesh, {}


def _distances(sheet: QuadMesh, mesh: SurfaceMesh, followed: SurfaceMesh) -> FloatArray:
    """Signed distances from `mesh` of the vertices that are over `followed`, its smooth copy.

    Of all vertices where none is.
    """
    target, points = MeshTarget(followed), sheet.vertices_coords
    distances, _, places = target.distance(points, target.unknown(len(points)))
    over = target.inside(places)
    over = over if over.any() else np.ones(len(points), bool)
    if followed is not mesh:
        distances = MeshTarget(mesh).distance(points, target.unknown(len(points)))[0]
    return distances[over]


def _told(found: SurfaceSheets, columns: int, smoothing: dict[str, float], rigid: bool) -> Growth:
    sheets = found.sheets
    mesh = (
        joined([sheet.mesh.cut_open() for sheet in sheets]) if len(sheets) > 1 else sheets[0].mesh
    )
    first = sheets[0]
    chosen = {
        "sheets": float(len(sheets)),
        "columns": float(columns),
        "zigzag": first.pleats.zigzag,
        "row_step": first.pleats.spacing,
        "thickness": first.pleats.thickness,
        "turn_deg": float(np.degrees(first.turn)),
        "step": first.step,
        "off_steps": max(sheet.off for sheet in sheets),  # each in its own
    }
    chosen |= smoothing
    # how far a sheet that folds rigidly is off its surface is for the user to judge
    bad = [
        (number, sheet)
        for number, sheet in enumerate(sheets, 1)
        if not (sheet.made if rigid else sheet.good)
    ]
    rows = sum(sheet.mesh.grid.shape[0] - 1 for sheet in sheets)
    deviations = np.concatenate([sheet.deviations for sheet in sheets])
    status, advice = Status.GROWN, ""
    if bad:
        status = Status.NOT_FITTED
        advice = " ".join(_advice(number, sheet, len(sheets)) for number, sheet in bad)
    distance = max(sheet.distance for sheet in sheets)
    return Growth(mesh, rows, status, advice, found.coverage, chosen, deviations, distance)


def _advice(number: int, sheet: SurfaceSheet, count: int) -> str:
    """What is wrong with a sheet, and what would help."""
    name = f"Sheet {number} of {count}" if count > 1 else "The sheet"
    if sheet.advice:
        return f"{name}: {sheet.advice}"
    if not sheet.exact:
        return f"{name} has faces that are not convex, and does not unfold. Try more columns."
    if sheet.crossings:
        return (
            f"{name} crosses itself in {sheet.crossings} pairs of faces. More columns, a smaller "
            "thickness or another turn may help."
        )
    return (
        f"{name} covers {sheet.coverage:.1%} of its part, and its vertices are up to "
        f"{sheet.off:.2f} steps off their offsets. More columns or a smaller thickness bring it "
        "nearer."
    )


def joined(meshes: list[QuadMesh]) -> QuadMesh:
    """Several open patches as one mesh in as many pieces; their grids are one below another."""
    width = max(mesh.grid.shape[1] for mesh in meshes)
    coords: list[FloatArray] = []
    faces: list[IntArray] = []
    grids: list[IntArray] = []
    count = 0
    for mesh in meshes:
        rows, columns = mesh.grid.shape
        grid = np.full((rows + 1, width), -1)
        grid[:rows, :columns] = np.where(mesh.grid >= 0, mesh.grid + count, -1)
        coords.append(mesh.vertices_coords)
        faces.append(mesh.faces_vertices + count)
        grids.append(grid)
        count += len(mesh.vertices_coords)
    return QuadMesh(np.concatenate(coords), np.concatenate(faces), np.concatenate(grids)[:-1])


def sampled(target: Target) -> SurfaceMesh:
    """Triangles of the part of a target that is within its domain; its largest piece.

    Where sides of the square of its parameters coincide, or shrink to a point, the triangles are
    joined, so that a surface that closes on itself is closed.

    Raises `InvalidState` where nothing is within the domain.
    """
    u = np.linspace(-1, 1, _SAMPLES + 1)
    places = target.places(np.stack(np.meshgrid(u, u, indexing="ij"), axis=-1).reshape(-1, 2))
    coords = target.point(places)
    inside = target.inside(places) & np.isfinite(coords).all(axis=1)
    number = _joined_sides(coords, inside).reshape(len(u), -1)
    quads = np.stack(
        [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1
    ).reshape(-1, 4)
    quads = quads[inside[quads].all(axis=1)]
    if not len(quads):
        raise InvalidState("surface", "no part of it is within its domain", "Enlarge the domain.")
    sides = np.concatenate([np.sort(quads[:, [k, (k + 1) % 4]], axis=1) for k in range(4)])
    _, which = np.unique(sides, axis=0, return_inverse=True)
    of = np.tile(np.arange(len(quads)), 4)
    order = np.argsort(which.ravel(), kind="stable")
    same = which.ravel()[order][1:] == which.ravel()[order][:-1]
    piece = labels(np.column_stack([of[order][:-1][same], of[order][1:][same]]), len(quads))
    quads = quads[piece == np.bincount(piece).argmax()]
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    triangles = triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]
    used, triangles = np.unique(triangles, return_inverse=True)
    return SurfaceMesh.of(coords[used], triangles.reshape(-1, 3))


def _joined_sides(coords: FloatArray, inside: BoolArray) -> IntArray:
    """The number of each sample, (n,); the same for samples at the sides that coincide."""
    number = np.arange(len(coords))
    grid = number.reshape(_SAMPLES + 1, -1)
    rim = np.unique(np.concatenate([grid[0], grid[-1], grid[:, 0], grid[:, -1]]))
    rim = rim[inside[rim]]
    if len(rim):
        near = _SAME * float(np.ptp(coords[inside], axis=0).max())
        group = labels(cKDTree(coords[rim]).query_pairs(near, output_type="ndarray"), len(rim))
        _, first = np.unique(group, return_index=True)
        number[rim] = rim[first[group]]
    return number
