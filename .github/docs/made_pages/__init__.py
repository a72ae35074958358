"""Pages of the documentation that are made from the code, so that they cannot differ from it.

`write_pages` writes them as Markdown before Sphinx reads its sources; files that are as they were
are left alone, so that Sphinx reads only what has changed.
"""

from __future__ import annotations

from pathlib import Path

from made_pages.commands import commands_page
from made_pages.files import formats_page
from made_pages.findings import findings_page
from made_pages.keys import keys_pages
from made_pages.python_names import mathematics_page, names_page
from made_pages.stock import stock_page

__all__ = ["pages", "write_pages"]


def pages() -> dict[str, str]:
    """The text of each page by the name of its file."""
    return {
        "commands.md": commands_page(),
        **keys_pages(),
        "findings.md": findings_page(),
        "formats.md": formats_page(),
        "machines.md": stock_page("machines"),
        "materials.md": stock_page("materials"),
        "fab.md": names_page("fab"),
        "solver.md": names_page("solver"),
        "mathematics.md": mathematics_page(),
    }


def write_pages(folder: Path) -> None:
    """Write all of them, and remove those of an earlier version."""
    folder.mkdir(exist_ok=True)
    texts = pages()
    for old in set(folder.glob("*.md")) - {folder / name for name in texts}:
        old.unlink()
    for name, text in texts.items():
        path = folder / name
        if not path.is_file() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")
