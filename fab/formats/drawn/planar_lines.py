"""Lines of a file as the edges of a planar graph, each with the strongest of its letters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fab.errors import InvalidFile, Severity, counted
from fab.formats.drawn.line_soup import UNLETTERED, Letters
from fab.formats.drawn.lines import Lines, Repair
from fab.formats.drawn.tolerance import Tolerance
from fab.geometry.arrangement import Arrangement, arrangement
from solver.errors import InvalidState
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["DrawnLines", "PlanarLines", "planar_lines", "ranks_of"]

# Which of two letters in one place says more.
_RANK = {letter: rank for rank, letter in enumerate(UNLETTERED + "JUFVMCB")}
# Of the diagonal: moved by less, an end is where it was.
_MOVED_REL = 1e-8


@dataclass(frozen=True)
class DrawnLines:
    """Lines in millimetres before they are a planar graph.

    Attributes
    ----------
    coords : shape (n, 2, 2). named : pairs are rows; what each is called, its letter and angle.
    vertices : numbers of the vertices at both ends, shape (n, 2), where the file numbers them.
    """

    coords: FloatArray
    named: Lines
    vertices: IntArray | None = None


@dataclass(frozen=True)
class PlanarLines:
    """Edges of the planar graph.

    Attributes
    ----------
    lines : the edges; `planar` counts them.
    graph : the arrangement that they are of, its vertices in the order of those of the file.
    borders_twice : which edges are drawn as borders by two lines or more, shape (ne,).
    """

    lines: Lines
    graph: Arrangement
    borders_twice: BoolArray
    repairs: tuple[Repair, ...]


def ranks_of(letters: Letters) -> IntArray:
    """How much each letter says, shape (n,); the least is that of lines without a letter."""
    known = sorted(_RANK)
    return np.array([_RANK[letter] for letter in known])[np.searchsorted(known, letters)]


def planar_lines(drawn: DrawnLines, tolerance: Tolerance) -> PlanarLines:
    """The planar graph of drawn lines. What was changed to get there is in its repairs.

    Raises `InvalidFile` for mountains in the places of valleys, for too many crossings, and where
    the tolerance is too large for the drawing.
    """
    named = drawn.named
    try:
        graph = arrangement(drawn.coords, tolerance.reach)
    except InvalidState as error:
        raise InvalidFile(f"{named.path}: {error}") from error
    if not graph.settled:
        raise InvalidFile(
            f"{named.path}: its lines are too close to each other for a tolerance of "
            f"{tolerance.mm:.4g} mm. Give a smaller --merge-mm."
        )
    if drawn.vertices is not None:
        graph = _in_order(graph, drawn.vertices)
    line, edge = graph.line_pairs
    ranks = ranks_of(named.letters)
    order = np.lexsort((line, -ranks[line], edge))
    first = np.ones(len(order), bool)
    first[1:] = np.diff(edge[order]) > 0
    strongest = line[order][first]
    letters = named.letters[strongest]
    angles = named.angles[strongest].copy()
    alike = np.flatnonzero(
        np.isnan(angles[edge])
        & ~np.isnan(named.angles[line])
        & (named.letters[line] == letters[edge])
    )
    angles[edge[alike[::-1]]] = named.angles[line[alike[::-1]]]
    lines = replace(
        named.part(strongest),
        coords=graph.vertices_coords,
        pairs=graph.edges_vertices,
        angles=angles,
        planar=np.arange(len(strongest)),
    )
    count = len(strongest)
    has = {
        letter: np.bincount(edge, named.letters[line] == letter, minlength=count)
        for letter in "MVB"
    }
    both = np.flatnonzero((has["M"] > 0) & (has["V"] > 0) & (letters == "M"))
    if len(both):
        _refuse_both(named, graph, int(both[0]), len(both))
    repairs = _repairs(named, lines, graph, tolerance)
    return PlanarLines(lines, graph, has["B"] > 1, tuple(repairs))


def _in_order(graph: Arrangement, vertices: IntArray) -> Arrangement:
    """The graph with its vertices in the order of the file's, new ones last."""
    count = len(graph.vertices_coords)
    rank = np.full(count, int(vertices.max()) + 1)
    named = graph.ends_vertex >= 0
    np.minimum.at(rank, graph.ends_vertex[named], vertices[named])
    order = np.lexsort((np.arange(count), rank))
    new = np.empty(count + 1, np.int64)
    new[order], new[-1] = np.arange(count), -1
    return replace(
        graph,
        vertices_coords=graph.vertices_coords[order],
        edges_vertices=new[graph.edges_vertices],
        ends_vertex=new[graph.ends_vertex],
    )


def _refuse_both(named: Lines, graph: Arrangement, edge: int, count: int) -> None:
    lines = graph.edges_lines[graph.edges_offsets[edge] : graph.edges_offsets[edge + 1]]
    mountain, valley = (
        int(lines[np.flatnonzero(named.letters[lines] == letter)[0]]) for letter in "MV"
    )
    places = graph.vertices_coords[graph.edges_vertices[edge]]
    more = f" and {count - 1} more of these" if count > 1 else ""
    raise InvalidFile(
        f"{named.path}: {named.name(mountain)} is a mountain and {named.name(valley)} a valley in "
        f"the same place, from {named.point(places[0])} to {named.point(places[1])}{more}. Remove "
        "one of them."
    )


def _repairs(named: Lines, lines: Lines, graph: Arrangement, tolerance: Tolerance) -> list[Repair]:
    """What is reported of lines that became edges."""
    size = float(np.hypot(*np.ptp(graph.lines_coords.reshape(-1, 2), axis=0)))
    within = f"(tolerance {tolerance.mm:.4g} mm: {tolerance.reason})"
    line, edge = graph.line_pairs
    row_of = np.full(len(graph.lines_coords), -1)
    row_of[line[::-1]] = edge[::-1]
    crossings, joints = graph.crossings()
    at_joint = np.isin(graph.ends_vertex, joints)
    moved = graph.ends_moved
    out = []
    for code, chosen, what in (
        ("ends-joined", (moved > _MOVED_REL * size) & ~at_joint, "joined to others"),
        ("ends-extended", (moved > _MOVED_REL * size) & at_joint, "moved onto lines"),
    ):
        own, end = np.nonzero(chosen)
        if len(own):
            point = graph.lines_coords[own[0], end[0]]
            text = (
                f"{counted(len(own), 'end')} of lines {what} up to {moved[chosen].max():.4g} mm "
                f"away, the first of {named.name(own[0])} at {named.point(point)} {within}."
            )
            edges = row_of[np.unique(own)]
            places = graph.lines_coords[own, end]
            out.append(Repair(code, Severity.WARNING, text, edges[edges >= 0], places))
    split = np.union1d(crossings, joints)
    if len(split):
        parts = [
            counted(len(found), single, several)
            for found, single, several in (
                (crossings, "crossing", "crossings"),
                (joints, "end on another line", "ends on other lines"),
            )
            if len(found)
        ]
        first = named.point(graph.vertices_coords[split[0]])
        text = f"lines are split at {' and '.join(parts)}, the first at {first}."
        edges = np.flatnonzero(np.isin(graph.edges_vertices, split).any(axis=1))
        places = graph.vertices_coords[split]
        out.append(Repair("lines-split", Severity.NOTE, text, edges, places))
    bent = _bends(graph)
    if len(bent[0]) and bent[1].max() > tolerance.mm * 1e-3 and bent[1].max() > _MOVED_REL * size:
        worst = int(np.argmax(bent[1]))
        text = (
            "lines that pass each other's ends or crossings nearly in one point meet there, bent "
            f"by up to {bent[1][worst]:.4g} mm, at "
            f"{named.point(graph.vertices_coords[bent[0][worst]])} {within}."
        )
        edges = np.flatnonzero((graph.edges_vertices == bent[0][worst]).any(axis=1))
        places = graph.vertices_coords[bent[0][[worst]]]
        out.append(Repair("lines-bent", Severity.NOTE, text, edges, places))
    repeated = np.flatnonzero(graph.repeated())
    if len(repeated):
        kept = lines.letters[row_of[repeated[0]]]
        middle = named.point(graph.lines_coords[repeated[0]].mean(axis=0))
        text = (
            f"{counted(len(repeated), 'line')} on others from end to end, the first "
            f"{named.name(repeated[0])} at {middle}: "
            f"taken once, as {kept}, the strongest letter there."
        )
        places = graph.lines_coords[repeated].mean(axis=1)
        out.append(Repair("duplicate-line", Severity.WARNING, text, row_of[repeated], places))
    shared = np.flatnonzero(graph.edges_count > 1)
    shared = shared[~np.isin(shared, edge[np.isin(line, repeated)])]
    if len(shared):
        one = int(shared[0])
        start, end = graph.vertices_coords[graph.edges_vertices[one]]
        owners = graph.edges_lines[graph.edges_offsets[one] :][:2]
        text = (
            f"{named.name(owners[0])} and {named.name(owners[1])} lie on each other from "
            f"{named.point(start)} to {named.point(end)}: one edge, {lines.letters[one]}"
            + (f"; {counted(len(shared) - 1, 'more place')} alike." if len(shared) > 1 else ".")
        )
        out.append(Repair("lines-overlap", Severity.WARNING, text, shared, lines.middles(shared)))
    lost = np.flatnonzero(row_of < 0)
    if len(lost):
        point = graph.lines_coords[lost[0], 0]
        text = (
            f"{counted(len(lost), 'line')} shorter than the tolerance, the first "
            f"{named.name(lost[0])} at {named.point(point)}: removed {within}."
        )
        places = graph.lines_coords[lost, 0]
        out.append(Repair("zero-length-line", Severity.WARNING, text, lost[:0], places))
    return out


def _bends(graph: Arrangement) -> tuple[IntArray, FloatArray]:
    """Vertices that lines pass, and how far each is from the line as it was drawn."""
    vertex, line = graph.passes()
    start, end = graph.lines_coords[line].swapaxes(0, 1)
    span, arm = end - start, graph.vertices_coords[vertex] - start
    length = np.hypot(*span.T)
    off = np.abs(span[:, 0] * arm[:, 1] - span[:, 1] * arm[:, 0]) / np.where(length > 0, length, 1)
    return vertex, off
