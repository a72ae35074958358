"""What was read from a file of crease patterns."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fab.errors import Finding
from fab.formats.coordinate_bounds import require_asked_size
from fab.formats.units import with_size_given
from fab.pattern.crease_pattern import CreasePattern, scaled
from solver.vectors import FloatArray, IntArray

__all__ = ["PatternFile", "State", "resized"]

# A folded shape by its title and points, shape (nv, 3), mm.
State = tuple[str, FloatArray]


@dataclass(frozen=True)
class PatternFile:
    """A crease pattern in millimetres, its lower left corner at the origin.

    Attributes
    ----------
    title : of the file; empty where it has none.
    states : other folded shapes than the folded form, by their titles, in mm.
    findings : what was repaired, assumed or noticed.
    patterns : how many crease patterns the file holds; `ReadOptions.frame` chooses one of them.
    mm_per_unit : millimetres per unit of the file.
    origin : the pattern's lower left corner in the file, mm, shape (2,): places of findings are
        measured from where the file has its own origin.
    face_orders : rows of FOLD's faceOrders in the file, by the faces of the pattern, shape (n, 3).
    """

    title: str
    pattern: CreasePattern
    states: tuple[State, ...]
    findings: tuple[Finding, ...]
    patterns: int = 1
    mm_per_unit: float = 1.0
    origin: FloatArray = field(default_factory=lambda: np.zeros(2))
    face_orders: IntArray = field(default_factory=lambda: np.empty((0, 3), np.int64))


def resized(
    read: PatternFile, *, width_mm: float | None = None, factor: float | None = None
) -> PatternFile:
    """What was read with its longer side `width_mm` long, or `factor` times as large; see `scaled`.

    Texts of findings keep the coordinates of the file, and that of its unit says what was done with
    the size; their places follow it. Raises `InvalidJob` for sizes that nothing can be made of.
    """
    pattern = scaled(read.pattern, width_mm=width_mm, factor=factor)
    if pattern is read.pattern:
        return read
    if width_mm is None:
        asked = f"scale {factor:g}"
        done = f"The sheet was then made {factor:g} times as large"
    else:
        asked = f"width {width_mm:g} mm"
        done = f"The longer side of the sheet was then made {width_mm:g} mm long"
    require_asked_size(asked, float(np.ptp(pattern.vertices_coords, axis=0).max()))
    before, after = (np.ptp(p.vertices_coords, axis=0).max() for p in (read.pattern, pattern))
    times = float(after / before)
    findings = tuple(
        replace(
            with_size_given(finding, done),
            places=tuple((x * times, y * times) for x, y in finding.places),
        )
        for finding in read.findings
    )
    return replace(
        read,
        pattern=pattern,
        states=tuple((title, coords * times) for title, coords in read.states),
        findings=findings,
        mm_per_unit=read.mm_per_unit * times,
        origin=read.origin * times,
    )
