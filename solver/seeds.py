"""Seeds of growth: a curve in space, or a first strip."""

from __future__ import annotations

import numpy as np

from solver.errors import require_count, require_length, require_number, require_within
from solver.mesh import QuadMesh
from solver.vectors import FloatArray
from solver.vertex import require_foldable

__all__ = ["corrugated", "curve", "miura"]


def curve(vertices_coords: FloatArray) -> QuadMesh:
    """A curve in space, shape (m + 1, 3), to grow on with a chosen k (the paper's corollary)."""
    return QuadMesh.from_rows(np.asarray(vertices_coords, float)[None])


def miura(
    columns: int, sector_angle: float, fold: float, zigzag_length: float, crease_length: float
) -> QuadMesh:
    """The first strip of a Miura sheet: rows zigzag at constant z, creases climb between them.

    Parameters
    ----------
    columns : number of quads in the strip, at least 2.
    sector_angle : acute angle of the parallelograms, radians in (0, pi/2).
    fold : angle between each parallelogram and the plane z = 0, radians in (0, pi/2);
        0 would be flat, pi/2 folded flat.
    zigzag_length, crease_length : the parallelogram's sides along and across the strip.

    Source: M. Schenk and S. D. Guest, "Geometry of Miura-folded metamaterials", PNAS 110 (2013).
    """
    require_count("columns", columns, 2, "A strip needs an interior crease.")
    require_within(
        "sector_angle", sector_angle, 0.0, np.pi / 2, "60 degrees is common.", angle=True
    )
    require_within("fold", fold, 0.0, np.pi / 2, "0 is flat, 90 degrees is closed.", angle=True)
    require_length("zigzag_length", zigzag_length)
    require_length("crease_length", crease_length)
    lean = np.sqrt(1 - (np.sin(fold) * np.sin(sector_angle)) ** 2)
    step = zigzag_length * np.cos(fold) * np.sin(sector_angle) / lean
    swing = zigzag_length * np.cos(sector_angle) / lean
    i = np.arange(columns + 1)
    rows = np.zeros((2, columns + 1, 3))
    rows[:, :, 0] = step * i
    rows[:, :, 1] = swing * (i % 2)
    rows[1, :, 1] += crease_length * lean
    rows[1, :, 2] = crease_length * np.sin(fold) * np.sin(sector_angle)
    return QuadMesh.from_rows(rows)


def corrugated(columns: int, beta: float, k: float, lengths: FloatArray) -> QuadMesh:
    """The first strip of the crumpled sheet: a zigzag row swept along one direction (figure 4E).

    With unit vectors a, b at the angle beta and c such that angle(a, c) = angle(b, c) = pi - k/2,
    the previous row repeats c, a + c with the shift b - a, and front vertex i is y_i - lengths_i c.

    Parameters
    ----------
    columns : number of quads in the strip, at least 2.
    beta, k : radians, 0 < beta < pi and beta < k < 2 pi - beta.
    lengths : of the creases, positive, shape (columns + 1,).
    """
    require_count("columns", columns, 2, "A strip needs an interior crease.")
    require_number("beta", beta)
    require_number("k", k)
    require_foldable(np.array([beta]), np.array([k]))
    a = np.array([0.0, -np.sin(beta / 2), -np.cos(beta / 2)])
    b = np.array([0.0, np.sin(beta / 2), -np.cos(beta / 2)])
    lift = np.cos(k / 2) / np.cos(beta / 2)
    c = np.array([-np.sqrt(1 - lift**2), 0.0, lift])
    i = np.arange(columns + 1)
    y = c + np.where(i % 2 == 0, 1.0, 0.0)[:, None] * a + (i // 2)[:, None] * (b - a)
    return QuadMesh.from_rows(np.stack([y, y - lengths[:, None] * c]))
