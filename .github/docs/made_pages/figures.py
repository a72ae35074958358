"""The page of the paper's figures that can be made, from the table in the code."""

from __future__ import annotations

from fab.jobs.paper_figures import NUMBERING, PAPER_FIGURES
from made_pages.markdown import cell, table

__all__ = ["figures_page"]


def figures_page() -> str:
    """Name and caption of each."""
    rows = [[f"`{each.name}`", cell(each.caption)] for each in PAPER_FIGURES]
    return "\n".join(
        [
            "# List of the paper's figures\n",
            "`quadfold figure S13 M2 --out figures` makes them, `all` all of them in some minutes. "
            "How, and from data of your own: [the guide](../guide/paper_figures.md).\n",
            table(["name", "what it shows"], rows),
            NUMBERING + "\n",
        ]
    )
