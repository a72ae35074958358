"""The page of all findings, from the table in the code."""

from __future__ import annotations

from fab.findings import FAMILIES
from made_pages.markdown import anchor, cell

__all__ = ["findings_page"]


def findings_page() -> str:
    """Every code, by the stage that reports it: severities, meaning, cause and cure."""
    count = sum(len(family) for family in FAMILIES.values())
    out = [
        "# Findings: what they mean, and what to do\n",
        f"Reports, pages and the terminal name what was found by one of {count} codes, in lines "
        "such as `warning: fold-blocked: panels fold to 64 % of the target ...`.\n\n"
        "- An **error** means that the files should not be used as they are, and makes the exit "
        "code 1.\n"
        "- A **warning** means that something may not be as you want it.\n"
        "- A **note** states what was done.\n\n"
        "The text of each has its numbers and places. `quadfold findings fold-blocked` shows what "
        "is below at the terminal; reports list findings under `findings`.\n",
    ]
    for title, family in FAMILIES.items():
        out.append(f"## {title}\n")
        for each in family:
            severities = " or ".join(each.severities)
            out.append(
                anchor(f"finding-{each.code}") + f"### {each.code}\n\n"
                f"*{severities}.* {cell(each.meaning)}\n\n"
                f"Why\n: {cell(each.cause)}\n\nWhat to do\n: {cell(each.cure)}\n"
            )
    return "\n".join(out)
