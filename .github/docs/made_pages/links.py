"""Links of the site that lead nowhere, and what it would load from elsewhere."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from html import unescape
from pathlib import Path
from urllib.parse import unquote, urlsplit

__all__ = ["broken_links"]

_LINK = re.compile(r"<(\w+)\b[^>]*?\s(href|src)=\"([^\"]*)\"")
_ID = re.compile(r"\bid=\"([^\"]+)\"")


def broken_links(site: Path) -> Iterator[str]:
    """A line for each link to a file or place that is not there, or that would load from afar."""

    @cache
    def ids(path: Path) -> frozenset[str]:
        return frozenset(map(unescape, _ID.findall(path.read_text("utf-8"))))

    for page in sorted(site.rglob("*.html")):
        if page.parent.name == "results":  # complete in themselves
            continue
        for tag, _, link in _LINK.findall(page.read_text("utf-8")):
            parts = urlsplit(unescape(link))
            if parts.scheme or parts.netloc:
                if tag not in ("a", "link") or (tag == "link" and "fonts" in link):
                    yield f"{page.relative_to(site)} loads {link}"
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            if target.is_dir():
                target /= "index.html"
            if not target.is_file():
                yield f"{page.relative_to(site)}: {link} leads nowhere"
            elif (
                parts.fragment
                and target.suffix == ".html"
                and unquote(parts.fragment) not in ids(target)
            ):
                yield f"{page.relative_to(site)}: {link} has no such place"
