"""What does a person say of a thick sheet: its panels, its hinges?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import model_validator

from fab.hinges import HingeSettings
from fab.panels import PanelSettings
from fab.settings import Settings, apply_change, checked

__all__ = ["ThickSettings", "thick_settings"]


class ThickSettings(Settings):
    """The tables of a thick sheet, in a job and on the command line."""

    panels: PanelSettings = PanelSettings()
    hinges: HingeSettings = HingeSettings()

    @model_validator(mode="after")
    def _web_below_panel(self) -> ThickSettings:
        if self.hinges.web_mm >= self.panels.thickness_mm:
            raise ValueError(
                f"hinges.web_mm = {self.hinges.web_mm:g} must be below panels.thickness_mm = "
                f"{self.panels.thickness_mm:g}: a web is thinner than its panels"
            )
        return self


def thick_settings(changes: Sequence[str]) -> ThickSettings:
    """The defaults with changes such as "panels.thickness_mm=1.2" laid over them.

    Raises `InvalidJob` with every key at fault.
    """
    document: dict[str, Any] = {}
    for change in changes:
        apply_change(document, change)
    return checked(ThickSettings, document, "--set", "Give its table and key, with its unit.")
