"""Picture of a sheet: the folded form beside its crease pattern, as a PNG."""

from __future__ import annotations

import io
from itertools import pairwise
from typing import Any

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from solver.polygons import face_normals
from solver.vectors import FloatArray, norm, unit

__all__ = ["png_bytes", "principal_axes"]

_INK = {"M": "#d62020", "V": "#2050d6", "F": "#b0b0b0", "B": "#202020"}
_LIGHT = unit(np.array([-0.4, -0.5, 0.9]))
_UPPER, _LOWER = np.array([0.96, 0.84, 0.62]), np.array([0.62, 0.74, 0.86])


def png_bytes(pattern: CreasePattern, title: str, *, upright: bool = False) -> bytes:
    """Folded form on the left (where it is known), crease pattern on the right, 1600 x 800 pixels.

    Red mountains, blue valleys, black outline; the upper side of the sheet is sand, the lower blue.

    upright : whether the folded form stands with z upwards; else its longest directions lie flat.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    figure = Figure(figsize=(16, 8), dpi=100)
    FigureCanvasAgg(figure)
    folded = pattern.folded_coords
    edge_count = len(pattern.edges_vertices)
    if folded is not None:
        space: Any = figure.add_axes((0.0, 0.0, 0.5, 1.0), projection="3d", proj_type="ortho")
        turned = folded if upright else folded @ principal_axes(folded).T
        bounds = pattern.faces_offsets.tolist()
        faces = [turned[pattern.faces_vertices[i:j]] for i, j in pairwise(bounds)]
        space.view_init(elev=35, azim=-60)
        toward = np.array([np.cos(np.radians(35)) * 0.5, -np.cos(np.radians(35)) * 0.866, 0.5736])
        colours = _shades(pattern, turned, toward)
        space.add_collection3d(
            Poly3DCollection(
                faces,
                facecolors=colours,
                edgecolors="#303030",
                linewidths=min(0.5, 30 / np.sqrt(edge_count)),
            )
        )
        low, high = turned.min(axis=0), turned.max(axis=0)
        for axis, (a, b) in zip("xyz", zip(low, high, strict=True), strict=True):
            getattr(space, f"set_{axis}lim")(a, b if b > a else a + 1)
        space.set_box_aspect(np.maximum(high - low, 1e-3 * (high - low).max()), zoom=1.0)
        space.set_axis_off()
    left = 0.04 if folded is None else 0.54
    plane = figure.add_axes((left, 0.06, 0.98 - left, 0.87))
    for letter in "FMVB":
        chosen = pattern.edges_assignment == letter
        lines = pattern.vertices_coords[pattern.edges_vertices[chosen]]
        width = min(1.0, 40 / np.sqrt(edge_count))
        plane.add_collection(LineCollection(lines, colors=_INK[letter], linewidths=width))
    plane.set_aspect("equal")
    plane.autoscale_view()
    plane.set_xlabel("mm")
    counts = pattern.counts()
    plane.set_title(
        f"{title}: {pattern.face_count} faces, {counts['M']} mountains (red), "
        f"{counts['V']} valleys (blue)"
    )
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": "quadfold"})
    return stream.getvalue()


def principal_axes(coords: FloatArray) -> FloatArray:
    """Rotation that lays the two longest directions of a point set flat, rows are the axes."""
    _, vectors = np.linalg.eigh(np.cov((coords - coords.mean(axis=0)).T))
    axes: FloatArray = vectors.T[::-1].copy()
    for axis in axes[:2]:
        axis *= np.sign(axis[np.argmax(np.abs(axis))])
    axes[2] = np.cross(axes[0], axes[1])
    return axes


def _shades(pattern: CreasePattern, coords: FloatArray, toward: FloatArray) -> FloatArray:
    """Face colours, shape (nf, 3): lit, and by which side of the sheet faces the viewer."""
    normals = face_normals(coords, pattern.faces_vertices, pattern.faces_offsets)
    upper = normals @ toward > 0
    lit = 0.55 + 0.45 * np.abs(normals @ _LIGHT) / norm(_LIGHT)
    return np.clip(np.where(upper[:, None], _UPPER, _LOWER) * lit[:, None], 0, 1)
