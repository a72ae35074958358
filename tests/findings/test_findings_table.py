"""Every code that the source gives is explained, and every explanation is of such a code."""

import re

import pytest
from click.testing import CliRunner
from finding_codes import Codes
from helpers import ROOT

from fab.cli.group import main
from fab.errors import Severity
from fab.findings import FAMILIES, explained, find
from fab.formats.strictness import FACTS


@pytest.fixture(scope="module")
def codes():
    return Codes.of_folder(ROOT / "fab")


def test_every_code_is_explained_and_the_reverse(codes):
    given = codes.found()
    assert {code: given[code] for code in set(given) - set(explained())} == {}
    assert set(explained()) - set(given) == set()


def test_severities_are_those_of_the_source(codes):
    for code, found in codes.severities().items():
        assert found <= {severity.value for severity in explained()[code].severities}, code


def test_a_code_is_explained_once_and_completely():
    every = [each for family in FAMILIES.values() for each in family]
    assert len(every) == len(explained())
    order = list(Severity)
    for each in every:
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", each.code)
        assert list(each.severities) == sorted(set(each.severities), key=order.index)
        for text in (each.meaning, each.cause, each.cure):
            assert re.fullmatch(r"([A-Z]|--\w|\w+[_.]\w+\b).*\.", text), each  # or with a key
        if len(each.severities) > 1:
            assert re.search(r"\b(note|warning|error)\b", each.meaning + each.cause), each.code


def test_facts_of_readers_are_codes():
    assert set(FACTS) <= set(explained())


def test_no_code_is_overlooked_whatever_way_it_is_given():
    source = """
from fab.errors import Finding

TABLE = {"first": ("of-a-table", 1)}

@dataclass
class Repair:
    code: str
    def finding(self):
        return Finding(self.code, 1, "")

def about(text, code):
    return Finding(code, 1, text)

def given():
    Repair("of-a-field")
    about("", "of-a-parameter")
    about(code="of-a-keyword", text="")
    name = "of-a-name" if text else "of-a-choice"
    Finding(name, 1, "")
    code, cure = "of-a-pair", ""
    Finding(code, 1, cure)

def looped():
    for _, (code, number) in TABLE.items():
        Finding(code, number, "")
    for kind in ("pin", "tape"):
        Finding(f"joint-{kind}", 1, "")
    out = []
    out.append(("of-a-list", 2))
    return [Finding(code, number, "") for code, number in out]
"""
    found = set(Codes({"fab/example.py": source}).found())
    ways = ("table", "field", "parameter", "keyword", "name", "choice", "pair", "list")
    assert found == {f"of-a-{way}" for way in ways} | {"joint-pin", "joint-tape"}
    with pytest.raises(AssertionError, match="where it can be read"):
        Codes({"fab/example.py": "Finding(made_up(), 1, '')"}).found()


def run(*words):
    return CliRunner().invoke(main, ["findings", *words])


def test_a_finding_is_explained_at_the_terminal():
    answer = run("panel-vanishes")
    assert answer.exit_code == 0
    lines = answer.output.splitlines()
    assert lines[0] == "panel-vanishes (warning or error)"
    each = explained()["panel-vanishes"]
    assert [line.strip() for line in lines[1:]] == [
        each.meaning,
        f"why:  {each.cause}",
        f"cure: {each.cure}",
    ]


def test_all_findings_are_listed_and_searched_at_the_terminal():
    listed = [line.split()[0] for line in run().output.splitlines()]
    assert listed == sorted(explained())
    some = [line.split()[0] for line in run("kerf").output.splitlines()]
    assert some == [each.code for each in find("kerf")]
    assert {"no-kerf", "kerf-removed"} < set(some) < set(listed)
    wrong = run("no-kerv")
    assert wrong.exit_code == 2
    assert "Did you mean no-kerf?" in wrong.output
