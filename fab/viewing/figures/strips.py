"""Figures of strips: what one flap angle decides at all vertices of a front (S1, S2)."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from fab.pattern.development import develop
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
from fab.viewing.figures.forms import (
    LOWER,
    UPPER,
    Bundle,
    draw_bundle,
    framed,
    principal_view,
)
from solver.front import Front
from solver.growth_order import GrownStrip
from solver.mesh import QuadMesh
from solver.strip_family import StripFamily, special_at_first
from solver.vectors import FloatArray

__all__ = [
    "bounds_figure",
    "folds_figure",
    "pair_figure",
    "pair_movie",
    "strip_movie",
]

_VIEW = view_axes(45, -68)
_OLD_UPPER, _OLD_LOWER = (0.90, 0.88, 0.84), (0.80, 0.84, 0.88)


def pair_figure(front: Front, family: StripFamily, at: int = 0) -> Drawing:
    """Two neighbouring vertices: the strip at one flap angle, and the second's as a function of it.

    front : of two interior vertices or more, with faces behind it; family : its strips.
    """
    figure = new_figure(1150, 560)
    space = plain(figure, (0.0, 0.05, 0.48, 0.85))
    _draw_strip(space, front, family, at, np.full(len(front.vertices_coords), _length(front)))
    first = np.degrees(family.flap_angles[at])
    space.set_title(rf"$\alpha_1$ = {first:.0f}°", fontsize=11)
    plot = figure.add_axes((0.55, 0.11, 0.3, 0.76))
    x = np.degrees(family.flap_angles)
    for vertex, flaps in enumerate(np.degrees(family.vertices_flap_angle[1:3])):
        y = flaps.copy()
        y[np.abs(np.diff(y, prepend=y[0])) > 180] = np.nan
        label = rf"$\alpha_{vertex + 2}$"
        plot.plot(x, y, color=PALETTE[vertex], lw=2, label=label)
        plot.plot(first, np.degrees(family.vertices_flap_angle[vertex + 1, at]), "o", color="k")
    plot.plot(x, x, color="#bbbbbb", lw=1, label=r"$\alpha_1$")
    for vertex, arcs in enumerate(family.crossing[:3]):
        colour = ("#d62020", PALETTE[2], PALETTE[4])[vertex]
        shaded(plot, arcs, colour, 0.16)
        plot.fill([], [], color=colour, alpha=0.16, label=f"faces cross\nat vertex {vertex + 1}")
    plot.set_xlim(0, 360)
    plot.set_ylim(0, 360)
    plot.set_xticks(range(0, 361, 60))
    plot.set_yticks(range(0, 361, 60))
    plot.set_aspect("equal")
    plot.set_xlabel(r"flap angle $\alpha_1$ of the first vertex, degrees", fontsize=9)
    plot.set_ylabel("flap angles after it, degrees", fontsize=9)
    plot.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False)
    words = r"One flap angle decides the next:  $\tan(\alpha_1/2)\,\tan(\alpha_1'/2) = C_1$,  "
    words += r"$\alpha_2 = \alpha_1' + \delta_1$"
    figure.text(0.5, 0.94, words, ha="center", fontsize=11)
    return Drawing(figure)


def folds_figure(front: Front, family: StripFamily, at: int = 0) -> Drawing:
    """Fold angles of a strip's creases over the flap angle, and which of them are mountains."""
    figure = new_figure(1100, 900)
    space = plain(figure, (0.02, 0.66, 0.5, 0.28))
    _draw_strip(space, front, family, at, np.full(len(front.vertices_coords), _length(front)))
    first = np.degrees(family.flap_angles[at])
    space.set_title(rf"the strip at $\alpha_1$ = {first:.0f}°", fontsize=10)
    circle = plain(figure, (0.56, 0.63, 0.4, 0.29), "forbidden flap angles, vertex 1 inmost")
    rings = [(f"{number + 1}", arcs) for number, arcs in enumerate(family.crossing)]
    draw_circle(circle, rings, {}, float(family.flap_angles[at]))
    angles = figure.add_axes((0.08, 0.36, 0.88, 0.24))
    _plot_folds(angles, family)
    letters = figure.add_axes((0.08, 0.07, 0.88, 0.24))
    _plot_letters(letters, family)
    for axes in (angles, letters):
        axes.axvline(first, color="#202020", lw=1)
    figure.text(0.5, 0.965, "Folds of a strip as functions of its flap angle", ha="center")
    return Drawing(figure)


def bounds_figure(strip: GrownStrip, behind: FloatArray) -> Drawing:
    """A strip laid flat with the places where neighbouring creases meet, and its lengths below.

    behind : the row behind the strip's front, shape (m + 1, 3).
    """
    figure = new_figure(1100, 720)
    flat = plain(figure, (0.04, 0.4, 0.92, 0.52))
    rays = strip.rays
    rows = np.stack([behind, strip.front.row_coords, strip.row])
    coords = develop(QuadMesh.from_rows(rows)).vertices_coords.reshape(3, -1, 2)
    for first, colour in ((0, _OLD_UPPER), (1, UPPER)):
        outline = np.concatenate([coords[first], coords[first + 1, ::-1]])
        flat.fill(*outline.T, color=colour, lw=0)
    for row in coords:
        flat.plot(*row.T, color="#404040", lw=1)
    longest = 4.0 * float(np.median(strip.lengths))
    for i, bound in enumerate(rays.length_bounds.tolist()):
        start, end = coords[1, i], coords[2, i]
        along = (end - start) / np.linalg.norm(end - start)
        flat.plot(*np.stack([coords[0, i], start, end]).T, color="#404040", lw=1)
        reach = start + min(bound, longest) * along
        flat.plot(*np.stack([end, reach]).T, color="#d1642a", lw=1, ls=(0, (4, 2)))
        if bound < longest:
            flat.plot(*reach, "o", color="#d1642a", ms=4)
    lengths = figure.add_axes((0.08, 0.08, 0.88, 0.24))
    place = np.arange(len(strip.lengths))
    finite = np.isfinite(rays.length_bounds)
    top = 1.15 * float(max(strip.lengths.max(), rays.length_bounds[finite].max(initial=0.0)))
    top = min(top, 4 * float(strip.lengths.max()))
    lengths.bar(place, np.where(finite, rays.length_bounds, 2 * top), 0.8, color="#f3d9c6")
    lengths.bar(place, strip.lengths, 0.45, color="#0b6e99")
    lengths.set_ylim(0, top)
    lengths.set_xlabel("front vertex", fontsize=9)
    lengths.set_ylabel("length (blue) below its bound", fontsize=9)
    words = "Creases must end before they meet their neighbours (dots): bounds S20, S21"
    figure.suptitle(words, fontsize=12)
    return Drawing(figure)


def pair_movie(front: Front, family: StripFamily) -> Movie:
    """The flap angle turns: two vertices, their special choices and where their faces cross."""
    special = {name: angles.ravel().tolist() for name, angles in special_at_first(front).items()}
    rings = [(f"vertex {number + 1}", arcs) for number, arcs in enumerate(family.crossing)]
    rings.append(("all", family.crossing))
    lengths = np.full(len(front.vertices_coords), _length(front))
    extent = _extent(front, family, lengths)

    def frame(at: int) -> Drawing:
        figure = new_figure(960, 500)
        space = plain(figure, (0.0, 0.02, 0.52, 0.88))
        _draw_strip(space, front, family, at, lengths, extent)
        circle = plain(figure, (0.53, 0.03, 0.46, 0.86))
        draw_circle(circle, rings, special, float(family.flap_angles[at]))
        words = "  ".join(
            rf"$\alpha_{n + 1}$ = {np.degrees(angle):.0f}°"
            for n, angle in enumerate(family.vertices_flap_angle[:, at])
        )
        figure.text(0.5, 0.94, words, ha="center", fontsize=12)
        return Drawing(figure)

    return movie([partial(frame, at) for at in range(len(family.flap_angles))])


def strip_movie(front: Front, family: StripFamily) -> Movie:
    """The flap angle turns: a strip, its fold angles and its mountain-valley pattern."""
    lengths = np.full(len(front.vertices_coords), _length(front))
    extent = _extent(front, family, lengths)

    def frame(at: int) -> Drawing:
        figure = new_figure(900, 720)
        space = plain(figure, (0.02, 0.52, 0.96, 0.42))
        _draw_strip(space, front, family, at, lengths, extent)
        angles = figure.add_axes((0.09, 0.29, 0.88, 0.2))
        _plot_folds(angles, family)
        letters = figure.add_axes((0.09, 0.07, 0.88, 0.17))
        _plot_letters(letters, family)
        for axes in (angles, letters):
            axes.axvline(np.degrees(family.flap_angles[at]), color="#202020", lw=1.4)
        words = rf"$\alpha_1$ = {np.degrees(family.flap_angles[at]):.0f}°"
        figure.text(0.5, 0.95, words, ha="center", fontsize=12)
        return Drawing(figure)

    return movie([partial(frame, at) for at in range(len(family.flap_angles))])


def _length(front: Front) -> float:
    return 0.8 * float(np.median(front.edges_length))


def _row(front: Front, family: StripFamily, at: int, lengths: FloatArray) -> FloatArray:
    """The new row at one flap angle, its ends parallel to their neighbours, shape (m + 1, 3)."""
    inner = family.directions[:, at]
    directions = np.concatenate([inner[:1], inner, inner[-1:]])
    return np.asarray(front.vertices_coords + lengths[:, None] * directions)


def _extent(front: Front, family: StripFamily, lengths: FloatArray) -> FloatArray:
    """All points that a strip reaches as its flap angle turns."""
    rows = [_row(front, family, at, lengths) for at in range(len(family.flap_angles))]
    return np.concatenate([front.vertices_coords, *_behind(front), *rows])


def _behind(front: Front) -> list[FloatArray]:
    """The row behind a front, all creases to it of one length; empty where it is a curve."""
    if front.back is None:
        return []
    back = np.concatenate([front.back[:1], front.back, front.back[-1:]])
    return [front.vertices_coords + _length(front) * back]


def _draw_strip(
    axes: Any,
    front: Front,
    family: StripFamily,
    at: int,
    lengths: FloatArray,
    extent: FloatArray | None = None,
) -> None:
    """The faces behind a front, and those of the strip, with the letters of their creases."""
    x, z = front.vertices_coords, _row(front, family, at, lengths)
    faces, colours, lines, inks = [], [], [], []
    behind = _behind(front)
    for y in behind:
        for i in range(len(x) - 1):
            faces.append(np.stack([y[i], y[i + 1], x[i + 1], x[i]]))
            colours.append((_OLD_UPPER, _OLD_LOWER))
        for i in range(1, len(x) - 1):
            lines.append(np.stack([y[i], x[i]]))
            inks.append("#707070")
    for i in range(len(x) - 1):
        faces.append(np.stack([x[i], x[i + 1], z[i + 1], z[i]]))
        colours.append((UPPER, LOWER))
        lines.append(x[i : i + 2])
        inks.append(_ink(family.front_folds[i, at]))
    for i in range(1, len(x) - 1):
        lines.append(np.stack([x[i], z[i]]))
        inks.append(_ink(family.crease_folds[i - 1, at]))
    lines += [np.stack([x[0], z[0]]), z, np.stack([x[-1], z[-1]])]
    inks += [INK["B"]] * 3
    view = principal_view(x, _VIEW)
    draw_bundle(axes, view, Bundle(faces, colours, lines, inks, [1.8] * len(lines)))
    framed(axes, view, np.concatenate([x, z, *behind]) if extent is None else extent)


def _ink(fold: float) -> str:
    if not abs(fold) >= 1e-8:
        return INK["F"] if np.isfinite(fold) else INK["B"]
    return INK["V"] if fold > 0 else INK["M"]


def _plot_folds(axes: Any, family: StripFamily) -> None:
    x = all_around(np.degrees(family.flap_angles), 360.0)
    for folds, colour, name in (
        (family.front_folds, "#8a3ab0", "along the front"),
        (family.crease_folds, "#3a8a3a", "across the strip"),
    ):
        for number, fold in enumerate(np.degrees(folds)):
            y = all_around(fold)
            y[np.abs(np.diff(y, prepend=y[0])) > 180] = np.nan
            axes.plot(x, y, color=colour, lw=1, alpha=0.8, label=name if number == 0 else None)
    shaded(axes, family.crossing, alpha=0.06)
    axes.axhline(0, color="#999999", lw=0.6)
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 60))
    axes.set_ylim(-185, 185)
    axes.set_yticks([-180, -90, 0, 90, 180])
    axes.tick_params(labelsize=8)
    axes.set_ylabel("fold angle, degrees", fontsize=9)
    axes.legend(loc="upper right", fontsize=8, framealpha=0.9)


def _plot_letters(axes: Any, family: StripFamily) -> None:
    """Mountains red, valleys blue: creases upwards, the front's from the line on."""
    from matplotlib.colors import ListedColormap

    letters = np.sign(all_around(np.concatenate([family.crease_folds, family.front_folds])))
    colours = ListedColormap([INK["M"], "#eeeeee", INK["V"]])
    half = 180.0 / len(family.flap_angles)
    axes.imshow(
        np.nan_to_num(letters),
        cmap=colours,
        vmin=-1,
        vmax=1,
        aspect="auto",
        interpolation="nearest",
        origin="lower",
        extent=(-half, 360.0 + half, -0.5, len(letters) - 0.5),
        alpha=0.75,
    )
    axes.axhline(len(family.crease_folds) - 0.5, color="white", lw=2)
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 60))
    axes.set_yticks(
        [len(family.crease_folds) / 2 - 0.5, len(letters) - len(family.front_folds) / 2 - 0.5],
        ["across", "front"],
        rotation=90,
        va="center",
    )
    axes.tick_params(labelsize=8)
    axes.set_xlabel(r"flap angle $\alpha_1$, degrees (mountains red, valleys blue)", fontsize=9)
