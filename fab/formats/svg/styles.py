"""Style of SVG elements: presentation attributes, style sheets within the file, style attributes.

No style sheet of another file is read.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

__all__ = ["PROPERTIES", "Sheets", "local_name", "style_sheets"]

# What a reader of lines needs to know, and whether children inherit it.
PROPERTIES = {
    "clip-path": False,
    "color": True,
    "display": False,
    "fill": True,
    "mask": False,
    "opacity": False,
    "stroke": True,
    "stroke-opacity": True,
    "stroke-width": True,
    "rotate": False,
    "scale": False,
    "transform": False,
    "transform-box": False,
    "transform-origin": False,
    "translate": False,
    "visibility": True,
}
# An attribute of this name is no property: it has another grammar.
_ATTRIBUTES = tuple(name for name in PROPERTIES if name != "transform")
# Selectors of more parts could take very long to match.
_MOST_PARTS = 4
_MOST_RULES = 5_000
_DIGITS, _MOST_DIGITS = re.compile(r"\d+"), 1000
_SVG = "{http://www.w3.org/2000/svg}"

# Value and whether it is important, by property.
_Declarations = Mapping[str, tuple[str, bool]]


def local_name(element: ET.Element) -> str:
    """The name of an SVG element; empty for elements of other kinds, comments and instructions."""
    tag = element.tag
    if not isinstance(tag, str):
        return ""
    if tag.startswith(_SVG):
        return tag[len(_SVG) :]
    return "" if tag.startswith("{") else tag


class Sheets:
    """The style sheets of a file.

    Attributes
    ----------
    skipped : how many rules were left out: imports of other files and selectors not understood.
    """

    def __init__(
        self, rules: Mapping[ET.Element, list[tuple[tuple[int, ...], _Declarations]]], skipped: int
    ) -> None:
        self._rules = rules
        self.skipped = skipped

    def of(self, element: ET.Element) -> dict[str, str]:
        """The properties that are declared for an element itself, after the order of CSS.

        Its transform is that of CSS alone.
        """
        get = element.attrib.get
        found = {name: value for name in _ATTRIBUTES if (value := get(name)) is not None}
        rules = self._rules.get(element)
        inline = get("style")
        if rules is None:
            if inline:
                for name, (value, _) in _declarations(inline).items():
                    found[name] = value
            return found
        important: dict[str, str] = {}
        for _, declarations in sorted(rules, key=lambda rule: rule[0]):
            for name, (value, strong) in declarations.items():
                (important if strong else found)[name] = value
        for name, (value, strong) in _declarations(inline or "").items():
            (important if strong else found)[name] = value
        return found | important


def style_sheets(root: ET.Element) -> Sheets:
    """The style sheets of all style elements of a file."""
    texts = ["".join(e.itertext()) for e in root.iter() if local_name(e) == "style"]
    if not any(text.strip() for text in texts):
        return Sheets({}, 0)
    import cssselect2
    import tinycss2

    matcher: Any = cssselect2.Matcher()
    skipped = kept = 0
    for text in map(_with_short_numbers, texts):
        for rule in tinycss2.parse_stylesheet(text, skip_comments=True, skip_whitespace=True):
            if rule.type == "at-rule":
                skipped += rule.lower_at_keyword in ("import", "layer", "media", "supports")
            if rule.type != "qualified-rule":
                continue
            declarations = _of_tokens(rule.content)
            if not declarations:
                continue
            try:
                listed = tinycss2.serialize(rule.prelude)
                selectors = cssselect2.compile_selector_list(rule.prelude)
            except (cssselect2.SelectorError, RecursionError):
                skipped += 1
                continue
            if kept >= _MOST_RULES or _parts(listed) > _MOST_PARTS:
                skipped += 1
                continue
            kept += 1
            for selector in selectors:
                if selector.pseudo_element is None and not selector.never_matches:
                    matcher.add_selector(selector, declarations)
    rules: dict[ET.Element, list[tuple[tuple[int, ...], _Declarations]]] = {}
    for wrapper in cssselect2.ElementWrapper.from_xml_root(root).iter_subtree():
        found = [
            ((*specificity, order), declarations)
            for specificity, order, _, declarations in matcher.match(wrapper)
        ]
        if found:
            rules[wrapper.etree_element] = found
    return Sheets(rules, skipped)


def _parts(selectors: str) -> int:
    """How many simple selectors the longest of a list has between combinators, about."""
    parts = (re.split(r"\s*[>+~]\s*|\s+", part.strip()) for part in selectors.split(","))
    return max(map(len, parts))


@lru_cache(maxsize=4096)
def _declarations(text: str) -> _Declarations:
    import tinycss2

    if "(" not in text and "/" not in text and '"' not in text and "\\" not in text:
        out = {}
        for entry in text.split(";"):
            name, colon, value = entry.partition(":")
            name = name.strip().lower()
            if colon and name in PROPERTIES:
                plain = value.strip()
                strong = plain.lower().endswith("!important")
                out[name] = (plain[: -len("!important")].strip() if strong else plain, strong)
        return out
    return _of_tokens(tinycss2.parse_component_value_list(_with_short_numbers(text)))


def _with_short_numbers(text: str) -> str:
    """The text without digits beyond those that tinycss2 takes: such numbers are infinite."""
    return _DIGITS.sub(lambda found: found[0][:_MOST_DIGITS], text)


def _of_tokens(tokens: Any) -> _Declarations:
    import tinycss2

    out: dict[str, tuple[str, bool]] = {}
    for node in tinycss2.parse_blocks_contents(tokens, skip_comments=True, skip_whitespace=True):
        if node.type == "declaration" and node.lower_name in PROPERTIES:
            try:
                value = tinycss2.serialize(node.value).strip()
            except RecursionError:
                continue
            out[node.lower_name] = (value, bool(node.important))
    return out
