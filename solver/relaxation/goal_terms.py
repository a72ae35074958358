"""Soft terms of makers' goals: least sector angles, room for circles or panels, alike panels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.goals import PanelRoom
from solver.hinge_angles import hinge_angles, hinge_gradients
from solver.incircles import incircles
from solver.panel_shapes import PanelShapes, shape_sides
from solver.quad_hinges import side_hinges
from solver.relaxation.terms import Linear, squares
from solver.vectors import FloatArray, IntArray, cross, dot, norm

__all__ = ["AlikePanels", "LeastRooms", "LeastSectors"]

# Angles by whose difference the slope of a setback is taken, radians.
_APART = 1e-5


@dataclass(frozen=True)
class LeastSectors:
    """Sector angles less the least ones where that is negative, radians; else 0.

    Sectors of corners that have gone through the opposite diagonal are negative.

    Attributes
    ----------
    vertices : of each sector, shape (n, 4): its corner and the others of its face counterclockwise.
    least : smallest angle, radians.

    >>> sector = LeastSectors(np.array([[0, 1, 2, 3]]), np.pi / 2)
    >>> quad = np.array([[0.0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 1, 0]])
    >>> float(np.degrees(sector.linearised(quad).values[0]).round(9))
    -45.0
    """

    vertices: IntArray
    least: float

    @classmethod
    def of(cls, faces_vertices: IntArray, least: float) -> LeastSectors:
        """That of all corners of faces (nf, 4)."""
        turned = [np.roll(faces_vertices, -k, axis=1) for k in range(4)]
        return cls(np.stack(turned, axis=1).reshape(-1, 4), least)

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        corner, after, opposite, before = (coords[self.vertices[:, k]] for k in range(4))
        a, b = after - corner, before - corner
        normal = cross(a, b)
        height = norm(normal)
        sign = np.where(dot(normal, cross(opposite - corner, b - a)) < 0, -1.0, 1.0)
        angle = np.arctan2(sign * height, dot(a, b))
        angle = np.where(angle < -np.pi / 2, angle + 2 * np.pi, angle)
        near = angle < self.least
        with np.errstate(invalid="ignore", divide="ignore"):
            normal = np.where(near[:, None], (sign / height)[:, None] * normal, 0.0)
        by_a = -cross(normal, a) / dot(a, a)[:, None]
        by_b = cross(normal, b) / dot(b, b)[:, None]
        slopes = np.stack([-by_a - by_b, by_a, np.zeros_like(by_a), by_b], axis=1)
        return Linear(np.where(near, angle - self.least, 0.0), slopes, self)


@dataclass(frozen=True)
class LeastRooms:
    """Radii of the widest circles in faces less the least one where that is negative; else 0.

    Of circles behind setbacks that grow with fold angles, at several heights. In steps.

    Attributes
    ----------
    vertices : shape (n, 8): corners of a face, and of the face beyond each side a corner, or -1.
    hinges : shape (m, 4), see `hinge_angles`. beside : that of each side, shape (n, 4), or -1.
    slots : where the vertices of that hinge are among the eight, shape (n, 4, 4).
    height : the height that each residual is of, shape (n,).
    room : the circles and setbacks. step : unit of the residuals.
    """

    vertices: IntArray
    hinges: IntArray
    beside: IntArray
    slots: IntArray
    height: IntArray
    room: PanelRoom
    step: float

    @classmethod
    def of(cls, faces_vertices: IntArray, count: int, room: PanelRoom, step: float) -> LeastRooms:
        """That of all faces (nf, 4) of a sheet with `count` vertices."""
        hinges, beside = side_hinges(faces_vertices, count)
        own = hinges[beside]  # (nf, 4, 4)
        known = (own[:, :, 2:, None] == faces_vertices[:, None, None]).any(axis=3)
        far = np.where(known[:, :, 0], own[:, :, 3], own[:, :, 2])
        vertices = np.concatenate([faces_vertices, np.where(beside >= 0, far, -1)], axis=1)
        slots = (own[:, :, :, None] == vertices[:, None, None]).argmax(axis=3)
        heights, faces = len(room.at(np.zeros(1))), len(faces_vertices)
        return cls(
            np.tile(vertices, (heights, 1)),
            hinges,
            np.tile(beside, (heights, 1)),
            np.tile(slots, (heights, 1, 1)),
            np.repeat(np.arange(heights), faces),
            room,
            step,
        )

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        angles = np.append(hinge_angles(coords, self.hinges), np.nan)[self.beside]
        back, rise = self._setbacks(angles)
        found = incircles(coords[self.vertices[:, :4]], back)
        short = (found.radii - self.room.radius) / self.step
        gradients = np.zeros((*self.vertices.shape, 3))
        gradients[:, :4] = found.gradients
        turn = np.zeros((*self.beside.shape, 4, 3))
        there = self.beside >= 0
        turn[there] = hinge_gradients(coords, self.hinges)[self.beside[there]]
        turn *= -(found.weights * rise)[:, :, None, None]
        rows = np.arange(len(gradients))[:, None]
        for k in range(4):  # the vertices of one hinge are distinct
            gradients[rows, self.slots[:, k]] += turn[:, k]
        near = short < 0
        gradients *= near[:, None, None] / self.step
        return Linear(np.where(near, short, 0.0), gradients, self)

    def _setbacks(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Setbacks at each residual's height, and their slopes, both of the shape of `angles`."""
        rows = np.arange(len(angles))

        def at(turned: FloatArray) -> FloatArray:
            every = self.room.at(turned.ravel()).reshape(-1, *turned.shape)
            out: FloatArray = every[self.height, rows]
            return out

        return at(angles), (at(angles + _APART) - at(angles - _APART)) / (2 * _APART)


@dataclass(frozen=True)
class AlikePanels:
    """By how much sides and diagonals differ from those of the nearest template beyond what they
    may, in steps; else 0.

    Templates follow their panels from round to round, as the means of k-means clusters do, wherever
    that lowers the sum of squares. S. P. Lloyd, "Least squares quantization in PCM", IEEE
    Transactions on Information Theory 28 (1982).

    Attributes
    ----------
    vertices : ends of the `shape_sides` of all faces in turn, shape (8 nf, 2).
    shapes : templates of quads. within : by how much panels may differ from them.
    step : unit of the residuals.

    >>> square = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    >>> larger = PanelShapes(1.25 * np.array([[2.0] * 4 + [8**0.5] * 4]))
    >>> term = AlikePanels.of(np.array([[0, 1, 2, 3]]), larger, within=0.3, step=1.0)
    >>> float(term.linearised(square).values[0])  # the template goes to its panel
    0.0
    """

    vertices: IntArray
    shapes: PanelShapes
    within: float
    step: float

    @classmethod
    def of(
        cls, faces_vertices: IntArray, shapes: PanelShapes, within: float, step: float
    ) -> AlikePanels:
        """That of all faces (nf, 4)."""
        return cls(faces_vertices[:, shape_sides(4)].reshape(-1, 2), shapes, within, step)

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        side = coords[self.vertices[:, 1]] - coords[self.vertices[:, 0]]
        size = norm(side)
        lengths = size.reshape(-1, self.shapes.templates.shape[1])
        shapes, beyond = self.shapes, self._beyond(lengths, self.shapes)
        moved = shapes.centred(lengths)
        nearer = self._beyond(lengths, moved)
        if squares(nearer) < squares(beyond):
            shapes, beyond = moved, nearer
        values = beyond.ravel() / self.step
        slope = side * ((values != 0) / (size * self.step))[:, None]
        return Linear(values, np.stack([-slope, slope], axis=1), replace(self, shapes=shapes))

    def _beyond(self, lengths: FloatArray, shapes: PanelShapes) -> FloatArray:
        differ = lengths - shapes.laid(lengths)
        return np.sign(differ) * np.maximum(np.abs(differ) - self.within, 0.0)
