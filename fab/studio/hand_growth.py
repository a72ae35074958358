"""What the studio knows of a sheet that is grown by hand: its sides, and the choices of a strip."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import InvalidJob
from fab.jobs.design_settings import SEEDS
from fab.jobs.goals import design_goals, design_unit
from fab.jobs.job import Job
from fab.studio.job_text import Change, changed_text, job_of_text
from fab.studio.messages import packed_answer
from solver import Front, Growth, InvalidState, InvalidValue, QuadMesh, Side, StripByStrip
from solver.flap_costs import DesignAngleCost
from solver.flap_landscape import flap_angle_landscape
from solver.growth import least_length
from solver.rays import Rays
from solver.strip_choices import (
    ChosenStrip,
    closing_flap_angles,
    free_arcs_of,
    proposed_strip,
    strip_front,
)
from solver.strip_family import special_at_first
from solver.transfer import transfer_flap_angles
from solver.vectors import FloatArray, angle_between

__all__ = ["KIND", "by_hand", "hand_state", "next_strip"]

KIND = "strip_by_strip"
# Flap angles around the circle at which cost and constraints are shown.
_TRIALS = 360
# Special flap angles of so many vertices of a front are shown, those at its left end.
_MARKED = 24
# Creases that meet farther off than so many times the length of the front are as good as parallel.
_FAR = 1000.0


def by_hand(text: str, changes: Sequence[Change], folder: str, allow_code: bool) -> bytes:
    """The text of a job whose sheet is the seed of one that goes on by hand. Raises `InvalidJob`.

    The table of the design stays as it is, with its comments, and becomes that of the seed.
    """
    import tomlkit

    text = changed_text(text, changes)
    job = job_of_text(text, Path(folder), allow_code=allow_code)
    if job.design.kind not in SEEDS:
        raise InvalidJob(
            f"design.kind = {job.design.kind!r} cannot be a seed: it must be one of "
            f"{', '.join(SEEDS)}."
        )
    document: Any = tomlkit.parse(text)
    seed = document["design"]
    inline = not isinstance(seed, tomlkit.items.Table) or seed.is_super_table()
    design = tomlkit.inline_table() if inline else tomlkit.table()
    design["kind"] = KIND
    design["seed"] = _inline(seed) if inline else seed
    document["design"] = design
    grown = tomlkit.dumps(document)
    wanted = tomllib.loads(text)
    wanted["design"] = {"kind": KIND, "seed": wanted["design"]}
    if tomllib.loads(grown) != wanted:
        raise InvalidJob("design: its table cannot be moved. Write it as [design] in the text.")
    return packed_answer({"text": grown})


def _inline(table: Mapping[str, Any]) -> Any:
    import tomlkit

    out = tomlkit.inline_table()
    out.update(table)
    return out


def next_strip(
    text: str, changes: Sequence[Change], side: str, folder: str, allow_code: bool
) -> bytes:
    """A strip to begin with on a side of a job's sheet, as a row of its strips.

    Raises `InvalidJob`, and `InvalidState` for sides on which no strip can grow.
    """
    job = job_of_text(changed_text(text, changes), Path(folder), allow_code=allow_code)
    mesh = _grown(job, Path(folder), None)
    strip = proposed_strip(mesh, Side(side))
    angle = round(float(np.degrees(strip.flap_angle)), 10)
    row = {"side": strip.side.value, "flap_angle_deg": angle, "lengths": strip.lengths}
    return packed_answer({"strip": row})


def hand_state(
    text: str,
    changes: Sequence[Change],
    strip: int | None,
    landscape: str,
    folder: str,
    allow_code: bool,
) -> bytes:
    """The sides of a job's sheet, and what may be chosen for one of its strips.

    strip : its number, counted from 0; None for the sides alone. landscape : the one that the page
    has; its numbers are left out where it is the same. Of a job that is not grown by hand neither
    is known. Raises `InvalidJob`, and `InvalidValue` for strips before that cannot be grown.
    """
    job = job_of_text(changed_text(text, changes), Path(folder), allow_code=allow_code)
    if job.design.kind != KIND:
        return packed_answer({"sides": None, "strip": None, "seedable": job.design.kind in SEEDS})
    try:
        sides = _sides(_grown(job, Path(folder), None))
    except InvalidValue:
        sides = None  # the page keeps those that it has
    head: dict[str, Any] = {"sides": sides, "strip": None, "seedable": False}
    if strip is None or not 0 <= strip < len(job.design.strips):
        return packed_answer(head)
    chosen: ChosenStrip = job.design.strips[strip].parameters()
    mesh = _grown(job, Path(folder), strip)
    choices = _choices(mesh, chosen)
    head["strip"] = {"number": strip, **choices.head}
    arrays = choices.landscape() if choices.head["landscape"] != landscape else {}
    return packed_answer(head, arrays)


@dataclass(frozen=True)
class _Grown:
    """A design that has grown already."""

    growth: Growth

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """What grew."""
        del progress
        return self.growth


# The seed that grew last, with what it grew from.
_last: list[tuple[tuple[str, Path], Growth]] = []


def _grown(job: Job, folder: Path, strips: int | None) -> QuadMesh:
    """The sheet of a job that is grown by hand, after some of its strips, or all of them."""
    table = job.design
    if table.kind != KIND:
        raise InvalidJob(f"design.kind = {table.kind!r} must be {KIND!r} to be grown by hand.")
    known = (json.dumps([table.seed.model_dump(mode="json"), job.goals.model_dump()]), folder)
    design: StripByStrip = table.design(folder, design_goals(job), design_unit(job.sheet))[0]
    if not (_last and _last[0][0] == known):
        _last[:] = [(known, replace(design, strips=()).grow())]
    growth = replace(design, seed=_Grown(_last[0][1]), strips=design.strips[:strips]).grow()
    return growth.mesh


def _sides(mesh: QuadMesh) -> dict[str, Any]:
    """For each side of a sheet its vertices, and why no strip can grow on it, if none can."""
    opened = mesh.cut_open()
    sides = {}
    for side in Side:
        why = ""
        try:
            strip_front(mesh, side)
        except InvalidState as error:
            why = f"{error.value}."
        along = opened.turned(side)[-1]
        sides[side.value] = {"vertices": along[along >= 0].tolist(), "why": why}
    return sides


@dataclass(frozen=True)
class _Choices:
    """What may be chosen for a strip on a front: `head` for the page, and the landscape."""

    head: dict[str, Any]
    front: Front
    lengths: FloatArray | None

    def landscape(self) -> dict[str, FloatArray]:
        """Cost S30 and constraints C_con at flap angles around the circle (figure S13)."""
        trials = 2 * np.pi * np.arange(_TRIALS) / _TRIALS
        if self.front.closed:
            flaps = transfer_flap_angles(self.front.transfer_matrices, trials)
            constraint = self.front.self_intersections(flaps).sum(axis=0)
            cost = DesignAngleCost.of(self.front).cost(trials)
        else:
            found = flap_angle_landscape(self.front, lengths=self.lengths, flap_angles=trials)
            cost, constraint = found.cost, found.constraint
        return {"cost": cost, "constraint": constraint.astype(np.float64)}


def _choices(mesh: QuadMesh, chosen: ChosenStrip) -> _Choices:
    front = strip_front(mesh, chosen.side)
    rays = chosen.rays(front)
    count = len(rays.directions)
    lengths = np.asarray(chosen.lengths, np.float64)
    usable = lengths.shape in ((), (count,))
    free = free_arcs_of(front)
    closing = closing_flap_angles(front)
    far = _FAR * float(np.ptp(front.vertices_coords, axis=0).max())
    bounds = [None if bound > far else bound for bound in rays.length_bounds.tolist()]
    best = None
    if len(free) and closing is None:
        best = float(np.degrees(DesignAngleCost.of(front).best_of(free)) % 360.0)
    digest = hashlib.sha256(front.vertices_coords.tobytes())
    digest.update(front.k.tobytes() + (lengths.tobytes() if usable else b""))
    along = mesh.front_vertices(chosen.side)
    row = len(mesh.vertices_coords) + np.arange(count)
    head = {
        "side": chosen.side.value,
        "free": np.degrees(free).tolist(),
        "closings": None if closing is None else np.degrees(closing).tolist(),
        "special": _special(front),
        "best": best,
        "oldFace": _old_face(front),
        "boundary": None if front.closed else _boundary(front, rays),
        "bounds": bounds,
        "least": least_length(rays),
        "front": along.tolist(),
        "row": row.tolist(),
        "closed": front.closed,
        "landscape": digest.hexdigest()[:16],
    }
    spread = np.broadcast_to(lengths, count) if usable else None
    return _Choices(head, front, spread)


def _boundary(front: Front, rays: Rays) -> list[float]:
    """Design angles at both ends of an open front, degrees."""
    edges, new = front.edges_direction, rays.directions
    ends = angle_between(np.stack([edges[0], -edges[-1]]), new[[0, -1]])
    angles: list[float] = np.degrees(ends).tolist()
    return angles


def _old_face(front: Front) -> float:
    """Where the old face at the first vertex is, about the same axis as the flap, degrees."""
    assert front.back is not None
    c = front.back[0]
    return float(np.degrees(np.arctan2(c @ front.normals[0], c @ front.inner[0])) % 360.0)


def _special(front: Front) -> list[dict[str, Any]]:
    """Special flap angles (S2) of the vertices, as angles at the first one: name, vertex, angle."""
    marks = []
    first = 0 if front.closed else 1
    for name, angles in special_at_first(front).items():
        for vertex, each in enumerate(np.degrees(angles[:_MARKED]).tolist()):
            for angle in each:
                if np.isfinite(angle):
                    marks.append({"name": name, "vertex": vertex + first, "angle": angle % 360.0})
    return marks
