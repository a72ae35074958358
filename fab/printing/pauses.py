"""The pause of a print in which a film or fabric is laid into its panels."""

from __future__ import annotations

from dataclasses import dataclass

from fab.errors import Finding, Severity
from fab.panels.thick_sheet import ThickSheet

__all__ = ["Pause", "film_pause", "inspect_pause"]

# Shares of a layer that are rounding.
_WHOLE = 1e-6


@dataclass(frozen=True)
class Pause:
    """Where a print is to pause: above a height over the bed, after so many layers.

    Attributes
    ----------
    z_mm : height of what is printed before. after_layer : the number of the last layer before it,
    counted from 1. layer_mm : height of all layers. off_mm : how far the film lies below the middle
    of the panels; negative above it.
    """

    z_mm: float
    after_layer: int
    layer_mm: float
    off_mm: float

    @property
    def next_mm(self) -> float:
        """Height of the layer that follows."""
        return round(self.z_mm + self.layer_mm, 6)


def film_pause(sheet: ThickSheet, layer_mm: float) -> Pause | None:
    """The pause for the film of a sheet, at the whole layer below the middle of its panels.

    None where nothing is laid in.
    """
    if not sheet.laid.any():
        return None
    low, high = sheet.panels.heights_mm
    middle = (high - low) / 2
    layers = max(1, int(middle / layer_mm + _WHOLE))
    z = round(layers * layer_mm, 6)
    return Pause(z, layers, layer_mm, round(middle - z, 6))


def inspect_pause(sheet: ThickSheet, pause: Pause) -> list[Finding]:
    """What there is to do in the pause, and findings about it."""
    film = sheet.hinge.film_mm
    text = (
        f"pause the print at z = {pause.z_mm:g} mm, after layer {pause.after_layer} of "
        f"{pause.layer_mm:g} mm. Lay in a film or fabric of film_mm = {film:g}, larger than the "
        "sheet, fix it to the bed beside it, and go on. The 3MF file asks PrusaSlicer for the "
        "pause; set it by hand in other slicers. Cut the film along the outline in the end."
    )
    findings = [Finding("pause-for-film", Severity.NOTE, text)]
    if abs(pause.off_mm) > _WHOLE:
        where = "below" if pause.off_mm > 0 else "above"
        findings.append(
            Finding(
                "film-off-middle",
                Severity.NOTE,
                f"the film lies {abs(pause.off_mm):.3g} mm {where} the middle of its panels, at a "
                f"whole layer. Set thickness_mm to a multiple of {2 * pause.layer_mm:g}.",
            )
        )
    if film > pause.layer_mm * (1 + _WHOLE):
        findings.append(
            Finding(
                "film-too-thick",
                Severity.WARNING,
                f"film_mm = {film:g} is more than a layer of layer_mm = {pause.layer_mm:g}: the "
                "nozzle would catch it. Take a thinner film or an open fabric, or thicker layers.",
            )
        )
    return findings
