"""Options of loads on a folded sheet."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from fab.errors import InvalidJob

if TYPE_CHECKING:
    from fab.folding.fold_settings import FoldSettings

__all__ = ["load_options", "with_loads"]

_OPTIONS = (
    click.option(
        "--fix",
        multiple=True,
        metavar="WHERE",
        help='Hold the folded sheet there, and load it: "left edge", "right edge", "top edge", '
        '"bottom edge", "corners" or "border" of the flat sheet, "lowest" or "highest" of the '
        "folded one, the number of a vertex, or a region of the flat sheet as X,Y,X,Y in mm. An "
        "edge or a vertex that is held may turn, as on a hinge: hold a region to clamp it.",
    ),
    click.option(
        "--weight/--no-weight", default=None, help="Whether its own weight loads it (default: yes)."
    ),
    click.option(
        "--down",
        metavar="X,Y,Z",
        help="Direction of the weight, as pictures show the sheet (default: 0,0,-1).",
    ),
    click.option(
        "--pull",
        multiple=True,
        metavar="WHERE=X,Y,Z",
        help="A force in newtons on vertices, as --fix names them, which share it equally.",
    ),
    click.option(
        "--pressure-pa",
        type=float,
        default=None,
        metavar="PA",
        help="Air pressure on the lower sides of all faces.",
    ),
)

# Of the number of a vertex; Python converts no endless ones.
_MOST_DIGITS = 18


def load_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """A command with the options of loads, which it takes as `loads`: keys of a job."""

    @functools.wraps(command)
    def with_options(
        *arguments: Any,
        fix: tuple[str, ...],
        weight: bool | None,
        down: str | None,
        pull: tuple[str, ...],
        pressure_pa: float | None,
        **others: Any,
    ) -> Any:
        given: dict[str, Any] = {}
        if fix:
            given["fixed"] = [_where("--fix", text) for text in fix]
        if weight is not None:
            given["weight"] = weight
        if down is not None:
            given["down"] = _numbers(f"--down {down}", down, 3)
        if pull:
            given["pulls"] = [_pull(text) for text in pull]
        if pressure_pa is not None:
            given["pressure_pa"] = pressure_pa
        return command(*arguments, loads=given, **others)

    out: Callable[..., Any] = with_options
    for option in reversed(_OPTIONS):
        out = option(out)
    return out


def with_loads(settings: FoldSettings, given: Mapping[str, Any]) -> FoldSettings:
    """Settings with the loads of the options laid over their own.

    Raises `InvalidJob` for options without --fix where the settings hold nothing.
    """
    if not given:
        return settings
    from fab.folding.loads.load_settings import LoadSettings
    from fab.settings import checked

    own = {} if settings.loads is None else settings.loads.model_dump(exclude_unset=True)
    tables = own | dict(given)
    if "fixed" not in tables:
        raise InvalidJob(
            "loads move a sheet that nothing holds: say with --fix where it is held, such as "
            '--fix "left edge".'
        )
    loads = checked(LoadSettings, tables, "loads", "Give --fix, and --weight, --pull or so.")
    return settings.model_copy(update={"loads": loads})


def _where(option: str, text: str) -> str | int | list[float]:
    text = text.strip()
    if text.isdecimal() and len(text) <= _MOST_DIGITS:
        return int(text)
    return _numbers(f"{option} {text}", text, 4) if "," in text else text


def _pull(text: str) -> dict[str, Any]:
    where, equals, force = text.rpartition("=")
    if not equals:
        raise click.UsageError(f"--pull {text}: must have the form WHERE=X,Y,Z, as in 12=0,0,-0.5.")
    return {"at": [_where("--pull", where)], "force_n": _numbers(f"--pull {text}", force, 3)}


def _numbers(option: str, text: str, count: int) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise click.UsageError(f"{option}: must be {count} numbers with commas between them.")
    return numbers
