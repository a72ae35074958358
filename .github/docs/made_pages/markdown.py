"""Markdown: tables, anchors, and docstrings as they are written in the code."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

__all__ = ["anchor", "cell", "docstring", "table"]

_SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
# "width, height : of the sheet", at the beginning of a paragraph
_ENTRY = re.compile(r"^(\**\w+(?:, \**\w+)*) : ")


def anchor(name: str) -> str:
    """A target for links, before a heading."""
    return f"({name})=\n"


def cell(text: str) -> str:
    """Text for one cell of a table."""
    return _plain(" ".join(text.split())).replace("|", "\\|")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; its cells are Markdown already."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def docstring(text: str) -> str:
    """A docstring as Markdown: examples and indented lines as code, entries of lists as a list."""
    text = _SECTION.sub(lambda found: f"\n**{found[1]}**\n\n", text.strip() + "\n")
    return "\n\n".join(_block(block) for block in re.split(r"\n\s*\n", text) if block.strip())


def _block(block: str) -> str:
    if re.fullmatch(r"\s*\*\*[\w ]+\*\*\s*", block):
        return block.strip()
    if block.lstrip().startswith(">>>"):
        return f"```pycon\n{_dedented(block)}\n```"
    lines = block.strip("\n").split("\n")
    if all(line.startswith("    ") for line in lines) or any("|---" in line for line in lines):
        return block if "|---" in block else f"```text\n{_dedented(block)}\n```"
    if any(
        re.match(r"^ {4,}\S", line) and not _continues(lines, i) for i, line in enumerate(lines)
    ):
        return f"```text\n{block}\n```"
    if any(_ENTRY.match(line) for line in lines):
        return _entries(lines)
    return _plain("\n".join(line.strip() for line in lines))


def _continues(lines: Sequence[str], number: int) -> bool:
    """Whether an indented line goes on with the entry of a list above it."""
    return number > 0 and any(_ENTRY.match(line) for line in lines[:number])


def _entries(lines: Sequence[str]) -> str:
    """A list of names with what they are; text before the first one stays a paragraph."""
    out: list[str] = []
    for line in lines:
        found = _ENTRY.match(line)
        if found:
            names = ", ".join(f"`{name}`" for name in found[1].split(", "))
            out.append(f"- {names}: {_plain(line[found.end() :])}")
        elif out and out[-1].startswith("- "):
            out.append(f"  {_plain(line.strip())}")
        else:
            out.append(_plain(line.strip()))
    first = next(i for i, line in enumerate(out) if line.startswith("- "))
    return "\n".join([*out[:first], *([""] if first else []), *out[first:]])


def _plain(text: str) -> str:
    """Text whose own marks mean nothing, but for code between backticks."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<\[\]$])", r"\\\1", part) for part in parts
    )


def _dedented(block: str) -> str:
    lines = block.strip("\n").split("\n")
    least = min(len(line) - len(line.lstrip()) for line in lines if line.strip())
    return "\n".join(line[least:] for line in lines)
