"""Finish of a sheet: mirror, title and bridges; and how its lines are followed in the end.

placed pieces -> mirror -> title -> shared lines once, or bridges; then for each drawing
order of the work -> dashes as slots -> lead-ins and overcuts -> path of the knife's axis
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fab.drawings.closed_cuts import led_in
from fab.drawings.closed_slots import dash_slots, slot_beside
from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.drawings.drag_knife import blade_led
from fab.drawings.holding_bridges import bridged
from fab.drawings.shared_lines import cut_once
from fab.errors import Finding, Severity, counted
from fab.sheets.cutting_order import occupied_holes_last, tour
from fab.sheets.sheet_request import SheetRequest
from fab.sheets.sheet_title import titled
from solver.vectors import FloatArray

__all__ = ["Finished", "finish_findings", "finished", "followed"]


@dataclass(frozen=True)
class Finished:
    """A sheet with all that is asked for besides its pieces.

    Attributes
    ----------
    bridges : how many hold each outline, where any are asked for.
    title_left_out : whether there was no room for the title.
    """

    paths: CutPaths
    bridges: tuple[int, ...] = ()
    title_left_out: bool = False


def finished(paths: CutPaths, name: str, request: SheetRequest) -> Finished:
    """A sheet with its bridges and its title, mirrored where it lies face down.

    name : of the job, for the title.
    """
    wishes = request.wishes
    if wishes.mirror:
        paths = _mirrored(paths)
    left_out = False
    if wishes.title:  # pieces are known by their closed outlines: before these have bridges
        texts = [text for text in (name, *request.names) if text]
        whole = titled(paths, texts, request.margin_mm, request.gap_mm)
        left_out = whole is None
        paths = paths if whole is None else whole
    if request.shared_cuts:
        paths = cut_once(paths)
    counts: tuple[int, ...] = ()
    if wishes.bridges:
        paths, counts = _bridged(paths, request)
    return Finished(paths, counts, left_out)


def followed(
    paths: CutPaths, request: SheetRequest, *, turned_over: bool = False
) -> tuple[CutPaths, tuple[FloatArray, ...]]:
    """A drawing in the order of the work, as the tool goes; and outlines without a lead-in.

    turned_over : whether it is the back of a sheet.
    """
    knife = request.machine.knife
    ordered = tour(paths)
    wishes = request.wishes
    if wishes.closed_slots:  # after the tour, which is shorter for lines
        ordered = dash_slots(ordered, wishes.slot_mm, request.machine.beam)
    led, bare = led_in(
        ordered,
        knife.lead_in_mm,
        knife.overcut_mm,
        request.machine.margin_mm,
        turned_over=turned_over,
    )
    return blade_led(led, knife.offset_mm, knife.corner_deg), bare


def finish_findings(
    sheets: Sequence[Finished], bare: Sequence[FloatArray], request: SheetRequest
) -> list[Finding]:
    """What could not be made as asked for, over all sheets, and what to know of mirrored ones."""
    out = []
    wanted = request.wishes.bridges
    fewer = [count for sheet in sheets for count in sheet.bridges if count < wanted]
    if fewer:
        has = "1 outline has" if len(fewer) == 1 else f"{len(fewer)} outlines have"
        none = fewer.count(0)
        loose = f" {counted(none, 'piece')} without any will come loose." if none else ""
        text = (
            f"{has} room for fewer than {counted(wanted, 'bridge')} away from corners, for "
            f"{sum(fewer)} in all.{loose} Lower cutter.bridges or cutter.bridge_mm, or enlarge the "
            "sheet."
        )
        out.append(Finding("bridges-fewer", Severity.WARNING, text))
    untitled = [str(i) for i, sheet in enumerate(sheets, 1) if sheet.title_left_out]
    if untitled:
        which = "sheet" if len(untitled) == 1 else "sheets"
        text = (
            f"there is no room for the title beside the pieces of {which} {', '.join(untitled)}. "
            "Take a larger bed, or write it on the stock."
        )
        out.append(Finding("title-no-room", Severity.WARNING, text))
    if bare:
        x, y = bare[0].mean(axis=0).tolist()
        has = "1 closed cut has" if len(bare) == 1 else f"{len(bare)} closed cuts have"
        text = (
            f"{has} no room in what is thrown away for a quarter of knife.lead_in_mm = "
            f"{request.machine.knife.lead_in_mm:g} mm (the first around x = {x:.1f}, "
            f"y = {y:.1f} mm): cut without a lead-in. Lower lead_in_mm."
        )
        out.append(Finding("lead-in-left-out", Severity.NOTE, text))
    if request.wishes.mirror:
        text = (
            "drawings are mirrored: lay the material face down. Letters are engraved on its back "
            "so that they are read there."
        )
        out.append(Finding("mirrored", Severity.NOTE, text))
    return out


def _bridged(paths: CutPaths, request: SheetRequest) -> tuple[CutPaths, tuple[int, ...]]:
    """The sheet with bridges in all outlines of pieces, and in the holes that pieces lie in."""
    wishes, beam = request.wishes, request.machine.beam
    layers = occupied_holes_last(paths.layers)
    through = [la for la in layers if la.operation in (Operation.HOLE, Operation.CUT)]
    ends = [la.segments.reshape(-1, 2) for la in through]
    ends += [chain[[0, -1]] for la in through for chain in la.chains]
    counts: tuple[int, ...] = ()
    out: list[Layer] = []
    for layer in layers:
        if layer.operation is not Operation.CUT:
            out.append(layer)
            continue
        made = bridged(
            layer.outlines,
            wishes.bridges,
            wishes.bridge_mm,
            beam,
            np.concatenate(ends),
            request.slot_reach_mm,
        )
        counts = made.counts
        arcs, outlines = made.chains, made.outlines
        if wishes.closed_slots:
            of = np.repeat(np.arange(len(counts)), counts).tolist()
            outlines += tuple(
                slot_beside(arc, layer.outlines[number], wishes.slot_mm, beam)
                for arc, number in zip(arcs, of, strict=True)
            )
            arcs = ()
        out.append(replace(layer, outlines=outlines, chains=(*layer.chains, *arcs)))
    return replace(paths, layers=tuple(out)), counts


def _mirrored(paths: CutPaths) -> CutPaths:
    """Left and right exchanged; outlines keep their material on the left."""
    turn, shift = np.diag([-1.0, 1.0]), np.array([paths.size_mm[0], 0.0])
    layers = []
    for layer in paths.layers:
        moved = layer.moved(turn, shift)
        layers.append(replace(moved, outlines=tuple(ring[::-1] for ring in moved.outlines)))
    return replace(paths, layers=tuple(layers))
