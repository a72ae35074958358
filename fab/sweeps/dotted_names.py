"""Dotted names, such as those of keys and columns: in full, or by their last parts."""

from __future__ import annotations

from collections.abc import Sequence

from fab.errors import InvalidJob, did_you_mean

__all__ = ["named", "short_names"]


def named(name: str, known: Sequence[str], what: str) -> str:
    """The known name that is meant: whole, or without what is before its last dots.

    what : in the message, such as "column of the table". Raises `InvalidJob` for names that are not
    known, and for those that several have.

    >>> named("mass_g", ["solids.mass_g", "crossings"], "column")
    'solids.mass_g'
    """
    if name in known:
        return name
    ending = [each for each in known if each.endswith(f".{name}")]
    if len(ending) == 1:
        return ending[0]
    if ending:
        raise InvalidJob(f"{name} is one of {', '.join(ending)}: give one of them in full.")
    short = [each.rpartition(".")[2] for each in known]
    raise InvalidJob(f"{name} is no {what}.{did_you_mean(name, [*known, *short])}")


def short_names(names: Sequence[str]) -> dict[str, str]:
    """Each name without what is before its last dots, as far as it differs from the others then.

    >>> short_names(["design.rows", "flat.x_mm", "folded.x_mm"])
    {'design.rows': 'rows', 'flat.x_mm': 'flat.x_mm', 'folded.x_mm': 'folded.x_mm'}
    """
    out = {}
    for name in names:
        parts = name.split(".")
        endings = (".".join(parts[-count:]) for count in range(1, len(parts) + 1))
        others = [other for other in names if other != name]
        out[name] = next(
            (
                ending
                for ending in endings
                if not any(other == ending or other.endswith(f".{ending}") for other in others)
            ),
            name,
        )
    return out
