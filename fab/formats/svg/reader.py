"""SVG drawings of any program as the lines of a crease pattern.

Nothing of the file is run and nothing outside it is read. What is drawn but is no line, and what is
not drawn, is left out with a count.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from array import array
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from fab.errors import Finding, InvalidFile, Severity, counted
from fab.formats.drawn.dashes import join_dashes
from fab.formats.drawn.letters import given_letter, unlettered_finding, unused_colours
from fab.formats.drawn.line_soup import (
    UNLETTERED,
    Letters,
    LineSoup,
    require_few_lines,
    with_length,
)
from fab.formats.drawn.own_sheets import OPERATIONS, recovered_sheet
from fab.formats.read_options import ReadOptions
from fab.formats.source_files import shown
from fab.formats.strictness import with_lost
from fab.formats.svg.lengths import require_lengths
from fab.formats.svg.safe_xml import Document, read_xml
from fab.formats.svg.styles import local_name
from fab.formats.svg.thin_fills import outlines_of_strokes
from fab.formats.svg.tree import Drawing, Shape, drawing_of
from fab.formats.svg.viewports import PX_MM, Page, page_of
from fab.formats.units import unit_named, unit_unknown
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["FLATNESS_MM", "read_svg"]

# Curves become chords that leave them by at most this, in the size that the file has.
FLATNESS_MM = 0.05
# Nor by more than this, over the diagonal of the drawing, however large it is made later.
FLATNESS_REL = 1e-4
_FARTHEST = 1e9
# What programs add to a drawing beside its layers, as Inkscape does where it saves one of another.
_NOT_DRAWN = frozenset({"", "title", "desc", "defs", "metadata", "style"})
# A circle at the end of a line marks a vertex when it is smaller than this, over the drawing.
_MARK_REL = 0.01

_INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
_LABEL = _INKSCAPE + "label"
# Sizes of a pixel by the program that writes it.
_ILLUSTRATOR_MM, _OLD_INKSCAPE_MM = 25.4 / 72, 25.4 / 90


def read_svg(path: Path, options: ReadOptions) -> LineSoup:
    """The lines of an SVG file.

    Letters are those of `fab.formats.drawn.letters`: by the user's choice, then by data-assignment
    and by the names of the line, its groups and its layer, then by colour. Fold angles are those of
    data-foldAngle, or 180 degrees times the opacity of the stroke, where a mountain or valley of
    the file has one below 1.

    Coordinates are in millimetres where the file has a physical size, else in pixels, of which
    `options.mm_per_unit` gives the size; without it they are those of the program that wrote the
    file: 1/72 inch for Adobe Illustrator, 1/90 for Inkscape before 0.92, else 1/96.

    Raises `InvalidFile` for files that are not SVG, without a line, with images alone, with strokes
    as filled outlines alone, with more than a million lines or coordinates beyond 1e9, with lengths
    that are none, and all that `read_xml` refuses.
    """
    document = read_xml(path)
    root = document.root
    if local_name(root) != "svg":
        tag = root.tag.rpartition("}")[2]
        raise InvalidFile(
            f"{path}: the outermost element is {shown(str(tag))}, not svg. Save the drawing as SVG."
        )
    px_mm, of_program = _pixel(document)
    require_lengths(path, "the outermost svg", "svg", root.attrib)
    page = page_of(root.attrib, options.mm_per_unit if options.mm_per_unit else px_mm)
    mm_per_unit = 1.0 if page.physical else options.mm_per_unit or px_mm
    off_by = FLATNESS_MM / mm_per_unit
    drawing = drawing_of(path, root, page, off_by, options.colours)
    if any(shape.drawn.curves for shape in drawing.shapes):
        finest = FLATNESS_REL * _diagonal(drawing.shapes)
        if 0 < finest < off_by:
            off_by = finest
            drawing = drawing_of(path, root, page, off_by, options.colours)
    taken, as_outlines = _chosen(path, drawing)
    if as_outlines:
        _require_no_outlines_of_strokes(path, taken, mm_per_unit)
    bent = tuple([len(run) > 2 for run in shape.drawn.runs] == [True] for shape in taken)
    coords, element, letters, angles = _lines(path, taken)
    findings = _unit_findings(page, options, px_mm, of_program)
    findings += _clip_findings(taken, drawing, mm_per_unit)
    findings += _left_out_findings(drawing)
    findings += unused_colours(options.colours, drawing.keys)
    curves = sum(shape.drawn.curves for shape in taken)
    if curves:
        chords = len(coords)
        findings.append(
            Finding(
                "curve-flattened",
                Severity.NOTE,
                f"{counted(curves, 'curve')} became chords that leave the curve by up to "
                f"{off_by * mm_per_unit:.3g} mm; the drawing has {counted(chords, 'line')} in all.",
            )
        )
    if as_outlines:
        findings.append(
            Finding(
                "outline-of-fill",
                Severity.WARNING,
                f"nothing in the drawing has a stroke: the outlines of "
                f"{counted(len(taken), 'filled shape')} are taken for its lines, with the letters "
                "of their fills. Give the lines strokes where this is not meant.",
            )
        )
    keep = _no_vertex_marks(coords, element, taken, findings)
    long, short = with_length(coords)
    keep &= long
    findings += short
    soup = LineSoup(
        path,
        _title(root),
        coords[keep] * [1.0, -1.0],
        letters[keep],
        angles[keep],
        element[keep],
        tuple(shape.name for shape in taken),
        mm_per_unit,
        downwards=True,
    )
    if _is_own(root):
        operations = tuple(shape.operation for shape in taken)
        closed = tuple(shape.drawn.closed for shape in taken)
        given = [given_letter(s.colour, [s.operation], options.colours) for s in taken]
        soup = recovered_sheet(soup, operations, closed, bent, given)
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
    if page.physical and not page.by_pixels:
        return unit_named(1.0, options)
    if options.mm_per_unit or (page.physical and not of_program):
        return []
    whose = f"of {of_program}" if of_program else "(1/96 inch)"
    lacks = "coordinates" if page.physical else "size"
    what = f"the file gives its {lacks} in pixels alone: one pixel {whose}"
    return [unit_unknown(what, px_mm)]


def _title(root: ET.Element) -> str:
    for child in root:
        if local_name(child) == "title":
            return " ".join("".join(child.itertext()).split())
    return ""


def _is_own(root: ET.Element) -> bool:
    """Whether the file is one of the sheets that this program draws, or one saved again since."""
    groups = [child for child in root if local_name(child) not in _NOT_DRAWN]
    labels = [group.get("id", "") for group in groups]
    return (
        all(local_name(group) == "g" for group in groups)
        and all(g.get(_LABEL, name) == name for g, name in zip(groups, labels, strict=True))
        and "CUT" in labels
        and labels == [name for name in OPERATIONS if name in labels]
    )


def _chosen(path: Path, drawing: Drawing) -> tuple[list[Shape], bool]:
    """The shapes that are taken, and whether these are outlines of fills."""
    stroked = [shape for shape in drawing.shapes if shape.stroked]
    if stroked:
        without = Counter(
            "filled shapes without a stroke" if shape.filled else "shapes without stroke and fill"
            for shape in drawing.shapes
            if not shape.stroked
        )
        drawing.left_out.update(without)
        for shape in drawing.shapes:
            if shape.filled and not shape.stroked and shape.letter in ("M", "V"):
                drawing.fault("fill", shape.name)
        return stroked, False
    filled = drawing.shapes
    if filled:
        return filled, True
    left_out = {kind: count for kind, count in drawing.left_out.items() if count}
    if set(left_out) == {"images"}:
        raise InvalidFile(
            f"{path}: the drawing has {counted(left_out['images'], 'image')} and no line: it is a "
            "picture of pixels. Trace it to lines with a drawing program, and save those."
        )
    what = f" It has {_listed(left_out)} alone." if left_out else ""
    raise InvalidFile(
        with_lost(
            f"{path}: the drawing has no line.{what} Draw the outline and the creases as lines "
            "with a stroke.",
            _fault_findings(drawing),
        )
    )


def _require_no_outlines_of_strokes(path: Path, shapes: list[Shape], mm_per_unit: float) -> None:
    """Raise `InvalidFile` where filled shapes are drawn lines: each side would become a line."""
    require_few_lines(path, sum(len(run) - 1 for shape in shapes for run in shape.drawn.runs))
    found = outlines_of_strokes(shapes, _diagonal(shapes))
    if not found:
        return
    first, width = found[0]
    which = (
        "is a filled shape" if len(found) == 1 else f"and {len(found) - 1} more are filled shapes"
    )
    raise InvalidFile(
        f"{path}: nothing in the drawing has a stroke, and {first.name} {which} as thin as a drawn "
        f"line, {width * mm_per_unit:.2g} mm: each of its two sides would be a line of the "
        'pattern. Undo "stroke to path" or "outline stroke", or draw the lines with a stroke.'
    )


def _diagonal(shapes: list[Shape]) -> float:
    """Of the box around all shapes, in units of the page; 0 where it is not finite."""
    ends = [run[:: len(run) - 1] for shape in shapes for run in shape.drawn.runs]
    middles = [run[len(run) // 2] for shape in shapes for run in shape.drawn.runs]
    points = np.array([point for pair in ends for point in pair] + middles)
    with np.errstate(over="ignore", invalid="ignore"):
        diagonal = float(np.hypot(*np.ptp(points, axis=0)))
    return diagonal if np.isfinite(diagonal) else 0.0


def _lines(path: Path, shapes: list[Shape]) -> tuple[FloatArray, IntArray, Letters, FloatArray]:
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
        require_few_lines(path, len(ends) // 4)
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
    graded = graded or any(abs(s.angle) < 180 for s in shapes if s.letter in ("M", "V"))
    given = [graded or (shape.letter == "U" and shape.angle != 0) for shape in shapes]
    angle = np.where(given, [shape.angle for shape in shapes], np.nan)
    return coords, element, letters, angle[element]


def _no_vertex_marks(
    coords: FloatArray, element: IntArray, shapes: list[Shape], findings: list[Finding]
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
                f"{counted(len(marks), 'small circle')} at the ends of lines: taken for marks of "
                "vertices, and left out.",
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
    "fill": (
        "fill-of-crease",
        Severity.WARNING,
        "{count} without a stroke in the colour or on the layer of mountains or valleys, the first "
        "is {first}: left out, as no lines. Where they are creases, give them a stroke, or undo "
        '"stroke to path".',
        "filled shape",
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
    "width": (
        "stroke-without-width",
        Severity.NOTE,
        "{count} with a stroke of width 0, the first is {first}: taken for lines, as programs for "
        "lasers write hairlines so, although SVG draws nothing there. Remove them, or their "
        "stroke, where they are not meant.",
        "shape",
    ),
    "shape": (
        "shape-unreadable",
        Severity.WARNING,
        "the data of {count} cannot be read to the end, the first is {first}: what comes before "
        "the fault is taken.",
        "shape",
    ),
}


def _clip_findings(taken: list[Shape], drawing: Drawing, mm_per_unit: float) -> list[Finding]:
    """Lines that are read though a clip hides them, all or in part: no mere fault of `drawing`."""
    count = sum(len(shape.hidden) for shape in taken)
    if not count:
        return []
    del drawing.faults["clip"]
    first = next(shape for shape in taken if shape.hidden)
    x, y = (mm_per_unit * value for value in first.hidden[0])
    text = (
        f"a clip path hides {counted(count, 'line')} in whole or in part, the first of "
        f"{first.name} around ({x:.6g}, {y:.6g}) mm: the lines are taken whole. Cut or remove them "
        "in the drawing program where the rest is not meant, or remove the clip path where it is."
    )
    return [Finding("clip-ignored", Severity.WARNING, text)]


def _left_out_findings(drawing: Drawing) -> list[Finding]:
    out = []
    left_out = {kind: count for kind, count in drawing.left_out.items() if count}
    if left_out:
        out.append(
            Finding("not-lines", Severity.NOTE, f"left out, as no lines: {_listed(left_out)}.")
        )
    return [*out, *_fault_findings(drawing)]


def _fault_findings(drawing: Drawing) -> list[Finding]:
    out = []
    for kind, (code, severity, text, thing) in _FAULTS.items():
        if count := drawing.faults[kind]:
            first = drawing.first_fault[kind]
            out.append(
                Finding(code, severity, text.format(count=counted(count, thing), first=first))
            )
    return out


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(
        f"{count} {_singular(kind) if count == 1 else kind}"
        for kind, count in sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    )


def _singular(kind: str) -> str:
    first, space, rest = kind.partition(" of ")
    plural = {"elements", "figures", "foreignObjects", "images", "references", "rules"}
    plural |= {"shapes", "texts"}
    words = [word[:-1] if word in plural else word for word in first.split(" ")]
    return " ".join(words) + space + rest
