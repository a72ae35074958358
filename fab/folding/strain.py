"""Strain of the faces of a sheet."""

from __future__ import annotations

import numpy as np

from fab.folding.bar_hinge_model import Framework
from solver.graphs import EdgeIndex
from solver.vectors import FloatArray

__all__ = ["faces_strain"]


def faces_strain(frame: Framework, coords: FloatArray) -> FloatArray:
    """Largest absolute strain of the bars of every face, shape (nf,); coords : shape (nv, 3)."""
    strain = np.abs(frame.strains(coords))
    index = EdgeIndex.of(frame.bars_vertices, len(frame.vertices_coords))
    out = np.zeros(frame.sheet.pattern.face_count)
    for k in range(3):
        bar = index.find(frame.triangles_vertices[:, [k, (k + 1) % 3]])
        np.maximum.at(out, frame.triangles_face, strain[bar])
    return out
