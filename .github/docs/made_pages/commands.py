"""The page of all commands and their options, as the program declares them."""

from __future__ import annotations

import inspect

import click

from fab.cli.group import main
from made_pages.markdown import anchor, cell, docstring, table

__all__ = ["commands_page"]


def commands_page() -> str:
    """Usage, arguments and options of every command."""
    out = [
        "# All commands and options\n",
        "`quadfold COMMAND --help` shows the same at the terminal. What they are for is in "
        "[the guide](../guide/commands.md), with exit codes and how scripts use them.\n",
    ]
    context = click.Context(main, info_name="quadfold")
    for name in sorted(main.commands):
        out += _command(main.commands[name], f"quadfold {name}", context)
    return "\n".join(out)


def _command(command: click.Command, title: str, above: click.Context) -> list[str]:
    context = click.Context(command, info_name=title.split()[-1], parent=above)
    usage = " ".join([title, *command.collect_usage_pieces(context)])
    level = "#" * (len(title.split()))
    out = [
        anchor(title.replace(" ", "-")) + f"{level} {title}\n",
        f"```text\n{usage}\n```\n",
        docstring(inspect.cleandoc(command.help or "")) + "\n",
    ]
    options = [each for each in command.params if isinstance(each, click.Option)]
    if options:
        rows = [_row(option, context) for option in options]
        out.append(table(["option", "", "default"], rows))
    if isinstance(command, click.Group):
        for name in sorted(command.commands):
            out += _command(command.commands[name], f"{title} {name}", context)
    return out


def _row(option: click.Option, context: click.Context) -> list[str]:
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    kind = "" if option.is_flag or option.count else f" {_kind(option, context)}"
    # an option without help or default has nothing to show; an example is part of the help
    default = option.get_default(context, call=False)
    shown = "" if default in (None, False, (), "") or callable(default) else f"`{default}`"
    if "Sentinel" in shown or "UNSET" in shown:
        shown = ""
    return [names + cell(kind), cell(option.help or ""), shown]


def _kind(option: click.Option, context: click.Context) -> str:
    if isinstance(option.type, click.Choice):
        return " or ".join(str(getattr(each, "value", each)) for each in option.type.choices)
    return option.make_metavar(context).lower()
