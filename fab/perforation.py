"""Which lines does the cutter run along: perforated creases, relief holes, outlines?"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely
from pydantic import Field, model_validator

from fab.crease import CreasePattern
from fab.errors import Finding, Severity
from fab.fineness import enlargement
from fab.kerf import compensated
from fab.outlines import inner_cuts, outlines_of
from fab.paths import CutPaths, Layer, Operation, joined
from fab.relief import ReliefHoles, ReliefSettings, relief_holes
from fab.sectors import sectors_of
from fab.settings import Settings
from fab.styles import (
    SHORTEST_CUT_MM,
    CreaseStyle,
    DashStyle,
    EngraveStyle,
    LatticeStyle,
    NoStyle,
    cuts_along,
    require_kerf,
)
from solver.errors import InvalidValue
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["DashStyle", "FoldBand", "PerforationSettings", "cut_layers", "perforate"]

_NAMES = {"M": "mountain", "V": "valley", "F": "flat", "U": "unassigned"}
_BORDERS = ("B", "C")
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
    """Perforated creases, relief holes, inner cuts and closed outlines, where the pattern lies.

    kerf_mm : width of the beam. Cuts on creases are drawn shorter by it, and outlines and relief
        holes are moved by half of it (`fab.kerf`); inner cuts stay.

    The layers of mountains, valleys and cuts are always there, the other ones where something lies
    on them. Cuts of flat and of unassigned creases lie with the valleys; marks of every assignment
    (style engrave) with the engravings. Edges with one face are outlines whatever their assignment,
    and edges assigned C or B between two faces are inner cuts.

    Cuts begin `margin_mm` after the vertex, or after the rim of its relief hole. Lattices begin
    later: `margin_mm` after the place where their outermost row meets the bisector of the sector
    beside it (or its wall, where that is an outline), so that neighbours cannot meet; those that
    meet other lines all the same, across a narrow face, stay uncut. Creases without room are named
    in findings.

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
    findings += _meeting_findings(meeting)
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
    uncut = drawn == 0
    uncut[meeting] = False  # named already
    rooms = [s.least_room_mm if isinstance(s, LatticeStyle) else SHORTEST_CUT_MM for s in kinds]
    needed = trim.sum(axis=1) + np.array(rooms)[kind]
    findings += _too_short(pattern, lines & ~walls, uncut, needed, settings.margin_mm)
    findings += _rigid(pattern, (width > 0)[kind], drawn, needed)
    findings += _pierced(pierced, kerf_mm)
    borders = outlines_of(pattern)
    rings, moved = compensated(borders.rings, kerf_mm)
    relief, shrunk = compensated(holes.rings, kerf_mm)
    if relief:
        layers.append(Layer(Operation.RELIEF, outlines=relief))
    layers.append(Layer(Operation.CUT, borders.slits, rings))
    return joined(layers), [*findings, *moved, *shrunk]


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


def _meeting_findings(creases: IntArray) -> list[Finding]:
    if not len(creases):
        return []
    return [
        Finding(
            "lattices-meet",
            Severity.ERROR,
            f"{len(creases)} lattices would meet other lines across a face and stay uncut. Lower "
            "rows or pitch_mm, or enlarge the sheet.",
            creases=tuple(creases[:20].tolist()),
        )
    ]


def _too_short(
    pattern: CreasePattern,
    lines: BoolArray,
    uncut: BoolArray,
    needed: FloatArray,
    margin_mm: float,
) -> list[Finding]:
    findings = []
    ends = pattern.vertices_coords[pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    for letter, name in _NAMES.items():
        creases = np.flatnonzero(lines & (pattern.edges_assignment == letter))
        short = creases[uncut[creases]]
        if len(short):
            findings.append(
                Finding(
                    "crease-too-short",
                    Severity.ERROR if len(short) == len(creases) else Severity.WARNING,
                    f"{len(short)} of {len(creases)} {name} creases leave nothing between their "
                    f"margins ({2 * margin_mm:g} mm, and what relief holes and lattices take) and "
                    f"stay uncut. The shortest is {length[short].min():.3g} mm long. Lower "
                    "margin_mm, or make the sheet at least "
                    f"{enlargement(needed[short], length[short])} times as large.",
                    creases=tuple(short[:20].tolist()),
                )
            )
    return findings


def _rigid(
    pattern: CreasePattern, lattice: BoolArray, drawn: IntArray, needed: FloatArray
) -> list[Finding]:
    """Lattices of one slit, which bend nowhere; drawn : cuts of each crease, shape (ne,)."""
    creases = np.flatnonzero(lattice & (drawn == 1))
    if not len(creases):
        return []
    ends = pattern.vertices_coords[pattern.edges_vertices[creases]]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    bending = int((lattice & (drawn > 1)).sum())
    return [
        Finding(
            "lattice-rigid",
            Severity.WARNING if bending else Severity.ERROR,
            f"{len(creases)} lattices have room for one slit alone and do not bend; {bending} do. "
            f"The shortest of these creases is {length.min():.3g} mm long. Lower cut_mm, or make "
            f"the sheet at least {enlargement(needed[creases], length)} times as large.",
            creases=tuple(creases[:20].tolist()),
        )
    ]


def _pierced(pierced: IntArray, kerf_mm: float) -> list[Finding]:
    creases = np.flatnonzero(pierced)
    if not len(creases):
        return []
    return [
        Finding(
            "cut-shorter-than-kerf",
            Severity.WARNING,
            f"{pierced.sum()} cuts on {len(creases)} creases are not longer than the kerf "
            f"({kerf_mm:g} mm) and are drawn as pierces, which come out as long as the kerf. "
            "Lengthen the cuts, or take a finer beam.",
            creases=tuple(creases[:20].tolist()),
        )
    ]
