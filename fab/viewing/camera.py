"""Cameras: from millimetres in space to pixels, all lines of sight parallel."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.vectors import FloatArray, cross

__all__ = ["Camera", "fitted", "view_axes"]

# Sides of what is shown that are a smaller share of its longest one are as long as that.
_LEAST = 1e-9


@dataclass(frozen=True)
class Camera:
    """A parallel view, in which every length across the line of sight has the same scale.

    Attributes
    ----------
    axes : shape (3, 3), unit vectors: to the right, upwards, and towards the viewer.
    middle : shape (3,), mm, what is shown in the middle of the picture.
    pixels_per_mm : its scale.
    width, height : of the picture, in pixels.
    """

    axes: FloatArray
    middle: FloatArray
    pixels_per_mm: float
    width: int
    height: int

    def pixels(self, coords: FloatArray) -> FloatArray:
        """Where points (..., 3) are: pixels from the left, from the top, and towards the viewer.

        >>> camera = Camera(view_axes(90.0, -90.0), np.zeros(3), 2.0, 100, 60)
        >>> camera.pixels(np.array([[10.0, 5.0, 1.0]])).round(9).tolist()
        [[70.0, 20.0, 2.0]]
        """
        seen = (coords - self.middle) @ self.axes.T * self.pixels_per_mm
        return np.asarray(
            np.stack(
                [self.width / 2 + seen[..., 0], self.height / 2 - seen[..., 1], seen[..., 2]],
                axis=-1,
            )
        )

    def finer(self, factor: int) -> Camera:
        """The same view with `factor` times as many pixels along each side."""
        return replace(
            self,
            pixels_per_mm=self.pixels_per_mm * factor,
            width=self.width * factor,
            height=self.height * factor,
        )


def view_axes(elevation_deg: float, azimuth_deg: float) -> FloatArray:
    """Axes of a camera that stands at an azimuth from x towards y, as high as its elevation.

    Shape (3, 3). At 90 degrees it looks down, with y upwards for an azimuth of -90.
    """
    rise, turn = np.radians([elevation_deg, azimuth_deg])
    right = np.array([-np.sin(turn), np.cos(turn), 0.0])
    toward = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    return np.stack([right, cross(toward, right), toward])


def fitted(axes: FloatArray, coords: FloatArray, width: int, height: int, margin: int) -> Camera:
    """The camera with these axes that shows all points as large as fits inside a margin, in pixels.

    coords : shape (n, 3), mm; points that are not finite are left out.
    """
    seen = coords[np.isfinite(coords).all(axis=1)] @ axes.T
    if not len(seen):
        return Camera(axes, np.zeros(3), 1.0, width, height)
    low, high = seen.min(axis=0), seen.max(axis=0)
    span = np.maximum(high - low, _LEAST * (float((high - low).max()) or 1.0))
    scale = min((width - 2 * margin) / span[0], (height - 2 * margin) / span[1])
    return Camera(axes, (low + high) / 2 @ axes, float(scale), width, height)
