"""Columns of the table of a sweep: name, type, where in a report its figure is, what it means.

Names end in their units, as the keys of reports do. A sweep has a column for each of its axes too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

__all__ = ["FIGURES", "OUTCOME", "Column", "figures_of"]


@dataclass(frozen=True)
class Column:
    """A column of the table.

    path : keys and places of its figure in the report of a job; () for what is no figure of it. Of
        lists, "#" is their length and "+" the sum of what follows in their entries.
    """

    name: str
    kind: Literal["text", "whole", "number", "truth"]
    text: str
    path: tuple[str | int, ...] = ()


# What became of a variation; the first columns of every table.
OUTCOME = (
    Column("number", "whole", "of the variation, from 0, in the order of the sweep"),
    Column("job_hash", "text", "of its job, of what is measured and of the version"),
    Column("status", "text", "made, refused, failed, too slow, too large or crashed"),
    Column("message", "text", "why it was not made"),
    Column("errors", "text", "codes of its findings that are errors, with spaces between"),
    Column("warnings", "text", "codes of its warnings"),
    Column("seconds", "number", "of a clock, that it took"),
)


def _of(prefix: str, *rows: tuple[str, Literal["text", "whole", "number", "truth"], str]) -> Any:
    return tuple(
        Column(f"{prefix}.{name}" if prefix else name, kind, text, (*_path(prefix), *_path(name)))
        for name, kind, text in rows
    )


def _path(dotted: str) -> tuple[str, ...]:
    return tuple(dotted.split(".")) if dotted else ()


FIGURES: tuple[Column, ...] = (
    *_of(
        "growth",
        ("status", "text", "how growth ended"),
        ("advice", "text", "what would help where it stopped"),
        ("strips", "whole", "that grew"),
        ("coverage", "number", "share of the surface that is under the sheet"),
    ),
    *_of(
        "",
        ("counts.vertices", "whole", "of the pattern"),
        ("counts.faces", "whole", "of the pattern"),
        ("counts.creases.M", "whole", "mountains"),
        ("counts.creases.V", "whole", "valleys"),
        ("planarity_max", "number", "distance of a face from a plane, relative"),
        ("developability_max_rad", "number", "by which angles around a vertex miss a full turn"),
        ("isometry_max_rel", "number", "difference of lengths, flat and folded"),
        ("crossings", "whole", "pairs of faces that pass through each other when folded"),
        ("alike_panels.different", "whole", "different faces, within alike_mm"),
    ),
    Column("flat.x_mm", "number", "extent of the flat sheet", ("bounding_box_mm", "flat", 0)),
    Column("flat.y_mm", "number", "extent of the flat sheet", ("bounding_box_mm", "flat", 1)),
    Column("folded.x_mm", "number", "extent of the folded sheet", ("bounding_box_mm", "folded", 0)),
    Column("folded.y_mm", "number", "extent of the folded sheet", ("bounding_box_mm", "folded", 1)),
    Column("folded.z_mm", "number", "extent of the folded sheet", ("bounding_box_mm", "folded", 2)),
    *_of(
        "rigid",
        ("verdict", "text", "whether it folds with flat faces"),
        ("degrees_of_freedom", "whole", "of a state between"),
    ),
    *_of(
        "simulation",
        ("kind", "text", "what the fold is like"),
        ("reached", "truth", "whether the fold reaches its target"),
        ("rmsd_rel", "number", "distance from the target, of the diagonal"),
        ("angle_error_max_deg", "number", "of a crease at the end"),
        ("strain_max", "number", "at the end"),
        ("peak_strain", "number", "on the way"),
        ("bend_max_mm", "number", "by which faces bend on the way"),
        ("barrier_rel", "number", "energy on the way, of that of folding all creases"),
    ),
    *_of(
        "loads",
        ("sag_mm", "number", "under load"),
        ("outer_strain_max", "number", "under load, of the outer fibre"),
    ),
    *_of(
        "solids",
        ("panels", "whole", "thick panels"),
        ("hinges", "whole", "hinges between them"),
        ("bodies", "whole", "sound solids"),
        ("volume_mm3", "number", "of all bodies"),
        ("mass_g", "number", "where the print material is known"),
        ("overlap_max_mm3", "number", "of two bodies in any state that was checked"),
        ("clearance_min_mm", "number", "least distance of two panels"),
    ),
    Column("sheets.count", "whole", "sheets to cut", ("sheets", "#")),
    Column("sheets.pieces", "whole", "pieces on them, of one copy", ("pieces", "#")),
    Column("sheets.seams", "whole", "seams to glue, of one copy", ("glue_up", "#")),
    Column("sheets.minutes", "number", "of cutting, all sheets", ("sheets", "+", "minutes")),
    Column("sheets.cut_mm", "number", "cut through, all sheets", ("sheets", "+", "cut_mm")),
)


def figures_of(report: Mapping[str, Any], columns: Sequence[Column] = FIGURES) -> dict[str, Any]:
    """The figures of a report by the names of their columns; None where it has none.

    >>> columns = [Column("flat.x_mm", "number", "", ("bounding_box_mm", "flat", 0))]
    >>> figures_of({"bounding_box_mm": {"flat": [200.0, 100.0]}}, columns)
    {'flat.x_mm': 200.0}
    """
    return {column.name: _found(report, column.path) for column in columns}


# What stands in a path for a figure of a whole list.
_OF_LISTS = ("#", "+")


def _found(report: Any, path: Sequence[str | int]) -> Any:
    for place, key in enumerate(path):
        if key in _OF_LISTS:
            if report is None:
                return None
            return len(report) if key == "#" else sum(_found(x, path[place + 1 :]) for x in report)
        if isinstance(key, str):
            report = report.get(key) if isinstance(report, Mapping) else None
        else:
            report = report[key] if report is not None else None
    return report
