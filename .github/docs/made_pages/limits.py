"""The page of limits, from the constants of the readers."""

from __future__ import annotations

from fab import settings
from fab.jobs.reading_limits import LIMITS
from fab.studio import app, dropped_files, job_text
from fab.sweeps import axes, variations
from made_pages.markdown import table

__all__ = ["limits_page"]


def limits_page() -> str:
    """What a file may be at most, by the reader."""
    files = [
        [
            ", ".join(f"`{ending}`" for ending in limit.endings),
            f"{limit.largest_bytes / 1e6:,.0f} MB",
            limit.depth,
            limit.count,
            limit.memory,
        ]
        for limit in LIMITS
    ]
    deep = f"{settings.DEEPEST} tables or lists"
    tables = [
        ["jobs, materials, machines", settings.LARGEST_BYTES, deep, ""],
        [
            "sweeps",
            settings.LARGEST_BYTES,
            deep,
            f"{axes.MOST_AXES} axes of {axes.MOST_VALUES:,} values, {variations.MOST:,} variations",
        ],
        ["the text of a job in the studio", job_text.MOST_BYTES, deep, ""],
        ["a message to the studio", app.MOST_MESSAGE, "", f"{app.MOST_CHANGES} changes"],
        ["a file dropped on the studio", dropped_files.MOST_DROPPED, "", "read as the file it is"],
    ]
    return "\n".join(
        [
            "# Limits\n",
            "Files from anywhere are read within bounds, so that a damaged one ends in an error "
            "that names it, and neither fills the memory nor keeps the computer busy. Sizes are "
            "looked at before anything is read, depths and counts before anything is made of what "
            "was read.\n",
            "## Files of other programs\n",
            table(["file", "size", "depth", "parts", "memory and time"], files),
            "\nThe longer side of a sheet is from 0.1 mm to 100 m where something is made of it; "
            "coordinates are up to 1e50 in any file. Libraries in C++ that damaged files make "
            "crash, or keep busy without end, work in a process of their own: what ends it is in "
            "the error.\n",
            "## Files and messages of users\n",
            table(
                ["text", "size", "depth", "parts"],
                [[name, f"{size / 1e6:g} MB", *rest] for name, size, *rest in tables],
            ),
        ]
    )
