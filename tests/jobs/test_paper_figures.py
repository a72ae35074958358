"""The paper's figures: the numbers behind them, and that each is drawn."""

import io
import xml.etree.ElementTree as ElementTree
from functools import cache

import numpy as np
import pytest
from PIL import Image

from fab.catalogue import shipped
from fab.errors import InvalidJob
from fab.jobs import paper_figures, paper_models
from fab.jobs.figure_files import FigureFormat, chosen_figures, figure_files
from fab.jobs.paper_figures import PAPER_FIGURES
from fab.viewing.figures.canvas import Drawing, Movie
from solver import CorneredMiura, Front, flap_angle_landscape
from solver.arcs import contain, united
from solver.growth_order import grown_strips
from solver.transfer import Closing, loop_misses

FIGURES = {figure.name: figure for figure in PAPER_FIGURES}
# Many sheets, some of them large: these are drawn from smaller ones in tests/viewing/figures.
LARGE = {"S11", "M5"}


@cache
def drawn(name):
    return FIGURES[name].make()


def picture(data):
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image.convert("RGB"))


def axes_of(drawing, **labels):
    """The axes of a figure with these labels, such as ylabel="cost"."""
    return [
        axes
        for axes in drawing.figure.axes
        if all(getattr(axes, f"get_{name}")() == text for name, text in labels.items())
    ]


def test_all_figures_and_movies_have_a_caption():
    names = [*(f"S{n}" for n in range(1, 19)), *(f"M{n}" for n in range(1, 11))]
    assert list(FIGURES) == names
    for figure in PAPER_FIGURES:
        assert figure.caption.endswith(".")
        assert figure.caption.count(". ") == 0, "one sentence"


@pytest.mark.parametrize("name", [name for name in FIGURES if name not in LARGE])
def test_each_is_drawn(name):
    made = drawn(name)
    if isinstance(made, Movie):
        assert FIGURES[name].is_movie
        assert len(made.frames) >= 10
        first, last = (picture(made.frames[at]().png_bytes()) for at in (0, -1))
        assert first.shape == last.shape
        assert (first != last).any(axis=2).mean() > 0.001  # something moves
        pictures = [last]
    else:
        pictures = [picture(made.png_bytes())]
    for pixels in pictures:
        assert min(pixels.shape[:2]) >= 400
        assert (pixels < 128).any(axis=2).mean() > 0.001, "blank"


def test_curves_of_s2_have_one_front_and_the_sums_that_they_name():
    texts = [text.get_text() for text in drawn("S2").figure.legends[0].get_texts()]
    assert texts[:5] == [f"k = {k}°" for k in (115, 140, 180, 220, 245)]


def test_loops_of_s8_close_in_the_three_ways():
    cases = []
    for _, mesh in paper_models.loop_sheets():
        rows = mesh.vertices_coords[mesh.grid]
        front = Front.between(rows[1], rows[0], closed=True)
        closings = front.closings()
        cases.append(closings.case)
        deltas = np.append(front.deltas, front.closing_delta)
        misses = loop_misses(front.couplings, deltas, np.linspace(0, 6.2, 50))
        if closings.case is Closing.FAMILY:
            assert np.abs(misses).max() < 1e-9
        else:
            assert np.abs(misses).max() > 1.0
            at_roots = loop_misses(front.couplings, deltas, closings.flap_angles)
            assert np.abs(at_roots).max() < 1e-6
    assert cases == [Closing.PAIR, Closing.FAMILY, Closing.CONTINUATION]


def test_corners_of_s7_match_or_leave_one_pentagon():
    matched = CorneredMiura(matched=True, strips=6, strip_length=1.05).grow().mesh
    assert (len(matched.faces_vertices), len(matched.pentagons)) == (100, 0)
    assert len(CorneredMiura(fold=np.radians(40.0)).grow().mesh.pentagons) == 1
    titles = [axes.get_title() for axes in drawn("S7").figure.axes]
    assert titles[6] == "matched corner: 100 faces"


def test_creases_of_s6_end_below_their_bounds_and_some_near_them():
    strip, behind = paper_models.crumpled_strip(columns=9, strip=5, power=0.0)
    share = strip.lengths / strip.rays.length_bounds
    assert 0.5 < share.max() < 1
    assert Front.between(strip.front.row_coords, behind).k == pytest.approx(strip.front.k)


def test_least_costs_of_s13_are_what_growth_took_and_break_no_constraint():
    _, grown = paper_models.surface_fit()
    for number in paper_figures._SHOWN_STRIPS:
        strip = grown[number]
        to_offset = paper_models.offset_lengths(strip)
        taken = np.array([strip.flap_angle, strip.flap_angle + np.pi])
        landscape = flap_angle_landscape(strip.front, lengths=to_offset, flap_angles=taken)
        assert abs(landscape.best - strip.flap_angle) < 1e-9
        assert landscape.cost[0] == pytest.approx(landscape.best_cost)
        assert landscape.constraint[0] == 0
        assert landscape.constraint[1] > 0
        # the lengths that constrain are those that were grown
        assert to_offset(strip.rays) == pytest.approx(strip.lengths, abs=1e-9)
    for axes in axes_of(drawn("S13"), ylabel="cost"):
        dot = next(line for line in axes.lines if line.get_marker() == "o")
        dashed = next(line for line in axes.lines if len(line.get_xdata()) == 2)
        assert dot.get_xdata()[0] == pytest.approx(dashed.get_xdata()[0], abs=1e-6)


def test_intervals_of_s15_and_what_they_leave_make_the_circle():
    strip, _ = paper_models.crumpled_strip(columns=20, strip=8)
    crossing = strip.front.crossing_flap_angles()
    assert crossing.shape == (19, 2, 2)
    free = strip.front.free_flap_angles()
    union = united(crossing.reshape(-1, 2))
    sizes = [((arcs[:, 1] - arcs[:, 0]) % (2 * np.pi)).sum() for arcs in (free, union)]
    assert sum(sizes) == pytest.approx(2 * np.pi)
    assert contain(free, np.array([strip.flap_angle])).all()
    assert not contain(union, np.array([strip.flap_angle])).any()


def test_ribbons_of_s17_are_within_their_bounds():
    for name in ("brownian_ribbon", "brownian_ribbon_400"):
        (strip,) = grown_strips(paper_models.shipped_mesh(name), seed_rows=1)
        front = strip.front
        assert (front.beta < front.k).all()
        assert (front.k < 2 * np.pi - front.beta).all()
        assert (strip.lengths < strip.rays.length_bounds).all()


def test_the_fold_of_s18_starts_flat_and_ends_at_its_shape():
    scene = paper_models.folding_scene("hypar_20", states=4)
    assert scene.shares.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    flat = np.linalg.svd(scene.states_coords[0] - scene.states_coords[0].mean(axis=0))[1]
    assert flat[2] < 1e-9 * flat[0]
    target = scene.pattern.folded_coords
    assert np.abs(scene.states_coords[-1] - target).max() < 1e-9 * np.ptp(target)


def test_sheets_of_the_galleries_are_shipped():
    assert set(paper_figures._S11) <= set(shipped("jobs"))
    assert len(paper_figures._S11) == 2 + 3 + 4 + 5 + 5


def test_growth_begins_with_the_seed_and_ends_with_all_faces():
    for name, faces in (("M4", 1760), ("M7", 1000), ("M8", 800), ("M9", 24)):
        movie = drawn(name)
        texts = [movie.frames[at]().figure.texts[0].get_text() for at in (0, -1)]
        assert "step 1 of" in texts[0]
        assert texts[1].endswith(f"{faces} faces")


def test_the_same_figure_has_the_same_bytes():
    formats = (FigureFormat.PNG, FigureFormat.SVG)
    first, second = (figure_files(FIGURES["S8"], formats).files for _ in range(2))
    assert first == second
    assert list(first) == ["S8.png", "S8.svg"]
    assert ElementTree.fromstring(first["S8.svg"]).tag.endswith("svg")


def test_formats_fit_figures_and_movies():
    every = chosen_figures(["all"])
    assert [figure.name for figure, _ in every] == list(FIGURES)
    assert {kinds for figure, kinds in every if figure.is_movie} == {(FigureFormat.GIF,)}
    (both,) = chosen_figures(["M1"], [FigureFormat.MP4, FigureFormat.GIF])
    assert both[1] == (FigureFormat.GIF, FigureFormat.MP4)
    movies = chosen_figures(["ALL"], [FigureFormat.GIF])
    assert [figure.name for figure, _ in movies] == [f"M{n}" for n in range(1, 11)]
    (one,) = chosen_figures(["s13", "S13"], [FigureFormat.SVG, FigureFormat.GIF])
    assert (one[0].name, one[1]) == ("S13", (FigureFormat.SVG,))
    with pytest.raises(InvalidJob, match="M2 is a movie: --only must name one of gif, mp4"):
        chosen_figures(["all", "m2"], [FigureFormat.PNG])
    with pytest.raises(InvalidJob, match=r"figure 'S113' must be one of .* Did you mean S13\?"):
        chosen_figures(["S113"])


def test_figures_are_drawings_and_movies_movies():
    assert isinstance(drawn("S1"), Drawing)
    assert isinstance(drawn("M1"), Movie)
