"""The figures and movies of the paper's supplementary information, by name.

Dudte, Choi and Mahadevan, "An additive algorithm for origami design", PNAS 118 (2021). Figures S11
to S17 have the paper's numbers and subjects. The others are numbered in the order of the sections
that they belong to, and so are the movies: single vertex and pair, strip, growth of the models of
figure 4, folding. Their numbers in print may be others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from fab.jobs import paper_models as models
from fab.viewing.figures import (
    folds,
    galleries,
    growing,
    landscapes,
    loops,
    ribbons,
    strips,
    vertices,
)
from fab.viewing.figures.canvas import Drawing, Movie
from fab.viewing.figures.sheets import ShownSheet, shown_sheet
from fab.viewing.scene import Scene
from solver import BrownianRibbon, CorneredMiura, Crumpled, TiltedRings
from solver.flap_landscape import flap_angle_landscape
from solver.growth_order import grown_strips
from solver.strip_family import strip_family

__all__ = ["NUMBERING", "PAPER_FIGURES", "PaperFigure"]

NUMBERING = (
    "S11 to S17 have the numbers of the paper; S1 to S10, S18 and the movies M1 to M10 are "
    "numbered in the order of its sections, and may have other numbers in print."
)
# Frames of a turn of the flap angle.
_TURN = 72
# Strips of the surface fit whose landscapes are shown: both ways from its middle.
_SHOWN_STRIPS = (0, 14, 22, 36)


@dataclass(frozen=True)
class PaperFigure:
    """A figure or a movie.

    Attributes
    ----------
    name : such as S13, or M2 for a movie.
    caption : one sentence about what it shows.
    make : draws it; of a movie, its frames are drawn later.
    """

    name: str
    caption: str
    make: Callable[[], Drawing | Movie]

    @property
    def is_movie(self) -> bool:
        """Whether it is a movie."""
        return self.name.startswith("M")


def _one_vertex() -> Drawing:
    return vertices.vertex_figure(models.vertex(np.radians([70.0])))


def _curves() -> Drawing:
    beta = np.radians(100.0)
    old = np.pi - np.radians([115.0, 140.0, 180.0, 220.0, 245.0]) / 2
    return vertices.curve_figure([models.vertex_of(beta, half, half, 240) for half in old])


def _vertex_angles() -> Drawing:
    return vertices.angles_figure(models.vertex(720))


def _pair() -> Drawing:
    front = models.pair_front()
    return strips.pair_figure(front, strip_family(front, 720), at=200)


def _strip_folds() -> Drawing:
    strip, _ = models.crumpled_strip(columns=8, strip=1)
    family = strip_family(strip.front, 720)
    return strips.folds_figure(strip.front, family, at=round(np.degrees(strip.flap_angle) * 2))


def _length_bounds() -> Drawing:
    return strips.bounds_figure(*models.crumpled_strip(columns=9, strip=5, power=0.0))


def _corners() -> Drawing:
    filled = CorneredMiura(matched=True, strips=6, strip_length=1.05)
    pentagon = CorneredMiura(fold=np.radians(40.0))
    sheets = [
        shown_sheet(filled.grow().mesh, "matched corner"),
        shown_sheet(pentagon.grow().mesh, "five-sided face"),
    ]
    return growing.growth_figure(sheets, stages=4)


def _loops() -> Drawing:
    return loops.loops_figure(models.loop_sheets())


def _special() -> Drawing:
    return vertices.special_figure(models.vertex(4))


def _crossing() -> Drawing:
    return vertices.crossing_figure(models.vertex(4))


def _shipped(names: Sequence[str], *, upright: bool = False) -> list[ShownSheet]:
    return [shown_sheet(models.shipped_mesh(name), name, upright=upright) for name in names]


_S11 = (
    *("helicoid_40", "helicoid_80", "cylinder", "hourglass", "barrel"),
    *(f"landscape_{columns}" for columns in (20, 40, 80, 160)),
    *(f"paraboloid_{columns}" for columns in (10, 20, 40, 80, 160)),
    *(f"hypar_{columns}" for columns in (20, 30, 40, 80, 160)),
)


def _surfaces() -> Drawing:
    sheets: list[ShownSheet] = []
    for _, names in groupby(_S11, lambda name: name.rstrip("0123456789")):
        alike = _shipped(list(names), upright=True)
        view = alike[len(alike) // 2].view  # one for all sheets of a surface
        sheets += [replace(sheet, view=view) for sheet in alike]
    return galleries.gallery_figure(sheets, "Sheets that follow surfaces", columns=5)


def _two_seeds() -> Drawing:
    names = ("waves_narrow", "waves_wide", "waves_straight", "waves_diagonal")
    sheets = _shipped(names, upright=True)
    return galleries.gallery_figure(sheets, "One surface, grown from different seeds")


def _landscapes() -> Drawing:
    _, grown = models.surface_fit()
    shown = [(number, grown[number]) for number in _SHOWN_STRIPS]
    drawn = [
        (
            f"strip {number + 1}",
            flap_angle_landscape(
                strip.front, lengths=models.offset_lengths(strip), flap_angles=120
            ),
        )
        for number, strip in shown
    ]
    return landscapes.landscapes_figure(drawn, [strip.flap_angle for _, strip in shown])


def _curved_folds() -> Drawing:
    names = ("curved_fold", "wave_fold", "elliptic_ring", "trefoil_knot")
    sheets = _shipped(names, upright=True)
    return galleries.gallery_figure(sheets, "Curved folds: open, closed and knotted")


def _intervals() -> Drawing:
    strip, _ = models.crumpled_strip(columns=20, strip=8)
    return landscapes.intervals_figure(strip.front, strip.flap_angle)


def _crumpled() -> Drawing:
    sheets = _shipped(("crumpled", "crumpled_linear"))
    for power in (2.0, 1.0):
        design = Crumpled(strips=20, power=power, random_seed=3, as_printed=True)
        name = f"as printed, p = {power:g}"
        sheets.append(shown_sheet(design.grow().mesh, name))
    title = "Crumpled sheets: p = 2 and p = 1, ours and by the printed recipe"
    return galleries.gallery_figure(sheets, title)


def _ribbons() -> Drawing:
    names = ("brownian_ribbon", *(f"brownian_ribbon_{steps}" for steps in (400, 1000, 10000)))
    drawn = []
    for name in names:
        mesh = models.shipped_mesh(name)
        sheet = shown_sheet(mesh, f"{len(mesh.faces_vertices)} steps")
        drawn.append((sheet, grown_strips(mesh, seed_rows=1)[0]))
    return ribbons.ribbons_figure(drawn)


def _fold_states() -> Drawing:
    return folds.states_figure(_folding())


def _folding() -> Scene:
    return models.folding_scene("hypar_20", states=24)


def _vertex_turns() -> Movie:
    return vertices.vertex_movie(models.vertex(_TURN))


def _pair_turns() -> Movie:
    front = models.pair_front()
    return strips.pair_movie(front, strip_family(front, _TURN))


def _strip_turns() -> Movie:
    strip, _ = models.crumpled_strip(columns=8, strip=1)
    return strips.strip_movie(strip.front, strip_family(strip.front, _TURN))


def _fit_grows() -> Movie:
    mesh, _ = models.surface_fit()
    return growing.growth_movie(shown_sheet(mesh, "surface fit (4A)", upright=True))


def _squares_grow() -> Movie:
    mesh = TiltedRings(opening=0.5).grow().mesh
    return growing.growth_movie(shown_sheet(mesh, "twisted squares (4B)"))


def _cones_grow() -> Movie:
    return _shipped_grows("nested_cones", "nested cones (4C)")


def _curved_fold_grows() -> Movie:
    return _shipped_grows("curved_fold", "curved fold (4D)")


def _crumpled_grows() -> Movie:
    return _shipped_grows("crumpled", "crumpled sheet (4E)")


def _ribbon_grows() -> Movie:
    design = BrownianRibbon(steps=24, turn=np.radians(340.0), width_share=0.9, random_seed=5)
    mesh = design.grow().mesh
    return growing.growth_movie(shown_sheet(mesh, "ribbon along a random walk (4F)"))


def _shipped_grows(job: str, name: str) -> Movie:
    return growing.growth_movie(shown_sheet(models.shipped_mesh(job), name))


def _fit_folds() -> Movie:
    return folds.folding_movie(_folding())


PAPER_FIGURES = (
    PaperFigure(
        "S1",
        "One vertex, folded and flat: creases a, b, c and the new one r, sectors theta1 to theta4, "
        "beta, k and the flap angle.",
        _one_vertex,
    ),
    PaperFigure(
        "S2",
        "The new crease of a vertex runs along a curve on the sphere, a spherical ellipse: its two "
        "arcs theta1 and theta2 to a and b add up to k.",
        _curves,
    ),
    PaperFigure(
        "S3",
        "Design angles and fold angles of a vertex as functions of its flap angle, with its "
        "special choices and forbidden arcs.",
        _vertex_angles,
    ),
    PaperFigure(
        "S4",
        "Adjacent vertices: the flap angle of the first decides that of the second.",
        _pair,
    ),
    PaperFigure(
        "S5",
        "A strip: fold angles of all its creases as functions of the flap angle, its "
        "mountain-valley pattern, and the forbidden arcs of each vertex.",
        _strip_folds,
    ),
    PaperFigure(
        "S6",
        "Lengths of new creases and their bounds S20 and S21, where neighbouring creases meet.",
        _length_bounds,
    ),
    PaperFigure(
        "S7",
        "Growth around a concave corner: one that matches and is filled by quads, and one that "
        "leaves a five-sided face.",
        _corners,
    ),
    PaperFigure(
        "S8",
        "Closed fronts: by how much a loop misses itself over its flap angle, in each of the three "
        "cases in which it closes.",
        _loops,
    ),
    PaperFigure(
        "S9",
        "Special choices of one vertex: continuation, reflection, flat-foldable, equal angles, "
        "locked left and locked right.",
        _special,
    ),
    PaperFigure(
        "S10",
        "Self-intersection of a vertex: forbidden arcs on the circle of flap angles, and the "
        "vertex free, nested and crossing.",
        _crossing,
    ),
    PaperFigure(
        "S11",
        "Surfaces followed by sheets: helicoid at 2 resolutions, cylinders of zero, negative and "
        "positive curvature, landscape at 4, paraboloid and hypar at 5 each.",
        _surfaces,
    ),
    PaperFigure(
        "S12",
        "One surface from several seeds: narrow and wide zigzags with the same counts, straight "
        "and diagonal growth.",
        _two_seeds,
    ),
    PaperFigure(
        "S13",
        "Landscapes of the cost S30 and of the broken constraints C_con over the flap angle, for "
        "strips of the surface fit 4A, with the flap angle that growth took.",
        _landscapes,
    ),
    PaperFigure(
        "S14",
        "Curved folds of several topologies: along a parabola, a wave, an ellipse and a trefoil "
        "knot.",
        _curved_folds,
    ),
    PaperFigure(
        "S15",
        "Flap angles at which a crumpled sheet would cross itself: intervals of each vertex, "
        "their union, and the free angle that was drawn.",
        _intervals,
    ),
    PaperFigure(
        "S16",
        "Crumpled sheets with p = 2 and p = 1, by our recipe and by the printed one.",
        _crumpled,
    ),
    PaperFigure(
        "S17",
        "Ribbons along random walks of 10, 400, 1000 and 10000 steps, flat on a circle, with k "
        "between beta and 2 pi - beta, and lengths below their bounds.",
        _ribbons,
    ),
    PaperFigure(
        "S18",
        "A surface fit (hypar, 20 quads across) on its simulated way from flat to folded.",
        _fold_states,
    ),
    PaperFigure(
        "M1",
        "The flap angle of one vertex turns once around: faces, the curve of the new crease, and "
        "all angles.",
        _vertex_turns,
    ),
    PaperFigure(
        "M2",
        "The flap angle of a pair of vertices turns: all special choices of both, and where faces "
        "cross.",
        _pair_turns,
    ),
    PaperFigure(
        "M3",
        "The flap angle of a strip turns: its fold angles and its mountain-valley pattern.",
        _strip_turns,
    ),
    PaperFigure("M4", "The surface fit 4A grows strip by strip, both ways.", _fit_grows),
    PaperFigure("M5", "The twisted squares 4B grow ring by ring.", _squares_grow),
    PaperFigure("M6", "The nested cones 4C grow ring by ring.", _cones_grow),
    PaperFigure("M7", "The curved fold 4D grows strip by strip.", _curved_fold_grows),
    PaperFigure("M8", "The crumpled sheet 4E grows strip by strip.", _crumpled_grows),
    PaperFigure(
        "M9",
        "A ribbon along a random walk, as 4F but of 24 steps, grows quad by quad.",
        _ribbon_grows,
    ),
    PaperFigure(
        "M10",
        "A surface fit (hypar, 20 quads across) folds from flat to its shape, and back.",
        _fit_folds,
    ),
)
