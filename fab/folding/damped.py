"""Factors of damped symmetric matrices, whose sparsity may be another one each time."""

from __future__ import annotations

from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu

__all__ = ["damped"]


def damped(matrix: csc_array, damping: float) -> SuperLU:
    """Factors of a symmetric matrix, `damping` times its mean diagonal entry added to each."""
    matrix = matrix.copy()
    diagonal = matrix.diagonal()
    matrix.setdiag(diagonal + damping * diagonal.mean())
    return splu(
        matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
