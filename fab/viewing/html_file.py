"""HTML files that need nothing else: style, scripts and data within, and nothing is loaded."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

__all__ = ["Script", "html_file"]

_POLICY = (
    "default-src 'none'; script-src {scripts}; style-src 'sha256-{style}'; "
    "img-src data:; base-uri 'none'; form-action 'none'"
)


@dataclass(frozen=True)
class Script:
    """A script of a page. module : whether it is a module, which runs when all else is there."""

    text: str
    module: bool = False


def html_file(
    title: str, style: str, body: Iterable[str], data: Any, scripts: Sequence[Script]
) -> bytes:
    """The file. data : JSON values, which scripts find in the element `data`.

    body : HTML of what is within `body`; text of the user's is escaped by who writes it.
    """
    policy = _POLICY.format(
        scripts=" ".join(f"'sha256-{_digest(each.text)}'" for each in scripts),
        style=_digest(style),
    )
    tags = {False: "<script>", True: '<script type="module">'}
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title>",
        f"<style>{style}</style></head><body>",
        *body,
        f'<script type="application/json" id="data">{_json(data)}</script>',
        *(f"{tags[each.module]}{each.text}</script>" for each in scripts),
    ]
    return "\n".join(parts).encode() + b"</body></html>"


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _json(value: Any) -> str:
    """JSON that is safe within a script element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
