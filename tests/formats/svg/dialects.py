"""Crease patterns as SVG files in the manners of the programs that people save them with.

Each dialect does what files of that program do: its units, how it groups lines and says what they
are, where it puts transforms and styles, how far it rounds. What it cannot say comes out as what it
draws instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np
from helpers import PATTERNS

from fab import read_pattern
from fab.formats.svg.writer import simulator_svg_bytes

# Size of a pixel by who counts them, mm.
CSS, ILLUSTRATOR, OLD_INKSCAPE = 25.4 / 96, 25.4 / 72, 25.4 / 90


@dataclass(frozen=True)
class Source:
    """Lines to be drawn: both ends in mm, y upwards, letters, and fold angles in degrees."""

    coords: np.ndarray
    letters: np.ndarray
    angles: np.ndarray

    def as_letters(self, **instead: str) -> Source:
        """The lines with some letters exchanged."""
        letters = np.array([instead.get(str(letter), letter) for letter in self.letters])
        return replace(self, letters=letters)


@dataclass(frozen=True)
class Written:
    """A file, what it holds, and whether it has fold angles."""

    text: str
    lines: Source
    angles: bool = False


def source(*lines: tuple) -> Source:
    """Lines given as (letter, x, y, x, y), or with the fold angle after these."""
    letters = np.array([line[0] for line in lines])
    default = {"M": -180.0, "V": 180.0}
    angles = [line[5] if len(line) > 5 else default.get(line[0], 0.0) for line in lines]
    coords = np.array([line[1:5] for line in lines], float).reshape(-1, 2, 2)
    return Source(coords, letters, np.array(angles))


def box(size: float, height: float | None = None) -> list[tuple]:
    up = size if height is None else height
    corners = [(0, 0), (size, 0), (size, up), (0, up), (0, 0)]
    return [("B", *p, *q) for p, q in pairwise(corners)]


def blintz() -> Source:
    half = [(50, 0), (100, 50), (50, 100), (0, 50), (50, 0)]
    folds = [("V", *p, *q) for p, q in pairwise(half)]
    return source(*box(100), *folds)


def fish_base() -> Source:
    s = 100 * math.tan(math.pi / 8)
    lines = [("V", 0, 0, 100, 100)]
    for x, y in ((100, s), (s, 100)):  # creases of the upper flaps
        lines.append(("M", 0, 0, x, y))
    for x, y in ((0, 100 - s), (100 - s, 0)):
        lines.append(("V", 100, 100, x, y))
    return source(*box(100), *lines)


def map_fold() -> Source:
    lines = [("M" if i % 2 else "V", 30 * i, 0, 30 * i, 30) for i in range(1, 4)]
    lines += [("V" if i % 2 else "M", 30 * i, 30, 30 * i, 60) for i in range(1, 4)]
    lines += [("V", 30 * i, 30, 30 * i + 30, 30) for i in range(4)]
    return source(*box(120, 60), *lines)


def pinwheel() -> Source:
    """Unlike its mirror image."""
    lines = []
    for turn in range(4):
        c, s = round(math.cos(turn * math.pi / 2)), round(math.sin(turn * math.pi / 2))
        for letter, x, y, u, v in [
            ("M", 20, 20, 60, 20),
            ("V", 20, 20, 20, -20),
            ("F", 9, 3, 20, 20),
        ]:
            p = (60 + c * x - s * y, 60 + s * x + c * y)
            q = (60 + c * u - s * v, 60 + s * u + c * v)
            lines.append((letter, *p, *q))
    return source(*box(120), *lines)


def hypar() -> Source:
    """Angles of pleats of 115 degrees; diagonals are free."""
    lines = [("U", 0, 0, 90, 90), ("U", 90, 0, 0, 90)]
    for ring in range(1, 4):
        low, high = 10 * ring, 90 - 10 * ring
        corners = [(low, low), (high, low), (high, high), (low, high), (low, low)]
        letter, angle = ("M", -115.0) if ring % 2 else ("V", 115.0)
        lines += [(letter, *p, *q, angle) for p, q in pairwise(corners)]
    return source(*box(90), *lines)


def kresling(sides: int = 6) -> Source:
    lines = []
    for i in range(sides):
        x = 20.0 * i
        lines.append(("M", x, 0, x + 7, 30, -60.0) if i else ("B", x, 0, x + 7, 30))
        lines.append(("V", x + 20, 0, x + 7, 30, 75.0))
        lines += [("B", x, 0, x + 20, 0), ("B", x + 7, 30, x + 27, 30)]
    x = 20.0 * sides
    return source(*lines, ("B", x, 0, x + 7, 30))


def slits() -> Source:
    """Cuts, a facet crease, and creases of several angles."""
    return source(
        *box(80, 50),
        ("C", 20, 10, 20, 40),
        ("C", 60, 10, 60, 40),
        ("V", 20, 25, 40, 25, 90.0),
        ("M", 40, 10, 40, 40, -45.0),
        ("F", 20, 10, 40, 25),
    )


OWN = {
    "blintz": blintz,
    "fish_base": fish_base,
    "hypar": hypar,
    "kresling": kresling,
    "map_fold": map_fold,
    "pinwheel": pinwheel,
    "slits": slits,
}
NAMES = sorted([*OWN, *(path.stem for path in PATTERNS.glob("*.fold"))])


@cache
def pattern(name: str):
    return read_pattern(PATTERNS / f"{name}.fold")[0]


@cache
def lines_of(name: str) -> Source:
    """A pattern by its name, about 120 mm wide, its corner at the origin."""
    if name in OWN:
        return OWN[name]()
    found = pattern(name)
    scale = 120 / np.ptp(found.vertices_coords[:, 0])
    coords = found.vertices_coords[found.edges_vertices] * scale
    letters = found.edges_assignment.copy()
    angles = found.edges_foldAngle.copy()
    letters[np.isin(letters, ["M", "V"]) & (angles == 0)] = "F"
    return Source(coords - coords.min(axis=(0, 1)), letters, angles)


def _page(
    lines: Source, unit_mm: float, digits: int, margin: float
) -> tuple[np.ndarray, float, float]:
    """Ends in units of the file, y downwards, rounded; and the size of the page."""
    low, high = lines.coords.min(axis=(0, 1)), lines.coords.max(axis=(0, 1))
    width, height = (high - low) / unit_mm + 2 * margin
    ends = (lines.coords - low) / unit_mm + margin
    ends[..., 1] = height - ends[..., 1]
    return np.round(ends, digits), float(width), float(height)


def _held(lines: Source, ends: np.ndarray, unit_mm: float) -> Source:
    return replace(lines, coords=ends * [1, -1] * unit_mm)


def _rows(ends: np.ndarray) -> list[list[float]]:
    return ends.reshape(-1, 4).tolist()


def _by_letter(lines: Source, ends: np.ndarray) -> Iterable[tuple[str, list[list[float]]]]:
    for letter in sorted(set(lines.letters.tolist())):
        yield letter, _rows(ends[lines.letters == letter])


def inkscape(lines: Source) -> Written:
    """Inkscape 1: millimetres, layers with transforms, relative paths, all in the style."""
    lines = lines.as_letters(J="F")
    names = {"B": "Outline", "M": "Mountain folds", "V": "Valley folds", "C": "Cuts"}
    names |= {"F": "Flat", "U": "Hinges"}
    ends, width, height = _page(lines, 1.0, 9, 5.0)
    out = [
        '<?xml version="1.0" encoding="UTF-8" standalone="no"?>',
        "<!-- Created with Inkscape (http://www.inkscape.org/) -->",
        f'<svg width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}" version="1.1" '
        'id="svg5" inkscape:version="1.2.2 (b0a8486541, 2022-12-01)" sodipodi:docname="cp.svg" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        'xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd" '
        'xmlns="http://www.w3.org/2000/svg" xmlns:svg="http://www.w3.org/2000/svg">',
        '<sodipodi:namedview id="namedview7" pagecolor="#ffffff" inkscape:document-units="mm">'
        '<inkscape:grid type="xygrid" id="grid1"/></sodipodi:namedview><defs id="defs2"/>',
    ]
    number = 100
    for layer, (letter, rows) in enumerate(_by_letter(lines, ends)):
        shift = 10.0 * layer
        out.append(
            f'<g inkscape:label="{names[letter]}" inkscape:groupmode="layer" id="layer{layer + 1}" '
            f'transform="translate({shift},{-shift})">'
        )
        for x, y, u, v in rows:
            number += 1
            out.append(
                '<path style="fill:none;stroke:#1a1a1a;stroke-width:0.264583px;stroke-linecap:butt;'
                'stroke-linejoin:miter;stroke-opacity:1" '
                f'd="m {x - shift:.9f},{y + shift:.9f} {u - x:.9f},{v - y:.9f}" id="path{number}"/>'
            )
        out.append("</g>")
    return Written("\n".join([*out, "</svg>"]), _held(lines, ends, 1.0))


def inkscape_048(lines: Source) -> Written:
    """Inkscape before 0.92: pixels of 1/90 inch, no viewBox, colours by hand."""
    lines = lines.as_letters(J="F")
    colours = {"B": "#000000", "M": "#ff0000", "V": "#0000ff", "C": "#00ff00"}
    colours |= {"F": "#ffff00", "U": "#ff00ff"}
    ends, width, height = _page(lines, OLD_INKSCAPE, 7, 20.0)
    out = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" id="svg2" '
        'version="1.1" inkscape:version="0.48.4 r9939" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape">',
        '<g inkscape:label="Layer 1" inkscape:groupmode="layer" id="layer1">',
    ]
    for letter, rows in _by_letter(lines, ends):
        for x, y, u, v in rows:
            out.append(
                f'<path d="M {x:.7f},{y:.7f} {u:.7f},{v:.7f}" style="color:#000000;fill:none;'
                f'stroke:{colours[letter]};stroke-width:1px;stroke-opacity:1;display:inline"/>'
            )
    return Written("\n".join([*out, "</g></svg>"]), _held(lines, ends, OLD_INKSCAPE))


def illustrator(lines: Source) -> Written:
    """Illustrator's "save as": points as pixels, a document type with entities, process colours."""
    lines = lines.as_letters(J="F")
    colours = {"B": "#231F20", "M": "#ED1C24", "V": "#2E3192", "C": "#00A651"}
    colours |= {"F": "#FFF200", "U": "#EC008C"}
    ends, width, height = _page(lines, ILLUSTRATOR, 3, 0.0)
    out = [
        '<?xml version="1.0" encoding="utf-8"?>',
        "<!-- Generator: Adobe Illustrator 16.0.3, SVG Export Plug-In . SVG Version: 6.00 -->",
        '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
        '"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [',
        '\t<!ENTITY ns_extend "http://ns.adobe.com/Extensibility/1.0/">',
        '\t<!ENTITY ns_svg "http://www.w3.org/2000/svg">\n]>',
        f'<svg version="1.1" id="Layer_1" xmlns="&ns_svg;" xmlns:x="&ns_extend;" x="0px" y="0px"\n'
        f'\t width="{width:.3f}px" height="{height:.3f}px" viewBox="0 0 {width:.3f} {height:.3f}" '
        f'enable-background="new 0 0 {width:.3f} {height:.3f}" xml:space="preserve">',
        '<switch><foreignObject requiredExtensions="&ns_extend;" width="1" height="1"/>'
        '<g x:extraneous="self">',
    ]
    for x, y, u, v, letter, angle in zip(
        *ends.reshape(-1, 4).T.tolist(), lines.letters.tolist(), lines.angles.tolist(), strict=True
    ):
        share = abs(angle) / 180
        opacity = f'opacity="{share:.10g}" ' if letter in "MV" and share < 1 else ""
        tag = (
            f'line {opacity}fill="none" stroke="{colours[letter]}" stroke-miterlimit="10" '
            f'x1="{x:.3f}" y1="{y:.3f}" x2="{u:.3f}" y2="{v:.3f}"'
        )
        out.append(f"<{tag}/>")
    return Written("\n".join([*out, "</g></switch></svg>"]), _held(lines, ends, ILLUSTRATOR), True)


def illustrator_export(lines: Source) -> Written:
    """Illustrator's "export as": classes of a style sheet, several paths in one."""
    lines = lines.as_letters(J="F")
    colours = {"B": "#000", "M": "red", "V": "blue", "C": "lime", "F": "#ff0", "U": "#f0f"}
    ends, width, height = _page(lines, ILLUSTRATOR, 2, 3.0)
    kinds = list(_by_letter(lines, ends))
    rules = "".join(
        f".cls-{i + 1}{{stroke:{colours[letter]};}}" for i, (letter, _) in enumerate(kinds)
    )
    every = ",".join(f".cls-{i + 1}" for i in range(len(kinds)))
    out = [
        f'<svg id="Layer_1" data-name="Layer 1" xmlns="http://www.w3.org/2000/svg" '
        f'viewBox="0 0 {width:.2f} {height:.2f}"><defs><style>{every}{{fill:none;'
        f"stroke-miterlimit:10;}}{rules}</style></defs><title>cp</title>"
    ]
    for i, (_, rows) in enumerate(kinds):
        for x, y, u, v in rows:
            out.append(
                f'<line class="cls-{i + 1}" x1="{x:.2f}" y1="{y:.2f}" x2="{u:.2f}" y2="{v:.2f}"/>'
            )
    return Written("".join([*out, "</svg>"]), _held(lines, ends, ILLUSTRATOR))


def affinity(lines: Source) -> Written:
    """Affinity Designer: the size in percent, groups as layers, matrices, numbers with commas."""
    lines = lines.as_letters(J="F")
    names = {"B": "Border", "M": "Mountain", "V": "Valley", "C": "Cut", "F": "Facet", "U": "Hinge"}
    ends, width, height = _page(lines, CSS, 6, 12.0)
    out = [
        '<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n'
        '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
        '"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">',
        f'<svg width="100%" height="100%" viewBox="0 0 {width} {height}" version="1.1" '
        'xmlns="http://www.w3.org/2000/svg" xml:space="preserve" '
        'xmlns:serif="http://www.serif.com/" style="fill-rule:evenodd;clip-rule:evenodd;'
        'stroke-linecap:round;stroke-linejoin:round;stroke-miterlimit:1.5;">',
        f'<g id="Artboard1" serif:id="Artboard 1" transform="matrix(2,0,0,2,{-width},{-height})">',
    ]
    for letter, rows in _by_letter(lines, ends):
        out.append(f'<g id="{names[letter]}-1" serif:id="{names[letter]}">')
        for x, y, u, v in rows:
            x, u, y, v = (x + width) / 2, (u + width) / 2, (y + height) / 2, (v + height) / 2
            out.append(
                f'<path d="M{x:.9f},{y:.9f}L{u:.9f},{v:.9f}" '
                'style="fill:none;stroke:rgb(87,87,86);stroke-width:0.5px;"/>'
            )
        out.append("</g>")
    return Written("\n".join([*out, "</g></svg>"]), _held(lines, ends, CSS))


def origami_simulator(lines: Source) -> Written:
    """What Origami Simulator saves: lines with short colours and opacities, a viewBox alone."""
    lines = lines.as_letters(J="F")
    colours = {"B": "#000", "M": "#f00", "V": "#00f", "C": "#0f0", "F": "#ff0", "U": "#f0f"}
    ends, width, height = _page(lines, CSS, 12, 0.0)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-9.5 -9.5 {width + 19} {height + 19}">'
    ]
    for x, y, u, v, letter, angle in zip(
        *ends.reshape(-1, 4).T.tolist(), lines.letters.tolist(), lines.angles.tolist(), strict=True
    ):
        opacity = abs(angle) / 180 if letter in "MV" else 1
        out.append(
            f'<line stroke="{colours[letter]}" opacity="{opacity!r}" x1="{x!r}" y1="{y!r}" '
            f'x2="{u!r}" y2="{v!r}" stroke-width="1.8867"/>'
        )
    return Written("".join([*out, "</svg>"]), _held(lines, ends, CSS), True)


def rabbit_ear(lines: Source) -> Written:
    """Rabbit Ear: named colours, classes, data attributes; no unit."""
    names = {"B": "boundary", "M": "mountain", "V": "valley", "F": "flat"}
    names |= {"J": "join", "C": "cut", "U": "unassigned"}
    colours = {"B": "black", "M": "crimson", "V": "royalblue", "F": "lightgray"}
    colours |= {"J": "gold", "C": "limegreen", "U": "orchid"}
    ends, width, height = _page(lines, CSS, 12, 0.0)
    out = [
        f'<svg version="1.1" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width!r} {height!r}" '
        'stroke-width="0.01" class="creasePattern"><g class="edges" stroke="black">'
    ]
    for letter in names:
        out.append(f'<g class="{names[letter]}" stroke="{colours[letter]}">')
        own = lines.letters == letter
        for (x, y, u, v), angle in zip(_rows(ends[own]), lines.angles[own].tolist(), strict=True):
            opacity = f' opacity="{abs(angle) / 180}"' if angle not in (0, 180, -180) else ""
            out.append(
                f'<line x1="{x!r}" y1="{y!r}" x2="{u!r}" y2="{v!r}" data-foldAngle="{angle!r}" '
                f'data-assignment="{letter}"{opacity}/>'
            )
        out.append("</g>")
    return Written("".join([*out, "</g></svg>"]), _held(lines, ends, CSS), True)


def rabbit_ear_old(lines: Source) -> Written:
    """The forerunner of Rabbit Ear: blue mountains, red valleys, and classes that say so."""
    lines = lines.as_letters(J="F", U="F", C="B")
    names = {"B": "boundary", "M": "mountain", "V": "valley", "F": "mark"}
    ends, width, height = _page(lines, CSS, 9, 1.0)
    style = (
        "svg * {stroke-width:var(--crease-width);stroke-linecap:round;stroke:black;}\n"
        "polygon {fill:none; stroke:none; stroke-linejoin:bevel;}\n.mark {stroke:#AAA;}\n"
        ".mountain {stroke:#00F;}\n.valley{stroke:#F00;stroke-dasharray:"
        "calc(var(--crease-width)*2) calc(var(--crease-width)*2);}\n"
        ".foldedForm .creases line { stroke:none; }"
    )
    faces = f'<g class="faces"><polygon points="0,0 {width},0 {width},{height}"/></g>'
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}px" height="{height}px" '
        f'viewBox="0 0 {width} {height}"><style><![CDATA[{style}]]></style>{faces}'
        '<g class="creases">'
    ]
    for letter, rows in _by_letter(lines, ends):
        for x, y, u, v in rows:
            out.append(
                f'<line class="{names[letter]}" x1="{x:.9f}" y1="{y:.9f}" x2="{u:.9f}" '
                f'y2="{v:.9f}"/>'
            )
    return Written("\n".join([*out, "</g></svg>"]), _held(lines, ends, CSS))


def oriedita(lines: Source) -> Written:
    """Oriedita: a viewBox that is none, two digits, dash arrays, vertices as squares."""
    lines = lines.as_letters(J="F", C="B")
    colours = {"B": "black", "M": "red", "V": "blue", "F": "#64c8c8", "U": "orange"}
    dashes = {"M": 'stroke-dasharray="10 3 3 3"', "V": 'stroke-dasharray="8 8"'}
    ends, width, height = _page(lines, CSS, 2, 40.0)
    out = [
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'viewBox="40.0 40.0 {width - 40} {height - 40}">\n<g id="crease-pattern">'
    ]
    for x, y, u, v, letter in zip(*ends.reshape(-1, 4).T.tolist(), lines.letters, strict=True):
        out.append(
            f'<line x1="{x}" y1="{y}" x2="{u}" y2="{v}" {dashes.get(letter, "")}  '
            f'stroke="{colours[letter]}" stroke-width="1" />'
        )
        for a, b in ((x, y), (u, v)):
            out.append(
                f'<rect style="fill:#000000;stroke:none" width="2.0" height="2.0" x="{a - 1}" '
                f'y="{b - 1}" />'
            )
    out.append('</g>\n<g id="text"><text x="3" y="4"><tspan x="3" y="4">cp</tspan></text></g>')
    out.append('<g id="folded-figure-0"><path d="M 1 1 L 9 1 L 5 7 Z" style="stroke:black"/></g>')
    return Written("\n".join([*out, "</svg>"]), _held(lines, ends, CSS))


def oripa(lines: Source) -> Written:
    """ORIPA: 1000 pixels wide, an external document type, every style in full."""
    lines = lines.as_letters(J="?", F="?", C="B", U="?")
    colours = {"B": "black", "M": "red", "V": "blue", "?": "gray"}
    width = float(np.ptp(lines.coords[..., 0]))
    unit = width / 1000
    ends, _, _ = _page(lines, unit, 12, 0.0)
    out = [
        '<?xml version="1.0" encoding="ISO-8859-1" standalone="no"?>\n'
        '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 20010904//EN"\n'
        '"http://www.w3.org/TR/2001/REC-SVG-20010904/DTD/svg10.dtd">\n'
        '<svg xmlns="http://www.w3.org/2000/svg"\n xmlns:xlink="http://www.w3.org/1999/xlink" '
        'xml:space="preserve"\n width="1000px" height="1000px"\n viewBox="0 0 1000 1000" >'
    ]
    for x, y, u, v, letter in zip(*ends.reshape(-1, 4).T.tolist(), lines.letters, strict=True):
        out.append(
            f' <path style="fill:none;stroke:{colours[letter]};stroke-width:2.000000px;'
            "stroke-linecap:round;stroke-linejoin:round;stroke-opacity:1;fill-opacity:1.000000"
            f'"\n  d="M {x!r},{y!r} L {u!r},{v!r}" />'
        )
    return Written("\n".join([*out, "</svg>"]), _held(lines, ends, CSS))


def lightburn(lines: Source) -> Written:
    """LightBurn: millimetres, a matrix on each path, colours of its palette, no names."""
    lines = lines.as_letters(J="F")
    colours = {"B": "#000000", "M": "#FF0000", "V": "#0000FF", "C": "#00E000"}
    colours |= {"F": "#D0D000", "U": "#FF00FF"}
    ends, width, height = _page(lines, 1.0, 6, 0.0)
    out = [
        '<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n<!-- Created with LightBurn -->',
        f'<svg xmlns="http://www.w3.org/2000/svg" version="1.1" width="{width:.6f}mm" '
        f'height="{height:.6f}mm" viewBox="-3 -7 {width:.6f} {height:.6f}">',
    ]
    for x, y, u, v, letter in zip(*ends.reshape(-1, 4).T.tolist(), lines.letters, strict=True):
        out.append(
            f'<path transform="matrix(0 1 -1 0 {x - 3:.6f} {y - 7:.6f})" '
            f'style="stroke:{colours[letter]};stroke-width:0.050000mm;fill:none" '
            f'd="M0.000000,0.000000L{v - y:.6f},{x - u:.6f}"/>'
        )
    return Written("\n".join([*out, "</svg>"]), _held(lines, ends, 1.0))


def cad(lines: Source) -> Written:
    """A CAD program: centimetres, a group turned upside down, one path for each kind."""
    lines = lines.as_letters(J="F")
    names = {"B": "profile outline", "M": "bend-mountain", "V": "bend-valley"}
    names |= {"C": "CUT_2", "F": "auxiliary", "U": "score"}
    ends, width, height = _page(lines, 10.0, 9, 0.0)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}cm" height="{height}cm" '
        f'viewBox="0 0 {width} {height}"><g transform="translate(0,{height}) scale(1,-1)" '
        'fill="none" stroke="rgb(0,0,0)" stroke-width="0.01">'
    ]
    for letter, rows in _by_letter(lines, ends):
        data = "".join(f"M{x!r},{height - y!r}L{u!r} {height - v!r}" for x, y, u, v in rows)
        out.append(f'<path id="{names[letter]}" d="{data}"/>')
    return Written("\n".join([*out, "</g></svg>"]), _held(lines, ends, 10.0))


DIALECTS: dict[str, Callable[[Source], Written]] = {
    kind.__name__: kind
    for kind in (
        affinity,
        cad,
        illustrator,
        illustrator_export,
        inkscape,
        inkscape_048,
        lightburn,
        oriedita,
        origami_simulator,
        oripa,
        rabbit_ear,
        rabbit_ear_old,
    )
}


def ours(name: str) -> Written:
    """The SVG that `convert` writes for Origami Simulator."""
    found = pattern(name)
    ends = found.vertices_coords[found.edges_vertices]
    lines = Source(ends, found.edges_assignment, found.edges_foldAngle)
    return Written(simulator_svg_bytes(found, name).decode(), lines, True)
