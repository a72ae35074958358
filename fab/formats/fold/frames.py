"""Frames of a FOLD file: the flat sheet among them, its folded form, and other states.

Specification: https://github.com/edemaine/fold/blob/main/doc/spec.md (version 1.2).
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import Finding, InvalidFile, Severity, counted
from fab.files import require_file
from fab.formats.coordinate_bounds import require_range
from fab.formats.fold.flat_frames import FlatSheet, flat_sheet, is_open
from fab.formats.fold.number_rows import number_rows
from fab.formats.fold.sheet_frames import SheetFrames, sheet_frames
from fab.formats.fold.unfolding import unfolded
from fab.formats.json_files import read_json
from fab.formats.pattern_file import State
from fab.formats.read_options import ReadOptions
from fab.outputs import plain_title
from solver.vectors import FloatArray, IntArray

__all__ = [
    "LARGEST_BYTES",
    "SEAM_KEY",
    "STATE_KEY",
    "Frames",
    "State",
    "frame_coords",
    "frame_faces",
    "frame_list",
    "frame_pairs",
    "frame_title",
    "frames_of_shapes",
    "read_frames",
]

# About 5 million vertices, flat and folded.
LARGEST_BYTES = 2_000_000_000
# Marks a simulated state among folded forms; keys with a colon are left to programs.
STATE_KEY = "quadfold:state"
# Numbers of the points at which rims of several sheets are glued together.
SEAM_KEY = "quadfold:vertices_seam"

_Frame = dict[str, Any]


@dataclass(frozen=True)
class Frames:
    """Frames of a file, each with what it inherits.

    Attributes
    ----------
    title : of the file; empty where it has none.
    flat, coords : frame of the flat sheet, and its points in the plane, shape (nv, 2).
    folded : frame of the folded form where there is one.
    states : other folded frames, in the order of the file.
    patterns : how many different crease patterns the file holds.
    findings : what was assumed to find the flat sheet.
    """

    title: str
    flat: _Frame
    coords: FloatArray
    folded: _Frame | None
    states: tuple[_Frame, ...]
    patterns: int = 1
    findings: tuple[Finding, ...] = ()


def read_frames(path: Path, options: ReadOptions) -> Frames:
    """The frames of a file.

    The flat sheet is the first frame of class creasePattern, or the first that has all of it and
    more, such as assignments, or that which `options.frame` names; where no frame is of this class,
    all frames that are flat and open count as such, in any plane and but for folded forms; without
    any, a folded form is unfolded. The folded form is the first of class foldedForm besides. Code
    of the finding about frames of other classes: "frames-left-out".

    Raises `InvalidFile` for what is no FOLD file, and one without a sheet that is or unfolds flat.
    """
    document = _load(path)
    raw = [document, *frame_list(path, document, "file_frames", [])]
    frames = _resolved(path, raw)
    named = [
        number
        for number, frame in enumerate(frames)
        if _is(frame, "creasePattern") and (number == 0 or "vertices_coords" in frame)
    ]
    found = sheet_frames(frames, named or _flat_frames(path, frames))
    sheets = found.numbers
    title = _text(document.get("file_title"))
    if not sheets:
        return _without_sheet(path, title, frames, options)
    if options.frame is not None and not 1 <= options.frame <= len(sheets):
        raise InvalidFile(
            f"{path}: --frame {options.frame}: the file has {len(sheets)} crease "
            f"{'pattern' if len(sheets) == 1 else 'patterns'}. Give 1 to {len(sheets)}."
        )
    number = found.fullest() if options.frame is None else sheets[options.frame - 1]
    findings = []
    if len(sheets) > 1 and options.frame is None:
        text = f"the file has {len(sheets)} crease patterns: {_which(found, number)}"
        findings.append(Finding("several-patterns", Severity.WARNING, text))
    flat = frames[number]
    folded = [
        frame
        for place, frame in enumerate(frames)
        if _is(frame, "foldedForm")
        and (len(sheets) == 1 or _belongs(found, _sheet_of(raw, place, found.same), number))
    ]
    if len(sheets) > 1:
        count = len(frame_list(path, flat, "vertices_coords", []))
        folded = [f for f in folded if len(frame_list(path, f, "vertices_coords", [])) == count]
        title = _text(flat.get("frame_title")) or title
    sheet = _flat(path, flat)
    if sheet is None:
        coords = frame_coords(path, flat, "crease pattern")
        raise InvalidFile(
            f"{path}: no flat frame: the crease pattern's z runs over {np.ptp(coords[:, 2]):.6g}. "
            "Give a frame of class creasePattern with flat coordinates."
        )
    others = [n for n in _classless(frames) if n not in found.same]
    findings += _left_out(frames, number, others)
    return _chosen(title, flat, sheet, folded, len(sheets), findings)


def frames_of_shapes(
    path: Path, title: str, frame: _Frame, folded: _Frame | None, findings: list[Finding]
) -> Frames:
    """The frames of a flat shape, or of a folded one alone, which is unfolded.

    frame : with vertices_coords and faces_vertices. folded : its folded form where that is known.
    """
    sheet = _flat(path, frame)
    if sheet is not None and (folded is not None or _opens(path, frame, sheet)):
        return _chosen(title, frame, sheet, [] if folded is None else [folded], 1, findings)
    if folded is not None:
        coords = frame_coords(path, frame, "flat sheet")
        raise InvalidFile(
            f"{path}: no flat frame: its z runs over {np.ptp(coords[:, 2]):.6g}. Give the flat "
            "sheet first."
        )
    return _of_folded(path, title, [frame], findings)


def _classless(frames: list[_Frame]) -> list[int]:
    """Frames with points that are neither of class creasePattern nor of class foldedForm."""
    return [
        number
        for number, frame in enumerate(frames)
        if "vertices_coords" in frame
        and not (_is(frame, "creasePattern") or _is(frame, "foldedForm"))
    ]


def _flat_frames(path: Path, frames: list[_Frame]) -> list[int]:
    """The frames that are flat and open, where none is of class creasePattern.

    The first of them need not be open: it is what was drawn. Others that cannot be read are none.
    """
    first, *others = _classless(frames) or [-1]
    if first < 0:
        return []
    found = [] if _flat(path, frames[first]) is None else [first]
    for number in others:
        with suppress(InvalidFile):
            sheet = _flat(path, frames[number])
            if sheet is not None and _opens(path, frames[number], sheet):
                found.append(number)
    return found


def _left_out(frames: list[_Frame], number: int, others: list[int]) -> list[Finding]:
    """The finding of frames of other classes that say anything else than the sheet."""
    if not others:
        return []
    compared = sheet_frames(frames, [number, *others])
    lost = [n for n in others if not compared.says_all_of(number, compared.same[n])]
    if not lost:
        return []
    first = f"file_frames[{lost[0] - 1}]" if lost[0] else "the outermost frame"
    more = len(lost) - 1
    which = f"{first} is" if not more else f"{first} and {counted(more, 'other frame')} are"
    text = (
        f"{which} neither of class creasePattern nor of class foldedForm, and left out. Give one "
        "of these classes to what is to be read."
    )
    return [Finding("frames-left-out", Severity.NOTE, text)]


def _without_sheet(path: Path, title: str, frames: list[_Frame], options: ReadOptions) -> Frames:
    """The flat sheet where no frame is one but for folded forms."""
    if options.frame not in (None, 1):
        raise InvalidFile(
            f"{path}: --frame {options.frame}: the file has 1 crease pattern. Give 1."
        )
    others = _classless(frames)
    forms = [
        number
        for number, frame in enumerate(frames)
        if "vertices_coords" in frame and _is(frame, "foldedForm")
    ]
    if not (others or forms):
        frame_coords(path, frames[0], "crease pattern")  # says what is missing
    folded = [frames[number] for number in forms]
    for number, frame in zip(forms, folded, strict=True):
        sheet = _flat(path, frame)
        if sheet is None or not _opens(path, frame, sheet):
            continue
        text = "a frame of class foldedForm is flat: it is taken for the crease pattern."
        findings = [Finding("flat-form-taken", Severity.NOTE, text)]
        findings += _left_out(frames, number, others)
        rest = [other for other in folded if other is not frame]
        return _chosen(title, frame, sheet, rest, 1, findings)
    if forms:
        return _of_folded(path, title, folded, _left_out(frames, forms[0], others))
    first, *behind = others
    return _of_folded(path, title, [frames[first]], _left_out(frames, first, behind))


def _of_folded(path: Path, title: str, folded: list[_Frame], findings: list[Finding]) -> Frames:
    """The flat sheet that the first of some folded forms unfolds into."""
    frame = folded[0]
    coords = frame_coords(path, frame, "folded form")
    if not frame.get("faces_vertices"):
        raise InvalidFile(
            f"{path}: no flat frame: every frame is a folded form, and without faces it cannot be "
            "unfolded. Give a frame of class creasePattern with flat coordinates."
        )
    corners, offsets = frame_faces(path, frame["faces_vertices"], len(coords))
    pairs = frame_pairs(path, frame, len(coords))
    letters = [str(letter).upper() for letter in frame_list(path, frame, "edges_assignment", [])]
    cut = np.array([letter == "C" for letter in letters], bool)
    cuts = pairs[cut] if len(cut) == len(pairs) else pairs[:0]
    if len(pairs):
        lacking = np.setdiff1d(pairs, corners)
        if len(lacking):
            raise InvalidFile(
                f"{path}: no flat frame: vertex {lacking[0]} of the folded form has edges but no "
                "face, so that it cannot be unfolded. Give the flat sheet."
            )
    flat = unfolded(path, coords, corners, offsets, cuts)
    text = (
        "every frame is a folded form: it was unfolded into its crease pattern, "
        f"{np.ptp(flat[:, 0]):.6g} x {np.ptp(flat[:, 1]):.6g} units large."
    )
    found = [*findings, Finding("unfolded", Severity.NOTE, text)]
    return _chosen(title, frame, FlatSheet(flat, "", False), folded, 1, found)


def _chosen(
    title: str,
    flat: _Frame,
    sheet: FlatSheet,
    folded: list[_Frame],
    patterns: int,
    findings: list[Finding],
) -> Frames:
    """Frames with the folded form apart from other states, and findings about the sheet's plane."""
    if sheet.plane:
        findings = [*findings, Finding("frame-turned", Severity.NOTE, sheet.plane)]
    if sheet.side_assumed:
        text = (
            "no faces say which side of the sheet is the upper one: mountains may be valleys. Give "
            "the file with its faces, or a sheet in the plane of x and y."
        )
        findings = [*findings, Finding("side-assumed", Severity.WARNING, text)]
    folded = [frame for frame in folded if frame is not flat or sheet.coords is not None]
    final = next((frame for frame in folded if STATE_KEY not in frame), None)
    states = tuple(frame for frame in folded if frame is not final)
    return Frames(title, flat, sheet.coords, final, states, patterns, tuple(findings))


def _flat(path: Path, frame: _Frame) -> FlatSheet | None:
    """The sheet of a frame in its plane, None where it is in none."""
    coords = frame_coords(path, frame, "crease pattern")
    return flat_sheet(coords, _faces_or_none(path, frame, len(coords)))


def _opens(path: Path, frame: _Frame, sheet: FlatSheet) -> bool:
    count = len(sheet.coords)
    return is_open(
        sheet.coords, _faces_or_none(path, frame, count), frame_pairs(path, frame, count)
    )


def _faces_or_none(path: Path, frame: _Frame, count: int) -> tuple[IntArray, IntArray] | None:
    rows = frame.get("faces_vertices")
    return frame_faces(path, rows, count) if rows else None


def _is(frame: _Frame, wanted: str) -> bool:
    return wanted in frame.get("frame_classes", [])


def _which(sheets: SheetFrames, number: int) -> str:
    """Which of several crease patterns is read, and how the others are."""
    first = sheets.numbers[0]
    if number == first:
        return "the first is read. Give --frame 2 for the second, and so on."
    added = ", ".join(sheets.added(number, first))
    return (
        f"number {sheets.numbers.index(number) + 1} is read, which is the first with {added} "
        "besides. Give --frame 1 for the first, and so on."
    )


def _belongs(sheets: SheetFrames, own: int | None, number: int) -> bool:
    """Whether a folded form of the crease pattern `own`, None for any, is one of `number` too."""
    return own is None or sheets.says_all_of(number, own)


def _sheet_of(raw: list[_Frame], number: int, sheets: dict[int, int]) -> int | None:
    """The crease pattern that a frame inherits from; None where it inherits from none."""
    while number not in sheets:
        if number == 0 or not raw[number].get("frame_inherit"):
            return None
        number = raw[number].get("frame_parent", 0)
    return sheets[number]


def _text(value: object) -> str:
    """A title of a file without what cannot be printed."""
    return plain_title(value) if isinstance(value, str) else ""


def frame_title(frame: _Frame) -> str:
    """The title of a frame, empty where it has none, without what cannot be printed."""
    return _text(frame.get("frame_title"))


def _load(path: Path) -> dict[str, Any]:
    require_file(path, InvalidFile, "Give the path of a FOLD file.")
    return read_json(path, LARGEST_BYTES)


def frame_list(path: Path, frame: dict[str, Any], key: str, default: list[Any]) -> list[Any]:
    """A list of a frame by its key. Raises `InvalidFile` where it is something else."""
    value = frame.get(key, default)
    if not isinstance(value, list):
        raise InvalidFile(f"{path}: {key} must be a list.")
    return value


def _resolved(path: Path, frames: list[Any]) -> list[dict[str, Any]]:
    """All frames with what they inherit from their parents laid below them."""
    done: dict[int, dict[str, Any]] = {}
    for start in range(len(frames)):
        chain = []
        index = start
        while index not in done:
            frame = frames[index]
            if not isinstance(frame, dict):
                raise InvalidFile(f"{path}: frame {index} must be an object.")
            classes = frame.get("frame_classes", [])
            if not isinstance(classes, list):
                raise InvalidFile(f"{path}: frame_classes of frame {index} must be a list.")
            chain.append(index)
            if index == 0 or not frame.get("frame_inherit"):
                break
            parent = frame.get("frame_parent", 0)
            if type(parent) is not int or not 0 <= parent < len(frames) or parent in chain:
                raise InvalidFile(f"{path}: frame_parent {parent} does not name another frame.")
            index = parent
        for index in reversed(chain):
            own = {key: value for key, value in frames[index].items() if key != "file_frames"}
            inherits = index != 0 and frames[index].get("frame_inherit")
            above = done[frames[index].get("frame_parent", 0)] if inherits else {}
            done[index] = {**above, **own}
    return [done[index] for index in range(len(frames))]


def frame_coords(path: Path, frame: dict[str, Any], what: str) -> FloatArray:
    """The points of a frame, shape (nv, 3); z = 0 where they are plane."""
    rows = frame_list(path, frame, "vertices_coords", [])
    found = number_rows(rows)
    if rows and found.dtype.kind not in "iuf":
        raise InvalidFile(
            f"{path}: vertices_coords of the {what} must be numbers, all points alike in length."
        )
    coords = found.astype(np.float64)
    if coords.ndim != 2 or coords.shape[1] not in (2, 3) or len(coords) < 3:
        raise InvalidFile(
            f"{path}: vertices_coords of the {what} must hold at least 3 points of 2 or 3 numbers."
        )
    require_range(path, coords, what)
    return coords if coords.shape[1] == 3 else np.pad(coords, ((0, 0), (0, 1)))


def frame_pairs(path: Path, frame: dict[str, Any], count: int) -> IntArray:
    """edges_vertices whose vertices run up to `count`, shape (ne, 2)."""
    rows = frame_list(path, frame, "edges_vertices", [])
    pairs: IntArray = number_rows(rows)
    if rows and (pairs.shape != (len(rows), 2) or pairs.dtype.kind != "i"):
        for number, row in enumerate(rows):
            if not isinstance(row, list) or len(row) != 2 or any(type(v) is not int for v in row):
                raise InvalidFile(f"{path}: edge {number} must have two vertex numbers.")
        pairs = np.array([[min(max(v, -1), count) for v in row] for row in rows])
    pairs = pairs.reshape(-1, 2)
    bad = np.flatnonzero(((pairs < 0) | (pairs >= count)).any(axis=1))
    if len(bad):
        raise InvalidFile(
            f"{path}: edge {bad[0]} names the vertices {rows[bad[0]]}; vertices run from "
            f"0 to {count - 1}."
        )
    return pairs.astype(np.int64)


def frame_faces(path: Path, faces: Any, count: int) -> tuple[IntArray, IntArray]:
    """Corners and offsets of faces_vertices whose vertices run up to `count`.

    Where a face runs along an edge that ends within it, forth and back, that edge is left out.
    """
    if not isinstance(faces, list) or not faces:
        raise InvalidFile(f"{path}: faces_vertices must be a list of at least one face.")
    rings = []
    for number, face in enumerate(faces):
        if not isinstance(face, list) or len(face) < 3:
            raise InvalidFile(f"{path}: face {number} must have at least 3 corners.")
        for v in face:
            if not isinstance(v, int) or isinstance(v, bool) or not 0 <= v < count:
                raise InvalidFile(
                    f"{path}: face {number} names vertex {v}; vertices run from 0 to {count - 1}."
                )
        ring = face if len(set(face)) == len(face) else _without_spikes(face)
        if len(ring) < 3 or len(set(ring)) != len(ring):
            raise InvalidFile(
                f"{path}: face {number} passes a vertex twice. Divide it by an edge of assignment "
                "J, or leave faces_vertices out."
            )
        rings.append(ring)
    offsets = np.concatenate([[0], np.cumsum([len(ring) for ring in rings])])
    return np.array([v for ring in rings for v in ring], np.int64), offsets.astype(np.int64)


def _without_spikes(ring: list[int]) -> list[int]:
    """A walk around a face without what it runs forth and back, such as 1 in 0 1 0."""
    out: list[int] = []
    for vertex in ring:
        if len(out) > 1 and out[-2] == vertex:
            out.pop()
        elif not out or out[-1] != vertex:
            out.append(vertex)
    while len(out) > 2:  # the same over the first corner
        if out[-1] == out[0]:
            out = out[:-1]
        elif out[-1] == out[1]:
            out = out[1:-1]
        elif out[-2] == out[0]:
            out = out[:-2]
        else:
            break
    return out
