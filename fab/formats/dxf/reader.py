"""DXF drawings of any CAD or drawing program as lines.

Lines, arcs, circles, ellipses, splines and polylines are read from the model space, also within
blocks, which are followed through every INSERT by its matrix. What a line is (mountain, valley,
cut, …) is said by its layer or its colour, as in SVG drawings.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from ezdxf.colors import aci2rgb
from ezdxf.document import Drawing

from fab.errors import Finding, InvalidFile, Severity, counted
from fab.formats.drawn.dashes import join_dashes
from fab.formats.drawn.letters import (
    given_letter,
    key_of,
    letter_of,
    unlettered_finding,
    unused_colours,
)
from fab.formats.drawn.line_soup import UNLETTERED, LineSoup, require_few_lines, with_length
from fab.formats.drawn.own_sheets import OPERATIONS, recovered_sheet
from fab.formats.dxf.curves import DRAWN, flattened, is_curved, is_mesh, weight
from fab.formats.dxf.document import mm_per_unit_of, read_document, unit_findings
from fab.formats.read_options import ReadOptions
from fab.formats.source_files import shown
from fab.formats.strictness import with_lost
from fab.formats.units import unit_named
from solver.vectors import FloatArray, IntArray

__all__ = ["DEEPEST", "read_dxf"]

# Curves are off their chords by up to this, mm, but neither less than the first nor more than the
# second of these shares of the drawing's diagonal.
TOLERANCE_MM = 0.01
_SHARES = 1e-6, 1e-4
DEEPEST = 50
# Over the diagonal: nearer to z = 0 is on it.
_PLANE = 1e-9
_BYBLOCK, _BLACK_ACI, _LAST_ACI = 0, 7, 255
# Text and the like, that nobody takes for lines.
_NO_LINES = frozenset(
    [
        *("TEXT", "MTEXT", "ATTRIB", "ATTDEF", "TOLERANCE", "LEADER", "MULTILEADER"),
        *("DIMENSION", "ARC_DIMENSION", "POINT", "VIEWPORT", "IMAGE", "OLE2FRAME", "SEQEND"),
    ]
)
# The layer of points that dimensions keep, which is never plotted.
_UNPLOTTED = "defpoints"
# Layers of ORIPA and Oriedita whose names mean something else than their words.
_ORIPA = frozenset(["MountainLine", "ValleyLine"])
_ORIPA_LETTERS = {"CutLine": "B", "noname": "F"}
_LISTED = 6


@dataclass(frozen=True)
class _Style:
    """What an INSERT hands down to the entities of its block: layer 0 and BYBLOCK are its own."""

    layer: str | None = None
    colour: str | None = None
    place: str = ""


@dataclass(frozen=True)
class _Drawn:
    """An entity as it is drawn: its colour, its layer, and the matrix of the blocks around it."""

    entity: Any
    matrix: FloatArray | None
    layer: str
    colour: str | None
    name: str

    def points(self, tolerance: float) -> FloatArray:
        """Points along it in the drawing, shape (n, 3), off it by up to `tolerance`."""
        matrix = self.matrix
        scale = 1.0 if matrix is None else float(np.linalg.norm(matrix[:3, :3], 2))
        points = flattened(self.entity, tolerance / scale if scale > 0 else tolerance)
        return points if matrix is None else points @ matrix[:3, :3] + matrix[3, :3]


@dataclass(frozen=True)
class _LeftOut:
    """Counts of entities that are not drawn, by their kind, layer or block."""

    kinds: Counter[str] = field(default_factory=Counter)
    hidden: Counter[str] = field(default_factory=Counter)
    damaged: Counter[str] = field(default_factory=Counter)
    absent: Counter[str] = field(default_factory=Counter)
    unplotted: Counter[str] = field(default_factory=Counter)


def read_dxf(path: Path, options: ReadOptions) -> LineSoup:
    """The lines of a DXF file of up to 100 MB and two million lines with its blocks.

    Curves are flattened within 0.01 mm, between 1e-6 and 1e-4 of the drawing's diagonal. The unit
    is that of $INSUNITS, if it names one. Where the model space has no lines, those of the first
    paper space that has some are read. Dashes become whole lines; drawings whose layers are those
    of our own sheets (CUT and ENGRAVE, MOUNTAIN, VALLEY or RELIEF, and no other) become their
    pattern again.

    Raises `InvalidFile` for files that cannot be read, without lines, over the bounds, with blocks
    that contain themselves, and for drawings in an upright plane. Codes of the findings:
    "file-recovered", "unit-imperial", "paper-space", "entities-skipped", "layers-hidden",
    "layer-unplotted", "blocks-absent", "entities-damaged", "curves-flattened",
    "line-without-length", "off-plane", "colour-unknown", "colours-unused", and those of
    `join_dashes` and `recovered_sheet`.
    """
    document, recovered = read_document(path)
    mm = mm_per_unit_of(document)
    findings = [*recovered]
    if mm is not None:
        findings += unit_named(mm, options)
    elif options.mm_per_unit is None:
        findings += unit_findings(document)
    left_out = _LeftOut()
    try:
        drawn, spaces = _drawn_entities(path, document, left_out)
    except InvalidFile:
        raise
    except Exception as error:  # ezdxf raises whatever damaged values lead to
        raise InvalidFile(
            f"{path}: the blocks, layers or layouts of the DXF file are damaged: "
            f"{shown(str(error))}. Export it again."
        ) from error
    lines, element, closed, bent, curves = _lines(
        path, drawn, left_out, mm or options.mm_per_unit or 1.0
    )
    kept, short = with_length(lines)
    lines, element = lines[kept], element[kept]
    findings += [*spaces, *_left_out_findings(left_out), *curves, *short]
    if not len(lines):
        refusal = (
            f"{path}: it has no lines, arcs, splines or polylines to read. Draw the creases with "
            "them, on layers that are visible."
        )
        raise InvalidFile(with_lost(refusal, findings))
    lines, off_plane = _flat(path, lines)
    letters, unknown = _letters(drawn, options.colours)
    unused = _unused(drawn, options.colours)
    soup = LineSoup(
        path,
        _title(document),
        lines,
        letters[element],
        np.full(len(lines), np.nan),
        element,
        tuple(one.name for one in drawn),
        mm,
        (*findings, *off_plane, *unused),
    )
    layers = [one.layer for one in drawn]
    if {"CUT"} < set(layers) <= set(OPERATIONS):
        given = [given_letter(one.colour, [one.layer], options.colours) for one in drawn]
        return recovered_sheet(soup, layers, closed, bent, given)
    if unknown:
        soup = replace(soup, findings=(*soup.findings, unlettered_finding(unknown)))
    return join_dashes(soup)


def _title(document: Drawing) -> str:
    title = document.header.get("$PROJECTNAME", "")
    return title if isinstance(title, str) else ""


def _drawn_entities(
    path: Path, document: Drawing, left_out: _LeftOut
) -> tuple[list[_Drawn], list[Finding]]:
    """What is drawn in the model space, or else in a paper space."""
    walk = _Walk(path, document, left_out)
    drawn = list(walk.drawn(document.modelspace()))
    papers = [document.layout(name) for name in document.layout_names_in_taborder()]
    papers = [paper for paper in papers if not paper.is_modelspace]
    if drawn:
        count = sum(entity.dxftype() in DRAWN for paper in papers for entity in paper)
        if not count:
            return drawn, []
        what = "line or curve" if count == 1 else "lines and curves"
        text = f"left out: {count} {what} of paper space, where title blocks are."
        return drawn, [Finding("paper-space", Severity.NOTE, text)]
    for paper in papers:
        if drawn := list(walk.drawn(paper)):
            text = (
                f"the model space has no lines: they are those of the paper space "
                f"{shown(paper.name)}, at its scale."
            )
            return drawn, [Finding("paper-space", Severity.WARNING, text)]
    return [], []


class _Walk:
    """Entities of a document through all blocks, with the layers and colours that they have."""

    def __init__(self, path: Path, document: Drawing, left_out: _LeftOut) -> None:
        self.path = path
        self.document = document
        self.left_out = left_out
        self.weights: dict[str, int] = {}

    def drawn(self, space: Iterable[Any]) -> Iterator[_Drawn]:
        """What is drawn in a space. Raises `InvalidFile` before anything, where it is too much."""
        entities = list(space)
        require_few_lines(self.path, self._weight(entities, ()))
        return self._walk(entities, None, _Style())

    def _weight(self, entities: Iterable[Any], above: tuple[str, ...]) -> int:
        """How many lines entities become at least, with their blocks."""
        total = 0
        for entity in entities:
            kind = entity.dxftype()
            if kind in DRAWN:
                total += weight(entity)
            elif kind == "INSERT":
                total += _times(entity) * self._weight_of_block(entity, above)
        return total

    def _weight_of_block(self, insert: Any, above: tuple[str, ...]) -> int:
        block = insert.block()
        if block is None:
            return 1
        name = str(block.name).casefold()
        if name in above or len(above) > DEEPEST:
            what = "contains itself" if name in above else f"is over {DEEPEST} blocks deep"
            raise InvalidFile(f"{self.path}: the block {shown(block.name)} {what}. Explode it.")
        if name not in self.weights:
            self.weights[name] = 1 + self._weight(block, (*above, name))
        return self.weights[name]

    def _walk(
        self, entities: Iterable[Any], matrix: FloatArray | None, style: _Style
    ) -> Iterator[_Drawn]:
        for entity in entities:
            kind = entity.dxftype()
            layer = str(entity.dxf.layer)
            if layer == "0" and style.layer is not None:
                layer = style.layer
            if (kind not in DRAWN and kind != "INSERT") or is_mesh(entity):
                self.left_out.kinds["MESH" if kind in DRAWN else kind] += 1
            elif self._is_hidden(entity, layer):
                self.left_out.hidden[layer] += 1
            elif kind != "INSERT" and layer.casefold() == _UNPLOTTED:
                self.left_out.unplotted[kind] += 1
            elif kind == "INSERT":
                yield from self._inserted(entity, layer, matrix, style)
            else:
                handle = entity.dxf.handle
                name = f"{kind} {handle}{style.place}" if handle else f"{kind}{style.place}"
                yield _Drawn(entity, matrix, layer, self._colour(entity, layer, style), name)

    def _inserted(
        self, insert: Any, layer: str, matrix: FloatArray | None, style: _Style
    ) -> Iterator[_Drawn]:
        block = insert.block()
        if block is None or (block.block.is_xref and not len(block)):
            self.left_out.absent[str(insert.dxf.name)] += 1
            return
        place = style.place or f" of INSERT {insert.dxf.handle}"
        inner = _Style(layer, self._colour(insert, layer, style), place)
        for attached in insert.attribs:
            self.left_out.kinds[attached.dxftype()] += 1
        for one in insert.multi_insert() if _times(insert) > 1 else [insert]:
            own = np.array(list(one.matrix44()), float).reshape(4, 4)
            yield from self._walk(block, own if matrix is None else own @ matrix, inner)

    def _is_hidden(self, entity: Any, layer: str) -> bool:
        if entity.dxf.get("invisible", 0):
            return True
        found = self._layer(layer)
        if found is None:
            return False
        # A layer that is off hides what is on it, a frozen one also the blocks that are put on it.
        return bool(found.is_frozen() or (found.is_off() and entity.dxftype() != "INSERT"))

    def _layer(self, name: str) -> Any:
        layers = self.document.layers
        return layers.get(name) if layers.has_entry(name) else None

    def _colour(self, entity: Any, layer: str, style: _Style) -> str | None:
        """Colour as "#rrggbb"; black for white, which CAD programs draw on a dark screen."""
        if entity.dxf.hasattr("true_color"):
            return _hex(entity.rgb)
        aci = int(entity.dxf.get("color", _LAST_ACI + 1))
        if aci == _BYBLOCK:
            return style.colour
        if aci > _LAST_ACI:
            found = self._layer(layer)
            if found is None:
                return _hex((255, 255, 255))
            if found.dxf.hasattr("true_color"):
                return _hex(found.rgb)
            aci = int(found.dxf.color)
        return _of_aci(aci)


def _times(insert: Any) -> int:
    return max(1, int(insert.mcount))


def _of_aci(aci: int) -> str | None:
    """Colour of an index, negative where the layer is off; None for numbers that are no colour."""
    number = abs(aci)
    if not 0 < number <= _LAST_ACI:
        return None
    return _hex((0, 0, 0) if number == _BLACK_ACI else tuple(aci2rgb(number)))


def _hex(rgb: Any) -> str | None:
    if rgb is None:
        return None
    parts = tuple(int(part) for part in rgb)
    return "#000000" if min(parts) >= 250 else "#%02x%02x%02x" % parts


def _lines(
    path: Path, drawn: list[_Drawn], left_out: _LeftOut, mm_per_unit: float
) -> tuple[FloatArray, IntArray, list[bool], list[bool], list[Finding]]:
    """Lines of shape (n, 2, 3), the entity of each, which entities are closed, which have several
    sides, and how far curves are off.

    Entities whose numbers make no line are counted in `left_out`.
    """
    rough = [_points(one, np.inf, left_out) for one in drawn]
    filled = [points for points in rough if len(points)]
    if not filled:
        return np.zeros((0, 2, 3)), np.zeros(0, np.int64), [], [], []
    low = np.min([points.min(axis=0) for points in filled], axis=0)
    high = np.max([points.max(axis=0) for points in filled], axis=0)
    with np.errstate(over="ignore"):
        diagonal = float(np.linalg.norm(high - low))
    if not np.isfinite(diagonal):
        raise InvalidFile(
            f"{path}: its coordinates are too large. Scale the drawing to millimetres."
        )
    tolerance = float(np.clip(TOLERANCE_MM / mm_per_unit, *(np.array(_SHARES) * diagonal)))
    curved = 0
    total = 0
    for number, one in enumerate(drawn):
        if len(rough[number]) and is_curved(one.entity):
            rough[number] = _points(one, tolerance, left_out)
            curved += len(rough[number]) > 2
        total += max(len(rough[number]) - 1, 0)
        require_few_lines(path, total)
    parts = [np.stack([points[:-1], points[1:]], axis=1) for points in rough]
    element = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    findings = []
    if curved:
        what = "1 curve is" if curved == 1 else f"{curved} curves are"
        text = f"{what} flattened within {tolerance * mm_per_unit:.3g} mm."
        findings.append(Finding("curves-flattened", Severity.NOTE, text))
    closed = [len(points) > 3 and bool((points[0] == points[-1]).all()) for points in rough]
    bent = [len(points) > 2 for points in rough]
    return np.concatenate(parts), element, closed, bent, findings


def _points(one: _Drawn, tolerance: float, left_out: _LeftOut) -> FloatArray:
    """Points along an entity; none, and counted, where its numbers make no curve."""
    try:
        with np.errstate(all="ignore"):
            points = one.points(tolerance)
    except Exception:  # ezdxf raises whatever damaged numbers lead to
        points = np.zeros((0, 3))
        left_out.damaged[one.entity.dxftype()] += 1
        return points
    drawn = len(points) > 1 and bool(np.isfinite(points).all())
    if not drawn or (is_curved(one.entity) and bool((points == points[0]).all())):
        left_out.damaged[one.entity.dxftype()] += 1
        return np.zeros((0, 3))
    return points


def _left_out_findings(left_out: _LeftOut) -> list[Finding]:
    out = []
    if left_out.kinds:
        only_text = set(left_out.kinds) <= _NO_LINES
        severity = Severity.NOTE if only_text else Severity.WARNING
        cure = "" if only_text else " Explode them in the CAD program where they have creases."
        text = f"left out, as they are no lines: {_listed(left_out.kinds)}.{cure}"
        out.append(Finding("entities-skipped", severity, text))
    if left_out.hidden:
        count = sum(left_out.hidden.values())
        what = "1 entity is" if count == 1 else f"{count} entities are"
        text = (
            f"{what} left out as invisible, on layers that are off or frozen: "
            f"{_listed(left_out.hidden, 'on')}. Show these layers to read them."
        )
        out.append(Finding("layers-hidden", Severity.NOTE, text))
    if left_out.unplotted:
        count = sum(left_out.unplotted.values())
        text = (
            f"{counted(count, 'line or curve', 'lines and curves')} on the layer Defpoints, which "
            "CAD programs never plot: left out. Move creases to another layer."
        )
        out.append(Finding("layer-unplotted", Severity.NOTE, text))
    if left_out.absent:
        text = (
            "left out, insertions of blocks that the file does not have: "
            f"{_listed(left_out.absent, 'of')}. Bind what refers to other files in the CAD "
            "program, and export the drawing again."
        )
        out.append(Finding("blocks-absent", Severity.WARNING, text))
    if left_out.damaged:
        listed = _listed(left_out.damaged)
        text = f"left out, as their numbers make no line: {listed}. Draw them again."
        out.append(Finding("entities-damaged", Severity.WARNING, text))
    return out


def _listed(counts: Mapping[str, int], before_name: str = "") -> str:
    ranked = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    listed = ", ".join(
        f"{count} {before_name} {shown(name)}" if before_name else f"{count} {shown(name)[1:-1]}"
        for name, count in ranked[:_LISTED]
    )
    rest = len(ranked) - _LISTED
    return f"{listed}, and {rest} more kinds" if rest > 0 else listed


def _flat(path: Path, lines: FloatArray) -> tuple[FloatArray, list[Finding]]:
    """The lines seen from above, shape (n, 2, 2), and whether they were not in one level plane."""
    heights = lines[..., 2]
    across = lines[..., :2]
    box = across.reshape(-1, 2)
    spread = np.ptp(box, axis=0)
    near = _PLANE * float(np.linalg.norm(np.append(spread, np.ptp(heights))))
    if np.ptp(heights) > near and spread.min() <= near:
        raise InvalidFile(
            f"{path}: the drawing is in an upright plane. Turn it into the plane z = 0."
        )
    slanted = int((np.abs(heights[:, 1] - heights[:, 0]) > near).sum())
    raised = int((np.abs(heights) > near).any(axis=1).sum())
    if not raised:
        return across, []
    what = "1 line is" if raised == 1 else f"{raised} lines are"
    text = f"{what} not at z = 0: read as seen from above."
    if slanted:
        one = slanted == 1
        text += f" {slanted} of them {'is' if one else 'are'} slanted and lose length."
    severity = Severity.WARNING if slanted else Severity.NOTE
    return across, [Finding("off-plane", severity, text)]


def _letters(drawn: list[_Drawn], colours: Mapping[str, str]) -> tuple[Any, Counter[str]]:
    """The assignment of each entity, and what those that have none are drawn with."""
    from_oripa = any(one.layer in _ORIPA for one in drawn)
    unknown: Counter[str] = Counter()
    letters = []
    for one in drawn:
        letter = letter_of(one.colour, [one.layer], colours)
        given = one.layer.strip().casefold() in colours or (one.colour or "") in colours
        if from_oripa and not given:
            letter = _ORIPA_LETTERS.get(one.layer, letter)
        if letter is None:
            unknown[one.colour or one.layer] += 1
        letters.append(letter or UNLETTERED)
    return np.array(letters, dtype="U1"), unknown


def _unused(drawn: list[_Drawn], colours: Mapping[str, str]) -> list[Finding]:
    """The finding of colours and layers that have a letter, but no entity."""
    if not colours:
        return []
    keys = {key_of(text) for one in drawn for text in (one.layer, one.colour or "")}
    return unused_colours(colours, keys)
