"""The command for the user's own settings, and the stock that other commands take from them."""

from __future__ import annotations

from typing import Literal

import click

from fab.cli.console import answers, say

__all__ = ["preferred", "required", "settings"]

Key = Literal["material", "machine", "printer", "print_material"]


@click.group(invoke_without_command=True)
@click.pass_context
def settings(context: click.Context) -> None:
    """Show your settings: the stock that commands take where none is given."""
    if context.invoked_subcommand is not None:
        return
    with answers():
        from fab.preferences import preferences, preferences_file

        found, path = preferences().model_dump(), preferences_file()
        width = max(map(len, found))
        for key, value in found.items():
            say(f"{key:<{width}}  {'-' if value is None else value}")
        say(f"in {path}; materials and machines of your own: in folders beside it")


@settings.command("set")
@click.argument("key")
@click.argument("name")
def set_(key: str, name: str) -> None:
    """Set material, machine, printer or print_material to NAME, or to the path of a .toml file."""
    with answers():
        from pathlib import Path

        from fab.preferences import set_preference

        value = str(Path(name).resolve()) if name.endswith(".toml") else name
        _require_stock(key, value)
        say(f"{key} = {value}, in {set_preference(key, value)}")


@settings.command()
@click.argument("key")
def unset(key: str) -> None:
    """Remove a setting."""
    with answers():
        from fab.preferences import set_preference

        say(f"{key} removed, in {set_preference(key, None)}")


def preferred(key: Key, given: str | None) -> str | None:
    """What is given, or else the setting, which is then told; None where there is neither."""
    if given is not None:
        return given
    from fab.preferences import preferences

    value: str | None = getattr(preferences(), key)
    if value is not None:
        say(f"{key} = {value}, of your settings", error=True)
    return value


def required(key: Literal["material", "machine"], given: str | None) -> str:
    """What is given, or else the setting. Raises `InvalidJob` where there is neither."""
    from fab.errors import InvalidJob

    value = preferred(key, given)
    if value is None:
        raise InvalidJob(
            f"no {key} is given: add --{key} NAME, or set it once for all: `quadfold settings set "
            f"{key} NAME`. List the names: `quadfold shipped {key}s`."
        )
    return value


def _require_stock(key: str, value: str) -> None:
    """Raise `InvalidJob` where there is no such stock; other keys are refused later."""
    from fab.printing.printers import load_print_material, load_printer
    from fab.sheets.materials import load_machine, load_material

    if key == "material":
        load_material(value)
    elif key == "machine":
        load_machine(value)
    elif key == "printer":
        load_printer(value)
    elif key == "print_material":
        load_print_material(value)
