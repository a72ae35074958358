"""The guide to thick panels: plates, parts and how they are joined, hinges, folding."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

import numpy as np

from fab.errors import counted
from fab.viewing.assembly.body_views import body_views
from fab.viewing.assembly.flat_maps import FlatMaps
from fab.viewing.assembly.map_styles import legend
from fab.viewing.assembly.parts import Assembly, Hold, Joint, Model
from fab.viewing.assembly.sheet_maps import SheetMaps, map_rows
from fab.viewing.assembly.steps import fold_text, listed, numbers_text
from fab.viewing.leaflet import WIDTH_MM, Block, Facts, Heading, Leaflet, Row, Step, Table, Text
from fab.viewing.scene import Scene

__all__ = ["PanelHinge", "panel_guide"]

_FORM_MM, _FLAT_MM, _MAP_MM = (88.0, 64.0), (WIDTH_MM, 105.0), (98.0, 74.0)
# Longer lists are left to the FOLD file and the names of bodies.
_MOST_HINGES = 3000
# What is done with each kind of hinge before the first fold.
_HINGES = {
    "web": "Bend each web to and fro a few times, a little further each time.",
    "knuckle": "Pins are printed in their barrels: turn each hinge to and fro until it is free.",
    "snap knuckle": "Turn each hinge to and fro until it is free. Panels snap off their pins and "
    "on again: press the open barrels onto the pin, one after another.",
    "film": "The film holds the panels: bend it along each crease.",
}


@dataclass(frozen=True)
class PanelHinge:
    """A hinge between two panels.

    Attributes
    ----------
    edge : its number, that of the edge in the pattern. kind : such as "web" and "knuckle".
    joint : its number, where parts are joined there.
    panels : numbers of both, those of their faces.
    """

    edge: int
    kind: str
    joint: int | None
    length_mm: float
    fold_angle_deg: float
    panels: tuple[int, int]


def panel_guide(
    assembly: Assembly,
    scene: Scene,
    hinges: tuple[PanelHinge, ...],
    state: int,
    panels: tuple[int, ...],
) -> Leaflet:
    """Facts, the folded bodies, plates, the flat plan, steps, the list of hinges.

    assembly : one model whose pieces are the parts; its sheets are the plates. scene : with its
    bodies. state : the last one that panels reach. panels : numbers of the faces that have one.
    """
    (model,) = assembly.models
    flat = FlatMaps(model)
    blocks: list[Block] = [Text(assembly.caution)] if assembly.caution else []
    blocks.append(Facts((*assembly.facts, *model.facts)))
    blocks += [Heading("Folded"), Row(body_views(scene, model, state, _FORM_MM))]
    if assembly.sheets:
        blocks += [Heading("Plates"), *map_rows(assembly, SheetMaps(assembly))]
    if not model.alone:
        blocks += [Heading("Parts and joints"), Row((flat.whole(_FLAT_MM),))]
    edges = np.array([hinge.edge for hinge in hinges], np.int64)
    plan = flat.numbered(edges, np.array(panels, np.int64), _FLAT_MM)
    if plan is not None:
        blocks += [Heading("Hinges and panels"), Row((plan,), joined=True)]
    letters = np.unique(model.pattern.edges_assignment).tolist()
    blocks.append(Row((legend(letters, model, WIDTH_MM),)))
    blocks.append(Heading("Steps"))
    blocks += _steps(assembly, model, flat, hinges, scene, state)
    if hinges:
        blocks += _hinge_list(hinges, numbered=plan is not None)
    return Leaflet(f"{assembly.name}: panels", assembly.made_by, tuple(blocks))


def _steps(
    assembly: Assembly,
    model: Model,
    flat: FlatMaps,
    hinges: tuple[PanelHinge, ...],
    scene: Scene,
    state: int,
) -> list[Block]:
    steps: list[Step] = []
    plates = len(assembly.sheets)
    text = f"Print {counted(plates, 'plate')}." if plates else "Print the sheet flat, as it is."
    steps.append(Step(1, "Print", " ".join([text, *assembly.cutting])))
    for pair, group in groupby(model.joints, lambda joint: max(joint.pieces)):
        joints = list(group)
        others = sorted({piece for joint in joints for piece in joint.pieces} - {pair})
        names = [model.pieces[number].name for number in others]
        own = model.pieces[pair].name
        labels = tuple(joint.label for joint in joints)
        numbers = numbers_text(labels)
        text = f"{'Joint' if len(joints) == 1 else 'Joints'} {numbers}, while all lies flat. "
        text += _joined(model, joints)
        near = flat.around((*others, pair), labels, _MAP_MM)
        steps.append(Step(len(steps) + 1, f"Join {own} to {listed(names)}", text, near))
    kinds = list(dict.fromkeys(hinge.kind for hinge in hinges))
    told = [_HINGES[kind] for kind in kinds if kind in _HINGES]
    if told:
        steps.append(Step(len(steps) + 1, "Hinges", " ".join(told)))
    reached = scene.bodies.state_names[state] if scene.bodies is not None else ""
    last = state == scene.state_count - 1
    text = "Fold everywhere a little, again and again, rather than one crease after another."
    if not last:
        text += f" Panels stop {reached}: do not force them further."
    steps.append(Step(len(steps) + 1, "Fold", text))
    return list(steps)


def _joined(model: Model, joints: list[Joint]) -> str:
    """How the joints of a part are made, by their kind."""
    sentences = []
    by_hold: dict[tuple[Hold, int | None], list[Joint]] = {}
    for joint in joints:
        by_hold.setdefault((joint.hold, joint.holder), []).append(joint)
    for (hold, holder), own in by_hold.items():
        at = "" if len(own) == len(joints) else f" at {numbers_text(j.label for j in own)}"
        if hold is Hold.TAPE or holder is None:
            sentences.append(f"Tape them{at}.")
            continue
        name = model.pieces[holder].name
        others = [
            model.pieces[number].name
            for number in sorted({n for j in own for n in j.pieces if n != holder})
        ]
        how = " and put pins through their holes" if hold is Hold.PIN else ""
        sentences.append(
            f"Lay the pockets of {listed(others)} over the tongues of {name}{at}{how}."
        )
    return " ".join(sentences)


def _hinge_list(hinges: tuple[PanelHinge, ...], *, numbered: bool) -> list[Block]:
    text = "Numbers are those of edges and faces of the FOLD file, and of the bodies in STEP files."
    if not numbered:
        text += " There are too many of them for a plan of this size."
    if len(hinges) > _MOST_HINGES:
        return [Heading("Hinges"), Text(f"{text} {len(hinges)} hinges are not listed here.")]
    rows = tuple(
        (
            str(hinge.edge),
            hinge.kind if hinge.joint is None else f"{hinge.kind}, joint {hinge.joint}",
            f"{hinge.length_mm:.1f}",
            fold_text(hinge.fold_angle_deg),
            f"{hinge.panels[0]} - {hinge.panels[1]}",
        )
        for hinge in hinges
    )
    head = ("hinge", "kind", "mm", "fold", "panels")
    return [Heading("Hinges"), Text(text), Table("Hinges", head, rows, 1 if len(rows) <= 12 else 2)]
