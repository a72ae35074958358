"""The view that shows most of a form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fab.viewing.camera import fitted, view_axes
from fab.viewing.raster import nearest_triangles
from solver.vectors import FloatArray, IntArray

__all__ = ["best_view"]

_PIXELS = 120
# None of them looks along a side of the box around a form, which would show no depth.
_AZIMUTHS_DEG = tuple(-67.5 + 45 * k for k in range(8))
_LYING_DEG = (35.0, 50.0)
_UPRIGHT_DEG = (15.0, 30.0, 45.0)
# A view that follows must be better by this share: near ties stay with the first.
_BETTER = 1.02


def best_view(forms: Sequence[FloatArray], faces: IntArray, *, upright: bool) -> FloatArray:
    """Axes of a camera, shape (3, 3): of views from around a form, the one that shows most of it.

    The one with the largest viewpoint entropy (Vazquez et al. 2001, Viewpoint selection using
    viewpoint entropy): many faces are seen, and all of them large.

    forms : each of shape (n, 3, 3), mm, of triangles: a form in one state or several. faces : shape
    (n,), of each triangle. upright : whether z is up, so that it is seen rather from the side; else
    it lies flat, and is seen rather from above.
    """
    views = [
        view_axes(rise, turn)
        for rise in (_UPRIGHT_DEG if upright else _LYING_DEG)
        for turn in _AZIMUTHS_DEG
    ]
    values = np.zeros(len(views))
    for corners in forms:
        points = corners.reshape(-1, 3)
        cameras = [fitted(axes, points, _PIXELS, _PIXELS, 1) for axes in views]
        # all views of a form at one scale: what is seen from its narrow side is small
        scale = min(camera.pixels_per_mm for camera in cameras)
        for number, camera in enumerate(cameras):
            seen = replace(camera, pixels_per_mm=scale)
            values[number] += _entropy(seen.pixels(corners), faces)
    best = 0
    for number in range(1, len(views)):
        if values[number] > values[best] * _BETTER:
            best = number
    return views[best]


def _entropy(corners: FloatArray, faces: IntArray) -> float:
    """Entropy of the shares of a picture that faces and the background have."""
    slim = len(corners) < _PIXELS**2  # of more, all are: what their middles show is enough
    owner, _ = nearest_triangles(corners, _PIXELS, _PIXELS, slim=slim)
    seen = np.bincount(faces[owner[owner >= 0]], minlength=1)
    shares = seen[seen > 0] / owner.size
    return float(-(shares * np.log(shares)).sum())
