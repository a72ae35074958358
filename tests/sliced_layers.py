"""What PrusaSlicer prints of a file, layer by layer, read from its G-code."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import shapely

wants_slicer = pytest.mark.skipif(
    shutil.which("prusa-slicer") is None, reason="no prusa-slicer: install Debian's"
)


def sliced(path: Path, *options: str) -> list[str]:
    """The lines of G-code of a model, with layers of 0.2 mm and no compensation of any kind."""
    out = path.with_suffix(".gcode")
    command = ["prusa-slicer", "--datadir", str(path.parent / "none"), "--export-gcode"]
    own = ["--layer-height", "0.2", "--first-layer-height", "0.2", "--elefant-foot-compensation=0"]
    bed = ["--bed-shape", "0x0,250x0,250x210,0x210", "--skirts", "0"]
    run = [*command, *own, *bed, *options, "-o", str(out), str(path)]
    subprocess.run(run, check=True, capture_output=True, timeout=300)
    return out.read_text().splitlines()


def printed_islands(lines: list[str], layer: int) -> list[shapely.Polygon]:
    """What lies apart in a layer, counted from 1: lines of plastic of their width, joined."""
    number, width, place, tracks = 0, 0.0, np.zeros(2), []
    for line in lines:
        if line.startswith(";LAYER_CHANGE"):
            number += 1
        elif line.startswith(";WIDTH:"):
            width = float(line[7:])
        elif line.startswith(("G1 ", "G0 ")):
            words = {word[0]: word[1:] for word in line.split(";")[0].split()[1:]}
            target = np.array([float(words.get(k, v)) for k, v in zip("XY", place, strict=True)])
            if number == layer and float(words.get("E", 0)) > 0 and (target != place).any():
                tracks.append(shapely.buffer(shapely.LineString([place, target]), width / 2))
            place = target
    return list(shapely.get_parts(shapely.union_all(tracks)))


def least_gap_mm(islands: list[shapely.Polygon]) -> float:
    """The least distance of two islands."""
    tree = shapely.STRtree(islands)
    first, second = tree.query(islands, predicate="dwithin", distance=5.0)
    pairs = first < second
    return float(
        min(
            islands[i].distance(islands[k])
            for i, k in zip(first[pairs].tolist(), second[pairs].tolist(), strict=True)
        )
    )
