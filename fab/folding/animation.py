"""What does a fold look like on its way: strain as colour, state after state?"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fab.folding.bar_hinge_model import Framework
from fab.folding.quasi_static import Folding, FoldState
from solver.vectors import FloatArray

__all__ = ["faces_strain", "gif_bytes", "strain_png_bytes"]

_PIXELS, _DPI = 800, 100
_COLOURS = "YlOrRd"
_FRAME_MS, _LAST_MS = 150, 1500
# Pictures of an exact fold would otherwise show rounding as strain.
_LEAST_STRAIN = 1e-6
_MOST_FRAMES = 60
_ELEVATION_DEG, _AZIMUTH_DEG = 35.0, -60.0
# With this zoom, a picture is as wide and high as the box is long, with a margin.
_FITTING_ZOOM = 1.6

Progress = Callable[[int, int], None]


def faces_strain(frame: Framework, coords: FloatArray) -> FloatArray:
    """Largest strain of the bars of every face, shape (nf,)."""
    strain = np.abs(frame.strains(coords))
    count = len(frame.vertices_coords)
    low, high = np.sort(frame.bars_vertices, axis=1).T
    order = np.argsort(low * count + high)
    keys = (low * count + high)[order]
    out = np.zeros(len(frame.sheet.pattern.faces_offsets) - 1)
    for k in range(3):
        pair = np.sort(frame.triangles_vertices[:, [k, (k + 1) % 3]], axis=1)
        bar = order[np.searchsorted(keys, pair[:, 0] * count + pair[:, 1])]
        np.maximum.at(out, frame.triangles_face, strain[bar])
    return out


def strain_png_bytes(folding: Folding, title: str) -> bytes:
    """Up to six states, evenly over the load, coloured by strain: one scale for all of them."""
    states = _evenly(folding, 6)
    columns = min(3, len(states))
    rows = -(-len(states) // columns)
    figure = _figure(6 * columns, 5 * rows + 1)
    most = _most_strain(folding)
    for place, state in enumerate(states):
        axes: Any = figure.add_subplot(rows, columns, place + 1, projection="3d", proj_type="ortho")
        _draw(axes, folding, state, most)
        axes.set_title(_title(state))
    figure.subplots_adjust(0.02, 0.12, 0.98, 0.92, 0.05, 0.1)
    _scale(figure, most)
    figure.suptitle(title)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": "quadfold"})
    return stream.getvalue()


def gif_bytes(folding: Folding, title: str, progress: Progress | None = None) -> bytes:
    """States one after another and back, coloured by strain, 800 x 800 pixels, endless.

    All of them up to 60; of more, 60 evenly over the load.
    """
    from PIL import Image

    most = _most_strain(folding)
    pictures = []
    states = _evenly(folding, _MOST_FRAMES)
    for done, state in enumerate(states):
        if progress is not None:
            progress(done, len(states))
        figure = _figure(_PIXELS / _DPI, _PIXELS / _DPI)
        axes: Any = figure.add_axes((0, 0.05, 1, 0.9), projection="3d", proj_type="ortho")
        _draw(axes, folding, state, most)
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


def _evenly(folding: Folding, most: int) -> list[FoldState]:
    """At most so many states, the first and the last among them."""
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


def _most_strain(folding: Folding) -> float:
    return max(_LEAST_STRAIN, *(state.strain_max for state in folding.states))


def _draw(axes: Any, folding: Folding, state: FoldState, most: float) -> None:
    """One state, in the box that holds them all."""
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
            facecolors=colormaps[_COLOURS](np.sqrt(strain / most)),
            edgecolors="#303030",
            linewidths=width,
        )
    )
    middle, side = _seen([each.coords for each in folding.states])
    middle, side = middle * frame.size_mm, side * frame.size_mm
    for axis, at in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{axis}lim")(at - side / 2, at + side / 2)
    axes.set_box_aspect((1, 1, 1), zoom=_FITTING_ZOOM)
    axes.view_init(elev=_ELEVATION_DEG, azim=_AZIMUTH_DEG)
    axes.set_axis_off()


def _seen(coords: Sequence[FloatArray]) -> tuple[FloatArray, float]:
    """Middle of what is seen of the sheets, and the longer side of the box around it."""
    up, around = np.radians([_ELEVATION_DEG, _AZIMUTH_DEG])
    right = np.array([-np.sin(around), np.cos(around), 0.0])
    towards = np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    view = np.stack([right, np.cross(towards, right), towards], axis=1)
    every = np.concatenate(coords) @ view
    low, high = every.min(axis=0), every.max(axis=0)
    return (low + high) / 2 @ view.T, float((high - low)[:2].max())


def _scale(figure: Any, most: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import PowerNorm
    from matplotlib.ticker import PercentFormatter

    bar = figure.add_axes((0.25, 0.07, 0.5, 0.015))
    mappable = ScalarMappable(PowerNorm(0.5, 0, most), _COLOURS)
    figure.colorbar(
        mappable,
        cax=bar,
        orientation="horizontal",
        label="largest strain of a face",
        format=PercentFormatter(1.0),
    )
