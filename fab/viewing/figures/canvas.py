"""What figures and movies are drawn on, and their files."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from fab.progress import Steps, no_steps
from fab.viewing.movie_files import FRAME_MS

__all__ = [
    "INK",
    "PALETTE",
    "Drawing",
    "Movie",
    "all_around",
    "movie",
    "new_figure",
    "plain",
    "shaded",
]

_DPI = 100
INK = {"M": "#d62020", "V": "#2050d6", "F": "#b0b0b0", "B": "#202020"}
# Colours that differ in lightness too, for curves that are told apart.
PALETTE = ("#0b6e99", "#d1642a", "#3a8a3a", "#8a3ab0", "#b08a00", "#7a4a2a", "#c0417e", "#555555")


@dataclass(frozen=True)
class Drawing:
    """A figure, as files.

    Attributes
    ----------
    figure : the matplotlib Figure, which may be changed before it is saved.
    """

    figure: Any

    def png_bytes(self) -> bytes:
        """The figure as PNG, 100 pixels to an inch."""
        return self._saved("png", {"Software": "quadfold"})

    def svg_bytes(self) -> bytes:
        """The figure as SVG, its text as outlines."""
        return self._saved("svg", {"Date": None, "Creator": "quadfold"})

    def _saved(self, kind: str, metadata: dict[str, Any]) -> bytes:
        from matplotlib import rc_context

        stream = io.BytesIO()
        with rc_context({"svg.hashsalt": "quadfold", "svg.fonttype": "path"}):
            self.figure.savefig(stream, format=kind, metadata=metadata)
        return stream.getvalue()

    def image(self) -> Any:
        """The figure as an RGB image of Pillow."""
        from PIL import Image

        self.figure.canvas.draw()
        size = self.figure.canvas.get_width_height()
        return Image.frombytes("RGBA", size, bytes(self.figure.canvas.buffer_rgba())).convert("RGB")


@dataclass(frozen=True)
class Movie:
    """Pictures of one size, each drawn when it is needed.

    Attributes
    ----------
    frames : each draws one picture.
    order : which is shown, one after another, by number.
    times_ms : for how long.
    """

    frames: Sequence[Callable[[], Drawing]]
    order: Sequence[int]
    times_ms: Sequence[int]

    def images(self, progress: Steps = no_steps) -> list[Any]:
        """All pictures; progress : called with (pictures drawn, pictures in all)."""
        out = []
        for done, frame in enumerate(self.frames):
            progress(done, len(self.frames))
            out.append(frame().image())
        return out


def movie(frames: Sequence[Callable[[], Drawing]], last_ms: int = FRAME_MS) -> Movie:
    """A movie of pictures one after another, the last of them shown longer."""
    times = [FRAME_MS] * len(frames)
    times[-1] = last_ms
    return Movie(frames, range(len(frames)), times)


def new_figure(width_px: float, height_px: float) -> Any:
    """An empty figure of this size."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_px / _DPI, height_px / _DPI), dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def plain(figure: Any, place: tuple[float, float, float, float], title: str = "") -> Any:
    """Axes without a frame, of one scale in x and y, at (left, bottom, width, height)."""
    axes = figure.add_axes(place)
    axes.set_axis_off()
    axes.set_aspect("equal")
    if title:
        axes.set_title(title, fontsize=10)
    return axes


def all_around(values: Any, turn: float = 0.0) -> Any:
    """Values at angles around a circle, along the last axis, and the first again, a turn later."""
    import numpy as np

    return np.concatenate([values, values[..., :1] + turn], axis=-1)


def shaded(axes: Any, arcs: Any, colour: str = "#d62020", alpha: float = 0.12) -> None:
    """Arcs of angles, in radians, as upright bands on axes whose x is in degrees from 0 to 360."""
    import numpy as np

    for start, end in np.degrees(arcs).reshape(-1, 2).tolist():
        spans = [(start, end)] if start < end else [(start, 360.0), (0.0, end)]
        for low, high in spans:
            axes.axvspan(low, high, color=colour, alpha=alpha, lw=0)
