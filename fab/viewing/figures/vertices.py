"""Figures of one vertex: what its flap angle decides (S1, S2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from fab.viewing.camera import view_axes
from fab.viewing.figures.canvas import (
    INK,
    PALETTE,
    Drawing,
    Movie,
    all_around,
    movie,
    new_figure,
    plain,
    shaded,
)
from fab.viewing.figures.circles import draw_circle
from fab.viewing.figures.forms import LOWER, UPPER, Bundle, draw_bundle
from solver.vectors import FloatArray, angle_between, cross, unit
from solver.vertex_family import VertexFamily, vertex_family

__all__ = [
    "angles_figure",
    "crossing_figure",
    "curve_figure",
    "special_figure",
    "vertex_figure",
    "vertex_movie",
]

# In the vertex's own frame: its front runs to the right, and opens towards the viewer.
_VIEW = view_axes(32, -76)
# Faces behind the front are paler than new ones.
_OLD_UPPER, _OLD_LOWER = (0.90, 0.88, 0.84), (0.80, 0.84, 0.88)
_LETTERS = ("a", "b", "c", "r")
# Of points on arcs, radians.
_STEP = np.radians(3)


def vertex_figure(family: VertexFamily, at: int = 0) -> Drawing:
    """A vertex in space at one of its flap angles, and flat, with the names of all its parts."""
    figure = new_figure(1200, 600)
    space = plain(figure, (0.0, 0.02, 0.52, 0.88), "folded")
    _draw_vertex(space, family, at)
    _draw_names(space, family, at)
    flat = plain(figure, (0.54, 0.05, 0.42, 0.85), "flat")
    theta3, theta4 = _old_sectors(family)
    sectors = [family.theta2[at], family.theta1[at], theta4, theta3]
    names = [r"$\theta_2$", r"$\theta_1$", r"$\theta_4$", r"$\theta_3$"]
    start = 0.0
    for number, (size, name) in enumerate(zip(sectors, names, strict=True)):
        turn = np.linspace(start, start + size, 60)
        rim = np.column_stack([np.cos(turn), np.sin(turn)])
        colour = UPPER if number < 2 else _OLD_UPPER
        flat.fill(*np.concatenate([[[0, 0]], rim]).T, color=colour, lw=0)
        arc = (0.22 + 0.03 * (number % 2)) * rim
        flat.plot(*arc.T, color="#555555", lw=0.9)
        middle = start + size / 2
        text = f"{name} = {np.degrees(size):.1f}°"
        flat.text(0.6 * np.cos(middle), 0.6 * np.sin(middle), text, ha="center", va="center")
        start += size
    ends = np.concatenate([[0.0], np.cumsum(sectors)[:-1]])
    for turn, letter, crease in zip(ends, "brac", (1, 3, 0, 2), strict=True):
        fold = family.fold_angles[crease, at]
        x, y = np.cos(turn), np.sin(turn)
        flat.plot([0, x], [0, y], color=_ink(fold), lw=2.2)
        flat.text(1.09 * x, 1.09 * y, letter, ha="center", va="center", fontsize=13, style="italic")
    flat.set_xlim(-1.2, 1.2)
    flat.set_ylim(-1.2, 1.2)
    words = (
        rf"$\beta$ = {np.degrees(family.beta):.1f}°,  k = $\theta_1+\theta_2$ = "
        rf"{np.degrees(family.k):.1f}°,  flap angle $\alpha$ = "
        f"{np.degrees(family.flap_angles[at]):.1f}°"
    )
    figure.text(0.5, 0.95, words, ha="center", fontsize=12)
    return Drawing(figure)


def curve_figure(families: Sequence[VertexFamily], arcs: int = 8) -> Drawing:
    """Curves of the new crease on the sphere, one for each family, all with the same a and b.

    arcs : pairs of arcs to a and b that are drawn on the middle curve, evenly in the flap angle.
    """
    figure = new_figure(1000, 760)
    space = plain(figure, (0.0, 0.0, 0.74, 0.93))
    a, b = families[0].a, families[0].b
    up = unit(cross(a, b))
    across = unit(a + b)
    # from above the front, so that the whole curve of the middle family is in sight
    view = _facing(0.75 * up + 0.55 * across + 0.2 * cross(up, across), up)
    turn = np.linspace(0, 2 * np.pi, 181)
    space.fill(np.cos(turn), np.sin(turn), color="#f4f6f8", lw=0)
    space.plot(np.cos(turn), np.sin(turn), color="#999999", lw=1)
    for tilt in (0.0, np.pi / 3, 2 * np.pi / 3):  # great circles through the normal
        side = np.cos(tilt) * across + np.sin(tilt) * cross(up, across)
        circle = np.cos(turn)[:, None] * up + np.sin(turn)[:, None] * side
        _draw_curve(space, circle, view, "#d4d8dc", 0.6)
    plane = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * cross(up, across)
    _draw_curve(space, plane, view, "#a8adb2", 0.8)
    middle = families[len(families) // 2]
    step = max(1, len(middle.directions) // max(arcs, 1))
    for r in middle.directions[::step]:
        for end in (a, b):
            _draw_curve(space, _arc(end, r), view, "#c8a878", 0.8)
    _draw_curve(space, _arc(a, b), view, "#202020", 2.4)
    for number, family in enumerate(families):
        colour = PALETTE[number % len(PALETTE)]
        closed = np.concatenate([family.directions, family.directions[:1]])
        wide = 2.6 if family is middle else 1.6
        _draw_curve(space, closed, view, colour, wide)
        label = rf"k = {np.degrees(family.k):.0f}°"
        space.plot([], [], color=colour, lw=wide, label=label)
    for end, name in ((a, "a"), (b, "b")):
        x, y, _ = view @ end
        space.plot(x, y, "o", color="#202020", ms=7)
        space.text(1.07 * x, 1.07 * y, name, fontsize=14, style="italic", ha="center", va="center")
    space.plot([], [], color="#202020", lw=2.4, label=rf"$\beta$ = {np.degrees(middle.beta):.0f}°")
    space.plot([], [], color="#c8a878", lw=0.8, label=r"arcs $\theta_1$ and $\theta_2$")
    space.set_xlim(-1.12, 1.12)
    space.set_ylim(-1.12, 1.12)
    figure.legend(
        *space.get_legend_handles_labels(), loc="center right", frameon=False, fontsize=11
    )
    figure.text(0.5, 0.95, "All new creases of a vertex: theta1 + theta2 = k", ha="center")
    return Drawing(figure)


def angles_figure(family: VertexFamily) -> Drawing:
    """Design angles and fold angles of a vertex as functions of its flap angle."""
    figure = new_figure(1100, 800)
    sectors, folds = figure.subplots(2, 1, sharex=True)
    figure.subplots_adjust(0.08, 0.08, 0.8, 0.94, hspace=0.12)
    _plot_sectors(sectors, family)
    _plot_folds(folds, family)
    for axes in (sectors, folds):
        _mark_special(axes, family.special)
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=9)
    figure.suptitle("What the flap angle of a vertex decides (red bands: faces cross)", fontsize=12)
    return Drawing(figure)


def special_figure(family: VertexFamily) -> Drawing:
    """The vertex at each of its special flap angles, one picture each."""
    choices = [(name, angle) for name, angles in family.special.items() for angle in angles]
    columns = 4
    rows = -(-len(choices) // columns)
    figure = new_figure(300 * columns, 320 * rows + 40)
    for number, (name, angle) in enumerate(choices):
        row, column = divmod(number, columns)
        height = 0.95 / rows
        bottom = 0.95 - (row + 0.94) * height
        place = (column / columns, bottom, 1 / columns, 0.78 * height)
        axes = plain(figure, place, f"{name}\n" + rf"$\alpha$ = {np.degrees(angle):.1f}°")
        one = vertex_family(family.a, family.b, family.c, np.array([angle]))
        _draw_vertex(axes, one, 0)
        words = rf"$\theta_1$ = {np.degrees(one.theta1[0]):.1f}°, "
        words += rf"$\theta_2$ = {np.degrees(one.theta2[0]):.1f}°"
        axes.text(0.5, -0.03, words, transform=axes.transAxes, ha="center", fontsize=9)
    figure.text(0.5, 0.97, "Special flap angles of one vertex", ha="center", fontsize=12)
    return Drawing(figure)


def crossing_figure(family: VertexFamily) -> Drawing:
    """The circle of flap angles with its forbidden arcs, and a vertex of each kind beside it."""
    figure = new_figure(1200, 480)
    circle = plain(figure, (0.0, 0.04, 0.36, 0.84), "flap angles")
    draw_circle(circle, [("faces cross", family.crossing)], family.special)
    for number, (name, angle) in enumerate(_kinds(family)):
        axes = plain(figure, (0.37 + 0.21 * number, 0.06, 0.21, 0.76), name)
        one = vertex_family(family.a, family.b, family.c, np.array([angle]))
        _draw_vertex(axes, one, 0)
        words = rf"$\alpha$ = {np.degrees(angle):.0f}°"
        axes.text(0.5, -0.05, words, transform=axes.transAxes, ha="center", fontsize=10)
    figure.text(0.5, 0.94, "Where new faces cross old ones", ha="center", fontsize=12)
    return Drawing(figure)


def vertex_movie(family: VertexFamily) -> Movie:
    """The flap angle turns once around: the vertex, its curve on the sphere, its angles."""

    def frame(at: int) -> Drawing:
        figure = new_figure(960, 480)
        space = plain(figure, (0.0, 0.02, 0.46, 0.9))
        closed = np.concatenate([family.directions, family.directions[:1]])
        _draw_vertex(space, family, at, curve=closed)
        sectors = figure.add_axes((0.54, 0.56, 0.34, 0.36))
        folds = figure.add_axes((0.54, 0.1, 0.34, 0.36))
        _plot_sectors(sectors, family)
        _plot_folds(folds, family)
        for axes in (sectors, folds):
            axes.axvline(np.degrees(family.flap_angles[at]), color="#202020", lw=1.2)
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=8)
        words = rf"$\alpha$ = {np.degrees(family.flap_angles[at]):.0f}°"
        figure.text(0.23, 0.94, words, ha="center", fontsize=12)
        return Drawing(figure)

    return movie([partial(frame, at) for at in range(len(family.flap_angles))])


def _draw_vertex(axes: Any, family: VertexFamily, at: int, curve: FloatArray | None = None) -> None:
    """The four sectors and creases of a vertex, of unit length."""
    a, b, c, r = family.a, family.b, family.c, family.directions[at]
    faces, colours = [], []
    for first, second, upper, lower in (
        (b, r, UPPER, LOWER),
        (r, a, UPPER, LOWER),
        (a, c, _OLD_UPPER, _OLD_LOWER),
        (c, b, _OLD_UPPER, _OLD_LOWER),
    ):
        rim = _arc(first, second)
        for p, q in pairwise(rim):
            faces.append(np.stack([p, q, 0 * p]))
            colours.append((upper, lower))
    creases = [np.stack([0 * u, u]) for u in (a, b, c, r)]
    inks = [_ink(float(fold)) for fold in family.fold_angles[:, at]]
    widths = [2.4] * 4
    if curve is not None:
        creases, inks, widths = [*creases, curve], [*inks, "#999999"], [*widths, 1.0]
    view = _view_of(family)
    draw_bundle(axes, view, Bundle(faces, colours, creases, inks, widths))
    for u, letter in zip((a, b, c, r), _LETTERS, strict=True):
        x, y, _ = view @ (1.12 * u)
        axes.text(x, y, letter, ha="center", va="center", fontsize=12, style="italic")
    axes.set_xlim(-1.2, 1.2)
    axes.set_ylim(-1.2, 1.2)


def _draw_names(axes: Any, family: VertexFamily, at: int) -> None:
    """Arcs of beta and of the flap angle."""
    view = _view_of(family)
    arc = 0.35 * _arc(family.a, family.b)
    axes.plot(*(arc @ view.T)[:, :2].T, color="#202020", lw=1, ls="--")
    x, y, _ = view @ (1.25 * arc[len(arc) // 2])
    axes.text(x, y, r"$\beta$", fontsize=12)
    # the flap angle, about a, from the beta plane to the new face
    n = unit(cross(family.a, family.b))
    p = cross(n, family.a)
    turn = np.linspace(0, family.flap_angles[at], 40)[:, None]
    swing = 0.55 * family.a + 0.3 * (np.cos(turn) * p + np.sin(turn) * n)
    axes.plot(*(swing @ view.T)[:, :2].T, color="#8a3ab0", lw=1.4)
    foot = np.stack([0.55 * family.a, 0.55 * family.a + 0.3 * p])
    axes.plot(*(foot @ view.T)[:, :2].T, color="#8a3ab0", lw=0.9, ls=":")
    x, y, _ = view @ (0.55 * family.a + 1.25 * (swing[len(swing) // 2] - 0.55 * family.a))
    axes.text(x, y, r"$\alpha$", fontsize=12, color="#8a3ab0")


def _view_of(family: VertexFamily) -> FloatArray:
    right, back = unit(family.b - family.a), -unit(family.a + family.b)
    return _VIEW @ np.stack([right, back, cross(right, back)])


def _plot_sectors(axes: Any, family: VertexFamily) -> None:
    x = all_around(np.degrees(family.flap_angles), 360.0)
    for number, values in enumerate((family.theta1, family.theta2)):
        label = rf"$\theta_{number + 1}$"
        axes.plot(x, all_around(np.degrees(values)), color=PALETTE[number], lw=1.8, label=label)
    axes.set_ylabel("design angle, degrees", fontsize=9)
    _on_circle(axes, family)


def _plot_folds(axes: Any, family: VertexFamily) -> None:
    x = all_around(np.degrees(family.flap_angles), 360.0)
    for crease, letter in enumerate(_LETTERS):
        y = all_around(np.degrees(family.fold_angles[crease]))
        y[np.abs(np.diff(y, prepend=y[0])) > 180] = np.nan  # passes a half turn
        axes.plot(x, y, color=PALETTE[crease + 2], lw=1.6, label=f"fold of {letter}")
    axes.axhline(0, color="#999999", lw=0.6)
    axes.set_ylim(-185, 185)
    axes.set_yticks([-180, -90, 0, 90, 180])
    axes.set_ylabel("fold angle, degrees", fontsize=9)
    axes.set_xlabel("flap angle, degrees", fontsize=9)
    _on_circle(axes, family)


def _on_circle(axes: Any, family: VertexFamily) -> None:
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 60))
    axes.tick_params(labelsize=8)
    shaded(axes, family.crossing)


def _mark_special(axes: Any, special: Mapping[str, tuple[float, ...]]) -> None:
    for number, (name, angles) in enumerate(special.items()):
        for first, angle in enumerate(angles):
            axes.axvline(
                np.degrees(angle),
                color=PALETTE[(number + 2) % len(PALETTE)],
                lw=1,
                ls=(0, (1 + number, 2)),
                label=name if first == 0 else None,
            )


def _kinds(family: VertexFamily) -> list[tuple[str, float]]:
    """A flap angle of each kind: away from the old crease, nested between locked ones, crossing."""
    left, right = family.special["locked left"][0], family.special["locked right"][0]
    start, end = max(family.crossing.tolist(), key=lambda arc: (arc[1] - arc[0]) % (2 * np.pi))
    away = np.pi / 2 if left > np.pi else 1.5 * np.pi
    return [
        ("free: away from c", (away + family.special["continuation"][0]) / 2),
        ("free: nested", (left + right) / 2),
        ("faces cross", start + ((end - start) % (2 * np.pi)) / 2),
    ]


def _old_sectors(family: VertexFamily) -> tuple[float, float]:
    return float(angle_between(family.b, family.c)), float(angle_between(family.a, family.c))


def _ink(fold: float) -> str:
    if abs(fold) < 1e-8:
        return INK["F"]
    return INK["V"] if fold > 0 else INK["M"]


def _arc(first: FloatArray, second: FloatArray) -> FloatArray:
    """Points of the great circle between two directions, shape (n, 3)."""
    size = float(angle_between(first, second))
    count = max(2, int(size / _STEP))
    share = np.linspace(0, 1, count)[:, None]
    if size < 1e-9:
        return np.repeat(first[None], count, axis=0)
    return np.asarray(
        (np.sin((1 - share) * size) * first + np.sin(share * size) * second) / np.sin(size)
    )


def _facing(toward: FloatArray, up: FloatArray) -> FloatArray:
    """A camera that looks against `toward`, with `up` upwards as far as it can be."""
    toward = unit(toward)
    right = unit(cross(up, toward))
    return np.stack([right, cross(toward, right), toward])


def _draw_curve(axes: Any, points: FloatArray, view: FloatArray, colour: str, width: float) -> None:
    """A curve on the unit sphere, its hidden parts dotted."""
    seen = points @ view.T
    front = np.where(seen[:, 2:] >= -1e-9, seen[:, :2], np.nan)
    hidden = np.where(seen[:, 2:] <= 1e-9, seen[:, :2], np.nan)
    axes.plot(*front.T, color=colour, lw=width, solid_capstyle="round")
    axes.plot(*hidden.T, color=colour, lw=0.7 * width, ls=(0, (1, 2)))
