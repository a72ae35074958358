"""Painted triangles: lit, with lines around what belongs together, as an array of pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fab.viewing.camera import Camera
from fab.viewing.raster import nearest_triangles
from solver.vectors import BoolArray, FloatArray, IntArray, cross, unit

__all__ = ["Painting", "Shapes", "painted", "painting", "triangle_normals"]

# Pictures are drawn finer by this factor, then averaged.
_FINER = 2
# To the right, upwards, towards the viewer: light comes with the viewer, over the left shoulder.
_LIGHT = unit(np.array([-0.5, 0.65, 0.8]))
# How far all groups together are moved apart, towards the viewer.
_LAYERS_PIXELS = 0.2
# Sides of solids that are seen edge on are left out.
_EDGE_ON = 1e-9
_LINE = 0.35
# Faces that are narrower than this, in pixels, have fainter lines: they would be all lines.
_NARROW = 14.0
# Faces that are wider than this have lines of a pixel, others of half of one.
_WIDE = 40.0


@dataclass(frozen=True)
class Shapes:
    """Triangles to be painted.

    Attributes
    ----------
    corners : shape (n, 3, 3), mm, finite.
    colours, backs : shape (n, 3), red, green and blue from 0 to 1, of the side from which the
        corners are counterclockwise, and of the other one.
    groups : shape (n,), equal where no line is drawn between triangles; -1 for triangles that
        have no lines.
    behind_mm : all of them yield to others that are up to so far behind them.
    darkest : how bright colours are without light, over what they are in it.
    closed : whether they are around solids, so that their backs are not seen.
    layered : whether those that would be on each other are apart already.
    """

    corners: FloatArray
    colours: FloatArray
    backs: FloatArray
    groups: IntArray
    behind_mm: float = 0.0
    darkest: float = 0.58
    closed: bool = False
    layered: bool = False


@dataclass(frozen=True)
class Painting:
    """A picture, and what is seen in it, which is known finer than the picture.

    Attributes
    ----------
    picture : on white, shape (height, width, 3), from 0 to 1.
    groups : shape (k height, k width), those of the first shapes as they are, those of the next
        after them, and so on; -1 where there is nothing, -2 where triangles without lines are.
    heights : of the same shape, towards the viewer, in fine pixels; -inf where there is nothing.
    finer : k.
    """

    picture: FloatArray
    groups: IntArray
    heights: FloatArray
    finer: int = _FINER


def painted(camera: Camera, shapes: Sequence[Shapes]) -> FloatArray:
    """A picture on white, shape (height, width, 3), from 0 to 1."""
    return painting(camera, shapes).picture


def painting(camera: Camera, shapes: Sequence[Shapes]) -> Painting:
    """A picture on white, and the groups that are seen in it."""
    fine = camera.finer(_FINER)
    places, inks, groups = [], [], []
    first = 0
    for each in shapes:
        corners = fine.pixels(each.corners)
        normals = triangle_normals(corners * [1, -1, 1])  # rows run downwards
        kept = normals[:, 2] > _EDGE_ON if each.closed else np.ones(len(normals), bool)
        normals, corners = normals[kept], corners[kept]
        corners[..., 2] -= each.behind_mm * fine.pixels_per_mm
        # of faces that are on each other, as when folded flat, the first one is seen all over
        own = each.groups[kept]
        layers = 0.0 if each.layered else _LAYERS_PIXELS
        corners[..., 2] -= (own * (layers / max(1, int(own.max(initial=1)))))[:, None]
        front = normals[:, 2:] >= 0
        normals = np.where(front, normals, -normals)
        light = each.darkest + (1 - each.darkest) * np.clip(normals @ _LIGHT, 0, 1)
        places.append(corners)
        inks.append(np.where(front, each.colours[kept], each.backs[kept]) * light[:, None])
        groups.append(np.where(own < 0, -2, own + first))
        first += int(each.groups.max(initial=-1)) + 1
    ink, group = np.concatenate(inks), np.concatenate(groups)
    owner, heights = nearest_triangles(np.concatenate(places), fine.width, fine.height)
    drawn = owner >= 0
    picture = np.ones((fine.height, fine.width, 3))
    picture[drawn] = ink[owner[drawn]]
    shown = np.full(owner.shape, -1)
    shown[drawn] = group[owner[drawn]]
    strength, wide = _lines(shown)
    picture[_between(shown, wide)] *= 1 - (1 - _LINE) * strength
    parts = picture.reshape(camera.height, _FINER, camera.width, _FINER, 3)
    return Painting(np.clip(parts.mean(axis=(1, 3)), 0, 1), shown, heights)


def triangle_normals(corners: FloatArray) -> FloatArray:
    """Unit normals of triangles (n, 3, 3), shape (n, 3); 0 where there is no area."""
    a, b, c = corners.swapaxes(0, 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nan_to_num(unit(cross(b - a, c - a)))


def _lines(shown: IntArray) -> tuple[float, bool]:
    """How strong lines are, 0 to 1, and whether they are wide, by how large groups are seen."""
    _, counts = np.unique(shown[shown >= 0], return_counts=True)
    if not len(counts):
        return 0.0, False
    size = float(np.sqrt(np.median(counts))) / _FINER
    return min(1.0, size / _NARROW), size > _WIDE


def _between(shown: IntArray, wide: bool) -> BoolArray:
    """Pixels beside another group; from both sides where lines are wide."""
    across, down = shown[:, :-1] != shown[:, 1:], shown[:-1] != shown[1:]
    # what has no lines has none where it ends at the background, and none of its own
    across &= (shown[:, :-1] >= 0) | (shown[:, 1:] >= 0)
    down &= (shown[:-1] >= 0) | (shown[1:] >= 0)
    out = np.zeros(shown.shape, bool)
    out[:, :-1] |= across
    out[:-1] |= down
    if wide:
        out[:, 1:] |= across
        out[1:] |= down
    return out
