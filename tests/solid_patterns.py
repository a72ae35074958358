"""Patterns for the tests of thick panels: rings of quads, folded pairs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from flat_patterns import pattern_of

from fab.pattern.crease_pattern import CreasePattern


def creased(pattern: CreasePattern, angles_deg, folded=None) -> CreasePattern:
    """The pattern with other fold angles, and letters that agree."""
    letters = np.where(angles_deg > 0, "V", np.where(angles_deg < 0, "M", "F"))
    letters[pattern.edges_faces[:, 1] < 0] = "B"
    return replace(
        pattern, edges_foldAngle=angles_deg, edges_assignment=letters, folded_coords=folded
    )


def ringed(ring, angles_deg) -> CreasePattern:
    """A polygon, face 0, with a quad beyond each of its sides; its sides fold, spokes do not."""
    n = len(ring)
    coords = np.concatenate([ring, 3 * ring - 2 * ring.mean(axis=0)])
    around = [[n + i, n + (i + 1) % n, (i + 1) % n, i] for i in range(n)]
    pattern = pattern_of(coords, [list(range(n)), *around])
    signed = np.zeros(len(pattern.edges_vertices))
    low, high = np.sort(pattern.edges_vertices, axis=1).T
    inner = np.flatnonzero(high < n)
    side = np.where(high[inner] - low[inner] == 1, low[inner], high[inner])
    signed[inner] = np.broadcast_to(angles_deg, n)[side]
    return creased(pattern, signed)


def folded_pair(angle_deg: float, length: float = 20.0, width: float = 30.0) -> CreasePattern:
    """Two rectangles with a crease along x = 0, folded by the angle: valleys rise at x > 0."""
    y = [0.0, length]
    coords = np.array([[x, v] for v in y for x in (-width, 0.0, width)])
    flat = pattern_of(coords, [[0, 1, 4, 3], [1, 2, 5, 4]])
    turn = np.radians(angle_deg)
    right = np.maximum(coords[:, 0], 0)
    x = np.minimum(coords[:, 0], 0) + right * np.cos(turn)
    folded = np.column_stack([x, coords[:, 1], right * np.sin(turn)])
    angles = np.where(flat.edges_faces[:, 1] >= 0, angle_deg, 0.0)
    return creased(flat, angles, folded)
