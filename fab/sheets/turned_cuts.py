"""Pieces cut anew as they are placed, for a beam that is wider along one axis of the bed.

A piece that is turned has that axis elsewhere, so its kerf follows from where it is placed; for
placing, room is kept for the widest cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fab.drawings.cut_paths import Layer
from fab.errors import Finding
from fab.layout.nesting import Placements
from fab.sheets.crease_findings import crease_findings
from fab.sheets.cut_pieces import CutPattern, cut_layers_of, finding_of_piece
from fab.sheets.sheet_request import SheetRequest

__all__ = ["cut_as_placed"]

# Turns that differ by less have the same cuts, in decimals of a radian.
_SAME_TURN = 6


def cut_as_placed(
    patterns: Sequence[CutPattern], placements: Placements, request: SheetRequest
) -> tuple[list[tuple[Layer, ...]], Placements, tuple[Finding, ...]]:
    """The layers of each placed piece, the placements of these, and what is found in cutting them.

    Pieces are numbered through all patterns. The first placement of a piece has the layers 0, and
    so on; findings of copies that are turned alike are named once.
    """
    whole = [(pattern, piece) for pattern in patterns for piece in pattern.pieces.pieces]
    known: dict[tuple[int, float], int] = {}
    layers: list[tuple[Layer, ...]] = []
    creases, findings = [], []
    items = []
    for item in placements.items:
        angle = float(np.arctan2(item.turn[1, 0], item.turn[0, 0]))
        key = (item.piece, round(angle, _SAME_TURN))
        if key not in known:
            pattern, piece = whole[item.piece]
            beam = request.machine.beam.turned(-angle)
            cut, drawn = cut_layers_of(piece, request, beam, labelled=pattern.labelled)
            creases.append(replace(cut.creases, numbers=piece.edges[cut.creases.numbers]))
            alone = len(whole) == 1
            findings += [finding_of_piece(piece, one, alone=alone) for one in cut.findings]
            known[key] = len(layers)
            layers.append(drawn)
        items.append(replace(item, piece=known[key]))
    margin_mm = request.perforation.margin_mm
    findings += crease_findings(creases, margin_mm, request.machine.beam)
    once = {(one.code, one.text): one for one in findings}
    return layers, replace(placements, items=tuple(items)), tuple(once.values())
