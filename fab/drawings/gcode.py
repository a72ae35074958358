"""G-code of cut paths for lasers with GRBL, and a run around all that is cut, without power.

The dialect is that of GRBL 1.1 in laser mode ($32=1), as its wiki has it ("Grbl v1.1 Laser Mode"):
`G21 G90 G94`, millimetres, absolute, feed a minute; `M4`, power that follows the speed of the
head, so that corners and the ends of dashes are not burnt; `G0` moves with the laser off, `G1`
with power `S` and feed `F` in mm/min; `M5` off, `M2` end. `S` at full power is `$30`.

The origin is the front left corner of the bed: set the work zero there. Moves also have `S0` where
the laser is off, for machines that are not in laser mode. Comments hold no text of the user's:
GRBL obeys some characters wherever they are.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import numpy as np

from fab.drawings.cut_paths import CutPaths, Operation, polylines
from fab.drawings.cut_settings import CutSetting
from solver.errors import InvalidState

__all__ = ["frame_bytes", "gcode_bytes"]

_SECONDS_A_MINUTE = 60
_HEAD = "G21\nG90\nG94\nM4 S0\n"
_TAIL = "M5\nG0 X0 Y0 S0\nM2\n"


def gcode_bytes(paths: CutPaths, settings: Mapping[Operation, CutSetting], s_max: float) -> bytes:
    """The program, the same bytes for the same paths, in the order of the layers and their lines.

    settings : speed and power of each operation that occurs; s_max : S at full power.

    Raises `InvalidState` for an operation without power.
    """
    width, depth = paths.size_mm
    out = io.StringIO()
    out.write(f"; bed {width:g} x {depth:g} mm, full power S{s_max:g}\n{_HEAD}")
    for layer in paths.layers:
        lines = polylines(layer)
        if not lines:
            continue
        feed, power = _feed_and_power(layer.operation, settings, s_max)
        out.write(f"; {layer.operation}\n")
        for line in lines:
            first, second, *others = [_place(point) for point in line.tolist()]
            out.write(f"G0 {first} S0\nG1 {second} S{power} F{feed}\n")
            out.writelines(f"G1 {place}\n" for place in others)
    out.write(_TAIL)
    return out.getvalue().encode()


def frame_bytes(paths: CutPaths, settings: Mapping[Operation, CutSetting]) -> bytes:
    """A run around the least box of all lines with the laser at zero power, to place the stock.

    The feed is that of the fastest operation. Raises `InvalidState` where nothing is drawn.
    """
    lines = [line for layer in paths.layers for line in polylines(layer)]
    if not lines:
        raise InvalidState("sheet", "nothing is on the sheet", "Draw something on it.")
    points = np.concatenate(lines)
    (left, near), (right, far) = points.min(axis=0), points.max(axis=0)
    corners = [(left, near), (right, near), (right, far), (left, far), (left, near)]
    feed = _number(max(setting.speed_mm_s for setting in settings.values()) * _SECONDS_A_MINUTE)
    first, second, *others = [_place(corner) for corner in corners]
    moves = "".join(f"G1 {place}\n" for place in others)
    text = f"; run around the lines without power\n{_HEAD}G0 {first} S0\nG1 {second} S0 F{feed}\n"
    return (text + moves + _TAIL).encode()


def _feed_and_power(
    operation: Operation, settings: Mapping[Operation, CutSetting], s_max: float
) -> tuple[str, str]:
    """F and S of an operation."""
    setting = settings.get(operation)
    if setting is None or setting.power_percent is None:
        raise InvalidState(
            "powers",
            f"the power of {operation} is not known, and G-code has to have it",
            "Give cut_percent, perforate_percent, score_percent and engrave_percent in [powers] of "
            "a machine of your own (score_percent for creases scored as whole lines; those of one "
            "kind that are partly scored, partly dashed need a run each).",
        )
    return (
        _number(setting.speed_mm_s * _SECONDS_A_MINUTE),
        _number(setting.power_percent / 100 * s_max),
    )


def _place(point: Sequence[float]) -> str:
    x, y = point
    return f"X{_number(x)} Y{_number(y)}"


def _number(value: float) -> str:
    """A number to six decimals, without zeros that say nothing."""
    return f"{value:.6f}".rstrip("0").rstrip(".")
