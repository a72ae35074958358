"""Which elements of an SVG file are meant for this reader: alternatives, languages and extensions.

The language is English whatever that of the computer: a file is the same pattern everywhere.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence

__all__ = ["chosen_of", "is_meant"]

_LANGUAGE = "en"
# Every feature that SVG 1.1 names; SVG 2 no longer has them.
_FEATURES = ("http://www.w3.org/tr/svg11/feature#", "org.w3c.")


def is_meant(element: ET.Element) -> bool:
    """Whether the conditions of an element hold, as they do where it has none.

    No extension of SVG is known. Of languages one must be English, as en or en-GB are.
    """
    get = element.attrib.get
    if get("requiredExtensions") is not None:
        return False
    if not all(map(_is_feature, (get("requiredFeatures") or "").split())):
        return False
    languages = get("systemLanguage")
    return languages is None or any(map(_is_spoken, languages.split(",")))


def chosen_of(alternatives: Sequence[ET.Element]) -> ET.Element | None:
    """The one of the children of a switch that is drawn: the first that is meant."""
    return next(filter(is_meant, alternatives), None)


def _is_feature(name: str) -> bool:
    return name.lower().startswith(_FEATURES)


def _is_spoken(language: str) -> bool:
    return language.strip().lower().partition("-")[0] == _LANGUAGE
