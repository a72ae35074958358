"""Where contact stops a sheet on its way to the target."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fab.folding.bar_hinge_model import Framework
from fab.folding.contact.contact import Contact
from solver.vectors import FloatArray, IntArray

__all__ = ["Stop", "stop_at"]


@dataclass(frozen=True)
class Stop:
    """Where a sheet is stopped.

    Attributes
    ----------
    share : of the fold, 0 to 1, from which on faces press on each other.
    faces : the two that press most at first, by their numbers in the pattern.
    point_mm : where they touch, in that state of the fold, as `Folding` has it.
    flat_mm : where that is on each of them, in the flat sheet.
    orders : how many orders of folding were tried.
    """

    share: float
    faces: tuple[int, int]
    point_mm: tuple[float, float, float]
    flat_mm: tuple[tuple[float, float], tuple[float, float]]
    orders: int = 1

    def report(self) -> dict[str, Any]:
        """As JSON values."""
        return asdict(self)


def stop_at(frame: Framework, contact: Contact, coords: FloatArray, share: float) -> Stop | None:
    """The stop of a sheet at coords, shape (nv, 3), where parts touch; None where none do."""
    found = contact.touching(coords)
    if not len(found.room):
        return None
    most = int(np.argmax(found.pressure))
    members, weights = found.pairs.members[most], found.weights[most]
    sides = [members[:1], members[1:]] if most < found.pairs.faced else [members[:2], members[2:]]
    shares = np.split(np.abs(weights), [len(sides[0])])
    faces = [_face_of(frame, side) for side in sides]
    size = frame.size_mm
    spots = [part @ coords[side] * size for side, part in zip(sides, shares, strict=True)]
    flat = [part @ frame.vertices_coords[side] for side, part in zip(sides, shares, strict=True)]
    point = (spots[0] + spots[1]) / 2
    if faces[0] > faces[1]:
        faces, flat = faces[::-1], flat[::-1]
    return Stop(
        share,
        (faces[0], faces[1]),
        (float(point[0]), float(point[1]), float(point[2])),
        (
            (float(flat[0][0] * size), float(flat[0][1] * size)),
            (float(flat[1][0] * size), float(flat[1][1] * size)),
        ),
    )


def _face_of(frame: Framework, vertices: IntArray) -> int:
    """The first face that has all of these vertices in one of its triangles."""
    inside = np.isin(frame.triangles_vertices, vertices).sum(axis=1) == len(vertices)
    return int(frame.triangles_face[inside].min())
