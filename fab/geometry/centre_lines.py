"""Centre lines of narrow plane regions: their medial axis, from one end to the other.

The axis is made of the borders between the Voronoi cells of many points on the outline. Of these
count the ones between points far from each other along the outline: the others lead into corners.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import shapely
from scipy.spatial import Voronoi
from shapely.ops import substring

from fab.geometry.boxes import smallest_box
from solver.vectors import FloatArray, IntArray

__all__ = ["centre_lines"]

# Points on an outline are nearer to each other than its mean width by this factor.
_POINTS = 2.0
# A region that would have more of them is so thin that it is taken for one without branches.
_MOST_POINTS = 8_000
# Points along each of the two sides of such a region, more than a width apart.
_SIDE_POINTS = 400
# Lines in corners are between points nearer to each other, along the outline, than this: in mean
# widths, and at most this share of the outline.
_CORNER, _CORNER_REL = 3.0, 0.3
# In mean widths: what an axis is simplified by, and what is made anew at its ends.
_OFF, _END = 0.25, 1.0
# Points of an axis that are nearer to each other, in steps along the outline, are one.
_SAME = 1e-6


def centre_lines(region: shapely.Polygon, least: float) -> list[FloatArray]:
    """The lines in the middle of a region, each of shape (k, 2), from border to border.

    Side branches shorter than about `least` are left out; at least one line is not.

    >>> (line,) = centre_lines(shapely.box(0, 0, 9, 0.2), 0.5)
    >>> sorted(line.round(9).tolist())
    [[0.0, 0.1], [9.0, 0.1]]
    """
    width = 2 * region.area / region.length
    step = width / _POINTS
    if region.length > _MOST_POINTS * step:
        return [_to_border(_between_sides(region), (True, True), region, width)]
    corner = min(max(_CORNER * width, 2 * least), _CORNER_REL * region.length)
    points, links = _axis(region, step, corner)
    chains = _chains(links)
    ends, times = np.unique([chain[end] for chain in chains for end in (0, -1)], return_counts=True)
    loose = set(ends[times == 1].tolist())
    lines = [
        _to_border(points[chain], (chain[0] in loose, chain[-1] in loose), region, width)
        for chain in chains
    ]
    return lines or [_longest_chord(region)]


def _axis(region: shapely.Polygon, step: float, corner: float) -> tuple[FloatArray, IntArray]:
    """Points of the axis, shape (n, 2), and the pairs of them that it joins, shape (m, 2).

    step : distance of points on the outline. corner : distance of points along it that are too near
    to each other to be on two sides.
    """
    fine, of = shapely.get_coordinates(
        shapely.segmentize(shapely.get_rings(region), step), return_index=True
    )
    last = np.append(np.diff(of) > 0, True)
    length = np.hypot(*np.diff(fine, axis=0, prepend=fine[:1]).T)
    length[np.append(True, last[:-1])] = 0.0
    along = np.cumsum(length)
    around = np.diff(along[last], prepend=0.0)[of]
    fine, of, along, around = (values[~last] for values in (fine, of, along, around))
    origin = fine.mean(axis=0)
    cells = Voronoi(fine - origin)
    points = cells.vertices + origin
    first, second = cells.ridge_points.T
    apart = np.abs(along[first] - along[second])
    apart = np.minimum(apart, around[first] - apart)
    links = np.asarray(cells.ridge_vertices)
    far = (of[first] != of[second]) | (apart > corner)
    links = links[far & (links >= 0).all(axis=1)]
    shapely.prepare(region)
    inside = shapely.contains_xy(region, points)
    links = links[inside[links].all(axis=1)]
    links = _of_places(points, links, _SAME * step)
    return points, links[links[:, 0] != links[:, 1]]


def _of_places(points: FloatArray, links: IntArray, near: float) -> IntArray:
    """The links with one number for points in one place: around four of a circle there are two."""
    used, number = np.unique(links, return_inverse=True)
    _, first, place = np.unique(
        np.rint(points[used] / near), axis=0, return_index=True, return_inverse=True
    )
    out: IntArray = used[first[place.ravel()]][number].reshape(-1, 2)
    return out


def _chains(links: IntArray) -> list[list[int]]:
    """Joined points from one end or fork to the next; closed ones end where they begin."""
    at = defaultdict(set)
    for a, b in links.tolist():
        at[a].add(b)
        at[b].add(a)
    ends = {point for point, others in at.items() if len(others) != 2}
    chains = []
    for start in [*sorted(ends), *sorted(at.keys() - ends)]:
        while at[start]:
            chain = [start]
            while len(chain) == 1 or (chain[-1] not in ends and chain[-1] != start):
                onward = min(at[chain[-1]])
                at[chain[-1]].remove(onward)
                at[onward].remove(chain[-1])
                chain.append(onward)
            chains.append(chain)
    return chains


def _to_border(
    line: FloatArray, loose: tuple[bool, bool], region: shapely.Polygon, width: float
) -> FloatArray:
    """A line simplified, and its loose ends carried on to the border of the region."""
    whole = shapely.linestrings(line)
    cut = min(_END * width, whole.length / 4)
    start, stop = cut * loose[0], whole.length - cut * loose[1]
    middle = shapely.simplify(substring(whole, start, stop), _OFF * width)
    simple = shapely.get_coordinates(middle)
    for end, inner, is_loose in ((0, 1, loose[0]), (-1, -2, loose[1])):
        if is_loose:
            simple[end] = _on_border(simple[inner], simple[end], region)
    return np.asarray(simple)


def _on_border(inner: FloatArray, end: FloatArray, region: shapely.Polygon) -> FloatArray:
    """Where a line from one point over another first meets the border beyond the latter."""
    span = end - inner
    reach = region.length / float(np.hypot(*span))
    ray = shapely.linestrings(np.stack([end, end + reach * span]))
    met = shapely.get_coordinates(shapely.intersection(ray, region.boundary))
    if not len(met):
        return end
    out: FloatArray = met[np.argmin(np.hypot(*(met - end).T))]
    return out


def _longest_chord(region: shapely.Polygon) -> FloatArray:
    """The middle line of the smallest box around a region, shape (2, 2)."""
    box = smallest_box(region)
    sides = np.hypot(*np.diff(box, axis=0)[:2].T)
    first = 0 if sides[0] <= sides[1] else 1
    return np.array([(box[first + k] + box[(first + k + 1) % 4]) / 2 for k in (0, 2)])


def _between_sides(region: shapely.Polygon) -> FloatArray:
    """The middle between the two sides of a very thin region, which meet in its farthest corners.

    Shape (k, 2).
    """
    ring = shapely.get_coordinates(region.exterior)[:-1]
    first = int(np.argmax(np.hypot(*(ring - ring[0]).T)))
    ring = np.roll(ring, -first, axis=0)
    second = int(np.argmax(np.hypot(*(ring - ring[0]).T)))
    forth, back = ring[: second + 1], np.append(ring[second:], ring[:1], axis=0)[::-1]
    share = np.linspace(0, 1, _SIDE_POINTS)
    for side in (forth, back):  # the corners too, which would be cut off
        along = np.cumsum(np.hypot(*np.diff(side, axis=0, prepend=side[:1]).T))
        share = np.union1d(share, along / along[-1])
    sides = [
        shapely.line_interpolate_point(shapely.linestrings(side), share, normalized=True)
        for side in (forth, back)
    ]
    middles: FloatArray = np.mean([shapely.get_coordinates(side) for side in sides], axis=0)
    return middles[1:-1]  # the ends are corners
