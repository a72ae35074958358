"""Growth on a part of a front, and around the concave corner that this leaves.

     o---L---o           x       the concave corner: three faces, and room for a fourth one
     |   |   |           arms    x q q2 .. L, the left one, and x p p2 .. R, the right one
     o---q2--w'          z       where the creases from p and q meet: a matched corner. The new
     |   |   |                   front has its own corner there, until an arm is used up
     o---q---z---w---o
     |   |   |   |   |           unmatched, both creases end before they meet, at z1 and z2: the
     o---x---p---p2--R           corner's face is the pentagon x p z2 z1 q, and the new front, past
     |   |   |   |   |           w' z1 z2 w, has no corner
     o---o---o---o---o

The strip that makes the first arm ends at x with the crease of a full strip, so that the fourth
sector there, between the edges x p and x q, makes x developable. The fourth face lies in the plane
of these two edges, the corner plane: it fixes the flap angles at p and at q, and with them those
along both arms, outwards. A matched corner gives one length more away: z must be developable in its
turn, so the crease z w' leaves z as (S13) says from z q, z p and z w, in the plane of the face
q q2 w' z, and meets the crease from q2 there. All other lengths are free.

Source: supplementary information of "An additive algorithm for origami design", S1 B.1; the
condition at z is derived here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from numbers import Integral

import numpy as np

from solver.errors import InvalidState, InvalidValue, require_count, require_within
from solver.front import Front, require_convex
from solver.growth import (
    Growth,
    Lengths,
    Status,
    Stop,
    Strip,
    grown_rows,
    length_trouble,
    lengths_along,
)
from solver.mesh import QuadMesh, Side
from solver.rays import Rays, boundary_ray, meeting_distances
from solver.vectors import FloatArray, IntArray, angle_between, dot, norm, unit
from solver.vertex import flap_angle_of

__all__ = ["CornerStrip", "grow_corner", "grow_part", "grow_pentagon"]

# Three faces at a corner leave the fourth its sector up to this, radians.
_FITS = 1e-9
_CURE = "Another flap angle or other lengths in the strips before may help."


@dataclass(frozen=True)
class CornerStrip:
    """The free choices of a strip around a corner; its flap angles are the corner's.

    Attributes
    ----------
    lengths : of the new creases, from the far end of the left arm past the corner to that of the
        right arm: one for all, one each, or a function of the `Rays`. Where a matched corner fixes
        a length, the one given is not used: those of p and q, and of q2 where both arms have two
        edges or more.
    boundary_angles : design angles at the far ends of the left and of the right arm, radians in
        (0, pi); None: parallel to the neighbouring crease.
    """

    lengths: Lengths
    boundary_angles: tuple[float | None, float | None] = (None, None)


def grow_part(
    mesh: QuadMesh,
    strips: int,
    choose: Callable[[Front, int], Strip | Stop],
    *,
    part: tuple[int, int],
    side: Side = Side.TOP,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """Grow `strips` strips on the front vertices `part[0]` to `part[1]` of one side of a patch.

    Where the front goes on beyond an end of the part, that end becomes a concave corner: the first
    strip's crease there is that of a full strip, and has no boundary angle of its own. The front
    that `choose` is given for the first strip has the next vertex beyond such an end too, so that
    `Strip.at` and the front's angles count from there; lengths are those of the part alone.
    See `solver.growth.grow` for the rest.

    Raises `InvalidValue` for a closed patch or a curve, and for a part that is not on the front.
    """
    require_count("strips", strips, 1, "Ask for one strip or more.")
    front, behind = _require_part(mesh, side, part, strips)
    first, last = part
    beyond = (
        int(first > 0 and front[first - 1] >= 0),
        int(last + 1 < len(front) and front[last + 1] >= 0),
    )
    wide = slice(first - beyond[0], last + 1 + beyond[1])
    x, y = mesh.vertices_coords[front[wide]], mesh.vertices_coords[behind[wide]]
    require_convex(x, y)

    def choose_part(around: Front, strip: int) -> Strip | Stop:
        choice = choose(around, strip)
        if strip == 0 and isinstance(choice, Strip):
            _require_free_ends(choice, beyond)
        return choice

    rows, stop = grown_rows(Front.between(x, y), strips, choose_part, progress, beyond)
    return _growth(mesh.extended(side, rows, first), len(rows), stop)


def _require_part(
    mesh: QuadMesh, side: Side, part: tuple[int, int], strips: int
) -> tuple[IntArray, IntArray]:
    """Vertices of a side's front and of the row behind it; refuses parts that cannot grow."""
    front, behind = mesh.front_vertices(side), mesh.previous_vertices(side)
    if not (
        isinstance(part, tuple) and len(part) == 2 and all(isinstance(i, Integral) for i in part)
    ):
        raise InvalidValue("part", part, "be two whole numbers", "Number the front's vertices.")
    first, last = part
    if mesh.closed or behind is None:
        what = "a closed patch has no ends" if mesh.closed else "a curve has no faces"
        raise InvalidState(
            "mesh", f"{what}, so no strip grows on a part of it", "Grow a full strip first."
        )
    if not 0 <= first < last < len(front) or front[first : last + 1].min() < 0:
        raise InvalidValue(
            "part",
            part,
            f"name two vertices of the front, 0 to {len(front) - 1}, with none missing between",
            "Give the numbers of its first and last vertex, from left to right.",
        )
    if last - first < 2 and strips > 1:
        raise InvalidValue(
            "part",
            part,
            "have 3 vertices or more where more than one strip is grown",
            "On a part of one quad a second strip has no interior crease.",
        )
    return front, behind


def _require_free_ends(strip: Strip, beyond: tuple[int, int]) -> None:
    """Refuse boundary angles at ends of a part where the front goes on."""
    for end, given, inside in zip(("left", "right"), strip.boundary_angles, beyond, strict=True):
        if given is not None and inside:
            raise InvalidValue(
                f"boundary angle ({end})",
                given,
                "be left out where the front goes on",
                "The crease at a concave corner is that of a full strip.",
            )


def grow_corner(
    mesh: QuadMesh,
    strips: int,
    choose: Callable[[int], CornerStrip | Stop],
    *,
    side: Side = Side.TOP,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """Grow `strips` matched strips around the concave corner at the right end of a side.

    The hole in the grid there, h rows and w columns, is filled by min(h, w) strips.

    Parameters
    ----------
    choose : called with the strip's number, returns its free choices, or that growth stops here.
    progress : called after each strip with the number of strips grown and wanted.

    A length out of bounds in the first strip raises `InvalidValue`, as do meshes without such a
    corner. Creases that cannot match, arms that cannot fold, faces that cross those behind them,
    and lengths out of bounds in later strips end growth with a status.
    """
    require_count("strips", strips, 1, "Ask for one strip or more.")
    height, width = _hole(mesh.turned(side))
    if not 1 <= strips <= min(height, width):
        raise InvalidValue(
            "strips",
            strips,
            f"be from 1 to {min(height, width)}",
            f"The corner's hole of {height} x {width} quads is full then.",
        )
    _Corner.of(mesh, side).require_room(mesh.vertices_coords)
    for j in range(strips):
        corner = _Corner.of(mesh, side)
        choice = choose(j)
        if isinstance(choice, Stop):
            return _growth(mesh, j, choice)
        _require_strip(choice)
        row = _matched_row(mesh.vertices_coords, corner, choice, j)
        if isinstance(row, Stop):
            advice = f"Strip {j + 1} of {strips}: {row.advice} {_CURE}"
            return _growth(mesh, j, Stop(row.status, advice))
        mesh = _with_matched(mesh, side, row)
        if progress is not None:
            progress(j + 1, strips)
    return Growth(mesh, strips)


def grow_pentagon(mesh: QuadMesh, strip: CornerStrip, *, side: Side = Side.TOP) -> Growth:
    """Grow one strip around the corner at the right end of a side and leave a pentagon there.

    All lengths are free below their bounds. The new mesh's grid holds the row on which the strip
    was grown, from the far end of the left arm to that of the right arm, and the new row: `grow`
    goes on at its top, left and right; other parts of the patch are no longer in the grid.

    Raises `InvalidValue` as `grow_corner` does for its first strip.
    """
    _require_strip(strip)
    corner = _Corner.of(mesh, side)
    corner.require_room(mesh.vertices_coords)
    made = _corner_rays(mesh.vertices_coords, corner, strip)
    if isinstance(made, Stop):
        return _growth(mesh, 0, Stop(made.status, f"{made.advice} {_CURE}"))
    rays, _ = made
    lengths = lengths_along(strip.lengths, rays)
    trouble = length_trouble(lengths, rays)
    if trouble is not None:
        i, _, bound = trouble
        raise _bad_length(lengths, i, bound)
    count = len(mesh.vertices_coords)
    behind = np.concatenate([corner.left[::-1], corner.right])
    new = count + np.arange(len(behind))
    q = len(corner.left) - 1
    quads = np.column_stack([behind[:-1], behind[1:], new[1:], new[:-1]])
    five = np.array([[corner.vertex, behind[q + 1], new[q + 1], new[q], behind[q]]])
    return Growth(
        replace(
            mesh,
            vertices_coords=np.concatenate([mesh.vertices_coords, rays.row(lengths)]),
            faces_vertices=np.concatenate([mesh.faces_vertices, np.delete(quads, q, axis=0)]),
            grid=np.stack([behind, new]),
            pentagons=np.concatenate([mesh.pentagons, five]),
        ),
        1,
    )


@dataclass(frozen=True)
class _Corner:
    """Vertex numbers at a concave corner.

    vertex : the corner's own; left, right : of the arms outwards, without it; *_behind : the
    vertices behind the corner and each arm, one more.
    """

    vertex: int
    left: IntArray
    right: IntArray
    left_behind: IntArray
    right_behind: IntArray

    @classmethod
    def of(cls, mesh: QuadMesh, side: Side) -> _Corner:
        turned = mesh.turned(side)
        height, width = _hole(turned)
        r, c = turned.shape[0] - height - 1, turned.shape[1] - width - 1
        return cls(
            int(turned[r, c]),
            turned[r + 1 :, c],
            turned[r, c + 1 :],
            turned[r:, c - 1],
            turned[r - 1, c:],
        )

    def require_room(self, coords: FloatArray) -> None:
        """Refuse a corner whose fourth sector would not make it developable."""
        ring = [self.right[0], self.left[0], self.left_behind[0], self.right_behind[0]]
        spokes = coords[ring] - coords[self.vertex]
        total = float(angle_between(spokes, np.roll(spokes, -1, axis=0)).sum())
        if not abs(total - 2 * np.pi) <= _FITS:
            raise InvalidValue(
                f"sum of the sector angles at vertex {self.vertex}",
                f"{total:.9g} rad",
                "be 2 pi with the sector that the corner leaves",
                "Make the corner by `grow_part`.",
            )


def _require_strip(choice: object) -> None:
    if not isinstance(choice, CornerStrip):
        raise InvalidValue(
            "strip around a corner", repr(choice), "be a CornerStrip", "Its flap angles are fixed."
        )


def _hole(turned: IntArray) -> tuple[int, int]:
    """Rows and columns of the hole at the upper right of a grid."""
    hole = turned < 0
    height = int(np.argmin(np.append(hole[::-1, -1], False)))
    width = int(np.argmin(np.append(hole[-1, ::-1], False)))
    r, c = turned.shape[0] - height - 1, turned.shape[1] - width - 1
    whole = height > 0 and width > 0 and r > 0 and c > 0 and hole[r + 1 :, c + 1 :].all()
    if not whole or hole[r - 1 : r + 1, c - 1 :].any() or hole[r - 1 :, c - 1 : c + 1].any():
        raise InvalidState(
            "mesh",
            "the mesh has no concave corner at the right end of this side, which is a rectangular "
            "hole in its grid with faces along both arms",
            "Make the corner by `grow_part`, or name another side.",
        )
    return height, width


def _growth(mesh: QuadMesh, strips: int, stop: Stop | None) -> Growth:
    if stop is None:
        return Growth(mesh, strips)
    return Growth(mesh, strips, stop.status, stop.advice)


def _bad_length(lengths: FloatArray, i: int, bound: str) -> InvalidValue:
    advice = "Lengths are counted from the far end of the left arm to that of the right arm."
    return InvalidValue(f"length[{i}]", lengths[i], bound, advice)


def _with_matched(mesh: QuadMesh, side: Side, row: FloatArray) -> QuadMesh:
    """The mesh with `row` around its corner, from the left arm's far end to the right one's."""
    turned = mesh.turned(side).copy()
    height, width = _hole(turned)
    new = len(mesh.vertices_coords) + np.arange(len(row))
    turned[-height:, -width] = new[:height][::-1]
    turned[-height, -width:] = new[height - 1 :]
    return mesh.filled(side, turned, row)


def _matched_row(
    coords: FloatArray, corner: _Corner, choice: CornerStrip, strip: int
) -> FloatArray | Stop:
    """The new row, one vertex for both p and q, shape (h + w - 1, 3)."""
    made = _corner_rays(coords, corner, choice)
    if isinstance(made, Stop):
        return made
    rays, arm_bounds = made
    q, p = len(corner.left) - 1, len(corner.left)
    x, r = rays.vertices_coords, rays.directions
    meeting = _meeting(coords[corner.vertex], x[[q, p]], r[[q, p]])
    if meeting is None or not np.isfinite(meeting).all():
        return Stop(
            Status.CORNER_NOT_MATCHED,
            "the creases from the corner's neighbours do not meet. Leave a pentagon.",
        )
    lengths = lengths_along(choice.lengths, rays).copy()
    again = min(len(corner.left), len(corner.right)) > 1  # z is a corner in its turn
    fixed = [q - 1, q, p] if again else [q, p]
    lengths[fixed] = np.minimum(1.0, arm_bounds[fixed]) / 2  # until they are known
    trouble = length_trouble(lengths, replace(rays, length_bounds=arm_bounds))
    if trouble is not None:
        i, status, bound = trouble
        if strip == 0:
            raise _bad_length(lengths, i, bound)
        return Stop(status, f"at new crease {i} the length must {bound}.")
    lengths[[q, p]] = meeting
    row = rays.row(lengths)
    z = row[[q, p]].mean(axis=0)
    if again:
        length = _matching_length(x[q - 1 : p + 1], z, r[q - 1], row[p + 1])
        if isinstance(length, Stop):
            return length
        lengths[q - 1] = length
    for i in fixed:
        if lengths[i] >= arm_bounds[i]:
            return Stop(
                Status.CORNER_NOT_MATCHED,
                f"the corner fixes the length of new crease {i} to {lengths[i]:.9g}, beyond "
                f"{arm_bounds[i]:.9g}, where it meets its neighbour. Leave a pentagon, or choose "
                "other lengths beside it.",
            )
    row = rays.row(lengths)
    row[q] = z
    return np.delete(row, p, axis=0)


def _matching_length(
    arms: FloatArray, z: FloatArray, direction: FloatArray, w: FloatArray
) -> float | Stop:
    """Length of the crease from q2 with which the matched corner z is developable.

    arms : q2, q and p, shape (3, 3); direction : of the crease from q2; w : new vertex at p2.
    """
    q2, q, p = arms
    # three creases that are not in one plane always leave room for the fourth
    front = Front.between(np.stack([q, z, w]), np.stack([q, p, w]))
    a, b = -front.edges_direction[:1], front.edges_direction[1:]
    rays = front.rays(float(flap_angle_of(a, b, (q2 - q)[None])[0]))
    if front.self_intersections(rays.flap_angles[:, None]).any():
        return Stop(Status.FACES_CROSS, "new faces would cross at the matched corner.")
    meeting = _meeting(q, np.stack([z, q2]), np.stack([rays.directions[1], direction]))
    if meeting is None or not np.isfinite(meeting).all():
        return Stop(
            Status.CORNER_NOT_MATCHED,
            "no length beside the corner makes the matched corner developable. Leave a pentagon, "
            "or choose another length on the other arm.",
        )
    return float(meeting[1])


def _corner_rays(
    coords: FloatArray, corner: _Corner, choice: CornerStrip
) -> tuple[Rays, FloatArray] | Stop:
    """Rays of a strip around a corner, from the left arm's far end to the right one's.

    Returns also the length bounds that the arms set, without that of the corner's face. Flap angles
    are those that the arms have when they are passed from the corner outwards.
    """
    x = coords[corner.vertex]
    spokes = unit(coords[[corner.left[0], corner.right[0]]] - x)
    arms = []
    for which, numbers, behind, across, angle in (
        ("left", corner.left, corner.left_behind, spokes[1], choice.boundary_angles[0]),
        ("right", corner.right, corner.right_behind, spokes[0], choice.boundary_angles[1]),
    ):
        line = np.concatenate([x[None], coords[numbers]])
        arm = _arm_rays(which, line, coords[behind], across, angle)
        if isinstance(arm, Stop):
            return arm
        arms.append(arm)
    left, right = arms
    joined = Rays(
        np.concatenate([left.vertices_coords[::-1], right.vertices_coords]),
        np.concatenate([left.directions[::-1], right.directions]),
        (
            np.concatenate([left.half_flaps[0][::-1], right.half_flaps[0]]),
            np.concatenate([left.half_flaps[1][::-1], right.half_flaps[1]]),
        ),
        np.concatenate([left.length_bounds[::-1], right.length_bounds]),
    )
    q, p = len(corner.left) - 1, len(corner.left)
    meeting = _meeting(x, joined.vertices_coords[[q, p]], joined.directions[[q, p]])
    if meeting is None:
        return Stop(
            Status.CORNER_NOT_CONVEX,
            "a crease from the corner's neighbours points back into the corner, whose face would "
            "not be convex.",
        )
    bounds = joined.length_bounds.copy()
    bounds[[q, p]] = np.minimum(bounds[[q, p]], meeting)
    return replace(joined, length_bounds=bounds), joined.length_bounds


def _arm_rays(
    which: str, x: FloatArray, y: FloatArray, across: FloatArray, angle: float | None
) -> Rays | Stop:
    """Rays of an arm's vertices but the corner's; the corner's face lies on the side `across`.

    (S13) does not know left from right, so both arms are fronts that begin at the corner.
    """
    if angle is not None:
        cure = "Leave it out for parallel."
        require_within(f"boundary angle ({which})", angle, 0.0, np.pi, cure, angle=True)
    if len(x) == 2:  # the neighbour is a corner of the patch: its crease stays in the corner plane
        direction = (
            across if angle is None else boundary_ray(unit(x[0] - x[1]), across, angle, which)[0]
        )
        return Rays(x[1:], direction[None], (np.empty(0), np.empty(0)), np.array([np.inf]))
    require_convex(x, y)
    try:
        front = Front.between(x, y)
    except InvalidValue as error:
        return Stop(Status.FRONT_NOT_FOLDABLE, f"the {which} arm has no room to fold: {error}")
    a, b = -front.edges_direction[:1], front.edges_direction[1:2]
    flap_angle = float(flap_angle_of(a, b, across[None])[0])
    rays = front.rays(flap_angle, boundary_angles=(None, angle))
    crossing = front.self_intersections(rays.flap_angles[:, None])[:, 0]
    if crossing.any():
        i = int(np.flatnonzero(crossing)[0]) + 1
        return Stop(
            Status.FACES_CROSS,
            f"new faces would cross those behind the {which} arm, at vertex {i} from the corner.",
        )
    return rays.between(1, len(x))


def _meeting(corner: FloatArray, ends: FloatArray, directions: FloatArray) -> FloatArray | None:
    """Distances from two ends at which their rays meet in the plane of a corner, shape (2,).

    corner : shape (3,); ends, directions : shape (2, 3), coplanar with it. inf where the rays do
    not meet; None where one of them points back over the line through both ends: the face of
    corner, ends and new vertices would not be convex.
    """
    along = unit(ends[1] - ends[0])
    arm = ends[0] - corner
    away = unit(arm - dot(arm, along) * along)
    cosine, sine = directions @ along, directions @ away
    if not sine.min() > 0:
        return None
    length = norm(ends[1:] - ends[:1])
    first, second = (
        (cosine[:1], sine[:1]),
        (-cosine[1:], sine[1:]),
    )
    return np.concatenate(meeting_distances(length, first, second))
