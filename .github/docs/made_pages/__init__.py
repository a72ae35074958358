"""Pages of the documentation that are made from the code, so that they cannot differ from it.

`write_pages` writes them as Markdown before Sphinx reads its sources; files that are as they were
are left alone, so that Sphinx reads only what has changed.
"""

from __future__ import annotations

from pathlib import Path

from made_pages.commands import commands_page
from made_pages.figures import figures_page
from made_pages.files import formats_page
from made_pages.findings import findings_page
from made_pages.gallery import gallery_pages, pictures_copied, results_made
from made_pages.keys import keys_pages
from made_pages.limits import limits_page
from made_pages.python_names import mathematics_page, names_page
from made_pages.stock import stock_page

__all__ = ["pages", "write_pages"]


def pages(results: set[str]) -> dict[str, str]:
    """The text of each page by the name of its file.

    results : templates whose result pages are there.
    """
    return {
        "commands.md": commands_page(),
        **keys_pages(),
        "figures.md": figures_page(),
        "findings.md": findings_page(),
        "formats.md": formats_page(),
        "limits.md": limits_page(),
        "machines.md": stock_page("machines"),
        "materials.md": stock_page("materials"),
        "fab.md": names_page("fab"),
        "solver.md": names_page("solver"),
        "mathematics.md": mathematics_page(),
        **gallery_pages(results),
    }


def write_pages(folder: Path) -> None:
    """Write all of them and what they show, and remove those of an earlier version."""
    (folder / "gallery").mkdir(parents=True, exist_ok=True)
    pictures_copied(folder / "gallery_pictures")
    texts = pages(results_made(folder / "extra" / "results"))
    for old in set(folder.glob("**/*.md")) - {folder / name for name in texts}:
        old.unlink()
    for name, text in texts.items():
        path = folder / name
        if not path.is_file() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")
