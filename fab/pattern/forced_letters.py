"""Letters of creases that have none, where flat folding leaves one possibility only.

At every interior vertex the assignments that fold it flat are listed (`flat_foldability`), those
that contradict known letters are struck out, and what the others agree on becomes known, from
vertex to vertex until nothing changes. Only conditions that are necessary are used, so that every
flat folding of the sheet has the letters that are found.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.flat_foldability import balanced_letters, foldable_letters, kawasaki_rad
from fab.pattern.sectors import sectors_of
from solver.graphs import labels
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["KAWASAKI_RAD", "ForcedLetters", "forced_letters", "with_letters"]

# A vertex whose sectors miss Kawasaki's condition by more does not fold flat. Files have their
# points with a few digits.
KAWASAKI_RAD = 1e-3
# At vertices of more creases Maekawa's condition alone is used.
_MOST_CREASES = 12


@dataclass(frozen=True)
class ForcedLetters:
    """What flat folding says of the creases without a letter (U).

    Attributes
    ----------
    edges, letters : creases that can have one letter only, and that letter, shapes (k,).
    free : number of creases that stay without one.
    open_vertices : interior vertices with such creases at which Kawasaki's condition fails.
    contradictory : vertices at which no letters agree with the known ones, or with what follows
        from them. Nothing is concluded there, nor from creases that depend on each other through
        them.
    """

    edges: IntArray
    letters: np.ndarray
    free: int
    open_vertices: IntArray
    contradictory: IntArray


def forced_letters(pattern: CreasePattern, fold_deg: float = 180.0) -> ForcedLetters:
    """The letters that follow from those that a pattern has.

    fold_deg : what creases of the pattern fold by. A vertex with a crease of another angle is not
        one that folds flat; nothing is concluded there.
    """
    letters, angles = pattern.edges_assignment, pattern.edges_foldAngle
    unknown = pattern.edges_joining & (letters == "U") & (np.abs(angles) <= FLAT_ANGLE_DEG)
    vertices, open_vertices = _vertices(pattern, unknown, fold_deg)
    may = np.ones((2, len(letters)), bool)  # be a mountain, a valley
    known = ~unknown
    may[0, known] = (letters[known] == "M") | ((letters[known] == "U") & (angles[known] < 0))
    may[1, known] = (letters[known] == "V") | ((letters[known] == "U") & (angles[known] > 0))
    agreeing = [group.agrees(may) for group in vertices]
    wrong = [group.vertices[~own] for group, own in zip(vertices, agreeing, strict=True)]
    vertices = [group.part(own) for group, own in zip(vertices, agreeing, strict=True)]
    may, later = _followed(vertices, may, unknown)
    edges = np.flatnonzero(unknown & (may[0] != may[1]))
    return ForcedLetters(
        edges,
        np.where(may[1, edges], "V", "M"),
        int(unknown.sum()) - len(edges),
        open_vertices,
        np.unique(np.concatenate([*wrong, later])),
    )


def with_letters(
    pattern: CreasePattern, forced: ForcedLetters, fold_deg: float = 180.0
) -> CreasePattern:
    """The pattern with the letters that were found; these creases fold by `fold_deg`."""
    letters, angles = pattern.edges_assignment.copy(), pattern.edges_foldAngle.copy()
    letters[forced.edges] = forced.letters
    angles[forced.edges] = np.where(forced.letters == "V", fold_deg, -fold_deg)
    return replace(pattern, edges_assignment=letters, edges_foldAngle=angles)


@dataclass(frozen=True)
class _Vertices:
    """Interior vertices with equally many creases, and the letters that fold them flat.

    Attributes
    ----------
    vertices, creases : shapes (k,) and (k, n), counterclockwise.
    listed : which of `balanced_letters` fold them flat, shape (k, a); None for so many creases
        that these are not listed.
    """

    vertices: IntArray
    creases: IntArray
    listed: BoolArray | None

    def part(self, which: BoolArray) -> _Vertices:
        """Some of the vertices."""
        listed = None if self.listed is None else self.listed[which]
        return _Vertices(self.vertices[which], self.creases[which], listed)

    def agrees(self, may: BoolArray) -> BoolArray:
        """Whether some letters fold each vertex flat, shape (k,); may : shape (2, ne)."""
        return _some(self.choices(may))

    def choices(self, may: BoolArray) -> BoolArray:
        """Which letters (M, V) each crease has in foldings of its vertex, shape (2, k, n)."""
        own = may[:, self.creases]
        if self.listed is None:
            return self._balanced(own)
        valleys = balanced_letters(self.creases.shape[1]).astype(np.float32)
        barred = (~own).astype(np.float32)
        left = self.listed & (barred[0] @ (1 - valleys).T + barred[1] @ valleys.T == 0)
        agreeing = left.astype(np.float32)
        return np.stack([agreeing @ (1 - valleys) > 0, agreeing @ valleys > 0])

    def _balanced(self, own: BoolArray) -> BoolArray:
        """As `choices`, by Maekawa's condition alone."""
        half = self.creases.shape[1] // 2
        least = (own[1] & ~own[0]).sum(axis=1)  # valleys
        most = own[1].sum(axis=1)
        more, fewer = half + 1, half - 1
        possible = np.asarray(own[0] | own[1]).all(axis=1)
        possible &= ((least <= more) & (more <= most)) | ((least <= fewer) & (fewer <= most))
        # an undecided crease can be a valley unless all sums need it as a mountain, and vice versa
        valley = np.where(more <= most, more, fewer) > least
        mountain = np.where(fewer >= least, fewer, more) < most
        undecided = own.all(axis=0)
        return np.stack(
            [
                own[0] & possible[:, None] & (~undecided | mountain[:, None]),
                own[1] & possible[:, None] & (~undecided | valley[:, None]),
            ]
        )


def _vertices(
    pattern: CreasePattern, unknown: BoolArray, fold_deg: float
) -> tuple[list[_Vertices], IntArray]:
    """Vertices that can say something, by number of creases, and those that do not fold flat."""
    letters = pattern.edges_assignment
    creases = pattern.edges_joining & np.isin(letters, ["M", "V", "U"])
    sectors = sectors_of(pattern, creases)
    count = len(pattern.vertices_coords)
    other = np.abs(np.abs(pattern.edges_foldAngle) - fold_deg) > FLAT_ANGLE_DEG
    barred = (pattern.edges_faces[:, 1] < 0) | (letters == "C") | (creases & ~unknown & other)
    usable = np.abs(_paper_around(pattern) - 2 * np.pi) <= KAWASAKI_RAD
    usable[pattern.edges_vertices[barred]] = False
    asked = np.zeros(count, bool)
    asked[pattern.edges_vertices[unknown]] = True
    asked &= usable
    vertex, first, degree = np.unique(sectors.vertices, return_index=True, return_counts=True)
    own = asked[vertex]
    open_vertices = [vertex[own & (degree % 2 == 1)]]
    groups = []
    for size in np.unique(degree[own & (degree % 2 == 0)]).tolist():
        chosen = np.flatnonzero(own & (degree == size))
        place = first[chosen][:, None] + np.arange(size)
        angles = sectors.angles[place]
        flat = kawasaki_rad(angles) <= KAWASAKI_RAD
        open_vertices.append(vertex[chosen[~flat]])
        listed = foldable_letters(angles[flat], KAWASAKI_RAD) if size <= _MOST_CREASES else None
        groups.append(_Vertices(vertex[chosen[flat]], sectors.edges[place[flat]], listed))
    nothing = _Vertices(vertex[:0], np.empty((0, 2), np.int64), np.empty((0, 2), bool))
    return groups or [nothing], np.sort(np.concatenate(open_vertices))


def _paper_around(pattern: CreasePattern) -> FloatArray:
    """Sum of the angles of the faces at every vertex, radians, shape (nv,)."""
    corners, following = pattern.faces_vertices, next_corner(pattern.faces_offsets)
    side = pattern.vertices_coords[corners[following]] - pattern.vertices_coords[corners]
    direction = np.arctan2(side[:, 1], side[:, 0])
    turn = direction[following] - direction
    turn -= 2 * np.pi * np.round(turn / (2 * np.pi))
    within = np.bincount(corners[following], np.pi - turn, len(pattern.vertices_coords))
    return np.asarray(within, np.float64)


def _followed(
    vertices: list[_Vertices], may: BoolArray, unknown: BoolArray
) -> tuple[BoolArray, IntArray]:
    """What creases may be in the end, shape (2, ne), and vertices that contradict the others.

    Creases that depend on each other through such a vertex stay as they were.
    """
    linked = _linked(vertices, unknown)
    count = len(unknown)
    bad = np.zeros(len(linked), bool)
    contradictory = [np.empty(0, np.int64)]
    changed = np.ones(count, bool)
    while changed.any():
        after = may.copy()
        for group in vertices:
            asked = group.part(_some(changed[None, group.creases]))
            choices = asked.choices(may)
            failed = asked.vertices[~_some(choices)]
            contradictory.append(failed)
            bad[linked[count + failed]] = True
            for letter in range(2):
                np.logical_and.at(after[letter], asked.creases, choices[letter])
        after[:, ~unknown] = may[:, ~unknown]
        none = ~(after[0] | after[1])
        bad[linked[:count][none]] = True
        contradictory += [v.vertices[none[v.creases].any(axis=1)] for v in vertices]
        lost = bad[linked]
        after[:, lost[:count] & unknown] = True
        vertices = [group.part(~lost[count + group.vertices]) for group in vertices]
        changed = np.asarray((after != may).any(axis=0) & ~lost[:count], np.bool_)
        may = after
    return may, np.concatenate(contradictory)


def _some(choices: BoolArray) -> BoolArray:
    """Where any of choices of shape (m, k, n) is true, shape (k,)."""
    return np.asarray(np.any(choices, axis=(0, 2)), np.bool_)


def _linked(vertices: list[_Vertices], unknown: BoolArray) -> IntArray:
    """A number for each crease and then for each vertex, equal where they depend on each other.

    Known creases depend on nothing.
    """
    count = len(unknown)
    pairs, most = [np.empty((0, 2), np.int64)], 0
    for group in vertices:
        row, column = np.nonzero(unknown[group.creases])
        vertex = group.vertices[row]
        pairs.append(np.column_stack([group.creases[row, column], count + vertex]))
        most = max(most, int(group.vertices.max(initial=-1)) + 1)
    return labels(np.concatenate(pairs), count + most)
