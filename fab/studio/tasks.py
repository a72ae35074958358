"""What the studio's workers do: grow, show, fold, simulate, picture, make. By name, in `TASKS`."""

from __future__ import annotations

import dataclasses
import hashlib
import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import Finding
from fab.jobs.job import load_job
from fab.jobs.job_files import Sheet, grown_sheet
from fab.jobs.reading import read_sheet
from fab.outputs import plain_title
from fab.pattern.crease_pattern import CreasePattern
from fab.studio.export_tasks import export
from fab.studio.findings import listed
from fab.studio.form_fields import form_fields
from fab.studio.hand_growth import by_hand, hand_state, next_strip
from fab.studio.job_text import changed_text, job_of_text
from fab.studio.messages import packed_answer
from fab.studio.simulation import simulate, simulate_file
from fab.viewing.face_triangles import face_corner_triangles
from fab.viewing.level_of_detail import detail_note
from fab.viewing.predicted_fold import predicted_scene
from fab.viewing.scene import Scene
from fab.viewing.scene_builders import pattern_scene
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray, IntArray

__all__ = ["TASKS", "fold", "grow", "opened", "picture", "read"]

# Pixels of a picture in the gallery, which is drawn twice as large.
_PICTURE = (480, 360)
# Pixels above and below the form in a picture.
_MARGIN = 12


def opened(text: str, folder: str, allow_code: bool) -> bytes:
    """The form of a job, and the values that it has. Raises `InvalidJob`."""
    job = job_of_text(text, Path(folder), allow_code=allow_code)
    fields = [dataclasses.asdict(field) for field in form_fields(job)]
    values = job.model_dump(mode="json", exclude_unset=True)
    return packed_answer({"text": text, "name": job.name, "fields": fields, "values": values})


def grow(
    text: str,
    changes: Sequence[tuple[Sequence[str], Any]],
    folder: str,
    topology: str,
    allow_code: bool,
) -> bytes:
    """The sheet of a job with some changes: its new text, how it grew, findings, and coordinates.

    topology : of the sheet that the page has; faces and edges are left out where it is the same.
    Raises `InvalidJob`.
    """
    text = changed_text(text, changes)
    sheet = _sheet(text, Path(folder), allow_code)
    plain = sheet.settings.model_copy(update={"simulation": None})  # which takes minutes
    report = dataclasses.replace(sheet, settings=plain).make([])
    growth = report.report["growth"]
    scene = pattern_scene(sheet.pattern, sheet.settings.name, upright=sheet.upright)
    head = {
        "text": text,
        "name": sheet.settings.name,
        "status": growth["status"],
        "advice": growth["advice"],
        "strips": growth["strips"],
        "boxes": report.report["bounding_box_mm"],
    }
    return _answer(head, scene, report.findings, topology)


def fold(text: str, folder: str, allow_code: bool) -> bytes:
    """States of the sheet of a job from flat to folded. Raises `InvalidJob`."""
    sheet = _sheet(text, Path(folder), allow_code)
    scene = predicted_scene(sheet.pattern, sheet.settings.name, upright=sheet.upright)
    return _states(scene)


def read(path: str, topology: str) -> bytes:
    """The pattern in a file, as `grow` answers. Raises `InvalidFile`."""
    name, scene, findings = _read(Path(path))
    pattern = scene.pattern
    boxes = {"flat": np.ptp(pattern.vertices_coords, axis=0).tolist()}
    if pattern.folded_coords is not None:
        boxes["folded"] = np.ptp(pattern.folded_coords, axis=0).tolist()
    head = {"name": name, "status": "read", "advice": "", "strips": 0, "boxes": boxes}
    return _answer(head, scene, findings, topology)


def read_fold(path: str) -> bytes:
    """States of the pattern in a file from flat to folded. Raises `InvalidFile`."""
    return _states(_read(Path(path))[1])


def picture(path: str) -> bytes:
    """A PNG of 480 x 360 pixels of the folded form of a shipped job."""
    from PIL import Image

    from fab.viewing.camera import fitted
    from fab.viewing.canvas import Box, Canvas
    from fab.viewing.painting import painted
    from fab.viewing.shapes import sheet_shapes, sheet_triangles

    sheet = grown_sheet(load_job(path))
    scene = pattern_scene(sheet.pattern, sheet.settings.name, upright=sheet.upright)
    coords = scene.states_coords[-1]
    triangles = sheet_triangles(sheet.pattern)
    axes = best_view([coords[triangles.vertices]], triangles.faces, upright=sheet.upright)
    width, height = 2 * _PICTURE[0], 2 * _PICTURE[1]
    inner = Box(0, 0, width, height).without(_MARGIN)
    camera = fitted(axes, coords, inner.width, inner.height, 1)
    canvas = Canvas(width, height)
    canvas.paste(painted(camera, [sheet_shapes(coords, triangles)]), inner)
    stream = io.BytesIO()
    with Image.open(io.BytesIO(canvas.png_bytes())) as image:
        image.convert("RGB").resize(_PICTURE).save(stream, format="png", optimize=True)
    return stream.getvalue()


TASKS: Mapping[str, Callable[..., Any]] = {
    "opened": opened,
    "grow": grow,
    "fold": fold,
    "read": read,
    "read_fold": read_fold,
    "simulate": simulate,
    "simulate_file": simulate_file,
    "picture": picture,
    "export": export,
    "hand_state": hand_state,
    "next_strip": next_strip,
    "by_hand": by_hand,
}

# The sheet that grew last, with what it grew from: its fold is asked for next.
_last: list[tuple[tuple[str, Path], Sheet]] = []


def _sheet(text: str, folder: Path, allow_code: bool) -> Sheet:
    if _last and _last[0][0] == (text, folder):
        return _last[0][1]
    sheet = grown_sheet(job_of_text(text, folder, allow_code=allow_code))
    _last[:] = [((text, folder), sheet)]
    return sheet


def _read(path: Path) -> tuple[str, Scene, Sequence[Finding]]:
    found = read_sheet(path)
    name = plain_title(path.stem)
    return name, predicted_scene(found.pattern, name), found.findings


def _states(scene: Scene) -> bytes:
    head = {"states": len(scene.shares), "shares": scene.shares.tolist()}
    return packed_answer(head, {"positions": scene.states_coords})


def _answer(
    head: Mapping[str, Any], scene: Scene, findings: Sequence[Finding], known: str
) -> bytes:
    pattern = scene.pattern
    triangles, faces = face_corner_triangles(pattern)
    arrays: dict[str, FloatArray | IntArray] = {
        "folded": scene.states_coords[-1],
        "flat": pattern.vertices_coords,
    }
    rows = pattern.faces_vertices[triangles]
    topology = _topology(pattern, rows)
    letters = "".join(pattern.edges_assignment.tolist())
    whole = {
        **head,
        "topology": topology,
        "letters": letters,
        "faces": pattern.face_count,
        "creases": pattern.counts(),
        "hasForm": pattern.folded_coords is not None,
        "detail": detail_note(pattern.face_count),
        "findings": listed(findings, pattern),
        "findingsCount": len(findings),
    }
    if topology != known:
        axes = best_view([scene.states_coords[-1][rows]], faces, upright=scene.upright)
        whole["view"] = axes[2].tolist()
        arrays |= {
            "triangles": rows,
            "trianglesFace": faces,
            "edges": pattern.edges_vertices,
            "corners": pattern.faces_vertices,
            "offsets": pattern.faces_offsets,
        }
    return packed_answer(whole, arrays)


def _topology(pattern: CreasePattern, triangles: IntArray) -> str:
    """A name of what is joined to what; of convex faces any triangles will do."""
    parts = [pattern.edges_vertices, pattern.faces_vertices, pattern.faces_offsets]
    if not _convex(pattern):
        parts.append(triangles)
    digest = hashlib.sha256(str(len(pattern.vertices_coords)).encode())
    for array in parts:
        digest.update(np.ascontiguousarray(array, dtype=np.int64).tobytes())
    return digest.hexdigest()[:16]


def _convex(pattern: CreasePattern) -> bool:
    corners, offsets = pattern.faces_vertices, pattern.faces_offsets
    onward, back = np.arange(1, len(corners) + 1), np.arange(-1, len(corners) - 1)
    onward[offsets[1:] - 1], back[offsets[:-1]] = offsets[:-1], offsets[1:] - 1
    at = pattern.vertices_coords[corners]
    to, since = at[onward] - at, at - at[back]
    return bool((since[:, 0] * to[:, 1] - since[:, 1] * to[:, 0] > 0).all())
