"""What a user should know of the layers of a sheet that is folded flat."""

from __future__ import annotations

from fab.errors import Finding, Severity, counted, first_few
from fab.layers.layer_orders import FoldsFlat, LayerOrders

__all__ = ["inspect_layers", "layers_text"]

# A text names up to this many faces.
_SHOWN = 12
_MANY = 1_000_000


def layers_text(layers: LayerOrders) -> str:
    """Such as "folds flat: yes, its layers have 4 orders".

    >>> layers_text(LayerOrders(FoldsFlat.NO, states=0, faces=(2, 5, 7)))
    'folds flat: no, because of faces 2, 5 and 7'
    """
    if layers.folds_flat is FoldsFlat.UNDECIDED:
        return f"folds flat: undecided, {layers.reason}"
    if layers.folds_flat is FoldsFlat.NO:
        because = f", because of {_faces(layers.faces)}" if layers.faces else ""
        return f"folds flat: no{because}"
    assert layers.states is not None
    number = f"{layers.states:.3g}" if layers.states > _MANY else str(layers.states)
    least = "" if layers.states_exact else "at least "
    return f"folds flat: yes, its layers have {least}{number} order{'s' if number != '1' else ''}"


def inspect_layers(layers: LayerOrders | None) -> list[Finding]:
    """Findings where layers have no order, where that is not known, and where a file's is wrong."""
    if layers is None:
        return []
    if layers.folds_flat is FoldsFlat.UNDECIDED:
        text = (
            f"whether the sheet can lie flat is undecided: {layers.reason}. Its layers may pass "
            "through each other when it is folded."
        )
        return [Finding("layers-undecided", Severity.WARNING, text)]
    if layers.folds_flat is FoldsFlat.NO:
        return [_no_order(layers)]
    if layers.given is False:
        of = f" of {_faces(layers.given_faces)}" if layers.given_faces else ""
        text = (
            f"the faceOrders of the file{of} contradict each other or the letters of creases, so "
            "that a sheet would pass through itself: another order of its layers is taken."
        )
        panels = first_few(layers.given_faces)
        return [Finding("face-orders-contradict", Severity.WARNING, text, panels=panels)]
    return []


def _no_order(layers: LayerOrders) -> Finding:
    if layers.faces:
        because = (
            f": {_faces(layers.faces)} alone cannot be put in layers, whatever the others do. "
            "Change the letters of creases between them, or what lies under them."
        )
    else:
        because = "; the faces at fault were not found in time."
    text = (
        f"the sheet cannot lie flat: in every order of its layers it passes through itself{because}"
    )
    return Finding("cannot-lie-flat", Severity.ERROR, text, panels=first_few(layers.faces))


def _faces(faces: tuple[int, ...]) -> str:
    """Such as "faces 2, 5 and 7"; of many, the first few and how many there are."""
    if len(faces) > _SHOWN:
        first = ", ".join(map(str, faces[:_SHOWN]))
        return f"{counted(len(faces), 'face')} ({first}, …)"
    *others, last = map(str, faces)
    return f"faces {', '.join(others)} and {last}" if others else f"face {last}"
