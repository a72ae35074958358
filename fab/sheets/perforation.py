"""Perforation: the lines that the cutter runs along to make creases, relief holes and outlines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fab.drawings.beam import Beam
from fab.drawings.cut_paths import CutPaths, Layer, Operation, chained, joined
from fab.errors import Finding
from fab.geometry.rings import is_hole
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.outlines import inner_cuts, outlines_of
from fab.sheets.crease_cuts import SHORTEST_CUT_MM, cuts_along, require_kerf
from fab.sheets.crease_findings import CREASE_NAMES, CutCreases, crease_findings
from fab.sheets.crease_styles import CreaseStyle, EngraveStyle, LatticeStyle, NoStyle
from fab.sheets.kerf import compensated
from fab.sheets.lattice_room import lattice_starts, meeting_lattices
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.relief_holes import ReliefHoles, relief_holes
from solver.errors import InvalidValue
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["CutPiece", "cut_layers", "cut_piece", "opening_cuts", "perforate"]

_BORDERS = ("B", "C")
_JOINED = "J"  # faces that are one: nothing is drawn between them


@dataclass(frozen=True)
class CutPiece:
    """A pattern as it is cut.

    Attributes
    ----------
    layers : one for each operation, in the order of the work.
    creases : what became of the creases, for `crease_findings`.
    findings : those of relief holes and outlines.
    """

    layers: tuple[Layer, ...]
    creases: CutCreases
    findings: tuple[Finding, ...]


def perforate(
    pattern: CreasePattern,
    settings: PerforationSettings,
    kerf_mm: float | Beam = 0.0,
    marks: Sequence[Layer] = (),
) -> tuple[CutPaths, list[Finding]]:
    """`cut_layers` and further `marks`, moved so that their lower left corner is (0, 0)."""
    layers, findings = cut_layers(pattern, settings, kerf_mm)
    layers = joined([*layers, *marks]) if marks else layers
    outlines = [ring for layer in layers for ring in layer.outlines]
    points = np.concatenate(outlines) if outlines else pattern.vertices_coords
    low, high = points.min(axis=0), points.max(axis=0)
    width, height = (high - low).tolist()
    moved = tuple(layer.moved(np.eye(2), -low) for layer in layers)
    return CutPaths(moved, (width, height)), findings


def cut_layers(
    pattern: CreasePattern, settings: PerforationSettings, kerf_mm: float | Beam = 0.0
) -> tuple[tuple[Layer, ...], list[Finding]]:
    """The layers of `cut_piece` for a pattern that is cut alone, and all findings of it."""
    cut = cut_piece(pattern, settings, kerf_mm)
    return cut.layers, [
        *cut.findings,
        *crease_findings([cut.creases], settings.margin_mm, kerf_mm),
    ]


def cut_piece(
    pattern: CreasePattern, settings: PerforationSettings, kerf_mm: float | Beam = 0.0
) -> CutPiece:
    """Perforated creases, relief and other holes, inner cuts and outlines, where the pattern is.

    kerf_mm : width of the beam, or the beam as it is in the pattern. Cuts on creases are drawn
        shorter by it, and outlines and relief holes are moved by half of it (`fab.sheets.kerf`);
        inner cuts stay.

    The layers of mountains, valleys and cuts are always present, the others where anything is on
    them. Cuts of flat and of unassigned creases are on the layer of valleys; marks of every
    assignment (style engrave) are on that of engravings. Edges with one face are outlines whatever
    their assignment, and edges assigned C or B between two faces are inner cuts.

    Cuts begin `margin_mm` after the vertex, or after the rim of its relief hole. Lattices begin
    later: `margin_mm` after the place where their outermost row meets the bisector of the sector
    beside it (or its wall, where that is an outline), so that neighbours cannot meet; those that
    meet other lines all the same, across a narrow face, stay uncut, and so do creases without room.

    Raises `InvalidValue` for unknown assignments, for a negative kerf, for one that joins cuts, and
    for too many cuts.
    """
    require_kerf(kerf_mm)
    lines = _lines(pattern, settings)
    holes = ReliefHoles(np.zeros(len(pattern.vertices_coords)), ())
    findings: list[Finding] = []
    if settings.relief is not None:
        holes, findings = relief_holes(
            pattern, lines.drawn, lines.walls, lines.marks, settings.relief
        )
    beam = Beam.of(kerf_mm)
    creases, layers = _cut_creases(pattern, lines, holes, settings.margin_mm, beam)
    borders = outlines_of(pattern)
    moved, relief = compensated(borders.rings, beam), compensated(holes.rings, beam)
    if holes.rings:
        layers.append(_through(Operation.RELIEF, relief.gaps, relief.rings))
    inner = tuple(ring for ring in moved.rings if is_hole(ring))
    if inner:
        layers.append(Layer(Operation.HOLE, outlines=inner))
    slits = np.concatenate([borders.slits, moved.gaps])
    outer = tuple(ring for ring in moved.rings if not is_hole(ring))
    layers.append(_through(Operation.CUT, slits, outer))
    return CutPiece(joined(layers), creases, (*findings, *moved.findings, *relief.findings))


def opening_cuts(openings: Sequence[FloatArray], kerf_mm: float | Beam) -> Layer:
    """Holes, each clockwise of shape (m, 2), as the beam follows them; narrow ones in one line."""
    moved = compensated(openings, kerf_mm)
    return _through(Operation.HOLE, moved.gaps, moved.rings)


def _through(operation: Operation, lines: FloatArray, outlines: tuple[FloatArray, ...]) -> Layer:
    """A layer of lines, shape (n, 2, 2), of which those that meet are chains, and outlines."""
    segments, chains = chained(lines)
    return Layer(operation, segments, outlines, chains)


@dataclass(frozen=True)
class _Lines:
    """What is drawn along the edges of a pattern.

    Attributes
    ----------
    styles : those that occur; style : the number of each edge's own, shape (ne,). Borders have the
        first, which is none.
    walls : which edges are outlines and inner cuts, shape (ne,).
    """

    styles: tuple[CreaseStyle, ...]
    style: IntArray
    walls: BoolArray

    @property
    def drawn(self) -> BoolArray:
        """Edges along which anything is drawn, shape (ne,)."""
        out: BoolArray = ~self._of_kind(NoStyle) | self.walls
        return out

    @property
    def marks(self) -> BoolArray:
        """Edges that are only engraved, shape (ne,)."""
        return self._of_kind(EngraveStyle)

    def _of_kind(self, kind: type[CreaseStyle]) -> BoolArray:
        out: BoolArray = np.array([isinstance(style, kind) for style in self.styles])[self.style]
        return out

    def band_widths_mm(self, across_mm: FloatArray) -> FloatArray:
        """Width of each edge's lattice as it is cut, 0 for other styles, shape (ne,).

        across_mm : of a cut along each edge, shape (ne,).
        """
        lattice = self._of_kind(LatticeStyle)
        widths = [s.width_mm if isinstance(s, LatticeStyle) else 0.0 for s in self.styles]
        return np.where(lattice, np.array(widths)[self.style] + across_mm, 0.0)

    def rooms_mm(self) -> FloatArray:
        """Length that each edge's room must exceed for its style to be cut, shape (ne,)."""
        rooms = [
            style.least_room_mm if isinstance(style, LatticeStyle) else SHORTEST_CUT_MM
            for style in self.styles
        ]
        return np.array(rooms)[self.style]


def _lines(pattern: CreasePattern, settings: PerforationSettings) -> _Lines:
    """The style of each edge. Raises `InvalidValue` for an unknown assignment."""
    letters = pattern.edges_assignment
    known = [*CREASE_NAMES, *_BORDERS, _JOINED]
    strange = np.flatnonzero(~np.isin(letters, known))
    if len(strange):
        raise InvalidValue(
            f"assignment of edge {strange[0]}",
            repr(str(letters[strange[0]])),
            f"be one of {', '.join(known)}",
            "Assign the edge, U where it is not known.",
        )
    styles: list[CreaseStyle] = [NoStyle()]
    number = np.zeros(len(letters), np.int64)
    for where, style in _chosen_styles(pattern, settings):
        if style not in styles:
            styles.append(style)
        number[where] = styles.index(style)
    walls = (pattern.edges_faces[:, 1] < 0) | inner_cuts(pattern)
    return _Lines(tuple(styles), number, walls)


def _chosen_styles(
    pattern: CreasePattern, settings: PerforationSettings
) -> Iterator[tuple[BoolArray, CreaseStyle]]:
    """Edges, shape (ne,), and their style; later ones replace earlier ones."""
    letters = pattern.edges_assignment
    shared = pattern.edges_faces[:, 1] >= 0
    for letter, name in CREASE_NAMES.items():
        yield shared & (letters == letter), getattr(settings, name)
    angle = np.abs(pattern.edges_foldAngle)
    for band in settings.bands:
        within = shared & (angle >= band.from_deg)
        within &= (angle < band.to_deg) | (band.to_deg == 180)
        for letter, style in (("M", band.mountain), ("V", band.valley)):
            if style is not None:
                yield within & (letters == letter), style


def _cut_creases(
    pattern: CreasePattern, lines: _Lines, holes: ReliefHoles, margin_mm: float, beam: Beam
) -> tuple[CutCreases, list[Layer]]:
    """What becomes of the creases, and the layers of their cuts, mountains and valleys first."""
    spans = np.diff(pattern.vertices_coords[pattern.edges_vertices], axis=1)[:, 0]
    width = lines.band_widths_mm(beam.across(spans))
    trim = holes.radii_mm[pattern.edges_vertices]
    trim = np.maximum(trim, lattice_starts(pattern, lines.drawn, lines.walls, width / 2))
    trim += margin_mm
    trimmed = np.where(lines.walls[:, None], 0.0, trim)
    meeting = np.isin(
        np.arange(len(trim)),
        meeting_lattices(pattern, lines.drawn, trimmed, width / 2, margin_mm, holes.rings),
    )
    layers = [Layer(Operation.MOUNTAIN), Layer(Operation.VALLEY)]
    count, pierced = np.zeros((2, len(trim)), np.int64)
    for number, style in enumerate(lines.styles):
        for operation, letters in _operations(style):
            of_letters = np.isin(pattern.edges_assignment, letters)
            edges = np.flatnonzero((lines.style == number) & of_letters & ~meeting)
            if not len(edges):
                continue
            ends = pattern.vertices_coords[pattern.edges_vertices[edges]]
            cuts = cuts_along(ends, style, trim[edges], beam, int(count.sum()))
            count += np.bincount(edges[cuts.owner], minlength=len(trim))
            pierced += np.bincount(edges[cuts.owner[cuts.pierced]], minlength=len(trim))
            layers.append(Layer(operation, cuts.segments))
    edges = np.flatnonzero(lines.drawn & ~lines.walls)
    ends = pattern.vertices_coords[pattern.edges_vertices[edges]]
    creases = CutCreases(
        edges,
        pattern.edges_assignment[edges],
        np.hypot(*(ends[:, 1] - ends[:, 0]).T),
        trim[edges].sum(axis=1) + lines.rooms_mm()[edges],
        count[edges],
        width[edges] > 0,
        meeting[edges],
        pierced[edges],
    )
    return creases, layers


def _operations(style: CreaseStyle) -> list[tuple[Operation, list[str]]]:
    """What is done along creases of a style, and the assignments that it is done for."""
    if isinstance(style, NoStyle):
        return []
    if isinstance(style, EngraveStyle):
        return [(Operation.ENGRAVE, list(CREASE_NAMES))]
    return [(Operation.MOUNTAIN, ["M"]), (Operation.VALLEY, ["V", "F", "U"])]
