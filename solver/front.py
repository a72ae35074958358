"""The growth front: its angles and frames, and the rays of new creases for a flap angle.

          z0----z1----z2----z3      new row, grown along the rays r
          | r0  | r1  | r2  | r3
          x0----x1----x2----x3      the front, new growth on the left of its direction
          |     |     |     |
          y0----y1----y2----y3      previous row (or none: then k is chosen, not measured)

Source: supplementary information of "An additive algorithm for origami design", S1 and S2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from numbers import Integral

import numpy as np

from solver.arcs import free_arcs
from solver.errors import InvalidState, InvalidValue, require_number, require_within
from solver.mesh import QuadMesh, Side
from solver.rays import Rays, boundary_ray, length_bounds, loop_bounds
from solver.transfer import (
    Closings,
    half_angles,
    inverse_matrices,
    loop_closings,
    loop_miss,
    transfer_each,
    transfer_matrices,
)
from solver.vectors import (
    SMALLEST,
    BoolArray,
    FloatArray,
    cross,
    dot,
    full_turn,
    norm,
    numbers,
    points,
)
from solver.vertex import flap_angle_of, locked_flap_angles, require_foldable, self_intersects

__all__ = ["Front"]

# A loop that misses itself by less is closed: the rounding is spread over all its quads, radians.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Front:
    """A polyline of m + 1 vertices with the angles that a new strip must use up.

    Arrays are read-only.

    Attributes
    ----------
    vertices_coords : shape (m + 1, 3).
    edges_length, edges_direction : shapes (m,) and (m, 3).
    beta, k, couplings : of the interior vertices, shape (m - 1,).
    normals : of the beta planes, n = unit(a x b), shape (m - 1, 3).
    inner : n x a, in the beta planes on b's side, shape (m - 1, 3).
    deltas : angle between successive beta planes about their common edge, shape (m - 2,).
    sin_beta, rise, run : of the interior vertices: with (S13), theta1 is the angle whose tangent is
        rise / (run + 2 sin_beta sin^2(alpha/2)), shape (m - 1,).
    back : unit directions to the previous row, shape (m - 1, 3); None where the front is a curve.
    closed : the front is a loop; its arrays then run from the last vertex once around to the first,
        so that every vertex of the loop is an interior one.
    """

    vertices_coords: FloatArray
    edges_length: FloatArray
    edges_direction: FloatArray
    beta: FloatArray
    k: FloatArray
    couplings: FloatArray
    normals: FloatArray
    inner: FloatArray
    deltas: FloatArray
    sin_beta: FloatArray
    rise: FloatArray
    run: FloatArray
    back: FloatArray | None = None
    closed: bool = False

    def __post_init__(self) -> None:
        for array in vars(self).values():
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @classmethod
    def between(
        cls, vertices_coords: FloatArray, previous_coords: FloatArray, *, closed: bool = False
    ) -> Front:
        """Front with faces behind it: k = 2 pi - theta3 - theta4 (both arrays (m + 1, 3)).

        closed : whether both rows are loops, their first vertices not repeated. Raises
        `InvalidValue` where beta or k leave their interval.
        """
        x, y = points("front", vertices_coords), points("previous row", previous_coords)
        if x.shape != y.shape:
            raise InvalidValue(
                "previous row",
                f"array of shape {y.shape}",
                f"have the shape of the front, {x.shape}",
                "Give one point behind each front vertex.",
            )
        if closed:
            x, y = _around(x), _around(y)
        length, direction = _edges(x)
        crease = y[1:-1] - x[1:-1]
        size = norm(crease)
        if not size.min() > SMALLEST:
            i = int(np.flatnonzero(~(size > SMALLEST))[0])
            raise InvalidValue(
                f"length of the crease behind front vertex {i + 1}",
                size[i],
                f"be greater than {SMALLEST:g}",
                "Rows must not meet: choose longer creases.",
            )
        back = crease / size[:, None]
        before, after = direction[:-1], direction[1:]
        # angles of unit vectors u, v as 2 atan2(|u - v|, |u + v|); the left one is against `before`
        theta4 = 2 * np.arctan2(norm(before + back), norm(before - back))
        theta3 = 2 * np.arctan2(norm(after - back), norm(after + back))
        return cls._with_k(x, length, direction, 2 * np.pi - theta3 - theta4, back, closed)

    @classmethod
    def on_curve(
        cls, vertices_coords: FloatArray, k: FloatArray | float, *, closed: bool = False
    ) -> Front:
        """Front that is only a curve in space; k_i is free in (beta_i, 2 pi - beta_i).

        k : radians, one for all interior vertices or shape (m - 1,); of a loop all vertices are
        interior. This is the corollary of the paper. Raises `InvalidValue` where beta or k leave
        their interval.

        >>> zigzag = np.array([[0.0, 0, 0], [1, 1, 0], [2, 0, 0], [3, 1, 0]])
        >>> front = Front.on_curve(zigzag, np.radians(200))
        >>> np.degrees(front.beta).round(9).tolist()
        [90.0, 90.0]
        >>> front.rays(np.radians(100)).row(0.5).shape
        (4, 3)
        """
        x = points("front", vertices_coords)
        x = _around(x) if closed else x
        length, direction = _edges(x)
        angles = numbers("k", k)
        if angles.ndim > 1 or (angles.ndim == 1 and len(angles) != len(x) - 2):
            raise InvalidValue(
                "k",
                f"array of shape {angles.shape}",
                f"be a number or have shape ({len(x) - 2},)",
                "Give one value for each interior vertex of the front.",
            )
        spread = np.broadcast_to(angles, len(x) - 2)
        for i in np.flatnonzero(~((spread > 0) & (spread < 2 * np.pi))):
            cure = "Choose k between beta and 2 pi - beta."
            require_within(f"k[{i}]", float(spread[i]), 0.0, 2 * np.pi, cure, angle=True)
        front = cls._with_k(x, length, direction, spread, closed=closed)
        require_foldable(front.beta, front.k)
        return front

    @classmethod
    def of(cls, mesh: QuadMesh, side: Side, k: FloatArray | float | None = None) -> Front:
        """The front on `side` of a patch; `k` where the patch is a curve, and only there."""
        front = mesh.front_vertices(side)
        if front.min() < 0:
            raise InvalidState(
                "side",
                f"the {side} side is not filled from end to end",
                "Fill its corner, or grow on a part of it (`solver.corner`).",
            )
        x = mesh.vertices_coords[front]
        behind = mesh.previous_vertices(side)
        if behind is None:
            if k is None:
                raise InvalidValue(
                    "k", None, "be given for a curve", "Choose k between beta and 2 pi - beta."
                )
            return cls.on_curve(x, k, closed=mesh.closed)
        if k is not None:
            raise InvalidValue(
                "k",
                k,
                "be left out where there are faces behind the front",
                "There k follows from developability.",
            )
        y = mesh.vertices_coords[behind]
        _edges(x)  # too short ones have no convex faces either
        require_convex(x, y)
        return cls.between(x, y, closed=mesh.closed)

    @classmethod
    def _with_k(
        cls,
        x: FloatArray,
        length: FloatArray,
        direction: FloatArray,
        k: FloatArray,
        back: FloatArray | None = None,
        closed: bool = False,
    ) -> Front:
        before, after = direction[:-1], direction[1:]
        across = cross(after, before)  # a x b with a = -before
        sine = norm(across)
        along = dot(before, after)
        beta = np.arctan2(sine, -along)
        half_sum, half_difference = (k + beta) / 2, (k - beta) / 2
        sin_sum, sin_difference = np.sin(half_sum), np.sin(half_difference)
        with np.errstate(divide="ignore", invalid="ignore"):  # angles at their ends: refused below
            couplings = sin_difference / sin_sum  # as `solver.transfer.coupling`
        # cos beta - cos k and sin k - sin beta without cancellation where k nears beta
        rise, run = 2 * sin_sum * sin_difference, 2 * np.cos(half_sum) * sin_difference
        # rounding leaves tiny couplings, or sines, where a bound is met exactly
        if not (couplings.min() > 1e-11 and couplings.max() < 1e11 and sine.min() > 1e-11):
            require_foldable(beta, k)
        normals = across / sine[:, None]
        inner = (after - along[:, None] * before) / sine[:, None]
        sin_delta, cos_delta = -dot(normals[:-1], inner[1:]), dot(normals[:-1], normals[1:])
        deltas = np.arctan2(sin_delta, cos_delta)
        return cls(
            *(x, length, direction, beta, k, couplings, normals, inner, deltas, sine, rise, run),
            back=back,
            closed=closed,
        )

    @cached_property
    def transfer_matrices(self) -> FloatArray:
        """From the first flap angle to each, see `solver.transfer`, shape (m - 1, 2, 2)."""
        return transfer_matrices(self.couplings, self.deltas)

    @property
    def row_coords(self) -> FloatArray:
        """The front's own vertices, one for each of the new row, shape (m + 1, 3) or (N, 3)."""
        return self.vertices_coords[1:-1] if self.closed else self.vertices_coords

    @property
    def closing_delta(self) -> float:
        """Angle between the beta planes of a loop's last and first vertex about their edge."""
        n0, n1 = self.normals[-1], self.normals[0]
        return float(np.arctan2(-(n0 @ self.inner[0]), n0 @ n1))

    def closings(self) -> Closings:
        """The flap angles for which a closed front closes again (`solver.transfer.Closings`).

        Their vertices are counted from 0 there: begin a strip at front vertex number + 1.
        """
        if not self.closed:
            raise InvalidState("front", "the front is open", "Open fronts take any flap angle.")
        continuation = None
        if self.back is not None:
            u = self.edges_direction
            continuation = float(flap_angle_of(-u[:1], u[1:2], -self.back[:1])[0])
        return loop_closings(
            self.couplings, np.append(self.deltas, self.closing_delta), continuation
        )

    def _candidates(self, flap_angles: FloatArray) -> FloatArray:
        angles = numbers("flap_angles", flap_angles)
        if angles.ndim != 2 or len(angles) != len(self.k):
            raise InvalidValue(
                "flap_angles",
                f"array of shape {angles.shape}",
                f"have shape ({len(self.k)}, q)",
                "Give a row for each interior vertex, and a column for each candidate.",
            )
        return angles

    def self_intersections(self, flap_angles: FloatArray) -> BoolArray:
        """Vertices at which new faces would cross the old ones, shape (m - 1, q).

        flap_angles : of every interior vertex for q candidates, shape (m - 1, q).
        """
        flap_angles = self._candidates(flap_angles)
        if self.back is None:
            return np.zeros(flap_angles.shape, bool)
        a, b = -self.edges_direction[:-1], self.edges_direction[1:]
        left, right = locked_flap_angles(a, b, self.back, self.couplings)
        return self_intersects(flap_angles, left[:, None], right[:, None])

    def crossing_flap_angles(self) -> FloatArray:
        """Flap angles at front vertex 1 for which new faces cross old ones, as arcs, (m - 1, 2, 2).

        Two arcs for each interior vertex (S2 B), on the old crease's side of its beta plane: from
        the plane to the first locked flap angle, and from the second one to the plane. Inverse
        matrices carry them to vertex 1 (S4 D). A front that is a curve has none, shape (0, 2, 2).
        """
        if self.back is None:
            return np.empty((0, 2, 2))
        a, b = -self.edges_direction[:-1], self.edges_direction[1:]
        left, right = locked_flap_angles(a, b, self.back, self.couplings)
        base = np.where(left < np.pi, 0.0, np.pi)
        first = np.column_stack([base, np.minimum(left, right)])
        second = np.column_stack([np.maximum(left, right), base + np.pi])
        matrices = inverse_matrices(self.transfer_matrices)
        images = transfer_each(matrices, np.concatenate([first, second], axis=1))
        images = images.reshape(-1, 2, 2)
        turned = np.linalg.det(matrices) < 0  # such a map runs backwards round the circle
        out: FloatArray = np.where(turned[:, None, None], images[:, :, ::-1], images)
        return out

    def free_flap_angles(self) -> FloatArray:
        """Flap angles at front vertex 1 for which no vertex self-intersects, as arcs (k, 2).

        What the union of `crossing_flap_angles` leaves, exactly; see `solver.arcs` for the form of
        arcs.
        """
        return free_arcs(self.crossing_flap_angles().reshape(-1, 2))

    def away_from_back(self, flap_angles: FloatArray) -> BoolArray:
        """Vertices whose new crease and old crease are on different sides of the beta plane.

        There old and new faces can neither cross nor nest. Shapes as in `self_intersections`.
        """
        flap_angles = self._candidates(flap_angles)
        if self.back is None:
            return np.ones(flap_angles.shape, bool)
        above = dot(self.back, self.normals) > 0
        out: BoolArray = (full_turn(flap_angles) < np.pi) != above[:, None]
        return out

    def rays(
        self,
        flap_angle: float,
        *,
        at: int = 1,
        boundary_angles: tuple[float | None, float | None] = (None, None),
    ) -> Rays:
        """Directions of the new creases for one flap angle.

        Parameters
        ----------
        flap_angle : radians, at the front vertex number `at` (1 to m - 1).
        boundary_angles : design angles at the first and last vertex, radians in (0, pi), between
            the front's edge and the new boundary edge; None: parallel to the neighbouring crease.

        Raises `InvalidValue` for a vertex without a flap angle, and for angles out of bounds.
        """
        flap_angle = self._require_flap_angle(flap_angle, at)
        if not (isinstance(boundary_angles, tuple | list) and len(boundary_angles) == 2):
            raise InvalidValue(
                "boundary_angles", boundary_angles, "be a pair", "Give (None, None) for parallel."
            )
        s, c, closing_error = self._half_flaps(flap_angle, at)
        cos_flap, sin_flap = c * c - s * s, 2 * s * c
        run = self.run + 2 * self.sin_beta * s * s
        size = np.hypot(self.rise, run)
        cos1, sin1 = run / size, self.rise / size  # of theta1 (S13)
        a = -self.edges_direction[:-1]
        directions: FloatArray = (
            cos1[:, None] * a
            + (sin1 * cos_flap)[:, None] * self.inner
            + (sin1 * sin_flap)[:, None] * self.normals
        )
        # theta2 = k - theta1: its cosine and sine without another arctangent
        cos_k, sin_k = np.cos(self.k), np.sin(self.k)
        cos2, sin2 = cos_k * cos1 + sin_k * sin1, sin_k * cos1 - cos_k * sin1
        if self.closed:
            bounds = loop_bounds(self.edges_length[1:], (cos2, sin2), (cos1, sin1))
            return Rays(self.row_coords, directions, (s, c), bounds, abs(closing_error))
        directions, bounds = self._boundary(directions, (cos1, sin1), (cos2, sin2), boundary_angles)
        return Rays(self.vertices_coords, directions, (s, c), bounds)

    def _require_flap_angle(self, flap_angle: float, at: int) -> float:
        """The flap angle as a number; refuses one that is none, and vertices without one."""
        last = len(self.vertices_coords) - 1
        if not isinstance(at, Integral) or not 1 <= at <= last - 1:
            raise InvalidValue(
                "at", at, f"be an interior vertex, 1 to {last - 1}", "Ends have no flap angle."
            )
        require_number("flap_angle", flap_angle)
        flap_angle = float(flap_angle)
        if not np.isfinite(flap_angle):
            raise InvalidValue("flap_angle", flap_angle, "be finite", "Give an angle in radians.")
        return flap_angle

    def _half_flaps(self, flap_angle: float, at: int) -> tuple[FloatArray, FloatArray, float]:
        """Sines and cosines of half the flap angles, and by how much a loop misses its first.

        Where a loop closes but for rounding, this is spread over all its vertices.
        """
        s, c = half_angles(self.couplings, self.deltas, flap_angle, at - 1)
        closing_error = 0.0
        if self.closed:
            closing_error, spread = loop_miss(self.couplings, self.closing_delta, s, c)
            if abs(closing_error) < _ROUNDING:
                s, c = half_angles(self.couplings, self.deltas + spread, flap_angle, at - 1)
        return s, c, closing_error

    def _boundary(
        self,
        inner: FloatArray,
        theta1: tuple[FloatArray, FloatArray],
        theta2: tuple[FloatArray, FloatArray],
        angles: tuple[float | None, float | None],
    ) -> tuple[FloatArray, FloatArray]:
        """Directions of all creases of an open front, boundary edges included, and length bounds.

        inner : directions at the interior vertices; theta1, theta2 : cosines and sines of the
        design angles there.
        """
        (cos1, sin1), (cos2, sin2) = theta1, theta2
        directions = np.concatenate([inner[:1], inner, inner[-1:]])
        # per edge: angle on its left end (towards the next vertex) and on its right end
        left = np.empty((2, len(self.edges_length)))
        right = np.empty_like(left)
        left[:, 1:] = cos2, sin2
        right[:, :-1] = cos1, sin1
        left[:, 0] = -cos1[0], sin1[0]
        right[:, -1] = -cos2[-1], sin2[-1]
        angle_left, angle_right = angles
        if angle_left is not None:
            edge = self.edges_direction[0]
            directions[0], left[:, 0] = boundary_ray(edge, inner[0], angle_left, "left")
        if angle_right is not None:
            edge = -self.edges_direction[-1]
            directions[-1], right[:, -1] = boundary_ray(edge, inner[-1], angle_right, "right")
        return directions, length_bounds(self.edges_length, left, right)


def require_convex(x: FloatArray, y: FloatArray) -> None:
    """Refuse faces behind a front that are reflex at it; grown faces never are."""
    edge, left, right = x[1:] - x[:-1], y[:-1] - x[:-1], y[1:] - x[1:]
    normal = cross(x[1:] - y[:-1], x[:-1] - y[1:])
    reflex = (dot(cross(left, edge), normal) <= 0) | (dot(cross(right, edge), normal) <= 0)
    if reflex.any():
        i = int(np.flatnonzero(reflex)[0])
        raise InvalidState(
            "mesh",
            f"the face behind front edge {i} is reflex at the front",
            "Grow from faces whose angles are below 180 degrees there, or on another side.",
        )


def _edges(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    if len(x) < 3:
        raise InvalidValue(
            "front", f"array of shape {x.shape}", "have shape (m + 1, 3), m >= 2", "Add vertices."
        )
    edge = x[1:] - x[:-1]
    length = norm(edge)
    if not length.min() > SMALLEST:
        i = int(np.flatnonzero(~(length > SMALLEST))[0])
        raise InvalidValue(
            f"length of front edge {i}",
            length[i],
            f"be greater than {SMALLEST:g}",
            "Remove duplicate vertices from the front.",
        )
    return length, edge / length[:, None]


def _around(row: FloatArray) -> FloatArray:
    """A loop as an open polyline that passes its last vertex first, and its first one last."""
    return np.concatenate([row[-1:], row, row[:1]])
