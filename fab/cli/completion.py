"""Names that a shell completes: shipped jobs beside files, stock, and codes of findings."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click
from click.shell_completion import CompletionItem

__all__ = ["FindingCode", "JobPath", "StockName"]


class JobPath(click.Path):
    """The path of a job, or the name of a shipped one."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from fab.catalogue import shipped

        names = [CompletionItem(name) for name in shipped("jobs") if name.startswith(incomplete)]
        return [*names, *super().shell_complete(ctx, param, incomplete)]


class StockName(click.ParamType[str]):
    """The name of a sheet, print material, cutter or printer that is known, or a path."""

    name = "name"

    def __init__(self, kind: Literal["sheet", "print", "cutter", "printer"]) -> None:
        self.kind = kind

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from fab.catalogue import known_of

        del ctx, param
        return [CompletionItem(name) for name in known_of(self.kind) if name.startswith(incomplete)]


class FindingCode(click.ParamType[str]):
    """The code of a finding, or another word."""

    name = "code"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from fab.findings import explained

        del ctx, param
        return [CompletionItem(code) for code in explained() if code.startswith(incomplete)]
