"""Which pieces is a sheet cut into, and how are they glued together again?

pattern -> sets of faces -> seams -> tabs -> pieces with labels, each a pattern of its own
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from pydantic import Field

from fab.errors import Finding, Severity
from fab.layout.assembly_order import assembly_order, piece_name
from fab.layout.face_sets import Sheet, extent, outer_corners, upright
from fab.layout.partition import partition
from fab.pattern.closing_edges import closing_edges
from fab.pattern.crease_pattern import CreasePattern, face_normals
from fab.settings import Settings
from fab.sheets.glue_tabs import Banks, corner_angles, placed_tabs
from fab.sheets.labels import Label, fitted, highest, number_text
from solver.errors import InvalidValue, require_positive
from solver.mesh import edges_of
from solver.vectors import FloatArray, IntArray, cross, unit

__all__ = ["Piece", "Pieces", "Seam", "SheetSplit", "split"]

# Smaller letters cannot be read.
_READABLE_MM = 1.0
_MOST_NAMED = 20
# So many of the largest faces are tried for the name of a piece.
_MOST_TRIED = 24


class SheetSplit(Settings):
    """How a sheet that is too large, or that overlaps itself, is cut into pieces."""

    margin_mm: float = Field(default=5.0, ge=0, le=1000, description="kept free around the bed")
    mitre_mm: float = Field(
        default=0.0, ge=0, le=1000, description="room for mitres of the cut, inside the margin"
    )
    tabs: bool = Field(default=True, description="whether seams get glue tabs")
    tab_mm: float = Field(
        default=8.0, ge=1, le=1000, description="greatest height of a tab; lower on short edges"
    )
    tab_angle_deg: float = Field(
        default=45.0, ge=10, le=90, description="greatest angle at the foot of a tab"
    )
    label_mm: float = Field(default=4.0, ge=1, le=1000, description="greatest height of letters")


@dataclass(frozen=True)
class Seam:
    """An edge along which two pieces, or two edges of one, are glued together.

    Attributes
    ----------
    label : running number, in the order of assembling; it is engraved on both sides
        (`fab.labels.number_text`).
    edges : numbers in the whole pattern, first and second side; the same twice, unless the whole
        pattern is open here and its folded form is closed.
    pieces : numbers of the pieces of both sides.
    piece_edges : numbers of the edge in the patterns of both pieces.
    length_mm, fold_angle_deg : the fold angle as in a pattern, of both faces.
    tab : the side that carries the tab, 0 or 1; None where there is none.
    """

    label: int
    edges: tuple[int, int]
    pieces: tuple[int, int]
    piece_edges: tuple[int, int]
    length_mm: float
    fold_angle_deg: float
    tab: int | None


@dataclass(frozen=True)
class Piece:
    """A part of the sheet with its tabs, its best box upright at the origin.

    Attributes
    ----------
    name : "A", "B", ... "Z", "AA", ...
    pattern : the piece as a pattern of its own. Its faces are faces of the whole pattern, rising,
        and after them the tabs; the crease of a tab is folded as its seam is.
    faces, edges : numbers in the whole pattern, -1 for tabs and their sides.
    labels : text to be engraved: the piece's name, then those of its seams. None crosses a crease.
    unwritten : the texts that there is no room for.
    """

    name: str
    pattern: CreasePattern
    faces: IntArray
    edges: IntArray
    labels: tuple[Label, ...]
    unwritten: tuple[str, ...]


@dataclass(frozen=True)
class Pieces:
    """All pieces, and the seams in the order in which they are glued.

    A piece's seams to those assembled before it come one after another.
    """

    pieces: tuple[Piece, ...]
    seams: tuple[Seam, ...]

    @property
    def labelled(self) -> bool:
        """Whether labels tell anything: not those of one piece without seams."""
        return len(self.pieces) > 1 or len(self.seams) > 0


@dataclass(frozen=True)
class _Seams:
    """Seams before they have tabs.

    edges, faces, vertices, pieces : of both sides, shapes (n, 2), (n, 2), (n, 2, 2), (n, 2);
    vertices run with the face of their side on the left. angle : fold angle, degrees, shape (n,).
    """

    edges: IntArray
    faces: IntArray
    vertices: IntArray
    pieces: IntArray
    angle: FloatArray


def split(
    pattern: CreasePattern,
    settings: SheetSplit,
    bed_mm: tuple[float, float],
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Pieces, list[Finding]]:
    """Pieces that lie on the bed and overlap nowhere, with tabs and labels.

    A pattern that fits is one piece. Otherwise it is cut along its inner edges, those of assignment
    F too, into as few pieces as the search finds. Edges of the boundary that come together when
    folded (a ring cut open) are seams as well, where the pattern knows its folded form.

    progress : called with (steps done, steps in all): each face is set apart, then drawn.

    Raises `InvalidValue` for a bed smaller than a face with its tabs, or a face without area.
    """
    border = settings.margin_mm + settings.mitre_mm
    kept = f"margin {settings.margin_mm:g} mm"
    if settings.mitre_mm:
        kept += f", mitres of the cut {settings.mitre_mm:g} mm"
    for name, length in zip(("bed width", "bed height"), bed_mm, strict=True):
        require_positive(name, length, "Give the size of the bed in mm.")
        if length <= 2 * border:
            bound = f"be greater than 2 x {border:g} mm, what is kept free ({kept})"
            raise InvalidValue(name, f"{length:g} mm", bound, "Lower margin_mm.")
    if pattern.face_count == 0:
        raise InvalidValue("faces", 0, "be at least 1", "Give a pattern with faces.")
    width, height = (length - 2 * border for length in bed_mm)
    told = f"the bed of {bed_mm[0]:g} x {bed_mm[1]:g} mm less {border:g} mm on each side ({kept})"
    joined = pattern.edges_joining
    closing, closing_angle = closing_edges(pattern)
    glued = np.zeros(len(joined), bool)
    glued[closing.ravel()] = True
    sheet = Sheet(pattern, joined, _reach(pattern, settings), glued, (width, height), told)
    steps = 2 * pattern.face_count

    def tell(done: int, _: int) -> None:
        if progress is not None:
            progress(done, steps)

    sets = partition(sheet, tell)
    owner = np.empty(pattern.face_count, np.int64)
    for number, faces in enumerate(sets):
        owner[faces] = number
    pairs = np.concatenate([pattern.edges_faces[joined], pattern.edges_faces[closing, 0]])
    order, rank = assembly_order(owner[pairs], len(sets))
    sets = [sets[number] for number in order.tolist()]
    owner = rank[owner]
    seams = _seams(pattern, owner, joined, closing, closing_angle)
    side, tops = _tabs(pattern, owner, seams, settings)
    pieces: list[Piece] = []
    drawn = pattern.face_count
    for number, faces in enumerate(sets):
        pieces.append(_piece(sheet, number, faces, seams, side, tops, settings))
        drawn += len(faces)
        tell(drawn, steps)
    made = Pieces(tuple(pieces), _numbered(pattern, pieces, seams, side))
    return made, _findings(made, settings)


def _reach(pattern: CreasePattern, settings: SheetSplit) -> FloatArray:
    """Outer corners of the widest tabs on both sides of all edges; the ends where there are none.

    On the first side the tab of the first face stands, across the edge from it.
    """
    ends = pattern.vertices_coords[pattern.edges_vertices]
    if not settings.tabs:
        return np.stack([ends, ends], axis=1)
    both = np.stack([ends, ends[:, ::-1]], axis=1).reshape(-1, 2, 2)
    steep = np.full((len(both), 2), np.pi / 2)
    high = np.full(len(both), settings.tab_mm)
    return outer_corners(both, high, steep).reshape(-1, 2, 2, 2)


def _seams(
    pattern: CreasePattern,
    owner: IntArray,
    joined: np.ndarray,
    closing: IntArray,
    closing_angle: FloatArray,
) -> _Seams:
    """All seams: each piece's to those before it, and last those that close it."""
    inner = np.flatnonzero(joined)
    inner = inner[np.ptp(owner[pattern.edges_faces[inner]], axis=1) > 0]
    edges = np.concatenate([np.column_stack([inner, inner]), closing])
    faces = np.concatenate([pattern.edges_faces[inner], pattern.edges_faces[closing, 0]])
    ends = pattern.edges_vertices[edges]
    ends[: len(inner), 1] = ends[: len(inner), 1, ::-1]
    angle = np.concatenate([pattern.edges_foldAngle[inner], closing_angle])
    pieces = owner[faces]
    # seams of two pieces run side by side, in the order along which the neighbours are met
    order = np.lexsort((edges[:, 0], pieces.min(axis=1), pieces.max(axis=1)))
    return _Seams(edges[order], faces[order], ends[order], pieces[order], angle[order])


def _tabs(
    pattern: CreasePattern, owner: IntArray, seams: _Seams, settings: SheetSplit
) -> tuple[IntArray, FloatArray]:
    """Side of each seam that carries its tab, -1 for none, and the tab's outer corners."""
    count, nv = len(seams.edges), len(pattern.vertices_coords)
    if not settings.tabs or not count:
        return np.full(count, -1), np.full((count, 2, 2), np.nan)
    coords, corners, offsets = (
        pattern.vertices_coords,
        pattern.faces_vertices,
        pattern.faces_offsets,
    )
    angles = corner_angles(coords, corners, offsets)
    face = np.repeat(np.arange(pattern.face_count), np.diff(offsets))
    # angles of a face, and of a piece, at a vertex
    face_key = face * nv + corners
    by_face = np.argsort(face_key)
    piece_key, group = np.unique(owner[face] * nv + corners, return_inverse=True)
    in_piece = np.bincount(group, angles)
    inside = in_piece[np.searchsorted(piece_key, seams.pieces[:, :, None] * nv + seams.vertices)]
    gaps = np.asarray(2 * np.pi - inside, np.float64)
    across = seams.faces[:, ::-1, None] * nv + seams.vertices[:, ::-1, ::-1]
    beyond_angles = angles[by_face[np.searchsorted(face_key[by_face], across)]]
    ends = coords[seams.vertices]
    shapes = shapely.polygons(shapely.linearrings(coords[corners], indices=face))
    own, theirs = ends[:, 0] @ [1, 1j], ends[:, 1, ::-1] @ [1, 1j]
    beyond = np.stack(
        [
            _moved(shapes[seams.faces[:, 1]], theirs, own),
            _moved(shapes[seams.faces[:, 0]], own[:, ::-1], theirs[:, ::-1]),
        ],
        axis=1,
    )
    banks = Banks(ends, seams.vertices, seams.pieces, gaps, beyond, beyond_angles)
    return placed_tabs(
        banks, settings.tab_mm, settings.tab_angle_deg, shapes, owner, face_key[by_face], nv
    )


def _moved(shapes: np.ndarray, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Polygons moved rigidly, each so that its complex edge `start` (n, 2) comes onto `goal`."""
    turn = np.diff(goal)[:, 0] / np.diff(start)[:, 0]
    turn /= np.abs(turn)
    shift = goal.mean(axis=1) - turn * start.mean(axis=1)
    points, index = shapely.get_coordinates(shapes, return_index=True)
    z = (points @ [1, 1j]) * turn[index] + shift[index]
    rings = shapely.linearrings(np.column_stack([z.real, z.imag]), indices=index)
    out: np.ndarray = shapely.polygons(rings)
    return out


def _piece(
    sheet: Sheet,
    number: int,
    faces: IntArray,
    seams: _Seams,
    side: IntArray,
    tops: FloatArray,
    settings: SheetSplit,
) -> Piece:
    """The pattern of a set of faces and its tabs, laid upright, and what is engraved on it."""
    pattern = sheet.pattern
    sizes = np.diff(pattern.faces_offsets)[faces]
    mine = np.zeros(pattern.face_count, bool)
    mine[faces] = True
    old = pattern.faces_vertices[np.repeat(mine, np.diff(pattern.faces_offsets))]
    used, corners = np.unique(old, return_inverse=True)
    carried = np.flatnonzero((side >= 0) & (seams.pieces[np.arange(len(side)), side] == number))
    a, b = np.searchsorted(used, seams.vertices[carried, side[carried]]).reshape(-1, 2).T
    p = len(used) + 2 * np.arange(len(carried))
    corners = np.concatenate([corners, np.column_stack([b, a, p, p + 1]).ravel()])
    offsets = np.concatenate([[0], np.cumsum(np.concatenate([sizes, np.full(len(a), 4)]))])
    edges = edges_of(corners, offsets)
    coords = np.concatenate([pattern.vertices_coords[used], tops[carried].reshape(-1, 2)])
    turn, fits = upright(coords, sheet.room_mm)
    if not fits:  # the turn that the partition found, with room for all tabs
        turn, _ = upright(extent(sheet, faces), sheet.room_mm)
    coords = coords @ turn.T
    coords -= coords.min(axis=0)
    whole = _whole_edges(pattern, used, mine, edges.edges_vertices)
    letter = np.where(edges.edges_faces[:, 1] < 0, "B", "F")
    angle = np.zeros(len(whole))
    inner = (edges.edges_faces[:, 1] >= 0) & (edges.edges_faces[:, 1] < len(faces))
    letter[inner] = pattern.edges_assignment[whole[inner]]
    angle[inner] = pattern.edges_foldAngle[whole[inner]]
    at = _numbers_of(whole, seams.edges[carried, side[carried]])
    angle[at] = seams.angle[carried]
    letter[at] = np.where(angle[at] > 0, "V", np.where(angle[at] < 0, "M", "F"))
    folded = pattern.folded_coords
    if folded is not None:
        folded = np.concatenate([folded[used], _folded_tops(pattern, seams, side, tops, carried)])
    own = CreasePattern(
        coords, edges.edges_vertices, edges.edges_faces, letter, angle, corners, offsets, folded
    )
    numbers = np.concatenate([faces, np.full(len(a), -1)])
    texts, labels = _labels(own, number, numbers, whole, seams, carried, side, settings)
    return Piece(
        piece_name(number),
        own,
        numbers,
        whole,
        tuple(label for label in labels if label is not None),
        tuple(text for text, label in zip(texts, labels, strict=False) if label is None),
    )


def _whole_edges(
    pattern: CreasePattern, used: IntArray, mine: np.ndarray, ends: IntArray
) -> IntArray:
    """Numbers in the whole pattern of a piece's edges, -1 for the sides of tabs."""
    count = len(used)
    near = np.flatnonzero(np.append(mine, False)[pattern.edges_faces].any(axis=1))
    old = np.searchsorted(used, np.sort(pattern.edges_vertices[near], axis=1))
    key = old[:, 0] * count + old[:, 1]
    order = np.argsort(key)
    low, high = np.sort(ends, axis=1).T
    wanted = np.where(high < count, low * count + high, -1)
    place = np.minimum(np.searchsorted(key[order], wanted), len(key) - 1)
    return np.where(key[order][place] == wanted, near[order][place], -1)


def _numbers_of(whole: IntArray, edges: IntArray) -> IntArray:
    """Where a piece has the given edges of the whole pattern."""
    order = np.argsort(whole, kind="stable")
    out: IntArray = order[np.searchsorted(whole[order], edges)]
    return out


def _folded_tops(
    pattern: CreasePattern, seams: _Seams, side: IntArray, tops: FloatArray, carried: IntArray
) -> FloatArray:
    """Folded corners of tabs: each lies in the plane of the face that it is glued to."""
    folded = pattern.folded_coords
    assert folded is not None  # the caller's promise
    ends = seams.vertices[carried, side[carried]]
    flat_a, flat_b = pattern.vertices_coords[ends].swapaxes(0, 1)
    a, b = folded[ends].swapaxes(0, 1)
    normals = face_normals(folded, pattern.faces_vertices, pattern.faces_offsets)
    normal = normals[seams.faces[carried, 1 - side[carried]]]
    span = flat_b - flat_a
    u = span / np.hypot(*span.T)[:, None]
    arm = tops[carried] - flat_a[:, None]
    along = (arm * u[:, None]).sum(axis=2)
    out = (arm * np.column_stack([u[:, 1], -u[:, 0]])[:, None]).sum(axis=2)
    x = unit(b - a)
    y = cross(x, normal)  # away from the piece, in the other face
    points = a[:, None] + along[..., None] * x[:, None] + out[..., None] * y[:, None]
    flat: FloatArray = points.reshape(-1, 3)
    return flat


def _labels(
    own: CreasePattern,
    number: int,
    faces: IntArray,
    whole: IntArray,
    seams: _Seams,
    carried: IntArray,
    side: IntArray,
    settings: SheetSplit,
) -> tuple[list[str], tuple[Label | None, ...]]:
    """The piece's name in the face with most room, and each seam's number beside its edge.

    What is to be written, and the labels as far as there is room, after them numbers on tabs too.
    """
    rooms = [
        shapely.polygons(own.vertices_coords[own.faces_vertices[i:j]])
        for i, j in zip(own.faces_offsets[:-1], own.faces_offsets[1:], strict=True)
    ]
    real = int((faces >= 0).sum())
    seam, bank = np.nonzero(seams.pieces == number)
    edge = _numbers_of(whole, seams.edges[seam, bank])
    face = own.edges_faces[edge, 0]
    ends = own.vertices_coords[own.edges_vertices[edge]]
    # on a tab the text stands below the seam
    tab = real + np.arange(len(carried))
    tab_edge = _numbers_of(whole, seams.edges[carried, side[carried]])
    tab_ends = own.vertices_coords[own.edges_vertices[tab_edge]][:, ::-1]
    lines = np.concatenate([ends, tab_ends])
    direction = lines[:, 1] - lines[:, 0]
    name = piece_name(number)
    widest, middle, slant = _place_for(name, rooms[:real], face)
    texts = [name, *(number_text(s + 1) for s in seam.tolist())]
    anchors = np.concatenate([middle[None], lines.mean(axis=1)])
    angles = np.concatenate([[slant], np.arctan2(direction[:, 1], direction[:, 0])])
    height = np.full(len(anchors), settings.label_mm)
    height[0] *= 2
    hang = np.ones(len(anchors))
    hang[0] = 0.0
    space = [rooms[f] for f in [widest, *face.tolist(), *tab.tolist()]]
    on_tabs = [number_text(s + 1) for s in carried.tolist()]
    return texts, fitted([*texts, *on_tabs], anchors, angles, space, height, hang, _READABLE_MM)


def _place_for(
    text: str, rooms: list[shapely.Polygon], beside_seams: IntArray
) -> tuple[int, FloatArray, float]:
    """The face in which a text may be highest, the text's middle, and its slant in radians.

    Faces without seams come first, as long as letters there are half as high.
    """
    shapes = np.asarray(rooms)
    large = np.argsort(-shapely.area(shapes), kind="stable")[:_MOST_TRIED]
    near = 0.1 * shapely.area(shapes[large]) / shapely.length(shapes[large])
    disks = shapely.maximum_inscribed_circle(shapes[large], tolerance=near)
    middles = shapely.get_coordinates(disks)[::2]
    best = (0.0, int(large[0]), middles[0], 0.0)
    for face, middle in zip(large.tolist(), middles, strict=True):
        side = np.diff(shapely.get_coordinates(shapely.oriented_envelope(shapes[face])), axis=0)
        along = side[np.argmax(np.hypot(*side.T))]
        for slant in (0.0, float(np.arctan(along[1] / along[0])) if along[0] else np.pi / 2):
            height = highest(text, middle, slant, shapes[face])
            if face in beside_seams:
                height /= 2
            if height > best[0] * (1 + 1e-9):
                best = (height, face, middle, slant)
    return best[1:]


def _numbered(
    pattern: CreasePattern, pieces: Sequence[Piece], seams: _Seams, side: IntArray
) -> tuple[Seam, ...]:
    """The seams, with the numbers of their edges in both pieces."""
    ends = pattern.vertices_coords[pattern.edges_vertices[seams.edges[:, 0]]]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    own = np.full(seams.edges.shape, -1)
    for number, piece in enumerate(pieces):
        seam, bank = np.nonzero(seams.pieces == number)
        own[seam, bank] = _numbers_of(piece.edges, seams.edges[seam, bank])
    return tuple(
        Seam(i + 1, (e, f), (p, q), (u, v), size, angle, None if tab < 0 else tab)
        for i, ((e, f), (p, q), (u, v), size, angle, tab) in enumerate(
            zip(
                seams.edges.tolist(),
                seams.pieces.tolist(),
                own.tolist(),
                length.tolist(),
                seams.angle.tolist(),
                side.tolist(),
                strict=True,
            )
        )
    )


def _findings(made: Pieces, settings: SheetSplit) -> list[Finding]:
    findings = []
    if len(made.pieces) > 1:
        text = (
            f"the sheet is cut into {len(made.pieces)} pieces with {len(made.seams)} seam edges. "
            "Glue them in the order of their labels."
            if made.seams
            else f"the sheet comes apart into {len(made.pieces)} pieces without seams: there is "
            "nothing to glue."
        )
        findings.append(Finding("sheet-split", Severity.NOTE, text))
    bare = [seam.edges[0] for seam in made.seams if seam.tab is None]
    if bare and settings.tabs:
        text = (
            f"{len(bare)} of {len(made.seams)} seam edges have no room for a tab. Join them with "
            "tape, lower tab_mm, or enlarge the sheet."
        )
        findings.append(
            Finding("tab-no-room", Severity.WARNING, text, creases=tuple(bare[:_MOST_NAMED]))
        )
    missing = sum(len(piece.unwritten) for piece in made.pieces)
    if missing and made.labelled:
        text = (
            f"{missing} labels are left out: on their faces is no room for letters of "
            f"{_READABLE_MM:g} mm. Enlarge the sheet to have them engraved; the report lists the "
            "seams of all pieces."
        )
        findings.append(Finding("label-too-small", Severity.WARNING, text))
    return findings
