"""Level of detail: what pages leave out of large sheets to stay usable, and how they say so."""

from __future__ import annotations

__all__ = ["MANY_FACES", "detail_note", "states_between"]

# Of more faces, software draws a few pictures a second, and each state takes a second or more.
MANY_FACES = 20_000
_BETWEEN, _BETWEEN_OF_MANY = 9, 2


def states_between(faces: int) -> int:
    """States that are shown between the flat sheet and its folded form.

    >>> states_between(1000), states_between(76_000)
    (9, 2)
    """
    return _BETWEEN if faces <= MANY_FACES else _BETWEEN_OF_MANY


def detail_note(faces: int) -> str:
    """What a page says of what it leaves out; nothing where it shows everything.

    >>> detail_note(20_000)
    ''
    """
    if faces <= MANY_FACES:
        return ""
    return (
        f"{faces} faces: lines of the folded form are off until they are asked for, and it has "
        f"{_BETWEEN_OF_MANY} states between flat and folded here. Files leave out nothing."
    )
