"""Files of the paper's figures and movies."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

from fab.errors import InvalidJob, did_you_mean
from fab.files import shortened
from fab.jobs.paper_figures import PAPER_FIGURES, PaperFigure
from fab.outputs import Made
from fab.progress import Progress, silent
from fab.viewing.figures.canvas import Drawing
from fab.viewing.movie_files import gif_bytes, mp4_bytes

__all__ = ["ALL", "FigureFormat", "chosen_figures", "figure_files"]

# The name that stands for all figures.
ALL = "all"


class FigureFormat(StrEnum):
    """What a figure or a movie can be saved as."""

    PNG = "png"
    SVG = "svg"
    GIF = "gif"
    MP4 = "mp4"


_OF_FIGURES = (FigureFormat.PNG, FigureFormat.SVG)
_OF_MOVIES = (FigureFormat.GIF, FigureFormat.MP4)
# What is made where nothing is asked for: MP4 wants an encoder.
_USUAL = (FigureFormat.PNG, FigureFormat.SVG, FigureFormat.GIF)


def chosen_figures(
    names: Sequence[str], formats: Sequence[FigureFormat] | None = None
) -> list[tuple[PaperFigure, tuple[FigureFormat, ...]]]:
    """The figures of these names, each once, and what each is saved as.

    names : such as S13 or m2, or all. formats : those that are wanted; None: PNG and SVG of
    figures, GIF of movies. Of all figures those that have none of the formats are left out.

    Raises `InvalidJob` for unknown names, and for a figure with none of the formats.
    """
    known = {figure.name: figure for figure in PAPER_FIGURES}
    wanted: dict[str, bool] = {}  # by name, whether it was asked for itself
    for name in names:
        if name.lower() == ALL:
            wanted |= {each: wanted.get(each, False) for each in known}
        elif name.upper() in known:
            wanted[name.upper()] = True
        else:
            raise InvalidJob(
                f"figure {shortened(name)!r} must be one of {', '.join(known)}, or {ALL}."
                f"{did_you_mean(name.upper(), known)}"
            )
    chosen = []
    for name, itself in wanted.items():
        figure = known[name]
        fitting = _OF_MOVIES if figure.is_movie else _OF_FIGURES
        saved = tuple(kind for kind in fitting if kind in (formats or _USUAL))
        if saved:
            chosen.append((figure, saved))
        elif itself:
            kind = "movie" if figure.is_movie else "figure"
            raise InvalidJob(f"{name} is a {kind}: --only must name one of {', '.join(fitting)}.")
    if not chosen:
        raise InvalidJob("None of the figures is saved in these formats.")
    return chosen


def figure_files(
    figure: PaperFigure, formats: Sequence[FigureFormat], progress: Progress = silent
) -> Made:
    """One figure or movie, in each of the formats that fit it.

    Raises `InvalidJob` for MP4 without an encoder.
    """
    progress(figure.name, 0, 1)
    drawn = figure.make()
    files = {}
    if isinstance(drawn, Drawing):
        saving = {FigureFormat.PNG: drawn.png_bytes, FigureFormat.SVG: drawn.svg_bytes}
        for kind in formats:
            if kind in saving:
                files[f"{figure.name}.{kind}"] = saving[kind]()
    else:
        pictures = drawn.images(lambda done, total: progress(figure.name, done, total))
        for kind, encoded in ((FigureFormat.GIF, gif_bytes), (FigureFormat.MP4, mp4_bytes)):
            if kind in formats:
                data = encoded(pictures, drawn.order, drawn.times_ms)
                files[f"{figure.name}.{kind}"] = data
    progress(figure.name, 1, 1)
    return Made(files, {"name": figure.name, "caption": figure.caption}, ())
