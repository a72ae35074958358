"""The flat-foldable vertex of four creases: its multiplier, and the sector that has a given one.

The creases right, above, left and below leave the sectors A and B above the row, and pi - A and
pi - B below it, since opposite sectors of a vertex that folds flat sum to pi (Kawasaki):

              above
          B     |     A
      left -----+----- right          t = tan(fold angle / 2), valley positive
        pi - A  |  pi - B
              below

It folds in two ways. In both, opposite creases fold by the same amount, and half-angle tangents
keep their ratio through the whole motion (Tachi 2009). Either the two along the row fold alike, the
two across it oppositely and less,

    t_below = t_left cos((A + B)/2) / cos((A - B)/2),

or the two across it fold alike, the two along it oppositely and less,

    t_left = t_below sin((B - A)/2) / sin((A + B)/2).

Every ratio below 1 belongs to exactly one B: with T = tan(B/2),

    T = (1 - m) / (1 + m) / tan(A/2)     and     T = (1 + m) / (1 - m) tan(A/2).
"""

from __future__ import annotations

import math

__all__ = ["left_sector", "multiplier"]


def multiplier(right: float, left: float) -> float:
    """t_below / t_left where creases along the row fold alike; right, left : A and B, radians.

    >>> round(multiplier(math.radians(60), math.radians(60)), 9)  # Miura: cos A
    0.5
    """
    return math.cos((right + left) / 2) / math.cos((right - left) / 2)


def left_sector(right: float, along: float, across: float) -> float:
    """The sector B of a vertex whose creases left and below have given half-angle tangents.

    right : A, radians in (0, pi). along, across : t_left and t_below, not both 0. The result is in
    [0, pi], radians: at its ends, where both tangents are of one size, no vertex is.

    >>> round(math.degrees(left_sector(math.radians(60), 1.0, 0.5)), 9)
    60.0
    >>> round(math.degrees(left_sector(math.radians(70), 1.0, 2.0)), 9)
    129.086494561
    """
    s, c = math.sin(right / 2), math.cos(right / 2)
    if abs(across) < abs(along):
        m = across / along
        return 2 * math.atan2((1 - m) * c, (1 + m) * s)
    m = along / across
    return 2 * math.atan2((1 + m) * s, (1 - m) * c)
