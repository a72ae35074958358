"""Feature sizes of a sheet: faces too narrow for the cutter, and how much larger it must be."""

from __future__ import annotations

import math

import numpy as np

from fab.errors import Finding, Severity, first_few
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray

__all__ = ["enlargement", "face_widths_mm", "narrow_faces"]


def enlargement(needed_mm: FloatArray, present_mm: FloatArray) -> str:
    """The least factor, in three digits, by which all present lengths exceed those needed.

    needed_mm, present_mm : shape (n,), at least one.

    >>> enlargement(np.array([3.0, 5.0]), np.array([1.0, 4.0]))
    '3.01'
    """
    with np.errstate(divide="ignore"):
        factor = float(np.max(needed_mm / present_mm))
    if not math.isfinite(factor):
        return "inf"
    unit = 10.0 ** (math.floor(math.log10(factor)) - 2)
    # rounding must not name a factor that makes lengths equal
    return f"{(math.floor(factor / unit * (1 + 1e-12)) + 1) * unit:.3g}"


def face_widths_mm(pattern: CreasePattern) -> FloatArray:
    """Least distance between a side of a face and the corner farthest from it, shape (nf,).

    The width of a convex face: it passes through no narrower gap between two parallel lines.
    """
    out = np.full(pattern.face_count, np.inf)
    for faces, corners in pattern.faces_by_size():
        points = pattern.vertices_coords[corners]
        for corner in range(corners.shape[1]):
            side = points[:, corner] - points[:, corner - 1]
            arm = points - points[:, corner, None]
            off = np.abs(side[:, None, 0] * arm[..., 1] - side[:, None, 1] * arm[..., 0])
            out[faces] = np.minimum(out[faces], off.max(axis=1) / np.hypot(*side.T))
    return out


def narrow_faces(pattern: CreasePattern, kerf_mm: float) -> list[Finding]:
    """A finding where faces are not wider than the kerf, so that their creases burn together."""
    width = face_widths_mm(pattern)
    narrow = np.flatnonzero(width <= kerf_mm)
    if not len(narrow):
        return []
    least = int(np.argmin(width))
    factor = enlargement(np.array([kerf_mm]), width[[least]])
    across = f"{width[least]:.3g} mm across"
    which = (
        f"faces is not wider than the kerf ({kerf_mm:g} mm): face {least} is {across}, and nothing "
        "of it is left between its creases"
        if len(narrow) == 1
        else f"faces are not wider than the kerf ({kerf_mm:g} mm), the narrowest, {least}, is "
        f"{across}: nothing of them is left between their creases"
    )
    return [
        Finding(
            "face-narrower-than-kerf",
            Severity.WARNING,
            f"{len(narrow)} of {len(width)} {which}. Make the sheet {factor} times as large, or "
            "take a finer beam.",
            panels=first_few(narrow),
        )
    ]
