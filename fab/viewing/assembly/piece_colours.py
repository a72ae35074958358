"""Colours of pieces: apart from each other in hue, and in lightness where they are printed grey."""

from __future__ import annotations

import numpy as np

from solver.vectors import FloatArray

__all__ = ["hex_colour", "paler", "piece_colours"]

# A piece alone has the colour of the upper side of a sheet.
_ALONE = (0.96, 0.84, 0.62)
# Turns between the hues of pieces that follow each other, and their lightness, in turn.
_GOLDEN, _LIGHTNESS, _CHROMA = 0.381966, (0.90, 0.76, 0.84, 0.70), 0.10
_FIRST_HUE = 0.23
# From Oklab to the cubic roots of cone responses, and from these to linear red, green and blue.
# Bjorn Ottosson 2020, A perceptual color space for image processing.
_ROOTS = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_LINEAR = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def piece_colours(count: int) -> FloatArray:
    """Light colours for black letters, from 0 to 1, shape (count, 3); the same for each number.

    >>> colours = piece_colours(30)
    >>> bool((colours[:12] == piece_colours(12)).all() and len(np.unique(colours, axis=0)) == 30)
    True
    """
    if count == 1:
        return np.array([_ALONE])
    number = np.arange(count)
    hue = 2 * np.pi * ((_FIRST_HUE + _GOLDEN * number) % 1.0)
    lightness = np.array(_LIGHTNESS)[number % len(_LIGHTNESS)]
    lab = np.column_stack([lightness, _CHROMA * np.cos(hue), _CHROMA * np.sin(hue)])
    linear = np.clip((lab @ _ROOTS.T) ** 3 @ _LINEAR.T, 0.0, 1.0)
    curved = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.asarray(curved.round(3))


def paler(colours: FloatArray, share: float) -> FloatArray:
    """Colours with a share of white."""
    return np.asarray(colours + (1.0 - colours) * share)


def hex_colour(colour: FloatArray) -> str:
    """Such as "#f5d69e".

    >>> hex_colour(np.array([1.0, 0.5, 0.0]))
    '#ff8000'
    """
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour.tolist())
