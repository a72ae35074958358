"""The command about findings: what a code means, what causes it, and what cures it."""

from __future__ import annotations

import click

from fab.cli.completion import FindingCode
from fab.cli.console import answers, say

__all__ = ["findings"]


@click.command()
@click.argument("code", default="", type=FindingCode())
def findings(code: str) -> None:
    """Explain a finding by its CODE: what it means, what causes it, and what cures it.

    Without CODE all findings are listed, one line each; with any other word, those that have it in
    their code or explanation.
    """
    with answers():
        from fab.findings import find

        found = find(code)
        if len(found) == 1:
            (only,) = found
            say(f"{only.code} ({' or '.join(only.severities)})")
            say(f"  {only.meaning}")
            say(f"  why:  {only.cause}")
            say(f"  cure: {only.cure}")
            return
        width = max(len(each.code) for each in found)
        for each in found:
            say(f"{each.code:<{width}}  {'/'.join(each.severities)}: {each.meaning}")
