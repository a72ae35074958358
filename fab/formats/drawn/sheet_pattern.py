"""The crease pattern of faces and the lines around and within them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fab.errors import Finding, InvalidFile, Severity, first_few
from fab.formats.drawn.crease_letters import lettered
from fab.formats.drawn.fold_angles import with_fold_angles
from fab.formats.drawn.lines import Faces, Lines, places_of
from fab.formats.read_options import ReadOptions
from fab.pattern.crease_pattern import CreasePattern, fold_angles_deg
from solver.errors import InvalidValue
from solver.mesh import Edges, edges_of
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["SheetPattern", "sheet_pattern"]


@dataclass(frozen=True)
class SheetPattern:
    """A pattern, and where its parts come from.

    Attributes
    ----------
    lines : all edges, in the order of the pattern's.
    edges : the sides of the faces, the first of the pattern's edges.
    used : which of the vertices of the lines are the pattern's, shape (nv,).
    origin : the pattern's lower left corner in the drawing, mm, shape (2,).
    """

    pattern: CreasePattern
    lines: Lines
    edges: Edges
    used: BoolArray
    origin: FloatArray
    findings: tuple[Finding, ...]


def sheet_pattern(
    lines: Lines,
    faces: Faces,
    around: Callable[[Lines, IntArray], IntArray],
    folded: FloatArray | None,
    options: ReadOptions,
    *,
    none_given: str,
) -> SheetPattern:
    """The pattern of faces, its lower left corner at the origin.

    around : of the lines, sides of faces first, and the faces of these, shape (m, 2), gives the
    face that each of the others is in. folded : points of the folded form, shape (nv, 3), mm.
    none_given : see `with_fold_angles`.
    """
    edges = edges_of(faces.corners, faces.offsets)
    source = _places(lines, edges.edges_vertices)
    loose = np.ones(len(lines.pairs), bool)
    loose[source] = False
    lines = lines.part(np.concatenate([source, np.flatnonzero(loose)]))
    if lines.element is not None:  # findings number them as the pattern does
        lines = replace(lines, number=np.arange(len(lines.pairs)))
    within = around(lines, edges.edges_faces)
    count = len(source)
    rest = np.arange(count, len(lines.pairs))
    _refuse_open(lines, rest)
    findings = []
    if len(rest):
        several = len(rest) > 1
        text = (
            f"{lines.named(rest)} {'end' if several else 'ends'} within a face: "
            f"{'they' if several else 'it'} can be cut, but not folded flat."
        )
        findings.append(_about("crease-dangling", Severity.WARNING, text, lines, rest))
    edges_faces = np.concatenate([edges.edges_faces, np.column_stack([within, within])])
    alone = edges_faces[:, 1] < 0
    measured = None
    if folded is not None:
        measured = np.full(len(lines.pairs), np.nan)
        measured[:count] = _measured(lines, faces, edges, folded)
    lines, found = with_fold_angles(lines, alone, measured, options, none_given=none_given)
    findings += found
    lines, found = _with_borders(lines, alone, options)
    findings += found
    edges_vertices = np.concatenate([edges.edges_vertices, lines.pairs[count:]])
    used = np.zeros(len(lines.coords), bool)
    used[edges_vertices] = True
    place = np.cumsum(used) - 1
    coords = lines.coords[used]
    origin = coords.min(axis=0)
    pattern = CreasePattern(
        coords - origin,
        place[edges_vertices],
        edges_faces,
        lines.letters,
        np.where(np.isin(lines.letters, ["M", "V", "U"]), lines.angles, 0.0),
        place[faces.corners],
        faces.offsets,
        None if folded is None else folded[used],
    )
    if folded is None:
        pattern, found = lettered(pattern, lines, origin, options)
        findings += found
        lines = replace(lines, letters=pattern.edges_assignment, angles=pattern.edges_foldAngle)
    return SheetPattern(pattern, lines, edges, used, origin, tuple(findings))


def _about(code: str, severity: Severity, text: str, lines: Lines, rows: IntArray) -> Finding:
    creases, places = first_few(np.sort(lines.number[rows])), places_of(lines.middles(rows))
    return Finding(code, severity, text, creases=creases, places=places)


def _places(lines: Lines, sides: IntArray) -> IntArray:
    """Which of the lines each side of the faces is."""
    keys, wanted = lines.keys(), lines.keys(sides)
    order = np.argsort(keys)
    place: IntArray = order[np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)]
    lacking = np.flatnonzero(keys[place] != wanted)
    if len(lacking):
        first, second = sides[lacking[0]]
        raise InvalidFile(
            f"{lines.path}: edges_vertices lacks the side ({first}, {second}) of a face. Add it."
        )
    return place


def _refuse_open(lines: Lines, rest: IntArray) -> None:
    """Raise `InvalidFile` where one of the lines that are sides of no face is a border."""
    borders = rest[lines.letters[rest] == "B"]
    if len(borders):
        raise InvalidFile(
            f"{lines.path}: the outline is open at {lines.name(int(borders[0]))}, near "
            f"{lines.place(int(borders[0]))}. Close it, or make the edge a cut (C)."
        )


def _measured(lines: Lines, faces: Faces, edges: Edges, folded: FloatArray) -> FloatArray:
    try:
        return fold_angles_deg(folded, edges, faces.corners, faces.offsets)
    except InvalidValue as error:
        raise InvalidFile(f"{lines.path}: folded form: {error}") from error


def _with_borders(
    lines: Lines, alone: BoolArray, options: ReadOptions
) -> tuple[Lines, list[Finding]]:
    """The lines with B on all that have one face, and on no others."""
    findings = []
    unmarked = np.flatnonzero(alone & (lines.letters != "B"))
    if len(unmarked):
        text = f"{lines.named(unmarked)} with a face on one side alone: taken for border (B)."
        findings.append(_about("border-unmarked", Severity.WARNING, text, lines, unmarked))
    inside = np.flatnonzero(~alone & (lines.letters == "B"))
    if len(inside):
        if options.inner_border != "cut":
            row = int(inside[0])
            raise InvalidFile(
                f"{lines.path}: {lines.name(row)}, near {lines.place(row)}, is a border (B) with "
                "faces on both sides. Make it a crease or a cut (C), or give --inner-border cut."
            )
        names = lines.named(inside).removesuffix(",")
        text = f"{names}: a border with faces on both sides is taken for a cut (C)."
        findings.append(_about("border-inside", Severity.WARNING, text, lines, inside))
    letters = np.where(alone, "B", np.where(lines.letters == "B", "C", lines.letters))
    return replace(lines, letters=letters), findings
