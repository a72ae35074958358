"""Which lines does the cutter run along: perforated creases, relief holes, outlines?"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fab.drawings.cut_paths import CutPaths, Layer, Operation, joined
from fab.errors import Finding, Severity
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.outlines import inner_cuts, outlines_of
from fab.pattern.sectors import sectors_of
from fab.settings import Settings
from fab.sheets.crease_styles import (
    SHORTEST_CUT_MM,
    CreaseStyle,
    DashStyle,
    EngraveStyle,
    LatticeStyle,
    NoStyle,
    cuts_along,
    require_kerf,
)
from fab.sheets.feature_size import enlargement
from fab.sheets.kerf import compensated
from fab.sheets.relief_holes import ReliefHoles, ReliefSettings, relief_holes
from solver.errors import InvalidValue
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "CutCreases",
    "DashStyle",
    "FoldBand",
    "PerforationSettings",
    "crease_findings",
    "cut_layers",
    "cut_piece",
    "perforate",
]

_NAMES = {"M": "mountain", "V": "valley", "F": "flat", "U": "unassigned"}
_BORDERS = ("B", "C")
# Where more creases than this share cannot be folded, a sheet is a waste of material.
_MOST_UNCUT = 0.5
_JOINED = "J"  # faces that are one: nothing is drawn between them


class FoldBand(Settings):
    """Styles of the creases that fold by at least `from_deg` and less than `to_deg`.

    A band that ends at 180 holds creases that fold by 180 too.
    """

    from_deg: float = Field(ge=0, le=180)
    to_deg: float = Field(ge=0, le=180)
    mountain: CreaseStyle | None = Field(default=None, description="left out: as outside the bands")
    valley: CreaseStyle | None = Field(default=None, description="left out: as outside the bands")

    @model_validator(mode="after")
    def _runs_upwards(self) -> FoldBand:
        if self.from_deg >= self.to_deg:
            raise ValueError(
                f"from_deg = {self.from_deg:g} must be below to_deg = {self.to_deg:g}. Exchange "
                "them, or remove the band"
            )
        return self


class PerforationSettings(Settings):
    """How creases are perforated, by assignment and by how far they fold."""

    mountain: CreaseStyle = DashStyle(cut_mm=3.0, gap_mm=1.0)
    valley: CreaseStyle = DashStyle(cut_mm=1.0, gap_mm=1.0)
    flat: CreaseStyle = NoStyle()
    unassigned: CreaseStyle = EngraveStyle()
    margin_mm: float = Field(
        default=0.5, gt=0, le=1000, description="uncut at both ends of every crease"
    )
    bands: list[FoldBand] = Field(
        default=[], description="other styles by fold angle; between bands those above apply"
    )
    relief: ReliefSettings | None = Field(
        default=None, description="holes at vertices; none where left out"
    )

    @model_validator(mode="after")
    def _bands_apart(self) -> PerforationSettings:
        bands = sorted(self.bands, key=lambda band: band.from_deg)
        for lower, upper in pairwise(bands):
            if upper.from_deg < lower.to_deg:
                raise ValueError(
                    f"bands from {lower.from_deg:g} to {lower.to_deg:g} and from "
                    f"{upper.from_deg:g} to {upper.to_deg:g} degrees overlap. Let one end where "
                    "the other begins"
                )
        return self


@dataclass(frozen=True)
class CutCreases:
    """The creases of a pattern that are to be cut, and what became of each; shapes (n,).

    Attributes
    ----------
    numbers, letters : of the edges.
    length_mm, needed_mm : the length, and that with which something is cut at least.
    cuts : how many lie on each; lattice : which have one.
    meeting : those that stay uncut as their lattice would meet other lines.
    pierced : how many cuts on each are not longer than the kerf.
    """

    numbers: IntArray
    letters: NDArray[np.str_]
    length_mm: FloatArray
    needed_mm: FloatArray
    cuts: IntArray
    lattice: BoolArray
    meeting: BoolArray
    pierced: IntArray


def perforate(
    pattern: CreasePattern, settings: PerforationSettings, kerf_mm: float = 0.0
) -> tuple[CutPaths, list[Finding]]:
    """`cut_layers`, moved so that their lower left corner is (0, 0)."""
    layers, findings = cut_layers(pattern, settings, kerf_mm)
    outlines = [ring for layer in layers for ring in layer.outlines]
    points = np.concatenate(outlines) if outlines else pattern.vertices_coords
    low, high = points.min(axis=0), points.max(axis=0)
    width, height = (high - low).tolist()
    return CutPaths(tuple(layer.moved(np.eye(2), -low) for layer in layers), (width, height)), (
        findings
    )


def cut_layers(
    pattern: CreasePattern, settings: PerforationSettings, kerf_mm: float = 0.0
) -> tuple[tuple[Layer, ...], list[Finding]]:
    """The layers of `cut_piece` for a pattern that is cut alone, and all that is told of it."""
    layers, creases, findings = cut_piece(pattern, settings, kerf_mm)
    return layers, [*findings, *crease_findings([creases], settings.margin_mm, kerf_mm)]


def cut_piece(
    pattern: CreasePattern, settings: PerforationSettings, kerf_mm: float = 0.0
) -> tuple[tuple[Layer, ...], CutCreases, list[Finding]]:
    """Perforated creases, relief holes, inner cuts and closed outlines, where the pattern lies.

    What became of the creases is given as arrays, for `crease_findings`; the findings are those of
    holes and outlines.

    kerf_mm : width of the beam. Cuts on creases are drawn shorter by it, and outlines and relief
        holes are moved by half of it (`fab.kerf`); inner cuts stay.

    The layers of mountains, valleys and cuts are always there, the other ones where something lies
    on them. Cuts of flat and of unassigned creases lie with the valleys; marks of every assignment
    (style engrave) with the engravings. Edges with one face are outlines whatever their assignment,
    and edges assigned C or B between two faces are inner cuts.

    Cuts begin `margin_mm` after the vertex, or after the rim of its relief hole. Lattices begin
    later: `margin_mm` after the place where their outermost row meets the bisector of the sector
    beside it (or its wall, where that is an outline), so that neighbours cannot meet; those that
    meet other lines all the same, across a narrow face, stay uncut, and so do creases without room.

    Raises `InvalidValue` for unknown assignments, for a negative kerf, one that joins cuts, and for
    too many cuts.
    """
    require_kerf(kerf_mm)
    kinds, kind = _styles(pattern, settings)
    walls = (pattern.edges_faces[:, 1] < 0) | inner_cuts(pattern)
    lines = np.array([not isinstance(style, NoStyle) for style in kinds])[kind] | walls
    marks = np.array([isinstance(style, EngraveStyle) for style in kinds])[kind]
    findings: list[Finding] = []
    holes = ReliefHoles(np.zeros(len(pattern.vertices_coords)), ())
    if settings.relief is not None:
        holes, findings = relief_holes(pattern, lines, walls, marks, settings.relief)
    width = np.array([s.width_mm + kerf_mm if isinstance(s, LatticeStyle) else 0.0 for s in kinds])
    trim = holes.radii_mm[pattern.edges_vertices]
    trim = np.maximum(trim, _lattice_starts(pattern, lines, walls, width[kind] / 2))
    trim += settings.margin_mm
    trimmed = np.where(walls[:, None], 0.0, trim)
    meeting = _meeting_lattices(pattern, lines, trimmed, width[kind] / 2, settings.margin_mm, holes)
    layers = [Layer(Operation.MOUNTAIN), Layer(Operation.VALLEY)]
    drawn, pierced = np.zeros((2, len(kind)), np.int64)
    for number, style in enumerate(kinds):
        for operation, letters in _operations(style):
            of_style = (kind == number) & np.isin(pattern.edges_assignment, letters)
            creases = np.flatnonzero(of_style)
            creases = creases[~np.isin(creases, meeting)]
            if not len(creases):
                continue
            ends = pattern.vertices_coords[pattern.edges_vertices[creases]]
            cuts = cuts_along(ends, style, trim[creases], kerf_mm)
            drawn += np.bincount(creases[cuts.owner], minlength=len(kind))
            pierced += np.bincount(creases[cuts.owner[cuts.pierced]], minlength=len(kind))
            layers.append(Layer(operation, cuts.segments))
    creases = np.flatnonzero(lines & ~walls)
    ends = pattern.vertices_coords[pattern.edges_vertices[creases]]
    rooms = [s.least_room_mm if isinstance(s, LatticeStyle) else SHORTEST_CUT_MM for s in kinds]
    became = CutCreases(
        creases,
        pattern.edges_assignment[creases],
        np.hypot(*(ends[:, 1] - ends[:, 0]).T),
        trim[creases].sum(axis=1) + np.array(rooms)[kind[creases]],
        drawn[creases],
        (width > 0)[kind[creases]],
        np.isin(creases, meeting),
        pierced[creases],
    )
    borders = outlines_of(pattern)
    rings, moved = compensated(borders.rings, kerf_mm)
    relief, shrunk = compensated(holes.rings, kerf_mm)
    if relief:
        layers.append(Layer(Operation.RELIEF, outlines=relief))
    layers.append(Layer(Operation.CUT, borders.slits, rings))
    return joined(layers), became, [*findings, *moved, *shrunk]


def _operations(style: CreaseStyle) -> list[tuple[Operation, list[str]]]:
    if isinstance(style, NoStyle):
        return []
    if isinstance(style, EngraveStyle):
        return [(Operation.ENGRAVE, list(_NAMES))]
    return [(Operation.MOUNTAIN, ["M"]), (Operation.VALLEY, ["V", "F", "U"])]


def _styles(
    pattern: CreasePattern, settings: PerforationSettings
) -> tuple[list[CreaseStyle], IntArray]:
    """The styles that occur, and the number of each edge's own, shape (ne,); borders have none."""
    letters = pattern.edges_assignment
    known = [*_NAMES, *_BORDERS, _JOINED]
    strange = np.flatnonzero(~np.isin(letters, known))
    if len(strange):
        raise InvalidValue(
            f"assignment of edge {strange[0]}",
            repr(str(letters[strange[0]])),
            f"be one of {', '.join(known)}",
            "Assign the edge, U where it is not known.",
        )
    kinds: list[CreaseStyle] = [NoStyle()]
    kind = np.zeros(len(letters), np.int64)

    def put(where: BoolArray, style: CreaseStyle) -> None:
        if style not in kinds:
            kinds.append(style)
        kind[where] = kinds.index(style)

    shared = pattern.edges_faces[:, 1] >= 0
    for letter, name in _NAMES.items():
        put(shared & (letters == letter), getattr(settings, name))
    angle = np.abs(pattern.edges_foldAngle)
    for band in settings.bands:
        within = shared & (angle >= band.from_deg)
        within &= (angle < band.to_deg) | (band.to_deg == 180)
        for letter, style in (("M", band.mountain), ("V", band.valley)):
            if style is not None:
                put(within & (letters == letter), style)
    return kinds, kind


def _lattice_starts(
    pattern: CreasePattern, lines: BoolArray, walls: BoolArray, half_mm: FloatArray
) -> FloatArray:
    """How far from each end a band of this half width clears the lines beside it, shape (ne, 2).

    A band h to each side clears the bisector of a sector a after h cot(a / 2), and a wall itself
    after h cot(a); nothing lies in its way beyond a right angle.
    """
    out = np.zeros((len(half_mm), 2))
    if not half_mm.any():
        return out
    sectors = sectors_of(pattern, lines)
    wall = walls[sectors.edges]
    share = np.where(wall[sectors.following], 1.0, 0.5)  # seen from the line before
    after = np.minimum(sectors.angles * share, np.pi / 2)
    before = np.empty_like(after)
    before[sectors.following] = np.minimum(sectors.angles * np.where(wall, 1.0, 0.5), np.pi / 2)
    clear = np.minimum(before, after)
    half = half_mm[sectors.edges]
    with np.errstate(divide="ignore", invalid="ignore"):
        start = np.where(half > 0, half * np.cos(clear) / np.sin(clear), 0.0)
    out[sectors.edges, sectors.ends] = start
    return out


def _meeting_lattices(
    pattern: CreasePattern,
    lines: BoolArray,
    trim: FloatArray,
    half_mm: FloatArray,
    margin_mm: float,
    holes: ReliefHoles,
) -> IntArray:
    """Creases whose lattice meets another line, hole or lattice, or the margin of a vertex."""
    if not half_mm.any():
        return np.empty(0, np.int64)
    edges = np.flatnonzero(lines)
    ends = pattern.vertices_coords[pattern.edges_vertices[edges]]
    span = ends[:, 1] - ends[:, 0]
    length = np.hypot(span[:, 0], span[:, 1])
    shortened = trim[edges]
    room = length - shortened.sum(axis=1)
    edges, ends, span, length = (a[room > 0] for a in (edges, ends, span, length))
    shortened = shortened[room > 0]
    along = span / length[:, None]
    across = along[:, ::-1] * [-1, 1] * half_mm[edges, None]
    low = ends[:, 0] + shortened[:, :1] * along
    high = ends[:, 1] - shortened[:, 1:] * along
    wide = np.flatnonzero(half_mm[edges] > 0)
    bands = shapely.polygons(
        np.stack([low - across, high - across, high + across, low + across], axis=1)[wide]
    )
    shapes = shapely.linestrings(np.stack([low, high], axis=1))
    shapes[wide] = bands
    rings = [shapely.LinearRing(ring) for ring in holes.rings]
    band, other = shapely.STRtree([*shapes, *rings]).query(bands, predicate="intersects")
    foreign = band[wide[band] != other]
    points = shapely.points(pattern.vertices_coords[np.unique(pattern.edges_vertices)])
    within = margin_mm * (1 - 1e-9)  # a band may begin at the margin of its own vertex
    near, _ = shapely.STRtree(points).query(bands, predicate="dwithin", distance=within)
    met: IntArray = np.unique(edges[wide[np.concatenate([foreign, near])]])
    return met


def crease_findings(
    creases: Sequence[CutCreases], margin_mm: float, kerf_mm: float
) -> list[Finding]:
    """What is told of creases that are not cut as asked for, each thing once for all patterns.

    creases : those of each pattern, at least one; edges are told by their numbers.
    """
    every = CutCreases(
        *(
            np.concatenate([getattr(own, field.name) for own in creases])
            for field in dataclasses.fields(CutCreases)
        )
    )
    return [
        *_meeting_findings(every),
        *_too_short(every, margin_mm),
        *_rigid(every),
        *_pierced(every, kerf_mm),
    ]


def _meeting_findings(creases: CutCreases) -> list[Finding]:
    met = creases.numbers[creases.meeting]
    if not len(met):
        return []
    return [
        Finding(
            "lattices-meet",
            Severity.ERROR,
            f"{len(met)} lattices would meet other lines across a face and stay uncut. Lower "
            "rows or pitch_mm, or enlarge the sheet.",
            creases=tuple(met[:20].tolist()),
        )
    ]


def _too_short(creases: CutCreases, margin_mm: float) -> list[Finding]:
    short = (creases.cuts == 0) & ~creases.meeting
    if not short.any():
        return []
    alike = [(name, short[creases.letters == letter]) for letter, name in _NAMES.items()]
    counts = [f"{uncut.sum()} of {len(uncut)} {name}" for name, uncut in alike if uncut.any()]
    length = creases.length_mm[short]
    return [
        Finding(
            "crease-too-short",
            Severity.ERROR
            if any(len(uncut) and uncut.mean() > _MOST_UNCUT for _, uncut in alike)
            else Severity.WARNING,
            f"{' and '.join(counts)} creases leave nothing between their margins "
            f"({2 * margin_mm:g} mm, and what relief holes and lattices take) and stay uncut. The "
            f"shortest is {length.min():.3g} mm long. Lower margin_mm, or make the sheet at least "
            f"{enlargement(creases.needed_mm[short], length)} times as large.",
            creases=tuple(creases.numbers[short][:20].tolist()),
        )
    ]


def _rigid(creases: CutCreases) -> list[Finding]:
    """Lattices of one slit, which bend nowhere."""
    rigid = creases.lattice & (creases.cuts == 1)
    if not rigid.any():
        return []
    bending = int((creases.lattice & (creases.cuts > 1)).sum())
    length = creases.length_mm[rigid]
    return [
        Finding(
            "lattice-rigid",
            Severity.ERROR
            if rigid.sum() > _MOST_UNCUT * creases.lattice.sum()
            else Severity.WARNING,
            f"{rigid.sum()} lattices have room for one slit alone and do not bend; {bending} do. "
            f"The shortest of these creases is {length.min():.3g} mm long. Lower cut_mm, or make "
            f"the sheet at least {enlargement(creases.needed_mm[rigid], length)} times as large.",
            creases=tuple(creases.numbers[rigid][:20].tolist()),
        )
    ]


def _pierced(creases: CutCreases, kerf_mm: float) -> list[Finding]:
    pierced = np.flatnonzero(creases.pierced)
    if not len(pierced):
        return []
    return [
        Finding(
            "cut-shorter-than-kerf",
            Severity.WARNING,
            f"{creases.pierced.sum()} cuts on {len(pierced)} creases are not longer than the kerf "
            f"({kerf_mm:g} mm) and are drawn as pierces, which come out as long as the kerf. "
            "Lengthen the cuts, or take a finer beam.",
            creases=tuple(creases.numbers[pierced[:20]].tolist()),
        )
    ]
