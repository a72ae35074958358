"""Shapes of SVG as runs of straight lines: curves become chords within a stated distance."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fab.formats.svg.viewports import Matrix, length_px, numbers

__all__ = ["SHAPES", "Drawn", "Place", "drawn_shape"]

SHAPES = frozenset({"path", "line", "polyline", "polygon", "rect", "circle", "ellipse"})
# A chord more, and nobody would see it; it bounds what one element can ask for.
_MOST_CHORDS = 20_000
# Control points nearer to their chord, over its length, make no curve.
_STRAIGHT_REL = 1e-9
_STRAIGHT_PATH = re.compile(r"[MmLlHhVvZz0-9eE+\-.,\s]*")
_TOKEN = re.compile(r"[MmLlHhVvZz]|[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?|[^\s,]")
_COMMAND = re.compile(r"(?=[MmLlHhVvZzCcSsQqTtAa])")

Point = tuple[float, float]


@dataclass(frozen=True)
class Place:
    """Where a shape is drawn.

    Attributes
    ----------
    matrix : from its user space to the page.
    size : of the user space, for percentages.
    tolerance : how far chords may leave a curve, on the page.
    """

    matrix: Matrix
    size: tuple[float, float]
    tolerance: float


@dataclass
class Drawn:
    """A shape on the page.

    Attributes
    ----------
    runs : points of each run of lines; closed ones end where they began.
    curves : how many curves became chords.
    closed : whether all runs are closed.
    broken : whether the data could be read in part only.
    """

    runs: list[list[Point]] = field(default_factory=list)
    curves: int = 0
    closed: bool = True
    broken: bool = False

    def add(self, run: list[Point], *, closed: bool) -> None:
        """One more run, where it has a line."""
        if len(run) > 1:
            self.runs.append(run)
            self.closed = self.closed and closed


def drawn_shape(tag: str, attributes: Mapping[str, str], place: Place) -> Drawn:
    """The lines of a shape; `tag` is one of `SHAPES`."""
    width, height = place.size

    def x_of(name: str) -> float:
        return length_px(attributes.get(name), width)

    def y_of(name: str) -> float:
        return length_px(attributes.get(name), height)

    match tag:
        case "line":
            ends = [(x_of("x1"), y_of("y1")), (x_of("x2"), y_of("y2"))]
            return Drawn([_placed(ends, place.matrix)], closed=False)
        case "polyline" | "polygon":
            values = numbers(attributes.get("points", ""))
            points = list(zip(values[::2], values[1::2], strict=False))
            closed = tag == "polygon"
            if closed and len(points) > 1:
                points.append(points[0])
            runs = [_placed(points, place.matrix)] if len(points) > 1 else []
            return Drawn(runs, closed=closed, broken=len(values) % 2 > 0)
        case "rect":
            return _rectangle(attributes, place)
        case "circle" | "ellipse":
            if tag == "circle":
                diagonal = math.hypot(width, height) / math.sqrt(2)
                rx = ry = length_px(attributes.get("r"), diagonal)
            else:
                rx, ry = _radii(attributes, place.size)
            if not (rx > 0 and ry > 0):
                return Drawn()
            middle = (x_of("cx"), y_of("cy"))
            ring = _arc(middle, (rx, 0.0), (0.0, ry), 0.0, 2 * math.pi, place)
            return Drawn([[*ring[:-1], ring[0]]], curves=1)
    return _path(attributes.get("d", ""), place)


def _placed(points: list[Point], matrix: Matrix) -> list[Point]:
    a, b, c, d, e, f = matrix
    return [(a * x + c * y + e, b * x + d * y + f) for x, y in points]


def _radii(attributes: Mapping[str, str], size: tuple[float, float]) -> tuple[float, float]:
    """The radii rx and ry, of which one may follow the other."""
    rx = length_px(attributes.get("rx"), size[0], -1.0)
    ry = length_px(attributes.get("ry"), size[1], -1.0)
    if rx < 0 and ry < 0:
        return 0.0, 0.0
    return (ry if rx < 0 else rx), (rx if ry < 0 else ry)


def _rectangle(attributes: Mapping[str, str], place: Place) -> Drawn:
    width, height = place.size
    x, y = length_px(attributes.get("x"), width), length_px(attributes.get("y"), height)
    across = length_px(attributes.get("width"), width)
    up = length_px(attributes.get("height"), height)
    if not (across > 0 and up > 0):
        return Drawn()
    rx, ry = _radii(attributes, place.size)
    rx, ry = min(rx, across / 2), min(ry, up / 2)
    if not (rx > 0 and ry > 0):
        corners = [(x, y), (x + across, y), (x + across, y + up), (x, y + up), (x, y)]
        return Drawn([_placed(corners, place.matrix)])
    ring: list[Point] = []
    middles = [(x + across - rx, y + ry), (x + across - rx, y + up - ry)]
    middles += [(x + rx, y + up - ry), (x + rx, y + ry)]
    for quarter, middle in enumerate(middles):
        start = (quarter - 1) * math.pi / 2
        ring += _arc(middle, (rx, 0.0), (0.0, ry), start, start + math.pi / 2, place)
    return Drawn([[*ring, ring[0]]], curves=4)


def _arc(
    middle: Point, across: Point, up: Point, begin: float, end: float, place: Place
) -> list[Point]:
    """Points on the page of middle + across cos t + up sin t, t from begin to end.

    Numbers beyond the range of floats give points that are not finite, which `read_svg` refuses.
    """
    a, b, c, d, e, f = place.matrix
    linear = np.array([[a, c], [b, d]])
    with np.errstate(over="ignore", invalid="ignore"):
        frame = linear @ np.array([across, up]).T
    radius = float(np.linalg.norm(frame, 2)) if np.isfinite(frame).all() else math.inf
    if not math.isfinite(radius) or not radius > 0:
        count = 1
    else:
        half = math.acos(max(1 - place.tolerance / radius, 0.0))
        count = math.ceil(abs(end - begin) / (2 * half)) if half > 0 else _MOST_CHORDS
    count = min(max(count, 1 if abs(end - begin) < math.pi else 3), _MOST_CHORDS)
    t = np.linspace(begin, end, count + 1)
    with np.errstate(over="ignore", invalid="ignore"):
        centre = linear @ np.array(middle) + [e, f]
        points = np.column_stack([np.cos(t), np.sin(t)]) @ frame.T + centre
    return [(x, y) for x, y in points.tolist()]


def _bezier(controls: list[Point], place: Place) -> list[Point]:
    """Points on the page of a Bézier curve of degree 2 or 3, with these control points."""
    points = np.array(_placed(controls, place.matrix))
    degree = len(points) - 1
    with np.errstate(over="ignore", invalid="ignore"):
        bend = float(np.hypot(*np.diff(points, n=2, axis=0).T).max())
        if not math.isfinite(bend) or _is_straight(points):
            ends = points[[0, -1]]
        else:
            wanted = math.sqrt(degree * (degree - 1) / 8 * bend / place.tolerance)
            count = max(1, math.ceil(min(wanted, _MOST_CHORDS)))
            t = np.linspace(0.0, 1.0, count + 1)[:, None]
            weights = [
                math.comb(degree, k) * t**k * (1 - t) ** (degree - k) for k in range(degree + 1)
            ]
            ends = sum(weight * point for weight, point in zip(weights, points, strict=True))
            ends[0], ends[-1] = points[0], points[-1]
    return [(x, y) for x, y in ends.tolist()]


def _is_straight(points: Any) -> bool:
    chord = points[-1] - points[0]
    length = float(np.hypot(*chord))
    if length == 0:
        return False
    inner, unit = points[1:-1] - points[0], chord / length
    along = inner @ unit
    off = np.abs(inner[:, 0] * unit[1] - inner[:, 1] * unit[0])
    near = _STRAIGHT_REL * length
    return bool((off <= near).all() and (along >= -near).all() and (along <= length + near).all())


def _path(data: str, place: Place) -> Drawn:
    if _STRAIGHT_PATH.fullmatch(data):
        return _straight_path(data, place.matrix)
    import svgelements

    try:
        path, broken = svgelements.Path(data), False
    except (ValueError, IndexError, TypeError, ArithmeticError, AttributeError):
        path, broken = _readable_part(data), True
    out = Drawn(closed=True, broken=broken)
    run: list[Point] = []

    def finish(closed: bool) -> None:
        nonlocal run
        out.add(run, closed=closed)
        run = []

    for segment in path:
        end = segment.end
        if end is None:
            continue
        if end.x is None or end.y is None:  # what svgelements makes of words such as NaN
            out.broken = True
            break
        if isinstance(segment, svgelements.Move):
            finish(closed=False)
            run = _placed([(end.x, end.y)], place.matrix)
            continue
        if segment.start is None:  # a path that does not begin with a move
            out.broken = True
            break
        if not run:
            run = _placed([(segment.start.x, segment.start.y)], place.matrix)
        if isinstance(segment, svgelements.Arc):
            centre = segment.center
            across = (segment.prx.x - centre.x, segment.prx.y - centre.y)
            up = (segment.pry.x - centre.x, segment.pry.y - centre.y)
            begin = float(segment.get_start_t())
            if across == (0.0, 0.0) or up == (0.0, 0.0):
                run += _placed([(end.x, end.y)], place.matrix)
            else:
                # svgelements measures t from prx towards pry
                points = _arc(
                    (centre.x, centre.y), across, up, begin, begin + float(segment.sweep), place
                )
                run += [*points[1:-1], *_placed([(end.x, end.y)], place.matrix)]
                out.curves += 1
        elif isinstance(segment, svgelements.CubicBezier | svgelements.QuadraticBezier):
            inner = (
                [segment.control]
                if hasattr(segment, "control")
                else [
                    segment.control1,
                    segment.control2,
                ]
            )
            controls = [(p.x, p.y) for p in (segment.start, *inner, end)]
            points = _bezier(controls, place)
            out.curves += len(points) > 2
            run += points[1:]
        else:
            run += _placed([(end.x, end.y)], place.matrix)
            if isinstance(segment, svgelements.Close):
                finish(closed=True)
    finish(closed=False)
    return out


def _readable_part(data: str) -> Any:
    """The path up to its first fault, as far as whole commands go."""
    import svgelements

    parts = [part for part in _COMMAND.split(data) if part.strip()]
    low, high = 0, len(parts)  # that many can be read, and cannot
    while high - low > 1:
        middle = (low + high) // 2
        try:
            svgelements.Path("".join(parts[:middle]))
            low = middle
        except (ValueError, IndexError, TypeError, ArithmeticError, AttributeError):
            high = middle
    return svgelements.Path("".join(parts[:low]))


def _straight_path(data: str, matrix: Matrix) -> Drawn:
    """A path of lines alone. Long ones are common, and a general reader takes minutes for them."""
    a, b, c, d, e, f = matrix
    out = Drawn(closed=True)
    run: list[Point] = []
    x = y = begin_x = begin_y = 0.0
    command = ""
    pending: float | None = None
    fresh = True  # a command that awaits its first numbers

    def finish(closed: bool) -> None:
        nonlocal run
        out.add(run, closed=closed)
        run = []

    for found in _TOKEN.finditer(data):
        token = found.group()
        if token.isalpha() and token not in "eE":
            if (fresh and command not in ("", "Z", "z")) or pending is not None:
                out.broken = True
                break
            if not command and token not in "Mm":
                out.broken = True
                break
            command, fresh = token, True
            if token in "Zz":
                if run:
                    run.append(run[0])
                    finish(closed=True)
                x, y = begin_x, begin_y
            continue
        try:
            value = float(token)
        except ValueError:
            out.broken = True
            break
        if command in ("", "Z", "z"):
            out.broken = True
            break
        if command in "Hh":
            x = value if command == "H" else x + value
        elif command in "Vv":
            y = value if command == "V" else y + value
        elif pending is None:
            pending = value
            continue
        else:
            relative = command in "ml"
            x, y = (x + pending, y + value) if relative else (pending, value)
            pending = None
            if command in "Mm" and fresh:
                finish(closed=False)
                begin_x, begin_y = x, y
                run.append((a * x + c * y + e, b * x + d * y + f))
                fresh = False
                continue
        fresh = False
        if not run:  # after a closed subpath
            run.append((a * begin_x + c * begin_y + e, b * begin_x + d * begin_y + f))
        run.append((a * x + c * y + e, b * x + d * y + f))
    finish(closed=False)
    out.broken = out.broken or pending is not None or (fresh and command not in ("", "Z", "z"))
    return out
