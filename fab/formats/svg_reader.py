"""SVG drawings of any program as the lines of a crease pattern.

Nothing of the file is run and nothing outside it is read. What is drawn but is no line, and what is
not drawn, is left out with a count.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from array import array
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.dashes import join_dashes
from fab.formats.line_letters import colour_of, letter_of, unlettered_finding
from fab.formats.line_soup import LETTERS, UNLETTERED, Letters, LineSoup
from fab.formats.read_options import ReadOptions
from fab.formats.safe_xml import Document, read_xml
from fab.formats.sheet_drawings import OPERATIONS, recovered_sheet
from fab.formats.svg_shapes import SHAPES, Drawn, Place, drawn_shape
from fab.formats.svg_styles import local_name, style_sheets
from fab.formats.svg_viewports import (
    IDENTITY,
    PX_MM,
    Matrix,
    Page,
    length_px,
    page_of,
    transform_of,
    viewport_matrix,
)
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["FLATNESS_MM", "read_svg"]

# Curves become chords that leave them by at most this, in the size that the file has.
FLATNESS_MM = 0.05
_MOST_LINES = 1_000_000
# `use` elements may multiply a drawing; deeper ones refer to each other in a circle.
_MOST_SHAPES = 200_000
_DEEPEST_USE = 32
_FARTHEST = 1e9
# A circle at the end of a line marks a vertex when it is smaller than this, over the drawing.
_MARK_REL = 0.01

_INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
_SERIF = "{http://www.serif.com/}"
_XLINK = "{http://www.w3.org/1999/xlink}"
_LABEL = _INKSCAPE + "label"
_GROUPS = frozenset({"g", "a", "svg", "switch", "use"})
_TEXTS = frozenset({"text", "flowRoot"})
_DEFINITIONS = frozenset(
    {
        *("defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient"),
        *("radialGradient", "filter", "style", "script", "title", "desc", "metadata", "font"),
    }
)
# Oriedita draws folded figures beside the crease pattern.
_FOLDED_FIGURE = re.compile(r"folded-figure-\d+")
# Sizes of a pixel by the program that writes it.
_ILLUSTRATOR_MM, _OLD_INKSCAPE_MM = 25.4 / 72, 25.4 / 90


@dataclass(frozen=True)
class _Context:
    """What an element takes from those around it.

    Attributes
    ----------
    names : of the groups around it, innermost first.
    operation : of our own drawings, where its layer is one.
    uses : how many `use` elements it is drawn through.
    """

    matrix: Matrix
    size: tuple[float, float]
    stroke: str = "none"
    fill: str = "black"
    colour: str = "black"
    stroke_opacity: str = "1"
    visible: bool = True
    hidden: bool = False
    names: tuple[str, ...] = ()
    operation: str = ""
    uses: int = 0
    label: str = ""


@dataclass
class _Shape:
    """One shape that is drawn."""

    name: str
    drawn: Drawn
    colour: str | None
    letter: str | None
    angle: float
    opaque: bool
    stroked: bool
    filled: bool
    circle: bool
    operation: str


@dataclass
class _Drawing:
    """All shapes of a file, and what was left out."""

    shapes: list[_Shape] = field(default_factory=list)
    left_out: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    first_fault: dict[str, str] = field(default_factory=dict)

    def fault(self, kind: str, element: str) -> None:
        self.faults[kind] += 1
        self.first_fault.setdefault(kind, element)


def read_svg(path: Path, options: ReadOptions) -> LineSoup:
    """The lines of an SVG file.

    Letters are those of `fab.formats.line_letters`: by the user's choice, then by data-assignment
    and by the names of the line, its groups and its layer, then by colour. Fold angles are those of
    data-foldAngle, or 180 degrees times the opacity of the stroke, where a mountain or valley of
    the file has one below 1.

    Coordinates are in millimetres where the file has a physical size, else in pixels, of which
    `options.mm_per_unit` gives the size; without it they are those of the program that wrote the
    file: 1/72 inch for Adobe Illustrator, 1/90 for Inkscape before 0.92, else 1/96.

    Raises `InvalidFile` for files that are not SVG, without a line, with images alone, with more
    than a million lines or coordinates beyond 1e9, and all that `read_xml` refuses.
    """
    document = read_xml(path)
    root = document.root
    if local_name(root) != "svg":
        tag = root.tag.rpartition("}")[2]
        raise InvalidFile(
            f"{path}: the outermost element is {tag!r}, not svg. Save the drawing as SVG."
        )
    px_mm, of_program = _pixel(document)
    page = page_of(root.attrib, options.mm_per_unit if options.mm_per_unit else px_mm)
    drawing = _drawing(path, root, page, options)
    taken, as_outlines = _chosen(path, drawing)
    coords, element, letters, angles = _lines(path, taken)
    findings = _unit_findings(page, options, px_mm, of_program)
    findings += _left_out_findings(drawing)
    mm_per_unit = 1.0 if page.physical else options.mm_per_unit or px_mm
    curves = sum(shape.drawn.curves for shape in taken)
    if curves:
        chords = len(coords)
        findings.append(
            Finding(
                "curve-flattened",
                Severity.NOTE,
                f"{_count(curves, 'curve')} became chords that leave the curve by up to "
                f"{FLATNESS_MM:g} mm; the drawing has {_count(chords, 'line')} in all.",
            )
        )
    if as_outlines:
        findings.append(
            Finding(
                "outline-of-fill",
                Severity.WARNING,
                f"nothing in the drawing has a stroke: the outlines of "
                f"{_count(len(taken), 'filled shape')} are taken for its lines, with the letters "
                "of their fills. Give the lines strokes where this is not meant.",
            )
        )
    keep = _no_vertex_marks(coords, element, taken, findings)
    keep &= _with_length(coords, findings)
    soup = LineSoup(
        path,
        _title(root),
        coords[keep] * [1.0, -1.0],
        letters[keep],
        angles[keep],
        element[keep],
        tuple(shape.name for shape in taken),
        mm_per_unit,
    )
    if _is_own(root):
        operations = tuple(shape.operation for shape in taken)
        closed = tuple(shape.drawn.closed for shape in taken)
        soup = recovered_sheet(soup, operations, closed)
    else:
        soup = join_dashes(soup)
    if not len(soup.lines_coords):
        raise InvalidFile(
            f"{path}: the drawing has no line that is part of a pattern. Draw its outline and "
            "creases as lines with a stroke."
        )
    open_letters = Counter(
        taken[e].colour or "without a stroke"
        for e in soup.lines_element[soup.lines_assignment == UNLETTERED].tolist()
    )
    if open_letters:
        findings.append(unlettered_finding(open_letters))
    return replace(soup, findings=(*findings, *soup.findings))


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


# --- which program, what size ---


def _pixel(document: Document) -> tuple[float, str]:
    """Size of a pixel in mm by the program that wrote the file, and the name of that program."""
    styles = (e.text or "" for e in document.root.iter() if local_name(e) == "style")
    exported = "data-name" in document.root.attrib or any(".cls-1" in text for text in styles)
    if exported or "Adobe Illustrator" in document.comments:
        return _ILLUSTRATOR_MM, "Adobe Illustrator"
    version = document.root.get(_INKSCAPE + "version", "")
    found = re.match(r"(\d+)\.(\d+)", version)
    if found and (int(found[1]), int(found[2])) < (0, 92):
        return _OLD_INKSCAPE_MM, f"Inkscape {found[0]}"
    return PX_MM, ""


def _unit_findings(
    page: Page, options: ReadOptions, px_mm: float, of_program: str
) -> list[Finding]:
    if page.physical and not (page.by_pixels and of_program):
        return []
    size = options.mm_per_unit or px_mm
    if options.mm_per_unit:
        return []
    whose = f"of {of_program}" if of_program else "(1/96 inch)"
    lacks = "coordinates" if page.physical else "size"
    return [
        Finding(
            "unit-unknown",
            Severity.NOTE,
            f"the file gives its {lacks} in pixels alone: one pixel {whose} is taken for "
            f"{size:.6g} mm. Give the width of the pattern, or the size of a unit, where this is "
            "not meant.",
        )
    ]


def _title(root: ET.Element) -> str:
    for child in root:
        if local_name(child) == "title":
            return " ".join("".join(child.itertext()).split())
    return ""


def _is_own(root: ET.Element) -> bool:
    """Whether the file is one of the sheets that this program draws."""
    groups = [child for child in root if local_name(child) not in ("", "title")]
    labels = [group.get(_LABEL, "") for group in groups]
    return (
        all(local_name(group) == "g" for group in groups)
        and all(group.get("id") == label for group, label in zip(groups, labels, strict=True))
        and "CUT" in labels
        and labels == [name for name in OPERATIONS if name in labels]
    )


# --- the tree ---


def _drawing(path: Path, root: ET.Element, page: Page, options: ReadOptions) -> _Drawing:
    sheets = style_sheets(root)
    known = {key: element for element in root.iter() if (key := element.get("id"))}
    out = _Drawing()
    out.left_out["rules of style sheets"] += sheets.skipped
    mm = 1.0 if page.physical else options.mm_per_unit or PX_MM
    tolerance = FLATNESS_MM / mm
    counts: Counter[str] = Counter()
    drawn = 0
    first = _Context(page.matrix, page.size)
    stack: list[tuple[ET.Element, _Context, bool]] = [(root, first, True)]
    while stack:
        element, around, outermost = stack.pop()
        tag = local_name(element)
        used_symbol = tag == "symbol" and around.label == "symbol"
        if not tag or (tag in _DEFINITIONS and not used_symbol):
            continue
        if tag in _TEXTS or tag in ("image", "foreignObject"):
            out.left_out["texts" if tag in _TEXTS else f"{tag}s"] += 1
            continue
        shape = tag in SHAPES
        if not shape and tag not in _GROUPS and tag != "symbol":
            continue
        drawn += around.uses > 0
        if drawn > _MOST_SHAPES:
            raise InvalidFile(
                f"{path}: its `use` elements draw more than {_MOST_SHAPES} elements. Draw the "
                "lines themselves."
            )
        declared = sheets.of(element)
        inner = _inherited(around, declared)
        identity = element.get("id", "")
        counts[tag] += shape
        name = f"{tag} {identity!r}" if identity else f"{tag} {counts[tag]}"
        if (text := declared.get("transform")) is not None:
            matrix = transform_of(text)
            if matrix is None:
                out.fault("transform", name)
            else:
                inner = replace(inner, matrix=_product(inner.matrix, matrix))
        if declared.get("clip-path", "none") != "none" or declared.get("mask", "none") != "none":
            out.fault("clip", name)
        if shape:
            own = (*_names(element), *inner.names)
            found = _shape(element, tag, name, inner, own, declared, tolerance, options, out)
            if found is not None:
                out.shapes.append(found)
            continue
        if _FOLDED_FIGURE.fullmatch(identity):
            out.left_out["folded figures"] += 1
            continue
        if float_of(declared.get("opacity"), 1.0) < 1.0:
            out.fault("group-opacity", name)
        inner = _within(element, tag, inner, outermost)
        if tag == "use":
            stack += _used(element, inner, known, out)
            continue
        children = [child for child in element if isinstance(child.tag, str)]
        if tag == "switch":
            children = [c for c in children if not c.get("requiredExtensions")][:1]
        stack += [(child, inner, False) for child in reversed(children)]
    return out


def _names(element: ET.Element) -> Iterator[str]:
    """What an element is called, the surest first."""
    get = element.attrib.get
    letter = get("data-assignment", "").strip().upper()
    if len(letter) == 1 and letter in LETTERS:
        yield _NAME_OF_LETTER[letter]
    for key in (_LABEL, "data-name", _SERIF + "id"):
        if name := get(key):
            yield name
    if classes := get("class"):
        yield from classes.split()
    if name := get("id"):
        yield name


_NAME_OF_LETTER = {
    "B": "boundary",
    "M": "mountain",
    "V": "valley",
    "F": "flat",
    "U": "unassigned",
    "C": "cut",
    "J": "join",
}


def _inherited(around: _Context, declared: dict[str, str]) -> _Context:
    """The context with what an element itself declares."""
    if not declared:
        return around
    changes: dict[str, object] = {}
    for key, attribute in (
        ("color", "colour"),
        ("stroke", "stroke"),
        ("fill", "fill"),
        ("stroke-opacity", "stroke_opacity"),
    ):
        value = declared.get(key)
        if value is not None and value != "inherit":
            changes[attribute] = value
    visibility = declared.get("visibility")
    if visibility is not None and visibility != "inherit":
        changes["visible"] = visibility == "visible"
    if declared.get("display") == "none":
        changes["hidden"] = True
    return replace(around, **changes) if changes else around  # type: ignore[arg-type]


def _within(element: ET.Element, tag: str, context: _Context, outermost: bool) -> _Context:
    """The context of what is in a group."""
    if outermost:
        return context
    names = (*_names(element), *context.names)
    label = element.get(_LABEL, "")
    operation = label if label in OPERATIONS else context.operation
    out = replace(context, names=names, operation=operation, label="")
    if tag == "svg" or tag == "symbol":
        width, height = context.size
        get = element.attrib.get
        if tag == "svg":
            x, y = length_px(get("x"), width), length_px(get("y"), height)
            out = replace(out, matrix=_product(out.matrix, (1.0, 0.0, 0.0, 1.0, x, y)))
        across = length_px(get("width"), width, width)
        up = length_px(get("height"), height, height)
        matrix, size = viewport_matrix(element.attrib, across, up)
        out = replace(out, matrix=_product(out.matrix, matrix), size=size)
    return out


def _used(
    element: ET.Element, context: _Context, known: dict[str, ET.Element], out: _Drawing
) -> list[tuple[ET.Element, _Context, bool]]:
    """What a `use` element draws."""
    get = element.attrib.get
    target = (get("href") or get(_XLINK + "href") or "").strip()
    if not target.startswith("#"):
        out.left_out["references to other files"] += 1
        return []
    found = known.get(target[1:])
    if found is None or context.uses >= _DEEPEST_USE:
        out.fault("use", f"use of {target!r}")
        return []
    width, height = context.size
    x, y = length_px(get("x"), width), length_px(get("y"), height)
    inner = replace(
        context,
        matrix=_product(context.matrix, (1.0, 0.0, 0.0, 1.0, x, y)),
        uses=context.uses + 1,
        label=local_name(found),
    )
    if inner.label in ("symbol", "svg"):
        across = length_px(get("width"), width, width)
        up = length_px(get("height"), height, height)
        if get("width") or get("height") or inner.label == "symbol":
            inner = replace(inner, size=(across, up))
    return [(found, inner, False)]


def _product(outer: Matrix, inner: Matrix) -> Matrix:
    if inner == IDENTITY:
        return outer
    a, b, c, d, e, f = outer
    p, q, r, s, t, u = inner
    return (
        a * p + c * q,
        b * p + d * q,
        a * r + c * s,
        b * r + d * s,
        a * t + c * u + e,
        b * t + d * u + f,
    )


# --- shapes ---


def float_of(text: str | None, default: float) -> float:
    """A number or percentage from 0 to 1, as opacities are."""
    if text is None:
        return default
    plain = text.strip()
    try:
        value = float(plain[:-1]) / 100 if plain.endswith("%") else float(plain)
    except ValueError:
        return default
    return min(max(value, 0.0), 1.0) if value == value else default


def _shape(
    element: ET.Element,
    tag: str,
    name: str,
    context: _Context,
    names: tuple[str, ...],
    declared: dict[str, str],
    tolerance: float,
    options: ReadOptions,
    out: _Drawing,
) -> _Shape | None:
    if context.hidden or not context.visible:
        out.left_out["hidden shapes"] += 1
        return None
    stroke = context.colour if context.stroke.lower() == "currentcolor" else context.stroke
    fill = context.colour if context.fill.lower() == "currentcolor" else context.fill
    stroked = not _is_none(stroke)
    filled = not _is_none(fill) and tag != "line"
    place = Place(context.matrix, context.size, tolerance)
    try:
        drawn = drawn_shape(tag, element.attrib, place)
    except (OverflowError, ValueError):
        out.fault("shape", name)
        return None
    if drawn.broken:
        out.fault("shape", name)
    if not drawn.runs:
        return None
    colour = stroke if stroked else fill if filled else None
    letter = letter_of(colour, names, options.colours)
    alpha = 1.0
    if stroked and (found := colour_of(stroke)) is not None:
        alpha = found[1]
    opacity = alpha * float_of(declared.get("opacity"), 1.0)
    opacity *= float_of(context.stroke_opacity, 1.0)
    angle = np.nan
    if letter == "M" or letter == "V":
        angle = (180.0 if letter == "V" else -180.0) * opacity + 0.0
        given = element.get("data-foldAngle")
        if given is not None:
            try:
                value = float(given)
            except ValueError:
                value = np.nan
            if 0 < abs(value) <= 180 and (value > 0) == (letter == "V"):
                angle = value
    return _Shape(
        name,
        drawn,
        colour,
        letter,
        angle,
        opacity == 1.0,
        stroked,
        filled,
        tag == "circle" or tag == "ellipse",
        context.operation,
    )


def _is_none(paint: str) -> bool:
    plain = paint.strip().lower()
    if plain in ("none", "transparent", ""):
        return True
    found = colour_of(plain)
    return found is not None and found[1] == 0.0


def _chosen(path: Path, drawing: _Drawing) -> tuple[list[_Shape], bool]:
    """The shapes that are taken, and whether these are outlines of fills."""
    stroked = [shape for shape in drawing.shapes if shape.stroked]
    if stroked:
        without = Counter(
            "filled shapes without a stroke" if shape.filled else "shapes without stroke and fill"
            for shape in drawing.shapes
            if not shape.stroked
        )
        drawing.left_out.update(without)
        return stroked, False
    filled = drawing.shapes
    if filled:
        return filled, True
    left_out = {kind: count for kind, count in drawing.left_out.items() if count}
    if set(left_out) == {"images"}:
        raise InvalidFile(
            f"{path}: the drawing has {_count(left_out['images'], 'image')} and no line: it is a "
            "picture of pixels. Trace it to lines with a drawing program, and save those."
        )
    what = f" It has {_listed(left_out)} alone." if left_out else ""
    raise InvalidFile(
        f"{path}: the drawing has no line.{what} Draw the outline and the creases as lines with a "
        "stroke."
    )


def _lines(path: Path, shapes: list[_Shape]) -> tuple[FloatArray, IntArray, Letters, FloatArray]:
    """Ends, element, letter and fold angle of every line, y downwards."""
    ends, sizes = array("d"), []
    for shape in shapes:
        size = 0
        for run in shape.drawn.runs:
            for (x, y), (z, w) in pairwise(run):
                ends.extend((x, y, z, w))
            size += len(run) - 1
        shape.drawn.runs.clear()
        sizes.append(size)
        if len(ends) > 4 * _MOST_LINES:
            raise InvalidFile(
                f"{path}: more than {_MOST_LINES} lines. Split the drawing into several files."
            )
    coords = np.array(ends, dtype=float).reshape(-1, 2, 2)
    element = np.repeat(np.arange(len(shapes)), sizes)
    far = ~(np.abs(coords) <= _FARTHEST).all(axis=(1, 2))
    if far.any():
        which = int(np.flatnonzero(far)[0])
        raise InvalidFile(
            f"{path}: {shapes[element[which]].name} has a coordinate of "
            f"{coords[which].ravel()[~(np.abs(coords[which].ravel()) <= _FARTHEST)][0]:g}; they "
            f"must lie from -{_FARTHEST:g} to {_FARTHEST:g}. Remove the element, or correct it."
        )
    letters = np.array([shape.letter or UNLETTERED for shape in shapes], dtype="U1")[element]
    graded = any(not s.opaque for s in shapes if s.letter in ("M", "V"))
    graded = graded or any(abs(s.angle) < 180 for s in shapes)
    angle = np.array([shape.angle if graded else np.nan for shape in shapes])
    return coords, element, letters, angle[element]


def _no_vertex_marks(
    coords: FloatArray, element: IntArray, shapes: list[_Shape], findings: list[Finding]
) -> BoolArray:
    """Which lines are not those of small circles that mark the ends of other lines."""
    kept: BoolArray = np.ones(len(coords), bool)
    round_ones = np.array([s.circle and s.filled and s.letter in ("B", None) for s in shapes])
    if not round_ones.any() or round_ones.all():
        return kept
    of_circle = round_ones[element]
    from scipy.spatial import KDTree

    order = np.unique(element[of_circle])
    points = coords[of_circle][:, 0]
    _, first = np.unique(element[of_circle], return_index=True)
    low, high = np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)
    others = coords[~of_circle].reshape(-1, 2)
    if not len(others):
        return kept
    size = float(np.hypot(*np.ptp(others, axis=0)))
    radius = (high - low).max(axis=1) / 2
    distance, _ = KDTree(others).query((low + high) / 2)
    marks = order[(radius <= _MARK_REL * size) & (distance <= 0.25 * radius)]
    if len(marks):
        kept = ~np.isin(element, marks)
        findings.append(
            Finding(
                "vertex-mark",
                Severity.NOTE,
                f"{_count(len(marks), 'small circle')} at the ends of lines: taken for marks of "
                "vertices, and left out.",
            )
        )
    return kept


def _with_length(coords: FloatArray, findings: list[Finding]) -> BoolArray:
    """Which lines have a length."""
    kept: BoolArray = (coords[:, 0] != coords[:, 1]).any(axis=1)
    if not kept.all():
        count = int((~kept).sum())
        findings.append(
            Finding(
                "line-without-length",
                Severity.NOTE,
                f"{_count(count, 'line')} without length: left out.",
            )
        )
    return kept


# --- what was left out ---

_FAULTS = {
    "transform": (
        "transform-unreadable",
        Severity.WARNING,
        "of {count} the transform cannot be read and was not applied, the first is {first}. "
        "Save the file again, with transforms applied to the shapes.",
        "element",
    ),
    "clip": (
        "clip-ignored",
        Severity.NOTE,
        "{count} clipped or masked, the first is {first}: the lines are taken whole.",
        "element",
    ),
    "group-opacity": (
        "group-opacity",
        Severity.NOTE,
        "{count} of an opacity below 1, the first is {first}: fold angles follow the opacity of "
        "lines, not that of groups.",
        "group",
    ),
    "use": (
        "use-unresolved",
        Severity.WARNING,
        "{count} refer to nothing in the file, or to themselves, the first is {first}: left out.",
        "reference",
    ),
    "shape": (
        "shape-unreadable",
        Severity.WARNING,
        "the data of {count} cannot be read to the end, the first is {first}: what comes before "
        "the fault is taken.",
        "shape",
    ),
}


def _left_out_findings(drawing: _Drawing) -> list[Finding]:
    out = []
    left_out = {kind: count for kind, count in drawing.left_out.items() if count}
    if left_out:
        out.append(
            Finding("not-lines", Severity.NOTE, f"left out, as no lines: {_listed(left_out)}.")
        )
    for kind, (code, severity, text, thing) in _FAULTS.items():
        if count := drawing.faults[kind]:
            first = drawing.first_fault[kind]
            out.append(
                Finding(code, severity, text.format(count=_count(count, thing), first=first))
            )
    return out


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(
        f"{count} {_singular(kind) if count == 1 else kind}"
        for kind, count in sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    )


def _singular(kind: str) -> str:
    first, space, rest = kind.partition(" of ")
    plural = {"texts", "images", "foreignObjects", "shapes", "figures", "references", "rules"}
    words = [word[:-1] if word in plural else word for word in first.split(" ")]
    return " ".join(words) + space + rest
