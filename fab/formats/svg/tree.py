"""The tree of an SVG file walked through: every shape that is drawn, where and in which style.

Groups, nested drawings, symbols and `use` are followed, styles inherited; nothing is drawn that the
file hides, defines only, or takes from other files.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fab.errors import InvalidFile
from fab.formats.drawn.letters import colour_of, key_of, letter_of
from fab.formats.drawn.line_soup import LETTERS
from fab.formats.drawn.own_sheets import OPERATIONS
from fab.formats.source_files import shown
from fab.formats.svg.clips import Clip, Clips, clip_of
from fab.formats.svg.conditions import chosen_of, is_meant
from fab.formats.svg.lengths import require_lengths
from fab.formats.svg.shapes import SHAPES, Drawn, Place, Point, drawn_shape
from fab.formats.svg.styles import local_name, style_sheets
from fab.formats.svg.transforms import attribute_transform, product, style_transform
from fab.formats.svg.viewports import (
    IDENTITY,
    Matrix,
    Page,
    length_px,
    origin_of,
    viewport_matrix,
)

__all__ = ["DEEPEST_USE", "MOST_SHAPES", "Drawing", "Shape", "drawing_of"]

# `use` elements may multiply a drawing; deeper ones refer to each other in a circle.
MOST_SHAPES = 200_000
DEEPEST_USE = 32

_INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
_SERIF = "{http://www.serif.com/}"
_XLINK = "{http://www.w3.org/1999/xlink}"
_LABEL = _INKSCAPE + "label"
_GROUPS = frozenset({"g", "a", "svg", "switch", "use"})
_TEXTS = frozenset({"text", "flowRoot"})
_PICTURES = frozenset({"image", "foreignObject"})
_DEFINITIONS = frozenset(
    {
        *("defs", "symbol", "clipPath", "mask", "pattern", "marker", "linearGradient"),
        *("radialGradient", "filter", "style", "script", "title", "desc", "metadata", "font"),
    }
)
# They move what they are in, which is drawn where it begins, or show a part of the drawing.
_MOTIONS = frozenset({"animate", "animateMotion", "animateTransform", "set", "view"})
# Oriedita draws folded figures beside the crease pattern.
_FOLDED_FIGURE = re.compile(r"folded-figure-\d+")


@dataclass(frozen=True)
class _Context:
    """What an element takes from those around it.

    Attributes
    ----------
    names : of the groups around it, innermost first.
    operation : of our own drawings, where its layer is one.
    meant : whether it is for the language and the program that reads the file.
    uses : how many `use` elements it is drawn through.
    label, given : of the `use` element right above it: what it refers to, and the width and height
        that it gives.
    clips : that hold for it.
    """

    matrix: Matrix
    size: tuple[float, float]
    stroke: str = "none"
    fill: str = "black"
    colour: str = "black"
    stroke_opacity: str = "1"
    stroke_width: str = "1"
    visible: bool = True
    hidden: bool = False
    meant: bool = True
    names: tuple[str, ...] = ()
    operation: str = ""
    uses: int = 0
    label: str = ""
    given: tuple[str, str] = ("", "")
    clips: tuple[Clip, ...] = ()


@dataclass
class Shape:
    """One shape that is drawn.

    hidden : the middle of what a clip hides of each of its lines that it cuts off.
    """

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
    hidden: list[Point]


@dataclass
class Drawing:
    """All shapes of a file, what was left out, and keys of colours and names where some have
    letters.
    """

    shapes: list[Shape] = field(default_factory=list)
    left_out: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    first_fault: dict[str, str] = field(default_factory=dict)
    keys: set[str] = field(default_factory=set)

    def fault(self, kind: str, element: str) -> None:
        self.faults[kind] += 1
        self.first_fault.setdefault(kind, element)


def drawing_of(
    path: Path, root: ET.Element, page: Page, tolerance: float, colours: Mapping[str, str]
) -> Drawing:
    """All shapes that a file draws.

    tolerance : how far chords may leave curves, in units of the page. colours : letters that the
    user gives, as in `letter_of`. Raises `InvalidFile` for lengths that are none, and where `use`
    elements draw over 200,000 elements.
    """
    sheets = style_sheets(root)
    known = {key: element for element in root.iter() if (key := element.get("id"))}
    clips = Clips(known, tolerance)
    out = Drawing()
    out.left_out["rules of style sheets"] += sheets.skipped
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
        if tag in _TEXTS or tag in _PICTURES:
            out.left_out["texts" if tag in _TEXTS else f"{tag}s"] += 1
            continue
        shape = tag in SHAPES
        if not shape and tag not in _GROUPS and tag != "symbol":
            out.left_out["elements of unknown kinds"] += tag not in _MOTIONS
            continue
        drawn += around.uses > 0
        if drawn > MOST_SHAPES:
            raise InvalidFile(
                f"{path}: its `use` elements draw more than {MOST_SHAPES} elements. Draw the "
                "lines themselves."
            )
        declared = sheets.of(element)
        inner = _inherited(around, declared)
        if not is_meant(element):
            inner = replace(inner, meant=False)
        identity = element.get("id", "")
        counts[tag] += 1
        name = f"{tag} {shown(identity)}" if identity else f"{tag} {counts[tag]}"
        if inner.visible and not inner.hidden and inner.meant:
            require_lengths(path, name, tag, element.attrib)
        if (matrix := _own_transform(element, declared, inner.size)) is None:
            out.fault("transform", name)
        elif matrix != IDENTITY:
            inner = replace(inner, matrix=product(inner.matrix, matrix))
        if any(declared.get(key, "none") != "none" for key in ("translate", "rotate", "scale")):
            out.fault("transform", name)
        if declared.get("clip-path", "none") != "none" or declared.get("mask", "none") != "none":
            out.fault("clip", name)
            inner = _clipped(inner, element, tag, declared)
        if shape:
            own = (*_names(element), *inner.names)
            found = _shape(element, tag, name, inner, own, declared, tolerance, colours, out)
            if found is not None:
                if inner.clips:
                    found.hidden = clips.cut_off(found.drawn.runs, inner.clips)
                out.shapes.append(found)
            continue
        if _FOLDED_FIGURE.fullmatch(identity):
            out.left_out["folded figures"] += 1
            continue
        if (opacity := _share(declared.get("opacity"), 1.0)) == 0.0:
            inner = replace(inner, hidden=True)
        elif opacity < 1.0:
            out.fault("group-opacity", name)
        inner = _within(element, tag, inner, outermost)
        if tag == "use":
            stack += _used(element, inner, known, out)
            continue
        children = [child for child in element if isinstance(child.tag, str)]
        if tag == "switch":
            stack += reversed(_switched(children, inner))
        else:
            stack += [(child, inner, False) for child in reversed(children)]
    return out


def _switched(
    children: list[ET.Element], context: _Context
) -> list[tuple[ET.Element, _Context, bool]]:
    """The child of a switch that is drawn, and those that are not, where they may have lines."""
    drawable = SHAPES | _GROUPS | _TEXTS | _PICTURES
    chosen = chosen_of([child for child in children if local_name(child) in drawable])
    other = replace(context, meant=False)
    return [
        (child, context if child is chosen else other, False)
        for child in children
        if child is chosen or local_name(child) not in _TEXTS | _PICTURES
    ]


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
        ("stroke-width", "stroke_width"),
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
    label = element.get(_LABEL) or element.get("id", "")
    operation = label if label in OPERATIONS else context.operation
    out = replace(context, names=names, operation=operation, label="", given=("", ""))
    if tag == "svg" or tag == "symbol":
        width, height = context.size
        get = element.attrib.get
        if tag == "svg":
            x, y = length_px(get("x"), width), length_px(get("y"), height)
            out = replace(out, matrix=product(out.matrix, (1.0, 0.0, 0.0, 1.0, x, y)))
        across = length_px(context.given[0] or get("width"), width, width)
        up = length_px(context.given[1] or get("height"), height, height)
        matrix, size = viewport_matrix(element.attrib, across, up)
        out = replace(out, matrix=product(out.matrix, matrix), size=size)
    return out


def _clipped(
    context: _Context, element: ET.Element, tag: str, declared: dict[str, str]
) -> _Context:
    """The context with the clip of an element, in its user space."""
    matrix, size = context.matrix, context.size
    if tag == "use":
        x, y = length_px(element.get("x"), size[0]), length_px(element.get("y"), size[1])
        matrix = product(matrix, (1.0, 0.0, 0.0, 1.0, x, y))
    clip = clip_of(declared.get("clip-path", ""), matrix, size)
    return context if clip is None else replace(context, clips=(*context.clips, clip))


def _used(
    element: ET.Element, context: _Context, known: dict[str, ET.Element], out: Drawing
) -> list[tuple[ET.Element, _Context, bool]]:
    """What a `use` element draws."""
    get = element.attrib.get
    target = (get("href") or get(_XLINK + "href") or "").strip()
    if not target.startswith("#"):
        out.left_out["references to other files"] += 1
        return []
    found = known.get(target[1:])
    if found is None or context.uses >= DEEPEST_USE:
        out.fault("use", f"use of {shown(target)}")
        return []
    width, height = context.size
    x, y = length_px(get("x"), width), length_px(get("y"), height)
    inner = replace(
        context,
        matrix=product(context.matrix, (1.0, 0.0, 0.0, 1.0, x, y)),
        uses=context.uses + 1,
        label=local_name(found),
        given=(get("width", ""), get("height", "")),
    )
    return [(found, inner, False)]


def _own_transform(
    element: ET.Element, declared: dict[str, str], size: tuple[float, float]
) -> Matrix | None:
    """The transform of an element, by its style before its attribute; None where none is read."""
    if (text := declared.get("transform")) is not None:
        return _about_origin(style_transform(text), declared, size)
    if (text := element.get("transform")) is not None:
        return _about_origin(attribute_transform(text), declared, size)
    return IDENTITY


def _about_origin(
    matrix: Matrix | None, declared: dict[str, str], size: tuple[float, float]
) -> Matrix | None:
    """A transform about its transform-origin; None where either cannot be read."""
    if matrix is None or "transform-origin" not in declared:
        return matrix
    origin = origin_of(declared["transform-origin"], size)
    if origin is None or declared.get("transform-box", "view-box") != "view-box":
        return None
    x, y = origin
    moved = product((1.0, 0.0, 0.0, 1.0, x, y), matrix)
    return product(moved, (1.0, 0.0, 0.0, 1.0, -x, -y))


def _share(text: str | None, default: float) -> float:
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
    colours: Mapping[str, str],
    out: Drawing,
) -> Shape | None:
    if context.hidden or not context.visible:
        out.left_out["hidden shapes"] += 1
        return None
    if not context.meant:
        out.left_out["shapes for other languages or programs"] += 1
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
    if stroked and length_px(context.stroke_width, 1.0, 1.0) == 0:
        out.fault("width", name)
    colour = stroke if stroked else fill if filled else None
    letter = letter_of(colour, names, colours)
    if colours:
        out.keys.update(map(key_of, [*names, *([] if colour is None else [colour])]))
    alpha = 1.0
    if stroked and (found := colour_of(stroke)) is not None:
        alpha = found[1]
    opacity = alpha * _share(declared.get("opacity"), 1.0)
    opacity *= _share(context.stroke_opacity, 1.0)
    sign = {"M": -1.0, "V": 1.0, "U": 0.0}.get(letter or "")
    angle = np.nan
    if sign is not None:
        angle = 180.0 * sign * opacity + 0.0 if sign else np.nan
        given = element.get("data-foldAngle")
        if given is not None:
            try:
                value = float(given)
            except ValueError:
                value = np.nan
            if abs(value) <= 180 and value * sign >= 0:
                angle = value + 0.0
    return Shape(
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
        [],
    )


def _is_none(paint: str) -> bool:
    plain = paint.strip().lower()
    if plain in ("none", "transparent", ""):
        return True
    found = colour_of(plain)
    return found is not None and found[1] == 0.0
