"""One vertex all around the circle of its flap angle: its curve, its folds, its special choices."""

import numpy as np
import pytest

from solver import InvalidValue
from solver.arcs import contain
from solver.vectors import angle_between, cross, dot, unit
from solver.vertex_family import SPECIAL, vertex_family

OLD = [([-1, 0.1, 0.4], [1, 0.2, 0.4], [0, -1, 0]), ([-1, 0.5, 0], [1, 0.4, 0.1], [0.2, -1, 0.6])]


@pytest.fixture(params=OLD, ids=["valley", "mountain"])
def family(request):
    return vertex_family(*request.param, 720)


def at(family, name):
    """The vertex at the flap angles of a special choice."""
    return vertex_family(family.a, family.b, family.c, np.array(family.special[name]))


def test_the_curve_is_a_spherical_ellipse_around_the_old_creases(family):
    theta1 = angle_between(family.a[None], family.directions)
    theta2 = angle_between(family.b[None], family.directions)
    np.testing.assert_allclose(theta1, family.theta1, atol=1e-12)
    np.testing.assert_allclose(theta2, family.theta2, atol=1e-12)
    np.testing.assert_allclose(theta1 + theta2, family.k, atol=1e-12)
    theta3, theta4 = angle_between(family.b, family.c), angle_between(family.a, family.c)
    assert family.k == pytest.approx(2 * np.pi - theta3 - theta4, abs=1e-12)
    # of all sums of arcs to a and b the least is beta, on the arc between them, and below k
    share = np.linspace(0, 1, 101)[:, None]
    between = unit((1 - share) * family.a + share * family.b)
    sums = angle_between(family.a[None], between) + angle_between(family.b[None], between)
    np.testing.assert_allclose(sums, family.beta, atol=1e-12)
    assert family.beta < family.k < 2 * np.pi - family.beta


def test_special_vertices_solve_their_equations(family):
    theta3, theta4 = angle_between(family.b, family.c), angle_between(family.a, family.c)
    assert set(family.special) <= set(SPECIAL)

    straight = at(family, "continuation")
    np.testing.assert_allclose(straight.directions, -family.c[None], atol=1e-12)
    np.testing.assert_allclose(straight.fold_angles[:2], 0, atol=1e-7)

    mirrored = at(family, "reflection")
    normal = unit(cross(family.a, family.b))
    image = -family.c + 2 * dot(family.c, normal) * normal
    np.testing.assert_allclose(mirrored.directions, image[None], atol=1e-12)

    flat = at(family, "flat-foldable")
    assert flat.theta1.size == 2
    np.testing.assert_allclose(flat.theta1 + theta3, np.pi, atol=1e-12)
    np.testing.assert_allclose(flat.theta2 + theta4, np.pi, atol=1e-12)

    even = at(family, "equal angles")
    assert even.theta1.size == 2
    np.testing.assert_allclose(even.theta1, even.theta2, atol=1e-12)

    for name, crease in (("locked left", 0), ("locked right", 1)):
        locked = at(family, name)
        np.testing.assert_allclose(np.abs(locked.fold_angles[crease]), np.pi, atol=1e-7)


def test_forbidden_arcs_end_where_faces_touch(family):
    ends = family.crossing.ravel()
    assert ends.size == 4
    folds = vertex_family(family.a, family.b, family.c, ends).fold_angles
    # two faces lie on each other at a crease that is folded by a half turn
    np.testing.assert_allclose(np.abs(folds).max(axis=0), np.pi, atol=1e-7)


def test_forbidden_flap_angles_are_on_the_side_of_the_old_crease(family):
    inside = contain(family.crossing, family.flap_angles)
    normal = cross(family.a, family.b)
    same = (family.directions @ normal > 0) == (family.c @ normal > 0)
    assert inside.any()
    assert same[inside].all()
    assert not inside[~same].any()


def test_folds_close_around_the_vertex(family):
    """Turning about each crease in turn, by its sector and its fold, comes back to the start."""
    theta3, theta4 = angle_between(family.b, family.c), angle_between(family.a, family.c)
    for n in range(0, 720, 97):
        turn = np.eye(3)
        folds = family.fold_angles[[1, 3, 0, 2], n]  # counterclockwise from b
        for fold, sector in zip(
            folds, (family.theta2[n], family.theta1[n], theta4, theta3), strict=True
        ):
            c, s = np.cos(fold), np.sin(fold)
            turn = turn @ [[1, 0, 0], [0, c, -s], [0, s, c]]
            c, s = np.cos(sector), np.sin(sector)
            turn = turn @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        np.testing.assert_allclose(turn, np.eye(3), atol=1e-10)


def test_creases_without_direction_are_refused():
    with pytest.raises(InvalidValue, match="a = zero"):
        vertex_family([0, 0, 0], [1, 0, 0], [0, -1, 0])
