"""Order and direction in which the lines of a sheet are cut.

The order of the work is that of the operations. Within each, a tour keeps the travel short
(`fab.sheets.tours`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import shapely

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.sheets.tours import GAIN_MM, Tour, nearest_neighbours, travel_mm
from solver.vectors import FloatArray, IntArray

__all__ = ["occupied_holes_last", "tour"]

# Rounds of choosing the start of each outline anew.
_ROUNDS = 4


def tour(paths: CutPaths) -> CutPaths:
    """The same lines in an order and direction that keep the travel short, from the origin on.

    Operations follow each other in the order of the work, in each segments, then chains, then
    outlines. CUT outlines go inside-out: those deepest within others come first, so that nothing is
    cut in a piece that is free already, and the outermost are freed last; so HOLE outlines that a
    piece lies in come with them, as CUT. Segments and chains may be reversed;
    outlines may start at any of their vertices. From where the head comes from, the travel of each
    group is no longer than in the order given, or by nearest neighbours alone.

    >>> dashes = np.array([[[9.0, 0.0], [6.0, 0.0]], [[1.0, 0.0], [4.0, 0.0]]])
    >>> layer = Layer(Operation.VALLEY, dashes)
    >>> tour(CutPaths((layer,), (10.0, 10.0))).layers[0].segments[..., 0].tolist()
    [[1.0, 4.0], [6.0, 9.0]]
    """
    head = np.zeros(2)
    layers = []
    ordered = occupied_holes_last(paths.layers)
    for layer in sorted(ordered, key=lambda layer: list(Operation).index(layer.operation)):
        segments = _segments_tour(layer.segments, head)
        head = segments[-1, 1] if len(segments) else head
        chains = _chains_tour(layer.chains, head)
        head = chains[-1][-1] if chains else head
        outlines: list[FloatArray] = []
        for group in _groups(layer):
            outlines += _outlines_tour(group, head)
            head = outlines[-1][0]
        layers.append(replace(layer, segments=segments, chains=chains, outlines=tuple(outlines)))
    return replace(paths, layers=tuple(layers))


def occupied_holes_last(layers: tuple[Layer, ...]) -> tuple[Layer, ...]:
    """Layers whose HOLE outlines with a CUT outline in them are on that of CUT."""
    of = {layer.operation: layer for layer in layers}
    if not {Operation.HOLE, Operation.CUT} <= set(of):
        return layers
    hole, cut = of[Operation.HOLE], of[Operation.CUT]
    lines = [*cut.outlines, *cut.chains, *cut.segments]
    if not lines or not hole.outlines:
        return layers
    shapes = np.array([shapely.Polygon(ring) for ring in hole.outlines])
    points = shapely.points(np.array([line[0] for line in lines]))
    around = set(shapely.STRtree(points).query(shapes, predicate="contains_properly")[0].tolist())
    if not around:
        return layers
    free = tuple(ring for i, ring in enumerate(hole.outlines) if i not in around)
    full = tuple(ring for i, ring in enumerate(hole.outlines) if i in around)
    of[Operation.HOLE] = replace(hole, outlines=free)
    of[Operation.CUT] = replace(cut, outlines=(*cut.outlines, *full))
    kept = (of[layer.operation] for layer in layers)
    return tuple(layer for layer in kept if layer.operation is not Operation.HOLE or free)


def _groups(layer: Layer) -> Iterator[list[FloatArray]]:
    """Outlines that may be cut in any order; CUT outlines by depth, the deepest first."""
    outlines = layer.outlines
    if not outlines:
        return
    if layer.operation is not Operation.CUT:
        yield list(outlines)
        return
    depth = _depths(outlines)
    for level in range(depth.max(), -1, -1):
        yield [outlines[i] for i in np.flatnonzero(depth == level)]


def _depths(outlines: tuple[FloatArray, ...]) -> IntArray:
    """How many other outlines each one is within, shape (n,)."""
    shapes = np.array([shapely.Polygon(outline) for outline in outlines])
    area = shapely.area(shapes)
    # outlines do not cross: a point of the smaller one decides, and touching does no harm
    points = shapely.point_on_surface(shapes)
    inside, around = shapely.STRtree(shapes).query(points, predicate="intersects")
    return np.bincount(inside[area[inside] < area[around]], minlength=len(outlines))


def _segments_tour(segments: FloatArray, head: FloatArray) -> FloatArray:
    """The segments in order and direction, shape (n, 2, 2)."""
    if not len(segments):
        return segments
    return _directed(segments.reshape(-1, 2), _entries(segments, head))


def _chains_tour(chains: tuple[FloatArray, ...], head: FloatArray) -> tuple[FloatArray, ...]:
    """The chains in order and direction."""
    if not chains:
        return ()
    entries = _entries(np.stack([chain[[0, -1]] for chain in chains]), head)
    return tuple(chains[end // 2][:: -1 if end % 2 else 1] for end in entries.tolist())


def _entries(segments: FloatArray, head: FloatArray) -> IntArray:
    """The end at which each line is entered, in their order: 2 i of line i, or 2 i + 1, (n,)."""
    ends = segments.reshape(-1, 2)
    number = np.arange(len(ends))
    entries = nearest_neighbours(ends, number // 2, number ^ 1, head)
    if travel_mm(segments, head) <= travel_mm(_directed(ends, entries), head):
        entries = number[::2]
    return Tour(ends, entries, head).improved()


def _directed(ends: FloatArray, entries: IntArray) -> FloatArray:
    """Segments from the end at which each is entered to its other end."""
    return np.stack([ends[entries], ends[entries ^ 1]], axis=1)


def _outlines_tour(outlines: list[FloatArray], head: FloatArray) -> list[FloatArray]:
    """The outlines in order, each from the vertex where its cut starts and ends."""
    vertices = np.concatenate(outlines)
    sizes = [len(outline) for outline in outlines]
    first = np.cumsum([0, *sizes[:-1]])
    owner = np.repeat(np.arange(len(outlines)), sizes)
    start = nearest_neighbours(vertices, owner, np.arange(len(vertices)), head)
    if travel_mm(_points(vertices[first]), head) <= travel_mm(_points(vertices[start]), head):
        start = first
    for _ in range(_ROUNDS):
        # an outline is a line that ends where it starts
        lines = vertices[start].repeat(2, axis=0)
        start = start[Tour(lines, 2 * np.arange(len(start)), head).improved() // 2]
        order = owner[start]
        better = first[order] + _best_starts(outlines, order, start - first[order], head)
        if np.array_equal(better, start):
            break
        start = better
    return [
        np.roll(outlines[number], first[number] - at, axis=0)
        for number, at in zip(owner[start].tolist(), start.tolist(), strict=True)
    ]


def _points(starts: FloatArray) -> FloatArray:
    """Lines without length, shape (n, 2, 2): outlines end where they start."""
    return starts[:, None].repeat(2, 1)


def _best_starts(
    outlines: list[FloatArray], order: IntArray, chosen: IntArray, head: FloatArray
) -> IntArray:
    """For each outline in turn the vertex of the shortest detour between its neighbours."""
    chosen = chosen.copy()
    before = head
    for i, number in enumerate(order.tolist()):
        corner = outlines[number]
        detour = np.hypot(*(corner - before).T)
        if i + 1 < len(order):
            following = outlines[order[i + 1]][chosen[i + 1]]
            detour += np.hypot(*(corner - following).T)
        if detour.min() < detour[chosen[i]] - GAIN_MM:
            chosen[i] = np.argmin(detour)
        before = corner[chosen[i]]
    return chosen
