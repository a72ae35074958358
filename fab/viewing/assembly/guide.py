"""The assembly guide: all pages for one who has cut the sheets and puts the model together."""

from __future__ import annotations

import numpy as np

from fab.viewing.assembly.flat_maps import FlatMaps
from fab.viewing.assembly.form_views import FormViews
from fab.viewing.assembly.map_styles import legend
from fab.viewing.assembly.parts import Assembly, Model
from fab.viewing.assembly.sheet_maps import SheetMaps, map_rows
from fab.viewing.assembly.steps import fold_text, hold_text, written_steps
from fab.viewing.leaflet import (
    WIDTH_MM,
    Block,
    Facts,
    Heading,
    Leaflet,
    NewPage,
    Row,
    Step,
    Table,
    Text,
)
from fab.viewing.scene_builders import laid_flat
from fab.viewing.sketch import Sketch

__all__ = ["assembly_guide"]

# Sizes of what is on the pages, mm.
_SMALL, _FORM = (58.0, 52.0), (88.0, 68.0)
_MANY_JOINTS = 40
_MAP_MM, _STEP_FORM = (98.0, 74.0), (60.0, 44.0)
# Of more steps than this the first have small pictures; views of forms take longer.
_MOST_MAPS, _MOST_FORMS = 1000, 24
# Of larger sheets steps have no views of their own.
_MANY_FACES = 20_000


def assembly_guide(assembly: Assembly) -> Leaflet:
    """Facts, the folded form, the sheets, the flat pattern, the steps, the table of seams.

    Where several models are cut together, the sheets are first, then each model is on its own.
    """
    sheets = SheetMaps(assembly)
    blocks: list[Block] = [Text(assembly.caution)] if assembly.caution else []
    if len(assembly.models) == 1:
        (model,) = assembly.models
        blocks.append(Facts((*assembly.facts, *model.facts)))
        views = _views(model)
        if len(assembly.sheets) == 1:
            forms = views.both(_SMALL) if views is not None else ()
            blocks.append(Row((sheets.map(assembly.sheets[0], _SMALL), *forms)))
        else:
            blocks += _forms(views)
            blocks += [Heading("Sheets"), *map_rows(assembly, sheets)]
        blocks += _model(model, views, assembly)
    else:
        blocks.append(Facts(assembly.facts))
        blocks += [Heading("Sheets"), *map_rows(assembly, sheets)]
        for model in assembly.models:
            views = _views(model)
            blocks += [NewPage(), Heading(model.name), Facts(model.facts), *_forms(views)]
            blocks += _model(model, views, assembly)
    return Leaflet(f"{assembly.name}: assembly", assembly.made_by, tuple(blocks))


def _forms(views: FormViews | None) -> list[Block]:
    return [] if views is None else [Heading("Folded form"), Row(views.both(_FORM))]


def _model(model: Model, views: FormViews | None, assembly: Assembly) -> list[Block]:
    """The flat pattern, the steps and the table of seams of a model."""
    single = len(model.pieces) == 1 and not model.joints
    flat = FlatMaps(model)
    alone = 80.0 if views is not None else 96.0
    high = alone if single else 215.0 if len(model.joints) > _MANY_JOINTS else 130.0
    blocks: list[Block] = [
        Heading("Flat pattern"),
        Row((flat.whole((WIDTH_MM, high)),), joined=True),
    ]
    letters = np.unique(model.pattern.edges_assignment).tolist()
    blocks.append(Row((legend(letters, model, WIDTH_MM),)))
    blocks.append(Heading("Steps"))
    blocks += _steps(model, flat, None if single else views, assembly)
    if model.joints:
        blocks += [Heading("Seams"), Text(_table_text(model)), _table(model)]
    return blocks


def _table_text(model: Model) -> str:
    text = (
        "In the order in which they are joined; each number is engraved on both sides of its seam"
    )
    stopped = [joint.engraved for joint in model.joints if joint.engraved != str(joint.label)]
    if stopped:
        text += f", with a full stop where it would be another one upside down: {stopped[0]}"
    return text if text.endswith(".") else f"{text}."


def _views(model: Model) -> FormViews | None:
    formed = model.formed
    if formed is None or formed.folded_coords is None:
        return None
    coords = formed.folded_coords
    if not model.upright:
        turn, shift = laid_flat(formed, coords)
        coords = coords @ turn.T + shift
    return FormViews(model, formed, coords)


def _steps(
    model: Model, flat: FlatMaps, views: FormViews | None, assembly: Assembly
) -> list[Block]:
    out: list[Block] = []
    maps = forms = 0
    slow = model.pattern.face_count > _MANY_FACES
    for number, step in enumerate(written_steps(model, assembly), 1):
        near: tuple[Sketch, ...] = ()
        below: tuple[Sketch, ...] = ()
        if step.pieces and maps < _MOST_MAPS:
            maps += 1
            near = flat.around(step.pieces, step.labels, _MAP_MM)
        if near and views is not None and forms < _MOST_FORMS and not slow:
            forms += 1
            below = (
                views.view(
                    _STEP_FORM,
                    step.joined,
                    labels=step.labels,
                    caption="What is joined then, folded.",
                ),
            )
        out.append(Step(number, step.title, step.text, near, below))
    return out


def _table(model: Model) -> Table:
    rows = tuple(
        (
            str(joint.label),
            f"{joint.length_mm:.1f}",
            fold_text(joint.fold_angle_deg),
            " - ".join(dict.fromkeys(model.pieces[piece].name for piece in joint.pieces)),
            hold_text(model, joint),
            "□",
        )
        for joint in model.joints
    )
    head = ("seam", "mm", "fold", "pieces", "by", "done")
    return Table("Seams", head, rows, 1 if len(rows) <= 12 else 2)
