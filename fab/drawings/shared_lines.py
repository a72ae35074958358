"""Lines that two outlines share, cut once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from solver.vectors import FloatArray, IntArray

__all__ = ["cut_once"]

# Edges nearer to each other than this are one line, mm; parts shorter than it are none.
_SAME_MM = 2e-3


def cut_once(paths: CutPaths) -> CutPaths:
    """The drawing with every line that several outlines of CUT share in the first of them alone.

    What is left of the others is cut as open chains, or as single segments.

    >>> squares = [np.array([[x, 0.0], [x + 1, 0.0], [x + 1, 1.0], [x, 1.0]]) for x in (0.0, 1.0)]
    >>> both = CutPaths((Layer(Operation.CUT, outlines=tuple(squares)),), (2.0, 1.0))
    >>> (layer,) = cut_once(both).layers
    >>> len(layer.outlines), [chain.tolist() for chain in layer.chains]
    (1, [[[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]]])
    """
    return replace(
        paths,
        layers=tuple(
            _once(layer) if layer.operation is Operation.CUT else layer for layer in paths.layers
        ),
    )


def _once(layer: Layer) -> Layer:
    rings = layer.outlines
    if len(rings) < 2:
        return layer
    edges = np.concatenate([np.stack([r, np.roll(r, -1, axis=0)], axis=1) for r in rings])
    sizes = [len(ring) for ring in rings]
    ring_of = np.repeat(np.arange(len(rings)), sizes)
    covered = _covered(edges, ring_of)
    outlines, chains, segments = [], list(layer.chains), [layer.segments]
    begins = np.cumsum([0, *sizes[:-1]])
    for ring, begin in zip(rings, begins.tolist(), strict=True):
        own = range(begin, begin + len(ring))
        if not any(covered[edge] for edge in own):
            outlines.append(ring)
            continue
        for chain in _open_parts([_rest(edges[edge], covered[edge]) for edge in own]):
            if len(chain) == 2:
                segments.append(chain[None])
            else:
                chains.append(chain)
    return replace(
        layer,
        outlines=tuple(outlines),
        chains=tuple(chains),
        segments=np.concatenate(segments),
    )


def _covered(edges: FloatArray, ring_of: IntArray) -> list[list[tuple[float, float]]]:
    """For each edge, the places along it, in mm, that edges of earlier rings run along."""
    lines = shapely.linestrings(edges)
    later, earlier = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=_SAME_MM)
    pairs = ring_of[earlier] < ring_of[later]
    later, earlier = later[pairs], earlier[pairs]
    start = edges[later, 0]
    ahead = edges[later, 1] - start
    length = np.hypot(*ahead.T)
    unit = ahead / length[:, None]
    arms = edges[earlier] - start[:, None]
    across = unit[:, None, 0] * arms[..., 1] - unit[:, None, 1] * arms[..., 0]
    place = (unit[:, None] * arms).sum(axis=2)
    low = np.maximum(place.min(axis=1), 0.0)
    high = np.minimum(place.max(axis=1), length)
    along = (np.abs(across) < _SAME_MM).all(axis=1) & (high - low > _SAME_MM)
    out: list[list[tuple[float, float]]] = [[] for _ in edges]
    for edge, a, b in zip(
        later[along].tolist(), low[along].tolist(), high[along].tolist(), strict=True
    ):
        out[edge].append((a, b))
    return out


def _rest(edge: FloatArray, covered: Sequence[tuple[float, float]]) -> list[FloatArray]:
    """The parts of an edge, shape (2, 2), that are not covered, in their order."""
    if not covered:
        return [edge]
    length = float(np.hypot(*(edge[1] - edge[0])))
    parts, place = [], 0.0
    for low, high in [*sorted(covered), (length, length)]:
        if low - place > _SAME_MM:
            ends = np.array([place, low]) / length
            part = edge[0] + ends[:, None] * (edge[1] - edge[0])
            part[0] = edge[0] if place == 0.0 else part[0]
            part[1] = edge[1] if low == length else part[1]
            parts.append(part)
        place = max(place, high)
    return parts


def _open_parts(edges: Sequence[Sequence[FloatArray]]) -> list[FloatArray]:
    """Chains of the parts of a ring's edges that follow each other, each shape (m, 2).

    At least one edge of the ring is covered in part.
    """
    parts = [part for edge in edges for part in edge]
    if not parts:
        return []
    meets = [
        bool((np.abs(part[1] - following[0]) <= _SAME_MM).all())
        for part, following in zip(parts, [*parts[1:], parts[0]], strict=True)
    ]
    if all(meets):  # only a corner is covered
        return [np.concatenate([parts[0][:1], *(part[1:] for part in parts)])]
    first = meets.index(False) + 1
    parts = parts[first:] + parts[:first]
    meets = meets[first:] + meets[:first]
    chains, current = [], [parts[0]]
    for part, joined in zip(parts[1:], meets[:-1], strict=True):
        if joined:
            current.append(part)
        else:
            chains.append(current)
            current = [part]
    chains.append(current)
    return [np.concatenate([chain[0][:1], *(part[1:] for part in chain)]) for chain in chains]
