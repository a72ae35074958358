"""Pictures and animations of a simulated fold, its faces coloured by strain."""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fab.folding.quasi_static import Folding, FoldState
from fab.folding.strain import faces_strain
from fab.progress import Steps, no_steps
from solver.vectors import FloatArray

__all__ = ["gif_bytes", "strain_png_bytes"]

_PIXELS, _DPI = 800, 100
_COLOURS = "YlOrRd"
_FRAME_MS, _LAST_MS = 150, 1500
# Least end of the colour scale: pictures of an exact fold would otherwise show rounding as strain.
_LEAST_STRAIN = 1e-6
_MOST_FRAMES = 60
_ELEVATION_DEG, _AZIMUTH_DEG = 35.0, -60.0
# With this zoom a picture shows the whole box with a margin.
_FITTING_ZOOM = 1.6


def strain_png_bytes(folding: Folding, title: str) -> bytes:
    """A PNG file of up to six states, evenly over the load, coloured by strain on one scale."""
    states = _sampled(folding, 6)
    columns = min(3, len(states))
    rows = -(-len(states) // columns)
    figure = _figure(6 * columns, 5 * rows + 1)
    scale = _largest_strain(folding)
    for number, state in enumerate(states, 1):
        axes: Any = figure.add_subplot(rows, columns, number, projection="3d", proj_type="ortho")
        _draw_state(axes, folding, state, scale)
        axes.set_title(_title(state))
    figure.subplots_adjust(0.02, 0.12, 0.98, 0.92, 0.05, 0.1)
    _draw_scale(figure, scale)
    figure.suptitle(title)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": "quadfold"})
    return stream.getvalue()


def gif_bytes(folding: Folding, title: str, progress: Steps = no_steps) -> bytes:
    """An endless GIF of the states there and back, coloured by strain, 800 x 800 pixels.

    It shows all states up to 60; of more, 60 evenly over the load.

    progress : called with (states drawn, states in all).
    """
    from PIL import Image

    scale = _largest_strain(folding)
    pictures = []
    states = _sampled(folding, _MOST_FRAMES)
    for done, state in enumerate(states):
        progress(done, len(states))
        figure = _figure(_PIXELS / _DPI, _PIXELS / _DPI)
        axes: Any = figure.add_axes((0, 0.05, 1, 0.9), projection="3d", proj_type="ortho")
        _draw_state(axes, folding, state, scale)
        figure.suptitle(f"{title}: {_title(state)}")
        stream = io.BytesIO()
        figure.savefig(stream, format="png")
        pictures.append(Image.open(stream).convert("P", palette=Image.Palette.ADAPTIVE))
    frames = [*pictures, *pictures[-2:0:-1]]
    times = [_FRAME_MS] * len(frames)
    times[len(pictures) - 1] = times[0] = _LAST_MS
    out = io.BytesIO()
    frames[0].save(
        out, format="GIF", save_all=True, append_images=frames[1:], duration=times, loop=0
    )
    return out.getvalue()


def _sampled(folding: Folding, most: int) -> list[FoldState]:
    """Up to `most` states, the first and the last among them."""
    chosen = np.unique(np.linspace(0, len(folding.states) - 1, most).round().astype(int))
    return [folding.states[k] for k in chosen]


def _title(state: FoldState) -> str:
    return f"{state.load:.0%}, strain up to {state.strain_max:.2%}"


def _figure(width: float, height: float) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=_DPI)
    FigureCanvasAgg(figure)
    return figure


def _largest_strain(folding: Folding) -> float:
    return max(_LEAST_STRAIN, *(state.strain_max for state in folding.states))


def _draw_state(axes: Any, folding: Folding, state: FoldState, scale: float) -> None:
    """One state, in the box that holds all of them; scale : strain of the darkest colour."""
    from matplotlib import colormaps
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    frame = folding.frame
    pattern = frame.sheet.pattern
    coords = state.coords * frame.size_mm
    strain = faces_strain(frame, state.coords)
    faces = [
        coords[pattern.faces_vertices[i:j]] for i, j in pairwise(pattern.faces_offsets.tolist())
    ]
    width = min(0.5, 30 / np.sqrt(len(pattern.edges_vertices)))
    axes.add_collection3d(
        Poly3DCollection(
            faces,
            facecolors=colormaps[_COLOURS](np.sqrt(strain / scale)),
            edgecolors="#303030",
            linewidths=width,
        )
    )
    middle, side = _view_box([each.coords for each in folding.states])
    middle, side = middle * frame.size_mm, side * frame.size_mm
    for axis, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{axis}lim")(centre - side / 2, centre + side / 2)
    axes.set_box_aspect((1, 1, 1), zoom=_FITTING_ZOOM)
    axes.view_init(elev=_ELEVATION_DEG, azim=_AZIMUTH_DEG)
    axes.set_axis_off()


def _view_box(coords: Sequence[FloatArray]) -> tuple[FloatArray, float]:
    """Middle of all states as the picture shows them, and the longer side of the box around it."""
    up, around = np.radians([_ELEVATION_DEG, _AZIMUTH_DEG])
    right = np.array([-np.sin(around), np.cos(around), 0.0])
    towards = np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    view = np.stack([right, np.cross(towards, right), towards], axis=1)
    every = np.concatenate(coords) @ view
    low, high = every.min(axis=0), every.max(axis=0)
    return (low + high) / 2 @ view.T, float((high - low)[:2].max())


def _draw_scale(figure: Any, scale: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import PowerNorm
    from matplotlib.ticker import PercentFormatter

    bar = figure.add_axes((0.25, 0.07, 0.5, 0.015))
    mappable = ScalarMappable(PowerNorm(0.5, 0, scale), _COLOURS)
    figure.colorbar(
        mappable,
        cax=bar,
        orientation="horizontal",
        label="largest strain of a face",
        format=PercentFormatter(1.0),
    )
