"""Steps of an assembly in words: cut, crease, join what lies side by side, fold, close the rest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from fab.errors import counted
from fab.viewing.assembly.parts import Assembly, Hold, Joint, Model, Motion

__all__ = [
    "WrittenStep",
    "fold_text",
    "hold_text",
    "listed",
    "numbers_text",
    "written_steps",
]

_FLAT_DEG = 0.5


@dataclass(frozen=True)
class WrittenStep:
    """A step in words.

    Attributes
    ----------
    pieces : that are joined, the last one to the others, as the step's small map shows them.
    joined : all pieces that are in one from then on, as the small view of the form shows them.
    labels : of the seams that are glued.
    """

    title: str
    text: str
    pieces: tuple[int, ...] = ()
    joined: tuple[int, ...] = ()
    labels: tuple[int, ...] = ()


def written_steps(model: Model, assembly: Assembly) -> list[WrittenStep]:
    """All steps of a model, in order."""
    flat = [joint for joint in model.joints if not joint.closing]
    closing = [joint for joint in model.joints if joint.closing]
    steps = [_cut(model, assembly), *_creased(model)]
    done: set[int] = set()
    for later, joints in groupby(flat, lambda joint: max(joint.pieces)):
        done |= {later}
        steps.append(_joined(model, later, list(joints), done))
    steps += _folded(model)
    for pair, joints in groupby(closing, lambda joint: tuple(sorted(joint.pieces))):
        done |= set(pair)
        steps.append(_closed(model, pair, list(joints), done))
    if model.points:
        text = (
            f"The rims of the sheets meet at {counted(len(model.points), 'numbered point')}: "
            "glue each to the one with the same number on the other sheet, in the order of the "
            "numbers. Strips of paper on the lower side hold what is between them."
        )
        steps.append(WrittenStep("Join the sheets at their points", text))
    return steps


def _cut(model: Model, assembly: Assembly) -> WrittenStep:
    sheets = sum(len(sheet.numbers) for sheet in assembly.sheets)
    text = f"Cut {counted(sheets, 'sheet')}"
    if model.copies > 1:
        text += f", for {model.copies} copies of the model: what follows is for each of them"
    text += "."
    several = len(model.pieces) > 1
    if model.total > len(model.pieces):
        text += f" {model.name} is {_names(model)}."
    text += "".join(f" {sentence}" for sentence in assembly.cutting)
    if assembly.face_down:
        text += " Sheets are cut face down: turn the pieces over, and the upper side is up."
    elif several:
        text += " Lay the pieces out with their letters up: that is the upper side."
    elif model.joints:
        text += " The side with the numbers is the upper side."
    bare = [piece.name for piece in model.pieces if not piece.lettered]
    if bare and several:
        text += f" {listed(bare)} had no room for letters: write them on by the map of the sheets."
    return WrittenStep("Cut", text)


def _names(model: Model) -> str:
    """Such as "piece C" or "pieces C to F"."""
    first, last = model.pieces[0].name, model.pieces[-1].name
    return f"piece {first}" if first == last else f"pieces {first} to {last}"


def _creased(model: Model) -> list[WrittenStep]:
    pattern = model.pattern
    letters = pattern.edges_assignment
    counts = {letter: int((letters == letter).sum()) for letter in "MVU"}
    if not sum(counts.values()):
        return []
    kinds = [
        f"{counted(counts['M'], 'mountain')} away from you" if counts["M"] else "",
        f"{counted(counts['V'], 'valley')} towards you" if counts["V"] else "",
        f"{counted(counts['U'], 'crease')} without a direction" if counts["U"] else "",
    ]
    angles = np.abs(pattern.edges_foldAngle[np.isin(letters, ["M", "V"])])
    how = "Fold each crease once to its angle and open it again"
    if model.joints:
        how += ", before anything is joined"
    text = f"{how}: {listed([kind for kind in kinds if kind])}, seen from the upper side."
    angles = angles[angles > _FLAT_DEG]
    if len(angles):
        low, high = round(float(angles.min())), round(float(angles.max()))
        text += f" They end at {low}°." if low == high else f" They end at {low}° to {high}°."
        text += " 0° is flat, 180° folded over." if high < 179 else " 180° is folded over."
    return [WrittenStep("Crease", text)]


def _joined(model: Model, later: int, joints: Sequence[Joint], done: set[int]) -> WrittenStep:
    """A piece joined to those before it, all flat."""
    others = sorted({piece for joint in joints for piece in joint.pieces} - {later})
    done |= set(others)
    names = [model.pieces[piece].name for piece in others]
    name = model.pieces[later].name
    text = (
        f"{_seams(joints).capitalize()}, while all lies flat, upper side up. {_held(model, joints)}"
    )
    labels = tuple(joint.label for joint in joints)
    return WrittenStep(
        f"Join {name} to {listed(names)}", text, (*others, later), tuple(sorted(done)), labels
    )


def _folded(model: Model) -> list[WrittenStep]:
    letters = model.pattern.edges_assignment
    if not np.isin(letters, ["M", "V", "U"]).any():
        return []
    text = {
        Motion.TOGETHER: "Faces stay flat on the way: all creases move together, and none has to "
        "be forced.",
        Motion.RIGID: "Faces stay flat on the way, and no crease has to be forced.",
        Motion.BENDS: "Faces bend a little on the way: fold everywhere a little, again and again, "
        "rather than one crease after another.",
        Motion.UNKNOWN: "Fold everywhere a little, again and again, until all creases have their "
        "angles, rather than one crease after another.",
    }[model.motion]
    return [WrittenStep("Fold", text)]


def _closed(
    model: Model, pair: tuple[int, ...], joints: Sequence[Joint], done: set[int]
) -> WrittenStep:
    """Edges that come together when the sheet is folded."""
    names = sorted({model.pieces[piece].name for piece in pair}, key=lambda n: (len(n), n))
    what = f"Close {names[0]}" if len(names) == 1 else f"Join {names[1]} to {names[0]}"
    where = (
        "come together as the sheet folds"
        if len(joints) > 1
        else "comes together as the sheet folds"
    )
    text = f"{_seams(joints).capitalize()} {where}. {_held(model, joints)}"
    labels = tuple(joint.label for joint in joints)
    return WrittenStep(what, text, tuple(dict.fromkeys(pair)), tuple(sorted(done)), labels)


def _seams(joints: Sequence[Joint]) -> str:
    numbers = numbers_text(joint.label for joint in joints)
    return f"seam {numbers}" if len(joints) == 1 else f"seams {numbers}"


def _held(model: Model, joints: Sequence[Joint]) -> str:
    """What holds seams together, in sentences."""
    sentences = [*_tabs(model, joints)]
    for hold, text in _OTHERS.items():
        own = [joint for joint in joints if joint.hold is hold]
        if own:
            which, at = numbers_text(joint.label for joint in own), ""
            if len(own) == len(joints):
                which = "it" if len(own) == 1 else "them"
            else:
                at = f" at {which}"
            sentences.append(text.format(which=which, at=at))
    return " ".join(sentences)


# What is done with seams that no tab of one side holds.
_OTHERS = {
    Hold.TABS: "Fold the tabs of both sides behind the sheet and glue them onto each other{at}.",
    Hold.STITCHES: "Sew {which} through the holes of both sides.",
    Hold.TAPE: "Tape {which} on the lower side.",
}


def _tabs(model: Model, joints: Sequence[Joint]) -> list[str]:
    """Which tabs and tongues of which piece go where."""
    held: dict[tuple[Hold, int, int], list[int]] = {}
    for joint in joints:
        if joint.holder is not None and joint.hold in (Hold.TAB, Hold.TONGUE):
            first, second = joint.pieces
            other = second if joint.holder == first else first
            held.setdefault((joint.hold, joint.holder, other), []).append(joint.label)
    told: dict[Hold, list[str]] = {}
    for (hold, holder, other), labels in held.items():
        names = model.pieces[holder].name, model.pieces[other].name
        noun = "tab" if hold is Hold.TAB else "tongue"
        things = f"the {noun}" if len(labels) == 1 else f"the {noun}s"
        at = "" if len(labels) == len(joints) else f" at {numbers_text(labels)}"
        if hold is Hold.TAB:
            own = "under its other edge" if len(labels) == 1 else "under its other edges"
            where = own if holder == other else f"under {names[1]}"
        else:
            slots = "slot" if len(labels) == 1 else "slots"
            where = (
                f"into its own {slots}" if holder == other else f"into the {slots} of {names[1]}"
            )
        told.setdefault(hold, []).append(f"{things} of {names[0]} {where}{at}")
    verbs = {Hold.TAB: "Glue", Hold.TONGUE: "Put"}
    return [f"{verbs[hold]} {listed(words)}." for hold, words in told.items()]


def hold_text(model: Model, joint: Joint) -> str:
    """What holds a seam, in a few words for a table."""
    if joint.holder is not None and joint.hold in (Hold.TAB, Hold.TONGUE):
        noun = "tab" if joint.hold is Hold.TAB else "tongue"
        return f"{noun} of {model.pieces[joint.holder].name}"
    if joint.hold is Hold.STITCHES:
        return counted(joint.stitches, "stitch", "stitches")
    return "two tabs" if joint.hold is Hold.TABS else "tape"


def fold_text(angle_deg: float) -> str:
    """The fold of a seam.

    >>> fold_text(90.04), fold_text(-2.34), fold_text(0.0)
    ('valley 90°', 'mountain 2.3°', 'flat')
    """
    if abs(angle_deg) < _FLAT_DEG / 10:
        return "flat"
    digits = 0 if abs(angle_deg) >= 10 else 1
    return f"{'valley' if angle_deg > 0 else 'mountain'} {abs(angle_deg):.{digits}f}°"


def listed(words: Sequence[str]) -> str:
    """Such as "A, B and C".

    >>> listed(["A"]), listed(["A", "B", "C"])
    ('A', 'A, B and C')
    """
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]


def numbers_text(numbers: Iterable[int]) -> str:
    """Such as "1 to 4, 7 and 8", of numbers that rise.

    >>> numbers_text([1, 2, 3, 4, 7, 8]), numbers_text([5]), numbers_text([1, 3, 4, 5])
    ('1 to 4, 7 and 8', '5', '1 and 3 to 5')
    """
    every = sorted(numbers)
    runs: list[list[int]] = []
    for number in every:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    words = []
    for run in runs:
        words += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else [str(number) for number in run]
    return listed(words)
