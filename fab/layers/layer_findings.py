"""What a user should know of the layers of a sheet that is folded flat."""

from __future__ import annotations

from fab.errors import Finding, Severity, counted, first_few
from fab.layers.layer_orders import FoldsFlat, LayerOrders, named

__all__ = ["inspect_layers"]


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
        of = f" of {named(layers.given_faces)}" if layers.given_faces else ""
        text = (
            f"the faceOrders of the file{of} contradict each other or the letters of creases, so "
            "that a sheet would pass through itself: they are left out."
        )
        panels = first_few(layers.given_faces)
        return [Finding("face-orders-contradict", Severity.WARNING, text, panels=panels)]
    return []


def _no_order(layers: LayerOrders) -> Finding:
    if layers.faces:
        because = (
            f": {named(layers.faces)} alone cannot be put in layers, whatever the others do. "
            "Change the letters of creases between them, or what lies under them."
        )
    else:
        because = "; the faces at fault were not found in time."
    text = (
        f"the sheet cannot lie flat: in every order of its layers it passes through itself{because}"
    )
    severity = Severity.ERROR
    if layers.assumed:
        severity = Severity.WARNING
        text += (
            f" This is with {counted(layers.assumed, 'crease')} of unknown angle folded by 180 "
            "degrees, to either side."
        )
    return Finding("cannot-lie-flat", severity, text, panels=first_few(layers.faces))
